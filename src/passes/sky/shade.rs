//! What clouds leave of the light in the air between and below them, by height.
//!
//! Haze under an overcast is lit by what comes through it, and not by the sun: without that, the far ground faded into the blue of a
//! clear sky, and a sun behind the clouds shone in the air before them.
//!
//! *How we store it.* Shares at heights that lie the closer the lower they are: the square of even steps up to [`REACH_M`].

use super::atmosphere::EARTH_M;
use glam::Vec3;

/// Number of heights.
pub const NODES: usize = 32;
/// The highest, m; above it nothing is shaded.
pub const REACH_M: f32 = 20_000.0;
/// Shortest stretch of a ray that stands for the air at the eye, m.
const LEAST_M: f32 = 200.0;

/// The light of the air against that of a clear sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shade {
    /// Share of the light that comes from sun and moon straight, at each height.
    pub direct: [f32; NODES],
    /// What has been scattered before, over that of a clear sky, per colour at each height; over 1 where clouds make more of it.
    pub diffuse: [Vec3; NODES],
    /// Heights around the eye between which air lies before the clouds, m: below a deck, all up to it.
    pub near_m: [f32; 2],
}

impl Shade {
    /// The height of a node, m.
    pub fn height_m(node: usize) -> f32 {
        let share = node as f32 / (NODES - 1) as f32;
        share * share * REACH_M
    }

    /// Shares of direct and of scattered light at a height, m.
    pub fn at(&self, height_m: f32) -> (f32, Vec3) {
        let place = (height_m / REACH_M).clamp(0.0, 1.0).sqrt() * (NODES - 1) as f32;
        let low = (place as usize).min(NODES - 2);
        // Even in height between two nodes.
        let [below, above] = [low, low + 1].map(Self::height_m);
        let share = ((height_m - below) / (above - below)).clamp(0.0, 1.0);
        let direct = self.direct[low] + (self.direct[low + 1] - self.direct[low]) * share;
        (direct, self.diffuse[low].lerp(self.diffuse[low + 1], share))
    }

    /// The range at which a ray leaves the air that lies before the clouds, m.
    pub fn near_end_m(&self, eye_m: f32, up: f32) -> f32 {
        let b = (EARTH_M + eye_m) * up;
        let beyond = |height_m: f32| (eye_m - height_m) * (2.0 * EARTH_M + eye_m + height_m);
        let [low, high] = self.near_m.map(beyond);
        let end = if b < 0.0 && b * b > low {
            low.max(0.0) / ((b * b - low).sqrt() - b)
        } else {
            let root = (b * b - high.min(0.0)).sqrt();
            if b > 0.0 { -high.min(0.0) / (root + b) } else { root - b }
        };
        end.max(LEAST_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half(near_m: [f32; 2]) -> Shade {
        let direct = std::array::from_fn(|node| if Shade::height_m(node) < 1_000.0 { 0.25 } else { 1.0 });
        Shade { direct, diffuse: direct.map(Vec3::splat), near_m }
    }

    #[test]
    fn shares_are_those_of_the_nodes_and_even_between_them() {
        let shade = half([0.0, 1_000.0]);
        for node in 0..NODES {
            let (direct, diffuse) = shade.at(Shade::height_m(node));
            assert!((direct - shade.direct[node]).abs() < 1e-5 && diffuse.x == direct, "{node}: {direct}");
        }
        let step = (0..NODES).position(|node| Shade::height_m(node) >= 1_000.0).expect("a node above");
        let middle = 0.5 * (Shade::height_m(step - 1) + Shade::height_m(step));
        assert!((shade.at(middle).0 - 0.625).abs() < 1e-4);
        assert_eq!(shade.at(1e6), (1.0, Vec3::ONE));
    }

    #[test]
    fn a_ray_leaves_the_air_before_the_clouds_where_it_meets_them() {
        let shade = half([0.0, 1_000.0]);
        // Straight up and down.
        assert!((shade.near_end_m(400.0, 1.0) - 600.0).abs() < 1.0);
        assert!((shade.near_end_m(400.0, -1.0) - 400.0).abs() < 1.0);
        // Level: by Pythagoras on the sphere, sqrt(2 R h).
        let level = shade.near_end_m(400.0, 0.0);
        assert!((level / (2.0 * EARTH_M * 600.0).sqrt() - 1.0).abs() < 1e-3, "{level}");
        // From above down to the tops, and away into space.
        let above = half([2_000.0, 1e9]);
        assert!((above.near_end_m(3_000.0, -1.0) - 1_000.0).abs() < 1.0);
        assert!(above.near_end_m(3_000.0, 0.5) > 1e6);
        // At the edge of the clouds there is no stretch.
        assert_eq!(above.near_end_m(2_000.0, -0.5), LEAST_M);
    }
}
