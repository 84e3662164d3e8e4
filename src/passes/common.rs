//! What several passes share: the camera, the haze, charts; twin of `common.wgsl`.

use crate::clouds::{density, warp};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

/// Eye, picture and air. Parameters; twin of `Camera` in `common.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// Right axis times the tangent of half the horizontal field of view (east, north, up).
    pub right: [f32; 3],
    /// Width in pixels.
    pub width_px: f32,
    /// Up axis times the tangent of half the vertical field of view.
    pub up: [f32; 3],
    /// Height in pixels.
    pub height_px: f32,
    /// Forward axis.
    pub forward: [f32; 3],
    /// Height of the eye above the sphere.
    pub eye_m: f32,
    /// Radius of the sphere.
    pub earth_m: f32,
    /// Factor from cd/m2 to the linear value that is tone-mapped.
    pub exposure: f32,
    /// Extinction of the haze at height 0, in 1/m: 3.0 / visibility (5 % contrast).
    pub haze_per_m: f32,
    /// Extinction of the molecules at height 0, green, in 1/m.
    pub air_per_m: f32,
}

/// Height over which the haze falls to 1/e.
pub const HAZE_SCALE_M: f32 = 1_200.0;
/// Height over which the molecules fall to 1/e.
pub const AIR_SCALE_M: f32 = 8_000.0;

impl Camera {
    /// Unit direction of the ray through a point of the picture in pixels (pixel centres at .5, y down).
    pub fn ray(&self, x_px: f32, y_px: f32) -> Vec3 {
        let sx = 2.0 * x_px / self.width_px - 1.0;
        let sy = 1.0 - 2.0 * y_px / self.height_px;
        (Vec3::from(self.forward) + Vec3::from(self.right) * sx + Vec3::from(self.up) * sy).normalize()
    }

    /// The same eye with `scale` times fewer pixels each way, rounded up.
    pub fn coarser(&self, scale: u32) -> Self {
        let size = |pixels: f32| (pixels / scale as f32).ceil();
        Self { width_px: size(self.width_px), height_px: size(self.height_px), ..*self }
    }

    /// Height above the sphere at range `t_m` along a ray whose upward component is `up`.
    pub fn height_at(&self, up: f32, t_m: f32) -> f32 {
        let r = self.earth_m + self.eye_m;
        // sqrt(r^2 + d) - r without cancellation.
        let d = 2.0 * t_m * r * up + t_m * t_m;
        self.eye_m + d / ((r * r + d).max(0.0).sqrt() + r)
    }

    /// Ranges at which a ray crosses the shell at a height: going down and going up; infinite where it does not.
    pub fn crossings(&self, up: f32, height_m: f32) -> (f32, f32) {
        let b = (self.earth_m + self.eye_m) * up;
        let c = (self.eye_m - height_m) * (2.0 * self.earth_m + self.eye_m + height_m);
        let disc = b * b - c;
        if disc < 0.0 {
            return (f32::INFINITY, f32::INFINITY);
        }
        let root = disc.sqrt();
        if c > 0.0 {
            // The eye is above the shell: it is met only looking down, twice.
            if b >= 0.0 { (f32::INFINITY, f32::INFINITY) } else { (c / (root - b), root - b) }
        } else {
            (f32::INFINITY, if b > 0.0 { -c / (root + b) } else { root - b })
        }
    }

    /// Transmittance of the air between the eye and a point at range `t_m` and height `height_m`.
    pub fn air_transmittance(&self, height_m: f32, t_m: f32) -> f32 {
        let depth = self.haze_per_m * mean_density(self.eye_m, height_m, HAZE_SCALE_M)
            + self.air_per_m * mean_density(self.eye_m, height_m, AIR_SCALE_M);
        (-depth * t_m).exp()
    }
}

/// Mean of exp(-h / scale) between two heights (closed form; the limit where they are equal).
fn mean_density(a_m: f32, b_m: f32, scale_m: f32) -> f32 {
    // From the lower height upwards, so that the exponential of a height in space does not overflow.
    let d = (b_m - a_m).abs() / scale_m;
    let lower = (-a_m.min(b_m) / scale_m).exp();
    lower * if d < 1e-2 { 1.0 - 0.5 * d } else { (1.0 - (-d).exp()) / d }
}

/// A chart for cloud or ground textures around the eye; twin of `Chart` in `common.wgsl`. See `geo::charts`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Chart {
    /// Chart coordinate of the eye's ground point in metres, brought into one period of the volume's tile.
    pub tile_origin_m: [f32; 2],
    /// The same point in periods of the 2D map, rotated, brought into [0, 1).
    pub map_origin: [f32; 2],
    /// Complex factor `a` of origin + a z / (1 - c z).
    pub a: [f32; 2],
    /// Complex factor `c`, 1/m.
    pub c: [f32; 2],
    /// Chart centre in the eye's axes: raw weight is its dot product with the direction from the Earth's centre.
    pub w: [f32; 3],
    /// Half the width of the zone over which charts are cross-faded, as a difference of raw weights.
    pub zone: f32,
    /// Phases at the eye's ground point of the waves that move the tile, in waves (see `clouds::warp`).
    pub warp: [f32; 4],
}

impl Chart {
    /// A place in the array that no look-up reads.
    pub const UNUSED: Self = Self {
        tile_origin_m: [0.0; 2],
        map_origin: [0.0; 2],
        a: [1.0, 0.0],
        c: [0.0; 2],
        w: [0.0; 3],
        zone: 1.0,
        // On the waves' crests, where they change least.
        warp: [0.25; 4],
    };

    /// Place in the tile, in periods, of a point displaced from the eye's ground point in the chart by so many metres.
    pub fn tile(&self, moved: Vec2) -> Vec2 {
        (Vec2::from(self.tile_origin_m) + moved + warp::shift_m(&self.warp, moved)) * (1.0 / density::TILE_M)
    }

    /// Displacement from the eye's ground point in the chart, metres, of a point with stereographic coordinate `z` (m).
    pub fn displacement(&self, z: Vec2) -> Vec2 {
        displacement(self.a.into(), self.c.into(), z)
    }
}

/// Displacement in a chart of factors `a` and `c` from the eye's ground point, metres, of a point with stereographic
/// coordinate `z` (m).
pub fn displacement(a: Vec2, c: Vec2, z: Vec2) -> Vec2 {
    complex_div(complex_mul(a, z), Vec2::new(1.0, 0.0) - complex_mul(c, z))
}

/// Charts that a layer or the ground may be drawn with at once.
pub const CHARTS: usize = 3;

/// Shares of the charts at a point (from the Earth's centre, in the eye's axes), adding up to 1.
pub fn chart_weights(charts: &[Chart; CHARTS], count: u32, from_centre: Vec3, radius_m: f32) -> [f32; CHARTS] {
    if count < 2 {
        return [1.0, 0.0, 0.0];
    }
    let used = |i: usize| i < count as usize;
    let direction = from_centre / radius_m;
    let raw: [f32; CHARTS] =
        std::array::from_fn(|i| if used(i) { direction.dot(Vec3::from(charts[i].w)) } else { -1.0 });
    let best = raw.iter().fold(-1.0f32, |a, b| a.max(*b));
    let lifted: [f32; CHARTS] =
        std::array::from_fn(|i| if used(i) { (charts[i].zone + raw[i] - best).max(0.0) } else { 0.0 });
    let sum: f32 = lifted.iter().sum();
    lifted.map(|w| w / sum)
}

/// Stereographic coordinate around the eye's ground point, in metres, of a point `p` (east, north, height over the
/// tangent plane at the ground point) at distance `radius_m` from the Earth's centre.
pub fn stereographic(p: Vec3, earth_m: f32, radius_m: f32) -> Vec2 {
    Vec2::new(p.x, p.y) * (2.0 * earth_m / (radius_m + earth_m + p.z))
}

fn complex_mul(a: Vec2, b: Vec2) -> Vec2 {
    Vec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

fn complex_div(a: Vec2, b: Vec2) -> Vec2 {
    complex_mul(a, Vec2::new(b.x, -b.y)) / b.length_squared()
}

/// Hermite step from 0 at `low` to 1 at `high`.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
