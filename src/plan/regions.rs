//! Regions around the eye: which are near enough to shape the deck, and their outlines in the eye's coordinates.

use super::PassNote;
use super::eye::Eye;
use crate::geo::Geodetic;
use crate::passes::deck::{REGIONS, Region};
use crate::world::command::RegionShape;
use crate::world::snapshot::{RegionState, Snapshot};
use glam::{DVec2, DVec3};

/// A region that shapes the deck.
pub struct NearRegion<'a> {
    /// The region.
    pub state: &'a RegionState,
    /// Its outline.
    pub outline: Region,
}

/// Regions with any weight within sight, nearest first; what does not fit is said in a note.
pub fn near<'a>(snapshot: &'a Snapshot, eye: &Eye, notes: &mut Vec<PassNote>) -> Vec<NearRegion<'a>> {
    let mut found: Vec<(f64, NearRegion)> = snapshot
        .regions
        .iter()
        .filter(|r| r.presence > 0.0)
        .map(|state| {
            let (outline, distance_m) = outline(&state.shape, state.presence, eye);
            (distance_m, NearRegion { state, outline })
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let sight_m = super::layers::extent_m(eye, 12_000.0);
    let beyond = found.iter().filter(|(d, _)| *d > sight_m).count();
    found.retain(|(d, _)| *d <= sight_m);
    if beyond > 0 {
        notes.push(note(false, format!("{beyond} regions lie beyond the horizon")));
    }
    if found.len() > REGIONS {
        notes.push(note(false, format!("{} regions in sight, the nearest {REGIONS} are drawn", found.len())));
        found.truncate(REGIONS);
    }
    if !found.is_empty() {
        notes.push(note(true, format!("{} regions in sight", found.len())));
    }
    found.into_iter().map(|(_, region)| region).collect()
}

fn note(kept: bool, why: String) -> PassNote {
    PassNote { pass: "region", kept, why }
}

/// The outline around the eye, and the distance from the eye to where the region's weight begins (0 inside).
fn outline(shape: &RegionShape, presence: f64, eye: &Eye) -> (Region, f64) {
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
