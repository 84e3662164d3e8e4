//! How much light there is: from sun, moon and sky, through the layers from the top down, and the exposure it asks for.

use super::PassNote;
use super::eye::Eye;
use crate::passes::common::{AIR_SCALE_M, Camera};
use crate::passes::deck::{FLASHES, Flash};
use crate::passes::ground::Ground;
use crate::passes::sky::Sky;
use crate::passes::sky::atmosphere::{Air, Luminary, MOON_LUX, SUN_LUX};
use crate::passes::sky::table::TableParams;
use crate::world::command::{Exposure, Frustum};
use crate::world::regions::weight_at;
use crate::world::snapshot::{FlashState, LayerState, Snapshot, ViewState};
use glam::{DQuat, Vec3};

/// Angular radius of the sun and, nearly, of the moon.
const DISC_RAD: f32 = 0.004_65;
/// Contrast of 5 % at the visibility: extinction is -ln(0.05) over it (WMO-No. 8, meteorological optical range).
const VISIBILITY_DEPTH: f64 = 2.996;

/// Share of a flash's light that the exposure answers to: a whole answer would turn the night black around it, none
/// would leave a white picture without shape.
const FLASH_METERED: f32 = 0.3;

/// Light at one height: on a plane facing the source, and on a horizontal plane from all the rest.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Lux per colour, facing the source.
    pub direct_lux: Vec3,
    /// Lux per colour, horizontal.
    pub diffuse_lux: Vec3,
}

/// The light of a moment around the eye.
pub struct Illuminance {
    /// The table of scattered light.
    pub table: TableParams,
    /// The brighter of sun and moon, as a direction (east, north, up).
    pub source: Vec3,
    /// Light above each global layer, by its index.
    pub above_layer: Vec<Level>,
    /// Light above all layers.
    pub top: Level,
    /// Light at the ground.
    pub ground: Level,
    /// Factor from cd/m2 to tone-mapped values.
    pub exposure: f32,
    air: Air,
    lights: [Luminary; 2],
    night: f32,
}

impl Illuminance {
    /// The light of a snapshot at an eye.
    pub fn new(snapshot: &Snapshot, eye: &Eye, view: &ViewState) -> Self {
        let sun = eye.direction(snapshot.sky.sun_direction_ecef);
        let moon = eye.direction(snapshot.sky.moon_direction_ecef);
        let haze = VISIBILITY_DEPTH / visibility_m(snapshot).max(1.0) - 1.2e-5;
        let air = Air { haze_per_m: haze.max(1e-7) as f32 };
        let lights = [
            Luminary {
                direction: sun,
                illuminance_lux: if snapshot.sky.sun_shines && sun.z > -0.31 {
                    Vec3::splat(SUN_LUX)
                } else {
                    Vec3::ZERO
                },
            },
            Luminary {
                direction: moon,
                illuminance_lux: if snapshot.sky.moon_shines {
                    moonlight(snapshot.sky.moon_lit_fraction, sun.z, moon.z)
                } else {
                    Vec3::ZERO
                },
            },
        ];
        // Airglow and starlight: 2e-4 cd/m2 at a dark site (Leinert et al. 1998, table 2), doubled for a peopled one. A
        // quarter of it, chosen here, stands for the stars, which are not drawn one by one and can be taken away.
        let night_luminance = 4e-4 * (0.75 + 0.25 * snapshot.sky.starlight as f32);
        let key = lights
            .iter()
            .max_by(|a, b| {
                let lux = |l: &Luminary| (air.transmittance(3_000.0, l.direction.z) * l.illuminance_lux).y;
                lux(a).total_cmp(&lux(b))
            })
            .copied()
            .unwrap_or(lights[0]);
        let level = |height_m: f32| Level {
            direct_lux: air.transmittance(height_m, key.direction.z) * key.illuminance_lux,
            diffuse_lux: skylight(&air, height_m, &lights) + Vec3::splat(std::f32::consts::PI * night_luminance),
        };
        let layers = &snapshot.weather.layers;
        let top_m = layers.last().map_or(0.0, |l| l.base_m + l.thickness_m) as f32;
        let (top, clear) = (level(top_m.max(1_000.0)), level(0.0));
        let mu = key.direction.z.max(0.02);
        let mut now = top;
        let mut at_eye = level(eye.height_m as f32);
        let mut above_layer = vec![top; layers.len()];
        for (i, layer) in layers.iter().enumerate().rev() {
            above_layer[i] = now;
            let through = pass(layer, now, mu);
            let share = ((eye.height_m - layer.base_m) / layer.thickness_m).clamp(0.0, 1.0) as f32;
            at_eye = pass_share(at_eye, now, through, 1.0 - share);
            now = through;
        }
        // The air below the layers takes its part too.
        let lower = |above: Vec3, clear: Vec3, top: Vec3| above * (clear / top.max(Vec3::splat(1e-9))).min(Vec3::ONE);
        let ground = Level {
            direct_lux: lower(now.direct_lux, clear.direct_lux, top.direct_lux),
            diffuse_lux: lower(now.diffuse_lux, clear.diffuse_lux.max(0.9 * top.diffuse_lux), top.diffuse_lux),
        };
        let ev = match view.exposure {
            Exposure::Ev100(ev) => ev as f32,
            Exposure::Automatic => {
                let steady_lux = at_eye.direct_lux.y * (0.2 + 0.8 * mu) + at_eye.diffuse_lux.y;
                automatic_ev(steady_lux + FLASH_METERED * flash_lux(snapshot, eye))
            }
        };
        let height_m = quantised(eye.height_m as f32);
        let scale = (1.2 * ev.exp2()).log2().round().exp2();
        let table = TableParams {
            eye_m: height_m,
            horizon: horizon(eye.earth_m as f32, height_m),
            haze_per_m: air.haze_per_m,
            lights: lights.map(|l| Luminary { direction: quantised_direction(l.direction), ..l }),
            night_luminance,
            scale,
        };
        let night = 1.0 - crate::passes::common::smoothstep(-0.14, -0.03, sun.z);
        // Full scale at 1.2 * 2^EV cd/m2 (ISO 2720 with K = 12.5 and saturation-based speed).
        let exposure = 1.0 / (1.2 * ev.exp2());
        Self { table, source: key.direction, above_layer, top, ground, exposure, air, lights, night }
    }

    /// The camera of a view.
    pub fn camera(&self, eye: &Eye, view: &ViewState) -> Camera {
        let [width, height] = view.size_px.map(|n| n as f32);
        let [right, up, axis] = eye.axes;
        // Tangents of the picture's sides, as half-widths around a middle, which is off the axis for a lopsided frustum.
        let ([across, aside], [along, above]) = match view.frustum {
            None => {
                let tangent = (0.5 * view.field_of_view_deg.to_radians()).tan() as f32;
                ([tangent, 0.0], [tangent * height / width, 0.0])
            }
            Some(Frustum { left_deg, right_deg, top_deg, bottom_deg }) => {
                let half = |low: f64, high: f64| {
                    let [low, high] = [low, high].map(|side_deg| side_deg.to_radians().tan());
                    [0.5 * (high - low), 0.5 * (high + low)].map(|tangent| tangent as f32)
                };
                (half(left_deg, right_deg), half(bottom_deg, top_deg))
            }
        };
        let forward = axis + right * aside + up * above;
        let [flip_x, flip_y] = view.mirror.map(|mirrored| if mirrored { -1.0 } else { 1.0 });
        Camera {
            right: (right * (across * flip_x)).into(),
            width_px: width,
            up: (up * (along * flip_y)).into(),
            height_px: height,
            forward: forward.into(),
            eye_m: eye.height_m as f32,
            earth_m: eye.earth_m as f32,
            exposure: self.exposure,
            haze_per_m: self.air.haze_per_m,
            air_per_m: 1.2e-5,
        }
    }

    /// Sky, sun and moon.
    pub fn sky(&self, eye: &Eye) -> Sky {
        let disc = |l: &Luminary, share: f32| {
            let seen = self.air.transmittance(eye.height_m as f32, l.direction.z) * l.illuminance_lux;
            seen * (share / (std::f32::consts::PI * DISC_RAD * DISC_RAD))
        };
        let [sun, moon] = &self.lights;
        Sky {
            sun_direction: sun.direction.into(),
            sun_cosine: DISC_RAD.cos(),
            sun_luminance: disc(sun, 1.0).into(),
            horizon: self.table.horizon,
            moon_direction: moon.direction.into(),
            moon_cosine: DISC_RAD.cos(),
            moon_luminance: disc(moon, 1.0).into(),
            table_scale: self.table.scale,
        }
    }

    /// The ground, if it is in sight.
    pub fn ground(&self, eye: &Eye, flashes: &[Flash], notes: &mut Vec<PassNote>) -> Option<Ground> {
        notes.push(PassNote { pass: "ground", kept: true, why: "the ground is below the eye".into() });
        let (near, chart) = eye.charts(DQuat::IDENTITY, super::layers::extent_m(eye, 0.0), 1.0);
        let mut flash = [Flash::default(); FLASHES];
        flash[..flashes.len()].copy_from_slice(flashes);
        Some(Ground {
            light_lux: self.ground.direct_lux.into(),
            flashes: flashes.len() as u32,
            light_direction: self.source.into(),
            city_luminance: 6.0 * self.night,
            sky_lux: self.ground.diffuse_lux.into(),
            charts: near.len() as u32,
            chart,
            flash,
        })
    }

    /// Light that comes up from the ground, over 4 pi, lux per colour.
    pub fn upwelling_lux(&self) -> Vec3 {
        let ground = self.ground.direct_lux * self.source.z.max(0.0) + self.ground.diffuse_lux;
        (ground * 0.13 + Vec3::new(1.0, 0.72, 0.42) * (0.08 * self.night)) * (2.0 * 0.079_577_47)
    }
}

/// Visibility at the ownship: the regions' where it is inside them, between the two by its logarithm in a transition.
fn visibility_m(snapshot: &Snapshot) -> f64 {
    snapshot.regions.iter().fold(snapshot.weather.visibility_m, |around, region| {
        let share = region.presence * weight_at(&region.shape, &snapshot.ownship.position);
        if share > 0.0 { around.powf(1.0 - share) * region.weather.visibility_m.powf(share) } else { around }
    })
}

/// Illuminance outside the air by the moon's phase (Allen 1973: m = -12.73 + 0.026 a + 4e-9 a^4, a in degrees); none
/// while it is down or the sun outshines it.
fn moonlight(lit_fraction: f64, sun_up: f32, moon_up: f32) -> Vec3 {
    if sun_up > -0.05 || moon_up < -0.03 {
        return Vec3::ZERO;
    }
    let phase_deg = (2.0 * lit_fraction - 1.0).clamp(-1.0, 1.0).acos().to_degrees();
    let magnitudes = 0.026 * phase_deg + 4e-9 * phase_deg.powi(4);
    Vec3::splat(MOON_LUX * 10f64.powf(-0.4 * magnitudes) as f32)
}

/// Illuminance of a horizontal plane by the sky at a height, lux per colour: six elevations by eight azimuths.
fn skylight(air: &Air, height_m: f32, lights: &[Luminary; 2]) -> Vec3 {
    let (rows, columns) = (6, 8);
    let mut sum = Vec3::ZERO;
    for row in 0..rows {
        // Equal shares of cos(zenith angle)^2, so that every direction weighs the same.
        let up = ((row as f32 + 0.5) / rows as f32).sqrt();
        let flat = (1.0 - up * up).sqrt();
        for column in 0..columns {
            let azimuth = (column as f32 + 0.5 * (row % 2) as f32) / columns as f32 * std::f32::consts::TAU;
            let direction = Vec3::new(azimuth.cos() * flat, azimuth.sin() * flat, up);
            sum += air.inscatter(height_m, direction, lights, 12).0;
        }
    }
    sum * (std::f32::consts::PI / (rows * columns) as f32)
}

/// Light below a layer: what its gaps let through and what it transmits diffusely (Eddington, see `passes::light`).
fn pass(layer: &LayerState, above: Level, mu: f32) -> Level {
    let cover = layer.coverage as f32;
    let depth = 0.6 * layer.kind.appearance().extinction_per_m * (layer.density * layer.thickness_m) as f32;
    let reduced = 4.0 / 3.0 + (1.0 - crate::passes::light::ASYMMETRY) * depth;
    let (from_source, from_sky) = ((2.0 / 3.0 + mu) / reduced, (4.0 / 3.0) / reduced);
    Level {
        direct_lux: above.direct_lux * (1.0 - cover * (1.0 - (-depth / mu).exp())),
        diffuse_lux: above.diffuse_lux * (1.0 - cover + cover * from_sky.min(1.0))
            + above.direct_lux * (cover * mu * from_source.min(1.0)),
    }
}

/// Applies a share of what a layer does to the light at the eye.
fn pass_share(eye: Level, above: Level, below: Level, share: f32) -> Level {
    let apply = |eye: Vec3, above: Vec3, below: Vec3| {
        let ratio = below / above.max(Vec3::splat(1e-9));
        eye * (Vec3::ONE + (ratio - Vec3::ONE) * share)
    };
    Level {
        direct_lux: apply(eye.direct_lux, above.direct_lux, below.direct_lux),
        diffuse_lux: apply(eye.diffuse_lux, above.diffuse_lux, below.diffuse_lux),
    }
}

/// Illuminance of the eye by the flashes of the shutter interval, lux, clouds in between not counted.
fn flash_lux(snapshot: &Snapshot, eye: &Eye) -> f32 {
    let at = |f: &FlashState| {
        let away = eye.place(&f.position) - Vec3::new(0.0, 0.0, eye.height_m as f32);
        f.intensity_cd as f32 / away.length_squared().max(1e6)
    };
    snapshot.flashes.iter().map(at).sum()
}

/// Exposure value for an illuminance: like a camera's meter by day, lagging behind at night as eyes do.
fn automatic_ev(lux: f32) -> f32 {
    (14.6 + 0.82 * (lux.max(1e-6) / 1e5).log2()).clamp(-2.0, 15.5)
}

fn horizon(earth_m: f32, height_m: f32) -> f32 {
    let r = earth_m + height_m;
    -((height_m * (2.0 * earth_m + height_m)).sqrt() / r)
}

/// A height in steps of 2 % of itself (and of the air's scale height), so that the table is not rebuilt for every metre.
fn quantised(height_m: f32) -> f32 {
    let step = 0.02 * (height_m + 0.01 * AIR_SCALE_M).log2().floor().exp2();
    (height_m / step).round() * step
}

/// A direction in steps of a twelfth of a degree.
fn quantised_direction(direction: Vec3) -> Vec3 {
    let step = 1.0 / 700.0;
    let rounded = (direction / step).round() * step;
    rounded.try_normalize().unwrap_or(direction)
}
