//! Which outlines the world hears of when a host has said more than it takes: those nearest to the ownship.
//!
//! The world takes twice as many regions as are drawn, so those that are exchanged here are not drawn, and what is drawn fades (see
//! `plan::regions`). One that the world has goes only for one that is clearly nearer: who flies between two does not make
//! them come and go.

use crate::geo::Geodetic;
use crate::geo::wgs84::to_ecef;
use crate::world::command::RegionShape;
use crate::world::regions::signed_distance_m;

/// What the world has counts as so much nearer: a share of its distance, and a distance.
const HELD_SHARE: f64 = 0.1;
const HELD_M: f64 = 2_000.0;

/// Keeps `most` of the items, those whose weather begins nearest to a place, in the order in which they were; those that the
/// world has (`held`) go before others about as near. Without a place the first ones.
pub(super) fn nearest<T>(
    items: Vec<T>,
    place: Option<&Geodetic>,
    most: usize,
    outline: impl Fn(&T) -> &RegionShape,
    held: impl Fn(&T) -> bool,
) -> Vec<T> {
    let Some(place) = place.filter(|_| items.len() > most) else {
        return items.into_iter().take(most).collect();
    };
    let level = Geodetic { altitude_m: 0.0, ..*place };
    // To the outline, then to the centre for those that hold the place.
    let away_m = |item: &T| {
        let shape = outline(item);
        let centre = Geodetic {
            latitude_rad: shape.latitude_deg.to_radians(),
            longitude_rad: shape.longitude_deg.to_radians(),
            altitude_m: 0.0,
        };
        let centre_m = (to_ecef(&centre) - to_ecef(&level)).length();
        // An outline's plane ends at the horizon of its centre: beyond, its corners bound the distance.
        let at_least_m = centre_m - 0.5 * shape.size_east_m.hypot(shape.size_north_m);
        let edge_m = signed_distance_m(shape, &level).max(at_least_m) - shape.transition_m;
        let nearer = |away_m: f64| if held(item) { (1.0 - HELD_SHARE) * away_m - HELD_M } else { away_m };
        (nearer(edge_m.max(0.0)), nearer(centre_m))
    };
    let mut order: Vec<((f64, f64), usize)> =
        items.iter().enumerate().map(|(number, item)| (away_m(item), number)).collect();
    order.sort_by(|(a, k), (b, l)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(k.cmp(l)));
    let mut kept = vec![false; items.len()];
    for (_, number) in &order[..most] {
        kept[*number] = true;
    }
    items.into_iter().zip(kept).filter_map(|(item, kept)| kept.then_some(item)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outline_counts_and_not_the_size() {
        let shape = |name: &str, latitude_deg: f64, size_east_m: f64, size_north_m: f64| RegionShape {
            name: name.into(),
            latitude_deg,
            longitude_deg: 8.0,
            size_east_m,
            size_north_m,
            corner_radius_m: 0.0,
            rotation_deg: 0.0,
            transition_m: 0.0,
        };
        // A long front 900 km to the north, a small cell about the ownship, another 300 km to the south.
        let all = vec![
            shape("front", 55.1, 2e6, 1e4),
            shape("cell", 47.0, 1e4, 1e4),
            shape("south", 44.3, 1e4, 1e4),
            shape("far side", -47.0, 1e4, 1e4),
        ];
        let here = Geodetic { latitude_rad: 47f64.to_radians(), longitude_rad: 8f64.to_radians(), altitude_m: 900.0 };
        let kept = |most| -> Vec<String> {
            nearest(all.clone(), Some(&here), most, |shape| shape, |_| false)
                .into_iter()
                .map(|shape| shape.name)
                .collect()
        };
        assert_eq!(kept(1), ["cell"]);
        assert_eq!(kept(2), ["cell", "south"]);
        assert_eq!(kept(3), ["front", "cell", "south"], "in the order in which they were");
        // The world has the front: it is not 10 % and 2 km nearer than the cell in the south, and goes; one that is stays.
        let held = |far_deg: f64| {
            let two = vec![shape("held", 47.0 + far_deg, 1e4, 1e4), shape("new", 44.3, 1e4, 1e4)];
            nearest(two, Some(&here), 1, |shape| shape, |shape| shape.name == "held")[0].name.clone()
        };
        assert_eq!((held(2.95), held(3.2)), ("held".to_owned(), "new".to_owned()));
        assert_eq!(nearest(all.clone(), None, 2, |shape| shape, |_| false).len(), 2);
    }
}
