//! Celestial Sphere Control: date and time of day in UTC, and which lights of the sky there are.

use crate::wire::cigi::packets::CelestialSphereControl;
use crate::world::command::{Command, SkyEdit, TimeEdit};
use crate::world::event::Refused;

/// What was said last.
#[derive(Clone, Debug, Default)]
pub struct Sky {
    last: Option<CelestialSphereControl>,
}

impl Sky {
    /// The commands of a packet. One that says the same as the last is no news: a host that repeats it with every frame does
    /// not hold back a time that runs by itself.
    ///
    /// # Errors
    /// [`Refused`]: a date or time that is none; then nothing of the packet counts.
    pub fn control(&mut self, packet: &CelestialSphereControl) -> Result<Vec<Command>, Refused> {
        let last = self.last.as_ref();
        let moment = |packet: &CelestialSphereControl| (packet.date, packet.hour, packet.minute, packet.seconds);
        let utc_s = if packet.date_time_valid { Some(utc_s(packet)?) } else { None };
        let told = |last: &&CelestialSphereControl| last.date_time_valid && moment(last) == moment(packet);
        let utc_s = utc_s.filter(|_| last.filter(told).is_none());
        let running = packet.continuous_time_of_day_enable;
        let rate = if running { 1.0 } else { 0.0 };
        let rate = last.is_none_or(|last| last.continuous_time_of_day_enable != running).then_some(rate);
        let mut commands = Vec::new();
        if utc_s.is_some() || rate.is_some() {
            commands.push(Command::Time(TimeEdit { utc_s, rate }));
        }
        let stars = if packet.star_field_enable { packet.star_field_intensity.clamp(0.0, 100.0) } else { 0.0 };
        let lights = |packet: &CelestialSphereControl| {
            (packet.sun_enable, packet.moon_enable, packet.star_field_enable, packet.star_field_intensity)
        };
        if last.is_none_or(|last| lights(last) != lights(packet)) {
            commands.push(Command::Sky(SkyEdit {
                sun: Some(packet.sun_enable),
                moon: Some(packet.moon_enable),
                starlight: Some(f64::from(stars) / 100.0),
            }));
        }
        self.last = Some(packet.clone());
        Ok(commands)
    }
}

/// Seconds since 1970; the date is month * 1000000 + day * 10000 + year.
fn utc_s(packet: &CelestialSphereControl) -> Result<f64, Refused> {
    let (month, day, year) = (packet.date / 1_000_000, packet.date / 10_000 % 100, packet.date % 10_000);
    let none = |field: &str, value: String, limit: &str| {
        Err(Refused::new(format!("Celestial Sphere Control.{field}"), value, limit, "no time of day"))
    };
    if packet.hour > 23 || packet.minute > 59 || !(0.0..60.0).contains(&packet.seconds) {
        let value = format!("{}:{}:{}", packet.hour, packet.minute, packet.seconds);
        return none("hour", value, "0:0:0 to 23:59:59");
    }
    let date =
        || jiff::civil::Date::new(i16::try_from(year).ok()?, i8::try_from(month).ok()?, i8::try_from(day).ok()?).ok();
    let midnight = date().and_then(|date| date.to_zoned(jiff::tz::TimeZone::UTC).ok());
    match midnight {
        Some(midnight) => {
            let clock_s = f64::from(packet.hour) * 3600.0 + f64::from(packet.minute) * 60.0 + f64::from(packet.seconds);
            Ok(midnight.timestamp().as_second() as f64 + clock_s)
        }
        None => none("date", packet.date.to_string(), "a date as MMDDYYYY"),
    }
}
