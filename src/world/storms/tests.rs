//! Storms: the same flashes however time went, states that rule one after another, and what they tell.

use super::*;
use crate::world::World;
use crate::world::command::{Command, ScenarioEdit};
use crate::world::limits::MAX_STORMS;
use crate::world::timeline::{TimedCommand, Timeline};
use std::collections::BTreeSet;
use std::sync::Arc;

fn request(name: &str) -> StormRequest {
    StormRequest {
        name: name.into(),
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        size_east_m: 30_000.0,
        size_north_m: 10_000.0,
        corner_radius_m: 5_000.0,
        rotation_deg: 30.0,
        altitude_m: Some(5_000.0),
        flashes_per_minute: 120.0,
        inside_share: 0.75,
        positive_share: 0.1,
        current_factor: 1.0,
        seed: 4,
    }
}

fn world(storm: StormRequest) -> World {
    let mut world = World::new();
    world.apply(Command::Storm(storm)).unwrap();
    world
}

/// Numbers of all flashes with light in the frames from 0 on.
fn seen(world: &mut World, frames: u32, rate_hz: f64) -> BTreeSet<u64> {
    let mut ids = BTreeSet::new();
    for frame in 0..frames {
        world.advance_to(f64::from(frame) / rate_hz);
        let lit = world.peek(1.0 / rate_hz).flashes;
        ids.extend(lit.iter().filter(|flash| flash.intensity_cd > 0.0).map(|flash| flash.id));
    }
    ids
}

#[test]
fn a_storm_is_the_same_at_any_rate_in_one_leap_and_after_a_seek() {
    let at_30 = seen(&mut world(request("cell")), 1_200, 30.0);
    assert!(at_30.len() > 5 && at_30.iter().all(|id| is_of_storm(*id)), "{at_30:?}");
    assert_eq!(at_30, seen(&mut world(request("cell")), 4_800, 120.0));
    let mut stepped = world(request("cell"));
    seen(&mut stepped, 300, 30.0);
    let mut leapt = world(request("cell"));
    stepped.advance_to(50.0);
    leapt.advance_to(50.0);
    assert_eq!(stepped.peek(20.0).flashes, leapt.peek(20.0).flashes);
    assert!(!leapt.peek(20.0).flashes.is_empty());

    let entries = vec![TimedCommand { at_s: 0.0, command: Command::Storm(request("cell")) }];
    let timeline = Timeline { duration_s: 99.0, entries, ..Default::default() };
    let mut world = World::new();
    world.apply(Command::Scenario(ScenarioEdit::Load(Arc::new(timeline)))).unwrap();
    world.advance_to(90.0);
    world.apply(Command::Scenario(ScenarioEdit::Seek { at_s: 50.0 })).unwrap();
    assert_eq!(world.peek(20.0).flashes, leapt.peek(20.0).flashes);
    let mut other = self::world(request("other"));
    other.advance_to(50.0);
    assert_ne!(other.peek(20.0).flashes, leapt.peek(20.0).flashes, "storms of other names have other flashes");
}

#[test]
fn flashes_lie_inside_the_extent_at_their_height_and_give_light() {
    let world = world(request("cell"));
    let shape = crate::world::command::RegionShape {
        name: "cell".into(),
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        size_east_m: 30_000.0,
        size_north_m: 10_000.0,
        corner_radius_m: 5_000.0,
        rotation_deg: 30.0,
        transition_m: 0.0,
    };
    let flashes = world.peek(3600.0).flashes;
    assert!(flashes.len() > 3_000);
    for flash in &flashes {
        // The outline is measured on a sphere that fits the Earth at the centre: some metres at 15 km.
        let outside_m = crate::world::regions::signed_distance_m(&shape, &flash.position);
        assert!(outside_m < 20.0 && flash.position.altitude_m == 5_000.0, "{flash:?}");
        assert!(flash.intensity_cd > 0.0 || flash.end_s > 3600.0);
    }
    let at_pole =
        World::clone(&self::world(StormRequest { latitude_deg: 90.0, ..request("pole") })).peek(600.0).flashes;
    // 15.8 km from the pole at most: half of the extent's diagonal.
    assert!(at_pole.iter().all(|flash| flash.position.latitude_rad.to_degrees() > 89.85));
    assert!(at_pole.len() > 200);
}

#[test]
fn a_change_leaves_what_is_under_way_and_what_is_said_again_goes_on() {
    let mut world = world(request("cell"));
    // A moment at which something shines.
    world.advance_to((0..).map(|k| 0.5 * f64::from(k)).find(|&t| lit(&world, t)).unwrap());
    let before = world.peek(0.01).flashes;
    world.apply(Command::Storm(request("cell"))).unwrap();
    assert_eq!(world.peek(0.01).flashes, before, "said again it goes on");
    world.apply(Command::Storm(StormRequest { flashes_per_minute: 0.0, ..request("cell") })).unwrap();
    assert_eq!(world.peek(0.01).flashes, before, "begun under the storm as it was");
    assert!(world.peek(60.0).flashes.iter().all(|flash| flash.begin_s <= world.simulation_time_s()), "no new ones");
    world.apply(Command::RemoveStorm { name: "cell".into() }).unwrap();
    assert_eq!((world.peek(0.01).flashes, world.peek(0.01).storms.len()), (before, 0));
    assert_eq!(world.apply(Command::RemoveStorm { name: "cell".into() }).unwrap_err().field, "name");
}

fn lit(world: &World, at_s: f64) -> bool {
    let mut ahead = world.clone();
    ahead.advance_to(at_s);
    ahead.peek(0.01).flashes.iter().any(|flash| flash.intensity_cd > 0.0)
}

#[test]
fn every_flash_that_was_seen_is_told_when_it_is_over_and_a_leap_costs_little() {
    let mut world = world(request("cell"));
    let seen = seen(&mut world, 300, 30.0);
    let mut told: BTreeSet<u64> = world.finished_flashes().into_iter().collect();
    world.advance_to(20.0);
    told.extend(world.finished_flashes());
    assert!(seen.is_subset(&told), "{seen:?} {told:?}");
    assert_eq!(world.finished_flashes(), [0_u64; 0], "once");
    // Ten years on: what was under way at the leap and what ended in the last minute.
    let under_way: BTreeSet<u64> = world.peek(0.02).flashes.iter().map(|flash| flash.id).collect();
    world.advance_to(3e8);
    let told: BTreeSet<u64> = world.finished_flashes().into_iter().collect();
    assert!(under_way.is_subset(&told) && told.len() < 600, "{}", told.len());
}

#[test]
fn a_storm_that_follows_an_aircraft_leaves_no_trail_of_states() {
    let mut storms = Storms::default();
    for k in 0..1_000 {
        let now_s = 0.1 * f64::from(k);
        storms.edit(&StormRequest { latitude_deg: 0.001 * f64::from(k), ..request("cell") }, now_s).unwrap();
        storms.take_finished(now_s);
        // A state is kept while a flash of it may be under way: one edit in each tenth of a second, and the one that rages.
        assert!(storms.states.len() as f64 <= 10.0 * LONGEST_FLASH_S + 2.0, "{k}: {}", storms.states.len());
    }
    assert_eq!(storms.raging().count(), 1);
}

#[test]
fn storms_out_of_bounds_are_refused() {
    let mut world = World::new();
    for (bad, field) in [
        (StormRequest { name: "a b".into(), ..request("x") }, "name"),
        (StormRequest { latitude_deg: 91.0, ..request("x") }, "latitude_deg"),
        (StormRequest { longitude_deg: f64::NAN, ..request("x") }, "longitude_deg"),
        (StormRequest { size_east_m: 0.0, ..request("x") }, "size_east_m"),
        (StormRequest { size_north_m: 1e9, ..request("x") }, "size_north_m"),
        (StormRequest { corner_radius_m: 5_001.0, ..request("x") }, "corner_radius_m"),
        (StormRequest { rotation_deg: f64::INFINITY, ..request("x") }, "rotation_deg"),
        (StormRequest { altitude_m: Some(-1.0), ..request("x") }, "altitude_m"),
        (StormRequest { flashes_per_minute: 601.0, ..request("x") }, "flashes_per_minute"),
        (StormRequest { inside_share: 1.1, ..request("x") }, "inside_share"),
        (StormRequest { positive_share: -0.1, ..request("x") }, "positive_share"),
        (StormRequest { current_factor: 0.0, ..request("x") }, "current_factor"),
    ] {
        assert_eq!(world.apply(Command::Storm(bad)).unwrap_err().field, field);
    }
    for k in 0..MAX_STORMS {
        world.apply(Command::Storm(request(&format!("s{k}")))).unwrap();
    }
    assert_eq!(world.apply(Command::Storm(request("more"))).unwrap_err().field, "storm");
    world.apply(Command::Storm(StormRequest { seed: 9, ..request("s3") })).unwrap();
    assert_eq!(world.peek(0.0).storms.len(), MAX_STORMS);
}
