//! What is not needed is not there: scenes over sea, coast, mountains and cities, by day, night and moon, and what is planned.

use super::*;
use crate::geo::terrain::Terrain;

/// What a plan has of all that a scene may not need.
#[derive(Debug, PartialEq)]
struct Needs {
    /// Rays are followed over heights.
    heights: bool,
    shore: bool,
    lamps: bool,
    glow: bool,
    stars: bool,
    /// The moon gives light, and its disc is there.
    moon: bool,
    shadows: bool,
    /// Regions' code runs.
    regions: bool,
}

const NOTHING: Needs = Needs {
    heights: false,
    shore: false,
    lamps: false,
    glow: false,
    stars: false,
    moon: false,
    shadows: false,
    regions: false,
};

fn needs(snapshot: &Snapshot) -> Needs {
    let plan = plan_of(snapshot);
    let kept = |pass: &str| plan.notes.iter().any(|note| note.pass == pass && note.kept);
    let [_, moon] = &plan.table.lights;
    let (moonlit, disc) = (moon.illuminance_lux.max_element() > 0.0, plan.sky.moon_luminance.iter().any(|l| *l > 0.0));
    let found = Needs {
        heights: plan.terrain(),
        shore: kept("shore"),
        lamps: plan.relief.as_ref().is_some_and(|relief| relief.lights),
        glow: plan.glow.is_some(),
        stars: plan.stars.is_some(),
        moon: moonlit || disc,
        shadows: plan.shadow.is_some(),
        regions: plan.layers.iter().any(|layer| layer.layer.regions > 0),
    };
    // The notes say what the executors get, and without any of the three there are no grids at all.
    assert_eq!([kept("relief"), kept("lamps"), kept("city glow")], [found.heights, found.lamps, found.glow]);
    assert_eq!([kept("stars"), kept("shadow"), kept("region")], [found.stars, found.shadows, found.regions]);
    assert_eq!(plan.relief.is_some(), found.heights || found.shore || found.lamps);
    // City light in the air's table by night alone.
    let cities = plan.table.cities.iter().any(|city| city.radius_m > 0.0);
    assert!(!cities || found.stars, "{found:?}");
    found
}

/// At 3 km over a place with the sun at an elevation; the full moon is 30 degrees below the horizon.
fn over(latitude_deg: f64, longitude_deg: f64, terrain: Terrain, sun_deg: f64) -> Snapshot {
    let mut snapshot = clear_day();
    snapshot.terrain = terrain;
    snapshot.ownship.position = place(latitude_deg, longitude_deg, 3_000.0);
    moon(sun(snapshot, sun_deg), -30.0)
}

fn moon(mut snapshot: Snapshot, elevation_deg: f64) -> Snapshot {
    snapshot.sky.moon_direction_ecef = sun(snapshot.clone(), elevation_deg).sky.sun_direction_ecef;
    snapshot.sky.moon_lit_fraction = 1.0;
    snapshot
}

fn clouded(mut snapshot: Snapshot) -> Snapshot {
    snapshot.weather.layers = vec![layer(CloudKind::Cumulus, 1_000.0, 800.0)];
    snapshot
}

#[test]
fn scenes_have_what_they_need_and_nothing_else() {
    let (level, made) = (|| Terrain::ELLIPSOID, Terrain::procedural);
    let (day, night) = (40.0, -40.0);
    let sea = |sun_deg| over(30.0, -40.0, made(), sun_deg);
    let coast = |sun_deg| over(43.4, 7.1, made(), sun_deg);
    let steppe = |terrain, sun_deg| over(48.5, 68.0, terrain, sun_deg);
    let dark = Needs { stars: true, ..NOTHING };
    let mut in_a_region = clouded(sea(day));
    in_a_region.regions.push(region(30.2, -40.0, 20_000.0, 1_000.0));
    let mut far_region = clouded(sea(day));
    far_region.regions.push(region(-30.0, 100.0, 20_000.0, 1_000.0));
    let mut moon_put_out = moon(sea(night), 40.0);
    moon_put_out.sky.moon_shines = false;
    let cases: [(&str, Snapshot, Needs); 18] = [
        ("sea by day", sea(day), NOTHING),
        ("sea by night", sea(night), dark),
        ("sea by night under clouds", clouded(sea(night)), Needs { stars: true, ..NOTHING }),
        ("sea by moonlight", moon(sea(night), 40.0), Needs { moon: true, stars: true, ..NOTHING }),
        (
            "clouds by moonlight",
            clouded(moon(sea(night), 40.0)),
            Needs { moon: true, stars: true, shadows: true, ..NOTHING },
        ),
        ("the moon put out", moon_put_out, Needs { stars: true, ..NOTHING }),
        ("the moon by day, its disc alone", moon(sea(day), 30.0), Needs { moon: true, ..NOTHING }),
        ("clouds by day at sea", clouded(sea(day)), Needs { shadows: true, ..NOTHING }),
        ("a region in sight", in_a_region, Needs { shadows: true, regions: true, ..NOTHING }),
        ("a region out of sight", far_region, Needs { shadows: true, ..NOTHING }),
        ("coast by day", coast(day), Needs { heights: true, shore: true, ..NOTHING }),
        ("coast by night", coast(night), Needs { heights: true, shore: true, lamps: true, stars: true, ..NOTHING }),
        (
            "clouds at the coast by night",
            clouded(coast(night)),
            Needs { heights: true, shore: true, lamps: true, glow: true, stars: true, ..NOTHING },
        ),
        ("coast by day on the ellipsoid", over(43.4, 7.1, level(), day), Needs { shore: true, ..NOTHING }),
        ("steppe by day on the ellipsoid", steppe(level(), day), NOTHING),
        ("steppe by day", steppe(made(), day), Needs { heights: true, ..NOTHING }),
        (
            "clouds over the steppe by day",
            clouded(steppe(made(), day)),
            Needs { heights: true, shadows: true, ..NOTHING },
        ),
        ("the north pole by night", over(90.0, 0.0, made(), night), Needs { stars: true, ..NOTHING }),
    ];
    for (name, snapshot, expected) in cases {
        assert_eq!(needs(&snapshot), expected, "{name}");
    }
}
