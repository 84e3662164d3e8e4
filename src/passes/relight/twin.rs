//! Twin of `relight.wgsl`: light of the fields at a place, in clouds and on the ground.

use super::{Field, Lit, Lits};
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// The isotropic phase function, 1/sr.
const ISOTROPIC: f32 = 0.079_577_47;

/// What a place scatters towards `towards` (unit) of all fields' light, cd/m2 per unit of opacity. `p`: east, north, height over
/// the tangent plane; `height_m` over the sphere. `fields` are those of the [`Lits`], in order; one that is still being
/// made is missing.
pub fn scattered(lits: &Lits, fields: &[Option<Arc<Field>>], p: Vec3, height_m: f32, towards: Vec3) -> f32 {
    let mut sum = 0.0;
    for (lit, field) in lits.lit[..lits.fields as usize].iter().zip(fields) {
        let level = (height_m - lit.base_m) * lit.inverse_thickness;
        if lit.levels > 0 && !(0.0..=1.0).contains(&level) {
            sum += ISOTROPIC * from_outside(lit, p, level < 0.0).0;
            continue;
        }
        let quotient = field.as_ref().map_or(ISOTROPIC, |field| {
            let found = quotient_at(field, place_in(lit, p, level));
            found.x + Vec3::new(found.y, found.z, found.w).dot(turned(lit, towards))
        });
        sum += lit.intensity_cd * quotient.max(0.0) * in_air(lit, p);
    }
    sum
}

/// Illuminance of ground with this normal by all fields, lux: from the lower face, or from the upper one where the ground
/// stands above it.
pub fn on_ground(lits: &Lits, p: Vec3, normal: Vec3) -> f32 {
    let of = |lit: &Lit| {
        let below = (Vec3::from(lit.above_m) - p).dot(Vec3::from(lit.up)) > 0.0;
        from_outside(lit, p, below).1.dot(normal).max(0.0)
    };
    lits.lit[..lits.fields as usize].iter().map(of).sum()
}

/// Place in a field's cells.
fn place_in(lit: &Lit, p: Vec3, level: f32) -> Vec3 {
    Vec3::new(
        Vec3::from(lit.east_per_m).dot(p) + lit.east_origin,
        Vec3::from(lit.north_per_m).dot(p) + lit.north_origin,
        level,
    )
}

/// A direction in the field's axes.
fn turned(lit: &Lit, d: Vec3) -> Vec3 {
    Vec3::new(
        lit.width_m * Vec3::from(lit.east_per_m).dot(d),
        lit.width_m * Vec3::from(lit.north_per_m).dot(d),
        Vec3::from(lit.up).dot(d),
    )
}

/// What the points would give in empty air, lux of one candela.
fn in_air(lit: &Lit, p: Vec3) -> f32 {
    let given = |q: &super::LitPoint| q.share / ((Vec3::from(q.position_m) - p).length_squared() + lit.cap_m2);
    lit.point[..lit.points as usize].iter().map(given).sum()
}

/// Light that comes to a place below or above a field's window, out of the cloud's face and from points that lie
/// beyond it: fluence in lux, and flux as a vector towards the light.
///
/// A patch of flux F and spread s lights a level plane at distance h by `F/pi h^2 (r^2 + b) / (r^2 + c)^3` at r aside, with
/// `c = h^2 + 2 s` and `b = 2 c^2 / h^2 - c`: all of F arrives, far away it is the light of a point that sends the cosine,
/// h^2 / r^4, and with s = 0 it is that everywhere.
fn from_outside(lit: &Lit, p: Vec3, below: bool) -> (f32, Vec3) {
    let up = Vec3::from(lit.up);
    let (face, straight, spread, side) = if below {
        (Vec3::from(lit.below_m), lit.below_cd, lit.spread_m2[0], -1.0)
    } else {
        (Vec3::from(lit.above_m), lit.above_cd, lit.spread_m2[1], 1.0)
    };
    let away = face - p;
    let rise = away.dot(up);
    let (aside, square) = ((away.length_squared() - rise * rise).max(0.0), rise * rise + 1.0);
    let wide = square + 2.0 * spread;
    let across = aside + wide;
    let on_plane = straight * (square * (aside - wide) + 2.0 * wide * wide) / (across * across * across);
    // Near a wide patch light comes from far above the horizon; far from it from where the patch is.
    let height = square + spread * wide / across;
    let mut fluence = on_plane * ((aside + height) / height).sqrt();
    let mut flux = (away - up * (side * height.sqrt() + rise)) * (on_plane / height.sqrt());
    for point in &lit.point[..lit.points as usize] {
        let position = Vec3::from(point.position_m);
        if lit.levels == 0 || (position - face).dot(up) * side > 0.0 {
            let away = position - p;
            let d2 = away.length_squared() + lit.cap_m2;
            let own = lit.intensity_cd * point.share / d2;
            fluence += own;
            flux += away * (own / d2.sqrt());
        }
    }
    (fluence, flux)
}

/// The quotients at a place in shares of the window, linear between the middles of cells and constant beyond the last.
fn quotient_at(field: &Field, share: Vec3) -> Vec4 {
    let cells = field.window.cells;
    let shares = share.to_array();
    let mut low = [0; 3];
    let mut part = [0.0; 3];
    let mut step = [0; 3];
    for k in 0..3 {
        let at = (shares[k] * cells[k] as f32 - 0.5).clamp(0.0, cells[k] as f32 - 1.0);
        low[k] = at as usize;
        part[k] = at - low[k] as f32;
        step[k] = usize::from(low[k] + 1 < cells[k]);
    }
    let at = |x: usize, y: usize, z: usize| {
        Vec4::from(field.quotients[low[0] + x + cells[0] * (low[1] + y + cells[1] * (low[2] + z))])
    };
    let edge = |y: usize, z: usize| at(0, y, z).lerp(at(step[0], y, z), part[0]);
    let face = |z: usize| edge(0, z).lerp(edge(step[1], z), part[1]);
    face(0).lerp(face(step[2]), part[2])
}
