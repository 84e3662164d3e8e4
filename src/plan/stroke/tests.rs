//! Strokes of a plan: none without a flash, the channel's light in its pixels at any distance, nothing behind the horizon.

use super::*;
use crate::geo::wgs84::{from_ecef, to_ecef};
use crate::lightning::flash::{FlashKind, Light, Polarity};
use crate::lightning::strike::{StrikeSpec, grow_strike};
use crate::lightning::tables::Tables;
use crate::passes::stroke::NARROWEST_PX;
use crate::plan::scenes::{clear_day, cumulus_at, flash, place};
use crate::plan::{FramePlan, Output, plan};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A clear day with a stroke to ground so far north of the eye, which looks there from a height.
fn bolt(north_m: f64, eye_m: f64) -> Snapshot {
    let mut snapshot = clear_day();
    snapshot.views[0].size_px = [640, 360];
    snapshot.ownship.position.altitude_m = eye_m;
    let eye = Eye::new(&snapshot.ownship, &snapshot.views[0], &snapshot.terrain);
    let there = from_ecef(eye.ground_ecef_m + eye.enu * DVec3::new(0.0, north_m, 0.0));
    snapshot.flashes.push(shown(Geodetic { altitude_m: 3_000.0, ..there }));
    snapshot
}

/// A flash to ground with its channel: a first stroke and a later one.
fn shown(position: Geodetic) -> FlashState {
    let spec = StrikeSpec {
        kind: FlashKind::CloudToGround,
        polarity: Polarity::Negative,
        seed: 7,
        origin_m: position.altitude_m,
        cloud_m: [2_000.0, 4_000.0],
        grounds_m: Vec::new(),
    };
    let channel = grow_strike(&spec, &mut Tables::default(), &AtomicBool::new(false)).expect("a right specification");
    let light = |branches, amount| Light { channel: 0, branches, span: [0.0, 1.0], amount };
    FlashState {
        lights: vec![light(true, 3e9), light(false, 1e9)],
        channel: Some(Arc::new(channel)),
        ..flash(position)
    }
}

fn planned(snapshot: &Snapshot) -> FramePlan {
    plan(snapshot, &snapshot.views[0], Output::Srgb8)
}

fn strokes_of(snapshot: &Snapshot) -> StrokePlan {
    planned(snapshot).strokes.expect("a flash shows its channel")
}

#[test]
fn a_scene_without_a_flash_has_none_of_it() {
    for mut snapshot in [clear_day(), cumulus_at(place(47.0, 8.0, 1_500.0))] {
        let quiet = planned(&snapshot);
        assert!(quiet.strokes.is_none());
        assert!(quiet.notes.iter().any(|note| note.pass == "stroke" && !note.kept));
        // A flash between two strokes, and one whose channel is still being grown.
        let dark = FlashState { lights: Vec::new(), intensity_cd: 0.0, ..shown(place(47.05, 8.0, 3_000.0)) };
        snapshot.flashes = vec![dark.clone()];
        assert!(planned(&snapshot).strokes.is_none());
        snapshot.flashes = vec![FlashState { channel: None, ..shown(dark.position) }];
        let growing = planned(&snapshot);
        assert!(growing.strokes.is_none() && snapshot.provisional());
        assert!(growing.notes.iter().any(|note| note.pass == "stroke" && note.why.contains("being grown")));
        snapshot.flashes = vec![shown(dark.position)];
        assert!(planned(&snapshot).strokes.is_some() && !snapshot.provisional());
    }
}

#[test]
fn the_channels_light_comes_to_its_pixels_from_any_distance() {
    // All of it is in the picture, which shows 18 degrees up.
    for north_m in [10_000.0, 17_000.0, 30_000.0, 60_000.0] {
        let snapshot = bolt(north_m, 1_500.0);
        let (plan, strokes) = (planned(&snapshot), strokes_of(&snapshot));
        let flash = &snapshot.flashes[0];
        let channel = flash.channel.as_deref().expect("grown");
        let lit = channel.lit(&flash.lights);
        let camera = &plan.camera;
        let there = enu(&flash.position);
        let base = to_ecef(&Geodetic { altitude_m: 0.0, ..flash.position });
        let eye = Eye::new(&snapshot.ownship, &snapshot.views[0], &snapshot.terrain);
        // Candela over distance squared over the solid angle of a pixel in the middle of the picture, stretch by stretch at the
        // finest; the pixel's own angle shrinks with the cube of its cosine.
        let middle = 2.0 * Vec3::from(camera.right).length() / camera.width_px
            * (2.0 * Vec3::from(camera.up).length() / camera.height_px);
        let mut expected = 0.0;
        channel.visit(0.0, |stretch| {
            let at = |point: u32| {
                let local = DVec3::from_array(channel.points[point as usize].position_m.map(f64::from));
                eye.enu.transpose() * (base + there * local - eye.ground_ecef_m) - DVec3::Z * eye.height_m
            };
            let away = 0.5 * (at(stretch.from) + at(stretch.to));
            let cosine = away.normalize().dot(Vec3::from(camera.forward).as_dvec3());
            let range_m = away.length();
            let air =
                camera.air_transmittance(camera.height_at((away.z / range_m) as f32, range_m as f32), range_m as f32);
            let solid = f64::from(middle) * cosine.powi(3);
            expected += lit.of(channel, &stretch) / LUMENS / (range_m * range_m) / solid * f64::from(air);
        });
        let found: f64 = strokes.segments.iter().map(|segment| f64::from(segment.light)).sum();
        // Lines that leave out what is below a quarter of a pixel lie up to that nearer or farther: 1e-4 of the range; the
        // middle of a stretch stands for it, which at a fifth of the range is off by 0.2^2 / 12 of its light.
        assert!((found / expected - 1.0).abs() < 5e-3, "{north_m}: {found} {expected}");
    }
}

#[test]
fn detail_follows_the_distance_and_everything_has_its_place() {
    let [near, far] = [5_000.0, 60_000.0].map(|north_m| strokes_of(&bolt(north_m, 300.0)));
    assert!(far.segments.len() < 1_500, "a bolt far away needs few stretches: {}", far.segments.len());
    assert!(near.segments.len() > 2 * far.segments.len(), "{} {}", near.segments.len(), far.segments.len());
    for strokes in [near, far] {
        let nodes = strokes.nodes.len() as u32;
        for segment in &strokes.segments {
            assert!(segment.node + 1 < nodes && segment.sigma_px >= NARROWEST_PX);
            let shares = [segment.share_from, segment.share_to];
            assert!(shares.iter().all(|share| (-1e-3..=1.001).contains(share)), "{shares:?}");
        }
        assert!(strokes.sources.iter().all(|source| source.node < nodes));
        assert!(strokes.sources.len() <= MOST_SOURCES && !strokes.sources.is_empty());
        let sum: f32 = strokes.sources.iter().map(|source| source.intensity_cd).sum();
        // Both lights together: 4e9 lm over 4 pi.
        assert!((sum / 3.183e8 - 1.0).abs() < 1e-2, "{sum}");
        let total: f32 = strokes.glow.iter().sum();
        assert!((total - 1.0).abs() < 1e-5);
    }
}

#[test]
fn a_long_bolt_has_no_gap_and_no_jump_where_its_detail_changes() {
    let mut before: Option<Vec<Segment>> = None;
    for step in 0..60 {
        let strokes = strokes_of(&bolt(4_000.0 - 2.0 * f64::from(step), 1_000.0));
        if let Some(before) = &before {
            // Every stretch lies within a pixel of one of the picture before: 2 m nearer is a fraction of a pixel, detail that
            // comes or goes a quarter.
            let near = |at: [f32; 2]| {
                let at = glam::Vec2::from(at);
                let to = |s: &Segment| {
                    let (a, b) = (glam::Vec2::from(s.from_px), glam::Vec2::from(s.to_px));
                    let share = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-9)).clamp(0.0, 1.0);
                    at.distance(a.lerp(b, share))
                };
                before.iter().map(to).fold(f32::INFINITY, f32::min)
            };
            let apart = strokes.segments.iter().step_by(7).map(|s| near(s.to_px)).fold(0.0, f32::max);
            assert!(apart < 1.0, "step {step}: {apart}");
        }
        before = (step % 10 == 0).then(|| strokes.segments.clone()).or(before.filter(|_| step % 10 != 9));
    }
}

#[test]
fn what_is_behind_the_horizon_or_the_eye_is_not_drawn() {
    // 10 m up the horizon is 11 km away; 60 km away the lowest 190 m are behind it.
    let snapshot = bolt(60_000.0, 10.0);
    let (camera, strokes) = (planned(&snapshot).camera, strokes_of(&snapshot));
    let lowest = strokes
        .segments
        .iter()
        .flat_map(|s| [s.from_px, s.to_px])
        .fold([0.0f32; 2], |a, b| if b[1] > a[1] { b } else { a });
    let up = camera.ray(lowest[0], lowest[1]).z;
    let dip = -(2.0 * 10.0f32 / camera.earth_m).sqrt();
    // Half a pixel is 0.8 mrad; the sphere may be 4 m over the channel's foot.
    assert!((up - dip).abs() < 1e-3, "{up} {dip}");
    let behind = strokes_of(&bolt(-5_000.0, 1_500.0));
    assert!(behind.segments.is_empty() && !behind.sources.is_empty(), "its light in the air is all round");
    assert!(strokes_of(&bolt(5_000.0, 1_500.0)).segments.len() > 100);
}

#[test]
fn extreme_places_of_a_flash_give_finite_strokes() {
    for position in [
        place(47.0, 8.0, 1_500.0),
        place(47.0, 8.0, -500.0),
        place(-47.0, -172.0, 3_000.0),
        place(90.0, 0.0, 3_000.0),
        place(47.01, 8.0, 50_000.0),
    ] {
        let mut snapshot = clear_day();
        snapshot.flashes.push(shown(position));
        let plan = planned(&snapshot);
        let Some(strokes) = plan.strokes else { continue };
        let numbers: &[f32] = bytemuck::cast_slice(&strokes.segments);
        let nodes: &[f32] = bytemuck::cast_slice(&strokes.nodes);
        assert!(numbers.iter().chain(nodes).all(|x| x.is_finite()), "{position:?}");
        assert!(strokes.strokes.scale > 0.0 && strokes.strokes.scale.is_finite());
    }
}

#[test]
fn sixty_four_flashes_at_once_stay_within_bounds() {
    let mut snapshot = bolt(600.0, 300.0);
    snapshot.flashes = vec![snapshot.flashes[0].clone(); 64];
    let strokes = strokes_of(&snapshot);
    assert!(strokes.segments.len() <= MOST_SEGMENTS + 64 * 200, "{}", strokes.segments.len());
    assert_eq!(strokes.sources.len(), MOST_SOURCES);
}

#[test]
fn linear_pictures_hold_the_brightest_stroke() {
    let snapshot = bolt(2_500.0, 1_500.0);
    let [seen, linear] = [Output::Srgb8, Output::LinearRgb].map(|output| plan(&snapshot, &snapshot.views[0], output));
    let factor = seen.camera.exposure / linear.camera.exposure;
    assert!(factor >= 1.0 && factor.log2().fract() == 0.0, "a power of two changes no digit: {factor}");
    let brightest = linear.strokes.as_ref().map_or(0.0, |strokes| strokes.brightest);
    assert!(brightest * linear.camera.exposure <= BRIGHTEST);
    assert!(linear.strokes.as_ref().is_some_and(|strokes| strokes.strokes.scale * brightest <= BRIGHTEST));
}

#[test]
fn the_ground_is_lit_by_the_channel_and_not_by_its_middle() {
    let snapshot = bolt(5_000.0, 1_500.0);
    let ground = planned(&snapshot).ground.expect("the ground is in sight");
    let lights = &ground.flash[..ground.flashes as usize];
    assert_eq!(lights.len(), SOURCES);
    let sum: f32 = lights.iter().map(|light| light.intensity).sum();
    // 4e9 lm over (4 pi)^2.
    assert!((sum / 2.533e7 - 1.0).abs() < 1e-2, "{sum}");
    let low = lights.iter().map(|light| light.position_m[2]).fold(f32::INFINITY, f32::min);
    assert!(low < 600.0, "some of it is near the ground: {low}");
    // Too many of them: a point each, as before.
    let mut many = snapshot.clone();
    many.flashes = vec![snapshot.flashes[0].clone(); FLASHES];
    assert_eq!(planned(&many).ground.map(|ground| ground.flashes as usize), Some(FLASHES));
}
