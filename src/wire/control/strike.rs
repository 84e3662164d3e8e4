//! `strike`: a flash that is asked for.

use super::names::{FlashType, PolarityName};
use crate::wire::limits;
use crate::world::command::{StrikeRequest, StrokeSpec, Strokes};
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Lightning strikes. Only the host may send it; an `event` names the first frame that shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StrikeMessage {
    /// WGS84 latitude.
    #[schemars(range(min = limits::LATITUDE_DEG.min, max = limits::LATITUDE_DEG.max))]
    pub latitude_deg: f64,
    /// WGS84 longitude.
    #[schemars(range(min = limits::LONGITUDE_DEG.min, max = limits::LONGITUDE_DEG.max))]
    pub longitude_deg: f64,
    /// Height of the light's centre above the ellipsoid; without it in the lowest cloud layer, or 2000 m when there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::STRIKE_ALTITUDE_M.min, max = limits::STRIKE_ALTITUDE_M.max))]
    pub altitude_m: Option<f64>,
    /// Simulation time, or `"now"`.
    #[serde(default)]
    pub at_s: StrikeTime,
    /// Where the flash goes.
    pub flash_type: FlashType,
    /// Sign of the charge brought down.
    #[serde(default = "usual_polarity")]
    pub polarity: PolarityName,
    /// Peak current of the first stroke; without it drawn by the seed. Given strokes have their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::PEAK_CURRENT_KA.min, max = limits::PEAK_CURRENT_KA.max))]
    pub peak_current_ka: Option<f64>,
    /// `"sample"`: drawn by the seed from the published distributions; or a list of strokes.
    #[serde(default)]
    pub strokes: StrokesJson,
    /// Whether the flash begins with its stepped leader, faintly, and not with its first return stroke.
    #[serde(default)]
    pub leader: bool,
    /// Seed of everything that is drawn by chance.
    #[serde(default)]
    pub seed: u64,
}

/// When a flash begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StrikeTime {
    /// A word.
    Word(NowWord),
    /// Simulation time.
    At(
        /// Seconds of simulation time.
        #[schemars(range(min = limits::SIMULATION_TIME_S.min, max = limits::SIMULATION_TIME_S.max))]
        f64,
    ),
}

/// The word `now`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NowWord {
    /// When the message is applied.
    Now,
}

/// The strokes of a flash.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StrokesJson {
    /// A word.
    Word(SampleWord),
    /// One by one, in rising order of delay.
    Given(#[schemars(length(min = limits::STROKES.min, max = limits::STROKES.max))] Vec<StrokeJson>),
}

/// The word `sample`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SampleWord {
    /// Drawn by the seed.
    Sample,
}

/// One stroke.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StrokeJson {
    /// Seconds after the flash begins.
    #[schemars(range(min = limits::STROKE_DELAY_S.min, max = limits::STROKE_DELAY_S.max))]
    pub delay_s: f64,
    /// Peak current.
    #[schemars(range(min = limits::PEAK_CURRENT_KA.min, max = limits::PEAK_CURRENT_KA.max))]
    pub peak_current_ka: f64,
    /// Length of its continuing current, 0 for none; without it drawn by the seed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::CONTINUING_S.min, max = limits::CONTINUING_S.max))]
    pub continuing_s: Option<f64>,
    /// Metres east and north of the flash's place to the ground point of this stroke and those after it, of a flash to ground;
    /// without it where the stroke before went. A point that no stroke had before is the end of a channel of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(range(min = limits::GROUND_POINT_M.min, max = limits::GROUND_POINT_M.max)))]
    pub ground_point_m: Option<[f64; 2]>,
}

impl From<StrokeJson> for StrokeSpec {
    fn from(stroke: StrokeJson) -> Self {
        let StrokeJson { delay_s, peak_current_ka, continuing_s, ground_point_m } = stroke;
        Self { delay_s, peak_current_ka, continuing_s, ground_point_m }
    }
}

impl From<StrokeSpec> for StrokeJson {
    fn from(stroke: StrokeSpec) -> Self {
        let StrokeSpec { delay_s, peak_current_ka, continuing_s, ground_point_m } = stroke;
        Self { delay_s, peak_current_ka, continuing_s, ground_point_m }
    }
}

fn usual_polarity() -> PolarityName {
    PolarityName::Negative
}

impl Default for StrikeTime {
    fn default() -> Self {
        Self::Word(NowWord::Now)
    }
}

impl Default for StrokesJson {
    fn default() -> Self {
        Self::Word(SampleWord::Sample)
    }
}

impl TryFrom<StrikeMessage> for StrikeRequest {
    type Error = Refused;

    fn try_from(message: StrikeMessage) -> Result<Self, Refused> {
        let strokes = match message.strokes {
            StrokesJson::Word(SampleWord::Sample) => Strokes::Sample,
            StrokesJson::Given(strokes) => {
                if let Some(peak_current_ka) = message.peak_current_ka {
                    let why = "strokes that are given have their own peak currents";
                    return Err(Refused::new("peak_current_ka", peak_current_ka, "only with \"sample\"", why));
                }
                Strokes::Given(rising(strokes)?)
            }
        };
        Ok(Self {
            latitude_deg: message.latitude_deg,
            longitude_deg: message.longitude_deg,
            altitude_m: message.altitude_m,
            at_s: match message.at_s {
                StrikeTime::Word(NowWord::Now) => None,
                StrikeTime::At(at_s) => Some(at_s),
            },
            kind: message.flash_type.into(),
            polarity: message.polarity.into(),
            peak_current_ka: message.peak_current_ka,
            strokes,
            leader: message.leader,
            seed: message.seed,
        })
    }
}

fn rising(strokes: Vec<StrokeJson>) -> Result<Vec<StrokeSpec>, Refused> {
    for (k, pair) in strokes.windows(2).enumerate() {
        if pair[1].delay_s <= pair[0].delay_s {
            let (field, limit) = (format!("strokes[{}].delay_s", k + 1), format!("more than {}", pair[0].delay_s));
            return Err(Refused::new(field, pair[1].delay_s, limit, "strokes stand in rising order of their delays"));
        }
    }
    Ok(strokes.into_iter().map(StrokeSpec::from).collect())
}

impl From<&StrikeRequest> for StrikeMessage {
    fn from(request: &StrikeRequest) -> Self {
        Self {
            latitude_deg: request.latitude_deg,
            longitude_deg: request.longitude_deg,
            altitude_m: request.altitude_m,
            at_s: request.at_s.map_or_else(StrikeTime::default, StrikeTime::At),
            flash_type: request.kind.into(),
            polarity: request.polarity.into(),
            peak_current_ka: request.peak_current_ka,
            strokes: match &request.strokes {
                Strokes::Sample => StrokesJson::default(),
                Strokes::Given(strokes) => StrokesJson::Given(strokes.iter().map(|&stroke| stroke.into()).collect()),
            },
            leader: request.leader,
            seed: request.seed,
        }
    }
}
