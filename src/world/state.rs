//! The state of the world: everything that a snapshot shows, at the present simulation time.

use crate::geo::Geodetic;
use crate::geo::celestial::sun_and_moon;
use crate::geo::terrain::Terrain;
use crate::lightning::flash::LONGEST_FLASH_S;
use crate::lightning::strike::StrikeSpec;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use super::check;
use super::clock::Clock;
use super::command::{Command, Ownship, SkyEdit, StrikeRequest, WeatherEdit};
use super::event::{Applied, Refused};
use super::growing::{Channels, Growing};
use super::light::Ongoing;
use super::limits;
use super::ownship::LastKnown;
use super::regions::{self, Region};
use super::snapshot::{FlashState, Quality, SkyState, Snapshot, ViewState};
use super::storms::Storms;
use super::strikes::Strikes;
use super::thunder::Thunder;
use super::views;
use super::weather::{self, Weather};

/// Height of a flash's light where there is no cloud.
const STRIKE_ALTITUDE_WITHOUT_CLOUD_M: f64 = 2_000.0;

/// Storms' channels are grown so long before their flashes begin.
const GROWN_AHEAD_S: f64 = 1.0;

/// Of a longer leap of the time only the end is looked through for flashes that began in it.
const LONGEST_LEAP_S: f64 = 10.0;

/// Which lights of the sky there are.
#[derive(Clone, Copy, Debug)]
struct SkyLights {
    sun: bool,
    moon: bool,
    starlight: f64,
}

impl Default for SkyLights {
    fn default() -> Self {
        Self { sun: true, moon: true, starlight: 1.0 }
    }
}

impl SkyLights {
    fn edit(&mut self, edit: &SkyEdit) -> Result<(), Refused> {
        if let Some(starlight) = edit.starlight {
            check::within("starlight", starlight, limits::STARLIGHT)?;
            self.starlight = starlight;
        }
        self.sun = edit.sun.unwrap_or(self.sun);
        self.moon = edit.moon.unwrap_or(self.moon);
        Ok(())
    }
}

/// The state of the world.
#[derive(Clone, Debug)]
pub struct State {
    now_s: f64,
    ownship: LastKnown,
    entities: BTreeMap<u16, LastKnown>,
    sky: SkyLights,
    weather: Weather,
    regions: Vec<Region>,
    views: Vec<ViewState>,
    clock: Clock,
    strikes: Strikes,
    channels: Channels,
    storms: Storms,
    /// Up to when storms' flashes have been told for their thunder.
    heard_s: f64,
    next_flash_id: u64,
}

impl State {
    /// The defaults of [`super::World::new`] at simulation time 0; flashes are numbered from `next_flash_id`.
    pub fn new(next_flash_id: u64) -> Self {
        Self {
            now_s: 0.0,
            ownship: LastKnown::default(),
            entities: BTreeMap::new(),
            sky: SkyLights::default(),
            weather: Weather::clear(),
            regions: Vec::new(),
            views: vec![views::default_view(views::DEFAULT_VIEW)],
            clock: Clock::default(),
            strikes: Strikes::default(),
            channels: Channels::default(),
            storms: Storms::default(),
            heard_s: 0.0,
            next_flash_id,
        }
    }

    /// Names of the views, in their order.
    pub fn view_names(&self) -> impl Iterator<Item = &str> {
        self.views.iter().map(|view| view.name.as_str())
    }

    /// Simulation time.
    pub fn now_s(&self) -> f64 {
        self.now_s
    }

    /// Sets a later simulation time; an earlier one is ignored.
    pub fn advance(&mut self, now_s: f64) {
        self.now_s = self.now_s.max(now_s);
    }

    /// Applies a command. `scenario_flash_id`: the number of a flash that a scenario asks for; such a flash begins exactly
    /// now when it says no time.
    ///
    /// # Errors
    /// [`Refused`], and nothing has changed. Commands to the scenario player are refused: they are not for the state.
    pub fn apply(&mut self, command: &Command, scenario_flash_id: Option<u64>) -> Result<Applied, Refused> {
        match command {
            Command::Ownship(message) => self.ownship = LastKnown::new(message, self.now_s)?,
            Command::Entity { id, place } => self.entity(*id, place.as_ref())?,
            Command::Sky(edit) => self.sky.edit(edit)?,
            Command::Weather(edit) => self.edit_weather(edit)?,
            Command::RemoveRegion { name, transition_s } => {
                regions::remove(&mut self.regions, name, *transition_s, self.now_s)?;
            }
            Command::Time(edit) => self.clock.edit(edit, self.now_s)?,
            Command::View(edit) => views::edit(&mut self.views, edit)?,
            Command::RemoveView { name } => views::remove(&mut self.views, name)?,
            Command::Strike(request) => return self.strike(request, scenario_flash_id),
            Command::Storm(request) => self.storms.edit(request, self.now_s)?,
            Command::RemoveStorm { name } => self.storms.remove(name, self.now_s)?,
            Command::Scenario(_) => {
                let limit = "ownship, weather, time, view, strike and storm commands";
                return Err(Refused::new("command", "scenario", limit, "a scenario cannot command its own player"));
            }
        }
        Ok(Applied::Done)
    }

    /// Begins the flashes that wait for a picture.
    pub fn begin_strikes(&mut self) {
        self.strikes.begin(self.now_s);
        self.channels.forget(self.now_s);
    }

    /// The channel of a flash that a snapshot shows, grown or not.
    pub fn channel(&self, flash: &FlashState) -> Arc<Growing> {
        let FlashState { id, position, kind, polarity, seed, .. } = *flash;
        self.channels.of(id, flash.end_s, || {
            let cloud_m = self.cloud_m(&position).unwrap_or([position.altitude_m; 2]);
            let grounds_m = flash.ground_points_m.clone();
            StrikeSpec { kind, polarity, seed, origin_m: position.altitude_m, cloud_m, grounds_m }
        })
    }

    /// The channel of a flash, entered so that it can be grown before anybody sees it: kept until a picture takes it over, or a
    /// second longer than it would last from now.
    fn channel_of(&self, flash: &Ongoing<'_>) -> Arc<Growing> {
        let Ongoing { id, position, kind, polarity, seed, .. } = *flash;
        self.channels.of(id, flash.end_s() + 1.0, || {
            let cloud_m = self.cloud_m(&position).unwrap_or([position.altitude_m; 2]);
            let grounds_m = flash.flash.ground_points_m.clone();
            StrikeSpec { kind, polarity, seed, origin_m: position.altitude_m, cloud_m, grounds_m }
        })
    }

    /// Channels that are still to be grown, each given out once; those of storms a while before their flashes begin.
    pub fn take_growing(&self) -> Vec<Arc<Growing>> {
        let altitude_m = |place: &Geodetic| self.cloud_altitude_m(place);
        for flash in self.storms.begun(self.now_s, self.now_s + GROWN_AHEAD_S, altitude_m) {
            self.channel_of(&flash);
        }
        self.channels.take_fresh()
    }

    /// The flashes that have begun since the last call, and who listens.
    pub fn take_thunder(&mut self) -> Vec<Thunder> {
        let now_s = self.now_s;
        let from_s = self.heard_s.max(now_s - LONGEST_LEAP_S);
        self.heard_s = now_s;
        let mut begun = self.strikes.take_begun(now_s);
        begun.extend(self.storms.begun(from_s, now_s, |place| self.cloud_altitude_m(place)));
        let listener = self.ownship.at(now_s).position;
        let thunder = |flash: Ongoing<'_>| Thunder {
            flash: flash.id,
            begin_s: flash.begin_s,
            ground: Geodetic { altitude_m: 0.0, ..flash.position },
            listener,
            channel: self.channel_of(&flash),
            strokes: flash.flash.into_owned(),
        };
        begun.into_iter().map(thunder).collect()
    }

    /// Numbers of the flashes that ended since the last call; those asked for one by one are kept for so many seconds more, for
    /// the guard against flicker to know of them.
    pub fn take_finished_flashes(&mut self, kept_s: f64) -> Vec<u64> {
        // Where nobody asks for pictures, channels end here.
        self.channels.forget(self.now_s);
        self.strikes.keep(kept_s);
        let mut finished = self.strikes.take_finished(self.now_s);
        finished.extend(self.storms.take_finished(self.now_s));
        finished
    }

    /// Numbers of all flashes not yet asked for, for the state that replaces this one.
    pub fn abandon_flashes(&mut self) -> VecDeque<u64> {
        let mut abandoned = self.strikes.abandon();
        abandoned.extend(self.storms.under_way(self.now_s));
        abandoned
    }

    /// Takes over flash numbers of the state that this one replaces.
    pub fn inherit(&mut self, finished: VecDeque<u64>, next_flash_id: u64) {
        self.strikes.inherit_finished(finished, self.now_s);
        self.storms.tell_from(self.now_s);
        self.heard_s = self.now_s;
        self.next_flash_id = next_flash_id;
    }

    /// The number that the next flash gets.
    pub fn next_flash_id(&self) -> u64 {
        self.next_flash_id
    }

    /// All flashes that may have light in `[begin_s, end_s)`, or had strokes in so many seconds before.
    pub(super) fn ongoing(&self, [begin_s, end_s]: [f64; 2], memory_s: f64) -> Vec<Ongoing<'_>> {
        let mut ongoing: Vec<Ongoing<'_>> = self.strikes.ongoing(begin_s).collect();
        let altitude_m = |place: &Geodetic| self.cloud_altitude_m(place);
        ongoing.extend(self.storms.begun(begin_s - LONGEST_FLASH_S - memory_s, end_s, altitude_m));
        ongoing
    }

    /// Everything at this moment but the flashes, of which the scenario's player knows more.
    pub fn snapshot(&self, number: u64, shutter_s: f64, quality: Quality, terrain: Terrain) -> Snapshot {
        let now_s = self.now_s;
        let utc_s = self.clock.utc_s(now_s);
        let sky = sun_and_moon(utc_s);
        Snapshot {
            number,
            host_frame: self.ownship.host_frame(),
            simulation_time_s: now_s,
            shutter_s: [now_s, now_s + shutter_s],
            utc_s,
            ownship: self.ownship.at(now_s),
            weather: self.weather.at(now_s),
            regions: regions::at(&self.regions, now_s),
            views: self.views.iter().map(|view| self.carried(view, now_s)).collect(),
            storms: self.storms.raging().cloned().collect(),
            flashes: Vec::new(),
            sky: SkyState {
                sun_direction_ecef: sky.sun_m.normalize(),
                moon_direction_ecef: sky.moon_m.normalize(),
                moon_lit_fraction: sky.moon_lit_fraction,
                sun_shines: self.sky.sun,
                moon_shines: self.sky.moon,
                starlight: self.sky.starlight,
            },
            quality,
            terrain,
        }
    }

    fn entity(&mut self, id: u16, place: Option<&Ownship>) -> Result<(), Refused> {
        if id == 0 {
            return Err(Refused::new("entity", id, "1 to 65535", "entity 0 is the ownship, which has its own command"));
        }
        let Some(place) = place else {
            self.entities.remove(&id);
            return Ok(());
        };
        let known = LastKnown::new(place, self.now_s)?;
        let count = self.entities.len() + usize::from(!self.entities.contains_key(&id));
        check::at_most("entity", count, limits::MAX_ENTITIES, "entities beside the ownship")?;
        self.entities.insert(id, known);
        Ok(())
    }

    /// A view with the place of the entity that carries it.
    fn carried(&self, view: &ViewState, now_s: f64) -> ViewState {
        let carrier = self.entities.get(&view.entity).filter(|_| view.entity != 0).map(|known| known.at(now_s));
        ViewState { carrier, ..view.clone() }
    }

    fn edit_weather(&mut self, edit: &WeatherEdit) -> Result<(), Refused> {
        match &edit.region {
            Some(shape) => regions::edit(&mut self.regions, shape, edit, &self.weather, self.now_s),
            None => {
                weather::refuse_cells(edit)?;
                self.weather.edit(edit, &self.ownship.at(self.now_s).position, self.now_s)
            }
        }
    }

    fn strike(&mut self, request: &StrikeRequest, scenario_flash_id: Option<u64>) -> Result<Applied, Refused> {
        let id = scenario_flash_id.unwrap_or(self.next_flash_id);
        let begin_s = request.at_s.or(scenario_flash_id.map(|_| self.now_s));
        let place = Geodetic {
            latitude_rad: request.latitude_deg.to_radians(),
            longitude_rad: request.longitude_deg.to_radians(),
            altitude_m: 0.0,
        };
        self.strikes.accept(id, request, begin_s, self.cloud_altitude_m(&place), self.now_s)?;
        if let Some(flash) = self.strikes.ongoing(self.now_s).last() {
            self.channel_of(&flash);
        }
        if scenario_flash_id.is_none() {
            self.next_flash_id += 1;
        }
        Ok(Applied::Flash { id })
    }

    /// Where the light of a flash is that does not say: in the middle of the lowest cloud.
    fn cloud_altitude_m(&self, place: &Geodetic) -> f64 {
        self.cloud_m(place).map_or(STRIKE_ALTITUDE_WITHOUT_CLOUD_M, |[base_m, top_m]| 0.5 * (base_m + top_m))
    }

    /// Base and top of the lowest layer with any cloud in it, of the weather that rules (or will rule) at a place.
    fn cloud_m(&self, place: &Geodetic) -> Option<[f64; 2]> {
        let ruling = |region: &&Region| regions::weight_at(&region.at(self.now_s).shape, place) >= 0.5;
        let region = self.regions.iter().rev().filter(|region| !region.leaving()).find(ruling);
        let layers = region.map_or(&self.weather, Region::weather).targets();
        let cloud = layers.iter().find(|layer| layer.coverage > 0.0);
        cloud.map(|layer| [layer.base_m, layer.base_m + layer.thickness_m])
    }
}
