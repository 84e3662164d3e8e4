//! The air that thunder comes through: speed of sound, pressure, and the loss by ISO 9613-1.

/// Air whose temperature falls evenly with height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Temperature at height 0, kelvin.
    pub temperature_k: f64,
    /// Fall of the temperature with height, kelvin per metre.
    pub lapse_k_per_m: f64,
    /// Relative humidity, per cent.
    pub humidity_percent: f64,
    /// Whether the air takes from the sound.
    pub loss: bool,
}

impl Default for Air {
    /// The standard atmosphere at 70 % humidity.
    fn default() -> Self {
        Self { temperature_k: 288.15, lapse_k_per_m: 0.0065, humidity_percent: 70.0, loss: true }
    }
}

/// Speed of sound per root of the temperature, m/s/sqrt(K), of dry air.
const SPEED: f64 = 20.05;
/// Pressure at height 0, Pa, and the height in which it falls to 1/e.
const PRESSURE_PA: f64 = 101_325.0;
const SCALE_HEIGHT_M: f64 = 8_400.0;
/// Gas constant of dry air, J/(kg K).
const GAS: f64 = 287.05;
/// The tropopause: it gets no colder above.
const COLDEST_K: f64 = 216.65;

impl Air {
    /// Temperature at a height.
    pub fn temperature_at_k(&self, height_m: f64) -> f64 {
        (self.temperature_k - self.lapse_k_per_m * height_m).max(COLDEST_K)
    }

    /// Speed of sound at a height.
    pub fn speed_mps(&self, height_m: f64) -> f64 {
        SPEED * self.temperature_at_k(height_m).sqrt()
    }

    /// Pressure at a height.
    pub fn pressure_pa(&self, height_m: f64) -> f64 {
        PRESSURE_PA * (-height_m / SCALE_HEIGHT_M).exp()
    }

    /// Density times speed of sound at a height.
    pub fn impedance(&self, height_m: f64) -> f64 {
        self.pressure_pa(height_m) / (GAS * self.temperature_at_k(height_m)) * self.speed_mps(height_m)
    }

    /// Seconds that sound takes along a straight line: distance over the mean of the speeds at its ends, which is exact where the
    /// temperature is linear between them (the integral of dz / sqrt(T) is the difference of 2 sqrt(T) over the lapse).
    pub fn travel_s(&self, from_m: [f64; 3], to_m: [f64; 3]) -> f64 {
        let d: [f64; 3] = std::array::from_fn(|axis| from_m[axis] - to_m[axis]);
        let distance_m = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        2.0 * distance_m / (self.speed_mps(from_m[2]) + self.speed_mps(to_m[2]))
    }

    /// Loss in decibels per metre at a frequency, at height 0 (ISO 9613-1, eq. 3 to 5).
    pub fn loss_db_per_m(&self, frequency_hz: f64) -> f64 {
        if !self.loss {
            return 0.0;
        }
        let warm = self.temperature_k / 293.15;
        let saturation = 10_f64.powf(4.6151 - 6.8346 * (273.16 / self.temperature_k).powf(1.261));
        let vapour = self.humidity_percent * saturation;
        let oxygen_hz = 24.0 + 4.04e4 * vapour * (0.02 + vapour) / (0.391 + vapour);
        let nitrogen_hz = warm.powf(-0.5) * (9.0 + 280.0 * vapour * (-4.170 * (warm.powf(-1.0 / 3.0) - 1.0)).exp());
        let square = frequency_hz * frequency_hz;
        let relaxing = 0.012_75 * (-2_239.1 / self.temperature_k).exp() / (oxygen_hz + square / oxygen_hz)
            + 0.106_8 * (-3_352.0 / self.temperature_k).exp() / (nitrogen_hz + square / nitrogen_hz);
        8.686 * square * (1.84e-11 * warm.sqrt() + warm.powf(-2.5) * relaxing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loss_is_that_of_the_standard_s_table() {
        // ISO 9613-2, table 2: dB/km at 63 Hz to 8 kHz, for 10 and 20 C and 70 %. Printed to 0.1; nominal octaves differ from
        // exact ones by up to 1.6 %, and the loss goes with the square of the frequency: 3 %.
        let rows = [
            (283.15, [0.1, 0.4, 1.0, 1.9, 3.7, 9.7, 32.8, 117.0]),
            (293.15, [0.1, 0.3, 1.1, 2.8, 5.0, 9.0, 22.9, 76.6]),
        ];
        for (temperature_k, printed) in rows {
            let air = Air { temperature_k, ..Air::default() };
            for (octave, printed) in (0..).zip(printed) {
                let found = 1e3 * air.loss_db_per_m(62.5 * 2_f64.powi(octave));
                assert!((found - printed).abs() < 0.06 + 0.03 * printed, "{temperature_k} {octave}: {found} {printed}");
            }
        }
    }

    #[test]
    fn sound_is_slower_in_the_cold_and_its_time_is_the_integral_along_the_ray() {
        let air = Air::default();
        assert!((air.speed_mps(0.0) - 340.3).abs() < 0.1 && air.speed_mps(5_000.0) < 321.0);
        let (from, to) = ([3_000.0, -1_000.0, 6_000.0], [0.0, 500.0, 20.0]);
        let length_m = (3_000_f64.powi(2) + 1_500_f64.powi(2) + 5_980_f64.powi(2)).sqrt();
        let steps = 1_000;
        let sum: f64 = (0..steps)
            .map(|k| (f64::from(k) + 0.5) / f64::from(steps))
            .map(|share| length_m / f64::from(steps) / air.speed_mps(6_000.0 - 5_980.0 * share))
            .sum();
        // Midpoint rule over a change of the slowness of 7 %: 1e-9.
        assert!((air.travel_s(from, to) / sum - 1.0).abs() < 1e-7, "{sum}");
    }
}
