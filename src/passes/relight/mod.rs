//! Light of flashes inside the clouds: fields of scattered light around flashes, which the deck pass samples (Dobashi et
//! al. 2007).
//!
//! *What it is.* For a flash and the cloud around it, the light that a place scatters into each direction per unit of
//! extinction. The deck pass multiplies it by its own extinction once, so that detail finer than a cell survives and nothing
//! counts twice. *How we compute it.* [`cloud`] samples the drawn layer in coarse cells around the flash, `scattering` finds
//! the light ([`solve`]). *How we store it.* Four numbers a cell (the mean over directions, and how it leans towards
//! east, north and up), divided by what the same source points would give in empty air at that place: the quotient is
//! smooth where the light itself falls with the square of the distance. *How we read it back.* `relight.wgsl` and
//! [`twin`]: the quotient by a linear sampler, times the points' light at the place itself.

pub mod cache;
pub mod cloud;
pub mod emergent;
pub mod patch;
pub mod solve;
pub mod store;
pub mod sum;
pub mod tables;
pub mod twin;

use crate::clouds::CloudKind;
use crate::passes::deck::{FLASH_CAP_M, Layer};
use crate::scattering::relight::Method;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;
use store::{Found, Store};
use sum::Summed;

/// Fields that light a picture at once.
pub const FIELDS: usize = 8;
/// Source points that a field's light falls off from.
pub const POINTS: usize = 12;
/// Cells east and north of a field.
pub const WIDTH: usize = 32;
/// Cells upwards of a field in a texture; one of fewer cells repeats none and is stretched.
pub const HEIGHT: usize = 16;

/// How flashes light the pictures' clouds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Lighting {
    /// Bare points: intensity over distance squared, nothing in between.
    Point,
    /// Direct light scattered once.
    Single,
    /// The published scheme: a table of virtual lights for the piece of cloud around, summed for each channel.
    Basis,
    /// Direct light of the channel, and a table for what is scattered more often.
    Hybrid,
    /// One solve for each channel, its points clustered.
    Solve,
    /// One solve with every point of the channel for itself and a tight tolerance.
    Reference,
}

impl Lighting {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Point, Self::Single, Self::Basis, Self::Hybrid, Self::Solve, Self::Reference];

    /// Its name on wires and in reports.
    pub fn name(self) -> &'static str {
        self.method().name()
    }

    /// What finds the light.
    pub fn method(self) -> Method {
        match self {
            Self::Point => Method::Point,
            Self::Single => Method::Single,
            Self::Basis => Method::Basis,
            Self::Hybrid => Method::Hybrid,
            Self::Solve => Method::Solve,
            Self::Reference => Method::Reference,
        }
    }
}

/// A point of a flash's channel: east, north, height over the tangent plane at the request's ground point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Position, m.
    pub position_m: [f32; 3],
    /// Share of the flash's light.
    pub share: f32,
}

/// Everything that decides a field: equal requests have equal fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Genus of the layer that is lit.
    pub kind: CloudKind,
    /// The layer as it lies around the ground point, as the flash began; without light and flashes. The ground point is the
    /// flash's, or the middle of a patch.
    pub layer: Layer,
    /// Radius of the sphere that stands for the Earth there.
    pub earth_m: f32,
    /// Where the light comes from; the shares sum to 1.
    pub points: Vec<Point>,
    /// How the light is found: never [`Lighting::Point`], which needs no field.
    pub method: Lighting,
    /// The piece of the cloud that has a table, for the methods that need one; else the box follows from the points.
    pub patch: Option<Window>,
}

/// A box of cells around a flash, in the flash's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Lower south-west corner: east, north, and height over the sphere, m.
    pub corner_m: [f32; 3],
    /// Edges of a cell, m.
    pub cell_m: [f32; 3],
    /// Cells east, north and up.
    pub cells: [usize; 3],
}

/// Light that comes out of a cloud's lower or upper face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Emergent {
    /// Middle of the lit part of the face: east and north of the flash's ground point, m.
    pub middle_m: [f32; 2],
    /// Mean square distance from the middle, m^2.
    pub spread_m2: f32,
    /// Luminous flux out of the face over that of the flash.
    pub share: f32,
}

/// Light of one candela of source points in one cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Where it lies.
    pub window: Window,
    /// Quotients, cell by cell, east fastest, then north, then up: mean over directions, and its lean (the light scattered
    /// into direction d is `x + yzw . d`, times what the points give).
    pub quotients: Vec<[f32; 4]>,
    /// The points that the quotients refer to: at most [`POINTS`].
    pub points: Vec<Point>,
    /// Square of the distance below which a point's light no longer rises, m^2.
    pub cap_m2: f32,
    /// What comes out below.
    pub below: Emergent,
    /// What comes out above.
    pub above: Emergent,
    /// What was done in the end (a solve that does not converge falls back).
    pub method: Method,
    /// Whether it stands in for what was asked for, whose table is not there yet.
    pub stand_in: bool,
    /// What a device makes the quotients from, which then are not here.
    pub summed: Option<Arc<Summed>>,
}

/// A point that a field falls off from. Parameters; twin of `LitPoint` in `relight.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LitPoint {
    /// Place: east, north, height over the tangent plane at the eye's ground point, m.
    pub position_m: [f32; 3],
    /// Share of the flash's light.
    pub share: f32,
}

/// A field as it lies around the eye. Parameters; twin of `Lit` in `relight.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Lit {
    /// The field's east in the eye's axes, over the window's width: 1/m.
    pub east_per_m: [f32; 3],
    /// Share of the window at the eye's ground point.
    pub east_origin: f32,
    /// The field's north in the eye's axes, over the window's width: 1/m.
    pub north_per_m: [f32; 3],
    /// Share of the window at the eye's ground point.
    pub north_origin: f32,
    /// The field's up in the eye's axes.
    pub up: [f32; 3],
    /// Width of the window, m.
    pub width_m: f32,
    /// Middle of what comes out below, in the eye's axes.
    pub below_m: [f32; 3],
    /// Luminous intensity of it straight down (a flat face sends the cosine of the angle to it), cd.
    pub below_cd: f32,
    /// Middle of what comes out above, in the eye's axes.
    pub above_m: [f32; 3],
    /// Luminous intensity of it straight up, cd.
    pub above_cd: f32,
    /// Mean squares of the distances from these middles, m^2: below, above.
    pub spread_m2: [f32; 2],
    /// Height of the window's lower face over the sphere, m.
    pub base_m: f32,
    /// 1 over the window's height, 1/m.
    pub inverse_thickness: f32,
    /// Luminous intensity of the flash, cd.
    pub intensity_cd: f32,
    /// Square of the distance below which a point's light no longer rises, m^2.
    pub cap_m2: f32,
    /// Points in use.
    pub points: u32,
    /// Cells upwards; 0 while the field is still being made and its points stand in for it.
    pub levels: u32,
    /// The points.
    pub point: [LitPoint; POINTS],
}

/// The fields of a picture. Parameters; twin of `Lits` in `relight.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Lits {
    /// Fields in use.
    pub fields: u32,
    /// Pads to 16 bytes.
    pub pad0: u32,
    /// Pads to 16 bytes.
    pub pad1: u32,
    /// Pads to 16 bytes.
    pub pad2: u32,
    /// The fields.
    pub lit: [Lit; FIELDS],
}

/// Where a field lies around the eye and how bright it is: what changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// East, north and up of the flash's axes in the eye's axes.
    pub axes: [[f32; 3]; 3],
    /// The flash's ground point in the eye's axes, m.
    pub origin_m: [f32; 3],
    /// Luminous intensity, cd.
    pub intensity_cd: f32,
}

/// A flash that lights a picture by a field.
#[derive(Clone, Debug, PartialEq)]
pub struct LitFlash {
    /// What its field is made from.
    pub request: Arc<Request>,
    /// Where it lies and how bright it is in this picture.
    pub placing: Placing,
}

/// The fields of a picture, ready to be read.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Parameters.
    pub lits: Lits,
    /// The fields in the parameters' order; missing ones are stood in for by their points.
    pub fields: Vec<Option<Arc<Field>>>,
    /// Whether a field is still being made.
    pub provisional: bool,
}

impl Prepared {
    /// The fields of a picture's flashes. `wait`: until all are there; else those of the coming pictures, `ahead`, are begun.
    pub fn new(store: &mut Store, flashes: &[LitFlash], ahead: &[Arc<Request>], wait: bool) -> Self {
        let requests: Vec<_> = flashes.iter().take(FIELDS).map(|flash| flash.request.clone()).collect();
        let (mut fields, mut shares, mut before) = (Vec::new(), Vec::new(), Vec::new());
        let mut provisional = false;
        for (i, found) in store.fields(&requests, wait).into_iter().enumerate() {
            let (field, share) = match found {
                Found::Ready(field) => (field, 1.0),
                // Light adds up: of the two fields each has its share, where there is room for both.
                Found::Turning { from, to, share } if requests.len() + before.len() < FIELDS => {
                    before.push((i, from, 1.0 - share));
                    (Some(to), share)
                }
                Found::Turning { to, .. } => (Some(to), 1.0),
                Found::Pending => {
                    provisional = true;
                    (None, 1.0)
                }
            };
            provisional |= field.as_ref().is_some_and(|field| field.stand_in);
            fields.push(field);
            shares.push(share);
        }
        provisional |= !before.is_empty();
        if !wait {
            ahead.iter().for_each(|request| store.prepare(request));
        }
        let mut lits = Lits::zeroed();
        let placed = |i: usize, field: Option<&Arc<Field>>, share: f32| {
            let flash = &flashes[i];
            let placing = Placing { intensity_cd: flash.placing.intensity_cd * share, ..flash.placing };
            field.map_or_else(|| stand_in(flash), |field| field.placed(&placing))
        };
        let own = fields.iter().zip(shares).enumerate().map(|(i, (field, share))| placed(i, field.as_ref(), share));
        let leaving = before.iter().map(|(i, field, share)| placed(*i, Some(field), *share));
        for (slot, lit) in lits.lit.iter_mut().zip(own.chain(leaving)) {
            *slot = lit;
            lits.fields += 1;
        }
        fields.extend(before.into_iter().map(|(_, field, _)| Some(field)));
        Self { lits, fields, provisional }
    }
}

/// A flash's points as bare lights, for while there is no field: deck paper eq. 21, the distance capped.
fn stand_in(flash: &LitFlash) -> Lit {
    let window = cloud::window(&flash.request);
    let points = solve::few(&flash.request.points, window.cell_m[0]).0;
    let bare = Field {
        window,
        quotients: Vec::new(),
        points,
        cap_m2: FLASH_CAP_M * FLASH_CAP_M,
        below: Emergent::default(),
        above: Emergent::default(),
        method: Method::Point,
        stand_in: true,
        summed: None,
    };
    Lit { levels: 0, ..bare.placed(&flash.placing) }
}

impl Field {
    /// The field as a picture's shaders read it.
    pub fn placed(&self, placing: &Placing) -> Lit {
        let [east, north, up] = placing.axes;
        let at = |[x, y, z]: [f32; 3]| -> [f32; 3] {
            std::array::from_fn(|k| placing.origin_m[k] + x * east[k] + y * north[k] + z * up[k])
        };
        let window = &self.window;
        let width_m = window.cell_m[0] * window.cells[0] as f32;
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let origin = |axis: [f32; 3], corner: f32| (-dot(axis, placing.origin_m) - corner) / width_m;
        let height_m = window.cell_m[2] * window.cells[2] as f32;
        // Over the sphere the window's faces are level; over the tangent plane they fall by little.
        let face = |e: &Emergent, height: f32| at([e.middle_m[0], e.middle_m[1], height]);
        // 4 pi steradians of one candela, out of a face that sends the cosine: over pi.
        let straight = |e: &Emergent| 4.0 * placing.intensity_cd * e.share;
        let mut point = [LitPoint::default(); POINTS];
        for (out, p) in point.iter_mut().zip(&self.points) {
            *out = LitPoint { position_m: at(p.position_m), share: p.share };
        }
        Lit {
            east_per_m: east.map(|v| v / width_m),
            east_origin: origin(east, window.corner_m[0]),
            north_per_m: north.map(|v| v / width_m),
            north_origin: origin(north, window.corner_m[1]),
            up,
            width_m,
            below_m: face(&self.below, window.corner_m[2]),
            below_cd: straight(&self.below),
            above_m: face(&self.above, window.corner_m[2] + height_m),
            above_cd: straight(&self.above),
            spread_m2: [self.below.spread_m2, self.above.spread_m2],
            base_m: window.corner_m[2],
            inverse_thickness: 1.0 / height_m,
            intensity_cd: placing.intensity_cd,
            cap_m2: self.cap_m2,
            points: self.points.len() as u32,
            levels: window.cells[2] as u32,
            point,
        }
    }
}

#[cfg(test)]
mod tests;
