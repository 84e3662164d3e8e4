//! Heights on a grid of latitudes and longitudes, as a file has them, laid over another ground.
//!
//! *What it is.* Samples at equal steps of latitude and longitude, above the ellipsoid. *How we compute it.* Bilinear between
//! samples; what is shorter than asked for comes from means over 2, 4, 8, ... samples each way, blended between two of these
//! levels. *How we store it.* f32, rows from the north; a sample that is not known is NaN. *How we read it back.* Where samples are
//! not known, and towards the edges, the grid goes over into the ground around it: at a coarser level by the share of what is
//! not known, so that a picture from afar and a question agree about a hole.

use super::Geodetic;
use super::terrain::{HIGHEST_M, Heights, Roughness, Terrain};
use crate::units::wrap_pi;
use std::fmt;

/// Samples over which the grid goes over into the ground around it, at its edges.
const MARGIN: f64 = 8.0;
/// Radius of a sphere for lengths along a meridian, good to half a per cent.
const EARTH_M: f64 = 6_371_000.0;
/// Steps eastwards shrink towards a pole; nearer to it than this latitude the thinnest crest does not count as thinner.
const FINEST_DEG: f64 = 85.0;
/// Nearer to a pole than this latitude (80 degrees) ways along it do not tell distances.
const NEAR_POLE_RAD: f64 = 1.396;
/// A level with fewer samples a side is not made.
const SMALLEST: usize = 2;

/// Samples and where they are.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Latitude of the northernmost row.
    pub north_deg: f64,
    /// Longitude of the westernmost column.
    pub west_deg: f64,
    /// Step southwards from row to row, positive.
    pub step_south_deg: f64,
    /// Step eastwards from column to column, positive.
    pub step_east_deg: f64,
    /// Samples in a row.
    pub columns: usize,
    /// Metres, rows from the north, each from the west; NaN where nothing is known. `columns` times the number of rows.
    pub heights_m: Vec<f32>,
}

/// A grid over another ground.
pub struct Raster {
    grid: Grid,
    /// Means over 2, 4, 8, ... samples each way.
    coarser: Vec<Level>,
    around: Terrain,
    /// Of the grid away from its edges, and over the margin at these.
    roughness: [Roughness; 2],
}

/// Means over equally many samples each way.
#[derive(Debug)]
struct Level {
    columns: usize,
    /// Of what is known of each mean's samples; NaN: nothing is.
    heights_m: Vec<f32>,
    /// Shares of each mean's samples that are known; empty: all are, everywhere.
    known: Vec<f32>,
}

/// A height of the grid, and how much of it is known: the rest is the ground around it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Found {
    /// The share times the mean of what is known.
    sum_m: f64,
    /// From 0 to 1.
    share: f64,
}

impl Found {
    fn mix(self, other: Self, share: f64) -> Self {
        let between = |a: f64, b: f64| a + (b - a) * share;
        Self { sum_m: between(self.sum_m, other.sum_m), share: between(self.share, other.share) }
    }
}

impl Raster {
    /// A grid of at least 2 x 2 samples, raised by `raise_m` (its zero above the ellipsoid), over the ground `around` it.
    pub fn new(mut grid: Grid, raise_m: f64, around: Terrain) -> Self {
        grid.heights_m.iter_mut().for_each(|height_m| *height_m += raise_m as f32);
        let mut coarser: Vec<Level> = Vec::new();
        loop {
            let next = match coarser.last() {
                None => halved(grid.columns, &grid.heights_m, &[]),
                Some(level) => halved(level.columns, &level.heights_m, &level.known),
            };
            if next.columns.min(next.heights_m.len() / next.columns.max(1)) < SMALLEST {
                break;
            }
            coarser.push(next);
        }
        let roughness = roughness(&grid, &around);
        Self { grid, coarser, around, roughness }
    }

    /// A place in samples of the grid from its first (columns, rows), and how many samples it is inside the edges.
    fn place(&self, latitude_rad: f64, longitude_rad: f64) -> (f64, f64, f64) {
        let grid = &self.grid;
        let rows = grid.heights_m.len() / grid.columns;
        let (last_x, last_y) = ((grid.columns - 1) as f64, (rows - 1) as f64);
        // Longitudes from the middle of the grid, so that it may lie across the 180th meridian.
        let middle_deg = grid.west_deg + 0.5 * last_x * grid.step_east_deg;
        let from_middle = wrap_pi(longitude_rad - middle_deg.to_radians()).to_degrees();
        let x = 0.5 * last_x + from_middle / grid.step_east_deg;
        let y = (grid.north_deg - latitude_rad.to_degrees()) / grid.step_south_deg;
        (x, y, x.min(last_x - x).min(y).min(last_y - y))
    }

    /// Samples over which the grid goes over into the ground around it: a small grid has a small margin.
    fn margin(&self) -> f64 {
        let shortest = self.grid.columns.min(self.grid.heights_m.len() / self.grid.columns) - 1;
        MARGIN.min(0.25 * shortest as f64)
    }

    /// Height at a place in samples of the grid from its first, at a level.
    fn at(&self, level: usize, x: f64, y: f64) -> Found {
        let (columns, heights_m, known) = match level.checked_sub(1) {
            None => (self.grid.columns, &self.grid.heights_m, &[][..]),
            Some(level) => {
                let level = &self.coarser[level];
                (level.columns, &level.heights_m, &level.known[..])
            }
        };
        let rows = heights_m.len() / columns;
        let size = f64::from(1 << level);
        // The middle of a mean over n samples lies (n - 1) / 2 samples after its first.
        let place = |at: f64, count: usize| (((at + 0.5) / size) - 0.5).clamp(0.0, (count - 1) as f64);
        let (x, y) = (place(x, columns), place(y, rows));
        let (column, row) = ((x as usize).min(columns - 2), (y as usize).min(rows - 2));
        let (u, v) = (x - column as f64, y - row as f64);
        let sample = |row: usize, column: usize| {
            let at = row * columns + column;
            let height_m = f64::from(heights_m[at]);
            if height_m.is_nan() {
                return Found::default();
            }
            let share = known.get(at).map_or(1.0, |share| f64::from(*share));
            Found { sum_m: share * height_m, share }
        };
        let north = sample(row, column).mix(sample(row, column + 1), u);
        let south = sample(row + 1, column).mix(sample(row + 1, column + 1), u);
        north.mix(south, v)
    }

    /// Height of the grid without what is shorter than `spacing_m`.
    fn smoothed(&self, x: f64, y: f64, spacing_m: f64) -> Found {
        let sample_m = self.grid.step_south_deg.to_radians() * EARTH_M;
        // From crest to crest there are two samples at least.
        let level = (spacing_m / (2.0 * sample_m)).max(1.0).log2().min(self.coarser.len() as f64);
        let (fine, share) = (level as usize, level.fract());
        let found = self.at(fine, x, y);
        if share == 0.0 { found } else { found.mix(self.at(fine + 1, x, y), share) }
    }
}

impl Heights for Raster {
    fn height_m(&self, latitude_rad: f64, longitude_rad: f64, spacing_m: f64) -> f64 {
        let around = || self.around.smoothed_height_m(latitude_rad, longitude_rad, spacing_m);
        let (x, y, inside) = self.place(latitude_rad, longitude_rad);
        if inside.is_nan() || inside < 0.0 {
            return around();
        }
        let found = self.smoothed(x, y, spacing_m);
        let weight = (inside / self.margin()).min(1.0);
        let weight = weight * weight * (3.0 - 2.0 * weight);
        let (sum_m, share) = (found.sum_m * weight, found.share * weight);
        // The weights of samples add up to 1 but for rounding.
        if share >= 1.0 - 1e-9 { sum_m / share } else { sum_m + around() * (1.0 - share) }
    }

    fn roughness(&self, latitude_rad: f64, longitude_rad: f64) -> Roughness {
        let (_, _, inside) = self.place(latitude_rad, longitude_rad);
        let [grid, margin] = self.roughness;
        let beyond = inside - self.margin();
        if beyond > 0.0 {
            // Towards a pole steps eastwards are shorter than the grain says.
            let east_m = self.grid.step_east_deg.to_radians() * EARTH_M * latitude_rad.cos().abs();
            let step_m = if latitude_rad.abs() > NEAR_POLE_RAD { grid.grain_m.min(0.5 * east_m) } else { grid.grain_m };
            return Roughness { reach_m: beyond * step_m, ..grid };
        }
        if inside >= 0.0 {
            return margin;
        }
        let around = self.around.roughness(&Geodetic { latitude_rad, longitude_rad, altitude_m: 0.0 });
        // Over a pole the way is shorter than along the circles of latitude.
        let share = if latitude_rad.abs() > NEAR_POLE_RAD { 0.5 } else { 1.0 };
        Roughness { reach_m: around.reach_m.min(-inside * share * grid.grain_m), ..around }
    }
}

impl fmt::Debug for Raster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Grid { north_deg, west_deg, columns, heights_m, .. } = &self.grid;
        write!(f, "{columns} x {} heights from {north_deg} N {west_deg} E", heights_m.len() / columns)
    }
}

/// How rough a grid is away from its edges and over the margin at these.
fn roughness(grid: &Grid, around: &Terrain) -> [Roughness; 2] {
    let rows = grid.heights_m.len() / grid.columns;
    let south_m = grid.step_south_deg.to_radians() * EARTH_M;
    let east_m = |row: usize, most_deg: f64| {
        let latitude_deg = grid.north_deg - row as f64 * grid.step_south_deg;
        // Not quite nothing at a pole, where all of a row is one place.
        grid.step_east_deg.to_radians() * EARTH_M * latitude_deg.abs().min(most_deg).to_radians().cos().max(1e-6)
    };
    let known = || grid.heights_m.iter().filter(|height_m| !height_m.is_nan());
    let highest_m = known().fold(0.0f64, |a, b| a.max(f64::from(b.abs())));
    let holes = grid.heights_m.iter().any(|height_m| height_m.is_nan());
    // Between two samples of which one is not known there may be a wall, as high as the two grounds are apart.
    let wall_m = highest_m + if around.is_ellipsoid() { 0.0 } else { HIGHEST_M };
    let rise_m = |a: f32, b: f32| match (a.is_nan(), b.is_nan()) {
        (false, false) => f64::from((a - b).abs()),
        (true, true) => 0.0,
        _ => wall_m,
    };
    let mut steepest = [0.0f64; 2];
    for (number, row) in grid.heights_m.chunks_exact(grid.columns).enumerate() {
        let east_m = east_m(number, 90.0);
        let eastwards = row.windows(2).map(|pair| rise_m(pair[0], pair[1]) / east_m);
        let next = grid.heights_m.get((number + 1) * grid.columns..).unwrap_or_default();
        let southwards = row.iter().zip(next).map(|(a, b)| rise_m(*a, *b) / south_m);
        steepest = [eastwards.fold(steepest[0], f64::max), southwards.fold(steepest[1], f64::max)];
    }
    let grain_m = south_m.min(east_m(0, FINEST_DEG)).min(east_m(rows - 1, FINEST_DEG));
    let steepest = steepest[0].hypot(steepest[1]);
    let margin = MARGIN.min(0.25 * (grid.columns.min(rows) - 1) as f64);
    // The weight of the grid rises by 1.5 over the margin's width at most.
    let outside = around.roughness(&Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, altitude_m: 0.0 });
    [
        // In a hole the ground around shows.
        match holes {
            true => {
                Roughness { grain_m: grain_m.min(outside.grain_m), steepest: steepest + outside.steepest, reach_m: 0.0 }
            }
            false => Roughness { grain_m, steepest, reach_m: 0.0 },
        },
        Roughness {
            grain_m: grain_m.min(outside.grain_m),
            steepest: steepest + outside.steepest + 1.5 * wall_m / (margin * grain_m),
            reach_m: grain_m,
        },
    ]
}

/// Means over 2 x 2 samples of which these shares are known (empty: all that are numbers). A last odd row or column goes into none.
fn halved(columns: usize, heights_m: &[f32], known: &[f32]) -> Level {
    let (half, rows) = (columns / 2, heights_m.len() / columns / 2);
    let mut level = Level { columns: half, heights_m: Vec::with_capacity(half * rows), known: Vec::new() };
    for (row, column) in (0..rows).flat_map(|row| (0..half).map(move |column| (row, column))) {
        let first = 2 * row * columns + 2 * column;
        let (mut sum_m, mut share) = (0.0, 0.0);
        for at in [first, first + 1, first + columns, first + columns + 1] {
            let height_m = heights_m[at];
            if !height_m.is_nan() {
                let there = known.get(at).copied().unwrap_or(1.0);
                sum_m += there * height_m;
                share += there;
            }
        }
        level.heights_m.push(if share > 0.0 { sum_m / share } else { f32::NAN });
        if share < 4.0 && level.known.is_empty() {
            level.known.reserve(half * rows);
            level.known.resize(level.heights_m.len() - 1, 1.0);
        }
        if share < 4.0 || !level.known.is_empty() {
            level.known.push(0.25 * share);
        }
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slope of 10 m a column and 3 m a row, 100 columns and 80 rows of 0.01 degrees from 47 N 8 E.
    fn slope() -> Grid {
        let heights_m = (0..80).flat_map(|row| (0..100).map(move |column| (10 * column + 3 * row) as f32)).collect();
        Grid { north_deg: 47.0, west_deg: 8.0, step_south_deg: 0.01, step_east_deg: 0.01, columns: 100, heights_m }
    }

    fn height(raster: &Raster, column: f64, row: f64, spacing_m: f64) -> f64 {
        raster.height_m((47.0 - 0.01 * row).to_radians(), (8.0 + 0.01 * column).to_radians(), spacing_m)
    }

    #[test]
    fn a_hole_is_as_rough_as_the_ground_that_shows_in_it() {
        let mut grid = slope();
        let middle = (46.6f64.to_radians(), 8.5f64.to_radians());
        let whole = Raster::new(slope(), 0.0, Terrain::procedural()).roughness(middle.0, middle.1);
        (0..10).for_each(|row| grid.heights_m[(35 + row) * 100 + 45..][..10].fill(f32::NAN));
        let holed = Raster::new(grid, 0.0, Terrain::procedural()).roughness(middle.0, middle.1);
        let around = Terrain::procedural().roughness(&Geodetic {
            latitude_rad: middle.0,
            longitude_rad: middle.1,
            altitude_m: 0.0,
        });
        assert!(holed.grain_m <= around.grain_m && holed.steepest >= around.steepest, "{holed:?}");
        // The tester: without a hole the grid's own samples, a kilometre wide, say it.
        assert!(whole.grain_m > 500.0 && whole.steepest < 0.1, "{whole:?}");
    }

    #[test]
    fn a_slope_is_a_slope_at_every_level_and_lies_above_its_zero() {
        let raster = Raster::new(slope(), 48.0, Terrain::ELLIPSOID);
        // Means over the middle of a slope are the slope itself: all levels agree. f32 samples of up to 1300 m: 1e-4 m.
        for spacing_m in [0.0, 2_300.0, 5_000.0, 11_000.0, 20_000.0] {
            for (column, row) in [(40.0, 30.0), (51.25, 42.5), (47.9, 35.1)] {
                let expected = 48.0 + 10.0 * column + 3.0 * row;
                let found = height(&raster, column, row, spacing_m);
                assert!((found - expected).abs() < 1e-3, "{column} {row} at {spacing_m}: {found}, not {expected}");
            }
        }
        assert_eq!(raster.coarser.len(), 5, "80, 40, 20, 10, 5, 2 rows");
    }

    #[test]
    fn what_is_short_is_gone_at_a_wide_spacing() {
        let mut grid = slope();
        let checks =
            (0..80).flat_map(|row| (0..100).map(move |column| if (row + column) % 2 == 0 { 100.0 } else { 0.0 }));
        grid.heights_m = checks.collect();
        let raster = Raster::new(grid, 0.0, Terrain::ELLIPSOID);
        // The place is a sample's to within rounding.
        assert!((height(&raster, 50.0, 40.0, 0.0) - 100.0).abs() < 1e-6);
        // Waves of two samples (2.2 km) are left out from a spacing of two waves on.
        assert!((height(&raster, 50.0, 40.0, 4_500.0) - 50.0).abs() < 1e-9);
    }

    #[test]
    fn at_its_edges_and_where_nothing_is_known_the_other_ground_shows() {
        let around = Terrain::procedural();
        let mut grid = slope();
        grid.heights_m[40 * 100 + 50] = f32::NAN;
        let raster = Raster::new(grid, 0.0, around.clone());
        let other = |column: f64, row: f64| {
            around.smoothed_height_m((47.0 - 0.01 * row).to_radians(), (8.0 + 0.01 * column).to_radians(), 0.0)
        };
        for (column, row) in [(-0.5, 40.0), (50.0, 80.0), (99.5, 40.0), (0.0, 40.0), (50.0, 79.0)] {
            assert_eq!(height(&raster, column, row, 0.0), other(column, row), "{column} {row}");
        }
        // At the sample that is not known the other ground, between it and its three known neighbours a quarter of it. The place is
        // a sample's to within rounding.
        assert!((height(&raster, 50.0, 40.0, 0.0) - other(50.0, 40.0)).abs() < 1e-6);
        let three_m = (10.0 * 49.0 + 3.0 * 39.0) + (10.0 * 50.0 + 3.0 * 39.0) + (10.0 * 49.0 + 3.0 * 40.0);
        let expected = 0.25 * (three_m + other(49.5, 39.5));
        assert!((height(&raster, 49.5, 39.5, 0.0) - expected).abs() < 1e-6);
        // Half-way over the margin of eight samples: the mean of both.
        let expected = 0.5 * (10.0 * 4.0 + 3.0 * 40.0 + other(4.0, 40.0));
        assert!((height(&raster, 4.0, 40.0, 0.0) - expected).abs() < 1e-3);
        assert_eq!(raster.height_m(f64::NAN, 0.1, 0.0), around.smoothed_height_m(f64::NAN, 0.1, 0.0));
    }

    #[test]
    fn a_hole_is_as_large_in_coarse_pictures_as_it_is() {
        // A plateau of 1,000 m with a hole of 4 x 4 samples, over the ellipsoid: the hole is 0 m.
        let mut grid = slope();
        grid.heights_m.fill(1_000.0);
        for (row, column) in (40..44).flat_map(|row| (40..44).map(move |column| (row, column))) {
            grid.heights_m[row * 100 + column] = f32::NAN;
        }
        let raster = Raster::new(grid, 0.0, Terrain::ELLIPSOID);
        let mean_m = |spacing_m: f64| {
            let places =
                (0..400).flat_map(|k| (0..400).map(move |l| (22.0 + 0.1 * f64::from(k), 22.0 + 0.1 * f64::from(l))));
            places.map(|(column, row)| height(&raster, column, row, spacing_m)).sum::<f64>() / 160_000.0
        };
        // Sixteen of 40 x 40 samples are missing: 1 % of the ground, at every level; interpolation keeps the sum.
        for spacing_m in [0.0, 2_000.0, 4_500.0, 7_000.0, 9_000.0] {
            let mean_m = mean_m(spacing_m);
            // Exact but for rounding, also where places are counted in degrees.
            assert!((mean_m - 990.0).abs() < 1e-3, "{spacing_m}: {mean_m}");
        }
        // Of means of 4 x 4 the one that is the hole knows nothing, and the one beside it all.
        let level = &raster.coarser[1];
        assert_eq!((level.known[10 * 25 + 10], level.known[10 * 25 + 9]), (0.0, 1.0));
        assert!(level.heights_m[10 * 25 + 10].is_nan() && level.heights_m[10 * 25 + 9] == 1_000.0);
        assert!(Raster::new(slope(), 0.0, Terrain::ELLIPSOID).coarser.iter().all(|level| level.known.is_empty()));
    }

    #[test]
    fn a_grid_lies_across_the_date_line() {
        let grid = Grid { west_deg: 179.5, ..slope() };
        let raster = Raster::new(grid, 0.0, Terrain::ELLIPSOID);
        let at = |longitude_deg: f64| raster.height_m(46.6f64.to_radians(), longitude_deg.to_radians(), 0.0);
        for (longitude_deg, expected) in [(179.8, 420.0), (-179.9, 720.0), (180.1, 720.0), (-179.0, 0.0), (0.0, 0.0)] {
            assert!((at(longitude_deg) - expected).abs() < 1e-3, "{longitude_deg}: {}", at(longitude_deg));
        }
    }
}
