//! The picture of a sheet: a grid of cells with labels above, beside and in them.

use super::font;
use crate::frame::Pixels;

/// Pixels between cells.
const GAP: u32 = 4;
const BACKGROUND: [u8; 4] = [24, 24, 28, 255];
const INK: [u8; 3] = [235, 235, 235];

/// A sheet under way.
pub(super) struct Canvas {
    cell: [u32; 2],
    /// Left and upper margin, which hold the labels.
    margin: [u32; 2],
    size: [u32; 2],
    scale: u32,
    rows: Vec<String>,
    columns: Vec<String>,
    rgba: Vec<u8>,
}

impl Canvas {
    /// An empty sheet with its margins written; none when it would have more than `most` pixels.
    pub(super) fn new(cell: [u32; 2], rows: &[String], columns: &[String], most: u64) -> Option<Self> {
        let scale = (cell[0] / 200).clamp(1, 4);
        let longest = rows.iter().map(|label| label.chars().count()).max().unwrap_or(0) as u32;
        let margin = [scale * (longest + 1) * font::ADVANCE, scale * 2 * font::HEIGHT];
        let side = |margin: u32, cells: usize, cell: u32| u64::from(margin) + cells as u64 * u64::from(cell + GAP);
        let size = [side(margin[0], columns.len(), cell[0]), side(margin[1], rows.len(), cell[1])];
        if size[0].checked_mul(size[1])? > most {
            return None;
        }
        let rgba = BACKGROUND.repeat((size[0] * size[1]) as usize);
        let size = size.map(|side| side as u32);
        let mut canvas = Self { cell, margin, size, scale, rows: rows.to_vec(), columns: columns.to_vec(), rgba };
        for (x, label) in columns.iter().enumerate() {
            canvas.write(label, [canvas.corner([x, 0])[0], scale * font::HEIGHT / 2]);
        }
        for (y, label) in rows.iter().enumerate() {
            canvas.write(label, [scale * font::ADVANCE / 2, canvas.corner([0, y])[1] + cell[1] / 2]);
        }
        Some(canvas)
    }

    /// Puts a cell's RGBA pixels, rows from the top, into column x and row y, with its own label in the corner.
    pub(super) fn paste(&mut self, at: [usize; 2], rgba: &[u8]) {
        let [left, top] = self.corner(at);
        let row = self.cell[0] as usize * 4;
        for (y, line) in rgba.chunks_exact(row).take(self.cell[1] as usize).enumerate() {
            let start = ((top as usize + y) * self.size[0] as usize + left as usize) * 4;
            self.rgba[start..start + row].copy_from_slice(line);
        }
        let label = format!("{}, {}", self.rows[at[1]], self.columns[at[0]]);
        // One size smaller than in the margins, where that is possible.
        let scale = (self.scale - 1).max(1);
        let y = top + self.cell[1].saturating_sub(scale * font::HEIGHT + 3);
        self.write_in(&label, [left + 3, y], scale, left + self.cell[0]);
    }

    /// Size and pixels of the whole.
    pub(super) fn finish(self) -> ([u32; 2], Pixels) {
        (self.size, Pixels::Srgb8(self.rgba))
    }

    fn corner(&self, [x, y]: [usize; 2]) -> [u32; 2] {
        [self.margin[0] + x as u32 * (self.cell[0] + GAP), self.margin[1] + y as u32 * (self.cell[1] + GAP)]
    }

    fn write(&mut self, text: &str, at: [u32; 2]) {
        self.write_in(text, at, self.scale, self.size[0]);
    }

    /// Writes with a dark rim, so that it can be read on any cloud; what would pass `right` is left out.
    fn write_in(&mut self, text: &str, at: [u32; 2], scale: u32, right: u32) {
        let dots: Vec<[u32; 2]> = font::dots(text)
            .flat_map(|[x, y]| (0..scale * scale).map(move |i| [x * scale + i % scale, y * scale + i / scale]))
            .map(|[x, y]| [at[0] + x, at[1] + y])
            .filter(|[x, _]| x + 1 < right)
            .collect();
        for [x, y] in &dots {
            for (dx, dy) in (0..3).flat_map(|dx| (0..3).map(move |dy| (dx, dy))) {
                self.dot([(x + dx).wrapping_sub(1), (y + dy).wrapping_sub(1)], [0; 3]);
            }
        }
        dots.iter().for_each(|at| self.dot(*at, INK));
    }

    fn dot(&mut self, [x, y]: [u32; 2], ink: [u8; 3]) {
        if x < self.size[0] && y < self.size[1] {
            let start = (y as usize * self.size[0] as usize + x as usize) * 4;
            self.rgba[start..start + 3].copy_from_slice(&ink);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_lie_where_they_are_pasted_and_labels_are_written() {
        let labels = |n: usize| vec!["A".to_owned(); n];
        let mut canvas = Canvas::new([40, 30], &labels(2), &labels(3), 1 << 20).expect("a small sheet");
        let empty = canvas.rgba.clone();
        assert!(empty.chunks(4).any(|p| p[..3] == INK), "labels in the margins");
        let red = [200, 0, 0, 255].repeat(40 * 30);
        canvas.paste([2, 1], &red);
        let [left, top] = canvas.corner([2, 1]);
        let ([width, height], Pixels::Srgb8(rgba)) = canvas.finish() else { panic!("8-bit pixels") };
        assert_eq!((left + 40 + GAP, top + 30 + GAP), (width, height));
        let pixel = |x: u32, y: u32| &rgba[((y * width + x) * 4) as usize..][..3];
        assert_eq!(pixel(left, top), [200, 0, 0]);
        assert_eq!(pixel(left - 1, top), &BACKGROUND[..3]);
        // All that changed lies in the cell, and a label lies over it.
        let changed = rgba.chunks(4).zip(empty.chunks(4)).filter(|(a, b)| a != b).count();
        assert_eq!(changed, 40 * 30);
        assert!(rgba.chunks(4).filter(|p| p[..3] == [200, 0, 0]).count() < 40 * 30);
    }

    #[test]
    fn a_sheet_that_is_too_large_is_none() {
        assert!(Canvas::new([8192, 4096], &["a".into(), "b".into()], &["c".into()], 64 << 20).is_none());
    }
}
