//! Heights on a grid of latitudes and longitudes, as a file has them, laid over another ground.
//!
//! *What it is.* Samples at equal steps of latitude and longitude, above the ellipsoid. *How we compute it.* Bilinear between
//! samples; what is shorter than asked for comes from means over 2, 4, 8, ... samples each way, blended between two of these
//! levels. *How we store it.* f32, rows from the north; a sample that is not known is NaN, and there the other ground shows.
//! *How we read it back.* Towards the edges the grid goes over into the ground around it.

use super::terrain::{Heights, Terrain};
use crate::units::wrap_pi;
use std::fmt;

/// Samples over which the grid goes over into the ground around it, at its edges.
const MARGIN: f64 = 8.0;
/// Radius of a sphere for lengths along a meridian, good to half a per cent.
const EARTH_M: f64 = 6_371_000.0;
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
}

#[derive(Debug)]
struct Level {
    columns: usize,
    heights_m: Vec<f32>,
}

impl Raster {
    /// A grid of at least 2 x 2 samples, raised by `raise_m` (its zero above the ellipsoid), over the ground `around` it.
    pub fn new(mut grid: Grid, raise_m: f64, around: Terrain) -> Self {
        grid.heights_m.iter_mut().for_each(|height_m| *height_m += raise_m as f32);
        let mut coarser: Vec<Level> = Vec::new();
        loop {
            let (columns, heights_m) =
                coarser.last().map_or((grid.columns, &grid.heights_m), |level| (level.columns, &level.heights_m));
            if columns.min(heights_m.len() / columns.max(1)) < 2 * SMALLEST {
                break;
            }
            coarser.push(halved(columns, heights_m));
        }
        Self { grid, coarser, around }
    }

    /// Height at a place in samples of the grid from its first, at a level; `None`: not known there.
    fn at(&self, level: usize, x: f64, y: f64) -> Option<f64> {
        let (columns, heights_m) = match level.checked_sub(1) {
            None => (self.grid.columns, &self.grid.heights_m),
            Some(level) => (self.coarser[level].columns, &self.coarser[level].heights_m),
        };
        let rows = heights_m.len() / columns;
        let size = f64::from(1 << level);
        // The middle of a mean over n samples lies (n - 1) / 2 samples after its first.
        let place = |at: f64, count: usize| (((at + 0.5) / size) - 0.5).clamp(0.0, (count - 1) as f64);
        let (x, y) = (place(x, columns), place(y, rows));
        let (column, row) = ((x as usize).min(columns - 2), (y as usize).min(rows - 2));
        let (u, v) = (x - column as f64, y - row as f64);
        let sample = |row: usize, column: usize| f64::from(heights_m[row * columns + column]);
        let north = sample(row, column) * (1.0 - u) + sample(row, column + 1) * u;
        let south = sample(row + 1, column) * (1.0 - u) + sample(row + 1, column + 1) * u;
        Some(north * (1.0 - v) + south * v).filter(|height_m| height_m.is_finite())
    }

    /// Height of the grid without what is shorter than `spacing_m`.
    fn smoothed(&self, x: f64, y: f64, spacing_m: f64) -> Option<f64> {
        let sample_m = self.grid.step_south_deg.to_radians() * EARTH_M;
        // From crest to crest there are two samples at least.
        let level = (spacing_m / (2.0 * sample_m)).max(1.0).log2().min(self.coarser.len() as f64);
        let (fine, share) = (level as usize, level.fract());
        let height_m = self.at(fine, x, y)?;
        if share == 0.0 {
            return Some(height_m);
        }
        Some(height_m + (self.at(fine + 1, x, y)? - height_m) * share)
    }
}

impl Heights for Raster {
    fn height_m(&self, latitude_rad: f64, longitude_rad: f64, spacing_m: f64) -> f64 {
        let around = || self.around.smoothed_height_m(latitude_rad, longitude_rad, spacing_m);
        let grid = &self.grid;
        let rows = grid.heights_m.len() / grid.columns;
        let (last_x, last_y) = ((grid.columns - 1) as f64, (rows - 1) as f64);
        // Longitudes from the middle of the grid, so that it may lie across the 180th meridian.
        let middle_deg = grid.west_deg + 0.5 * last_x * grid.step_east_deg;
        let from_middle = wrap_pi(longitude_rad - middle_deg.to_radians()).to_degrees();
        let x = 0.5 * last_x + from_middle / grid.step_east_deg;
        let y = (grid.north_deg - latitude_rad.to_degrees()) / grid.step_south_deg;
        let inside = x.min(last_x - x).min(y).min(last_y - y);
        if inside.is_nan() || inside < 0.0 {
            return around();
        }
        let Some(height_m) = self.smoothed(x, y, spacing_m) else { return around() };
        // A small grid has a small margin.
        let share = (inside / MARGIN.min(0.25 * last_x.min(last_y))).min(1.0);
        if share >= 1.0 {
            return height_m;
        }
        let share = share * share * (3.0 - 2.0 * share);
        height_m * share + around() * (1.0 - share)
    }
}

impl fmt::Debug for Raster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Grid { north_deg, west_deg, columns, heights_m, .. } = &self.grid;
        write!(f, "{columns} x {} heights from {north_deg} N {west_deg} E", heights_m.len() / columns)
    }
}

/// Means over 2 x 2 samples; what is not known of a mean's four is not known of it. A last odd row or column goes into none.
fn halved(columns: usize, heights_m: &[f32]) -> Level {
    let (half, rows) = (columns / 2, heights_m.len() / columns / 2);
    let mean = |row: usize, column: usize| {
        let at = 2 * row * columns + 2 * column;
        0.25 * (heights_m[at] + heights_m[at + 1] + heights_m[at + columns] + heights_m[at + columns + 1])
    };
    let heights_m = (0..rows).flat_map(|row| (0..half).map(move |column| mean(row, column))).collect();
    Level { columns: half, heights_m }
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
        for (column, row) in [(-0.5, 40.0), (50.0, 80.0), (99.5, 40.0), (0.0, 40.0), (50.0, 79.0), (49.5, 39.5)] {
            assert_eq!(height(&raster, column, row, 0.0), other(column, row), "{column} {row}");
        }
        // Half-way over the margin of eight samples: the mean of both.
        let expected = 0.5 * (10.0 * 4.0 + 3.0 * 40.0 + other(4.0, 40.0));
        assert!((height(&raster, 4.0, 40.0, 0.0) - expected).abs() < 1e-3);
        assert_eq!(raster.height_m(f64::NAN, 0.1, 0.0), around.smoothed_height_m(f64::NAN, 0.1, 0.0));
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
