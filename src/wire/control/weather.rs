//! `weather`: layers and visibility, global or of one region; all edits of one message land together.

use super::names::CloudType;
use super::region::RegionJson;
use crate::wire::limits;
use crate::world::command::{LayerChange, LayerSpec, WeatherEdit};
use crate::world::event::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// New or changed weather. Only the host may send it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeatherMessage {
    /// Makes the weather local to this region; without it the global weather is meant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<RegionJson>,
    /// Replaces the whole list of layers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(max = limits::LAYERS))]
    pub layers: Option<Vec<LayerJson>>,
    /// Changes single layers, after `layers` has been applied.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = limits::LAYER_CHANGES))]
    pub changes: Vec<LayerChangeJson>,
    /// Meteorological visibility at the ground (5 % contrast).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::VISIBILITY_M.min, max = limits::VISIBILITY_M.max))]
    pub visibility_m: Option<f64>,
    /// Seconds over which the old weather eases into the new one.
    #[serde(default)]
    #[schemars(range(min = limits::TRANSITION_S.min, max = limits::TRANSITION_S.max))]
    pub transition_s: f64,
}

/// A full cloud layer. Give `coverage` or `coverage_eighths`, not both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerJson {
    /// Cloud genus.
    pub cloud_type: CloudType,
    /// Height of the base above the ellipsoid.
    #[schemars(range(min = limits::BASE_M.min, max = limits::BASE_M.max))]
    pub base_m: f64,
    /// Top minus base.
    #[schemars(range(min = limits::THICKNESS_M.min, max = limits::THICKNESS_M.max))]
    pub thickness_m: f64,
    /// Share of the sky hidden.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::COVERAGE.min, max = limits::COVERAGE.max))]
    pub coverage: Option<f64>,
    /// The same in eighths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::COVERAGE_EIGHTHS.min, max = limits::COVERAGE_EIGHTHS.max))]
    pub coverage_eighths: Option<f64>,
    /// Factor on the type's usual extinction.
    #[serde(default = "usual_density")]
    #[schemars(range(min = limits::DENSITY.min, max = limits::DENSITY.max))]
    pub density: f64,
    /// Wind speed.
    #[serde(default)]
    #[schemars(range(min = limits::WIND_SPEED_MPS.min, max = limits::WIND_SPEED_MPS.max))]
    pub wind_speed_mps: f64,
    /// Direction that the wind comes from, from true north, clockwise.
    #[serde(default)]
    #[schemars(range(min = limits::DIRECTION_DEG.min, max = limits::DIRECTION_DEG.max))]
    pub wind_from_deg: f64,
}

/// A change of one layer: what is not given stays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerChangeJson {
    /// Which layer, counted from the lowest base, from 0.
    #[schemars(range(max = limits::LAYERS - 1))]
    pub index: u32,
    /// Cloud genus.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cloud_type: Option<CloudType>,
    /// Height of the base above the ellipsoid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::BASE_M.min, max = limits::BASE_M.max))]
    pub base_m: Option<f64>,
    /// Top minus base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::THICKNESS_M.min, max = limits::THICKNESS_M.max))]
    pub thickness_m: Option<f64>,
    /// Share of the sky hidden.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::COVERAGE.min, max = limits::COVERAGE.max))]
    pub coverage: Option<f64>,
    /// The same in eighths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::COVERAGE_EIGHTHS.min, max = limits::COVERAGE_EIGHTHS.max))]
    pub coverage_eighths: Option<f64>,
    /// Factor on the type's usual extinction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::DENSITY.min, max = limits::DENSITY.max))]
    pub density: Option<f64>,
    /// Wind speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::WIND_SPEED_MPS.min, max = limits::WIND_SPEED_MPS.max))]
    pub wind_speed_mps: Option<f64>,
    /// Direction that the wind comes from, from true north, clockwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::DIRECTION_DEG.min, max = limits::DIRECTION_DEG.max))]
    pub wind_from_deg: Option<f64>,
}

fn usual_density() -> f64 {
    1.0
}

/// The coverage from its two spellings; `None` when neither is given.
fn coverage(share: Option<f64>, eighths: Option<f64>) -> Result<Option<f64>, Refused> {
    match (share, eighths) {
        (Some(_), Some(eighths)) => {
            Err(Refused::new("coverage_eighths", eighths, "one of the two", "coverage is given twice; leave one out"))
        }
        (Some(share), None) => Ok(Some(share)),
        (None, eighths) => Ok(eighths.map(|eighths| eighths / 8.0)),
    }
}

impl TryFrom<WeatherMessage> for WeatherEdit {
    type Error = Refused;

    fn try_from(message: WeatherMessage) -> Result<Self, Refused> {
        let WeatherMessage { region, layers, changes, visibility_m, transition_s } = message;
        if region.is_none() && layers.is_none() && changes.is_empty() && visibility_m.is_none() {
            let limit = "at least one of region, layers, changes, visibility_m";
            return Err(Refused::new("layers", "not given", limit, "the message would change nothing"));
        }
        let within =
            |path: String| move |refused: Refused| Refused { field: format!("{path}.{}", refused.field), ..refused };
        let region = region.map(|region| region.try_into().map_err(within("region".into()))).transpose()?;
        let layers = layers
            .map(|layers| {
                let spec = |(k, layer): (usize, LayerJson)| layer.try_into().map_err(within(format!("layers[{k}]")));
                layers.into_iter().enumerate().map(spec).collect::<Result<Vec<LayerSpec>, _>>()
            })
            .transpose()?;
        let change = |(k, change): (usize, LayerChangeJson)| change.try_into().map_err(within(format!("changes[{k}]")));
        let changes = changes.into_iter().enumerate().map(change).collect::<Result<Vec<LayerChange>, _>>()?;
        Ok(Self { region, layers, changes, visibility_m, transition_s })
    }
}

impl From<&WeatherEdit> for WeatherMessage {
    fn from(edit: &WeatherEdit) -> Self {
        Self {
            region: edit.region.as_ref().map(RegionJson::from),
            layers: edit.layers.as_ref().map(|layers| layers.iter().map(LayerJson::from).collect()),
            changes: edit.changes.iter().map(LayerChangeJson::from).collect(),
            visibility_m: edit.visibility_m,
            transition_s: edit.transition_s,
        }
    }
}

impl TryFrom<LayerJson> for LayerSpec {
    type Error = Refused;

    fn try_from(layer: LayerJson) -> Result<Self, Refused> {
        let Some(coverage) = coverage(layer.coverage, layer.coverage_eighths)? else {
            return Err(Refused::new("coverage", "not given", "0 to 1", "give coverage or coverage_eighths"));
        };
        Ok(Self {
            kind: layer.cloud_type.into(),
            base_m: layer.base_m,
            thickness_m: layer.thickness_m,
            coverage,
            density: layer.density,
            wind_speed_mps: layer.wind_speed_mps,
            wind_from_deg: layer.wind_from_deg,
        })
    }
}

impl From<&LayerSpec> for LayerJson {
    fn from(layer: &LayerSpec) -> Self {
        Self {
            cloud_type: layer.kind.into(),
            base_m: layer.base_m,
            thickness_m: layer.thickness_m,
            coverage: Some(layer.coverage),
            coverage_eighths: None,
            density: layer.density,
            wind_speed_mps: layer.wind_speed_mps,
            wind_from_deg: layer.wind_from_deg,
        }
    }
}

impl TryFrom<LayerChangeJson> for LayerChange {
    type Error = Refused;

    fn try_from(change: LayerChangeJson) -> Result<Self, Refused> {
        Ok(Self {
            index: change.index as usize,
            kind: change.cloud_type.map(Into::into),
            base_m: change.base_m,
            thickness_m: change.thickness_m,
            coverage: coverage(change.coverage, change.coverage_eighths)?,
            density: change.density,
            wind_speed_mps: change.wind_speed_mps,
            wind_from_deg: change.wind_from_deg,
        })
    }
}

impl From<&LayerChange> for LayerChangeJson {
    fn from(change: &LayerChange) -> Self {
        Self {
            index: u32::try_from(change.index).unwrap_or(u32::MAX),
            cloud_type: change.kind.map(Into::into),
            base_m: change.base_m,
            thickness_m: change.thickness_m,
            coverage: change.coverage,
            coverage_eighths: None,
            density: change.density,
            wind_speed_mps: change.wind_speed_mps,
            wind_from_deg: change.wind_from_deg,
        }
    }
}
