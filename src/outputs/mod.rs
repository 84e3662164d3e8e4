//! What a host is told beside pictures: answers and events that follow from a snapshot alone. Pure; no device is asked.

pub mod air;
pub mod conditions;
pub mod field;
pub mod ground;
pub mod sight;

use crate::plan::{FramePlan, Output, plan};
use crate::world::command::Polarity;
use crate::world::event::{Event, Refused};
use crate::world::snapshot::{Snapshot, ViewState};

/// The view of this name.
///
/// # Errors
/// There is none; the refusal lists those that there are.
pub fn view<'a>(snapshot: &'a Snapshot, name: &str) -> Result<&'a ViewState, Refused> {
    snapshot.views.iter().find(|view| view.name == name).ok_or_else(|| {
        let names: Vec<&str> = snapshot.views.iter().map(|view| view.name.as_str()).collect();
        Refused::new("view", name, format!("one of: {}", names.join(", ")), "there is no view of this name")
    })
}

/// The plan of the next frame of this view.
///
/// # Errors
/// As [`view`].
pub fn plan_of(snapshot: &Snapshot, name: &str) -> Result<FramePlan, Refused> {
    view(snapshot, name).map(|view| plan(snapshot, view, Output::Srgb8))
}

/// Numbers of the flashes that give light in the shutter interval of this snapshot.
pub fn lit(snapshot: &Snapshot) -> impl Iterator<Item = u64> + '_ {
    snapshot.flashes.iter().filter(|flash| flash.intensity_cd > 0.0).map(|flash| flash.id)
}

/// The event for the first frame of a snapshot in which this flash gives light.
pub fn shown(snapshot: &Snapshot, id: u64, view: &str, frame: u64) -> Event {
    let flash = snapshot.flashes.iter().find(|flash| flash.id == id);
    let current_ka = flash.map_or(0.0, |flash| match flash.polarity {
        Polarity::Negative => -flash.peak_current_ka,
        Polarity::Positive => flash.peak_current_ka,
    });
    let simulation_time_s = snapshot.simulation_time_s;
    Event::StrikeShown { id, view: view.to_owned(), frame, simulation_time_s, current_ka }
}
