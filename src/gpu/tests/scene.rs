//! Scenes in which the passes are compared with their twins, in the words of their commands.

use crate::clouds::CloudKind;
use crate::geo::terrain::Terrain;
use crate::passes::relight::Lighting;
use crate::plan::{FramePlan, Output, plan};
use crate::world::World;
use crate::world::command::{
    Command, FlashKind, LayerSpec, Ownship, RegionShape, StrikeRequest, TimeEdit, ViewAction, ViewEdit, WeatherEdit,
};
use crate::world::snapshot::{DeckForm, Quality};
use crate::world::testing::{CUMULUS, EYE, STRIKE};

/// What is changed from scene to scene.
#[derive(Clone, Copy)]
pub struct Scene {
    pub coverage: f64,
    pub altitude_m: f64,
    pub pitch_deg: f64,
    pub deck_scale: u32,
    pub form: DeckForm,
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    pub strike: bool,
    pub region: bool,
    pub tower: bool,
    pub terrain: bool,
    pub night: bool,
    /// A storm cell so far ahead, km.
    pub cell_km: Option<f64>,
    pub own_lights: bool,
    /// The sun stands some degrees high.
    pub low_sun: bool,
}

/// Under broken clouds by day, looking up.
pub const BELOW: Scene = Scene {
    coverage: 0.5,
    altitude_m: 500.0,
    pitch_deg: 12.0,
    deck_scale: 1,
    form: DeckForm::Marched,
    latitude_deg: 47.0,
    longitude_deg: 8.0,
    strike: false,
    region: false,
    tower: false,
    terrain: false,
    night: false,
    cell_km: None,
    own_lights: false,
    low_sun: false,
};

/// Over the Alps, looking down at them, clouds among the crests.
pub const MOUNTAINS: Scene =
    Scene { terrain: true, latitude_deg: 46.45, altitude_m: 4500.0, pitch_deg: -14.0, coverage: 0.3, ..BELOW };

/// Over Paris by night.
pub const CITY: Scene = Scene { night: true, latitude_deg: 48.83, longitude_deg: 2.30, ..BELOW };

/// The same so low that lamps of the own ship reach the ground.
pub const LOW_OVER_A_CITY: Scene = Scene { altitude_m: 150.0, pitch_deg: -12.0, coverage: 0.0, ..CITY };

impl Scene {
    /// What one frame of it needs.
    pub fn plan(&self, output: Output) -> FramePlan {
        let mut world = World::new();
        if self.terrain {
            world.set_terrain(Terrain::procedural());
        }
        let relight = Lighting::Point;
        world.set_quality(Quality {
            deck_scale: self.deck_scale,
            deck_form: self.form,
            relight,
            ..world.peek(0.0).quality
        });
        let mut apply = |command| world.apply(command).map(|_| ()).expect("a command of a test");
        let (latitude_deg, longitude_deg) = (self.latitude_deg, self.longitude_deg);
        apply(Command::Ownship(Ownship {
            latitude_deg,
            longitude_deg,
            altitude_m: self.altitude_m,
            yaw_deg: 150.0,
            pitch_deg: self.pitch_deg,
            roll_deg: 5.0,
            ..EYE
        }));
        // 2026-06-21T09:00:00Z: the sun stands about 46 degrees high in the south-east.
        // A flash or lamps are to be seen: fourteen hours later it is night.
        let later_h = if self.strike || self.night { 14.0 } else { 0.0 } - if self.low_sun { 4.7 } else { 0.0 };
        let utc_s = 1_782_032_400.0 + later_h * 3600.0;
        apply(Command::Time(TimeEdit { utc_s: Some(utc_s), rate: Some(1.0) }));
        let layer = LayerSpec { coverage: self.coverage, ..CUMULUS };
        apply(Command::Weather(WeatherEdit { layers: Some(vec![layer]), ..Default::default() }));
        if let Some(ahead_km) = self.cell_km {
            let shape = RegionShape {
                name: "storm".into(),
                latitude_deg: latitude_deg - ahead_km * 0.866 / 111.2,
                longitude_deg: longitude_deg + ahead_km * 0.5 / (111.2 * latitude_deg.to_radians().cos()),
                size_east_m: 40_000.0,
                size_north_m: 40_000.0,
                corner_radius_m: 0.0,
                rotation_deg: 0.0,
                transition_m: 0.0,
            };
            let (kind, base_m, thickness_m) = (CloudKind::StormCell, 900.0, 12_000.0);
            let cell = LayerSpec { kind, base_m, thickness_m, coverage: 1.0, ..CUMULUS };
            let (region, layers) = (Some(shape), Some(vec![cell]));
            apply(Command::Weather(WeatherEdit { region, layers, ..Default::default() }));
        }
        if self.own_lights {
            let (landing_light, strobe) = (Some(true), Some(true));
            let (action, name) = (ViewAction::Change, "main".into());
            apply(Command::View(ViewEdit { action, name, landing_light, strobe, ..Default::default() }));
        }
        if self.region {
            let shape = RegionShape {
                name: "cell".into(),
                latitude_deg: latitude_deg - 0.05,
                longitude_deg: longitude_deg + 0.03,
                size_east_m: 8_000.0,
                size_north_m: 6_000.0,
                corner_radius_m: 2_000.0,
                rotation_deg: 30.0,
                transition_m: 1_500.0,
            };
            // A tower rises through the surroundings' layer: each is cut at the other's base and top.
            let (base_m, thickness_m) = if self.tower { (800.0, 3000.0) } else { (1000.0, 1200.0) };
            let dense = LayerSpec { coverage: 1.0, kind: CloudKind::Nimbostratus, base_m, thickness_m, ..layer };
            apply(Command::Weather(WeatherEdit {
                region: Some(shape),
                layers: Some(vec![dense]),
                ..Default::default()
            }));
        }
        if self.strike {
            apply(Command::Strike(StrikeRequest {
                latitude_deg: latitude_deg - 0.03,
                longitude_deg: longitude_deg + 0.02,
                altitude_m: Some(1500.0),
                kind: FlashKind::IntraCloud,
                seed: 1,
                ..STRIKE
            }));
        }
        apply(Command::View(ViewEdit { name: "main".into(), size_px: Some([160, 90]), ..change() }));
        let snapshot = world.snapshot(1.0 / 60.0);
        plan(&snapshot, &snapshot.views[0], output)
    }
}

/// A change of a view that there is.
pub fn change() -> ViewEdit {
    ViewEdit { action: ViewAction::Change, ..Default::default() }
}
