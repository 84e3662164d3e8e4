//! The own ship's lights: which lamps shine in a picture, and what lies before them.

use super::eye::Eye;
use super::illuminance::Level;
use super::{LayerPlan, PassNote};
use crate::clouds::density::DensityVolume;
use crate::geo::frames::{ENU_NED, enu, ned_from_body};
use crate::passes::beams::{Beams, LAMPS, LOOKS, Lamp, ranges_m, twin};
use crate::passes::common::{Camera, HAZE_SCALE_M};
use crate::passes::deck::clumps::varied;
use crate::passes::deck::field::{BOUNDS_WIDTH, Textures, margin};
use crate::world::command::Exposure;
use crate::world::snapshot::{Snapshot, ViewState};
use glam::Vec3;
use std::f32::consts::{FRAC_1_SQRT_2, PI};

/// Extinction below which air is clear enough that lamps light nothing in it: a visibility of 5 km.
const CLEAR_PER_M: f32 = 6e-4;
/// Luminous intensity of one landing light on its axis, and the angle at which it has fallen to 1/e. Chosen: sealed beams of
/// airliners are told to have some hundred thousand candela in a beam about 11 degrees wide.
const LANDING_CD: f32 = 400_000.0;
const LANDING_HALF_RAD: f32 = 0.12;
/// How far the landing lights point down against the body's axis.
const LANDING_DOWN_RAD: f32 = 0.05;
/// Effective intensity of a strobe: the least that 14 CFR 25.1401 asks for near the horizontal; and the constant of Blondel
/// and Rey by which that is meant, `I t / (a + t)`.
const STROBE_EFFECTIVE_CD: f64 = 400.0;
const BLONDEL_REY_S: f64 = 0.2;
/// A flash begins every so many seconds and lasts so long; 14 CFR 25.1401 allows 40 to 100 a minute.
const STROBE_PERIOD_S: f64 = 1.2;
const STROBE_FLASH_S: f64 = 0.1;
/// Places of the lamps in the body's axes, forward, right, down, from the ship's origin, m: an airliner of 34 m span. Landing
/// lights at the wings' roots, strobes at their tips.
const LANDING_M: [[f32; 3]; 2] = [[-2.0, -3.5, 2.0], [-2.0, 3.5, 2.0]];
const STROBE_M: [[f32; 3]; 2] = [[-8.0, -17.0, 0.0], [-8.0, 17.0, 0.0]];
/// Least illuminance right below a lamp whose light on the ground is seen, lux, and against the ground's other light.
const LEAST_LUX: f32 = 1.0;
const LEAST_SHARE: f32 = 0.02;
/// Share of a strobe's light that the exposure answers to, as it does to lightning.
const FLASH_METERED: f32 = 0.3;

/// The lamps of a view that shine in something; `None` where they are off or the air is clear.
pub fn lit(
    snapshot: &Snapshot,
    eye: &Eye,
    view: &ViewState,
    camera: &Camera,
    layers: &[LayerPlan],
    notes: &mut Vec<PassNote>,
) -> Option<Beams> {
    let mut note = |kept, why: &str| notes.push(PassNote { pass: "beams", kept, why: why.to_owned() });
    let lamps = lamps(snapshot, eye, view);
    if lamps.is_empty() {
        note(false, "no light of the own ship shines in this frame");
        return None;
    }
    if lamps.iter().all(|lamp| Vec3::from(lamp.position_m).length() > ranges_m()[LOOKS - 1]) {
        note(false, "the own ship is far away");
        return None;
    }
    let extinction_per_m = extinction(camera, layers);
    if extinction_per_m.iter().all(|extinction| *extinction < CLEAR_PER_M) {
        note(false, "before the own ship's lights the air is clear");
        return None;
    }
    note(true, "the own ship's lights shine in cloud or haze");
    let mut beams = Beams { lamps: 0, pad0: 0, pad1: 0, pad2: 0, lamp: [Lamp::default(); LAMPS], extinction_per_m };
    for (slot, lamp) in beams.lamp.iter_mut().zip(lamps) {
        *slot = lamp;
        beams.lamps += 1;
    }
    Some(beams)
}

/// The own ship's lamps that shine, about the eye: they sit on the own ship, whatever carries the view.
fn lamps(snapshot: &Snapshot, eye: &Eye, view: &ViewState) -> Vec<Lamp> {
    let strobe = strobe_cd(snapshot.shutter_s);
    let (origin, [forward, right, down]) = match view.carrier {
        None => {
            let [forward, right, down] = eye.body;
            let [f, r, d] = view.offset_m.map(|v| v as f32);
            (-(forward * f + right * r + down * d), eye.body)
        }
        Some(_) => {
            let ship = &snapshot.ownship;
            let axes = eye.enu.transpose() * enu(&ship.position) * ENU_NED * ned_from_body(&ship.attitude);
            let origin = eye.place(&ship.position) - Vec3::new(0.0, 0.0, eye.height_m as f32);
            (origin, [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.as_vec3()))
        }
    };
    let place = |[f, r, d]: [f32; 3]| (origin + forward * f + right * r + down * d).into();
    let (sin, cos) = LANDING_DOWN_RAD.sin_cos();
    let landing = LANDING_M.map(|body| Lamp {
        position_m: place(body),
        intensity_cd: LANDING_CD,
        axis: (forward * cos + down * sin).into(),
        narrowness: 1.0 / (LANDING_HALF_RAD * LANDING_HALF_RAD),
    });
    let flashing = STROBE_M.map(|body| Lamp {
        position_m: place(body),
        intensity_cd: strobe as f32,
        axis: forward.into(),
        narrowness: 0.0,
    });
    let lamps = landing.into_iter().filter(|_| view.lights.landing);
    lamps.chain(flashing.into_iter().filter(|_| view.lights.strobe && strobe > 0.0)).collect()
}

/// The lamps that light the ground so much that it is seen: near it, and by night.
pub fn on_ground(
    snapshot: &Snapshot,
    eye: &Eye,
    view: &ViewState,
    ground: &Level,
    up: f32,
    notes: &mut Vec<PassNote>,
) -> Vec<Lamp> {
    let mut lamps = lamps(snapshot, eye, view);
    let any = !lamps.is_empty();
    let over_m =
        (snapshot.ownship.position.altitude_m - snapshot.terrain.height_m(&snapshot.ownship.position)).max(1.0);
    let least_lux = LEAST_LUX.max(LEAST_SHARE * ground.horizontal_lux(up).y);
    lamps.retain(|lamp| lamp.intensity_cd / (over_m * over_m) as f32 > least_lux);
    let why = match (any, lamps.is_empty()) {
        (false, _) => "no light of the own ship shines in this frame",
        (true, true) => "the ground is too far away or too bright for the own ship's lights",
        (true, false) => "the own ship's lights shine on the ground",
    };
    notes.push(PassNote { pass: "beams on the ground", kept: !lamps.is_empty(), why: why.to_owned() });
    lamps
}

/// Mean intensity of a strobe over a shutter interval, cd: flashes are even in light while they last.
pub fn strobe_cd([begin_s, end_s]: [f64; 2]) -> f64 {
    let peak_cd = STROBE_EFFECTIVE_CD * (BLONDEL_REY_S + STROBE_FLASH_S) / STROBE_FLASH_S;
    // Seconds of light from simulation time 0 to a moment.
    let shone = |s: f64| {
        let periods = (s / STROBE_PERIOD_S).floor();
        periods * STROBE_FLASH_S + (s - periods * STROBE_PERIOD_S).min(STROBE_FLASH_S)
    };
    let length_s = end_s - begin_s;
    if length_s > 0.0 { peak_cd * ((shone(end_s) - shone(begin_s)) / length_s).clamp(0.0, 1.0) } else { 0.0 }
}

/// The exposure of a camera with the lamps' light in its picture, where it follows the light. It answers as to any other:
/// with the power 0.8 of the illuminance.
pub fn exposure(asked: Exposure, camera: &Camera, beams: &Beams, night_exposure: f32) -> f32 {
    let Exposure::Automatic = asked else { return camera.exposure };
    let [across, along] = [camera.right, camera.up].map(|axis| Vec3::from(axis) * FRAC_1_SQRT_2);
    let ahead = Vec3::from(camera.forward);
    let rays = [ahead, ahead + across, ahead - across, ahead + along, ahead - along];
    let part = |lamps: &[Lamp]| {
        let mut own = Beams { lamps: lamps.len() as u32, lamp: [Lamp::default(); LAMPS], ..*beams };
        own.lamp[..lamps.len()].copy_from_slice(lamps);
        rays.iter().map(|ray| twin::luminance(&own, ray.normalize(), f32::INFINITY)).sum::<f32>() / rays.len() as f32
    };
    let (steady, flashing): (Vec<Lamp>, Vec<Lamp>) =
        beams.lamp[..beams.lamps as usize].iter().partition(|lamp| lamp.narrowness > 0.0);
    let more_lux = PI * (part(&steady) + FLASH_METERED * part(&flashing));
    // The illuminance that the exposure was made for, of which it is the power -0.8; at its dark end it is that of the end.
    let lux = 1e5 * (night_exposure / camera.exposure).powf(1.25);
    camera.exposure * (lux / (lux + more_lux)).powf(0.8)
}

/// Extinction of cloud and haze along the picture's axis at the ranges of the looks, 1/m.
fn extinction(camera: &Camera, layers: &[LayerPlan]) -> [f32; LOOKS] {
    let bounds = [u8::MAX; BOUNDS_WIDTH * BOUNDS_WIDTH];
    let direction = Vec3::from(camera.forward).normalize();
    let reach_m = ranges_m()[LOOKS - 1];
    let near: Vec<_> = layers
        .iter()
        .filter(|plan| {
            let layer = &plan.layer;
            camera.eye_m + reach_m > layer.base_m && camera.eye_m - reach_m < layer.base_m + layer.thickness_m
        })
        .map(|plan| (&plan.layer, DensityVolume::of(plan.kind)))
        .collect();
    ranges_m().map(|t| {
        let height = camera.height_at(direction.z, t);
        let p = direction * t + Vec3::new(0.0, 0.0, camera.eye_m);
        let haze = camera.haze_per_m * (-height.max(0.0) / HAZE_SCALE_M).exp();
        let cloud = near.iter().map(|(layer, volume)| {
            let textures = Textures::unlit(&volume.shape, &bounds);
            if height < layer.base_m || height > layer.base_m + layer.thickness_m {
                return 0.0;
            }
            let found = margin(layer, &textures, camera.earth_m, p, height, t);
            let density = varied(layer, &textures, camera.earth_m, p, height, t);
            layer.extinction_per_m * (found * layer.inverse_edge).clamp(0.0, 1.0) * density
        });
        haze + cloud.sum::<f32>()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clouds::CloudKind;
    use crate::plan::scenes::{clear_day, layer, sun};
    use crate::plan::{FramePlan, Output, plan};
    use crate::world::snapshot::OwnLights;

    /// A night with lights on, under or in an overcast.
    fn night(altitude_m: f64, lights: OwnLights) -> Snapshot {
        let mut snapshot = sun(clear_day(), -30.0);
        snapshot.ownship.position.altitude_m = altitude_m;
        snapshot.weather.layers = vec![layer(CloudKind::Stratus, 1_000.0, 800.0)];
        snapshot.weather.layers[0].coverage = 1.0;
        snapshot.views[0].lights = lights;
        snapshot
    }

    fn plan_of(snapshot: &Snapshot) -> FramePlan {
        plan(snapshot, &snapshot.views[0], Output::LinearRgb)
    }

    const LANDING: OwnLights = OwnLights { landing: true, strobe: false };
    const STROBE: OwnLights = OwnLights { landing: false, strobe: true };

    #[test]
    fn lamps_are_planned_in_cloud_and_haze_alone_and_only_when_on() {
        let kept = |snapshot: &Snapshot| {
            let plan = plan_of(snapshot);
            let note = plan.notes.iter().find(|note| note.pass == "beams").expect("a note").kept;
            assert_eq!(note, plan.beams.is_some());
            plan.beams.map_or(0, |beams| beams.lamps)
        };
        assert_eq!(kept(&night(1_400.0, OwnLights::default())), 0);
        assert_eq!(kept(&night(1_400.0, LANDING)), 2);
        assert_eq!(kept(&night(1_400.0, OwnLights { landing: true, strobe: true })), 4);
        assert_eq!(kept(&night(5_000.0, LANDING)), 0, "clear air");
        let mut hazy = night(300.0, LANDING);
        hazy.weather.visibility_m = 1_500.0;
        assert_eq!(kept(&hazy), 2);
        // Between two flashes a strobe needs nothing.
        let mut dark = night(1_400.0, STROBE);
        assert_eq!(kept(&dark), 2);
        dark.shutter_s = [0.5, 0.516];
        assert_eq!(kept(&dark), 0);
    }

    #[test]
    fn all_of_a_flash_is_seen_whatever_the_frame_rate_and_its_light_is_that_of_the_rule() {
        for rate_hz in [24.0, 30.0, 60.0, 120.0] {
            // 12 s are ten flashes.
            let frames = (12.0 * rate_hz) as u32;
            let interval = |k: u32| [f64::from(k) / rate_hz, f64::from(k + 1) / rate_hz];
            let shone: f64 = (0..frames).map(|k| strobe_cd(interval(k)) / rate_hz).sum();
            // Blondel and Rey: an effective 400 cd of a flash of 0.1 s are 400 (0.2 + 0.1) cd s.
            assert!((shone / (10.0 * 400.0 * 0.3) - 1.0).abs() < 1e-9, "{rate_hz}: {shone}");
        }
        assert_eq!(strobe_cd([3.0, 3.0]), 0.0);
        assert_eq!(strobe_cd([0.2, 1.1]), 0.0);
    }

    #[test]
    fn exposure_answers_to_lamps_by_night_and_hardly_by_day() {
        let [dark, lit] =
            [OwnLights::default(), LANDING].map(|lights| plan_of(&night(1_400.0, lights)).camera.exposure);
        assert!(lit < 0.7 * dark, "{lit} {dark}");
        let mut fixed = night(1_400.0, LANDING);
        fixed.views[0].exposure = Exposure::Ev100(3.0);
        let mut without = fixed.clone();
        without.views[0].lights = OwnLights::default();
        assert_eq!(plan_of(&fixed).camera.exposure, plan_of(&without).camera.exposure);
        let [dark, lit] =
            [OwnLights::default(), LANDING].map(|lights| plan_of(&sun(night(1_400.0, lights), 40.0)).camera.exposure);
        assert!((lit / dark - 1.0).abs() < 0.01, "{lit} {dark}");
    }

    #[test]
    fn lamps_stand_where_the_body_has_them_whatever_the_view_and_the_attitude() {
        let mut snapshot = night(1_400.0, LANDING);
        snapshot.ownship.attitude.yaw_rad = 0.7;
        snapshot.views[0].attitude.yaw_rad = -1.2;
        snapshot.views[0].offset_m = [10.0, -0.5, -1.0];
        let beams = plan_of(&snapshot).beams.expect("lit");
        let forward = Vec3::new(0.7f32.sin(), 0.7f32.cos(), 0.0);
        let lamp = beams.lamp[1];
        // 12 m behind the eye and 4 m to its right.
        let place = Vec3::from(lamp.position_m);
        let right = Vec3::new(0.7f32.cos(), -0.7f32.sin(), 0.0);
        assert!((place.dot(forward) + 12.0).abs() < 1e-3 && (place.dot(right) - 4.0).abs() < 1e-3, "{place}");
        assert!((Vec3::from(lamp.axis).dot(forward) - LANDING_DOWN_RAD.cos()).abs() < 1e-4);
    }
}
