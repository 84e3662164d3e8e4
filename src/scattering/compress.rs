//! Basis intensities as few Haar coefficients: thresholds, three widths of a coefficient, sums of weighted fields.
//!
//! *What it is.* A field per component (direction, or spherical harmonic) on the grid. *How we compute it.* Orthonormal 3D
//! Haar (Dobashi et al. 2007, section 6), then every coefficient below a threshold is dropped. The paper's threshold is in units that it
//! does not give; here it is relative to a stated norm, the light of 1 W/sr at one cell's edge (times the root of the
//! number of cells, the length of a uniform field). *How we store it.* Place and value of what is left, values as f32,
//! f16 or one byte (sign and logarithm), places as bytes of how many cells lie between. *How we read it back.* [`Sum`] adds weighted coefficients (eq. 9) and transforms back once (eq. 8).

use crate::numeric::haar::Haar;
use half::f16;

/// Width of a stored coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Width {
    /// 4 bytes.
    F32,
    /// 2 bytes.
    F16,
    /// 1 byte: a sign and 127 steps of 8 % below the component's greatest coefficient, to 1/17,000 of it.
    Log8,
}

/// What is kept and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packing {
    /// Coefficients below this share of the norm are dropped; 0 keeps all.
    pub threshold: f64,
    /// Width of the rest.
    pub width: Width,
}

/// What is added for dropped coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ambient {
    /// Nothing.
    #[default]
    Off,
    /// Eq. 10 as printed: the root of the sum of squares of what was dropped, at every point. It makes pictures worse (it
    /// is a norm of the whole field, has no sign, and Haar keeps means anyway).
    Printed,
    /// The mean of what was dropped, with its sign.
    SignedMean,
}

/// Components of one light.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Coefficients kept of each component.
    pub counts: Vec<u32>,
    /// Root of the sum of squares of the dropped coefficients, per component (gamma of eq. 10).
    pub gammas: Vec<f32>,
    /// Mean of the dropped part, per component.
    pub means: Vec<f32>,
    /// Greatest coefficient of each component (the scale of [`Width::Log8`]).
    pub scales: Vec<f32>,
    /// Where the kept coefficients lie, component by component: for each a byte of how many cells are left out before it; a
    /// byte of 255 leaves out 255 cells and keeps none.
    pub gaps: Vec<u8>,
    /// Their values.
    pub values: Values,
    /// Sum of squares of all coefficients, and of the error of storing them.
    pub squares: [f64; 2],
}

/// Values of a block.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// As they are.
    F32(Vec<f32>),
    /// Rounded to 11 bits, in units of the component's scale.
    F16(Vec<f16>),
    /// Sign and logarithm.
    Log8(Vec<u8>),
}

/// Ratio of neighbouring steps of [`Width::Log8`].
const STEP: f32 = 1.08;

impl Block {
    /// Packs fields of one component after the other (`components * cells`), which are overwritten by coefficients.
    /// `norm` is the stated norm of the threshold.
    pub fn pack(haar: &Haar, fields: &mut [f32], packing: Packing, norm: f64) -> Self {
        let cells = haar.len();
        let limit = (packing.threshold * norm) as f32;
        let root = (cells as f32).sqrt();
        let mut scratch = Vec::new();
        let mut block = Self {
            counts: Vec::new(),
            gammas: Vec::new(),
            means: Vec::new(),
            scales: Vec::new(),
            gaps: Vec::new(),
            values: match packing.width {
                Width::F32 => Values::F32(Vec::new()),
                Width::F16 => Values::F16(Vec::new()),
                Width::Log8 => Values::Log8(Vec::new()),
            },
            squares: [0.0; 2],
        };
        for field in fields.chunks_mut(cells) {
            haar.forward(field, &mut scratch);
            let scale = field.iter().fold(0.0_f32, |m, c| m.max(c.abs()));
            // A byte reaches no further down.
            let limit = if packing.width == Width::Log8 { limit.max(scale * STEP.powi(-126)) } else { limit };
            let (mut count, mut dropped, mut mean, mut next) = (0, 0.0_f64, 0.0, 0);
            for (index, value) in field.iter().enumerate() {
                let square = f64::from(*value) * f64::from(*value);
                block.squares[0] += square;
                if *value == 0.0 || value.abs() < limit {
                    dropped += square;
                    if index == 0 {
                        mean = value / root;
                    }
                    continue;
                }
                count += 1;
                let mut gap = index - next;
                while gap >= usize::from(LONG) {
                    block.gaps.push(LONG);
                    gap -= usize::from(LONG);
                }
                block.gaps.push(gap as u8);
                next = index + 1;
                let stored = block.values.push(*value, scale);
                block.squares[1] += f64::from(value - stored).powi(2);
            }
            block.squares[1] += dropped;
            block.counts.push(count);
            block.gammas.push(dropped.sqrt() as f32);
            block.means.push(mean);
            block.scales.push(scale);
        }
        block
    }

    /// Where the coefficients lie, component after component.
    pub fn places(&self) -> Vec<u32> {
        let mut gaps = self.gaps.iter();
        let mut places = Vec::with_capacity(self.values.len());
        for count in &self.counts {
            let mut next = 0;
            places.extend((0..*count).filter_map(|_| place(&mut gaps, &mut next)).map(|place| place as u32));
        }
        places
    }

    /// The coefficients of all components in units of [`Block::unit_scales`], which only values of four bytes do without.
    pub fn unit_values(&self) -> Vec<f32> {
        match &self.values {
            Values::F32(v) => v.clone(),
            Values::F16(v) => v.iter().map(|v| v.to_f32()).collect(),
            Values::Log8(v) => v.iter().map(|v| log8(*v)).collect(),
        }
    }

    /// What [`Block::unit_values`] are to be multiplied by, component by component.
    pub fn unit_scales(&self) -> Vec<f32> {
        match &self.values {
            Values::F32(_) => vec![1.0; self.scales.len()],
            _ => self.scales.clone(),
        }
    }

    /// Bytes of the coefficients and their places, and 16 bytes a component.
    pub fn bytes(&self) -> usize {
        self.gaps.len() + self.values.len() * self.values.width() + self.counts.len() * 16
    }

    /// Bytes that it takes in memory.
    pub fn memory_bytes(&self) -> usize {
        self.bytes()
    }

    /// Whether every component's coefficients lie within so many cells and nothing is left over.
    pub fn fits(&self, cells: usize) -> bool {
        let mut gaps = self.gaps.iter();
        let each = self.counts.iter().all(|count| {
            let mut next = 0;
            (0..*count).all(|_| place(&mut gaps, &mut next).is_some_and(|place| place < cells))
        });
        each && gaps.next().is_none() && self.counts.iter().map(|c| *c as usize).sum::<usize>() == self.values.len()
    }
}

/// A gap as long as this keeps no coefficient.
const LONG: u8 = 255;

/// The next place of a component, and where the one after it may lie; none where there are no more gaps.
#[inline(always)]
fn place<'a>(gaps: &mut impl Iterator<Item = &'a u8>, next: &mut usize) -> Option<usize> {
    loop {
        let gap = *gaps.next()?;
        *next += usize::from(gap);
        if gap < LONG {
            *next += 1;
            return Some(*next - 1);
        }
    }
}

impl Values {
    /// Appends a value and gives what will be read back.
    fn push(&mut self, value: f32, scale: f32) -> f32 {
        match self {
            Self::F32(list) => {
                list.push(value);
                value
            }
            Self::F16(list) => {
                let short = f16::from_f32(value / scale);
                list.push(short);
                short.to_f32() * scale
            }
            Self::Log8(list) => {
                let steps = ((scale / value.abs()).ln() / STEP.ln()).round().clamp(0.0, 127.0) as u8;
                let byte = steps | if value < 0.0 { 128 } else { 0 };
                list.push(byte);
                log8(byte) * scale
            }
        }
    }

    /// Bytes of one value.
    pub fn width(&self) -> usize {
        match self {
            Self::F32(_) => 4,
            Self::F16(_) => 2,
            Self::Log8(_) => 1,
        }
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(list) => list.len(),
            Self::F16(list) => list.len(),
            Self::Log8(list) => list.len(),
        }
    }

    /// Whether nothing was kept.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What a byte stands for, as a share of the scale.
fn log8(byte: u8) -> f32 {
    let size = STEP.powi(-i32::from(byte & 127));
    if byte & 128 == 0 { size } else { -size }
}

/// A weighted sum of blocks, in coefficients.
pub struct Sum<'a> {
    haar: &'a Haar,
    coefficients: Vec<f32>,
    ambient: Vec<f32>,
    kind: Ambient,
    log: [f32; 256],
}

impl<'a> Sum<'a> {
    /// Nothing yet.
    pub fn new(haar: &'a Haar, components: usize, kind: Ambient) -> Self {
        Self {
            coefficients: vec![0.0; haar.len() * components],
            ambient: vec![0.0; components],
            kind,
            log: std::array::from_fn(|byte| log8(byte as u8)),
            haar,
        }
    }

    /// Adds `weight` times a light's components (eq. 9).
    pub fn add(&mut self, block: &Block, weight: f32) {
        let cells = self.haar.len();
        let mut start = 0;
        let mut gaps = block.gaps.iter();
        let components = self.coefficients.chunks_mut(cells).zip(&block.counts).enumerate();
        for (m, (out, count)) in components {
            let range = start..start + *count as usize;
            start = range.end;
            let scaled = weight * block.scales[m];
            match &block.values {
                Values::F32(v) => add_at(out, &mut gaps, v[range].iter().map(|v| weight * v)),
                Values::F16(v) => add_at(out, &mut gaps, v[range].iter().map(|v| scaled * v.to_f32())),
                Values::Log8(v) => add_at(out, &mut gaps, v[range].iter().map(|v| scaled * self.log[usize::from(*v)])),
            }
            self.ambient[m] += weight
                * match self.kind {
                    Ambient::Off => 0.0,
                    Ambient::Printed => block.gammas[m],
                    Ambient::SignedMean => block.means[m],
                };
        }
    }

    /// The fields (eq. 8), `components * cells`.
    pub fn fields(mut self) -> Vec<f32> {
        let mut scratch = Vec::new();
        for (field, ambient) in self.coefficients.chunks_mut(self.haar.len()).zip(&self.ambient) {
            self.haar.inverse(field, &mut scratch);
            if *ambient != 0.0 {
                field.iter_mut().for_each(|v| *v += ambient);
            }
        }
        self.coefficients
    }
}

/// Adds values at the places that the gaps tell.
#[inline(always)]
fn add_at<'a>(out: &mut [f32], gaps: &mut impl Iterator<Item = &'a u8>, values: impl Iterator<Item = f32>) {
    let mut next = 0;
    for value in values {
        // A block that fits its cells has a place for every value.
        if let Some(to) = place(gaps, &mut next).and_then(|place| out.get_mut(place)) {
            *to += value;
        }
    }
}

/// The threshold at which the stored fields of a sample of lights have the asked relative error (root of summed squares), by
/// bisection; within a tenth of the error, and never above it. `None`: the width itself costs more.
pub fn threshold_for(haar: &Haar, sample: &[Vec<f32>], width: Width, norm: f64, error: f64) -> Option<f64> {
    let found = |threshold: f64| {
        let mut squares = [0.0; 2];
        for fields in sample {
            let block = Block::pack(haar, &mut fields.clone(), Packing { threshold, width }, norm);
            squares[0] += block.squares[0];
            squares[1] += block.squares[1];
        }
        if squares[0] > 0.0 { (squares[1] / squares[0]).sqrt() } else { 0.0 }
    };
    let (mut low, mut high) = (1e-12, 1.0);
    if found(low) > error {
        return None;
    }
    for _ in 0..40 {
        let middle = f64::sqrt(low * high);
        let here = found(middle);
        if here <= error {
            low = middle;
            if here > 0.9 * error {
                break;
            }
        } else {
            high = middle;
        }
    }
    Some(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELLS: [usize; 3] = [16, 16, 4];

    /// Smooth fields with a peak, as light has.
    fn fields(components: usize, at: f32) -> Vec<f32> {
        (0..components * 1024)
            .map(|i| {
                let (m, c) = (i / 1024, i % 1024);
                let d = [c % 16, c / 16 % 16, c / 256].map(|x| x as f32 - at);
                (1.0 + m as f32) / (1.0 + d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
            })
            .collect()
    }

    fn relative(a: &[f32], b: &[f32]) -> f64 {
        let sum = |f: &dyn Fn(usize) -> f64| (0..a.len()).map(f).sum::<f64>();
        (sum(&|i| f64::from(a[i] - b[i]).powi(2)) / sum(&|i| f64::from(b[i]).powi(2))).sqrt()
    }

    fn restored(packing: Packing, ambient: Ambient) -> (Vec<f32>, Block) {
        let haar = Haar::new(CELLS);
        let block = Block::pack(&haar, &mut fields(3, 5.0), packing, 32.0);
        let mut sum = Sum::new(&haar, 3, ambient);
        sum.add(&block, 1.0);
        (sum.fields(), block)
    }

    #[test]
    fn nothing_dropped_is_nothing_lost_but_the_width() {
        // f32: rounding; f16: half a part in 2,048, and less for the root of squares; a byte: steps of 8 %, so 4 % at most.
        for (width, bound) in [(Width::F32, 1e-6), (Width::F16, 3e-4), (Width::Log8, 0.04)] {
            let (fields_back, block) = restored(Packing { threshold: 0.0, width }, Ambient::Off);
            let error = relative(&fields_back, &fields(3, 5.0));
            assert!(error < bound, "{width:?}: {error}");
            // The error that the block tells is the error there is.
            let told = (block.squares[1] / block.squares[0]).sqrt();
            assert!((told - error).abs() < 2e-6 + 0.01 * error, "{width:?}: {told} {error}");
        }
    }

    #[test]
    fn a_higher_threshold_keeps_less_and_errs_more() {
        let mut last = (usize::MAX, 0.0);
        for threshold in [1e-6, 1e-4, 1e-3, 1e-2, 1e-1] {
            let (back, block) = restored(Packing { threshold, width: Width::F16 }, Ambient::Off);
            let error = relative(&back, &fields(3, 5.0));
            let kept = block.values.len();
            assert!(kept < last.0 && error > last.1, "{threshold}");
            // Two bytes a value, one a place, and one for each 255 cells left out.
            assert!((3 * kept + 48..=3 * kept + 48 + 3 * 4).contains(&block.bytes()) && block.fits(1024));
            assert!(!block.fits(100) || kept < 10);
            last = (kept, error);
        }
    }

    #[test]
    fn coefficients_far_apart_come_back_where_they_were() {
        let haar = Haar::new([2048, 1, 1]);
        let mut there = vec![0.0_f32; 4096];
        let places = [0, 255, 256, 511, 767, 2047, 2048 + 1023, 4095];
        places.iter().enumerate().for_each(|(i, at)| there[*at] = (i + 1) as f32);
        let mut fields = there.clone();
        fields.chunks_mut(2048).for_each(|field| haar.inverse(field, &mut Vec::new()));
        let block = Block::pack(&haar, &mut fields, Packing { threshold: 0.5, width: Width::F32 }, 1.0);
        assert!(block.counts == [6, 2] && block.fits(2048) && !block.fits(2047));
        let mut sum = Sum::new(&haar, 2, Ambient::Off);
        sum.add(&block, 1.0);
        assert!(sum.coefficients.iter().zip(&there).all(|(a, b)| (a - b).abs() < 1e-4));
        let torn = Block { gaps: block.gaps[1..].to_vec(), ..block.clone() };
        let long = Block { gaps: [&block.gaps[..], &[0]].concat(), ..block };
        assert!(!torn.fits(2048) && !long.fits(2048));
    }

    #[test]
    fn a_target_error_is_met_on_its_sample() {
        let haar = Haar::new(CELLS);
        let sample: Vec<Vec<f32>> = (0..4).map(|i| fields(3, 3.0 * i as f32)).collect();
        for error in [0.003, 0.03] {
            let threshold = threshold_for(&haar, &sample, Width::F32, 32.0, error).expect("f32 holds it");
            let mut squares = [0.0; 2];
            for fields in &sample {
                let packing = Packing { threshold, width: Width::F32 };
                let block = Block::pack(&haar, &mut fields.clone(), packing, 32.0);
                (0..2).for_each(|k| squares[k] += block.squares[k]);
            }
            let found = (squares[1] / squares[0]).sqrt();
            assert!(found <= error && found > 0.5 * error, "{error}: {found}");
        }
        // Steps of 8 % are 2 % off on average, whatever is dropped.
        assert_eq!(threshold_for(&haar, &sample, Width::Log8, 32.0, 0.003), None);
    }

    #[test]
    fn sums_of_fields_are_fields_of_sums() {
        let haar = Haar::new(CELLS);
        let packing = Packing { threshold: 0.0, width: Width::F32 };
        let mut sum = Sum::new(&haar, 2, Ambient::Off);
        let (a, b) = (fields(2, 2.0), fields(2, 9.0));
        sum.add(&Block::pack(&haar, &mut a.clone(), packing, 1.0), 0.25);
        sum.add(&Block::pack(&haar, &mut b.clone(), packing, 1.0), 3.0);
        let expected: Vec<f32> = a.iter().zip(&b).map(|(a, b)| 0.25 * a + 3.0 * b).collect();
        assert!(relative(&sum.fields(), &expected) < 1e-6);
    }

    #[test]
    fn the_printed_ambient_term_does_harm_and_the_signed_mean_does_none() {
        let packing = Packing { threshold: 0.02, width: Width::F32 };
        let truth = fields(3, 5.0);
        let error = |ambient| relative(&restored(packing, ambient).0, &truth);
        let off = error(Ambient::Off);
        assert!(error(Ambient::Printed) > 3.0 * off, "{} {off}", error(Ambient::Printed));
        assert!(error(Ambient::SignedMean) <= off * 1.000_01);
    }
}
