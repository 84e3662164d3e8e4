//! The published scheme's sum as a device makes it: coefficients of the lights that stand for a bolt's points, their weights, and what
//! turns the summed fields into quotients. `sum.wgsl` does it on the device; the twin is [`Summed::quotients`].
//!
//! It is for fields of [`Method::Basis`](crate::scattering::relight::Method::Basis) alone. Those of the hybrid method pass the summed light
//! through the cloud once more, which is the solver's and the processor's work, and all others have no table.

use super::emergent::emergent;
use super::solve::{few, lean_kept, mean_in_air};
use super::{Emergent, Field, Request, Window};
use crate::numeric::haar::Haar;
use crate::numeric::sphere::DirectionSet;
use crate::scattering::ordinates::PointSource;
use crate::scattering::relight::{Method, Table, weights};
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// Longest axis of a box that a device sums: what one invocation holds of a line.
pub const LONGEST: usize = 64;
/// Most coefficients of one sum: 64 MiB of each of its two lists, half of what software adapters bind.
const MOST: usize = 16 << 20;

/// What a sum begins with. Parameters; twin of `SumHead` in `sum.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SumHead {
    /// Cells east, north and up.
    pub cells: [u32; 3],
    /// Components of a light.
    pub components: u32,
    /// Lights.
    pub lights: u32,
    /// Levels of the transform.
    pub levels: u32,
    /// Level of the texture at which the field begins.
    pub slot: u32,
    /// Pads to 16 bytes.
    pub pad0: u32,
}

/// The coefficients of one component of one light. Parameters; twin of `SumPart` in `sum.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SumPart {
    /// The first of them.
    pub first: u32,
    /// How many.
    pub count: u32,
    /// What they are multiplied by.
    pub weight: f32,
    /// Pads to 16 bytes.
    pub pad0: u32,
}

/// A sum that a device is to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Summed {
    /// What it begins with.
    pub head: SumHead,
    /// Light after light, component after component.
    pub parts: Vec<SumPart>,
    /// Places of the coefficients.
    pub places: Vec<u32>,
    /// The coefficients, before their weight.
    pub values: Vec<f32>,
    /// Of each component (direction) its share in the mean, and in three times the mean of directions.
    pub shares: Vec<[f32; 4]>,
    /// What the field's points would give in empty air, cell by cell, 1/m^2.
    pub in_air: Vec<f32>,
}

/// The field of points by a table of the published scheme, left to a device to sum; `None` where it is too large for one.
pub fn field(
    request: &Request,
    window: Window,
    set: &DirectionSet,
    table: &dyn Table,
    sources: &[PointSource],
) -> Option<Field> {
    let components = table.recipe().components();
    if window.cells.iter().any(|n| *n > LONGEST) || components != set.len() || table.recipe().medium.periodic {
        return None;
    }
    let (mut parts, mut places, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let weights = weights(table.recipe(), sources).0;
    for (light, weight) in &weights {
        let block = table.block(*light)?;
        let mut first = places.len() as u32;
        for (count, scale) in block.counts.iter().zip(block.unit_scales()) {
            parts.push(SumPart { first, count: *count, weight: *weight as f32 * scale, pad0: 0 });
            first += count;
        }
        places.extend(block.places());
        values.extend(block.unit_values());
        if places.len() > MOST {
            return None;
        }
    }
    let share = |(direction, weight): (&[f64; 3], &f64)| {
        let share = (weight / (4.0 * PI)) as f32;
        let [x, y, z] = direction.map(|c| 3.0 * share * c as f32);
        [share, x, y, z]
    };
    let (points, cap_m2) = few(&request.points, 0.45 * window.cell_m[0]);
    let cells: usize = window.cells.iter().product();
    let in_air = (0..cells).into_par_iter().map(|i| mean_in_air(&window, &points, cap_m2, i)).collect();
    let levels = window.cells.iter().map(|n| n.next_power_of_two().trailing_zeros()).max().unwrap_or(0);
    let head = SumHead {
        cells: window.cells.map(|n| n as u32),
        components: components as u32,
        lights: weights.len() as u32,
        levels,
        ..SumHead::default()
    };
    let shares = set.directions.iter().zip(&set.weights).map(share).collect();
    let summed = Summed { head, parts, places, values, shares, in_air };
    let [below, above] = summed.faces(&window);
    let (quotients, method) = (Vec::new(), Method::Basis);
    Some(Field {
        window,
        quotients,
        points,
        cap_m2,
        below,
        above,
        method,
        stand_in: false,
        summed: Some(Arc::new(summed)),
    })
}

impl Summed {
    fn haar(&self) -> Haar {
        Haar::new(self.head.cells.map(|n| n as usize))
    }

    /// Adds a component's coefficients, weighted once more.
    fn add(&self, component: usize, weight: f32, out: &mut [f32]) {
        for part in self.parts.iter().skip(component).step_by(self.head.components as usize) {
            let range = part.first as usize..(part.first + part.count) as usize;
            for (place, value) in self.places[range.clone()].iter().zip(&self.values[range]) {
                out[*place as usize] += weight * part.weight * value;
            }
        }
    }

    /// What comes out of the lower and the upper face. The flux of all directions is one field, so it is summed as one, and here.
    fn faces(&self, window: &Window) -> [Emergent; 2] {
        let mut flux = vec![0.0; self.in_air.len()];
        for (component, [_, _, _, up]) in self.shares.iter().enumerate() {
            self.add(component, *up, &mut flux);
        }
        self.haar().inverse(&mut flux, &mut Vec::new());
        let plane = window.cells[0] * window.cells[1];
        let top = flux.len() - plane;
        let face = |from: usize, sign: f32| {
            let out: Vec<f32> = flux[from..][..plane].iter().map(|up| sign * up * super::solve::to_flux()).collect();
            emergent(window, &out)
        };
        [face(0, -1.0), face(top, 1.0)]
    }

    /// Twin of `sum.wgsl`: the quotients.
    pub fn quotients(&self) -> Vec<[f32; 4]> {
        let (haar, cells) = (self.haar(), self.in_air.len());
        let mut moments = vec![[0.0_f32; 4]; cells];
        let (mut field, mut scratch) = (vec![0.0; cells], Vec::new());
        for (component, shares) in self.shares.iter().enumerate() {
            field.fill(0.0);
            self.add(component, 1.0, &mut field);
            haar.inverse(&mut field, &mut scratch);
            for (moments, light) in moments.iter_mut().zip(&field) {
                (0..4).for_each(|k| moments[k] += shares[k] * light.max(0.0));
            }
        }
        moments.iter().zip(&self.in_air).map(|(moments, in_air)| lean_kept(*moments, *in_air)).collect()
    }
}
