//! Twin of `glow.wgsl`.

/// An image of one value a pixel, row by row; beyond its rim there is nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Width and height.
    pub size: [usize; 2],
    /// Its values.
    pub values: Vec<f32>,
}

impl Level {
    fn at(&self, x: i64, y: i64) -> f32 {
        let [width, height] = self.size.map(|n| n as i64);
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        if inside { self.values[(x + y * width) as usize] } else { 0.0 }
    }

    fn made(size: [usize; 2], value: impl Fn(i64, i64) -> f32) -> Self {
        let places = (0..size[0] * size[1]).map(|i| ((i % size[0]) as i64, (i / size[0]) as i64));
        Self { size, values: places.map(|(x, y)| value(x, y)).collect() }
    }

    /// The level of half the size: weights 1 3 3 1 along both axes.
    fn halved(&self) -> Self {
        let row = |x: i64, y: i64| {
            0.125 * (self.at(x - 1, y) + self.at(x + 2, y)) + 0.375 * (self.at(x, y) + self.at(x + 1, y))
        };
        Self::made(self.size.map(|n| n.div_ceil(2)), |x, y| {
            let (x, y) = (2 * x, 2 * y);
            0.125 * (row(x, y - 1) + row(x, y + 2)) + 0.375 * (row(x, y) + row(x, y + 1))
        })
    }

    /// This level at a pixel of the finer one: three quarters of the texel that it lies in, a quarter of the nearest other.
    fn spread(&self, x: i64, y: i64) -> f32 {
        let other = |at: i64| (at >> 1) + if at & 1 == 1 { 1 } else { -1 };
        let ([x, other_x], [y, other_y]) = ([x >> 1, other(x)], [y >> 1, other(y)]);
        0.5625 * self.at(x, y)
            + 0.1875 * (self.at(other_x, y) + self.at(x, other_y))
            + 0.0625 * self.at(other_x, other_y)
    }
}

/// An image with its glow: the shares of [`super::weights`] of each level together.
pub fn glowing(image: Level, weights: &[f32]) -> Level {
    let mut levels = vec![image];
    for _ in 1..weights.len() {
        levels.push(levels[levels.len() - 1].halved());
    }
    let mut gathered: Option<Level> = None;
    for (level, weight) in levels.iter().zip(weights).rev() {
        let coarser = |x: i64, y: i64| gathered.as_ref().map_or(0.0, |coarser| coarser.spread(x, y));
        gathered = Some(Level::made(level.size, |x, y| weight * level.at(x, y) + coarser(x, y)));
    }
    gathered.unwrap_or(Level { size: [0; 2], values: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::glow::weights;

    fn point(size: [usize; 2], at: [usize; 2]) -> Level {
        let mut level = Level { size, values: vec![0.0; size[0] * size[1]] };
        level.values[at[0] + at[1] * size[0]] = 1_000.0;
        level
    }

    #[test]
    fn glow_keeps_the_light() {
        let shares = [0.6, 0.2, 0.1, 0.06, 0.04];
        for at in [[120, 90], [121, 90], [122, 93], [127, 95]] {
            let glowing = glowing(point([251, 187], at), &shares);
            let sum: f32 = glowing.values.iter().sum();
            // Far from the rim every weight is passed on: rounding of some thousand terms.
            assert!((sum - 1_000.0).abs() < 0.1, "{at:?}: {sum}");
            assert!(glowing.values.iter().all(|v| *v >= 0.0));
            let [x, y] = at;
            assert!((glowing.values[x + y * 251] - 600.0) > 0.0, "the core stays");
        }
    }

    #[test]
    fn each_level_is_as_wide_as_its_weight_is_made_for() {
        for level in 1..5 {
            let mut shares = vec![0.0; level + 1];
            shares[level] = 1.0;
            let glowing = glowing(point([256, 256], [128, 131]), &shares);
            let mut sums = [0.0f64; 3];
            for (i, v) in glowing.values.iter().enumerate() {
                let x = (i % 256) as f64;
                sums = [sums[0] + f64::from(*v), sums[1] + f64::from(*v) * x, sums[2] + f64::from(*v) * x * x];
            }
            let variance = sums[2] / sums[0] - (sums[1] / sums[0]).powi(2);
            let expected = 0.5 * (4f64.powi(level as i32) - 1.0);
            // Exact for the mean over where the point lies in its texel; a single place is off by up to the level's grid.
            assert!((variance / expected - 1.0).abs() < 0.2, "{level}: {variance} {expected}");
        }
    }

    #[test]
    fn shares_follow_the_glare_equation() {
        for (pixel_deg, size) in [(0.094, [640, 360]), (0.03, [1920, 1080]), (0.5, [16, 16]), (10.0, [640, 360])] {
            let shares = weights(pixel_deg, size);
            let sum: f32 = shares.iter().sum();
            assert!((sum - 1.0).abs() < 1e-5 && shares.iter().all(|w| *w >= 0.0), "{pixel_deg}: {shares:?}");
            assert!(shares[0] > 0.9, "most of the light stays: {shares:?}");
        }
        // A lux of light spreads 10 + 5 cd/m2 a degree away in the eye, 0.15 times that in the lens: an octave around a degree, from its lower end to its upper one,
        // holds the ring's integral 2 pi (pi / 180)^2 (5 ln 2 + 10 (1 / a - 1 / 2a)).
        let shares = weights(0.094, [640, 360]);
        let sigma = 0.094 * (0.5f32 * (4f32.powi(4) - 1.0)).sqrt();
        let (low, high) = (sigma / 2f32.sqrt(), sigma * 2f32.sqrt());
        let ring = 0.15 * std::f32::consts::TAU * 3.046_2e-4 * (5.0 * 2f32.ln() + 10.0 / low - 10.0 / high);
        assert!((shares[4] / ring - 1.0).abs() < 0.02, "{} {ring}", shares[4]);
    }
}
