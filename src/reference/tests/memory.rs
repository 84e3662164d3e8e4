//! What a scene does not need is not in memory: a table of scenes and of what an executor holds after them.

use super::*;
use crate::geo::terrain::Terrain;
use crate::plan::executor::PATIENCE;
use crate::plan::scenes::{clear_day, sun};
use crate::world::snapshot::Snapshot;

/// Over a place, level or made ground, the sun at an elevation and the moon put out, with cumulus or without.
fn scene(at: (f64, f64), terrain: Terrain, sun_deg: f64, cloud: bool) -> Snapshot {
    let mut snapshot = if cloud { cumulus_at(place(at.0, at.1, 600.0)) } else { clear_day() };
    snapshot.ownship.position = place(at.0, at.1, 600.0);
    snapshot.terrain = terrain;
    snapshot = sun(snapshot, sun_deg);
    snapshot.sky.moon_shines = false;
    snapshot
}

fn after(executor: &mut ReferenceExecutor, snapshot: &Snapshot) -> Vec<&'static str> {
    executor.draw(&plan(snapshot, &snapshot.views[0], Output::Srgb8));
    executor.held().into_iter().map(|(name, _)| name).collect()
}

const ATLANTIC: (f64, f64) = (30.0, -40.0);
const STEPPE: (f64, f64) = (48.5, 68.0);
const PARIS: (f64, f64) = (48.857, 2.352);

#[test]
fn each_scene_holds_what_it_needs_and_nothing_else() {
    let made = Terrain::procedural;
    let (sky, cloud) = (["sky table"].as_slice(), ["light in clouds", "empty space in clouds"].as_slice());
    let (shadows, heights, lamps, glow) = (["shadows"], ["heights and shores"], ["lamps"], ["city glow"]);
    let cases: [(&str, Snapshot, &[&[&str]]); 8] = [
        ("clear day at sea", scene(ATLANTIC, made(), 40.0, false), &[sky]),
        ("clear night at sea", scene(ATLANTIC, made(), -40.0, false), &[sky]),
        ("clear day over level steppe", scene(STEPPE, Terrain::ELLIPSOID, 40.0, false), &[sky]),
        ("clouds by day at sea", scene(ATLANTIC, made(), 40.0, true), &[sky, cloud, &shadows]),
        ("clouds by night at sea", scene(ATLANTIC, made(), -40.0, true), &[sky, cloud]),
        ("clear day over Paris", scene(PARIS, made(), 40.0, false), &[sky, &heights]),
        ("clear night over Paris", scene(PARIS, made(), -40.0, false), &[sky, &heights, &lamps]),
        ("clouds by night over Paris", scene(PARIS, made(), -40.0, true), &[sky, cloud, &heights, &lamps, &glow]),
    ];
    for (name, snapshot, expected) in cases {
        assert_eq!(after(&mut ReferenceExecutor::new(), &snapshot), expected.concat(), "{name}");
    }
}

#[test]
fn what_is_no_longer_needed_is_forgotten() {
    let mut executor = ReferenceExecutor::new();
    let city = after(&mut executor, &scene(PARIS, Terrain::procedural(), -40.0, true));
    assert!(city.contains(&"lamps") && city.contains(&"light in clouds") && city.contains(&"heights and shores"));
    let sea = scene(ATLANTIC, Terrain::procedural(), 40.0, false);
    let fresh = after(&mut ReferenceExecutor::new(), &sea);
    // Cities at once; what would be dear to make again when a look aside or another view has done without it for long.
    let first = after(&mut executor, &sea);
    assert!(
        !first.contains(&"lamps") && !first.contains(&"city glow") && first.contains(&"light in clouds"),
        "{first:?}"
    );
    for _ in 1..PATIENCE {
        after(&mut executor, &sea);
    }
    assert_eq!(after(&mut executor, &sea), fresh);
}
