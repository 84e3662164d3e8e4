//! Instants: RFC 3339 texts to seconds since 1970 and back.

use crate::wire::limits::UTC_S;
use crate::world::event::Refused;
use jiff::Timestamp;

/// Seconds since 1970-01-01T00:00:00 UTC of an RFC 3339 text with `Z` or an offset.
///
/// # Errors
/// The text is no instant, or lies outside the years that the sun's and moon's positions hold for.
pub fn parse(field: &str, text: &str) -> Result<f64, Refused> {
    let limit = "RFC 3339 with Z or an offset, 1900 to 2100";
    let instant: Timestamp = text.parse().map_err(|error| Refused::new(field, text, limit, format!("{error}")))?;
    // Whole seconds are exact in f64, so the sum is rounded once: printing and parsing again gives the same value.
    let utc_s = instant.as_second() as f64 + f64::from(instant.subsec_nanosecond()) / 1e9;
    if !(UTC_S.min..=UTC_S.max).contains(&utc_s) {
        return Err(Refused::new(field, text, limit, "the positions of sun and moon do not hold there"));
    }
    Ok(utc_s)
}

/// The RFC 3339 text in UTC of an instant; beyond the calendar the nearest instant that has a text.
pub fn print(utc_s: f64) -> String {
    let second = utc_s.floor();
    let nanosecond = ((utc_s - second) * 1e9).round() as i32;
    let (second, nanosecond) = if nanosecond == 1_000_000_000 { (second + 1.0, 0) } else { (second, nanosecond) };
    let end = if utc_s < 0.0 { Timestamp::MIN } else { Timestamp::MAX };
    Timestamp::new(second as i64, nanosecond).unwrap_or(end).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_instants() {
        for (text, utc_s) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2000-01-01T12:00:00Z", 946_728_000.0),
            ("2026-06-21T13:30:00+02:00", 1_782_041_400.0),
            ("1969-12-31T23:59:59.5Z", -0.5),
        ] {
            assert_eq!(parse("utc", text), Ok(utc_s), "{text}");
            assert_eq!(parse("utc", &print(utc_s)), Ok(utc_s), "{text} printed as {}", print(utc_s));
        }
    }

    #[test]
    fn what_is_no_instant_is_refused() {
        for text in ["", "noon", "2026-06-21", "2026-06-21T12:00:00", "2026-13-01T00:00:00Z", "1850-01-01T00:00:00Z"] {
            let refused = parse("utc", text).expect_err(text);
            assert_eq!(refused.field, "utc");
        }
    }
}
