//! Texture look-ups of the twins: the arithmetic of a sampler with linear filtering, in f32.

/// Splits a texel coordinate (centres at integers) into the lower texel and the share of the upper one.
#[inline]
fn split(at: f32) -> (i32, f32) {
    // The same as `floor`, which without SSE4.1 is a call.
    let whole = at as i32;
    let low = whole - i32::from((whole as f32) > at);
    (low, at - low as f32)
}

/// Bilinear look-up in a `width * width` map of bytes that repeats; `u`, `v` in periods. Answers 0 to 1.
pub fn map_repeat(map: &[u8], width: usize, u: f32, v: f32) -> f32 {
    debug_assert!(width.is_power_of_two());
    let mask = width as i32 - 1;
    let (x, fx) = split(u * width as f32 - 0.5);
    let (y, fy) = split(v * width as f32 - 0.5);
    let at = |dx: i32, dy: i32| f32::from(map[((x + dx) & mask) as usize + ((y + dy) & mask) as usize * width]);
    let low = at(0, 0) + (at(1, 0) - at(0, 0)) * fx;
    let high = at(0, 1) + (at(1, 1) - at(0, 1)) * fx;
    (low + (high - low) * fy) * (1.0 / 255.0)
}

/// Trilinear look-up of one byte in a volume `width * width * height` that repeats in x and y; z is clamped unless
/// `repeat_z`. Coordinates in periods. Answers 0 to 1.
pub fn volume_byte(data: &[u8], width: usize, height: usize, repeat_z: bool, p: [f32; 3]) -> f32 {
    let corners = Corners::new(width, height, repeat_z, p);
    corners.blend(|i| f32::from(data[i])) * (1.0 / 255.0)
}

struct Corners {
    index: [usize; 8],
    share: [f32; 3],
}

impl Corners {
    #[inline]
    fn new(width: usize, height: usize, repeat_z: bool, p: [f32; 3]) -> Self {
        let mask = width as i32 - 1;
        let (x, fx) = split(p[0] * width as f32 - 0.5);
        let (y, fy) = split(p[1] * width as f32 - 0.5);
        let (z, fz) = split(p[2] * height as f32 - 0.5);
        let level = |z: i32| {
            if repeat_z { z.rem_euclid(height as i32) as usize } else { z.clamp(0, height as i32 - 1) as usize }
        };
        let (x0, x1) = ((x & mask) as usize, ((x + 1) & mask) as usize);
        let (y0, y1) = ((y & mask) as usize * width, ((y + 1) & mask) as usize * width);
        let (z0, z1) = (level(z) * width * width, level(z + 1) * width * width);
        let index = [
            x0 + y0 + z0,
            x1 + y0 + z0,
            x0 + y1 + z0,
            x1 + y1 + z0,
            x0 + y0 + z1,
            x1 + y0 + z1,
            x0 + y1 + z1,
            x1 + y1 + z1,
        ];
        Self { index, share: [fx, fy, fz] }
    }

    #[inline]
    fn blend(&self, value: impl Fn(usize) -> f32) -> f32 {
        self.weigh(|k| value(self.index[k]))
    }

    #[inline]
    fn weigh(&self, value: impl Fn(usize) -> f32) -> f32 {
        let [fx, fy, fz] = self.share;
        let edge = |k: usize| {
            let low = value(k);
            low + (value(k + 1) - low) * fx
        };
        let face = |k: usize| {
            let low = edge(k);
            low + (edge(k + 2) - low) * fy
        };
        let low = face(0);
        low + (face(4) - low) * fz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texel_centre_gives_the_texel_and_a_midpoint_the_mean() {
        let data: Vec<u8> = (0..64).map(|i| (i * 3) as u8).collect();
        let at = |x: f32, y: f32, z: f32| volume_byte(&data, 4, 4, false, [x, y, z]) * 255.0;
        let centre = |k: f32| (k + 0.5) / 4.0;
        assert!((at(centre(1.0), centre(2.0), centre(3.0)) - f32::from(data[1 + 8 + 48])).abs() < 1e-4);
        let between = 0.5 * (f32::from(data[1]) + f32::from(data[2]));
        assert!((at(centre(1.5), centre(0.0), centre(0.0)) - between).abs() < 1e-4);
        // Wraps in x, clamps in z.
        assert!((at(centre(5.0), centre(0.0), centre(0.0)) - f32::from(data[1])).abs() < 1e-4);
        assert!((at(centre(0.0), centre(0.0), 9.0) - f32::from(data[48])).abs() < 1e-4);
    }

    #[test]
    fn the_map_repeats() {
        let map: Vec<u8> = (0..16).map(|i| (i * 16) as u8).collect();
        assert!((map_repeat(&map, 4, 0.3, 0.7) - map_repeat(&map, 4, 5.3, -3.3)).abs() < 1e-5);
    }
}
