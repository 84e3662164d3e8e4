//! The deck: layered volumetric cloud between slices and rings around the eye (deck paper 4 and 5).
//!
//! A ray is looked along on rungs counted from the eye, fewer where there is no cloud (`walk.wgsl`). A GPU has two forms of it:
//! `deck.wgsl` cuts rays into pieces by rings and by shells between slices, at rungs, and draws them as instances of one small mesh, near
//! to far, where the mesh only says which pixels are met and in what order; `march.wgsl` walks whole rays pixel by pixel in a
//! compute pass. The twin walks them ray by ray. All stop when nothing more can be seen.

pub mod clumps;
pub mod field;
pub mod glow;
pub mod instances;
pub mod sector;
pub mod spans;
pub mod twin;

use crate::passes::common::{CHARTS, Chart};
use crate::passes::light::encoding::Encoding;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Regions that may shape a layer at once.
pub const REGIONS: usize = 16;
/// Flashes that light the deck at once.
pub const FLASHES: usize = 64;

/// A region's outline around the eye. Parameters; twin of `Region` in `field.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Region {
    /// Centre as a stereographic coordinate around the eye's ground point, m.
    pub centre_m: [f32; 2],
    /// Cosine and sine of the rotation of its axes against the eye's.
    pub rotation: [f32; 2],
    /// Half size less the corner radius, m.
    pub core_m: [f32; 2],
    /// Corner radius, m.
    pub corner_m: f32,
    /// 1 over the transition width, 1/m.
    pub inverse_transition: f32,
    /// 0 (not there) to 1.
    pub presence: f32,
    /// Pads to 16 bytes.
    pub pad0: f32,
    /// Pads to 16 bytes.
    pub pad1: f32,
    /// Pads to 16 bytes.
    pub pad2: f32,
}

/// A flash as a point light. Parameters; twin of `Flash` in `common.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Flash {
    /// Place: east, north, height over the tangent plane at the eye's ground point, m.
    pub position_m: [f32; 3],
    /// Luminous intensity over 4 pi, cd/sr: eq. 21's numerator times the isotropic phase function.
    pub intensity: f32,
}

/// Everything about one layer. Parameters; twin of `Layer` in `field.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Layer {
    /// Light source's illuminance at the layer's top, lux per colour.
    pub light_lux: [f32; 3],
    /// Height of the base over the sphere.
    pub base_m: f32,
    /// Direction towards the light (east, north, up).
    pub light_direction: [f32; 3],
    /// Top minus base.
    pub thickness_m: f32,
    /// Sky's illuminance of the layer's top over 4 pi, per colour.
    pub sky_lux: [f32; 3],
    /// Extinction where the cloud is whole, 1/m (sigma_ref times D).
    pub extinction_per_m: f32,
    /// Light from below (ground, and cities at night) over 4 pi, per colour.
    pub ground_lux: [f32; 3],
    /// 1 over the shape value from edge to whole.
    pub inverse_edge: f32,
    /// Offset of theta.
    pub theta: f32,
    /// Factor on the map's value in theta.
    pub patchiness: f32,
    /// Height that one slice stands for.
    pub spacing_m: f32,
    /// Ratio between the radii of neighbouring rings.
    pub ring_ratio: f32,
    /// Radius of the first ring.
    pub ring_first_m: f32,
    /// Radius of the last ring.
    pub ring_last_m: f32,
    /// How far the layer is drawn.
    pub extent_m: f32,
    /// Amplitude of the fine detail, in shape value.
    pub detail: f32,
    /// Number of charts in use.
    pub charts: u32,
    /// Number of regions in use.
    pub regions: u32,
    /// Number of flashes in use.
    pub flashes: u32,
    /// Which region the layer belongs to, counted from 1; 0: the surroundings.
    pub region: u32,
    /// Origin of the detail noise in periods of its tile, along the axes of the first chart.
    pub detail_origin: [f32; 2],
    /// Distance over which the shape value changes by one at most, m: how far a look outside the cloud may step.
    pub reach_m: f32,
    /// Shortest step at the eye, m.
    pub step_m: f32,
    /// Transmittance below which the walk ends: what is behind adds less than this share. 0: it never ends early.
    pub hidden_below: f32,
    /// What a metre of height counts in a tabulated distance, against one along the ground.
    pub clear_rise: f32,
    /// Share of a tabulated distance to the nearest cloud that a look may go at once (see `clouds::clearance`); 0: none.
    pub clear_share: f32,
    /// How much theta falls in a metre at most.
    pub theta_slope_per_m: f32,
    /// Theta of the light volumes' first node.
    pub light_low: f32,
    /// Nodes for each unit of theta.
    pub light_per_theta: f32,
    /// Number of nodes.
    pub light_nodes: f32,
    /// How light is stored: the place in `Encoding::ALL`.
    pub light_encoding: u32,
    /// Height over the sphere at which the map of shade by higher layers lies.
    pub shade_height_m: f32,
    /// Distance from its middle at which it is half as fine as there, m.
    pub shade_near_m: f32,
    /// 1 over the logarithm that reaches to its rim; 0: no layer shades this one.
    pub shade_span: f32,
    /// How far towards the light the detail is looked at that shades a place, m.
    pub relief_m: f32,
    /// Periods of the detail a metre: along the first chart's axes and upwards.
    pub detail_per_m: [f32; 3],
    /// How much a detail of 1 instead of its mean towards the light takes of it, as an exponent.
    pub relief_depth: f32,
    /// Ranges between which the detail fades, m.
    pub detail_fade_m: [f32; 2],
    /// How much density varies inside the cloud, as a factor on clumps of detail; 0: the eye is not near.
    pub varied: f32,
    /// How many times finer than the detail the finer clumps are; whole, so that they wrap with it.
    pub clumps_finer: f32,
    /// Share of it that the air leaves on the way down to the base, per colour: low suns are redder there.
    pub low_light: [f32; 3],
    /// Pads to 16 bytes.
    pub pad0: f32,
    /// Middle of a sphere around all of a region's layer: east, north, height over the tangent plane, m.
    pub bound_m: [f32; 3],
    /// Its radius; 0: the layer has no bound.
    pub bound_radius_m: f32,
    /// The charts.
    pub chart: [Chart; CHARTS],
    /// The outlines of the regions.
    pub outline: [Region; REGIONS],
    /// The flashes.
    pub flash: [Flash; FLASHES],
}

impl Layer {
    /// How its light is stored.
    pub fn encoding(&self) -> Encoding {
        Encoding::ALL.get(self.light_encoding as usize).copied().unwrap_or_default()
    }

    /// The stretch of a ray from the eye, `eye_m` over the sphere, that may meet the layer; empty where the second range is not
    /// beyond the first. Twin of `bounded` in `walk.wgsl`.
    pub fn bounded(&self, eye_m: f32, direction: Vec3) -> [f32; 2] {
        if self.bound_radius_m == 0.0 {
            return [0.0, f32::INFINITY];
        }
        let middle = Vec3::from(self.bound_m) - Vec3::new(0.0, 0.0, eye_m);
        let nearest = direction.dot(middle);
        let beside = (middle - direction * nearest).length_squared();
        let half = self.bound_radius_m * self.bound_radius_m - beside;
        if half <= 0.0 {
            return [0.0; 2];
        }
        [nearest - half.sqrt(), nearest + half.sqrt()]
    }
}

/// One instance of the deck's mesh: a piece of a slab's far shell, of a ring, or of the shell where rays leave the layer.
/// Vertex data; twin of the instance inputs of `deck.wgsl`.
///
/// No WGSL struct: its members are attributes of a vertex buffer, each named in the pipeline.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// [`SLAB`], [`CAP`] or [`RING`], plus [`DOWN`] on the way down.
    pub kind: u32,
    /// Height of the slab's near shell; of a ring, its lower edge.
    pub near_m: f32,
    /// Height of the slab's far shell; of a ring, its upper edge.
    pub far_m: f32,
    /// Inner radius of the piece; of a ring, the radius of the ring before.
    pub inner_m: f32,
    /// Outer radius of the piece; of a ring, its radius.
    pub outer_m: f32,
}

/// The piece of a ray between two neighbouring slices.
pub const SLAB: u32 = 0;
/// The piece of a ray from the last ring to where it leaves the layer.
pub const CAP: u32 = 1;
/// The piece of a ray between two neighbouring rings.
pub const RING: u32 = 2;
/// The ray is falling.
pub const DOWN: u32 = 4;

/// Share of the range at which slabs and rings carry a ray alike: where slices lie further apart along it than that,
/// rings do.
pub const RING_SHARE: f32 = 0.11;
/// Slices' distances that are added to it: near the eye slabs serve all but level rays.
pub const RING_SLICES: f32 = 6.0;

/// Distance below which a flash's light no longer rises (eq. 21 is singular there), m.
pub const FLASH_CAP_M: f32 = 200.0;
/// Colour of a flash's light: the blue of a channel of 24,000 K or so.
pub const FLASH_COLOUR: Vec3 = Vec3::new(0.80, 0.90, 1.25);
