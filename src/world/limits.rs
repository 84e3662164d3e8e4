//! The limits of the world: how much of everything there may be, and the ranges of all quantities in commands.
//!
//! The wire re-exports them beside its own; a `[low, high]` pair includes both ends.

/// Weather layers, global or of one region.
pub const MAX_LAYERS: usize = 8;
/// Changes of single layers in one weather edit.
pub const MAX_LAYER_CHANGES: usize = 64;
/// Regions at once, those that are fading out included: twice as many as are drawn, so that whoever names the nearest ones
/// exchanges only such as are not drawn.
pub const MAX_REGIONS: usize = 32;
/// Views at once.
pub const MAX_VIEWS: usize = 16;
/// Entities beside the ownship that may carry views.
pub const MAX_ENTITIES: usize = 64;
/// Pixels of all views together (four of 3840 x 2160).
pub const MAX_TOTAL_PIXELS: u64 = 4 * 3840 * 2160;
/// Flashes that have not ended yet, waiting ones included, beside those of storms: a thousand in a second are taken.
pub const MAX_PENDING_STRIKES: usize = 1024;
/// Storms at once.
pub const MAX_STORMS: usize = 16;
/// Strokes of one flash.
pub const MAX_STROKES: usize = 32;
/// Entries of a scenario.
pub const MAX_TIMELINE_ENTRIES: usize = 20_000;
/// Characters in the name of a view or region.
pub const MAX_NAME_CHARS: usize = 32;
/// Ids of finished flashes kept until somebody asks; older ones are dropped.
pub const MAX_FINISHED_FLASHES: usize = 2048;
/// Refusals of scenario entries kept until somebody asks; later ones are dropped.
pub const MAX_SCENARIO_REFUSALS: usize = 256;

/// Latitude in degrees.
pub const LATITUDE_DEG: [f64; 2] = [-90.0, 90.0];
/// Longitude in degrees.
pub const LONGITUDE_DEG: [f64; 2] = [-180.0, 180.0];
/// Ownship altitude above the ellipsoid in metres.
pub const OWNSHIP_ALTITUDE_M: [f64; 2] = [-1_000.0, 400_000.0];
/// Yaw and roll in degrees.
pub const TURN_DEG: [f64; 2] = [-360.0, 360.0];
/// Pitch in degrees.
pub const PITCH_DEG: [f64; 2] = [-90.0, 90.0];
/// Each component of the ownship's velocity in m/s.
pub const VELOCITY_MPS: [f64; 2] = [-5_000.0, 5_000.0];
/// Seconds over which the ownship is extrapolated beyond its last message; then it holds.
pub const EXTRAPOLATION_LIMIT_S: f64 = 2.0;

/// Base of a layer above the ellipsoid in metres.
pub const BASE_M: [f64; 2] = [-500.0, 20_000.0];
/// Thickness of a layer in metres.
pub const THICKNESS_M: [f64; 2] = [1.0, 20_000.0];
/// Coverage as a share of the sky.
pub const COVERAGE: [f64; 2] = [0.0, 1.0];
/// Density factor.
pub const DENSITY: [f64; 2] = [0.0, 100.0];
/// Wind speed in m/s.
pub const WIND_SPEED_MPS: [f64; 2] = [0.0, 150.0];
/// Wind direction in degrees.
pub const WIND_FROM_DEG: [f64; 2] = [-360.0, 360.0];
/// Meteorological visibility in metres.
pub const VISIBILITY_M: [f64; 2] = [10.0, 300_000.0];
/// Duration of a transition in seconds.
pub const TRANSITION_S: [f64; 2] = [0.0, 86_400.0];

/// Full size of a region along either side in metres.
pub const REGION_SIZE_M: [f64; 2] = [100.0, 2_000_000.0];
/// Width of a region's transition in metres.
pub const REGION_TRANSITION_M: [f64; 2] = [0.0, 500_000.0];

/// UTC in seconds since 1970: the years 1900 to 2100, for which sun and moon are good.
pub const UTC_S: [f64; 2] = [-2_208_988_800.0, 4_102_444_800.0];
/// Seconds of UTC per second of simulation; negative: the sun goes backwards.
pub const TIME_RATE: [f64; 2] = [-86_400.0, 86_400.0];
/// Simulation time in seconds (about 31 years).
pub const SIMULATION_TIME_S: [f64; 2] = [0.0, 1e9];
/// Seconds of simulation per second of wall clock.
pub const SPEED: [f64; 2] = [0.0, 1_000.0];

/// Width and height of a view in pixels.
pub const VIEW_SIZE_PX: [u32; 2] = [16, 8_192];
/// Horizontal field of view in degrees.
pub const FIELD_OF_VIEW_DEG: [f64; 2] = [1.0, 170.0];
/// Angle of a side of a picture from its axis in degrees.
pub const FRUSTUM_DEG: [f64; 2] = [-85.0, 85.0];
/// Least angle between two sides of a picture in degrees.
pub const FRUSTUM_SPAN_DEG: f64 = 0.1;
/// Light of the stars as a share.
pub const STARLIGHT: [f64; 2] = [0.0, 1.0];
/// Each component of a view's offset in metres.
pub const VIEW_OFFSET_M: [f64; 2] = [-1_000.0, 1_000.0];
/// Exposure value at ISO 100.
pub const EV100: [f64; 2] = [-12.0, 24.0];

/// Height of a flash's light above the ellipsoid, which is the ground, in metres: up to where sprites begin.
pub const STRIKE_ALTITUDE_M: [f64; 2] = [0.0, 100_000.0];
/// Mean rate of a storm; the most active ever counted had some hundreds.
pub const FLASHES_PER_MINUTE: [f64; 2] = [0.0, 600.0];
/// A share of flashes.
pub const SHARE: [f64; 2] = [0.0, 1.0];
/// Factor on the peak currents of a storm's flashes.
pub const CURRENT_FACTOR: [f64; 2] = [0.1, 10.0];
/// Peak current in kiloamperes.
pub const PEAK_CURRENT_KA: [f64; 2] = [0.1, 500.0];
/// Length of a given continuing current in seconds; the longest seen is 0.8 s.
pub const CONTINUING_S: [f64; 2] = [0.0, 1.5];
/// Distance of a stroke's ground point from its flash's place, east or north, in metres; the farthest seen is 7.3 km.
pub const GROUND_POINT_M: [f64; 2] = [-20_000.0, 20_000.0];
/// Delay of a stroke after the flash begins in seconds.
pub const STROKE_DELAY_S: [f64; 2] = [0.0, 5.0];

/// Slices per layer.
pub const SLICES: [u32; 2] = [1, 512];
/// Pixels of the picture each way to one of the deck.
pub const DECK_SCALE: [u32; 2] = [1, 4];
/// Memory in MiB that tables of virtual lights may take.
pub const BASIS_MEMORY_MIB: [u32; 2] = [1, 65_536];
/// Ratio between the radii of neighbouring billboard rings.
pub const RING_RATIO: [f64; 2] = [1.01, 4.0];
