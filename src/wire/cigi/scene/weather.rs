//! Weather: layers of the globe, of regions and of entities become cloud layers, regions and storms.

use super::entities::OWNSHIP;
use super::storm::{Storm, near as near_storm};
use super::{Entities, half_turn};
use crate::clouds::CloudKind;
use crate::outputs::air::{Air, AirMass};
use crate::units::deg;
use crate::wire::cigi::Version;
use crate::wire::cigi::packets::{AtmosphereControl, EnvironmentalRegionControl, WeatherControl};
use crate::wire::limits::{CIGI_REGIONS, CIGI_WEATHER_LAYERS};
use crate::world::command::{Command, LayerSpec, RegionShape, StormRequest, WeatherEdit};
use crate::world::event::Refused;
use crate::world::limits::{MAX_REGIONS, MAX_STORMS, REGION_SIZE_M, REGION_TRANSITION_M, VISIBILITY_M};
use nearest::nearest;
use std::collections::BTreeMap;

pub mod clouds;
mod nearest;

/// Side of the square that an entity's weather fills, with corners so round that it is a disc.
const ENTITY_WEATHER_M: f64 = 20_000.0;
/// Width over which an entity's weather goes over into the weather around.
const ENTITY_TRANSITION_M: f64 = 5_000.0;
/// An entity's weather is moved when it is off by more.
const ENTITY_STEP_M: f64 = 50.0;
/// The layer that is lightning: each Weather Control of it is one strike.
pub const LIGHTNING_LAYER: u8 = 10;
/// Extent of a storm of the global weather around the ownship.
const GLOBAL_STORM_M: f64 = 60_000.0;

/// Whose weather a layer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Everybody's.
    Global,
    /// That of a region.
    Region(u16),
    /// That of an entity, which carries it along.
    Entity(u16),
}

/// A layer as it was last said.
#[derive(Clone, Debug)]
struct Said {
    packet: WeatherControl,
    version: Version,
}

/// All weather that was said, and what of it the world has heard.
#[derive(Clone, Debug)]
pub struct Weather {
    sea_level_m: f64,
    seed: u64,
    atmosphere: Option<AtmosphereControl>,
    regions: BTreeMap<u16, EnvironmentalRegionControl>,
    layers: BTreeMap<(Place, u8), Said>,
    heard_global: Vec<LayerSpec>,
    heard_visibility_m: Option<f64>,
    heard_regions: BTreeMap<String, (RegionShape, Vec<LayerSpec>)>,
    heard_storms: BTreeMap<String, StormRequest>,
    changed: bool,
}

impl Weather {
    /// None said. `sea_level_m`: mean sea level above the ellipsoid; `seed`: of storms.
    pub fn new(sea_level_m: f64, seed: u64) -> Self {
        Self {
            sea_level_m,
            seed,
            atmosphere: None,
            regions: BTreeMap::new(),
            layers: BTreeMap::new(),
            heard_global: Vec::new(),
            heard_visibility_m: None,
            heard_regions: BTreeMap::new(),
            heard_storms: BTreeMap::new(),
            changed: false,
        }
    }

    /// Atmosphere Control.
    pub fn atmosphere(&mut self, packet: &AtmosphereControl) {
        self.atmosphere = Some(packet.clone());
        self.changed = true;
    }

    /// Environmental Region Control.
    ///
    /// # Errors
    /// [`Refused`]: too many regions.
    pub fn region(&mut self, packet: &EnvironmentalRegionControl) -> Result<(), Refused> {
        const DESTROYED: u8 = 2;
        let id = packet.region_id;
        self.changed = true;
        if packet.region_state == DESTROYED {
            self.regions.remove(&id);
            self.layers.retain(|(place, _), _| *place != Place::Region(id));
            return Ok(());
        }
        if self.regions.len() >= CIGI_REGIONS && !self.regions.contains_key(&id) {
            let limit = format!("{CIGI_REGIONS} regions");
            return Err(Refused::new("region_id", id, limit, "destroy others first"));
        }
        self.regions.insert(id, packet.clone());
        Ok(())
    }

    /// Weather Control. For the layer that is lightning, the place of the strike; else nothing.
    ///
    /// # Errors
    /// [`Refused`]: too many layers, or a scope that is none.
    pub fn layer(&mut self, packet: &WeatherControl, version: Version) -> Result<Option<Place>, Refused> {
        let place = match packet.scope {
            0 => Place::Global,
            1 => Place::Region(packet.entity_region_id),
            2 => Place::Entity(packet.entity_region_id),
            other => return Err(Refused::new("Weather Control.scope", other, "0 to 2", "no such scope")),
        };
        if packet.layer_id == LIGHTNING_LAYER && packet.scope != 2 {
            return Ok(packet.weather_enable.then_some(place));
        }
        // An entity has one weather, whatever its number.
        let layer_id = if packet.scope == 2 { 1 } else { packet.layer_id };
        let key = (place, layer_id);
        self.changed = true;
        if !packet.weather_enable {
            self.layers.remove(&key);
            return Ok(None);
        }
        if self.layers.len() >= CIGI_WEATHER_LAYERS && !self.layers.contains_key(&key) {
            let limit = format!("{CIGI_WEATHER_LAYERS} layers");
            return Err(Refused::new("layer_id", packet.layer_id, limit, "disable others first"));
        }
        self.layers.insert(key, Said { packet: WeatherControl { layer_id, ..packet.clone() }, version });
        Ok(None)
    }

    /// What the world is to hear.
    pub fn commands(&mut self, entities: &Entities) -> Vec<Command> {
        // What goes with an entity, and a storm of the global weather with the ownship, has to be looked after; and of more
        // than the world draws those near the ownship.
        let follows = self.layers.iter().any(|((place, _), said)| match place {
            Place::Entity(_) => true,
            Place::Global => said.packet.random_lightning_enable,
            Place::Region(_) => false,
        }) || self.regions.len() > MAX_REGIONS
            || self.raging().nth(MAX_STORMS).is_some();
        if !std::mem::take(&mut self.changed) && !follows {
            return Vec::new();
        }
        let mut commands = Vec::new();
        let global = clouds::specs(&self.clouds_of(Place::Global), &[]);
        let clamp = |visibility: f32| f64::from(visibility).clamp(VISIBILITY_M[0], VISIBILITY_M[1]);
        let visibility_m = self.atmosphere.as_ref().map(|air| clamp(air.global_visibility_range));
        let layers = (global != self.heard_global).then(|| global.clone());
        let new_visibility_m = visibility_m.filter(|_| visibility_m != self.heard_visibility_m);
        if layers.is_some() || new_visibility_m.is_some() {
            let edit = WeatherEdit { layers, visibility_m: new_visibility_m, ..WeatherEdit::default() };
            commands.push(Command::Weather(edit));
        }
        let mut wanted = BTreeMap::new();
        for (place, shape, merges) in self.places(entities) {
            let own = self.clouds_of(place);
            // Storm cells alone stand in the weather around as they are.
            let alone = clouds::specs(&own, &[]);
            let cells = !alone.is_empty() && alone.iter().all(|layer| layer.kind == CloudKind::StormCell);
            let specs = if merges && !cells { clouds::specs(&own, &global) } else { alone };
            wanted.insert(shape.name.clone(), (shape, specs));
        }
        for name in self.heard_regions.keys().filter(|name| !wanted.contains_key(*name)) {
            commands.push(Command::RemoveRegion { name: name.clone(), transition_s: 0.0 });
        }
        for (name, (shape, specs)) in &mut wanted {
            match self.heard_regions.get(name) {
                Some((heard_shape, heard)) if heard == specs && near(heard_shape, shape) => {
                    *shape = heard_shape.clone()
                }
                _ => {
                    let (region, layers) = (Some(shape.clone()), Some(specs.clone()));
                    commands.push(Command::Weather(WeatherEdit { region, layers, ..WeatherEdit::default() }));
                }
            }
        }
        (self.heard_global, self.heard_visibility_m, self.heard_regions) = (global, visibility_m, wanted);
        self.storm_commands(entities, &mut commands);
        commands
    }

    /// What the world is to hear of storms: as many as it has room for, those near the ownship.
    fn storm_commands(&mut self, entities: &Entities, commands: &mut Vec<Command>) {
        let ownship = entities.pose(OWNSHIP).map(|pose| pose.position);
        let raging =
            self.raging().filter_map(|((place, layer), said)| self.storm(*place, *layer, &said.packet, entities));
        let storms: Vec<(Storm, String)> = raging.map(|storm| (storm.clone(), storm.name())).collect();
        let heard = |(_, name): &(Storm, String)| self.heard_storms.contains_key(name);
        let storms = nearest(storms, ownship.as_ref(), MAX_STORMS, |(storm, _)| &storm.shape, heard);
        let mut wanted: BTreeMap<String, StormRequest> =
            storms.into_iter().map(|(storm, name)| (name, storm.request())).collect();
        for name in self.heard_storms.keys().filter(|name| !wanted.contains_key(*name)) {
            commands.push(Command::RemoveStorm { name: name.clone() });
        }
        for (name, storm) in &mut wanted {
            match self.heard_storms.get(name) {
                Some(heard) if near_storm(heard, storm) => *storm = heard.clone(),
                _ => commands.push(Command::Storm(storm.clone())),
            }
        }
        self.heard_storms = wanted;
    }

    /// What was said of the air, for answers.
    pub fn air(&self, entities: &Entities) -> Air {
        let global = self.atmosphere.as_ref().map_or_else(AirMass::default, |air| AirMass {
            temperature_c: air.global_air_temperature.into(),
            humidity_percent: f64::from(air.global_humidity.min(100)),
            pressure_hpa: air.global_barometric_pressure.into(),
            wind_speed_mps: f64::from(air.global_horizontal_wind_speed).max(0.0),
            updraft_mps: air.global_vertical_wind_speed.into(),
            wind_from_deg: f64::from(air.global_wind_direction).rem_euclid(360.0),
        });
        let sea_level_m = self.sea_level_m;
        let mut layers = Vec::new();
        let everywhere = (Place::Global, None, true, true);
        let regions = self.places(entities).into_iter().map(|(place, shape, merges)| {
            let merges_aerosol = match place {
                Place::Region(id) => self.regions.get(&id).is_some_and(|region| region.merge_aerosol_concentrations),
                _ => false,
            };
            (place, Some(shape), merges, merges_aerosol)
        });
        for (place, region, merges, merges_aerosol) in std::iter::once(everywhere).chain(regions) {
            for said in self.said_of(place) {
                layers.push(clouds::air_layer(
                    &said.packet,
                    said.version,
                    sea_level_m,
                    region.clone(),
                    merges,
                    merges_aerosol,
                ));
            }
        }
        Air { global, sea_level_m, layers }
    }

    /// A storm of the weather of a place, for a single strike: in its first layer with cloud.
    pub fn storm_at(&self, place: Place, severity: u8, entities: &Entities) -> Option<Storm> {
        let storm = match self.said_of(place).find(|said| clouds::is_cloud(&said.packet)) {
            Some(said) => self.storm(place, LIGHTNING_LAYER, &said.packet, entities),
            None => {
                let shape = self.shape_of(place, entities)?;
                Some(Storm { shape, base_m: None, severity, seed: self.seed, layer: LIGHTNING_LAYER })
            }
        };
        storm.map(|storm| Storm { severity, ..storm })
    }

    /// The storm of a layer of the global weather, by its number; 0: of the first that there is.
    pub fn storm_of_layer(&self, layer_id: u8, severity: u8, entities: &Entities) -> Option<Storm> {
        if layer_id == 0 {
            return self.storm_at(Place::Global, severity, entities);
        }
        let said = self.layers.get(&(Place::Global, layer_id))?;
        self.storm(Place::Global, layer_id, &said.packet, entities).map(|storm| Storm { severity, ..storm })
    }

    fn storm(&self, place: Place, layer: u8, packet: &WeatherControl, entities: &Entities) -> Option<Storm> {
        let middle_m = f64::from(packet.base_elevation) + 0.5 * f64::from(packet.thickness).max(0.0);
        let base_m = Some(middle_m + self.sea_level_m);
        let (severity, seed) = (packet.severity, self.seed);
        Some(Storm { shape: self.shape_of(place, entities)?, base_m, severity, seed, layer })
    }

    /// The ground on which a place has its weather; `None`: there is no such place.
    fn shape_of(&self, place: Place, entities: &Entities) -> Option<RegionShape> {
        match place {
            Place::Global => entities.pose(OWNSHIP).map(|pose| RegionShape {
                name: String::new(),
                latitude_deg: deg(pose.position.latitude_rad),
                longitude_deg: deg(pose.position.longitude_rad),
                size_east_m: GLOBAL_STORM_M,
                size_north_m: GLOBAL_STORM_M,
                corner_radius_m: 0.0,
                rotation_deg: 0.0,
                transition_m: 0.0,
            }),
            Place::Region(id) => self.regions.get(&id).filter(|region| is_active(region)).map(region_shape),
            Place::Entity(id) => entities.pose(id).map(|pose| RegionShape {
                name: format!("entity-{id}"),
                latitude_deg: deg(pose.position.latitude_rad),
                longitude_deg: deg(pose.position.longitude_rad),
                size_east_m: ENTITY_WEATHER_M,
                size_north_m: ENTITY_WEATHER_M,
                corner_radius_m: 0.5 * ENTITY_WEATHER_M,
                rotation_deg: 0.0,
                transition_m: ENTITY_TRANSITION_M,
            }),
        }
    }

    /// Regions and entities that have weather, as many as the world takes (the nearest to the ownship), with their outlines and
    /// whether they keep the weather around them.
    fn places(&self, entities: &Entities) -> Vec<(Place, RegionShape, bool)> {
        let regions =
            self.regions.values().map(|region| (Place::Region(region.region_id), region.merge_weather_properties));
        let entity = |place: &Place| matches!(place, Place::Entity(_)).then_some((*place, true));
        let carried = self.layers.keys().filter_map(|(place, _)| entity(place));
        let all =
            regions.chain(carried).filter_map(|(place, merges)| Some((place, self.shape_of(place, entities)?, merges)));
        let ownship = entities.pose(OWNSHIP).map(|pose| pose.position);
        let heard = |(_, shape, _): &(Place, RegionShape, bool)| self.heard_regions.contains_key(&shape.name);
        nearest(all.collect(), ownship.as_ref(), MAX_REGIONS, |(_, shape, _)| shape, heard)
    }

    fn raging(&self) -> impl Iterator<Item = (&(Place, u8), &Said)> {
        self.layers.iter().filter(|(_, said)| said.packet.random_lightning_enable)
    }

    fn said_of(&self, place: Place) -> impl Iterator<Item = &Said> {
        self.layers.range((place, 0)..=(place, u8::MAX)).map(|(_, said)| said)
    }

    /// Clouds of a place, ready for the world.
    fn clouds_of(&self, place: Place) -> Vec<clouds::Parts> {
        let sea_level_m = self.sea_level_m;
        let parts = |said: &Said| clouds::parts(&said.packet, said.version, sea_level_m);
        let parts = self.said_of(place).filter_map(parts);
        // What has an outline is one cloud; over the globe it is a genus.
        parts.map(|parts| if place == Place::Global { parts } else { parts.bounded() }).collect()
    }
}

/// Whether two outlines are the same but for less than a step.
fn near(a: &RegionShape, b: &RegionShape) -> bool {
    let metres_per_degree = 111_000.0;
    let moved = (a.latitude_deg - b.latitude_deg).abs() + half_turn(a.longitude_deg - b.longitude_deg).abs();
    let here = RegionShape { latitude_deg: a.latitude_deg, longitude_deg: a.longitude_deg, ..b.clone() };
    a == b || *a == here && a.name.starts_with("entity-") && moved * metres_per_degree < ENTITY_STEP_M
}

fn is_active(region: &EnvironmentalRegionControl) -> bool {
    const ACTIVE: u8 = 1;
    region.region_state == ACTIVE
}

fn region_shape(region: &EnvironmentalRegionControl) -> RegionShape {
    let size = |size: f32| f64::from(size).clamp(REGION_SIZE_M[0], REGION_SIZE_M[1]);
    let (size_north_m, size_east_m) = (size(region.size_x), size(region.size_y));
    let widest_m = 0.5 * size_north_m.min(size_east_m);
    RegionShape {
        name: format!("region-{}", region.region_id),
        latitude_deg: region.latitude,
        longitude_deg: half_turn(region.longitude),
        size_east_m,
        size_north_m,
        corner_radius_m: f64::from(region.corner_radius).clamp(0.0, widest_m),
        rotation_deg: half_turn(region.rotation.into()),
        transition_m: f64::from(region.transition_perimeter).clamp(0.0, REGION_TRANSITION_M[1]),
    }
}
