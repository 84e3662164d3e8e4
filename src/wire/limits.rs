//! Limits: every length, count, rate and range that comes from outside, in one file.
//!
//! The published schemas take their bounds from here, and the check of a message is made from the schema, so a limit is
//! written once. A value outside is refused with the field, the value and the limit; nothing is clamped in silence. What
//! the world itself bounds is taken from there.

use crate::world::limits as world;

/// A closed range of a real number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
}

impl Range {
    const fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    const fn of([min, max]: [f64; 2]) -> Self {
        Self { min, max }
    }
}

/// A closed range of a whole number: a count, a size, a number of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Whole {
    /// Smallest value allowed.
    pub min: u64,
    /// Largest value allowed.
    pub max: u64,
}

impl Whole {
    const fn new(min: u64, max: u64) -> Self {
        Self { min, max }
    }
}

// --- Bytes and shapes of messages, checked before anything is built from them ---

/// Longest control message in bytes (an inline scenario is the longest).
pub const MESSAGE_BYTES: usize = 256 * 1024;
/// Longest scenario file in bytes.
pub const SCENARIO_BYTES: usize = 4 * 1024 * 1024;
/// Longest file of heights in bytes.
pub const HEIGHT_FILE_BYTES: usize = 512 * 1024 * 1024;
/// Most heights of a file: 144 MB of memory, and a third more for its coarser forms.
pub const HEIGHT_SAMPLES: usize = 36_000_000;
/// Samples of all tiles of a GeoTIFF over those of its picture at most: tiles reach beyond its edges.
pub const HEIGHT_PADDING: u64 = 4;
/// Most tags of a GeoTIFF: files in use have some dozens.
pub const HEIGHT_TAGS: u64 = 512;
/// Longest value of a tag of a GeoTIFF in bytes: keys and texts have some hundreds.
pub const HEIGHT_TAG_BYTES: u64 = 64 * 1024;
/// Most strips or tiles of a GeoTIFF: a grid of the largest size in tiles of 16 x 16 has 141,000.
pub const HEIGHT_CHUNKS: usize = 262_144;
/// Longest settings file in bytes.
pub const SETTINGS_BYTES: usize = 64 * 1024;
/// Deepest nesting of lists and objects in any JSON text (an inline scenario's layers stand at depth 6).
pub const JSON_DEPTH: usize = 12;
/// Most values (numbers, texts, lists, objects, ...) in one control message.
pub const MESSAGE_VALUES: usize = 20_000;
/// Most values in a scenario file.
pub const SCENARIO_VALUES: usize = 400_000;
/// Most fields in one object; no message of ours has more than a third of that.
pub const OBJECT_FIELDS: usize = 64;
/// Most complaints that one file or message is answered with; the rest are counted.
pub const COMPLAINTS: usize = 100;

/// Longest CIGI message in bytes: what one UDP datagram can carry over IPv4.
pub const CIGI_MESSAGE_BYTES: usize = 65_507;
/// Most packets of a CIGI message that is given as JSON; the smallest packet has 8 bytes.
pub const CIGI_JSON_PACKETS: usize = CIGI_MESSAGE_BYTES / 8;

/// CIGI packets that are taken before the clock is looked at again; the message in which they end is still taken whole.
pub const CIGI_PACKETS_AT_ONCE: usize = 1_024;
/// Entities of a CIGI host that are kept.
pub const CIGI_ENTITIES: usize = 1_024;
/// Regions of a CIGI host that are kept; the world has the nearest of them, as many as [`world::MAX_REGIONS`].
pub const CIGI_REGIONS: usize = 256;
/// Questions of a CIGI host that wait for one Start of Frame.
pub const CIGI_QUESTIONS: usize = 256;
/// Questions of a CIGI host that are answered again and again.
pub const CIGI_PERIODIC_QUESTIONS: usize = 256;
/// Answers to a CIGI host that wait because they did not fit one datagram.
pub const CIGI_ANSWERS_WAITING: usize = 4_096;
/// Bytes of one datagram to a CIGI host: what fits an Ethernet frame without being cut into fragments.
pub const CIGI_DATAGRAM_BYTES: usize = 1_472;
/// Frames a second of which a CIGI host is told.
pub const CIGI_RATE_HZ: Range = Range::new(1.0, 240.0);
/// Seconds of silence after which a CIGI host is taken to be gone.
pub const CIGI_SILENCE_S: Range = Range::new(0.1, 3_600.0);
/// Height of mean sea level above the WGS84 ellipsoid: the geoid lies between -107 m and 86 m.
pub const SEA_LEVEL_M: Range = Range::new(-110.0, 110.0);
/// Weather layers of a CIGI host that are kept, those of all regions and entities together.
pub const CIGI_WEATHER_LAYERS: usize = 1_024;

// --- Names and texts ---

/// Length in characters of the name of a view, a region or a client. A view's name fills at most 32 bytes of a frame header.
pub const NAME_LENGTH: Whole = Whole::new(1, world::MAX_NAME_CHARS as u64);
/// Characters of the name of a view or a region.
pub const NAME_PATTERN: &str = "^[A-Za-z0-9_-]+$";
/// Characters of the name of a scenario file without `.json`: no dot and no slash, so no way out of the folder.
pub const SCENARIO_NAME_PATTERN: &str = "^[a-z0-9-]+$";
/// Length of a scenario's name.
pub const SCENARIO_NAME_LENGTH: Whole = Whole::new(1, 64);
/// Length of a description in characters.
pub const DESCRIPTION_LENGTH: Whole = Whole::new(0, 1000);
/// Length of an access token in characters.
pub const TOKEN_LENGTH: Whole = Whole::new(8, 256);
/// Length of the text of an instant.
pub const INSTANT_LENGTH: Whole = Whole::new(1, 64);

// --- Ownship and places ---

/// WGS84 geodetic latitude.
pub const LATITUDE_DEG: Range = Range::of(world::LATITUDE_DEG);
/// WGS84 longitude.
pub const LONGITUDE_DEG: Range = Range::of(world::LONGITUDE_DEG);
/// Height of the ownship above the ellipsoid.
pub const ALTITUDE_M: Range = Range::of(world::OWNSHIP_ALTITUDE_M);
/// Heading, and the yaw of a view against the body.
pub const YAW_DEG: Range = Range::of(world::TURN_DEG);
/// Nose up.
pub const PITCH_DEG: Range = Range::of(world::PITCH_DEG);
/// Right wing down.
pub const ROLL_DEG: Range = Range::of(world::TURN_DEG);
/// One component of the velocity over ground; the fastest aircraft reaches 980 m/s, a capsule some thousands.
pub const VELOCITY_MPS: Range = Range::of(world::VELOCITY_MPS);

// --- Weather ---

/// Most cloud layers in one weather.
pub const LAYERS: usize = world::MAX_LAYERS;
/// Most edits of single layers in one message.
pub const LAYER_CHANGES: usize = world::MAX_LAYER_CHANGES;
/// Height of a layer's base above the ellipsoid.
pub const BASE_M: Range = Range::of(world::BASE_M);
/// Thickness of a layer: a cumulonimbus of the tropics reaches 18 km.
pub const THICKNESS_M: Range = Range::of(world::THICKNESS_M);
/// Share of the sky hidden.
pub const COVERAGE: Range = Range::of(world::COVERAGE);
/// The same in eighths (FEW 1-2, SCT 3-4, BKN 5-7, OVC 8).
pub const COVERAGE_EIGHTHS: Range = Range::new(0.0, 8.0);
/// Factor on the usual extinction of a cloud type (deck paper eq. 16, D).
pub const DENSITY: Range = Range::of(world::DENSITY);
/// Wind speed: the strongest jet stream measured is about 115 m/s.
pub const WIND_SPEED_MPS: Range = Range::of(world::WIND_SPEED_MPS);
/// Direction of a wind or an outline.
pub const DIRECTION_DEG: Range = Range::of(world::WIND_FROM_DEG);
/// Meteorological visibility: from dense fog to pure air.
pub const VISIBILITY_M: Range = Range::of(world::VISIBILITY_M);
/// Seconds over which weather eases.
pub const TRANSITION_S: Range = Range::of(world::TRANSITION_S);
/// Width or length of a region.
pub const REGION_SIZE_M: Range = Range::of(world::REGION_SIZE_M);
/// Corner radius of a region; besides at most half of its smaller size.
pub const CORNER_RADIUS_M: Range = Range::new(0.0, 1_000_000.0);
/// Width of the transition around a region.
pub const REGION_TRANSITION_M: Range = Range::of(world::REGION_TRANSITION_M);

// --- Questions ---

/// Ranges along a line of sight.
pub const SIGHT_RANGE_M: Range = Range::new(0.0, 1_000_000.0);
/// Opacity of cloud, 0 (clear) to 1.
pub const OPACITY: Range = Range::new(0.0, 1.0);
/// Questions that ask the world (heights, lines of sight, weather at a point) being worked out at once, of all clients.
pub const QUESTIONS_AT_ONCE: usize = 2;

// --- Time ---

/// Instants as seconds since 1970 (UTC): the years for which the sun's and moon's positions hold.
pub const UTC_S: Range = Range::of(world::UTC_S);
/// Seconds of UTC per second of simulation.
pub const TIME_RATE: Range = Range::of(world::TIME_RATE);
/// Simulation time.
pub const SIMULATION_TIME_S: Range = Range::of(world::SIMULATION_TIME_S);
/// Seconds of simulation per second of wall clock while a scenario plays.
pub const SPEED: Range = Range::of(world::SPEED);

// --- Views ---

/// Width or height of a picture.
pub const SIZE_PX: Whole = Whole::new(world::VIEW_SIZE_PX[0] as u64, world::VIEW_SIZE_PX[1] as u64);
/// Horizontal field of view of a flat picture.
pub const FIELD_OF_VIEW_DEG: Range = Range::of(world::FIELD_OF_VIEW_DEG);
/// Eye point against the ownship's reference point, one component.
pub const OFFSET_M: Range = Range::of(world::VIEW_OFFSET_M);
/// Exposure value at ISO 100: starlight is about -6, sunlit snow 16.
pub const EV100: Range = Range::of(world::EV100);

// --- Strikes ---

/// Height of a flash's light above the ellipsoid.
pub const STRIKE_ALTITUDE_M: Range = Range::of(world::STRIKE_ALTITUDE_M);
/// Peak current of a stroke; bounds of measurements are about 2 and 300 kA, 500 kA in the tropics (CIGRE TB 549).
pub const PEAK_CURRENT_KA: Range = Range::of(world::PEAK_CURRENT_KA);
/// Strokes of one flash; the most seen in one flash are about 26.
pub const STROKES: Whole = Whole::new(1, world::MAX_STROKES as u64);
/// Length of a stroke's continuing current.
pub const CONTINUING_S: Range = Range::of(world::CONTINUING_S);
/// A stroke's ground point against the flash's place, east or north.
pub const GROUND_POINT_M: Range = Range::of(world::GROUND_POINT_M);
/// Delay of a stroke after its flash began; flashes last up to about 2 s.
pub const STROKE_DELAY_S: Range = Range::of(world::STROKE_DELAY_S);

// --- Storms ---

/// Mean rate of a storm.
pub const FLASHES_PER_MINUTE: Range = Range::of(world::FLASHES_PER_MINUTE);
/// A share of a storm's flashes.
pub const SHARE: Range = Range::of(world::SHARE);
/// Factor on the peak currents of a storm's flashes.
pub const CURRENT_FACTOR: Range = Range::of(world::CURRENT_FACTOR);
/// Strokes in any one second that the guard against flicker lets through.
pub const GUARD_FLASHES_PER_S: Whole =
    Whole::new(crate::lightning::guard::FLASHES_PER_S[0] as u64, crate::lightning::guard::FLASHES_PER_S[1] as u64);

// --- Subscriptions, steps and the sockets ---

/// Most frames a second of one view; the server's own rate has the same limit.
pub const FRAME_RATE_HZ: Range = Range::new(0.01, 60.0);
/// Frames a second that the server may be told to aim at while running free.
pub const SERVER_RATE_HZ: Range = Range::new(0.1, FRAME_RATE_HZ.max);
/// Seconds after which a client that takes no bytes is cut off.
pub const SLOW_CLIENT_S: Range = Range::new(0.1, 600.0);
/// Quality of a JPEG.
pub const JPEG_QUALITY: Whole = Whole::new(1, 100);
/// Most subscriptions of one client.
pub const SUBSCRIPTIONS: usize = 16;
/// Lockstep steps of all clients that wait.
pub const STEPS_WAITING: usize = 64;
/// Most messages a second that one client may send on average; more are refused unread.
pub const MESSAGES_PER_SECOND: u32 = 500;
/// Most messages that one client may send at once before the rate holds.
pub const MESSAGE_BURST: u32 = 1_000;
/// Most refusals a second with which a client's flood is answered; the others are counted in the next one.
pub const REFUSALS_PER_SECOND: u32 = 1;
/// Clients at once that settings may ask for.
pub const CLIENTS: Whole = Whole::new(1, 1_000);

// --- Scenarios ---

/// Most entries of a scenario.
pub const SCENARIO_ENTRIES: usize = world::MAX_TIMELINE_ENTRIES;
/// Duration of a scenario; 0: it never ends.
pub const SCENARIO_DURATION_S: Range = Range::new(0.0, world::SIMULATION_TIME_S[1]);

// --- Pictures and frames on the wire ---

/// Slices per cloud layer (deck paper eq. 12, N).
pub const SLICES: Whole = Whole::new(world::SLICES[0] as u64, world::SLICES[1] as u64);
/// Pixels of the picture each way to one of the deck.
pub const DECK_SCALE: Whole = Whole::new(world::DECK_SCALE[0] as u64, world::DECK_SCALE[1] as u64);
/// Memory in MiB that tables of virtual lights may take.
pub const BASIS_MEMORY_MIB: Whole = Whole::new(world::BASIS_MEMORY_MIB[0] as u64, world::BASIS_MEMORY_MIB[1] as u64);
/// Memory in MiB that tables of virtual lights may take in their folder: a table has some ten.
pub const BASIS_CACHE_MIB: Whole = Whole::new(16, 1 << 20);
/// Ratio between the radii of neighbouring billboard rings.
pub const RING_RATIO: Range = Range::of(world::RING_RATIO);
/// Interval whose light a frame gathers.
pub const SHUTTER_S: Range = Range::new(0.000_1, 1.0);
/// Bytes of the picture in one frame message: the largest raw picture.
pub const FRAME_PAYLOAD_BYTES: u32 = 4 * world::VIEW_SIZE_PX[1] * world::VIEW_SIZE_PX[1];
/// Frames that wait for one client per subscription.
pub const QUEUE_FRAMES: Whole = Whole::new(1, 16);
/// Memory in MiB that the pictures of lockstep steps may hold until they are written.
pub const STEP_MEMORY_MIB: Whole = Whole::new(16, 1_048_576);
/// Commands that wait for the world.
pub const QUEUE_COMMANDS: Whole = Whole::new(16, 65_536);
/// Entries of a list in the settings (allowed origins).
pub const SETTINGS_LIST: usize = 64;
/// Length of a text in the settings in characters.
pub const SETTINGS_TEXT_LENGTH: Whole = Whole::new(1, 256);
