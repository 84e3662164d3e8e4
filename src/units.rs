//! Units: conversions between what people say and what the house computes in (SI, radians).

/// Radians to degrees.
pub fn deg(rad: f64) -> f64 {
    rad.to_degrees()
}

/// An angle in radians brought into [-pi, pi).
pub fn wrap_pi(angle_rad: f64) -> f64 {
    let two_pi = std::f64::consts::TAU;
    (angle_rad + std::f64::consts::PI).rem_euclid(two_pi) - std::f64::consts::PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrap_pi_keeps_the_direction() {
        for k in -5..=5 {
            let wrapped = wrap_pi(1.0 + std::f64::consts::TAU * f64::from(k));
            assert!((wrapped - 1.0).abs() < 1e-12, "turn {k}: {wrapped}");
        }
        assert_eq!(wrap_pi(std::f64::consts::PI), -std::f64::consts::PI);
    }
}
