//! Places where many people live, found by where they are: 34,000 of them, from GeoNames (`data/cities.bin`).
//!
//! The table is read when it is first asked for: by day nobody asks.

use glam::DVec3;
use std::sync::LazyLock;

/// Mean radius of the Earth: positions are good to a metre, distances between cities need no better.
const EARTH_M: f64 = 6_371_000.0;
/// Bytes of an entry, and before the first.
const ENTRY: usize = 7;
const HEADER: usize = 8;
const COLUMNS: usize = 360;
const ROWS: usize = 180;
/// Inhabitants of a square kilometre of built-up land (Europe's cities have 3,000 to 5,000).
const PER_KM2: f64 = 3_500.0;

/// A place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct City {
    /// Unit vector of its zenith, ECEF.
    pub zenith: DVec3,
    /// Inhabitants, to 2 %.
    pub population: f64,
}

impl City {
    /// Radius of a disc with the area that it is built on.
    pub fn radius_m(&self) -> f64 {
        1_000.0 * (self.population / PER_KM2 / std::f64::consts::PI).sqrt()
    }
}

/// All places, by cells of one degree from the south-west, the largest of a cell first.
struct Table {
    cities: Vec<City>,
    /// Where each cell's run begins.
    begins: Vec<u32>,
}

/// The places no farther from a place (unit vector of its zenith) than `reach_m`, in a fixed order.
pub fn near(zenith: DVec3, reach_m: f64) -> Vec<City> {
    static TABLE: LazyLock<Table> = LazyLock::new(|| Table::new(include_bytes!("../../data/cities.bin")));
    TABLE.near(zenith, reach_m)
}

impl Table {
    fn new(bytes: &[u8]) -> Self {
        let mut cities = Vec::new();
        let mut counts = vec![0u32; COLUMNS * ROWS + 1];
        for entry in bytes.get(HEADER..).unwrap_or_default().chunks_exact(ENTRY) {
            let number =
                |at: usize| f64::from(u32::from_le_bytes([entry[at], entry[at + 1], entry[at + 2], 0])) / 16_777_215.0;
            let (latitude_deg, longitude_deg) = (180.0 * number(0) - 90.0, 360.0 * number(3) - 180.0);
            let population = 1_000.0 * (f64::from(entry[6]) / 16.0).exp2();
            cities.push((
                cell(latitude_deg, longitude_deg),
                City { zenith: zenith_of(latitude_deg, longitude_deg), population },
            ));
        }
        // Rounding may have moved a place over a cell's border.
        cities.sort_by_key(|(cell, _)| *cell);
        for (cell, _) in &cities {
            counts[cell + 1] += 1;
        }
        let begins = counts.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        });
        Self { begins: begins.collect(), cities: cities.into_iter().map(|(_, city)| city).collect() }
    }

    fn near(&self, zenith: DVec3, reach_m: f64) -> Vec<City> {
        let reach_rad = (reach_m / EARTH_M).min(std::f64::consts::PI);
        let least_cosine = reach_rad.cos();
        let latitude_deg = zenith.z.clamp(-1.0, 1.0).asin().to_degrees();
        let longitude_deg = zenith.y.atan2(zenith.x).to_degrees();
        let (south, north) = (latitude_deg - reach_rad.to_degrees(), latitude_deg + reach_rad.to_degrees());
        // A cap around a pole meets every longitude; elsewhere its half width is asin(sin reach / cos latitude).
        let wide = if south <= -90.0 || north >= 90.0 {
            180.0
        } else {
            (reach_rad.sin() / latitude_deg.to_radians().cos()).min(1.0).asin().to_degrees().min(180.0)
        };
        let first = (longitude_deg - wide + 180.0).floor() as i32;
        let columns = ((longitude_deg + wide + 180.0).floor() as i32 - first + 1).min(COLUMNS as i32);
        let rows = row(south)..=row(north);
        let cells = rows
            .flat_map(|row| (0..columns).map(move |k| row * COLUMNS + (first + k).rem_euclid(COLUMNS as i32) as usize));
        let cities = cells.flat_map(|cell| &self.cities[self.begins[cell] as usize..self.begins[cell + 1] as usize]);
        cities.filter(|city| city.zenith.dot(zenith) >= least_cosine).copied().collect()
    }
}

fn zenith_of(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

fn row(latitude_deg: f64) -> usize {
    ((latitude_deg + 90.0).max(0.0) as usize).min(ROWS - 1)
}

fn cell(latitude_deg: f64, longitude_deg: f64) -> usize {
    row(latitude_deg) * COLUMNS + ((longitude_deg + 180.0).max(0.0) as usize).min(COLUMNS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_holds_what_it_says() {
        let bytes = include_bytes!("../../data/cities.bin");
        let said = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
        let table = Table::new(bytes);
        assert_eq!((&bytes[..4], bytes.len()), (b"SDP1".as_slice(), HEADER + ENTRY * said));
        assert_eq!(table.cities.len(), said);
        // The Earth's places over 15,000 inhabitants hold between two and five thousand million people.
        let people: f64 = table.cities.iter().map(|city| city.population).sum();
        assert!((2e9..5e9).contains(&people), "{people}");
    }

    #[test]
    fn cities_are_found_where_they_are() {
        let largest = |latitude: f64, longitude: f64, reach_m: f64| {
            near(zenith_of(latitude, longitude), reach_m).iter().map(|c| c.population).fold(0.0, f64::max)
        };
        // Official populations: Paris 2.1, Tokyo 8.3 to 14, Auckland 1.4 to 1.7 million.
        assert!((1.9e6..2.4e6).contains(&largest(48.857, 2.352, 10_000.0)));
        assert!(largest(35.69, 139.69, 20_000.0) > 8e6);
        assert!((1.2e6..1.9e6).contains(&largest(-36.85, 174.76, 20_000.0)));
        assert!(near(zenith_of(0.0, -30.0), 300_000.0).is_empty(), "the middle of the Atlantic");
        assert!(near(zenith_of(-90.0, 0.0), 300_000.0).is_empty(), "the south pole");
    }

    #[test]
    fn all_within_reach_are_found_and_no_others() {
        let table = Table::new(include_bytes!("../../data/cities.bin"));
        for (latitude, longitude, reach_m) in [
            (51.5, 7.0, 60_000.0),
            (67.0, 179.9, 900_000.0),
            (-17.8, 178.4, 500_000.0),
            (89.0, 0.0, 3_000_000.0),
            (0.0, 0.0, 2e7 * 1.01),
        ] {
            let here = zenith_of(latitude, longitude);
            let least = f64::cos((reach_m / EARTH_M).min(std::f64::consts::PI));
            let all = table.cities.iter().filter(|city| city.zenith.dot(here) >= least).count();
            assert_eq!(table.near(here, reach_m).len(), all, "{latitude} {longitude}");
            assert!(all > 0, "{latitude} {longitude}");
        }
    }
}
