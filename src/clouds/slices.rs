//! Geometry of a deck (deck paper 4): horizontal slices (LOD1) and rings of upright billboards around the eye (LOD0).
//!
//! A sample stands for a piece of the ray. Slices are `dh` apart in height, so a ray of elevation e meets one every
//! `dh / |sin e|`; the rings' radii grow by a constant ratio q, so a ray meets one every `t (q - 1/q) / 2` at range t.
//! Whichever is finer carries the ray: the weights of the two kinds add up to one everywhere and depend on the position
//! alone. So steep rays are drawn by slices, grazing ones by billboards; there is no gap at the horizon, no edge between
//! the levels of detail, and two abutting views agree.

/// Heights of the slices' centres above the base (eq. 12). One slice is legal: it lies in the middle.
pub fn heights(slices: u32, thickness_m: f32) -> Vec<f32> {
    match slices {
        0 | 1 => vec![0.5 * thickness_m],
        n => (0..n).map(|i| i as f32 * thickness_m / (n - 1) as f32).collect(),
    }
}

/// Slices that share one instance: the shader walks through them, so that a ray's crossings are found once for all.
pub const GROUP: u32 = 4;

/// Heights of the shells between groups of slices above the base: the lowest and the highest slice and those between
/// groups.
pub fn shells(slices: u32, thickness_m: f32) -> Vec<f32> {
    heights(slices.max(2).div_ceil(GROUP).max(2), thickness_m)
}

/// Height that one slice stands for.
pub fn spacing_m(slices: u32, thickness_m: f32) -> f32 {
    if slices < 2 { thickness_m } else { thickness_m / (slices - 1) as f32 }
}

/// Radii of the rings from `first_m` to `last_m`, each `ratio` times the one before.
pub fn ring_radii(first_m: f32, last_m: f32, ratio: f32) -> Vec<f32> {
    let n = ((last_m / first_m).ln() / ratio.ln()).ceil().max(1.0) as i32;
    (0..=n).map(|k| first_m * ratio.powi(k)).collect()
}

/// Range that a ring stands for, as a share of the range: `(q - 1/q) / 2`.
pub fn ring_share(ratio: f32) -> f32 {
    0.5 * (ratio - 1.0 / ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_run_from_base_to_top() {
        assert_eq!(heights(1, 500.0), [250.0]);
        assert_eq!(heights(3, 500.0), [0.0, 250.0, 500.0]);
        assert_eq!(spacing_m(3, 500.0), 250.0);
        assert_eq!(spacing_m(1, 500.0), 500.0);
    }

    #[test]
    fn shells_enclose_the_layer() {
        assert_eq!(shells(32, 700.0), [0.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0]);
        assert_eq!(shells(1, 500.0), [0.0, 500.0]);
    }

    #[test]
    fn rings_tile_the_range() {
        let radii = ring_radii(40.0, 20_000.0, 1.25);
        assert!(*radii.last().unwrap() >= 20_000.0 && radii[0] == 40.0);
        // Each ring stands for the range between the midpoints to its neighbours.
        let share = ring_share(1.25) * radii[5];
        assert!((share - 0.5 * (radii[6] - radii[4])).abs() < 1e-3);
    }
}
