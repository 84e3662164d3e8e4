//! Which outlines the world hears of when a host has said more than it draws: those nearest to the ownship.

use crate::geo::Geodetic;
use crate::geo::wgs84::to_ecef;
use crate::world::command::RegionShape;

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
    let place = to_ecef(&Geodetic { altitude_m: 0.0, ..*place });
    let away_m = |shape: &RegionShape| {
        let centre = Geodetic {
            latitude_rad: shape.latitude_deg.to_radians(),
            longitude_rad: shape.longitude_deg.to_radians(),
            altitude_m: 0.0,
        };
        (to_ecef(&centre) - place).length() - 0.5 * shape.size_east_m.hypot(shape.size_north_m)
    };
    let mut order: Vec<(f64, usize)> =
        items.iter().enumerate().map(|(number, item)| (away_m(outline(item)), number)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut kept = vec![false; items.len()];
    for (_, number) in &order[..most] {
        kept[*number] = true;
    }
    items.into_iter().zip(kept).filter_map(|(item, kept)| kept.then_some(item)).collect()
}
