//! What a host is told beside pictures: answers and events that follow from a snapshot alone. Pure; no device is asked.

use crate::plan::{FramePlan, Output, plan};
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
    Event::StrikeShown { id, view: view.to_owned(), frame, simulation_time_s: snapshot.simulation_time_s }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::World;
    use crate::world::command::{Command, FlashKind, Polarity, StrikeRequest, Strokes};

    #[test]
    fn a_view_that_is_not_there_is_refused_with_those_that_are() {
        let snapshot = World::new().peek(0.02);
        assert_eq!(view(&snapshot, "main").unwrap().name, "main");
        let refused = plan_of(&snapshot, "tail").unwrap_err();
        assert_eq!((refused.field.as_str(), refused.limit.as_str()), ("view", "one of: main"));
        assert_eq!(plan_of(&snapshot, "main").unwrap().size_px, snapshot.views[0].size_px);
    }

    #[test]
    fn a_flash_is_lit_only_while_it_gives_light() {
        let mut world = World::new();
        let request = StrikeRequest {
            latitude_deg: 47.0,
            longitude_deg: 8.0,
            altitude_m: None,
            at_s: Some(1.0),
            kind: FlashKind::CloudToGround,
            polarity: Polarity::Negative,
            peak_current_ka: Some(30.0),
            strokes: Strokes::Sample,
            seed: 1,
        };
        world.apply(Command::Strike(request)).unwrap();
        assert_eq!(lit(&world.snapshot(0.02)).count(), 0, "a second before");
        world.advance_to(0.99);
        let snapshot = world.snapshot(0.02);
        let ids: Vec<u64> = lit(&snapshot).collect();
        assert_eq!(ids.len(), 1);
        let Event::StrikeShown { id, frame, simulation_time_s, .. } = shown(&snapshot, ids[0], "main", 7) else {
            panic!("another event")
        };
        assert_eq!((id, frame, simulation_time_s), (ids[0], 7, 0.99));
        world.advance_to(100.0);
        assert_eq!(lit(&world.snapshot(0.02)).count(), 0, "long after");
    }
}
