//! Twin of `shadow.wgsl`: the share of the light that a layer lets through to a point of the ground.

use super::table::{LAYERS, LEVELS, TEXEL_M, THETAS, Table, sample};
use super::{DISC_RAD, Shadow};
use crate::clouds::modulation;
use crate::passes::common::{Camera, chart_weights, stereographic};
use crate::passes::deck::Layer;
use crate::passes::deck::field::region_shift;
use crate::passes::sampling::map_repeat;
use glam::{Vec2, Vec3};

/// One layer's shadow ready to be asked.
pub struct Caster<'a> {
    /// The layer.
    pub layer: &'a Layer,
    /// How its tables are read.
    pub shadow: Shadow,
    /// One table a chart in use.
    pub tables: Vec<&'a Table>,
    /// The 2D modulation map.
    pub map: &'a [u8],
}

/// Share of the light that comes through all layers to the ground at range `t_m` along a ray of the picture, 0 to 1.
/// `terrain`: the ground may stand at a height over the sphere.
pub fn through_all(casters: &[Caster], camera: &Camera, direction: Vec3, t_m: f32, terrain: bool) -> f32 {
    let height_m = if terrain { camera.height_at(direction.z, t_m) } else { 0.0 };
    let p = direction * t_m + Vec3::new(0.0, 0.0, camera.eye_m);
    let pixel = 2.0 * Vec3::from(camera.up).length() / camera.height_px;
    let normal = (p + Vec3::new(0.0, 0.0, camera.earth_m)).normalize();
    // A pixel's footprint is longer than wide: the mean of both, by their product.
    let footprint_m = t_m * pixel / (-direction.dot(normal)).max(1e-3).sqrt();
    casters.iter().map(|caster| caster.through_at(camera.earth_m, p, height_m, footprint_m)).product()
}

impl Caster<'_> {
    /// Share of the light that comes through the layer to a point of the ground (east, north, height over the tangent plane),
    /// as a mean over a footprint; 1 where the ground is turned away from the light or stands above the layer's middle.
    pub fn through(&self, earth_m: f32, p: Vec3, footprint_m: f32) -> f32 {
        self.through_at(earth_m, p, 0.0, footprint_m)
    }

    /// The same for a point at a height over the sphere, from which the tables begin.
    pub fn through_at(&self, earth_m: f32, p: Vec3, height_m: f32, footprint_m: f32) -> f32 {
        let light = Vec3::from(self.layer.light_direction);
        let b = (p + Vec3::new(0.0, 0.0, earth_m)).dot(light);
        // Nor has ground above the layer's middle any of its shadow.
        if b <= 0.0 || height_m >= self.shadow.height_m {
            return 1.0;
        }
        // Along the light to the layer's middle.
        let c = (self.shadow.height_m - height_m) * (2.0 * earth_m + self.shadow.height_m + height_m);
        let distance_m = c / (b + (b * b + c).sqrt());
        let q = p + light * distance_m;
        let radius = earth_m + self.shadow.height_m;
        let z = stereographic(q, earth_m, radius);
        let shift = region_shift(self.layer, z);
        if shift >= 1.0 {
            return 1.0;
        }
        let blur_m = (distance_m * DISC_RAD).hypot(footprint_m);
        let level = (blur_m * (1.0 / TEXEL_M)).max(1.0).log2().min((LEVELS - 1) as f32);
        let weights = chart_weights(&self.layer.chart, self.layer.charts, q + Vec3::new(0.0, 0.0, earth_m), radius);
        let mut through = 0.0;
        for ((chart, weight), table) in self.layer.chart.iter().zip(weights).zip(&self.tables) {
            if weight > 0.0 {
                let moved = chart.displacement(z);
                let tile = chart.tile(moved);
                let place = Vec2::from(chart.map_origin) + modulation::coordinates(moved);
                let above = map_repeat(self.map, modulation::WIDTH, place.x, place.y);
                let theta = self.layer.theta + self.layer.patchiness * above + shift;
                through += weight * self.column(table, tile, theta, level);
            }
        }
        through
    }

    /// A table's transmittance between the two entries around a theta.
    fn column(&self, table: &Table, tile: Vec2, theta: f32, level: f32) -> f32 {
        let entry = ((theta - self.shadow.theta_low) * self.shadow.inverse_step).clamp(0.0, (THETAS - 1) as f32);
        let layer = ((entry * (1.0 / 3.0)) as usize).min(LAYERS - 1);
        let found = sample(table, tile.x, tile.y, layer, level);
        let at = entry - (3 * layer) as f32;
        (0..4).map(|k| found[k] * (1.0 - (at - k as f32).abs()).max(0.0)).sum()
    }
}
