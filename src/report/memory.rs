//! What scenes hold in memory between pictures, and what a picture of each takes: part of the subject `omission`.

use super::result::Case;
use super::scene;
use super::subject::{Run, Stopped};
use super::timing::measure;
use super::units;
use crate::clouds::CloudKind;
use crate::geo::frames::enu;
use crate::geo::terrain::Terrain;
use crate::plan::Output;
use crate::reference::ReferenceExecutor;
use crate::world::World;
use crate::world::command::{Command, LayerSpec, Ownship, WeatherEdit};
use crate::world::event::Refused;
use crate::world::snapshot::Snapshot;
use glam::DVec3;

/// A scene: name, place, whether the ground has heights, elevation of the sun, whether there are clouds.
type Scene = (&'static str, [f64; 2], bool, f64, bool);

const SCENES: [Scene; 8] = [
    ("clear day at sea", [30.0, -40.0], true, 40.0, false),
    ("clear night at sea", [30.0, -40.0], true, -40.0, false),
    ("clouds by day at sea", [30.0, -40.0], true, 40.0, true),
    ("clear day over the Alps", [46.5, 8.0], true, 40.0, false),
    ("clear day over the Alps, level ground", [46.5, 8.0], false, 40.0, false),
    ("clear day over Paris", [48.857, 2.352], true, 40.0, false),
    ("clear night over Paris", [48.857, 2.352], true, -40.0, false),
    ("clouds by night over Paris", [48.857, 2.352], true, -40.0, true),
];

/// Each scene's memory and time; what it does not need is not listed with it.
pub fn cases(run: &mut Run) -> Result<(), Stopped> {
    let size_px = run.pick([160, 90], [640, 360]);
    let runs = run.pick(2, 7);
    for (name, at, heights, sun_deg, clouds) in SCENES {
        let failed = |refused: Refused| Stopped::Failed(refused.to_string());
        let snapshot = snapshot(at, heights, sun_deg, clouds, size_px).map_err(failed)?;
        let plan = scene::plan_of(&snapshot, Output::Srgb8)?;
        let mut executor = ReferenceExecutor::new();
        executor.draw(&plan);
        let (_, time_s) = measure(runs, || executor.draw(&plan));
        let held = executor.held();
        let all: usize = held.iter().map(|(_, bytes)| bytes).sum();
        let parts: Vec<String> =
            held.iter().map(|(name, bytes)| format!("{name} {}", units::bytes(*bytes as u64))).collect();
        run.record(Case::new(name, "held between pictures").time(time_s).memory(all as u64).note(parts.join(", ")))?;
    }
    Ok(())
}

/// An eye at 3 km that looks north and a little down, the moon put out.
fn snapshot(
    [latitude_deg, longitude_deg]: [f64; 2],
    heights: bool,
    sun_deg: f64,
    clouds: bool,
    size_px: [u32; 2],
) -> Result<Snapshot, Refused> {
    let mut world = World::new();
    world.set_terrain(if heights { Terrain::procedural() } else { Terrain::ELLIPSOID });
    let ownship = Ownship {
        latitude_deg,
        longitude_deg,
        altitude_m: 3_000.0,
        yaw_deg: 0.0,
        pitch_deg: -5.0,
        roll_deg: 0.0,
        velocity_ned_mps: None,
        host_frame: 0,
    };
    let cumulus: LayerSpec = scene::layer(CloudKind::Cumulus, 1_000.0, 1_000.0);
    let layers = Some(if clouds { vec![cumulus] } else { Vec::new() });
    world.apply(Command::Ownship(ownship))?;
    world.apply(Command::Weather(WeatherEdit { layers, ..Default::default() }))?;
    let mut snapshot = world.snapshot(1.0 / 60.0);
    let (up, north) = sun_deg.to_radians().sin_cos();
    snapshot.sky.sun_direction_ecef = enu(&snapshot.ownship.position) * DVec3::new(0.0, -north, up);
    snapshot.sky.moon_shines = false;
    snapshot.views.iter_mut().for_each(|view| view.size_px = size_px);
    Ok(snapshot)
}
