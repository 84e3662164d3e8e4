//! The rings of the coastline, read from the table in the binary and found by place.

use std::sync::LazyLock;

/// Units of the table in a degree.
const PER_DEGREE: f64 = 500.0;
/// Edges along this meridian are cuts.
const CUT_DEG: f64 = 180.0;
/// Cells of the index: one degree each way.
const COLUMNS: usize = 360;
const ROWS: usize = 180;

/// One edge of a ring, in degrees; the longitude of its end is brought next to that of its start (beyond 180 if need be).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Longitude and latitude of its start.
    pub from: [f64; 2],
    /// Of its end.
    pub to: [f64; 2],
}

/// All edges, and which of them touch a cell of one degree.
pub struct Rings {
    edges: Vec<Edge>,
    /// For each cell, row by row from the south-west, where its edges begin in `listed`.
    begins: Vec<u32>,
    listed: Vec<u32>,
}

/// The coastline of the Earth.
pub fn shared() -> &'static Rings {
    static RINGS: LazyLock<Rings> = LazyLock::new(|| Rings::new(&decode(include_bytes!("../../../data/coast.bin"))));
    &RINGS
}

impl Rings {
    /// Indexes rings of points (longitude, latitude in degrees).
    pub fn new(rings: &[Vec<[f64; 2]>]) -> Self {
        let mut edges = Vec::new();
        for ring in rings {
            for (i, from) in ring.iter().enumerate() {
                let mut to = ring[(i + 1) % ring.len()];
                to[0] += 360.0 * ((from[0] - to[0]) / 360.0).round();
                // Where land was cut at the 180th meridian there is no shore.
                if from[0].abs() >= CUT_DEG && to[0] == from[0] {
                    continue;
                }
                edges.push(Edge { from: *from, to });
            }
        }
        let mut cells = vec![Vec::new(); COLUMNS * ROWS];
        for (i, edge) in edges.iter().enumerate() {
            let span = |axis: usize| [edge.from[axis].min(edge.to[axis]), edge.from[axis].max(edge.to[axis])];
            let ([west, east], [south, north]) = (span(0), span(1));
            for row in cell(south + 90.0, ROWS)..=cell(north + 90.0, ROWS) {
                for column in (west + 180.0).floor() as i32..=(east + 180.0).floor() as i32 {
                    cells[row * COLUMNS + column.rem_euclid(COLUMNS as i32) as usize].push(i as u32);
                }
            }
        }
        let mut begins = vec![0];
        let mut listed = Vec::new();
        for cell in cells {
            listed.extend(cell);
            begins.push(listed.len() as u32);
        }
        Self { edges, begins, listed }
    }

    /// The edges that touch the cells between two longitudes and two latitudes (degrees), each brought to the longitudes
    /// about the middle; some of them twice.
    pub fn around(&self, [west, east]: [f64; 2], [south, north]: [f64; 2]) -> Vec<Edge> {
        let middle = 0.5 * (west + east);
        let (mut found, mut last) = (Vec::new(), None);
        let columns = ((east + 180.0).floor() as i32 - (west + 180.0).floor() as i32).min(COLUMNS as i32 - 1);
        for row in cell(south + 90.0, ROWS)..=cell(north + 90.0, ROWS) {
            for k in 0..=columns {
                let column = ((west + 180.0).floor() as i32 + k).rem_euclid(COLUMNS as i32) as usize;
                for index in &self.listed[self.cell_range(row, column)] {
                    // A long edge is listed in neighbouring cells one after another.
                    if last == Some(*index) {
                        continue;
                    }
                    last = Some(*index);
                    let mut edge = self.edges[*index as usize];
                    let by = 360.0 * ((middle - edge.from[0]) / 360.0).round();
                    (edge.from[0], edge.to[0]) = (edge.from[0] + by, edge.to[0] + by);
                    found.push(edge);
                }
            }
        }
        found
    }

    /// Latitudes at which a meridian crosses the shore, from the south. South of the first is land: the Antarctic.
    pub fn crossings(&self, longitude_deg: f64) -> Vec<f64> {
        let mut found = Vec::new();
        let column = cell((longitude_deg + 180.0).rem_euclid(360.0), COLUMNS);
        // A vertex on the border of two cells belongs to the edges of both: looked for on both sides.
        let mut last = Vec::new();
        for column in [column, (column + COLUMNS - 1) % COLUMNS] {
            for row in 0..ROWS {
                for index in &self.listed[self.cell_range(row, column)] {
                    let Edge { from, to } = self.edges[*index as usize];
                    let at = longitude_deg + 360.0 * ((from[0] - longitude_deg) / 360.0).round();
                    // Half open, so that a vertex counts once.
                    if (from[0] <= at) != (to[0] <= at) {
                        last.push((*index, from[1] + (to[1] - from[1]) * ((at - from[0]) / (to[0] - from[0]))));
                    }
                }
            }
        }
        last.sort_by_key(|(index, _)| *index);
        last.dedup_by_key(|(index, _)| *index);
        found.extend(last.into_iter().map(|(_, latitude)| latitude));
        found.sort_by(f64::total_cmp);
        found
    }

    fn cell_range(&self, row: usize, column: usize) -> std::ops::Range<usize> {
        let cell = row * COLUMNS + column;
        self.begins[cell] as usize..self.begins[cell + 1] as usize
    }
}

fn cell(degrees: f64, count: usize) -> usize {
    (degrees.max(0.0) as usize).min(count - 1)
}

/// The rings of the table; one that ends early has the rings up to there.
fn decode(bytes: &[u8]) -> Vec<Vec<[f64; 2]>> {
    let mut at = 8;
    let mut next = || {
        let (mut value, mut shift) = (0u64, 0);
        loop {
            let byte = *bytes.get(at)?;
            at += 1;
            value |= u64::from(byte & 127) << shift;
            shift += 7;
            if byte < 128 || shift > 56 {
                return Some((value >> 1) as i64 ^ -((value & 1) as i64));
            }
        }
    };
    let mut rings = Vec::new();
    // The length is written as it is, the coordinates with their sign in the lowest bit.
    while let Some(length) = next() {
        let (mut x, mut y) = (0, 0);
        let mut ring = Vec::new();
        for _ in 0..length {
            let (Some(dx), Some(dy)) = (next(), next()) else { return rings };
            (x, y) = (x + dx, y + dy);
            ring.push([x as f64 / PER_DEGREE, y as f64 / PER_DEGREE]);
        }
        rings.push(ring);
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_read_to_its_end() {
        let bytes = include_bytes!("../../../data/coast.bin");
        let rings = decode(bytes);
        let said = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]);
        assert_eq!(&bytes[..4], b"SDC1");
        assert_eq!(rings.len(), said as usize);
        let inside = |[x, y]: &[f64; 2]| x.abs() <= 180.0 && y.abs() <= 90.0;
        assert!(rings.iter().all(|ring| ring.len() > 2 && ring.iter().all(inside)));
    }

    #[test]
    fn a_meridian_crosses_a_square_twice_and_one_beyond_180_too() {
        let square = |west: f64, east: f64| vec![[west, 10.0], [east, 10.0], [east, 20.0], [west, 20.0]];
        let rings = Rings::new(&[square(5.0, 8.0), square(178.5, -177.0)]);
        for longitude in [5.5, 6.0, 7.999, 179.0, 180.0, -180.0, -178.0] {
            assert_eq!(rings.crossings(longitude), [10.0, 20.0], "{longitude}");
        }
        for longitude in [4.9, 8.1, 178.4, -176.9, 0.0] {
            assert_eq!(rings.crossings(longitude), Vec::<f64>::new(), "{longitude}");
        }
        assert!(!rings.around([177.0, 179.0], [9.0, 11.0]).is_empty());
        assert!(rings.around([-60.0, -59.0], [9.0, 11.0]).is_empty());
    }
}
