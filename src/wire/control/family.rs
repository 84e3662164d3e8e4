//! The message families: one line each, from which the schema, the check and the decoder are made.

use super::ownship::OwnshipMessage;
use super::region::RemoveRegionMessage;
use super::scenario::ScenarioMessage;
use super::session::{HelloMessage, QueryMessage, StepMessage, SubscribeMessage, UnsubscribeMessage};
use super::storm::{RemoveStormMessage, StormMessage};
use super::strike::StrikeMessage;
use super::time::TimeMessage;
use super::view::{ViewMessage, ViewName};
use super::weather::WeatherMessage;
use super::{Hello, Message, Subscription};
use crate::world::command::{Command, StormRequest, StrikeRequest, TimeEdit, WeatherEdit};
use crate::world::event::Refused;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// One value of `type`.
pub struct Family {
    /// The value.
    pub name: &'static str,
    /// Whether a scenario's entries may hold it.
    pub in_scenario: bool,
    /// The schema of its fields, without `type` and `seq`.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
    /// From its fields, which have passed the check.
    pub decode: fn(Value) -> Result<Message, Refused>,
}

/// All of them, in the order in which the documentation tells them.
pub const FAMILIES: &[Family] = &[
    family::<HelloMessage>("hello", false, |fields| {
        Hello::try_from(serde::<HelloMessage>(fields)?).map(Message::Hello)
    }),
    family::<OwnshipMessage>("ownship", true, |fields| {
        Ok(Message::Command(Command::Ownship(serde::<OwnshipMessage>(fields)?.into())))
    }),
    family::<WeatherMessage>("weather", true, |fields| {
        WeatherEdit::try_from(serde::<WeatherMessage>(fields)?).map(|edit| Message::Command(Command::Weather(edit)))
    }),
    family::<RemoveRegionMessage>("remove_region", true, |fields| {
        let RemoveRegionMessage { name, transition_s } = serde(fields)?;
        Ok(Message::Command(Command::RemoveRegion { name, transition_s }))
    }),
    family::<TimeMessage>("time", true, |fields| {
        TimeEdit::try_from(serde::<TimeMessage>(fields)?).map(|edit| Message::Command(Command::Time(edit)))
    }),
    family::<ViewMessage>("view", true, |fields| Ok(Message::Command(serde::<ViewMessage>(fields)?.into()))),
    family::<StrikeMessage>("strike", true, |fields| {
        StrikeRequest::try_from(serde::<StrikeMessage>(fields)?)
            .map(|request| Message::Command(Command::Strike(request)))
    }),
    family::<StormMessage>("storm", true, |fields| {
        StormRequest::try_from(serde::<StormMessage>(fields)?).map(|request| Message::Command(Command::Storm(request)))
    }),
    family::<RemoveStormMessage>("remove_storm", true, |fields| {
        let RemoveStormMessage { name } = serde(fields)?;
        Ok(Message::Command(Command::RemoveStorm { name }))
    }),
    family::<ScenarioMessage>("scenario", false, |fields| serde::<ScenarioMessage>(fields)?.try_into()),
    family::<SubscribeMessage>("subscribe", false, |fields| {
        Subscription::try_from(serde::<SubscribeMessage>(fields)?).map(Message::Subscribe)
    }),
    family::<UnsubscribeMessage>("unsubscribe", false, |fields| {
        let UnsubscribeMessage { view } = serde(fields)?;
        Ok(Message::Unsubscribe { view })
    }),
    family::<StepMessage>("step", false, |fields| {
        let StepMessage { to_s } = serde(fields)?;
        Ok(Message::Step { to_s })
    }),
    family::<QueryMessage>("query", false, |fields| Ok(Message::Query(serde::<QueryMessage>(fields)?.into()))),
];

const fn family<T: JsonSchema>(
    name: &'static str,
    in_scenario: bool,
    decode: fn(Value) -> Result<Message, Refused>,
) -> Family {
    Family { name, in_scenario, schema: T::json_schema, decode }
}

/// The name of a message's family and its fields, without `seq`.
pub fn encode(message: &Message) -> (&'static str, Value) {
    match message {
        Message::Hello(hello) => ("hello", json(&HelloMessage::from(hello))),
        Message::Command(command) => encode_command(command),
        Message::LoadScenario { name } => {
            let fields = super::scenario::LoadFields { name: Some(name.clone()), document: None };
            ("scenario", json(&ScenarioMessage::Load(fields)))
        }
        Message::Subscribe(subscription) => ("subscribe", json(&SubscribeMessage::from(subscription))),
        Message::Unsubscribe { view } => ("unsubscribe", json(&UnsubscribeMessage { view: view.clone() })),
        Message::Step { to_s } => ("step", json(&StepMessage { to_s: *to_s })),
        Message::Query(query) => ("query", json(&QueryMessage::from(query))),
    }
}

/// The name of a command's family and its fields.
pub fn encode_command(command: &Command) -> (&'static str, Value) {
    match command {
        Command::Ownship(ownship) => ("ownship", json(&OwnshipMessage::from(ownship))),
        Command::Weather(edit) => ("weather", json(&WeatherMessage::from(edit))),
        Command::RemoveRegion { name, transition_s } => {
            ("remove_region", json(&RemoveRegionMessage { name: name.clone(), transition_s: *transition_s }))
        }
        Command::Time(edit) => ("time", json(&TimeMessage::from(edit))),
        Command::View(edit) => ("view", json(&ViewMessage::from(edit))),
        Command::RemoveView { name } => ("view", json(&ViewMessage::Remove(ViewName { name: name.clone() }))),
        Command::Strike(request) => ("strike", json(&StrikeMessage::from(request))),
        Command::Storm(request) => ("storm", json(&StormMessage::from(request))),
        Command::RemoveStorm { name } => ("remove_storm", json(&RemoveStormMessage { name: name.clone() })),
        Command::Scenario(edit) => ("scenario", json(&ScenarioMessage::from(edit))),
        // Said by CIGI hosts alone: there is no such message, and a server would refuse it.
        Command::Entity { .. } => ("entity", Value::Null),
        Command::Sky(_) => ("sky", Value::Null),
    }
}

/// The type of our own from its fields. The check has passed, so an error here says that schema and type disagree; it is
/// still an answer and not a panic.
fn serde<T: DeserializeOwned>(fields: Value) -> Result<T, Refused> {
    serde_json::from_value(fields).map_err(|error| Refused::new("", error, "the published schema", "cannot be read"))
}

/// The JSON of a type of our own. None of them has a map with other keys than texts, which is all that could fail.
fn json<T: Serialize>(fields: &T) -> Value {
    serde_json::to_value(fields).unwrap_or_default()
}
