//! The coastline against known places, a direct search, and its own neighbours.

use super::*;

fn at(latitude_deg: f64, longitude_deg: f64) -> f64 {
    shore_m(latitude_deg.to_radians(), longitude_deg.to_radians())
}

#[test]
fn land_and_sea_are_where_they_are() {
    for (name, latitude, longitude) in [
        ("Lucerne", 47.0, 8.0),
        ("Kansas", 38.5, -98.0),
        ("Ayers Rock", -25.3, 131.0),
        ("south pole", -90.0, 0.0),
        ("near the south pole", -89.7, 123.0),
        ("Vostok", -78.5, 106.8),
        ("Chukotka east of the 180th meridian", 67.0, -175.5),
        ("Chukotka west of it", 67.5, 178.0),
        ("on the meridian", 67.8, 180.0),
        ("Greenland", 75.0, -40.0),
        ("Borneo", 1.0, 114.0),
    ] {
        assert!(at(latitude, longitude) > 1_000.0, "{name}: {}", at(latitude, longitude));
    }
    for (name, latitude, longitude) in [
        ("Atlantic", 0.0, -30.0),
        ("north pole", 90.0, 0.0),
        ("Pacific on the 180th meridian", 0.0, 180.0),
        ("off Cannes", 43.45, 7.05),
        ("North Sea", 56.0, 3.0),
        ("Drake Passage", -59.0, -65.0),
        ("Caspian Sea", 42.0, 50.7),
    ] {
        assert!(at(latitude, longitude) < -1_000.0, "{name}: {}", at(latitude, longitude));
    }
    assert_eq!(at(0.0, -30.0), -REACH_M);
}

#[test]
fn distances_are_those_of_a_direct_search() {
    let rings = rings::shared();
    for (latitude, longitude) in
        [(43.52, 7.01), (54.31, 10.13), (-17.8, 177.93), (61.03, 5.07), (-54.81, -68.02), (1.31, 103.77)]
    {
        let edges = rings.around([longitude - 1.5, longitude + 1.5], [latitude - 1.0, latitude + 1.0]);
        let shrink = f64::to_radians(latitude).cos();
        let to_edge = |edge: &rings::Edge| {
            let place = |p: [f64; 2]| glam::DVec2::new((p[0] - longitude) * shrink, p[1] - latitude);
            let (a, b) = (place(edge.from), place(edge.to));
            let share = (-a.dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            (a + (b - a) * share).length() * 111_195.0
        };
        let direct = edges.iter().map(to_edge).fold(REACH_M, f64::min);
        let charted = charted_m(0, latitude, longitude).abs();
        // Nodes hold the nearest edge that a neighbour knew of, which may miss it by a per cent; places here are nodes.
        assert!((charted - direct).abs() < 0.02 * direct + 1.0, "{latitude} {longitude}: {charted} {direct}");
    }
}

#[test]
fn nothing_steps_between_blocks() {
    // Along 47.x N across whole degrees and through a fjord coast, and across the 180th meridian over land.
    for (from, to) in
        [([61.0003, 4.0], [61.0003, 8.0]), ([60.2, 5.9997], [62.4, 5.9997]), ([67.0, 178.9], [67.0, 181.1])]
    {
        let place = |k: usize| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * k as f64 / 4_000.0);
        let way_m = (to[0] - from[0]).hypot((to[1] - from[1]) * f64::to_radians(from[0]).cos()) * 111_195.0 / 4_000.0;
        let mut before = at(from[0], from[1]);
        for k in 1..=4_000 {
            let [latitude, longitude] = place(k);
            let next = at(latitude, longitude);
            // A distance changes by no more than the way, the wiggles by as much again where they are steepest.
            assert!((next - before).abs() < 2.0 * way_m + 1.0, "{latitude} {longitude}: {before} {next}");
            before = next;
        }
    }
}

#[test]
fn coarse_pictures_have_the_same_shore() {
    for (latitude, longitude) in [(47.0, 8.0), (0.0, -30.0), (50.0, -1.0), (49.9, -4.0), (-80.0, 20.0)] {
        let coarse = coarse_shore_m(f64::to_radians(latitude), f64::to_radians(longitude), 5_000.0);
        assert!(coarse.signum() == at(latitude, longitude).signum(), "{latitude} {longitude}: {coarse}");
    }
}
