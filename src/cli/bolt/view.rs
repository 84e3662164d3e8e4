//! From metres to pixels: the flat view of a bolt, and a camera that goes round it.

use glam::DVec3;

/// Share of the picture that stays free about the grid.
const MARGIN: f64 = 0.04;
/// The turntable's camera: vertical field of view and height above the ground as a share of the bolt's.
const FIELD_OF_VIEW_DEG: f64 = 38.0;
const EYE_HEIGHT: f64 = 0.06;

/// A view: pixels of a place and the scale of line widths there.
pub(super) enum View {
    /// From the front, all of the grid, no perspective.
    Flat { scale: f64, left: f64, ground_px: f64, up: usize },
    /// Perspective from a place on a circle round the grid.
    Turntable { eye: DVec3, ahead: DVec3, right: DVec3, down: DVec3, focal: f64, size: [f64; 2], near: f64 },
}

impl View {
    /// The flat view of a box of `extent_m`, whose axis `up` (1 or 2) points up.
    pub fn flat(extent_m: [f64; 3], up: usize, [width, height]: [usize; 2]) -> Self {
        let (width, height) = (width as f64, height as f64);
        let room = 1.0 - 2.0 * MARGIN;
        let scale = (room * width / extent_m[0].max(1e-9)).min(room * height / extent_m[up].max(1e-9));
        let left = 0.5 * (width - scale * extent_m[0]);
        Self::Flat { scale, left, ground_px: height * (1.0 - MARGIN), up }
    }

    /// The view from a turn about the vertical that shows all of an upright cylinder round the points, `z` up from 0.
    pub fn turntable(points: &[[f64; 3]], turn_deg: f64, [width, height]: [usize; 2]) -> Self {
        let (width, height) = (width as f64, height as f64);
        let points = || points.iter().map(|&p| DVec3::from_array(p));
        let low = points().reduce(DVec3::min).unwrap_or(DVec3::ZERO);
        let high = points().reduce(DVec3::max).unwrap_or(DVec3::ZERO);
        let centre = (0.5 * (low + high)).with_z(0.0);
        let tall = high.z.max(1.0);
        let radius = points().map(|p| p.with_z(0.0).distance(centre)).fold(0.0, f64::max);
        let focal = 0.5 * height / (0.5 * FIELD_OF_VIEW_DEG).to_radians().tan();
        // From the near side of the cylinder the height must fit, from its middle the width.
        let distance = (1.1 * tall * focal / height + radius).max(2.2 * radius * focal / width + radius);
        let turn = turn_deg.to_radians();
        let eye = centre + DVec3::new(distance * turn.sin(), -distance * turn.cos(), EYE_HEIGHT * tall);
        let ahead = (centre + DVec3::Z * 0.5 * tall - eye).normalize();
        let right = ahead.cross(DVec3::Z).normalize();
        let down = ahead.cross(right);
        Self::Turntable { eye, ahead, right, down, focal, size: [width, height], near: distance }
    }

    /// Pixels of a place in metres along the grid's axes, and the scale of widths; nothing behind the eye.
    pub fn project(&self, p: [f64; 3]) -> Option<([f64; 2], f64)> {
        match *self {
            Self::Flat { scale, left, ground_px, up } => Some(([left + scale * p[0], ground_px - scale * p[up]], 1.0)),
            Self::Turntable { eye, ahead, right, down, focal, size, near } => {
                let d = DVec3::from_array(p) - eye;
                let depth = d.dot(ahead);
                let place = [0.5 * size[0] + focal * d.dot(right) / depth, 0.5 * size[1] + focal * d.dot(down) / depth];
                (depth > 0.02 * near).then_some((place, near / depth))
            }
        }
    }

    /// Share of the picture's height at which the ground begins to fill it.
    pub fn horizon(&self, height: usize) -> f64 {
        match *self {
            Self::Flat { ground_px, .. } => ground_px / height as f64,
            // The level direction: tan of the pitch below the middle.
            Self::Turntable { ahead, focal, size, .. } => {
                let pitch = ahead.z / ahead.x.hypot(ahead.y);
                ((0.5 * size[1] + focal * pitch) / size[1]).clamp(0.0, 1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_in_both_views() {
        let extent = [800.0, 600.0, 2000.0];
        let corner = |n: usize| std::array::from_fn(|axis| if n >> axis & 1 == 1 { extent[axis] } else { 0.0 });
        let corners: Vec<[f64; 3]> = (0..8).map(corner).collect();
        let size = [640, 480];
        let turned = |turn_deg| View::turntable(&corners, turn_deg, size);
        for view in [View::flat(extent, 2, size), turned(0.0), turned(77.0)] {
            for &p in &corners {
                let ([x, y], scale) = view.project(p).expect("in view");
                assert!((0.0..=640.0).contains(&x) && (0.0..=480.0).contains(&y) && scale > 0.3, "{p:?}: {x} {y}");
            }
        }
        // Up is up, and a quarter turn shows the other side.
        let front = turned(0.0);
        let above = |z: f64| front.project([400.0, 300.0, z]).expect("in view").0[1];
        assert!(above(2000.0) < above(0.0));
        let x = |view: &View, p| view.project(p).expect("in view").0[0];
        assert!(x(&front, [800.0, 300.0, 0.0]) > x(&front, [0.0, 300.0, 0.0]) + 50.0);
        let side = turned(90.0);
        assert!((x(&side, [800.0, 300.0, 0.0]) - x(&side, [0.0, 300.0, 0.0])).abs() < 1e-6);
        // A single point is a view, too.
        assert!(View::turntable(&[[1.0, 2.0, 0.0]], 0.0, size).project([1.0, 2.0, 0.0]).is_some());
    }
}
