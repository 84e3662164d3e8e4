//! Geometry of a deck (deck paper 4): horizontal slices (LOD1) and rings of upright billboards around the eye (LOD0).
//!
//! An instance stands for a piece of the ray between two surfaces: slabs between slices, or between rings whose radii
//! grow by a constant ratio. Slices are `dh` apart in height, so a ray of elevation e meets one every `dh / |sin e|`. Where
//! that is short against the range slabs carry the ray, else rings do: along a ray rings come first, and one range at which
//! slabs take over, which depends on the position alone. So steep rays are drawn by slices, grazing ones by billboards; there is no gap at the
//! horizon, no edge between the levels of detail, and two abutting views agree.

/// Heights of the slices' centres above the base (eq. 12). One slice is legal: it lies in the middle.
pub fn heights(slices: u32, thickness_m: f32) -> Vec<f32> {
    match slices {
        0 | 1 => vec![0.5 * thickness_m],
        n => (0..n).map(|i| i as f32 * thickness_m / (n - 1) as f32).collect(),
    }
}

/// Slices that share one instance. Between their shells a ray is walked in steps whose length follows the distance to
/// the cloud's edge and not the slices themselves; the number of slices sets the shells and the shortest step.
pub const GROUP: u32 = 8;

/// Heights of the shells between groups of slices above the base: the lowest and the highest slice and those between
/// groups.
pub fn shells(slices: u32, thickness_m: f32) -> Vec<f32> {
    heights(slices.max(2).div_ceil(GROUP).max(2), thickness_m)
}

/// Height that one slice stands for.
pub fn spacing_m(slices: u32, thickness_m: f32) -> f32 {
    if slices < 2 { thickness_m } else { thickness_m / (slices - 1) as f32 }
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
        assert_eq!(shells(32, 600.0), [0.0, 200.0, 400.0, 600.0]);
        assert_eq!(shells(1, 500.0), [0.0, 500.0]);
    }
}
