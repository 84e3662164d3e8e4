//! Packets in, a world out: each test says something as a host would and looks at the snapshot.

use super::super::packets::*;
use super::super::{ByteOrder, Version};
use super::*;
use crate::clouds::CloudKind;
use crate::geo::frames::{ENU_NED, ned_from_body};
use crate::geo::terrain::Terrain;
use crate::geo::wgs84::to_ecef;
use crate::geo::{Attitude, Geodetic};
use crate::world::World;
use crate::world::command::{Command, FlashKind, Polarity, Strokes};
use crate::world::regions::signed_distance_m;
use crate::world::snapshot::Snapshot;

#[path = "tests/entities.rs"]
mod entities_tests;
#[path = "tests/strikes.rs"]
mod strikes_tests;
#[path = "tests/views.rs"]
mod views_tests;
#[path = "tests/weather.rs"]
mod weather_tests;

const CONVENTION: Convention =
    Convention { sea_level_m: 0.0, seed: 1, size_px: [640, 360], terrain: Terrain::ELLIPSOID };

/// A host and the world that it speaks to.
struct Host {
    scene: Scene,
    world: World,
    moment: Moment,
    version: Version,
    refused: Vec<Refused>,
    strikes: Vec<(u16, StrikeRequest)>,
    questions: usize,
}

impl Host {
    fn new() -> Self {
        Self::with(CONVENTION, Version::V3)
    }

    fn with(convention: Convention, version: Version) -> Self {
        let moment = Moment { host_frame: 1, timestamp: None, extrapolate: false, now_s: 0.0 };
        let (scene, world) = (Scene::new(convention), World::new());
        Self { scene, world, moment, version, refused: Vec::new(), strikes: Vec::new(), questions: 0 }
    }

    /// Says these packets in one message. Returns how many commands the world took.
    fn says(&mut self, packets: impl IntoIterator<Item = Packet>) -> usize {
        let packets = packets.into_iter().collect();
        let message = Message { version: self.version, byte_order: ByteOrder::Little, packets, skipped: Vec::new() };
        let mut commands = 0;
        for consequence in self.scene.take(&message, &self.moment) {
            match consequence {
                Consequence::Command(command) => {
                    commands += 1;
                    self.refused.extend(self.world.apply(command).err());
                }
                Consequence::Strike { strike_id, request } => {
                    self.refused.extend(self.world.apply(Command::Strike(request.clone())).err());
                    self.strikes.push((strike_id, request));
                }
                Consequence::Question(_) => self.questions += 1,
                Consequence::Refused(refused) => self.refused.push(refused),
            }
        }
        commands
    }

    fn sees(&self) -> Snapshot {
        assert_eq!(self.refused, []);
        self.world.peek(0.02)
    }
}

fn ownship(latitude: f64, longitude: f64, altitude: f64) -> EntityControl {
    EntityControl { entity_state: 1, lat_xoff: latitude, lon_yoff: longitude, alt_zoff: altitude, ..Default::default() }
}

fn cloud(layer_id: u8, cloud_type: u8, base: f32, thickness: f32) -> WeatherControl {
    WeatherControl {
        layer_id,
        cloud_type,
        weather_enable: true,
        coverage: 50.0,
        base_elevation: base,
        thickness,
        ..Default::default()
    }
}

fn degrees(attitude: &Attitude) -> [f64; 3] {
    [attitude.yaw_rad, attitude.pitch_rad, attitude.roll_rad].map(f64::to_degrees)
}

fn assert_close(given: impl IntoIterator<Item = f64>, expected: impl IntoIterator<Item = f64>, tolerance: f64) {
    let (given, expected): (Vec<f64>, Vec<f64>) = (given.into_iter().collect(), expected.into_iter().collect());
    assert_eq!(given.len(), expected.len());
    for (a, b) in given.iter().zip(&expected) {
        assert!((a - b).abs() <= tolerance, "{given:?}, expected {expected:?}");
    }
}

#[test]
fn numbers_that_are_none_never_reach_the_world() {
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut host = Host::new();
        let before = host.sees();
        let single = wrong as f32;
        let packets: Vec<Packet> = vec![
            ownship(wrong, 8.0, 500.0).into(),
            EntityControl { roll: single, ..ownship(47.0, 8.0, 500.0) }.into(),
            ViewControl { yaw_enable: true, yaw: single, ..Default::default() }.into(),
            ViewDefinition { top_enable: true, top: single, ..Default::default() }.into(),
            CelestialSphereControl { star_field_intensity: single, ..Default::default() }.into(),
            AtmosphereControl { global_visibility_range: single, ..Default::default() }.into(),
            WeatherControl { aerosol_concentration: single, ..cloud(1, 7, 1_000.0, 500.0) }.into(),
            EnvironmentalRegionControl { region_state: 1, size_x: single, ..Default::default() }.into(),
            HatHotRequest { alt_zoff: wrong, ..Default::default() }.into(),
            Strike { altitude: wrong, ..Default::default() }.into(),
            TimedStrike { delay: single, ..Default::default() }.into(),
        ];
        let count = packets.len();
        host.says(packets);
        assert_eq!((host.refused.len(), host.questions), (count, 0), "{:?}", host.refused);
        assert!(host.refused.iter().all(|refused| refused.limit == "a finite number"));
        host.refused.clear();
        assert_eq!(host.sees(), before, "{wrong}");
    }
    // Finite and out of range: the world's own limits hold, and the field is named.
    let mut host = Host::new();
    host.says([EntityControl { pitch: 91.0, ..ownship(47.0, 8.0, 500.0) }.into()]);
    host.says([ownship(47.0, 8.0, 1e9).into()]);
    let fields: Vec<&str> = host.refused.iter().map(|refused| refused.field.as_str()).collect();
    assert_eq!(fields, ["pitch_deg", "altitude_m"]);
}

#[test]
fn what_would_fill_memory_is_refused() {
    let mut host = Host::new();
    let entities = (0..2_000).map(|entity_id| EntityControl { entity_id, ..ownship(47.0, 8.0, 500.0) }.into());
    host.says(entities);
    let regions = (0..300)
        .map(|region_id| EnvironmentalRegionControl { region_id, region_state: 1, ..Default::default() }.into());
    host.says(regions);
    let views = (0..20).map(|view_id| ViewControl { view_id, ..Default::default() }.into());
    host.says(views);
    let layers =
        (0..2_000).map(|id| WeatherControl { scope: 1, entity_region_id: id, ..cloud(1, 7, 1_000.0, 500.0) }.into());
    host.says(layers);
    assert_eq!(
        host.refused.len(),
        (2_000 - 1_024) + (300 - 256) + (20 - 16) + (2_000 - 1_024),
        "{:?}",
        host.refused.first()
    );
}
