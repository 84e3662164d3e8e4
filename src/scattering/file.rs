//! The basis file: a recipe and its blocks as bytes, with checksums; shares, merging, resuming (`protocol/basis-file.md`).

mod join;
mod read;

pub use join::{JoinError, join};
pub use read::{Blocks, Contents, read, scan};

use super::basis::{Basis, Content, Recipe};
use super::compress::{Block, Values, Width};
use super::krylov::Method;
use super::medium::MediumError;
use super::ordinates::{Ground, Treatment};
use super::phase::Phase;
use crate::bytes::{TooShort, Writer};
use crate::numeric::sphere::Rule;

/// First bytes of every basis file.
pub const MAGIC: &[u8; 8] = b"SDBASIS\0";
/// Version of the format.
pub const VERSION: u32 = 3;
/// Light number of the trailer.
const TRAILER: u32 = u32::MAX;
/// Most levels of lights and most lights a level; their product has its own limit.
const MOST_LEVELS: usize = 1 << 16;
/// Name of what stands behind a trailer, in [`FileError::Value`].
pub const AFTER_THE_END: &str = "bytes after the end";
/// Bytes of the trailer's content.
const TRAILER_BYTES: usize = 32;

/// Why bytes are no basis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// Other bytes than ours.
    #[error("this is no basis file: it does not begin with SDBASIS")]
    Foreign,
    /// A version that this program does not know.
    #[error("format version {0}; this program reads version {VERSION}")]
    Version(u32),
    /// It ends too early.
    #[error("cut off: {0}")]
    TooShort(#[from] TooShort),
    /// A checksum does not fit.
    #[error("{0} is damaged: its checksum does not fit")]
    Damaged(String),
    /// A number that cannot be.
    #[error("{field} is {value}: {limit}")]
    Value {
        /// Which one.
        field: &'static str,
        /// What it is.
        value: f64,
        /// What it must be.
        limit: &'static str,
    },
    /// The medium in it is none.
    #[error("medium: {0}")]
    Medium(#[from] MediumError),
    /// Lights are missing, doubled or out of order.
    #[error("light {found} where {expected} was due")]
    Order {
        /// Light found.
        found: u32,
        /// Light due.
        expected: u32,
    },
    /// Shares of different recipes.
    #[error("share {0} is of another recipe")]
    Mixed(usize),
    /// The system did not hand the bytes over.
    #[error("cannot be read: {0}")]
    Unreadable(String),
}

/// FNV-1a, 64 bits, with a salt.
pub fn hash(bytes: &[u8], salt: u64) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325 ^ salt, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

/// Everything before the blocks.
pub fn header(recipe: &Recipe) -> Vec<u8> {
    let mut body = Writer::default();
    let p = &recipe.params;
    body.put_u8(match recipe.content {
        Content::Total => 0,
        Content::Diffuse => 1,
    });
    body.put_u8(match recipe.packing.width {
        Width::F32 => 0,
        Width::F16 => 1,
        Width::Log8 => 2,
    });
    body.put_f64_le(recipe.packing.threshold);
    body.put_u8(Rule::ALL.iter().position(|r| *r == p.rule).unwrap_or(0) as u8);
    body.put_u8(u8::from(p.treatment == Treatment::Truncated));
    body.put_u8(match p.method {
        None => 0,
        Some(Method::SourceIteration) => 1,
        Some(Method::BiCgStab) => 2,
    });
    let lobes = match p.phase {
        Phase::HenyeyGreenstein(g) => (0, [(g, 0.0), (0.0, 0.0)]),
        Phase::CornetteShanks(lobes) => (1, lobes),
    };
    body.put_u8(lobes.0);
    lobes.1.iter().for_each(|(a, b)| {
        body.put_f64_le(*a);
        body.put_f64_le(*b);
    });
    body.put_f64_le(p.albedo);
    body.put_f64_le(p.tolerance);
    body.put_u64_le(p.most_sweeps as u64);
    body.put_u64_le(p.rays as u64);
    // No ground is a ground of a depth below 0.
    let ground = p.ground.unwrap_or(Ground { albedo: 0.0, depth_m: -1.0 });
    body.put_f64_le(ground.albedo);
    body.put_f64_le(ground.depth_m);
    let period = recipe.lights.period_m.unwrap_or([0.0; 2]);
    period.iter().for_each(|v| body.put_f64_le(*v));
    for list in [&recipe.lights.x_m, &recipe.lights.y_m, &recipe.lights.z_m] {
        body.put_u32_le(list.len() as u32);
        list.iter().for_each(|v| body.put_f64_le(*v));
    }
    let m = &recipe.medium;
    body.put_u8(u8::from(m.periodic));
    m.cells.iter().for_each(|n| body.put_u32_le(*n as u32));
    m.spacing_m.iter().for_each(|h| body.put_f64_le(*h));
    m.extinction_per_m.iter().for_each(|s| body.put_f32_le(*s));
    let body = body.into_bytes();
    let mut out = Writer::with_capacity(body.len() + 24);
    out.put(MAGIC);
    out.put_u32_le(VERSION);
    out.put_u32_le(body.len() as u32);
    out.put(&body);
    out.put_u64_le(hash(&body, 0));
    out.into_bytes()
}

/// One light's block.
pub fn block(recipe: &Recipe, light: usize, block: &Block) -> Vec<u8> {
    debug_assert!(block.fits(recipe.medium.len()), "light {light} has places outside its cells");
    let mut body = Writer::default();
    block.squares.iter().for_each(|s| body.put_f64_le(*s));
    for m in 0..block.counts.len() {
        body.put_u32_le(block.counts[m]);
        [block.gammas[m], block.means[m], block.scales[m]].iter().for_each(|v| body.put_f32_le(*v));
    }
    body.put_u32_le(block.gaps.len() as u32);
    body.put(&block.gaps);
    match &block.values {
        Values::F32(v) => v.iter().for_each(|v| body.put_f32_le(*v)),
        Values::F16(v) => v.iter().for_each(|v| body.put_u16_le(v.to_bits())),
        Values::Log8(v) => body.put(v),
    }
    framed(light as u32, &body.into_bytes())
}

/// The end of a complete file, gathered light by light: their number, sums of squares of coefficients and of their error (the
/// measured error of storing is the root of their ratio), and a checksum of the header and that number.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trailer {
    lights: usize,
    squares: [f64; 2],
}

impl Trailer {
    /// The next light, by its block's sums of squares.
    pub fn add(&mut self, squares: [f64; 2]) {
        self.lights += 1;
        (0..2).for_each(|k| self.squares[k] += squares[k]);
    }

    /// Lights so far.
    pub fn lights(&self) -> usize {
        self.lights
    }

    /// The trailer's bytes.
    pub fn bytes(&self, recipe: &Recipe) -> Vec<u8> {
        let mut body = Writer::default();
        body.put_u64_le(self.lights as u64);
        self.squares.iter().for_each(|sum| body.put_f64_le(*sum));
        body.put_u64_le(hash(&header(recipe), self.lights as u64));
        framed(TRAILER, &body.into_bytes())
    }
}

fn framed(light: u32, body: &[u8]) -> Vec<u8> {
    let mut out = Writer::with_capacity(body.len() + 16);
    out.put_u32_le(light);
    out.put_u32_le(body.len() as u32);
    out.put_u64_le(hash(body, u64::from(light)));
    out.put(body);
    out.into_bytes()
}

/// A whole basis as bytes.
pub fn write(basis: &Basis) -> Vec<u8> {
    let mut out = header(&basis.recipe);
    let mut trailer = Trailer::default();
    for (light, b) in basis.blocks.iter().enumerate() {
        out.extend(block(&basis.recipe, light, b));
        trailer.add(b.squares);
    }
    out.extend(trailer.bytes(&basis.recipe));
    out
}

#[cfg(test)]
mod tests;
