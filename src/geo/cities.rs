//! Places where many people live, found by where they are: 30,000 of them, from GeoNames (`data/cities.bin`).
//!
//! They are read where they lie in the program, sorted by cells of one degree: no table is made of them, by day or by night.
//! Quarters that are listed beside their city are not counted again (see `data/make-tables.py`).

use super::terrain::Terrain;
use glam::DVec3;

/// Mean radius of the Earth: positions are good to a metre, distances between cities need no better.
const EARTH_M: f64 = 6_371_000.0;
/// Bytes of an entry, and before the first.
const ENTRY: usize = 7;
const HEADER: usize = 8;
/// Largest number that an entry holds for latitude or longitude.
const WHOLE: u32 = 0xff_ffff;
const COLUMNS: i32 = 360;
const ROWS: i32 = 180;
/// Inhabitants of a square kilometre of built-up land (Europe's cities have 3,000 to 5,000).
const PER_KM2: f64 = 3_500.0;

/// A place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct City {
    /// Unit vector of its zenith, ECEF.
    pub zenith: DVec3,
    /// Inhabitants, to 2 %, but for those that a larger place near it has counted already.
    pub population: f64,
}

impl City {
    /// Radius of a disc with the area that it is built on.
    pub fn radius_m(&self) -> f64 {
        1_000.0 * (self.population / PER_KM2 / std::f64::consts::PI).sqrt()
    }

    /// Height of the ground that it stands on, without what is shorter than the city is wide.
    pub fn ground_m(&self, terrain: &Terrain) -> f64 {
        let level = self.zenith.x.hypot(self.zenith.y);
        let (latitude_rad, longitude_rad) = (self.zenith.z.atan2(level), self.zenith.y.atan2(self.zenith.x));
        terrain.smoothed_height_m(latitude_rad, longitude_rad, self.radius_m())
    }
}

/// The places no farther from a place (unit vector of its zenith) than `reach_m`, in a fixed order.
pub fn near(zenith: DVec3, reach_m: f64) -> Vec<City> {
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
    let columns = ((longitude_deg + wide + 180.0).floor() as i32 - first + 1).min(COLUMNS);
    let row = |latitude_deg: f64| ((latitude_deg + 90.0).max(0.0) as i32).min(ROWS - 1);
    let west = first.rem_euclid(COLUMNS);
    // Past the last column it goes on with the first.
    let runs = [west..(west + columns).min(COLUMNS), 0..(west + columns - COLUMNS).max(0)];
    let runs = (row(south)..=row(north)).flat_map(|row| runs.clone().map(|columns| (row, columns)));
    let cities = runs.filter(|(_, columns)| !columns.is_empty()).flat_map(|(row, columns)| run(row, columns));
    cities.filter(|city| city.zenith.dot(zenith) >= least_cosine).collect()
}

fn entries() -> &'static [[u8; ENTRY]] {
    include_bytes!("../../data/cities.bin")[HEADER..].as_chunks().0
}

/// The places of some cells of a row.
fn run(row: i32, columns: std::ops::Range<i32>) -> impl Iterator<Item = City> {
    let entries = entries();
    let begin = |column: i32| entries.partition_point(|entry| cell(entry) < row * COLUMNS + column);
    entries[begin(columns.start)..begin(columns.end)].iter().map(city)
}

/// Latitude and longitude as an entry holds them.
fn numbers(entry: &[u8; ENTRY]) -> [u32; 2] {
    [0, 3].map(|at| u32::from_le_bytes([entry[at], entry[at + 1], entry[at + 2], 0]))
}

/// The cell of an entry, counted from the south-west.
fn cell(entry: &[u8; ENTRY]) -> i32 {
    let [latitude, longitude] = numbers(entry);
    let along = |number: u32, cells: i32| (u64::from(number) * cells as u64 / u64::from(WHOLE)) as i32;
    along(latitude, ROWS) * COLUMNS + along(longitude, COLUMNS)
}

fn city(entry: &[u8; ENTRY]) -> City {
    let [latitude, longitude] = numbers(entry).map(|number| f64::from(number) / f64::from(WHOLE));
    let population = 1_000.0 * (f64::from(entry[6]) / 16.0).exp2();
    City { zenith: zenith_of(180.0 * latitude - 90.0, 360.0 * longitude - 180.0), population }
}

fn zenith_of(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_holds_what_it_says() {
        let bytes = include_bytes!("../../data/cities.bin");
        let said = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
        assert_eq!((&bytes[..4], bytes.len()), (b"SDP2".as_slice(), HEADER + ENTRY * said));
        assert_eq!(entries().len(), said);
        assert!(entries().is_sorted_by_key(cell), "runs are found by halving");
        // The Earth's places over 15,000 inhabitants hold between two and five thousand million people.
        let people: f64 = entries().iter().map(|entry| city(entry).population).sum();
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
        for (latitude, longitude, reach_m) in [
            (51.5, 7.0, 60_000.0),
            (67.0, 179.9, 900_000.0),
            (-17.8, 178.4, 500_000.0),
            (89.0, 0.0, 3_000_000.0),
            (0.0, 0.0, 2e7 * 1.01),
        ] {
            let here = zenith_of(latitude, longitude);
            let least = f64::cos((reach_m / EARTH_M).min(std::f64::consts::PI));
            let all = entries().iter().filter(|entry| city(entry).zenith.dot(here) >= least).count();
            assert_eq!(near(here, reach_m).len(), all, "{latitude} {longitude}");
            assert!(all > 0, "{latitude} {longitude}");
        }
    }

    #[test]
    fn quarters_are_not_counted_beside_their_city() {
        // Paris has 2.1 million inhabitants; within the disc of 13.9 km that it stands for GeoNames lists 9.4 million.
        let people: f64 = near(zenith_of(48.857, 2.352), 11_000.0).iter().map(|city| city.population).sum();
        assert!((2.0e6..2.6e6).contains(&people), "{people}");
    }
}
