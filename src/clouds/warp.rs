//! Slow waves that move the tile sideways: the same 16 km are seen again, but never in the same place of the next tile.
//!
//! *What it is.* A place of a chart takes its shape from another place of the tile, up to some four kilometres away. Two places a
//! whole number of tiles apart are moved differently, so that their shapes have little in common.
//! *How we compute it.* Four plane waves 56 to 71 km long, each of which moves places along its own crests: that shears elements
//! by a tenth and leaves their areas, so that coverage keeps its calibration. Waves are made of parabolas: every device
//! computes them alike. Wavelengths and directions were searched so that no multiple of 16 km up to 800 km,
//! east or north, is near whole waves of all four.

use glam::{DVec2, Vec2};

/// Waves.
pub const WAVES: usize = 4;
/// Waves a metre, east.
const EAST: [f32; WAVES] = [1.308_378e-5, 3.655_636e-6, -7.800_198e-6, -1.402_771e-5];
/// Waves a metre, north.
const NORTH: [f32; WAVES] = [8.496_709e-6, 1.364_302e-5, 1.599_278e-5, 9.461_809e-6];
/// Phases that mean that there are no waves.
pub const NONE: [f32; WAVES] = [-1.0; WAVES];
/// How far each moves a place east at most, m: 1.3 km along its crests.
const EASTWARD_M: [f32; WAVES] = [-708.0, -1255.7, -1168.4, -727.0];
/// The same north.
const NORTHWARD_M: [f32; WAVES] = [1090.3, 336.5, -569.9, -1077.7];

/// Phases of the waves at a chart coordinate (metres), in waves, 0 to 1.
pub fn phases(chart_m: DVec2) -> [f32; WAVES] {
    std::array::from_fn(|i| (f64::from(EAST[i]) * chart_m.x + f64::from(NORTH[i]) * chart_m.y).rem_euclid(1.0) as f32)
}

/// Where in the tile a place takes its shape from, against its own coordinate, m: `moved` metres away from where the waves
/// have these phases.
pub fn shift_m(phases: &[f32; WAVES], moved: Vec2) -> Vec2 {
    let mut shift = Vec2::ZERO;
    if phases[0] < 0.0 {
        return shift;
    }
    for i in 0..WAVES {
        let phase = phases[i] + EAST[i] * moved.x + NORTH[i] * moved.y;
        let f = phase - (phase + 0.5).floor();
        let wave = f * (8.0 - 16.0 * f.abs());
        shift += wave * Vec2::new(EASTWARD_M[i], NORTHWARD_M[i]);
    }
    shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_smooth_small_and_known_by_the_phases_wherever_they_were_taken() {
        let phases_here = phases(DVec2::new(3.2e6, -1.7e6));
        let mut steepest = 0.0f32;
        for k in 0..4000 {
            let moved = Vec2::new(137.0 * k as f32 - 2e5, 60.0 * k as f32);
            let here = shift_m(&phases_here, moved);
            assert!(here.length() < 5_200.0);
            let there = phases(DVec2::new(3.2e6, -1.7e6) + moved.as_dvec2());
            // Phases of a few waves in f32: 5e-7 of 70 km, at a slope below one.
            assert!((shift_m(&there, Vec2::ZERO) - here).length() < 0.1, "{moved}");
            for step in [Vec2::X, Vec2::Y] {
                let slope = (shift_m(&phases_here, moved + 20.0 * step) - here).length() / 20.0;
                steepest = steepest.max(slope);
            }
        }
        // Of each wave 8 * 1.3 km / 56 km at most; all four do not meet so in one place.
        assert!((0.1..0.55).contains(&steepest), "{steepest}");
    }

    #[test]
    fn areas_are_kept_on_the_whole() {
        let at = phases(DVec2::new(1e5, 2e5));
        let mut sum = 0.0;
        for k in 0..10_000u32 {
            let moved = Vec2::new((k % 100) as f32, (k / 100) as f32) * 2_900.0;
            let from = |d: Vec2| d + shift_m(&at, moved + d) - shift_m(&at, moved);
            let area = from(20.0 * Vec2::X).perp_dot(from(20.0 * Vec2::Y)) / 400.0;
            // Places are not folded over one another.
            assert!(area > 0.5, "{moved}: {area}");
            sum += area;
        }
        // 290 km are four or five waves: a twentieth of them is cut off.
        assert!((sum / 10_000.0 - 1.0f32).abs() < 0.02, "{}", sum / 10_000.0);
    }
}
