//! The flashes of the world: accepted, waiting, giving light, over.

use crate::geo::Geodetic;
use crate::lightning::flash::Flash;
use std::borrow::Cow;
use std::collections::VecDeque;

use super::check;
use super::command::{FlashKind, StrikeRequest, Strokes};
use super::event::Refused;
use super::light::Ongoing;
use super::limits;

/// All flashes that are not over, and the numbers of those that are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strikes {
    pending: Vec<Pending>,
    finished: VecDeque<u64>,
    /// Seconds after which a flash that is over is forgotten.
    kept_s: f64,
}

/// One accepted flash.
#[derive(Clone, Debug, PartialEq)]
struct Pending {
    id: u64,
    request: StrikeRequest,
    position: Geodetic,
    flash: Flash,
    /// Whether its beginning has been told for its thunder.
    heard: bool,
    /// `None`: begins with the next picture.
    begin_s: Option<f64>,
}

impl Pending {
    /// One that waits for a picture is taken to begin at `begin_s`.
    fn ongoing(&self, begin_s: f64) -> Ongoing<'_> {
        Ongoing {
            id: self.id,
            position: self.position,
            kind: self.request.kind,
            polarity: self.request.polarity,
            seed: self.request.seed,
            begin_s: self.begin_s.unwrap_or(begin_s),
            flash: Cow::Borrowed(&self.flash),
        }
    }

    fn over(&self, now_s: f64) -> bool {
        self.begin_s.is_some_and(|begin_s| begin_s + self.flash.duration_s() <= now_s)
    }
}

impl Strikes {
    /// Accepts a flash under a number. `begin_s`: `None` to begin with the next picture. `altitude_m`: where the light is
    /// when the request does not say.
    ///
    /// # Errors
    /// [`Refused`] for a value out of range, a time in the past, strokes out of order, or too many flashes.
    pub fn accept(
        &mut self,
        id: u64,
        request: &StrikeRequest,
        begin_s: Option<f64>,
        altitude_m: f64,
        now_s: f64,
    ) -> Result<(), Refused> {
        check_request(request, now_s)?;
        self.settle(now_s);
        // Those that are only remembered for a guard do not count.
        let waiting = self.pending.iter().filter(|pending| !pending.over(now_s)).count();
        check::at_most("strike", waiting + 1, limits::MAX_PENDING_STRIKES, "flashes waiting or under way")?;
        let flash = match &request.strokes {
            Strokes::Sample => {
                Flash::sample(request.kind, request.polarity, request.peak_current_ka, request.leader, request.seed)
            }
            Strokes::Given(strokes) => {
                let mut strokes = strokes.clone();
                if let (Some(first), Some(peak_current_ka)) = (strokes.first_mut(), request.peak_current_ka) {
                    first.peak_current_ka = peak_current_ka;
                }
                Flash::given(request.kind, request.polarity, &strokes, request.leader, request.seed)
            }
        };
        let position = Geodetic {
            latitude_rad: request.latitude_deg.to_radians(),
            longitude_rad: request.longitude_deg.to_radians(),
            altitude_m: request.altitude_m.unwrap_or(altitude_m),
        };
        self.pending.push(Pending { id, request: request.clone(), position, flash, heard: false, begin_s });
        Ok(())
    }

    /// Begins the flashes that wait for a picture.
    pub fn begin(&mut self, now_s: f64) {
        for pending in &mut self.pending {
            pending.begin_s.get_or_insert(now_s);
        }
    }

    /// All flashes that may be under way or to come; those that wait for a picture are taken to begin at `begin_s`.
    pub(super) fn ongoing(&self, begin_s: f64) -> impl Iterator<Item = Ongoing<'_>> {
        self.pending.iter().map(move |pending| pending.ongoing(begin_s))
    }

    /// The flashes that have begun and were not told before.
    pub(super) fn take_begun(&mut self, now_s: f64) -> Vec<Ongoing<'static>> {
        let begun = |pending: &&mut Pending| !pending.heard && pending.begin_s.is_some_and(|begin_s| begin_s <= now_s);
        let told = |pending: &mut Pending| {
            pending.heard = true;
            pending.ongoing(now_s).into_owned()
        };
        self.pending.iter_mut().filter(begun).map(told).collect()
    }

    /// Keeps flashes for so many seconds after they are over, before their numbers are told.
    pub fn keep(&mut self, kept_s: f64) {
        self.kept_s = kept_s;
    }

    /// Numbers of the flashes that are over since the last call.
    pub fn take_finished(&mut self, now_s: f64) -> Vec<u64> {
        self.settle(now_s);
        self.finished.drain(..).collect()
    }

    /// Numbers of all flashes, over or not: for when the world is replaced.
    pub fn abandon(&mut self) -> VecDeque<u64> {
        let rest: Vec<u64> = self.pending.drain(..).map(|pending| pending.id).collect();
        rest.into_iter().for_each(|id| self.finish(id));
        std::mem::take(&mut self.finished)
    }

    /// Takes over the numbers of flashes that another state of the world has had, in place of its own.
    pub fn inherit_finished(&mut self, finished: VecDeque<u64>, now_s: f64) {
        self.settle(now_s);
        self.finished = finished;
    }

    fn settle(&mut self, now_s: f64) {
        let now_s = now_s - self.kept_s;
        let (over, rest) = std::mem::take(&mut self.pending).into_iter().partition(|pending| pending.over(now_s));
        self.pending = rest;
        let over: Vec<Pending> = over;
        over.into_iter().for_each(|pending| self.finish(pending.id));
    }

    fn finish(&mut self, id: u64) {
        if self.finished.len() == limits::MAX_FINISHED_FLASHES {
            self.finished.pop_front();
        }
        self.finished.push_back(id);
    }
}

fn check_request(request: &StrikeRequest, now_s: f64) -> Result<(), Refused> {
    check::within("latitude_deg", request.latitude_deg, limits::LATITUDE_DEG)?;
    check::within("longitude_deg", request.longitude_deg, limits::LONGITUDE_DEG)?;
    if let Some(altitude_m) = request.altitude_m {
        check::within("altitude_m", altitude_m, limits::STRIKE_ALTITUDE_M)?;
    }
    if let Some(at_s) = request.at_s {
        check::within("at_s", at_s, limits::SIMULATION_TIME_S)?;
        if at_s < now_s {
            return Err(Refused::new("at_s", at_s, format!("at least {now_s}, the time now"), "in the past"));
        }
    }
    if let Some(peak_current_ka) = request.peak_current_ka {
        check::within("peak_current_ka", peak_current_ka, limits::PEAK_CURRENT_KA)?;
    }
    let Strokes::Given(strokes) = &request.strokes else { return Ok(()) };
    if strokes.is_empty() {
        return Err(Refused::new("strokes", "none", "at least 1", "a flash has strokes"));
    }
    check::at_most("strokes", strokes.len(), limits::MAX_STROKES, "strokes")?;
    let mut before_s = 0.0;
    for (index, stroke) in strokes.iter().enumerate() {
        if let Some(continuing_s) = stroke.continuing_s {
            check::within(&format!("strokes[{index}].continuing_s"), continuing_s, limits::CONTINUING_S)?;
        }
        if let Some(point) = stroke.ground_point_m {
            check_ground_point(&format!("strokes[{index}].ground_point_m"), point, request.kind)?;
        }
        let delay = format!("strokes[{index}].delay_s");
        check::within(&delay, stroke.delay_s, limits::STROKE_DELAY_S)?;
        check::within(&format!("strokes[{index}].peak_current_ka"), stroke.peak_current_ka, limits::PEAK_CURRENT_KA)?;
        if stroke.delay_s < before_s {
            return Err(Refused::new(delay, stroke.delay_s, format!("at least {before_s}"), "not in rising order"));
        }
        before_s = stroke.delay_s;
    }
    Ok(())
}

fn check_ground_point(field: &str, point: [f64; 2], kind: FlashKind) -> Result<(), Refused> {
    if kind != FlashKind::CloudToGround {
        let value = format!("[{}, {}]", point[0], point[1]);
        return Err(Refused::new(field, value, "only for cloud_to_ground", "this flash does not come to the ground"));
    }
    for (axis, value) in point.into_iter().enumerate() {
        check::within(&format!("{field}[{axis}]"), value, limits::GROUND_POINT_M)?;
    }
    Ok(())
}
