//! `time`: date, time of day and the rate at which it runs.

use super::instant;
use crate::wire::limits;
use crate::world::command::TimeEdit;
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A new clock setting: what is not given stays. Only the host may send it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeMessage {
    /// Instant, RFC 3339 with `Z` or an offset, of the years 1900 to 2100.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = limits::INSTANT_LENGTH.min, max = limits::INSTANT_LENGTH.max))]
    pub utc: Option<String>,
    /// Seconds of UTC per second of simulation; 0 stops the sun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::TIME_RATE.min, max = limits::TIME_RATE.max))]
    pub rate: Option<f64>,
}

impl TryFrom<TimeMessage> for TimeEdit {
    type Error = Refused;

    fn try_from(message: TimeMessage) -> Result<Self, Refused> {
        if message.utc.is_none() && message.rate.is_none() {
            let limit = "at least one of utc, rate";
            return Err(Refused::new("utc", "not given", limit, "the message would change nothing"));
        }
        let utc_s = message.utc.map(|utc| instant::parse("utc", &utc)).transpose()?;
        Ok(Self { utc_s, rate: message.rate })
    }
}

impl From<&TimeEdit> for TimeMessage {
    fn from(edit: &TimeEdit) -> Self {
        Self { utc: edit.utc_s.map(instant::print), rate: edit.rate }
    }
}
