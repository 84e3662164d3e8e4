//! The light that is drawn against Monte Carlo and closed forms; the grid of directions; what is made ahead.

use super::encoding::{Encoding, View, decode};
use super::grid::{Corner, SHARES, corners};
use super::node::{Node, shares};
use super::volume::{Volume, stored};
use super::*;
use crate::clouds::CloudKind;
use crate::clouds::density;
use crate::passes::deck::field::phases;
use crate::scattering::phase::Phase;
use crate::scattering::slab::{Slab, fluxes};
use glam::{Vec3, Vec4};

/// Stored values of one column of a uniform slab of an optical depth, from the base up.
fn column(depth: f32, direction: [f32; 3], encoding: Encoding) -> Vec<Vec4> {
    let node = Node {
        direction,
        theta: 0.0,
        voxel_height_m: 25.0,
        extinction_per_m: depth / (25.0 * HEIGHT as f32),
        inverse_edge: 1.0,
        bounded: false,
    };
    let mut column = Vec::new();
    shares(&node, &vec![255u8; density::WIDTH * density::WIDTH * HEIGHT], |i, found| {
        if i % (WIDTH * WIDTH) == 0 {
            column.push(encoding.encode(&found, direction));
        }
    });
    let volume = Volume { nodes: 1, texels: stored(encoding, column.iter().flat_map(|c| [*c; WIDTH * WIDTH])) };
    (0..HEIGHT).map(|z| volume.sample([0.1, 0.1], (z as f32 + 0.5) / HEIGHT as f32, 0.0)).collect()
}

/// Which of the light outside is asked for.
#[derive(Clone, Copy)]
enum Outside {
    Source,
    Sky,
}

/// Luminance that the drawn model sends out of a slab in a direction of sight (up: out of its base), light outside of 1.
fn luminance(column: &[Vec4], depth: f32, encoding: Encoding, light: Vec3, sight: Vec3, outside: Outside) -> f64 {
    let view = View { direction: sight, light, lobes: phases(sight.dot(light)) };
    let (steps, mut sum) = (800, 0.0);
    for k in 0..steps {
        // Shares of the height from the base; what lies between there and the eye.
        let share = (k as f32 + 0.5) / steps as f32;
        let z = (share * HEIGHT as f32 - 0.5).clamp(0.0, (HEIGHT - 1) as f32);
        let next = (z as usize + 1).min(HEIGHT - 1);
        let stored = column[z as usize] + (column[next] - column[z as usize]) * z.fract();
        let lit = decode(encoding, stored, &view);
        let before = if sight.z > 0.0 { share } else { 1.0 - share } * depth / sight.z.abs();
        let own = depth / steps as f32 / sight.z.abs();
        let found = match outside {
            Outside::Source => lit.source,
            Outside::Sky => lit.sky * 0.079_577_47,
        };
        sum += f64::from(found * (-before).exp() * own);
    }
    sum
}

/// Flux that leaves a slab by its base and by its top, as shares of what enters it.
fn leaving(depth: f32, light: Vec3, encoding: Encoding, outside: Outside) -> [f64; 2] {
    let column = column(depth, light.into(), encoding);
    let (rows, azimuths) = (12, 12);
    [1.0f32, -1.0].map(|side| {
        let mut sum = 0.0;
        for i in 0..rows * azimuths {
            let mu = ((i / azimuths) as f32 + 0.5) / rows as f32;
            let azimuth = ((i % azimuths) as f32 + 0.5) / azimuths as f32 * std::f32::consts::TAU;
            let flat = (1.0 - mu * mu).sqrt();
            let sight = Vec3::new(azimuth.cos() * flat, azimuth.sin() * flat, side * mu);
            sum += f64::from(mu) * luminance(&column, depth, encoding, light, sight, outside);
        }
        let mean = sum * std::f64::consts::TAU / f64::from(rows * azimuths);
        match outside {
            Outside::Source => mean / f64::from(light.z),
            Outside::Sky => mean,
        }
    })
}

#[test]
fn slabs_transmit_and_reflect_what_monte_carlo_says() {
    for (cosine, most) in [(1.0f32, 0.2), (0.6, 0.2), (0.25, 0.5)] {
        for depth in [5.0f32, 10.0, 20.0, 40.0] {
            let slab = Slab {
                optical_depth: f64::from(depth),
                albedo: 1.0,
                phase: Phase::HenyeyGreenstein(f64::from(ASYMMETRY)),
                cosine: f64::from(cosine),
                ground_albedo: 0.0,
                photons: 20_000,
                seed: 7,
            };
            let truth = fluxes(&slab).expect("a slab");
            let light = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            let direct = f64::from((-depth / cosine).exp());
            let [down, up] = leaving(depth, light, Encoding::Shares8, Outside::Source);
            let (passed, back) = ((down + direct) / truth.transmitted.mean, up / truth.reflected.mean);
            println!("mu {cosine}, depth {depth}: transmits {passed:.3}, reflects {back:.3} of Monte Carlo's");
            // What the model leaves out: Eddington's two moments, worst where the light grazes a thin slab (a beam that decays
            // slowly goes on through it); that a ray of sight sees light turned a little on its way.
            assert!((passed - 1.0).abs() < most, "mu {cosine}, depth {depth}: {passed}");
            assert!((back - 1.0).abs() < most, "mu {cosine}, depth {depth}: {back}");
        }
    }
}

#[test]
fn skylight_passes_a_slab_as_diffuse_light_does() {
    for depth in [5.0f32, 10.0, 20.0, 40.0] {
        // Diffuse light: cosines with the weight of their share of the flux.
        let (mut passed, mut reflected, rows) = (0.0, 0.0, 6);
        for i in 0..rows {
            let cosine = ((f64::from(i) + 0.5) / f64::from(rows)).sqrt();
            let phase = Phase::HenyeyGreenstein(f64::from(ASYMMETRY));
            let optical_depth = f64::from(depth);
            let slab = Slab { optical_depth, albedo: 1.0, phase, cosine, ground_albedo: 0.0, photons: 8_000, seed: 3 };
            let truth = fluxes(&slab).expect("a slab");
            passed += truth.transmitted.mean / f64::from(rows);
            reflected += truth.reflected.mean / f64::from(rows);
        }
        let [down, up] = leaving(depth, Vec3::Z, Encoding::Shares8, Outside::Sky);
        println!("depth {depth}: transmits {:.3}, reflects {:.3} of Monte Carlo's", down / passed, up / reflected);
        // Eddington's approximation, and the net flux at the source's slant instead of the sky's (see `encoding`).
        assert!((down / passed - 1.0).abs() < 0.25 && (up / reflected - 1.0).abs() < 0.25, "{depth}: {down} {up}");
    }
}

#[test]
fn light_grows_less_with_depth_and_half_of_a_deep_cloud_knows_no_direction() {
    for (outside, light) in [(Outside::Source, Vec3::new(0.6, 0.0, 0.8)), (Outside::Sky, Vec3::Z)] {
        let depth = 40.0;
        let column = column(depth, light.into(), Encoding::Shares8);
        let at = |z: usize| {
            let view = |d: Vec3| View { direction: d, light, lobes: phases(d.dot(light)) };
            let mean = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y].map(|d| {
                let lit = decode(Encoding::Shares8, column[z], &view(d));
                if matches!(outside, Outside::Source) { lit.source } else { lit.sky }
            });
            mean.iter().sum::<f32>() / 4.0
        };
        let values: Vec<f32> = (0..HEIGHT).rev().map(at).collect();
        // Below the first few depths, in which light from the source turns into diffuse light, it only grows darker.
        let from = if matches!(outside, Outside::Source) { 8 } else { 0 };
        assert!(values[from..].windows(2).all(|w| w[1] < w[0] * 1.001), "{values:?}");
        assert!(values[HEIGHT - 1] < 0.3 * values[from], "{values:?}");
    }
}

fn direction(corners: &[Corner; 3]) -> Vec3 {
    let sum: Vec3 = corners.iter().map(|c| Vec3::from(c.direction()) * c.weight as f32).sum();
    sum.normalize()
}

#[test]
fn corners_surround_their_direction() {
    let mut worst = 0.0f32;
    for k in 0..4_000 {
        let (elevation, azimuth) = ((4.2 + k as f32 * 0.0214).to_radians(), k as f32 * 0.37);
        let asked = Vec3::new(azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin());
        let found = corners(asked.into());
        assert_eq!(found.iter().map(|c| c.weight).sum::<u32>(), SHARES);
        worst = worst.max(direction(&found).angle_between(asked));
        for corner in found {
            assert!(Vec3::from(corner.direction()).angle_between(asked) < 3.5f32.to_radians(), "{asked}");
        }
    }
    // Half a share of a step of 2.3 degrees each way, 0.1 degrees, and the curve of a triangle of that size.
    assert!(worst < 0.2f32.to_radians(), "{} degrees", worst.to_degrees());
    let vertical = corners([0.0, 0.0, 1.0]);
    assert_eq!((vertical[0].direction(), vertical[0].weight), ([0.0, 0.0, 1.0], SHARES));
    // Light from below is taken from just above the horizon.
    assert!(corners([0.8, 0.0, -0.6]).iter().all(|c| c.direction()[2] > 0.04));
}

fn cumulus(corners: [Corner; 3], encoding: Encoding) -> Light {
    let look = CloudKind::Cumulus.appearance();
    Light {
        corners,
        nodes: Nodes { first: 3, count: 2, step: 0.12 },
        voxel_height_m: 40.0,
        extinction_per_m: look.extinction_per_m,
        inverse_edge: 1.0 / look.edge,
        bounded: false,
        encoding,
    }
}

/// Root of the mean square difference of the first two stored values.
fn apart(a: &Volume, b: &Volume) -> f32 {
    let at = |volume: &Volume, k: usize| {
        let place = [(k % 61) as f32 / 61.0, (k % 59) as f32 / 59.0];
        volume.sample(place, (k % 31) as f32 / 31.0, (k % 3) as f32 * 0.5)
    };
    let sum: f32 = (0..6_000).map(|k| (at(a, k) - at(b, k)).truncate().truncate().length_squared()).sum();
    (sum / 6_000.0).sqrt()
}

#[test]
fn light_between_corners_is_near_that_of_its_own_direction() {
    let middle = |at: [i32; 2]| [Corner { at, weight: SHARES }, Corner { at, weight: 0 }, Corner { at, weight: 0 }];
    for at in [[4, 10], [30, 12]] {
        let own = Volume::of(CloudKind::Cumulus, &cumulus(middle(at), Encoding::Shares8));
        // The same direction from corners twice as far away as the grid's.
        let (a, b) = ([at[0] - 1, at[1]], [at[0] + 1, at[1]]);
        let half = SHARES / 2;
        let around = [Corner { at: a, weight: half }, Corner { at: b, weight: half }, Corner { at: a, weight: 0 }];
        let between = Volume::of(CloudKind::Cumulus, &cumulus(around, Encoding::Shares8));
        let other = Volume::of(CloudKind::Cumulus, &cumulus(middle([at[0] + 4, at[1]]), Encoding::Shares8));
        let (error, moved) = (apart(&own, &between), apart(&own, &other));
        println!("{at:?}: {error:.4} between corners, {moved:.4} four corners on");
        // Second order in the distance of the corners.
        assert!(error < 0.012 && error < 0.3 * moved, "{at:?}: {error} {moved}");
    }
}

#[test]
fn what_was_made_ahead_or_blended_twice_is_the_same() {
    let near_edge = corners(Vec3::new(0.4, 0.31, 0.75).normalize().into());
    let light = cumulus(near_edge, Encoding::Harmonics);
    let first = Volume::of(CloudKind::Cumulus, &light);
    assert_eq!(Volume::of(CloudKind::Cumulus, &light), first);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let other = Light { extinction_per_m: 0.059, ..light };
    let threaded = Volume::of(CloudKind::Cumulus, &other);
    super::library::forget();
    assert_eq!(alone.install(|| Volume::of(CloudKind::Cumulus, &other)), threaded);
    assert_ne!(threaded, first);
}

#[test]
fn nodes_enclose_every_theta_and_stay_while_weather_eases() {
    for (low, range) in [(0.1, 0.35), (-1.5, 0.35), (0.9, 0.35), (0.0, 0.0), (-0.1, 3.0)] {
        let nodes = Nodes::around(low, range, 0.16);
        let (first, last) = (nodes.theta(0), nodes.theta(nodes.count - 1));
        assert!(nodes.count <= Nodes::MOST && first <= low.max(-0.16) + 1e-6, "{low} {range}: {nodes:?}");
        assert!(last >= (low + range).clamp(-0.16, 1.0) - 1e-6, "{low} {range}: {nodes:?}");
    }
    let (a, b) = (Nodes::around(0.37, 0.35, 0.16), Nodes::around(0.40, 0.35, 0.16));
    assert_eq!(a, b);
}
