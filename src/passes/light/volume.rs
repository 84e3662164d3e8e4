//! The light of one layer in one chart: the volumes of its thetas, blended between directions, one above the other.

use super::encoding::Encoding;
use super::grid::SHARES;
use super::{HEIGHT, Light, WIDTH, library};
use crate::clouds::CloudKind;
use crate::clouds::density::DensityVolume;
use glam::Vec4;
use half::f16;
use rayon::prelude::*;

/// Voxels of one theta.
pub const VOXELS: usize = WIDTH * WIDTH * HEIGHT;

/// Stored texels, x fastest, then y, then z upwards, then theta.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Four bytes each, 0 to 1.
    Bytes(Vec<[u8; 4]>),
    /// Four f16 each.
    Half(Vec<[f16; 4]>),
}

/// A light volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Thetas.
    pub nodes: u32,
    /// What they hold.
    pub texels: Texels,
}

impl Volume {
    /// The volume of a genus. Nodes that nobody has made yet are made at once, over all cores.
    pub fn of(kind: CloudKind, light: &Light) -> Self {
        let (nodes, shape) = (light.nodes.count, DensityVolume::of(kind));
        let used: Vec<_> = light.corners.iter().filter(|c| c.weight > 0).collect();
        let wanted: Vec<_> = (0..nodes).flat_map(|k| used.iter().map(move |c| (k, c.at))).collect();
        let made: Vec<_> = wanted.par_iter().map(|(k, at)| library::node(&shape, kind, light, *k, *at)).collect();
        let weights: Vec<f32> = used.iter().map(|c| c.weight as f32 / SHARES as f32).collect();
        let mut texels = if light.encoding.in_bytes() {
            Texels::Bytes(vec![[0; 4]; VOXELS * nodes as usize])
        } else {
            Texels::Half(vec![[f16::ZERO; 4]; VOXELS * nodes as usize])
        };
        let parts = made.chunks_exact(used.len());
        match &mut texels {
            Texels::Bytes(all) => all.par_chunks_mut(VOXELS).zip(parts.collect::<Vec<_>>()).for_each(|(out, parts)| {
                let parts: Vec<&[[u8; 4]]> = parts.iter().map(|p| bytes(p)).collect();
                blend(out, &parts, &weights, |v| f32::from(*v), |v| (v + 0.5) as u8);
            }),
            Texels::Half(all) => all.par_chunks_mut(VOXELS).zip(parts.collect::<Vec<_>>()).for_each(|(out, parts)| {
                let parts: Vec<&[[f16; 4]]> = parts.iter().map(|p| halves(p)).collect();
                blend(out, &parts, &weights, |v| f32::from(*v), f16::from_f32);
            }),
        }
        library::ahead(&shape, kind, light);
        Self { nodes, texels }
    }

    /// Memory of its texels.
    pub fn size_bytes(&self) -> usize {
        match &self.texels {
            Texels::Bytes(texels) => size_of_val(texels.as_slice()),
            Texels::Half(texels) => size_of_val(texels.as_slice()),
        }
    }

    /// Stored values at a place of the tile (periods), a share of the layer's height, and a theta in nodes from the first:
    /// trilinear, repeating east and north, clamped upwards; between two thetas.
    pub fn sample(&self, [u, v]: [f32; 2], share: f32, node: f32) -> Vec4 {
        let node = node.clamp(0.0, (self.nodes - 1) as f32);
        let low = node as usize;
        let at = |k: usize| self.trilinear(u, v, share, k);
        let found = at(low);
        if node == low as f32 { found } else { found + (at(low + 1) - found) * (node - low as f32) }
    }

    fn trilinear(&self, u: f32, v: f32, share: f32, node: usize) -> Vec4 {
        let split = |at: f32| (at.floor() as i32, at - at.floor());
        let (x, fx) = split(u * WIDTH as f32 - 0.5);
        let (y, fy) = split(v * WIDTH as f32 - 0.5);
        let (z, fz) = split((share * HEIGHT as f32 - 0.5).clamp(0.0, (HEIGHT - 1) as f32));
        let column = |dx: i32, dy: i32| {
            let mask = WIDTH as i32 - 1;
            ((x + dx) & mask) as usize + ((y + dy) & mask) as usize * WIDTH
        };
        let level = |dz: i32| (node * HEIGHT + (z + dz).min(HEIGHT as i32 - 1) as usize) * WIDTH * WIDTH;
        let mix = |a: Vec4, b: Vec4, share: f32| a + (b - a) * share;
        let face = |dz: i32| {
            let at = |dx: i32, dy: i32| self.texel(column(dx, dy) + level(dz));
            mix(mix(at(0, 0), at(1, 0), fx), mix(at(0, 1), at(1, 1), fx), fy)
        };
        mix(face(0), face(1), fz)
    }

    fn texel(&self, i: usize) -> Vec4 {
        match &self.texels {
            Texels::Bytes(texels) => Vec4::from(texels[i].map(f32::from)) * (1.0 / 255.0),
            Texels::Half(texels) => Vec4::from(texels[i].map(f32::from)),
        }
    }
}

/// Values rounded as an encoding stores them.
pub fn stored(encoding: Encoding, values: impl Iterator<Item = [f32; 4]>) -> Texels {
    if encoding.in_bytes() {
        Texels::Bytes(values.map(|texel| texel.map(|v| (v * 255.0 + 0.5) as u8)).collect())
    } else {
        Texels::Half(values.map(|texel| texel.map(f16::from_f32)).collect())
    }
}

fn bytes(texels: &Texels) -> &[[u8; 4]] {
    if let Texels::Bytes(texels) = texels { texels } else { &[] }
}

fn halves(texels: &Texels) -> &[[f16; 4]] {
    if let Texels::Half(texels) = texels { texels } else { &[] }
}

/// Weighted sums of texels, in one order.
fn blend<T: Copy>(
    out: &mut [[T; 4]],
    parts: &[&[[T; 4]]],
    weights: &[f32],
    read: impl Fn(&T) -> f32,
    round: impl Fn(f32) -> T,
) {
    if let [only] = parts {
        out.copy_from_slice(only);
        return;
    }
    for (i, texel) in out.iter_mut().enumerate() {
        let mut sum = [0.0f32; 4];
        for (part, weight) in parts.iter().zip(weights) {
            for (sum, value) in sum.iter_mut().zip(&part[i]) {
                *sum += weight * read(value);
            }
        }
        *texel = sum.map(&round);
    }
}
