//! Which outlines the world hears of when a host has said more than it draws: those nearest to the ownship.

use crate::geo::Geodetic;
use crate::geo::wgs84::to_ecef;
use crate::world::command::RegionShape;
use crate::world::regions::signed_distance_m;

/// Keeps `most` of the items, those whose outlines come nearest to a place, in the order in which they were; without a
/// place the first ones.
pub(super) fn nearest<T>(
    items: Vec<T>,
    place: Option<&Geodetic>,
    most: usize,
    outline: impl Fn(&T) -> &RegionShape,
) -> Vec<T> {
    let Some(place) = place.filter(|_| items.len() > most) else {
        return items.into_iter().take(most).collect();
    };
    let level = Geodetic { altitude_m: 0.0, ..*place };
    // To the outline, then to the centre for those that hold the place.
    let away_m = |shape: &RegionShape| {
        let centre = Geodetic {
            latitude_rad: shape.latitude_deg.to_radians(),
            longitude_rad: shape.longitude_deg.to_radians(),
            altitude_m: 0.0,
        };
        let centre_m = (to_ecef(&centre) - to_ecef(&level)).length();
        // An outline's plane ends at the horizon of its centre: beyond, its corners bound the distance.
        let at_least_m = centre_m - 0.5 * shape.size_east_m.hypot(shape.size_north_m);
        (signed_distance_m(shape, &level).max(at_least_m).max(0.0), centre_m)
    };
    let mut order: Vec<((f64, f64), usize)> =
        items.iter().enumerate().map(|(number, item)| (away_m(outline(item)), number)).collect();
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
            nearest(all.clone(), Some(&here), most, |shape| shape).into_iter().map(|shape| shape.name).collect()
        };
        assert_eq!(kept(1), ["cell"]);
        assert_eq!(kept(2), ["cell", "south"]);
        assert_eq!(kept(3), ["front", "cell", "south"], "in the order in which they were");
        assert_eq!(nearest(all.clone(), None, 2, |shape| shape).len(), 2);
    }
}
