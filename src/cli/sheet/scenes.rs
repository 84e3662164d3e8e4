//! The sheets: which scenes stand in their rows and columns. A new sheet is one more entry of [`SHEETS`].

use crate::clouds::CloudKind;
use crate::geo::terrain::Terrain;
use crate::world::World;
use crate::world::command::{Command, LayerSpec, Ownship, RegionShape, TimeEdit, WeatherEdit};
use crate::world::event::Refused;
use crate::world::snapshot::Snapshot;

/// A sheet: labels of its rows and columns, and the scene of each cell.
pub(super) struct Sheet {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    pub(super) rows: fn() -> Vec<String>,
    pub(super) columns: fn() -> Vec<String>,
    /// The scene of a row and a column.
    pub(super) scene: fn(usize, usize) -> Scene,
}

/// All sheets.
pub(super) const SHEETS: &[Sheet] = &[TYPES, CELL, DAYS, APPROACH];

/// Where the eye is and what it sees: one cell.
#[derive(Clone, Debug)]
pub(super) struct Scene {
    /// Seconds since 1970-01-01T00:00:00 UTC.
    pub(super) utc_s: f64,
    pub(super) latitude_deg: f64,
    pub(super) longitude_deg: f64,
    pub(super) altitude_m: f64,
    pub(super) yaw_deg: f64,
    pub(super) pitch_deg: f64,
    pub(super) field_of_view_deg: f64,
    pub(super) visibility_m: f64,
    pub(super) layers: Vec<LayerSpec>,
    /// What the world is told besides.
    pub(super) more: Vec<Command>,
}

impl Scene {
    /// The world as this cell shows it, over some ground, in its first view.
    ///
    /// # Errors
    /// What the world refused.
    pub(super) fn snapshot(&self, size_px: [u32; 2], terrain: Terrain) -> Result<Snapshot, Refused> {
        let mut world = World::new();
        world.set_terrain(terrain);
        let ownship = Ownship {
            latitude_deg: self.latitude_deg,
            longitude_deg: self.longitude_deg,
            altitude_m: self.altitude_m,
            yaw_deg: self.yaw_deg,
            pitch_deg: self.pitch_deg,
            roll_deg: 0.0,
            velocity_ned_mps: None,
            host_frame: 0,
        };
        let weather = WeatherEdit {
            layers: Some(self.layers.clone()),
            visibility_m: Some(self.visibility_m),
            ..WeatherEdit::default()
        };
        let time = TimeEdit { utc_s: Some(self.utc_s), rate: Some(0.0) };
        let first = [Command::Time(time), Command::Ownship(ownship), Command::Weather(weather)];
        for command in first.into_iter().chain(self.more.iter().cloned()) {
            world.apply(command)?;
        }
        world.advance_to(0.0);
        let mut snapshot = world.snapshot(1.0 / 60.0);
        for view in &mut snapshot.views {
            (view.size_px, view.field_of_view_deg) = (size_px, self.field_of_view_deg);
        }
        Ok(snapshot)
    }
}

/// Midnight of 2026-05-01 (UTC), the night after which has a full moon.
const DAY_S: f64 = 1_777_593_600.0;

/// A moment of that day.
const fn clock(hour: u32, minute: u32) -> f64 {
    DAY_S + 3600.0 * hour as f64 + 60.0 * minute as f64
}

/// The ten genera by time of day from under, in and above.
const TYPES: Sheet = Sheet {
    name: "types",
    about: "the ten genera at four times of day, from under, in and above them",
    rows: || CloudKind::ALL.iter().map(|kind| format!("{kind:?}")).collect(),
    columns: || TIMES.iter().flat_map(|(time, _)| EYES.map(|eye| format!("{time}, {eye}"))).collect(),
    scene: |row, column| types(CloudKind::ALL[row], TIMES[column / EYES.len()].1, column % EYES.len()),
};

/// At 47 N 8 E: the sun near its highest, at about 20 and at 2 degrees, the moon high.
const TIMES: [(&str, f64); 4] =
    [("noon", clock(11, 25)), ("low sun", clock(16, 30)), ("sunset", clock(18, 20)), ("moonlight", clock(23, 20))];
const EYES: [&str; 3] = ["under", "in", "above"];

fn types(kind: CloudKind, utc_s: f64, eye: usize) -> Scene {
    // Base, thickness (m) and coverage as the genus is usually met.
    let (base_m, thickness_m, coverage) = match kind {
        CloudKind::Stratus => (400.0, 400.0, 1.0),
        CloudKind::Stratocumulus => (1_200.0, 500.0, 0.8),
        CloudKind::Cumulus => (1_200.0, 1_200.0, 0.45),
        CloudKind::Cumulonimbus | CloudKind::StormCell => (1_200.0, 9_000.0, 0.4),
        CloudKind::Nimbostratus => (800.0, 3_000.0, 1.0),
        CloudKind::Altostratus => (3_500.0, 1_000.0, 0.95),
        CloudKind::Altocumulus => (3_500.0, 400.0, 0.65),
        CloudKind::Cirrus => (9_000.0, 1_000.0, 0.5),
        CloudKind::Cirrocumulus => (8_000.0, 500.0, 0.6),
        CloudKind::Cirrostratus => (8_500.0, 1_500.0, 0.95),
    };
    let (altitude_m, pitch_deg) = match eye {
        0 => (0.5 * base_m, 22.0),
        1 => (base_m + 0.5 * thickness_m, 0.0),
        _ => (base_m + thickness_m + 1_500.0 + 0.2 * thickness_m, -14.0),
    };
    let layer =
        LayerSpec { kind, base_m, thickness_m, coverage, density: 1.0, wind_speed_mps: 0.0, wind_from_deg: 0.0 };
    Scene {
        utc_s,
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        altitude_m,
        yaw_deg: 245.0,
        pitch_deg,
        field_of_view_deg: 70.0,
        visibility_m: 60_000.0,
        layers: vec![layer],
        more: Vec::new(),
    }
}

/// A storm cell from far and near.
const CELL: Sheet = Sheet {
    name: "cell",
    about: "a storm cell of 13 km at four times of day, from 100 km, 25 km, under it, in its tower, in its anvil and above",
    rows: || TIMES.iter().map(|(time, _)| (*time).to_owned()).collect(),
    columns: || CELL_EYES.map(|eye| eye.0.to_owned()).to_vec(),
    scene: |row, column| cell(TIMES[row].1, CELL_EYES[column]),
};

/// Name, metres west and south of the cell's middle, altitude, heading and pitch; its tower stands 6 km west of the middle.
const CELL_EYES: [(&str, f64, f64, f64, f64, f64); 6] = [
    ("100 km", 5_000.0, 100_000.0, 3_000.0, 0.0, 2.0),
    ("25 km", 6_000.0, 25_000.0, 2_000.0, 0.0, 12.0),
    ("under", -1_000.0, 3_000.0, 300.0, 270.0, 25.0),
    ("in the tower", 6_000.0, 0.0, 6_000.0, 0.0, 0.0),
    ("in the anvil", -8_000.0, 0.0, 12_000.0, 270.0, 0.0),
    ("above", -30_000.0, 25_000.0, 17_000.0, 310.0, -12.0),
];

fn cell(utc_s: f64, (_, west_m, south_m, altitude_m, yaw_deg, pitch_deg): (&str, f64, f64, f64, f64, f64)) -> Scene {
    let (latitude_deg, longitude_deg) = (47.0, 8.0);
    let layer = LayerSpec {
        kind: CloudKind::StormCell,
        base_m: 1_000.0,
        thickness_m: 13_000.0,
        coverage: 1.0,
        density: 1.0,
        wind_speed_mps: 20.0,
        wind_from_deg: 270.0,
    };
    let region = RegionShape {
        name: "cell".into(),
        latitude_deg,
        longitude_deg,
        size_east_m: 40_000.0,
        size_north_m: 40_000.0,
        corner_radius_m: 0.0,
        rotation_deg: 0.0,
        transition_m: 0.0,
    };
    let weather = WeatherEdit { region: Some(region), layers: Some(vec![layer]), ..WeatherEdit::default() };
    Scene {
        utc_s,
        latitude_deg: latitude_deg - south_m / 111_200.0,
        longitude_deg: longitude_deg - west_m / (111_200.0 * latitude_deg.to_radians().cos()),
        altitude_m,
        yaw_deg,
        pitch_deg,
        field_of_view_deg: 60.0,
        visibility_m: 80_000.0,
        layers: Vec::new(),
        more: vec![Command::Weather(weather)],
    }
}

/// A day over three places under three skies.
const DAYS: Sheet = Sheet {
    name: "days",
    about: "twelve times of day under a clear, a broken and an overcast sky over a city, a coast and mountains",
    rows: || SKIES.iter().flat_map(|sky| PLACES.map(|place| format!("{sky}, {}", place.0))).collect(),
    columns: || (0..12).map(|n| format!("{:02}:00 UTC", 2 * n)).collect(),
    scene: |row, column| days(row / PLACES.len(), row % PLACES.len(), column as u32),
};

const SKIES: [&str; 3] = ["clear", "broken", "overcast"];
/// Name, latitude, longitude, altitude (m) and heading: Paris from the south-west, Nice along the shore, the Bernese Alps.
const PLACES: [(&str, f64, f64, f64, f64); 3] = [
    ("city", 48.75, 2.15, 900.0, 55.0),
    ("coast", 43.63, 7.10, 900.0, 70.0),
    ("mountains", 46.70, 7.70, 3_500.0, 140.0),
];

fn days(sky: usize, place: usize, step: u32) -> Scene {
    let (_, latitude_deg, longitude_deg, altitude_m, yaw_deg) = PLACES[place];
    let coverage = [0.0, 0.65, 1.0][sky];
    // Over the eye, so that ground and clouds are both in the picture.
    let layer = LayerSpec {
        kind: [CloudKind::Cumulus, CloudKind::Cumulus, CloudKind::Stratocumulus][sky],
        base_m: altitude_m + 700.0,
        thickness_m: [800.0, 900.0, 600.0][sky],
        coverage,
        density: 1.0,
        wind_speed_mps: 0.0,
        wind_from_deg: 0.0,
    };
    Scene {
        utc_s: clock(2 * step, 0),
        latitude_deg,
        longitude_deg,
        altitude_m,
        yaw_deg,
        pitch_deg: 0.0,
        field_of_view_deg: 70.0,
        visibility_m: 60_000.0,
        layers: if coverage > 0.0 { vec![layer] } else { Vec::new() },
        more: Vec::new(),
    }
}

/// Down to a city by night.
const APPROACH: Sheet = Sheet {
    name: "approach",
    about: "a night approach to Paris from 10 km down to 300 m, under a clear sky and through an overcast of 900 to 1,500 m",
    rows: || ["clear", "overcast"].map(str::to_owned).to_vec(),
    columns: || HEIGHTS_M.iter().map(|height_m| format!("{height_m} m")).collect(),
    scene: |row, column| approach(row == 1, HEIGHTS_M[column]),
};

const HEIGHTS_M: [f64; 8] = [10_000.0, 7_000.0, 5_000.0, 3_000.0, 2_000.0, 1_200.0, 700.0, 300.0];

/// On a path of 1 in 12 towards the middle of the city from the south-west.
fn approach(overcast: bool, altitude_m: f64) -> Scene {
    let heading_deg: f64 = 40.0;
    let (south_deg, west_deg) = (
        12.0 * altitude_m * heading_deg.to_radians().cos() / 111_200.0,
        12.0 * altitude_m * heading_deg.to_radians().sin(),
    );
    let layer = LayerSpec {
        kind: CloudKind::Stratocumulus,
        base_m: 900.0,
        thickness_m: 600.0,
        coverage: 1.0,
        density: 1.0,
        wind_speed_mps: 0.0,
        wind_from_deg: 0.0,
    };
    Scene {
        // On 2026-05-16 the moon is new.
        utc_s: clock(23, 30) + 15.0 * 86_400.0,
        latitude_deg: 48.857 - south_deg,
        longitude_deg: 2.352 - west_deg / (111_200.0 * 48.5f64.to_radians().cos()),
        altitude_m,
        yaw_deg: heading_deg,
        pitch_deg: -4.8,
        field_of_view_deg: 60.0,
        visibility_m: 40_000.0,
        layers: if overcast { vec![layer] } else { Vec::new() },
        more: Vec::new(),
    }
}
