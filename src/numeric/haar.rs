//! Three-dimensional orthonormal Haar transform of any box: each level halves what is left of every axis that still can be.

/// The transform of one box shape. An odd end of an axis is carried to the next level as it is, so every shape works and
/// lengths (sums of squares) stay.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Haar {
    cells: [usize; 3],
    levels: Vec<[usize; 3]>,
}

impl Haar {
    /// The transform for boxes of these edges, first axis fastest.
    pub fn new(cells: [usize; 3]) -> Self {
        let mut levels = Vec::new();
        let mut size = cells;
        while size.iter().any(|n| *n > 1) {
            levels.push(size);
            size = size.map(|n| n.div_ceil(2));
        }
        Self { cells, levels }
    }

    /// Number of values of a box.
    pub fn len(&self) -> usize {
        self.cells.iter().product()
    }

    /// Whether the box has no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Values to coefficients, in place; the mean times the root of the count comes first.
    pub fn forward(&self, values: &mut [f32], scratch: &mut Vec<f32>) {
        for size in &self.levels {
            for axis in 0..3 {
                self.lines(*size, axis, values, scratch, split);
            }
        }
    }

    /// Coefficients to values, in place.
    pub fn inverse(&self, values: &mut [f32], scratch: &mut Vec<f32>) {
        for size in self.levels.iter().rev() {
            for axis in (0..3).rev() {
                self.lines(*size, axis, values, scratch, join);
            }
        }
    }

    /// One step along every line of an axis within the lower corner that a level works on. Lines across the first axis are
    /// taken as bundles of the first axis's length, which vectorises.
    fn lines(
        &self,
        size: [usize; 3],
        axis: usize,
        values: &mut [f32],
        scratch: &mut Vec<f32>,
        step: fn(&mut [f32], &mut Vec<f32>, usize, usize, usize),
    ) {
        if size[axis] < 2 {
            return;
        }
        let stride = [1, self.cells[0], self.cells[0] * self.cells[1]];
        let (bundle, outer) = match axis {
            0 => (1, [size[1], size[2]]),
            1 => (size[0], [1, size[2]]),
            _ => (size[0], [size[1], 1]),
        };
        for j in 0..outer[1] {
            for i in 0..outer[0] {
                let start = i * stride[1] + j * stride[2];
                step(&mut values[start..], scratch, size[axis], stride[axis], bundle);
            }
        }
    }
}

const ROOT_HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// Sums to the front, differences behind them.
fn split(values: &mut [f32], scratch: &mut Vec<f32>, n: usize, stride: usize, bundle: usize) {
    let half = n.div_ceil(2);
    scratch.clear();
    scratch.resize(n * bundle, 0.0);
    for k in 0..n / 2 {
        for b in 0..bundle {
            let (a, c) = (values[2 * k * stride + b], values[(2 * k + 1) * stride + b]);
            scratch[k * bundle + b] = (a + c) * ROOT_HALF;
            scratch[(half + k) * bundle + b] = (a - c) * ROOT_HALF;
        }
    }
    if n % 2 == 1 {
        for b in 0..bundle {
            scratch[(half - 1) * bundle + b] = values[(n - 1) * stride + b];
        }
    }
    put(values, scratch, n, stride, bundle);
}

fn join(values: &mut [f32], scratch: &mut Vec<f32>, n: usize, stride: usize, bundle: usize) {
    let half = n.div_ceil(2);
    scratch.clear();
    scratch.resize(n * bundle, 0.0);
    for k in 0..n / 2 {
        for b in 0..bundle {
            let (s, d) = (values[k * stride + b], values[(half + k) * stride + b]);
            scratch[2 * k * bundle + b] = (s + d) * ROOT_HALF;
            scratch[(2 * k + 1) * bundle + b] = (s - d) * ROOT_HALF;
        }
    }
    if n % 2 == 1 {
        for b in 0..bundle {
            scratch[(n - 1) * bundle + b] = values[(half - 1) * stride + b];
        }
    }
    put(values, scratch, n, stride, bundle);
}

fn put(values: &mut [f32], scratch: &[f32], n: usize, stride: usize, bundle: usize) {
    for (k, row) in scratch.chunks(bundle).enumerate().take(n) {
        values[k * stride..][..bundle].copy_from_slice(row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::hash::{pcg3d, unit};

    fn noise(n: usize) -> Vec<f32> {
        (0..n as u32).map(|i| unit(pcg3d(i, 3, 4)[0]) - 0.3).collect()
    }

    #[test]
    fn every_shape_comes_back_with_its_length() {
        for cells in [[32, 32, 4], [1, 1, 1], [5, 3, 7], [8, 1, 1], [1, 6, 2], [64, 64, 8]] {
            let haar = Haar::new(cells);
            let values = noise(haar.len());
            let mut there = values.clone();
            let mut scratch = Vec::new();
            haar.forward(&mut there, &mut scratch);
            let square = |v: &[f32]| v.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>();
            // Rounding of f32 over up to eighteen steps.
            assert!((square(&there) / square(&values) - 1.0).abs() < 1e-5, "{cells:?}");
            let mut back = there.clone();
            haar.inverse(&mut back, &mut scratch);
            assert!(values.iter().zip(&back).all(|(a, b)| (a - b).abs() < 2e-6), "{cells:?}");
        }
    }

    #[test]
    fn a_uniform_box_is_one_coefficient_and_a_hand_computed_one_is_right() {
        let haar = Haar::new([4, 2, 2]);
        let mut values = vec![3.0; 16];
        haar.forward(&mut values, &mut Vec::new());
        assert!((values[0] - 12.0).abs() < 1e-5 && values[1..].iter().all(|v| v.abs() < 1e-6));
        // 1, 2, 3, 5 on a line: pairs sum to 3 and 8, differ by -1 and -2; then 11 and -5.
        let line = Haar::new([4, 1, 1]);
        let mut values = vec![1.0, 2.0, 3.0, 5.0];
        line.forward(&mut values, &mut Vec::new());
        let root = 2.0_f32.sqrt();
        for (found, expected) in values.iter().zip([5.5, -2.5, -1.0 / root, -2.0 / root]) {
            assert!((found - expected).abs() < 1e-6, "{values:?}");
        }
    }
}
