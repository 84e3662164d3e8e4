//! How much light there is: from sun, moon and sky, through the layers from the top down, and the exposure it asks for.

mod air;
mod column;
mod exposure;
mod ground;

use super::PassNote;
use super::eye::Eye;
use super::regions::NearRegion;
use crate::geo::Geodetic;
use crate::geo::cities::near;
use crate::geo::frames::enu;
use crate::geo::stars::earth_from_stars;
use crate::geo::terrain::Terrain;
use crate::geo::wgs84::MEAN_RADIUS_M;
use crate::passes::common::{AIR_SCALE_M, Camera, smoothstep};
use crate::passes::ground::lights::CORE_LUMINANCE;
use crate::passes::sky::atmosphere::{Air, Luminary, MOON_LUX, SUN_LUX};
use crate::passes::sky::lamps::{CityLamps, MOST};
use crate::passes::sky::multiple::HigherOrders;
use crate::passes::sky::table::TableParams;
use crate::passes::sky::{Sky, Stars, stars};
use crate::world::command::Frustum;
use crate::world::regions::weight_at;
use crate::world::snapshot::{LayerState, Snapshot, ViewState};
use air::Left;
pub use column::Level;
use column::{ClearSky, Column};
pub use exposure::FULL_LUX_EXPOSURE;
use glam::{DMat3, Vec2, Vec3};
use ground::Sheet;

/// Angular radius of the sun and, nearly, of the moon.
const DISC_RAD: f32 = 0.004_65;
/// Sine of the elevation (-21 degrees) below which a light gives no twilight any more.
const LAST_TWILIGHT: f32 = -0.36;
/// Cities farther away do not light the sky.
const CITIES_REACH_M: f64 = 150_000.0;
/// Contrast of 5 % at the visibility: extinction is -ln(0.05) over it (WMO-No. 8, meteorological optical range).
const VISIBILITY_DEPTH: f64 = 2.996;

/// The light of a moment around the eye.
pub struct Illuminance {
    /// The table of scattered light.
    pub table: TableParams,
    /// The brighter of sun and moon, as a direction (east, north, up).
    pub source: Vec3,
    /// Light under the global weather, then under that of each region in sight.
    pub columns: Vec<Column>,
    /// Light at the ground under the eye, the columns weighted as they rule there.
    pub ground: Level,
    /// Light of the source on ground that no cloud shades, lux per colour on a plane facing it.
    pub unshaded_lux: Vec3,
    /// Factor from cd/m2 to tone-mapped values.
    pub exposure: f32,
    /// How much each column rules at the eye.
    shares: Vec<f32>,
    /// How far the surroundings' weather gives way to each column's: 0 for storm cells that stand in it.
    gives_way: Vec<f32>,
    /// What ground may reach through, and the light above it.
    sheet: Option<Sheet>,
    /// Share of light from below that the clouds send down again, and the height that they have for it, m.
    underside: [f32; 2],
    air: Air,
    lights: [Luminary; 2],
    /// How much of the lamps of cities is lit: all while the sun is lower than 8 degrees below the horizon, none above 1.7.
    pub night: f32,
    /// Whether the moon's disc is there, and how much of the stars' light.
    moon: bool,
    starlight: f32,
    /// Directions of the catalogue of stars to ECEF.
    earth_from_stars: DMat3,
}

impl Illuminance {
    /// The light of a snapshot at an eye, under the global weather and that of the regions in sight.
    pub fn new(snapshot: &Snapshot, eye: &Eye, view: &ViewState, regions: &[NearRegion]) -> Self {
        let sun = eye.direction(snapshot.sky.sun_direction_ecef);
        let moon = eye.direction(snapshot.sky.moon_direction_ecef);
        let haze = VISIBILITY_DEPTH / visibility_m(snapshot, &eye.position).max(1.0) - 1.2e-5;
        let air = Air { haze_per_m: haze.max(1e-7) as f32 };
        let lights = [
            Luminary {
                direction: sun,
                illuminance_lux: if snapshot.sky.sun_shines && sun.z > LAST_TWILIGHT {
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
        let higher = HigherOrders::of(&air);
        let level = |height_m: f32| Level {
            direct_lux: air.transmittance(height_m, key.direction.z) * key.illuminance_lux,
            diffuse_lux: skylight(&air, &higher, height_m, &lights)
                + Vec3::splat(std::f32::consts::PI * night_luminance),
        };
        let mu = key.direction.z.max(0.02);
        let clear = ClearSky { at: &level, eye: level(eye.height_m as f32), ground: level(0.0), mu };
        let around = &snapshot.weather.layers;
        let of = |region: &NearRegion| {
            let own = &region.state.weather.layers;
            let standing = || Column::standing_in(own, around, &clear, eye.height_m);
            let alone = || Column::new(own, &clear, eye.height_m);
            match region.state.gives_way() as f32 {
                share if share <= 0.0 => standing(),
                share if share >= 1.0 => alone(),
                share => Column::between(&standing(), &alone(), share),
            }
        };
        let columns: Vec<Column> =
            std::iter::once(Column::new(around, &clear, eye.height_m)).chain(regions.iter().map(of)).collect();
        let gives_way = regions.iter().map(|region| region.state.gives_way() as f32);
        let gives_way = std::iter::once(1.0).chain(gives_way).collect();
        let shares = shares(regions);
        let here = |level: fn(&Column) -> Level| Level::mixed(shares.iter().copied().zip(columns.iter().map(level)));
        let (at_eye, ground) = (here(|column| column.eye), here(|column| column.ground));
        let weathers = weathers(snapshot, regions, &columns, &shares);
        let sheet = if snapshot.terrain.is_ellipsoid() { None } else { Sheet::of(&weathers) };
        let underside = ground::underside(&weathers);
        // Towards the sun the sky of a twilight is many times as bright as overhead.
        let set = 1.0 - smoothstep(-0.06, 0.0, sun.z);
        let bright_side_lux =
            if set > 0.0 { set * exposure::bright_side_lux(&air, &higher, eye.height_m as f32, &lights) } else { 0.0 };
        // As much as of all skylight comes through the clouds; what they let through is the more even the less it is.
        let open = (at_eye.diffuse_lux.y / clear.eye.diffuse_lux.y.max(1e-9)).min(1.0);
        let ev = exposure::ev100(view.exposure, &at_eye, mu, bright_side_lux * open * open, snapshot, eye);
        let height_m = quantised(eye.height_m as f32);
        let scale = (1.2 * ev.exp2()).log2().round().exp2();
        // In steps of a fiftieth, so that the sky's table is not made for each frame of a dusk.
        let night = ((1.0 - smoothstep(-0.14, -0.03, sun.z)) * 50.0).round() / 50.0;
        let table = TableParams {
            eye_m: height_m,
            horizon: horizon(eye.earth_m as f32, height_m),
            haze_per_m: air.haze_per_m,
            lights: lights.map(|l| Luminary { direction: quantised_direction(l.direction), ..l }),
            night_luminance,
            cities: cities(eye, night, &snapshot.terrain),
            shade: Left::mixed(shares.iter().copied().zip(columns.iter().map(|c| &c.left))).shade(height_m),
            scale,
        };
        // Full scale at 1.2 * 2^EV cd/m2 (ISO 2720 with K = 12.5 and saturation-based speed).
        let exposure = 1.0 / (1.2 * ev.exp2());
        let unshaded_lux = clear.ground.direct_lux;
        let (moon, starlight) = (snapshot.sky.moon_shines, snapshot.sky.starlight as f32);
        let earth_from_stars = earth_from_stars(snapshot.utc_s);
        Self {
            table,
            source: key.direction,
            columns,
            ground,
            unshaded_lux,
            exposure,
            shares,
            gives_way,
            sheet,
            underside,
            air,
            lights,
            night,
            moon,
            starlight,
            earth_from_stars,
        }
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
        let disc = |l: &Luminary, outside_lux: Vec3| {
            let seen = self.air.transmittance(eye.height_m as f32, l.direction.z) * outside_lux;
            seen / (std::f32::consts::PI * DISC_RAD * DISC_RAD)
        };
        // The lit part of the moon is as bright at every phase (Lommel and Seeliger), by day and by night.
        let moonlit = Vec3::splat(if self.moon { MOON_LUX } else { 0.0 });
        let [sun, moon] = &self.lights;
        Sky {
            sun_direction: sun.direction.into(),
            sun_cosine: DISC_RAD.cos(),
            sun_luminance: disc(sun, sun.illuminance_lux).into(),
            horizon: self.table.horizon,
            moon_direction: moon.direction.into(),
            moon_cosine: DISC_RAD.cos(),
            moon_luminance: disc(moon, moonlit).into(),
            table_scale: self.table.scale,
        }
    }

    /// The stars, at night.
    pub fn stars(&self, eye: &Eye, camera: &Camera, notes: &mut Vec<PassNote>) -> Option<Stars> {
        let dark = smoothstep(-0.05, -0.12, self.lights[0].direction.z) * self.starlight;
        let why = if dark > 0.0 { "the night shows them" } else { "they are outshone, or put out" };
        notes.push(PassNote { pass: "stars", kept: dark > 0.0, why: why.into() });
        (dark > 0.0).then(|| {
            let turn = (eye.enu.transpose() * self.earth_from_stars).as_mat3();
            let spread = stars::spread_rad(2.0 * Vec3::from(camera.up).length() / camera.height_px);
            Stars {
                x: turn.x_axis.into(),
                sharpness: 0.5 / (spread * spread),
                y: turn.y_axis.into(),
                strength: dark / (std::f32::consts::TAU * spread * spread),
                z: turn.z_axis.into(),
                pad0: 0.0,
            }
        })
    }

    /// What the air leaves of the source's light between the heights of a column's top and of one of its layers', per colour.
    pub fn reddening(&self, column: usize, top_m: f64) -> Vec3 {
        self.lower(top_m, f64::from(self.columns[column].top_m))
    }

    /// What the air leaves of the source's light on its way from one height down to another, per colour.
    pub fn lower(&self, low_m: f64, high_m: f64) -> Vec3 {
        let [low, high] = [low_m, high_m].map(|height_m| self.air.transmittance(height_m as f32, self.source.z));
        (low / high.max(Vec3::splat(1e-9))).min(Vec3::ONE)
    }

    /// Light that comes up to layer `index` of one of the columns, from lower layers and the ground, over 4 pi, lux per colour;
    /// that of cities is the glow's.
    pub fn upwelling_lux(&self, column: usize, index: usize) -> Vec3 {
        self.columns[column].below_lux[index] * 0.079_577_47
    }
}

/// The cities whose light the air around the eye scatters most, `night` of it lit, as from the nearest corner of a grid of a
/// hundredth of a degree, so that the sky's table is not made for each metre.
fn cities(eye: &Eye, night: f32, terrain: &Terrain) -> [CityLamps; MOST] {
    let mut found = [CityLamps::default(); MOST];
    if night <= 0.0 {
        return found;
    }
    let corner = |angle_rad: f64| (angle_rad.to_degrees() * 100.0).round().to_radians() / 100.0;
    let place = Geodetic {
        latitude_rad: corner(eye.position.latitude_rad),
        longitude_rad: corner(eye.position.longitude_rad),
        altitude_m: 0.0,
    };
    let axes = enu(&place);
    let lamps = near(axes.z_axis, CITIES_REACH_M).into_iter().map(|city| {
        let away = axes.transpose() * city.zenith * MEAN_RADIUS_M;
        let (place_m, radius_m) = ([away.x as f32, away.y as f32], city.radius_m() as f32);
        let ground_m = city.ground_m(terrain) as f32;
        CityLamps { place_m, radius_m, luminance: CORE_LUMINANCE * night, ground_m }
    });
    let mut lamps: Vec<CityLamps> = lamps.collect();
    let counts = |city: &CityLamps| city.scalar_lux(Vec2::ZERO, city.ground_m + 500.0);
    lamps.sort_by(|a, b| counts(b).total_cmp(&counts(a)));
    found.iter_mut().zip(lamps).for_each(|(slot, city)| *slot = city);
    found
}

/// Visibility at a place: the regions' where it is inside them, between the two by its logarithm in a transition.
fn visibility_m(snapshot: &Snapshot, place: &Geodetic) -> f64 {
    snapshot.regions.iter().fold(snapshot.weather.visibility_m, |around, region| {
        let share = region.presence * weight_at(&region.shape, place);
        if share > 0.0 { around.powf(1.0 - share) * region.weather.visibility_m.powf(share) } else { around }
    })
}

/// How much each column's weather rules at the eye, adding up to 1: the surroundings', then each region's. Where regions
/// overlap, the mean of their weathers counts.
fn shares(regions: &[NearRegion]) -> Vec<f32> {
    let around: f64 = regions.iter().map(|region| 1.0 - region.weight).product();
    let all = around + regions.iter().map(|region| region.weight).sum::<f64>();
    std::iter::once(around).chain(regions.iter().map(|region| region.weight)).map(|w| (w / all) as f32).collect()
}

/// Illuminance outside the air by the moon's phase (Allen 1973: m = -12.73 + 0.026 a + 4e-9 a^4, a in degrees); none
/// while not even its twilight is left, or the sun outshines it five hundred times.
fn moonlight(lit_fraction: f64, sun_up: f32, moon_up: f32) -> Vec3 {
    if sun_up > -0.05 || moon_up < LAST_TWILIGHT {
        return Vec3::ZERO;
    }
    let phase_deg = (2.0 * lit_fraction - 1.0).clamp(-1.0, 1.0).acos().to_degrees();
    let magnitudes = 0.026 * phase_deg + 4e-9 * phase_deg.powi(4);
    Vec3::splat(MOON_LUX * 10f64.powf(-0.4 * magnitudes) as f32)
}

/// Illuminance of a horizontal plane by the sky at a height, lux per colour: six elevations by eight azimuths.
fn skylight(air: &Air, higher: &HigherOrders, height_m: f32, lights: &[Luminary; 2]) -> Vec3 {
    let (rows, columns) = (6, 8);
    let mut sum = Vec3::ZERO;
    let lights: Vec<Luminary> = lights.iter().filter(|l| l.illuminance_lux != Vec3::ZERO).copied().collect();
    for row in 0..rows {
        // Equal shares of cos(zenith angle)^2, so that every direction weighs the same.
        let up = ((row as f32 + 0.5) / rows as f32).sqrt();
        let flat = (1.0 - up * up).sqrt();
        for column in 0..columns {
            let azimuth = (column as f32 + 0.5 * (row % 2) as f32) / columns as f32 * std::f32::consts::TAU;
            let direction = Vec3::new(azimuth.cos() * flat, azimuth.sin() * flat, up);
            sum += air.inscatter(higher, height_m, direction, &lights, 12).0;
        }
    }
    sum * (std::f32::consts::PI / (rows * columns) as f32)
}

/// The weathers in sight, the surroundings first, each with how much it rules at the eye and the light through it.
fn weathers<'a>(
    snapshot: &'a Snapshot,
    regions: &[NearRegion<'a>],
    columns: &'a [Column],
    shares: &[f32],
) -> Vec<(f32, &'a [LayerState], &'a Column)> {
    let layers =
        std::iter::once(&snapshot.weather.layers).chain(regions.iter().map(|region| &region.state.weather.layers));
    shares.iter().zip(layers).zip(columns).map(|((share, layers), column)| (*share, &layers[..], column)).collect()
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

#[cfg(test)]
pub(super) mod tests;
