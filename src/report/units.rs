//! Numbers for people: three digits with a unit.

/// Seconds as ns, us, ms or s.
pub fn time(seconds: f64) -> String {
    let units = [(1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns")];
    let (size, unit) = units.into_iter().find(|(size, _)| seconds >= size * 0.9995).unwrap_or((1e-9, "ns"));
    format!("{} {unit}", digits(seconds / size))
}

/// Bytes as B, KiB, MiB or GiB.
pub fn bytes(bytes: u64) -> String {
    let units = [(1u64 << 30, "GiB"), (1 << 20, "MiB"), (1 << 10, "KiB"), (1, "B")];
    let (size, unit) = units.into_iter().find(|(size, _)| bytes >= *size).unwrap_or((1, "B"));
    format!("{} {unit}", digits(bytes as f64 / size as f64))
}

/// A number with three digits: plain near 1, with an exponent elsewhere.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e5).contains(&size) { digits(value) } else { format!("{value:.2e}") }
}

fn digits(value: f64) -> String {
    let decimals = match value.abs() {
        v if v == 0.0 || v >= 99.95 => 0,
        v if v >= 9.995 => 1,
        v if v >= 0.9995 => 2,
        v if v >= 0.09995 => 3,
        v if v >= 0.009995 => 4,
        _ => 5,
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_and_a_unit() {
        let times = [(0.0, "0 ns"), (1.5e-9, "1.50 ns"), (2e-5, "20.0 us"), (0.0345, "34.5 ms"), (1.0, "1.00 s")];
        for (seconds, text) in times {
            assert_eq!(time(seconds), text);
        }
        assert_eq!(time(0.999_99), "1.00 s");
        assert_eq!(time(4000.0), "4000 s");
        for (value, text) in [(0.0, "0"), (1e-9, "1.00e-9"), (0.01234, "0.0123"), (12.34, "12.3"), (1.0, "1.00")] {
            assert_eq!(number(value), text);
        }
        assert_eq!((bytes(512), bytes(8 << 20)), ("512 B".into(), "8.00 MiB".into()));
    }
}
