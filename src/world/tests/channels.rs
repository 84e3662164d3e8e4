//! Channels of flashes in snapshots: waited for, or not; one for each flash, and none when it is over.

use super::*;
use crate::lightning::strike::StrikeChannel;

fn channel(snapshot: &Snapshot) -> Option<Arc<StrikeChannel>> {
    assert_eq!(snapshot.flashes.len(), 1);
    snapshot.flashes[0].channel.clone()
}

#[test]
fn a_snapshot_waits_for_channels_and_one_at_once_does_not() {
    let mut world = World::new();
    world.apply(Command::Strike(strike())).expect("a good strike");
    let early = world.snapshot_at_once(0.01);
    assert!(channel(&early).is_none() && early.provisional());
    assert!(channel(&world.peek(0.01)).is_none(), "a look grows nothing");
    let shown = world.snapshot(0.01);
    let first = channel(&shown).expect("waited for");
    assert!(!shown.provisional());
    assert!(world.take_growing().is_empty(), "nothing is left to be grown");
    let again = channel(&world.snapshot_at_once(0.01)).expect("there by now");
    assert!(Arc::ptr_eq(&first, &again), "all pictures share it");
    let weak = Arc::downgrade(&first);
    let end_s = shown.flashes[0].end_s;
    drop((first, again, shown));
    world.advance_to(end_s);
    assert!(world.snapshot(0.01).flashes.is_empty());
    assert!(weak.upgrade().is_none(), "it goes with its flash");
}

#[test]
fn whoever_takes_a_channel_to_grow_gives_it_to_the_next_picture() {
    let mut world = World::new();
    world.apply(Command::Strike(strike())).expect("a good strike");
    let growing = world.take_growing();
    assert_eq!(growing.len(), 1, "known as soon as the strike is accepted");
    let grown = growing[0].grow().expect("a right specification");
    let shown = channel(&world.snapshot_at_once(0.01)).expect("grown");
    assert!(Arc::ptr_eq(&grown, &shown));
}

#[test]
fn a_scenario_grows_the_same_channel_however_it_is_played() {
    let entries = vec![TimedCommand { at_s: 1.003, command: Command::Strike(strike()) }];
    let timeline = Timeline { duration_s: 9.0, entries, ..Default::default() };
    // In the middle of a frame: the look ahead and the flash itself share a channel.
    let mut world = loaded(timeline.clone());
    world.advance_to(1.0);
    let ahead = channel(&world.snapshot(1.0 / 60.0)).expect("seen ahead of its entry");
    world.advance_to(1.0 + 1.0 / 60.0);
    let shown = channel(&world.snapshot(1.0 / 60.0)).expect("shown");
    assert!(Arc::ptr_eq(&ahead, &shown), "grown once");
    // Again from the start, and in other steps.
    world.apply(Command::Scenario(ScenarioEdit::Seek { at_s: 1.01 })).expect("a time inside");
    assert_eq!(channel(&world.snapshot(0.01)).as_ref(), Some(&shown), "every repetition has the same");
    let mut other = loaded(timeline);
    other.advance_to(1.02);
    assert_eq!(channel(&other.snapshot(0.002)), Some(shown));
}
