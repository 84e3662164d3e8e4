//! `view`: create, change and remove views.

use crate::wire::limits;
use crate::world::command::{Command, Exposure, ViewAction, ViewEdit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Makes, changes or removes a view. Only the host may send it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "action", rename_all = "snake_case")]
pub enum ViewMessage {
    /// Makes a view; what is not given takes its default.
    Create(ViewFields),
    /// Changes what is given of a view.
    Change(ViewFields),
    /// Removes a view and ends its subscriptions.
    Remove(ViewName),
}

/// The name alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViewName {
    /// The view's name: letters, digits, `-` and `_`.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub name: String,
}

/// The name and what a view has besides.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViewFields {
    /// The view's name: letters, digits, `-` and `_`.
    #[schemars(length(min = limits::NAME_LENGTH.min, max = limits::NAME_LENGTH.max), regex(pattern = limits::NAME_PATTERN))]
    pub name: String,
    /// Width and height in pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(range(min = limits::SIZE_PX.min, max = limits::SIZE_PX.max)))]
    pub size_px: Option<[u32; 2]>,
    /// Horizontal field of view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::FIELD_OF_VIEW_DEG.min, max = limits::FIELD_OF_VIEW_DEG.max))]
    pub field_of_view_deg: Option<f64>,
    /// Eye point in body axes, forward, right and down.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(range(min = limits::OFFSET_M.min, max = limits::OFFSET_M.max)))]
    pub offset_m: Option<[f64; 3]>,
    /// Yaw of the view against the body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::YAW_DEG.min, max = limits::YAW_DEG.max))]
    pub yaw_deg: Option<f64>,
    /// Pitch of the view against the body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::PITCH_DEG.min, max = limits::PITCH_DEG.max))]
    pub pitch_deg: Option<f64>,
    /// Roll of the view against the body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::ROLL_DEG.min, max = limits::ROLL_DEG.max))]
    pub roll_deg: Option<f64>,
    /// Whether the own ship's landing lights shine, seen in cloud and haze.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landing_light: Option<bool>,
    /// Whether its strobes flash, seen in cloud and haze.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strobe: Option<bool>,
    /// Exposure value at ISO 100, or `"automatic"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure_ev100: Option<ExposureJson>,
}

/// Exposure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ExposureJson {
    /// A word.
    Word(AutomaticWord),
    /// Exposure value at ISO 100.
    Ev100(
        /// Exposure value.
        #[schemars(range(min = limits::EV100.min, max = limits::EV100.max))]
        f64,
    ),
}

/// The word `automatic`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AutomaticWord {
    /// From the scene's illuminance.
    Automatic,
}

impl From<ViewMessage> for Command {
    fn from(message: ViewMessage) -> Self {
        match message {
            ViewMessage::Create(fields) => Self::View(fields.edit(ViewAction::Create)),
            ViewMessage::Change(fields) => Self::View(fields.edit(ViewAction::Change)),
            ViewMessage::Remove(view) => Self::RemoveView { name: view.name },
        }
    }
}

impl From<&ViewEdit> for ViewMessage {
    fn from(edit: &ViewEdit) -> Self {
        let fields = ViewFields {
            name: edit.name.clone(),
            size_px: edit.size_px,
            field_of_view_deg: edit.field_of_view_deg,
            offset_m: edit.offset_m,
            yaw_deg: edit.yaw_deg,
            pitch_deg: edit.pitch_deg,
            roll_deg: edit.roll_deg,
            landing_light: edit.landing_light,
            strobe: edit.strobe,
            exposure_ev100: edit.exposure.map(Into::into),
        };
        match edit.action {
            ViewAction::Create => Self::Create(fields),
            ViewAction::Change => Self::Change(fields),
        }
    }
}

impl ViewFields {
    fn edit(self, action: ViewAction) -> ViewEdit {
        ViewEdit {
            action,
            name: self.name,
            size_px: self.size_px,
            field_of_view_deg: self.field_of_view_deg,
            offset_m: self.offset_m,
            yaw_deg: self.yaw_deg,
            pitch_deg: self.pitch_deg,
            roll_deg: self.roll_deg,
            landing_light: self.landing_light,
            strobe: self.strobe,
            exposure: self.exposure_ev100.map(Into::into),
            // Said by CIGI hosts alone.
            frustum: None,
            mirror: None,
            entity: None,
        }
    }
}

impl From<ExposureJson> for Exposure {
    fn from(exposure: ExposureJson) -> Self {
        match exposure {
            ExposureJson::Word(AutomaticWord::Automatic) => Self::Automatic,
            ExposureJson::Ev100(ev100) => Self::Ev100(ev100),
        }
    }
}

impl From<Exposure> for ExposureJson {
    fn from(exposure: Exposure) -> Self {
        match exposure {
            Exposure::Automatic => Self::Word(AutomaticWord::Automatic),
            Exposure::Ev100(ev100) => Self::Ev100(ev100),
        }
    }
}
