//! Answers that follow from a snapshot alone, without a server. (Here, because `outputs` itself knows no world.)

use stormdeck::outputs::{lit, plan_of, shown, view};
use stormdeck::world::World;
use stormdeck::world::command::{Command, FlashKind, Polarity, StrikeRequest, Strokes};
use stormdeck::world::event::Event;

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
        leader: false,
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
