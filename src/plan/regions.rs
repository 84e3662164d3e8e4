//! Regions around the eye: which are near enough to shape the deck, and their outlines in the eye's coordinates.

use super::PassNote;
use super::eye::Eye;
use crate::geo::Geodetic;
use crate::passes::deck::{REGIONS, Region};
use crate::world::command::RegionShape;
use crate::world::regions::weight_at;
use crate::world::snapshot::{RegionState, Snapshot};
use glam::{DVec2, DVec3};

/// A region that shapes the deck.
pub struct NearRegion<'a> {
    /// The region.
    pub state: &'a RegionState,
    /// Its outline.
    pub outline: Region,
    /// How much its weather rules at the eye, 0 to 1.
    pub weight: f64,
}

/// Layers of regions that are drawn at once: each keeps up to three light volumes of about 8 MiB (twice that in f16).
const LAYERS: usize = 32;
/// Over this distance before the first region that is not drawn, those that are fade.
const FADE_M: f64 = 20_000.0;

/// Regions with any weight within sight, nearest first; what does not fit is said in a note.
pub fn near<'a>(snapshot: &'a Snapshot, eye: &Eye, notes: &mut Vec<PassNote>) -> Vec<NearRegion<'a>> {
    let mut found: Vec<(f64, NearRegion)> = snapshot
        .regions
        .iter()
        .filter(|r| r.presence > 0.0)
        .map(|state| {
            let (outline, distance_m) = outline(&state.shape, state.presence, eye);
            let weight = state.presence * weight_at(&state.shape, &eye.position);
            (distance_m, NearRegion { state, outline, weight })
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    // As far as anything of its clouds can be seen, those of the weather around included.
    let top_m = |region: &NearRegion| {
        let tops = region.state.weather.layers.iter().map(|layer| layer.base_m + layer.thickness_m);
        tops.fold(12_000.0, f64::max)
    };
    let seen = |(distance_m, region): &(f64, NearRegion)| *distance_m <= super::layers::extent_m(eye, top_m(region));
    let all = found.len();
    found.retain(seen);
    let beyond = all - found.len();
    if beyond > 0 {
        notes.push(note(false, format!("{beyond} regions lie beyond the horizon")));
    }
    let in_sight = found.len();
    let drawn = fitting(&found);
    if drawn < in_sight {
        fade_before(found[drawn].0, &mut found[..drawn]);
        let why = format!(
            "{in_sight} regions in sight, the nearest {drawn} are drawn: {REGIONS} with {LAYERS} layers together at most"
        );
        notes.push(note(false, why));
        found.truncate(drawn);
    }
    if drawn > 0 {
        notes.push(note(true, format!("{drawn} regions in sight")));
    }
    found.into_iter().map(|(_, region)| region).collect()
}

/// How many of the regions, nearest first, have no more layers than are drawn; the first always is.
fn fitting(found: &[(f64, NearRegion)]) -> usize {
    let mut layers = 0;
    let fits = |(_, region): &&(f64, NearRegion)| {
        layers += region.state.weather.layers.len();
        layers <= LAYERS
    };
    found.iter().take(REGIONS).take_while(fits).count()
}

/// Lets the regions that are drawn ease to nothing towards the distance of the first that is not, so that none appears or
/// vanishes at once when another comes nearer. The nearest stays as it is.
fn fade_before(cut_m: f64, drawn: &mut [(f64, NearRegion)]) {
    let nearest_m = drawn.first().map_or(0.0, |(distance_m, _)| *distance_m);
    let width_m = FADE_M.min(cut_m - nearest_m).max(1e-3);
    for (distance_m, region) in drawn.iter_mut().skip(1) {
        let share = ((cut_m - *distance_m) / width_m).clamp(0.0, 1.0);
        region.weight *= share;
        region.outline.presence *= share as f32;
    }
}

fn note(kept: bool, why: String) -> PassNote {
    PassNote { pass: "region", kept, why }
}

/// The outline around the eye, and the distance from the eye to where the region's weight begins (0 inside).
pub fn outline(shape: &RegionShape, presence: f64, eye: &Eye) -> (Region, f64) {
    let centre = place(shape, eye, 0.0, 0.0);
    // The rotated axes at the centre, as they lie in the eye's coordinates.
    let angle = shape.rotation_deg.to_radians();
    let ahead = place(shape, eye, 1e-4 * angle.cos(), -1e-4 * angle.sin());
    let axis = (ahead - centre).normalize_or(DVec2::X);
    let half = 0.5 * DVec2::new(shape.size_east_m, shape.size_north_m);
    let core = (half - DVec2::splat(shape.corner_radius_m)).max(DVec2::ZERO);
    let transition = shape.transition_m.max(1.0);
    let outline = Region {
        centre_m: centre.as_vec2().into(),
        rotation: axis.as_vec2().into(),
        core_m: core.as_vec2().into(),
        corner_m: shape.corner_radius_m as f32,
        inverse_transition: (1.0 / transition) as f32,
        presence: presence as f32,
        pad0: 0.0,
        pad1: 0.0,
        pad2: 0.0,
    };
    let q = DVec2::new(axis.dot(-centre), axis.perp_dot(-centre)).abs() - core;
    let outside = q.max(DVec2::ZERO).length() - shape.corner_radius_m;
    (outline, (outside - transition).max(0.0))
}

/// Stereographic coordinate around the eye of the centre, moved by an angle (radians) east and north.
fn place(shape: &RegionShape, eye: &Eye, east_rad: f64, north_rad: f64) -> DVec2 {
    let centre = Geodetic {
        latitude_rad: shape.latitude_deg.to_radians(),
        longitude_rad: shape.longitude_deg.to_radians(),
        altitude_m: 0.0,
    };
    let axes = crate::geo::frames::enu(&centre);
    let at = (axes * DVec3::new(east_rad, north_rad, 1.0)).normalize();
    let local = eye.enu.transpose() * at;
    // The antipode has no coordinate, and near it none that f32 holds: beyond 170 degrees, far away is far enough.
    let level = DVec2::new(local.x, local.y);
    if local.z < -0.985 {
        return level.normalize_or(DVec2::X) * (24.0 * eye.earth_m);
    }
    level * (2.0 * eye.earth_m / (1.0 + local.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::scenes::{clear_day, layer, region};
    use crate::world::limits::{MAX_LAYERS, MAX_REGIONS};

    #[test]
    fn of_all_regions_that_the_world_takes_half_are_drawn_and_none_comes_at_once() {
        // The world's places that are not drawn are where a CIGI host's regions are exchanged for nearer ones.
        assert_eq!(2 * REGIONS, MAX_REGIONS);
        let mut snapshot = clear_day();
        for k in 0..MAX_REGIONS {
            snapshot.regions.push(region(47.0 + 0.05 * k as f64, 8.0, 4_000.0, 1_000.0));
            let eye = Eye::new(&snapshot.ownship, &snapshot.views[0], &snapshot.terrain);
            let near = near(&snapshot, &eye, &mut Vec::new());
            assert_eq!(near.len(), REGIONS.min(k + 1));
            let whole = near.iter().filter(|r| r.outline.presence == 1.0).count();
            // 5.6 km apart: the last three lie within 20 km of the first that is not drawn.
            assert_eq!(whole, if k < REGIONS { k + 1 } else { REGIONS - 3 });
        }
    }

    /// Eight regions of eight layers, north of each other.
    fn crowded() -> Snapshot {
        let mut snapshot = clear_day();
        for k in 0..8 {
            let mut own = region(46.0 + 0.3 * f64::from(k), 8.0, 4_000.0, 1_000.0);
            own.shape.name = format!("region-{k}");
            own.weather.layers =
                (0..MAX_LAYERS).map(|i| layer(crate::clouds::CloudKind::Cumulus, 1e3 * i as f64, 500.0)).collect();
            snapshot.regions.push(own);
        }
        snapshot
    }

    #[test]
    fn too_many_layers_of_regions_are_told_and_go_without_a_jump() {
        let mut snapshot = crowded();
        let mut before: Option<Vec<f32>> = None;
        let mut changes = 0;
        for k in 0..400 {
            // 2 degrees northwards in steps of 550 m.
            snapshot.ownship.position.latitude_rad = (46.0 + 0.005 * f64::from(k)).to_radians();
            let eye = Eye::new(&snapshot.ownship, &snapshot.views[0], &snapshot.terrain);
            let mut notes = Vec::new();
            let near = near(&snapshot, &eye, &mut notes);
            assert_eq!(near.len(), LAYERS / MAX_LAYERS);
            assert!(notes.iter().any(|note| !note.kept && note.why.contains("nearest 4 are drawn")), "{notes:?}");
            assert_eq!(near[0].outline.presence, 1.0, "the nearest is whole");
            let presence =
                |name: &str| near.iter().find(|r| r.state.shape.name == name).map_or(0.0, |r| r.outline.presence);
            let now: Vec<f32> = (0..8).map(|i| presence(&format!("region-{i}"))).collect();
            if let Some(before) = &before {
                let step = now.iter().zip(before).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                // Two that come nearer and go at 550 m a step ease over 20 km.
                assert!(step < 1_150.0 / FADE_M as f32, "step {k}: {before:?} {now:?}");
                changes += usize::from(now.iter().zip(before).any(|(a, b)| (*a > 0.0) != (*b > 0.0)));
            }
            before = Some(now);
        }
        assert!(changes >= 3, "others came into the number: {changes} times");
    }
}
