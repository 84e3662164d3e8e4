//! Checks of single values: the second net behind the wire's, so that no NaN ever enters the world.

use super::event::Refused;
use super::limits::MAX_NAME_CHARS;

/// Refuses what is not a number within `[low, high]`.
pub fn within(field: &str, value: f64, [low, high]: [f64; 2]) -> Result<(), Refused> {
    if value >= low && value <= high {
        return Ok(());
    }
    let why = if value.is_finite() { "out of range" } else { "not a finite number" };
    Err(Refused::new(field, value, format!("{low} to {high}"), why))
}

/// As [`within`], for whole numbers.
pub fn within_u32(field: &str, value: u32, [low, high]: [u32; 2]) -> Result<(), Refused> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Refused::new(field, value, format!("{low} to {high}"), "out of range"))
}

/// Refuses more than `most` of something.
pub fn at_most(field: &str, count: usize, most: usize, what: &str) -> Result<(), Refused> {
    if count <= most {
        return Ok(());
    }
    Err(Refused::new(field, count, format!("at most {most}"), format!("too many {what}")))
}

/// Refuses a name that is empty, too long, or has other characters than letters, digits, `-` and `_`.
pub fn name(field: &str, name: &str) -> Result<(), Refused> {
    let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !name.is_empty() && name.len() <= MAX_NAME_CHARS && name.chars().all(good) {
        return Ok(());
    }
    let limit = format!("1 to {MAX_NAME_CHARS} letters, digits, - and _");
    Err(Refused::new(field, name, limit, "not a name"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_pass_and_nothing_beyond_or_unreal() {
        assert!(within("x", -1.0, [-1.0, 2.0]).is_ok() && within("x", 2.0, [-1.0, 2.0]).is_ok());
        for bad in [2.000_001, -1.1, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let refused = within("x", bad, [-1.0, 2.0]).unwrap_err();
            assert_eq!((refused.field.as_str(), refused.limit.as_str()), ("x", "-1 to 2"));
        }
    }

    #[test]
    fn names() {
        assert!(name("n", "left-eye_2").is_ok());
        for bad in ["", "a b", "ä", "../x", &"x".repeat(33)] {
            assert!(name("n", bad).is_err(), "{bad}");
        }
    }
}
