//! The sweep of one direction for sixteen sources: plane by plane downwind, from what cells scatter to the light in them; and what the
//! ground below sends up.

use super::{First, Operator, Work};
use crate::scattering::direct::NO_TILT;
use crate::scattering::lanes::Lanes;
use crate::scattering::path::{Tap, plane_axes};
use crate::scattering::surface::displace;

/// What the ground sends up: its albedo times the light that leaves through the lower face and the direct light, over pi.
#[inline(always)]
pub fn light_ground(operator: &Operator, first: Option<&First>, work: &mut Work) {
    let Some(surface) = &operator.ground else {
        work.ground.fill(Lanes::splat(operator.incoming));
        return;
    };
    let [nx, ny, _] = operator.cells;
    match first {
        Some(first) => work.ground.copy_from_slice(&first.lit),
        None => work.ground.fill(Lanes::ZERO),
    }
    let mut leaving = vec![Lanes::ZERO; nx * ny];
    for m in operator.order.iter().copied() {
        let d = operator.angles.set.directions[m];
        if d[2] > -1e-12 {
            break;
        }
        let cells = operator.len();
        for (column, out) in leaving.iter_mut().enumerate() {
            let e = (-operator.exit_depth(column, d[2])).exp();
            let at = m * cells + column;
            *out = work.radiance[at].scaled(e).plus(1.0 - e, &work.source[at]);
        }
        let weight = (operator.angles.set.weights[m] * -d[2]) as f32;
        displace(&leaving, [nx, ny], surface.shift(d), weight, &mut work.ground);
    }
    let albedo = surface.albedo as f32 * std::f32::consts::FRAC_1_PI;
    work.ground.iter_mut().for_each(|g| *g = g.scaled(albedo));
}

/// Light of one direction, plane by plane downwind.
#[inline(always)]
pub fn sweep(operator: &Operator, m: usize, first: Option<&First>, work: &mut Work) {
    let path = &operator.paths[m];
    let n = operator.cells;
    let stride = [1, n[0], n[0] * n[1]];
    let cells = operator.len();
    let [u_axis, v_axis] = plane_axes(path.axis);
    let (nu, nv) = (n[u_axis], n[v_axis]);
    let (su, sv) = (stride[u_axis], stride[v_axis]);
    let planes = n[path.axis];
    let source = &work.source[m * cells..][..cells];
    let radiance = &mut work.radiance[m * cells..][..cells];
    let weights = &operator.weights[m * cells..][..cells];
    let rise = operator.angles.set.directions[m][2];
    // The ground's light as this direction meets the lower face.
    let mut rising = Vec::new();
    if rise > 1e-12 {
        rising = match &operator.ground {
            Some(surface) => {
                let mut moved = vec![Lanes::ZERO; n[0] * n[1]];
                displace(&work.ground, [n[0], n[1]], surface.shift(operator.angles.set.directions[m]), 1.0, &mut moved);
                moved
            }
            None => vec![Lanes::splat(operator.incoming); n[0] * n[1]],
        };
    }
    let incoming = Lanes::splat(operator.incoming);
    // Light that leaves the cells of the plane before, and of this one.
    let mut entering = vec![incoming; nu * nv];
    let mut leaving = vec![incoming; nu * nv];
    for p in 0..planes {
        let plane = if path.forward { p } else { planes - 1 - p };
        let before = if path.forward { plane.wrapping_sub(1) } else { plane + 1 };
        let after = if path.forward { plane + 1 } else { plane.wrapping_sub(1) };
        // Beyond the first and the last plane the source goes on as it is there.
        let [base, before_base, after_base] =
            [plane, if p == 0 { plane } else { before }, if p + 1 == planes { plane } else { after }]
                .map(|at| at * stride[path.axis]);
        for v in 0..nv {
            for u in 0..nu {
                let cell = base + v * sv + u * su;
                let light = if p == 0 {
                    // Only an upward ray crosses the lower face first.
                    if path.axis == 2 && rise > 0.0 { rising[u + nu * v] } else { incoming }
                } else if let [tap] = &path.taps[..] {
                    *met(
                        &entering,
                        &rising,
                        &incoming,
                        tap,
                        (u, nu),
                        (v, nv),
                        (path.axis, before, n[0], v_axis == 2 && rise > 1e-12),
                    )
                } else {
                    let mut sum = Lanes::ZERO;
                    for tap in &path.taps {
                        let from = met(
                            &entering,
                            &rising,
                            &incoming,
                            tap,
                            (u, nu),
                            (v, nv),
                            (path.axis, before, n[0], v_axis == 2 && rise > 1e-12),
                        );
                        sum = sum.plus(tap.weight, from);
                    }
                    sum
                };
                let w = &weights[cell];
                let own = &source[cell];
                let difference = own.plus(-1.0, &light);
                let (mut mean, mut out) = (own.plus(-w.share, &difference), light.plus(w.lost, &difference));
                if w.lean > 1e-4 {
                    let mut slope = if let [tap] = &path.taps[..] {
                        let at = |sign: isize, base: usize| {
                            let cu = (u as isize + sign * tap.u).clamp(0, nu as isize - 1) as usize;
                            let cv = (v as isize + sign * tap.v).clamp(0, nv as isize - 1) as usize;
                            &source[base + cu * su + cv * sv]
                        };
                        at(-1, after_base).plus(-1.0, at(1, before_base))
                    } else {
                        let ahead = taken(source, &path.taps, -1, after_base, (u, nu, su), (v, nv, sv));
                        let behind = taken(source, &path.taps, 1, before_base, (u, nu, su), (v, nv, sv));
                        ahead.plus(-1.0, &behind)
                    };
                    if let Some(first) = first.filter(|f| f.slot[cell] != NO_TILT) {
                        let slot = first.slot[cell] as usize;
                        // The known rise in the units of the neighbours' difference, where it is known.
                        let rise = first.rises[slot * operator.paths.len() + m].scaled(w.unit / w.tilt.max(1e-30));
                        slope = slope.plus(1.0, &rise.plus(-1.0, &slope).times(&first.known[slot]));
                    }
                    mean = mean.plus(-w.lean, &slope);
                    out = out.plus(w.tilt, &slope);
                }
                leaving[u + nu * v] = out;
                radiance[cell] = mean;
            }
        }
        std::mem::swap(&mut entering, &mut leaving);
    }
}

/// Light that enters a cell from the cell of the plane before at a tap, or from outside the box there.
#[inline(always)]
fn met<'a>(
    entering: &'a [Lanes],
    rising: &'a [Lanes],
    incoming: &'a Lanes,
    tap: &Tap,
    (u, nu): (usize, usize),
    (v, nv): (usize, usize),
    (axis, before, columns, from_below): (usize, usize, usize, bool),
) -> &'a Lanes {
    let (tu, tv) = (u as isize + tap.u, v as isize + tap.v);
    if (tu as usize) < nu && (tv as usize) < nv {
        &entering[tu as usize + nu * tv as usize]
    } else if from_below && tv < 0 {
        // Past the lower face in the plane before: the column there.
        let beside = tu.clamp(0, nu as isize - 1) as usize;
        let column = if axis == 0 { [before, beside] } else { [beside, before] };
        &rising[column[0] + columns * column[1]]
    } else {
        incoming
    }
}

/// The source where the ray meets a plane: the nearest cell's beyond the box.
#[inline(always)]
fn taken(
    source: &[Lanes],
    taps: &[Tap],
    sign: isize,
    base: usize,
    (u, nu, su): (usize, usize, usize),
    (v, nv, sv): (usize, usize, usize),
) -> Lanes {
    let mut sum = Lanes::ZERO;
    for tap in taps {
        let cu = (u as isize + sign * tap.u).clamp(0, nu as isize - 1) as usize;
        let cv = (v as isize + sign * tap.v).clamp(0, nv as isize - 1) as usize;
        sum = sum.plus(tap.weight, &source[base + cu * su + cv * sv]);
    }
    sum
}
