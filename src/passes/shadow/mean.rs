//! What a layer lets through of the light on the mean over tile and map: what its shadows leave on the whole.

use super::Columns;
use super::table::{THETAS, mean_row, theta};
use crate::clouds::CloudKind;
use crate::clouds::density::{DensityVolume, WIDTH};
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// One row of texels in so many is looked at: neighbours are alike.
const ROW_STEP: usize = 8;
/// Places of the map, which is uniform.
const PLACES: usize = 32;
/// Curves kept: a few bytes each.
const KEPT: usize = 64;

/// Mean transmittance by theta.
type Curve = [f32; THETAS];

/// Mean share, 0 to 1, of the light that a layer lets through whose theta is an offset plus patchiness times the map.
pub fn mean_through(kind: CloudKind, columns: &Columns, offset: f32, patchiness: f32) -> f32 {
    let curve = curve(kind, columns);
    let low = theta(0, columns.edge);
    let step = theta(1, columns.edge) - low;
    let at = |place: usize| {
        let found = offset + patchiness * (place as f32 + 0.5) / PLACES as f32;
        let entry = ((found - low) / step).clamp(0.0, (THETAS - 1) as f32);
        let i = (entry as usize).min(THETAS - 2);
        curve[i] + (curve[i + 1] - curve[i]) * (entry - i as f32)
    };
    (0..PLACES).map(at).sum::<f32>() / PLACES as f32
}

/// Kept, since it is asked for each frame; made outside the lock, so that nobody waits for it.
fn curve(kind: CloudKind, columns: &Columns) -> Curve {
    static CURVES: Mutex<VecDeque<((CloudKind, Columns), Curve)>> = Mutex::new(VecDeque::new());
    let locked = || CURVES.lock().unwrap_or_else(PoisonError::into_inner);
    let key = (kind, *columns);
    if let Some((_, curve)) = locked().iter().find(|(k, _)| *k == key) {
        return *curve;
    }
    let shape = &DensityVolume::of(kind).shape;
    let mut curve = [0.0; THETAS];
    for y in (0..WIDTH).step_by(ROW_STEP) {
        let row = mean_row(columns, shape, y);
        curve.iter_mut().zip(row).for_each(|(sum, mean)| *sum += mean * ROW_STEP as f32 / WIDTH as f32);
    }
    let mut curves = locked();
    curves.push_front((key, curve));
    curves.truncate(KEPT);
    curve
}

#[cfg(test)]
mod tests {
    use super::super::table::{LEVELS, build};
    use super::*;

    #[test]
    fn the_mean_is_that_of_the_whole_table() {
        for kind in [CloudKind::Cumulus, CloudKind::Cirrus, CloudKind::Altocumulus] {
            let look = kind.appearance();
            let columns = Columns {
                direction: [0.48, -0.36, 0.8],
                begin: 0.0,
                thickness_m: look.usual_thickness_m,
                extinction_per_m: look.extinction_per_m,
                edge: look.edge,
                pieces: 1,
                bounded: false,
            };
            let table = build(&columns, &DensityVolume::of(kind).shape);
            for (entry, found) in curve(kind, &columns).iter().enumerate() {
                let texel = table.levels[LEVELS - 1][(entry / 3).min(7)];
                let whole = f32::from(texel[entry - 3 * (entry / 3).min(7)]) / 255.0;
                // An eighth of the rows, which lie 500 m apart: the error of the mean of 32 rows.
                assert!((found - whole).abs() < 0.02, "{kind:?} {entry}: {found}, all rows {whole}");
            }
        }
    }
}
