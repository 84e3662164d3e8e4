//! Light of cities scattered by the air: their domes over the horizon, and the haze that glows around an eye among them.
//!
//! *What it is.* Single scattering, the same to all sides, of the light that the cities around the eye send up; twice scattered
//! light is left out, as is the shade of clouds. *How we compute it.* Along each direction of the sky's table, at night only.
//! *How we store it.* In that table, so that deck and ground fade into it too.

use super::atmosphere::{Air, HAZE_ALBEDO, Medium, RAYLEIGH_PER_M, path};
use crate::passes::common::{AIR_SCALE_M, HAZE_SCALE_M};
use glam::{Vec2, Vec3};

/// Cities that count at once.
pub const MOST: usize = 8;
/// Colour of a city's lamps.
pub const CITY_COLOUR: Vec3 = Vec3::new(1.0, 0.72, 0.42);
/// Way over which haze near the ground takes a city's light to 1/e, as for the glow of clouds.
const CLEAR_M: f32 = 40_000.0;
/// Lamps and lit walls send light along the ground too: as much as a disc seen from this sine of an elevation.
const LEAST_SINE: f32 = 0.12;
const STEPS: u32 = 32;

/// A city as the air has it: a disc on the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CityLamps {
    /// From the eye's ground point to its middle, east and north.
    pub place_m: [f32; 2],
    /// Its radius; 0: none.
    pub radius_m: f32,
    /// Mean luminance of what is lit, cd/m2.
    pub luminance: f32,
    /// Height of the ground that it stands on.
    pub ground_m: f32,
}

impl CityLamps {
    /// Light at a point at a height over the sea: luminance over all directions it comes from, lux.
    pub fn scalar_lux(&self, place_m: Vec2, height_m: f32) -> f32 {
        let height_m = (height_m - self.ground_m).max(0.0);
        let r2 = self.radius_m * self.radius_m;
        let away2 = place_m.distance_squared(self.place_m.into());
        let d2 = away2 + height_m * height_m;
        // Within the disc the light comes from all sides, far from it as from a point.
        let sine = (height_m / d2.max(1.0).sqrt()).max(LEAST_SINE);
        let sine = sine + (1.0 - sine) * r2 / (r2 + away2);
        self.luminance * std::f32::consts::TAU * r2 / (2.0 * d2 + r2) * sine * (-d2.sqrt() / CLEAR_M).exp()
    }
}

impl Air {
    /// Light of cities scattered into a ray from a height, cd/m2 per colour.
    pub fn city_light(&self, cities: &[CityLamps], eye_m: f32, direction: Vec3) -> Vec3 {
        let [begin, end] = path(eye_m, direction.z).0;
        let (mut light, mut passed, mut before) = (Vec3::ZERO, Vec3::ONE, begin);
        for step in 0..STEPS {
            let share = (step + 1) as f32 / STEPS as f32;
            // Cubed: near the eye steps are short against the width of a city.
            let t = begin + (end - begin) * share * share * share;
            let (mid, ds) = (0.5 * (t + before), t - before);
            before = t;
            let height = Medium::along(eye_m, direction, direction, mid).height_m;
            let rayleigh = RAYLEIGH_PER_M * (-height / AIR_SCALE_M).exp();
            let haze = self.haze_per_m * (-height / HAZE_SCALE_M).exp();
            let extinction = rayleigh + Vec3::splat(haze);
            let through = (-extinction * ds).exp();
            let place_m = Vec2::new(direction.x, direction.y) * mid;
            let lux: f32 = cities.iter().map(|city| city.scalar_lux(place_m, height)).sum();
            let scattered = (rayleigh + Vec3::splat(HAZE_ALBEDO * haze)) * (lux * 0.079_577_47);
            light += passed * scattered * ((Vec3::ONE - through) / extinction.max(Vec3::splat(1e-12)));
            passed *= through;
        }
        light * CITY_COLOUR
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Haze of 40 km of visibility.
    const AIR: Air = Air { haze_per_m: 6.3e-5 };
    /// Three and a half million inhabitants around the eye.
    const BERLIN: CityLamps = CityLamps { place_m: [0.0, 0.0], radius_m: 17_800.0, luminance: 0.167, ground_m: 0.0 };

    #[test]
    fn a_clear_sky_over_a_city_is_as_bright_as_it_is() {
        // Luminance of a sky of so many magnitudes a square arc second, cd/m2.
        let of_magnitude = |magnitudes: f32| 10.8e4 * 10f32.powf(-0.4 * magnitudes);
        // 4 km from the middle of Vienna (1.7 million inhabitants) the darkest sky of a year had 19.25 (Puschnig, Posch and Uttenthaler
        // 2014, arXiv:1304.7716): 2.2e-3 cd/m2. Later hours and clearer air than ours are darker, clouds brighter: ours may be a third
        // darker and five times as bright.
        let vienna = CityLamps { place_m: [4_000.0, 0.0], radius_m: 12_400.0, ..BERLIN };
        let darkest = of_magnitude(19.25);
        let over_vienna = AIR.city_light(&[vienna], 200.0, Vec3::Z).y;
        assert!((0.67 * darkest..5.0 * darkest).contains(&over_vienna), "{over_vienna}, darkest {darkest}");
        // 23 km from the middle of Berlin it had 20.3 (Puschnig et al. 2014, arXiv:1307.2038), of which 21.6 are not the city's.
        let babelsberg = CityLamps { place_m: [23_000.0, 0.0], ..BERLIN };
        let darkest = of_magnitude(20.3) - of_magnitude(21.6);
        let there = AIR.city_light(&[babelsberg], 80.0, Vec3::Z).y;
        assert!((0.5 * darkest..5.0 * darkest).contains(&there), "{there}, darkest {darkest}");
        let zenith = AIR.city_light(&[BERLIN], 40.0, Vec3::Z).y;
        println!("Vienna {over_vienna:.2e}, Babelsberg {there:.2e}, Berlin {zenith:.2e} cd/m2");
        // 60 km away the sky overhead is nearly dark again (20 times less), and towards the city there is its dome.
        let away = CityLamps { place_m: [0.0, 60_000.0], ..BERLIN };
        let up = AIR.city_light(&[away], 40.0, Vec3::Z).y;
        let look = |north: f32| AIR.city_light(&[away], 40.0, Vec3::new(0.0, north, 0.1).normalize()).y;
        assert!(up < zenith / 20.0, "{up} {zenith}");
        assert!(look(1.0) > 4.0 * look(-1.0) && look(1.0) > 4.0 * up, "{} {} {up}", look(1.0), look(-1.0));
    }

    #[test]
    fn light_over_a_disc_is_that_of_its_solid_angle() {
        for height_m in [1_000.0f32, 5_000.0, 20_000.0, 60_000.0] {
            let found = BERLIN.scalar_lux(Vec2::ZERO, height_m) / (-height_m / CLEAR_M).exp();
            let angle = std::f32::consts::TAU * (1.0 - height_m / height_m.hypot(BERLIN.radius_m));
            // The simple form is right near and far and up to a third off between.
            let ratio = found / (BERLIN.luminance * angle);
            assert!((0.7..1.5).contains(&ratio), "{height_m}: {ratio}");
        }
        assert_eq!(AIR.city_light(&[], 40.0, Vec3::Z), Vec3::ZERO);
        // Denver: what counts is the height over the city.
        let high = CityLamps { ground_m: 1_600.0, ..BERLIN };
        assert_eq!(high.scalar_lux(Vec2::ZERO, 2_600.0), BERLIN.scalar_lux(Vec2::ZERO, 1_000.0));
    }
}
