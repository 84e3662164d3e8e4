//! Which grids of heights a picture needs: those around the eye, or none where nothing but sea is in sight.

use super::PassNote;
use super::eye::Eye;
use crate::geo::charts::ChartView;
use crate::geo::cities::near;
use crate::geo::coast::coarse_shore_m;
use crate::geo::frames::Curvature;
use crate::geo::terrain::HIGHEST_M;
use crate::geo::wgs84::{MEAN_RADIUS_M, from_ecef};
use crate::passes::deck::glow::{CityGlow, GlowWindow};
use crate::passes::relief::window::Window;
use crate::passes::relief::{LEVELS, Relief};
use crate::world::snapshot::Snapshot;
use glam::{DVec2, DVec3};

/// Spacing of the first level's nodes at most heights: a hill of the terrain has two of them.
const SPACING_M: f64 = 30.0;
/// Nodes that a level reaches from the eye, wherever in its middle tile that is.
const REACH_NODES: f64 = 152.0;
/// Land is looked for on circles so far apart: what is told of the shore reaches 100 km.
const SEARCH_M: f64 = 120_000.0;
/// Cities whose lamps are looked for at least so far, and whose light on clouds is.
const LAMPS_M: f64 = 30_000.0;
const GLOW_REACH_M: f64 = 300_000.0;
/// Nearer than this to a place that was looked at the shore is in sight.
const NEAR_M: f64 = 80_000.0;
/// Highest ground that is looked for behind the horizon of the sea.
const CREST_M: f64 = 4_000.0;

/// Heights around the eye.
#[derive(Clone, Debug, PartialEq)]
pub struct ReliefPlan {
    /// Parameters of the pass. The height that no ground exceeds is that of all ground: an executor lowers it.
    pub relief: Relief,
    /// What the grids are made from.
    pub window: Window,
    /// Whether the ground is anywhere else than on the ellipsoid, so that rays have to be followed.
    pub rays: bool,
    /// Whether lamps of cities are in sight.
    pub lights: bool,
}

/// The glow of cities on clouds.
#[derive(Clone, Debug, PartialEq)]
pub struct GlowPlan {
    /// Parameters of the deck pass.
    pub glow: CityGlow,
    /// What the table is made from.
    pub window: GlowWindow,
}

/// The glow on the clouds of a plan; `None`: by day, without clouds, far from all cities. `night`: how much of the lamps is lit.
pub fn glow(snapshot: &Snapshot, eye: &Eye, night: f32, clouds: bool, notes: &mut Vec<PassNote>) -> Option<GlowPlan> {
    let lamps = night > 0.0;
    let cities = lamps && clouds && !near(eye.zenith, GLOW_REACH_M).is_empty();
    let why = match (lamps, clouds, cities) {
        (false, ..) => "by day no lamp is lit",
        (_, false, _) => "there is no cloud to glow",
        (_, _, false) => "no city is near",
        _ => "cities light the clouds from below",
    };
    notes.push(PassNote { pass: "city glow", kept: cities, why: why.into() });
    cities.then(|| {
        let chart = Lying::of(eye);
        let window = GlowWindow::around(snapshot.terrain.clone(), chart.view.chart, chart.view.origin_m);
        let origin = window.share(chart.view.origin_m).as_vec2().into();
        let Lying { a, c, stretch, .. } = chart;
        GlowPlan { glow: CityGlow { a, c, stretch, origin, strength: night, pad0: 0.0 }, window }
    })
}

/// The relief in sight; `None`: only sea is, or only land without heights and lamps. `lamps`: whether those of cities are lit.
pub fn in_sight(snapshot: &Snapshot, eye: &Eye, lamps: bool, notes: &mut Vec<PassNote>) -> Option<ReliefPlan> {
    let mut note = |pass, kept, why: &str| notes.push(PassNote { pass, kept, why: why.into() });
    let reach = |height_m: f64| (2.0 * eye.earth_m * height_m).sqrt();
    let rays = !snapshot.terrain.is_ellipsoid();
    let range_m = reach(eye.height_m) + if rays { reach(CREST_M) } else { 0.0 };
    let (land, coast) = surface(eye, range_m);
    let why = match (land, coast) {
        (_, true) => "there is a shore in sight",
        (true, false) => "there is only land in sight",
        (false, false) => "there is only sea in sight",
    };
    note("shore", coast, why);
    note(
        "relief",
        land && rays,
        match (land, rays) {
            (false, _) => why,
            (true, false) => "the ground is the bare ellipsoid",
            (true, true) => "the ground has heights",
        },
    );
    let lights = land && lamps && !near(eye.zenith, reach(eye.height_m).max(LAMPS_M)).is_empty();
    note(
        "lamps",
        lights,
        match (lamps, lights) {
            (false, _) => "by day no lamp is lit",
            (true, false) => "no city is in sight",
            (true, true) => "cities are in sight",
        },
    );
    (coast || rays && land || lights).then(|| ReliefPlan { lights, ..around(snapshot, eye, reach(eye.height_m), rays) })
}

fn around(snapshot: &Snapshot, eye: &Eye, horizon_m: f64, rays: bool) -> ReliefPlan {
    let Lying { view, a, c, stretch } = Lying::of(eye);
    let reach_m = |spacing_m: f64| REACH_NODES * spacing_m * (1u32 << (LEVELS - 1)) as f64;
    let mut spacing_m = SPACING_M;
    while reach_m(spacing_m) < horizon_m && spacing_m < 16.0 * SPACING_M {
        spacing_m *= 2.0;
    }
    let window = Window::around(snapshot.terrain.clone(), view.chart, view.origin_m, spacing_m);
    let level = std::array::from_fn(|level| {
        let at = window.nodes(level, view.origin_m);
        [at.x, at.y, window.level_spacing_m(level), window.shore_unit_m(level)].map(|v| v as f32)
    });
    let relief = Relief { a, c, stretch, spacing_m: window.spacing_m as f32, highest_m: HIGHEST_M as f32, level };
    ReliefPlan { relief, window, rays, lights: false }
}

/// How the chart nearest to the eye lies about it.
struct Lying {
    view: ChartView,
    a: [f32; 2],
    c: [f32; 2],
    stretch: [f32; 2],
}

impl Lying {
    fn of(eye: &Eye) -> Self {
        let view = eye.nearest_chart();
        // Charts lie on the sphere of the mean radius; the eye's sphere has the mean of two curvatures that differ.
        let to_mean_sphere = MEAN_RADIUS_M / eye.earth_m;
        let curvature = Curvature::at(eye.position.latitude_rad);
        let narrow = |v: DVec2| (v * to_mean_sphere).as_vec2().into();
        let stretch = [eye.earth_m / curvature.prime_vertical_m, eye.earth_m / curvature.meridian_m].map(|v| v as f32);
        Self { view, a: narrow(view.a), c: narrow(view.c), stretch }
    }
}

/// Whether there is land within a range of the eye, and whether there is a shore, found on circles around it.
fn surface(eye: &Eye, range_m: f64) -> (bool, bool) {
    let shore_m = |offset_m: DVec2| {
        let place = from_ecef(eye.ground_ecef_m + eye.enu * DVec3::new(offset_m.x, offset_m.y, 0.0));
        coarse_shore_m(place.latitude_rad, place.longitude_rad, SEARCH_M)
    };
    let circles = (range_m / SEARCH_M).ceil() as u32;
    let (mut land, mut coast) = (false, false);
    for circle in 0..=circles {
        // On a tangent plane: far circles of a high eye come out too small, but then they reach beyond the horizon.
        let radius_m = (f64::from(circle) * SEARCH_M).min(range_m);
        let places = 6 * circle.max(1);
        for k in 0..places {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(places);
            let found_m = shore_m(DVec2::from_angle(angle) * radius_m);
            land |= found_m > -NEAR_M;
            coast |= found_m.abs() < NEAR_M;
        }
    }
    (land, coast)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::terrain::Terrain;
    use crate::passes::relief::field::{Grids, level, place as chart_place};
    use crate::passes::relief::window::Tiles;
    use crate::plan::scenes::{clear_day, place};

    fn seen(
        mut snapshot: Snapshot,
        latitude_deg: f64,
        longitude_deg: f64,
        altitude_m: f64,
    ) -> (Eye, Option<ReliefPlan>) {
        snapshot.ownship.position = place(latitude_deg, longitude_deg, altitude_m);
        let eye = Eye::new(&snapshot.ownship, &snapshot.views[0], &snapshot.terrain);
        let plan = in_sight(&snapshot, &eye, false, &mut Vec::new());
        (eye, plan)
    }

    #[test]
    fn over_the_sea_there_is_no_relief_and_at_the_coast_there_is() {
        let mut snapshot = clear_day();
        snapshot.terrain = Terrain::procedural();
        for (name, latitude, longitude, altitude, land) in [
            ("Atlantic", 30.0, -40.0, 3_000.0, false),
            ("Pacific on the 180th meridian", 15.0, -180.0, 12_000.0, false),
            ("north pole", 90.0, 0.0, 12_000.0, false),
            ("south pole", -90.0, 0.0, 3_000.0, true),
            ("off Cannes", 43.4, 7.1, 300.0, true),
            ("Alps", 46.5, 8.0, 5_000.0, true),
            ("Atlantic from space", 30.0, -40.0, 400_000.0, true),
        ] {
            let (_, plan) = seen(snapshot.clone(), latitude, longitude, altitude);
            assert_eq!(plan.is_some(), land, "{name}");
            assert!(plan.is_none_or(|plan| plan.rays), "{name}");
        }
        let (_, flat) = seen(clear_day(), 43.5, 7.0, 5_000.0);
        assert!(flat.is_some_and(|plan| !plan.rays), "the ellipsoid has a shore and nothing to follow rays over");
        let (_, inland) = seen(clear_day(), 50.0, 80.0, 5_000.0);
        assert!(inland.is_none(), "far from the sea the ellipsoid has nothing to tell");
    }

    #[test]
    fn what_is_drawn_is_what_is_asked_for() {
        let mut snapshot = clear_day();
        snapshot.terrain = Terrain::procedural();
        for (latitude, longitude) in [(46.4, 7.9), (64.0, -150.0), (-33.0, -70.2), (27.9, 86.9)] {
            let (eye, plan) = seen(snapshot.clone(), latitude, longitude, 4_000.0);
            let plan = plan.expect("land");
            let nodes = Tiles::default().nodes(&plan.window);
            let grids = Grids { relief: &plan.relief, nodes: &nodes, lights: None };
            for (east, north, bound_m) in
                [(0.0, 0.0, 12.0), (400.0, -900.0, 12.0), (-1_500.0, 700.0, 12.0), (9_000.0, -12_000.0, 130.0)]
            {
                let there = from_ecef(eye.ground_ecef_m + eye.enu * DVec3::new(east, north, 0.0));
                let asked = snapshot.terrain.height_m(&there);
                let p = eye.place(&crate::geo::Geodetic { altitude_m: asked, ..there });
                let (earth_m, radius_m) = (eye.earth_m as f32, (eye.earth_m + asked) as f32);
                let chart_m = chart_place(&plan.relief, p, earth_m, radius_m);
                let drawn = f64::from(grids.at(chart_m, level(&plan.relief, chart_m, p.length())).x);
                // Within 2 km: half of what lies between nodes of 30 m on slopes of 45 degrees. At 15 km the nodes are 190 m apart.
                assert!((drawn - asked).abs() < bound_m, "{latitude} {longitude}, {east} {north}: {drawn} {asked}");
            }
        }
    }
}
