//! The basis file: a recipe and its blocks as bytes, with checksums; shares, merging, resuming (`protocol/basis-file.md`).

use super::basis::{Basis, Content, Recipe};
use super::compress::{Block, Packing, Values, Width};
use super::krylov::Method;
use super::lights::{Lights, MOST_LIGHTS};
use super::medium::{MOST_CELLS, Medium, MediumError};
use super::ordinates::{Ground, Params, Treatment};
use super::phase::Phase;
use crate::bytes::{Reader, TooShort, Writer};
use crate::numeric::sphere::Rule;
use half::f16;

/// First bytes of every basis file.
pub const MAGIC: &[u8; 8] = b"SDBASIS\0";
/// Version of the format.
pub const VERSION: u32 = 3;
/// Light number of the trailer.
const TRAILER: u32 = u32::MAX;
/// Most levels of lights and most lights a level; their product has its own limit.
const MOST_LEVELS: usize = 1 << 16;
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
        field: String,
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
}

/// What a file holds so far, for resuming and merging.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// What it was made by.
    pub recipe: Recipe,
    /// Lights and their blocks, in the order of the file.
    pub blocks: Vec<(usize, Block)>,
    /// Bytes up to the end of the last whole block: where writing may go on.
    pub sound_bytes: usize,
    /// Whether the trailer is there: the basis is complete.
    pub complete: bool,
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

/// The end of a complete file: number of lights, sums of squares of coefficients and of their error (the measured error
/// of storing is the root of their ratio), and a checksum of the header and that number.
pub fn trailer(blocks: &[Block], recipe: &Recipe) -> Vec<u8> {
    let mut body = Writer::default();
    body.put_u64_le(blocks.len() as u64);
    for k in 0..2 {
        body.put_f64_le(blocks.iter().map(|b| b.squares[k]).sum());
    }
    body.put_u64_le(hash(&header(recipe), blocks.len() as u64));
    framed(TRAILER, &body.into_bytes())
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
    for (light, b) in basis.blocks.iter().enumerate() {
        out.extend(block(&basis.recipe, light, b));
    }
    out.extend(trailer(&basis.blocks, &basis.recipe));
    out
}

/// A whole basis from bytes.
///
/// # Errors
/// [`FileError`] says what is wrong first.
pub fn read(bytes: &[u8]) -> Result<Basis, FileError> {
    let contents = scan(bytes, false)?;
    if !contents.complete {
        return Err(FileError::Order { found: contents.blocks.len() as u32, expected: TRAILER });
    }
    let blocks: Vec<Block> = contents.blocks.into_iter().map(|(_, b)| b).collect();
    if blocks.len() != contents.recipe.lights.len() {
        return Err(FileError::Order { found: TRAILER, expected: blocks.len() as u32 });
    }
    Ok(Basis { recipe: contents.recipe, blocks })
}

/// What bytes hold. With `torn`, a last block that is cut off or damaged ends the reading and is no error: what a killed
/// bake leaves.
///
/// # Errors
/// [`FileError`].
pub fn scan(bytes: &[u8], torn: bool) -> Result<Contents, FileError> {
    let mut reader = Reader::new(bytes);
    if reader.take(MAGIC.len()).ok() != Some(&MAGIC[..]) {
        return Err(FileError::Foreign);
    }
    let version = reader.u32_le()?;
    if version != VERSION {
        return Err(FileError::Version(version));
    }
    let length = reader.u32_le()? as usize;
    let body = reader.take(length)?;
    if hash(body, 0) != reader.u64_le()? {
        return Err(FileError::Damaged("the header".into()));
    }
    let recipe = recipe(body)?;
    let mut contents = Contents { recipe, blocks: Vec::new(), sound_bytes: reader.offset(), complete: false };
    while !reader.rest().is_empty() && !contents.complete {
        match next(&mut reader, &contents) {
            Ok(Some(found)) => contents.blocks.push(found),
            Ok(None) => contents.complete = true,
            Err(_) if torn => break,
            Err(error) => return Err(error),
        }
        contents.sound_bytes = reader.offset();
    }
    if contents.complete && !reader.rest().is_empty() {
        let value = reader.rest().len() as f64;
        return Err(FileError::Value { field: "bytes after the end".into(), value, limit: "0" });
    }
    Ok(contents)
}

/// Joins the shares of one recipe, in any order; gives the bytes of the whole.
///
/// # Errors
/// [`FileError`]: a damaged share, another recipe, missing or doubled lights.
pub fn merge(shares: &[&[u8]]) -> Result<Vec<u8>, FileError> {
    let mut all: Option<(Recipe, Vec<(usize, Block)>)> = None;
    for (i, bytes) in shares.iter().enumerate() {
        let contents = scan(bytes, false)?;
        match &mut all {
            None => all = Some((contents.recipe, contents.blocks)),
            Some((recipe, blocks)) => {
                if *recipe != contents.recipe {
                    return Err(FileError::Mixed(i));
                }
                blocks.extend(contents.blocks);
            }
        }
    }
    let (recipe, mut blocks) = all.ok_or(FileError::Foreign)?;
    blocks.sort_by_key(|(light, _)| *light);
    for (i, (light, _)) in blocks.iter().enumerate() {
        if *light != i {
            return Err(FileError::Order { found: *light as u32, expected: i as u32 });
        }
    }
    if blocks.len() != recipe.lights.len() {
        return Err(FileError::Order { found: TRAILER, expected: blocks.len() as u32 });
    }
    Ok(write(&Basis { recipe, blocks: blocks.into_iter().map(|(_, b)| b).collect() }))
}

/// The next block, or none for the trailer.
fn next(reader: &mut Reader, so_far: &Contents) -> Result<Option<(usize, Block)>, FileError> {
    let light = reader.u32_le()?;
    let length = reader.u32_le()? as usize;
    let sum = reader.u64_le()?;
    let body = reader.take(length)?;
    if hash(body, u64::from(light)) != sum {
        let what = if light == TRAILER { "the trailer".into() } else { format!("the block of light {light}") };
        return Err(FileError::Damaged(what));
    }
    if light == TRAILER {
        if length != TRAILER_BYTES {
            return Err(FileError::Value { field: "trailer".into(), value: length as f64, limit: "32 bytes" });
        }
        return Ok(None);
    }
    // Shares begin anywhere, but go on one by one.
    let expected = so_far.blocks.last().map_or(light as usize, |(l, _)| l + 1);
    if light as usize != expected || expected >= so_far.recipe.lights.len() {
        return Err(FileError::Order { found: light, expected: expected as u32 });
    }
    Ok(Some((light as usize, decode(body, &so_far.recipe)?)))
}

fn decode(body: &[u8], recipe: &Recipe) -> Result<Block, FileError> {
    let refuse = |field: &str, value: f64, limit| Err(FileError::Value { field: field.into(), value, limit });
    let mut r = Reader::new(body);
    let cells = recipe.medium.len();
    let squares = [r.f64_le()?, r.f64_le()?];
    let (mut counts, mut gammas, mut means, mut scales) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut total = 0_usize;
    for _ in 0..recipe.components() {
        let count = r.u32_le()?;
        if count as usize > cells {
            return refuse("count", f64::from(count), "at most the number of cells");
        }
        total += count as usize;
        counts.push(count);
        for list in [&mut gammas, &mut means, &mut scales] {
            let value = r.f32_le()?;
            if !value.is_finite() {
                return refuse("scale", f64::from(value), "finite");
            }
            list.push(value);
        }
    }
    // Checked against what is there before room is made for it.
    let each = match recipe.packing.width {
        Width::F32 => 4,
        Width::F16 => 2,
        Width::Log8 => 1,
    };
    let gaps = r.u32_le()? as usize;
    if total.checked_mul(each).and_then(|n| n.checked_add(gaps)) != Some(r.rest().len()) {
        return refuse("bytes of coefficients", r.rest().len() as f64, "as the counts say");
    }
    let gaps = r.take(gaps)?.to_vec();
    let values = match recipe.packing.width {
        Width::F32 => Values::F32((0..total).map(|_| r.f32_le()).collect::<Result<_, _>>()?),
        Width::F16 => Values::F16((0..total).map(|_| r.u16_le().map(f16::from_bits)).collect::<Result<_, _>>()?),
        Width::Log8 => Values::Log8(r.take(total)?.to_vec()),
    };
    let finite = match &values {
        Values::F32(v) => v.iter().all(|v| v.is_finite()),
        Values::F16(v) => v.iter().all(|v| v.is_finite()),
        Values::Log8(_) => true,
    };
    if !finite || !squares.iter().all(|s| s.is_finite()) {
        return refuse("coefficient", f64::NAN, "finite");
    }
    let block = Block { counts, gammas, means, scales, gaps, values, squares };
    if !block.fits(cells) {
        return refuse("places of coefficients", block.gaps.len() as f64, "one for each, below the number of cells");
    }
    Ok(block)
}

fn recipe(body: &[u8]) -> Result<Recipe, FileError> {
    let mut r = Reader::new(body);
    let refuse = |field: &str, value: f64, limit| FileError::Value { field: field.into(), value, limit };
    let pick = |field: &str, value: u8, most: u8| {
        if value <= most { Ok(value) } else { Err(refuse(field, f64::from(value), "a known choice")) }
    };
    let content = if pick("content", r.u8()?, 1)? == 0 { Content::Total } else { Content::Diffuse };
    let width = [Width::F32, Width::F16, Width::Log8][usize::from(pick("width", r.u8()?, 2)?)];
    let threshold = r.f64_le()?;
    let rule = Rule::ALL[usize::from(pick("rule", r.u8()?, 2)?)];
    let treatment = if pick("treatment", r.u8()?, 1)? == 0 { Treatment::DeltaM } else { Treatment::Truncated };
    let method =
        [None, Some(Method::SourceIteration), Some(Method::BiCgStab)][usize::from(pick("method", r.u8()?, 2)?)];
    let kind = pick("phase", r.u8()?, 1)?;
    let lobes = [(r.f64_le()?, r.f64_le()?), (r.f64_le()?, r.f64_le()?)];
    let phase = if kind == 0 { Phase::HenyeyGreenstein(lobes[0].0) } else { Phase::CornetteShanks(lobes) };
    let (albedo, tolerance) = (r.f64_le()?, r.f64_le()?);
    let (most_sweeps, rays) = (r.u64_le()? as usize, r.u64_le()? as usize);
    let (ground_albedo, depth_m) = (r.f64_le()?, r.f64_le()?);
    let ground = (depth_m >= 0.0).then_some(Ground { albedo: ground_albedo, depth_m });
    let params = Params { rule, phase, treatment, albedo, ground, tolerance, most_sweeps, method, rays };
    super::ordinates::check(&params).map_err(|e| match e {
        super::ordinates::SolveError::Parameter { field, value, limit } => refuse(field, value, limit),
        _ => refuse("parameters", f64::NAN, "legal"),
    })?;
    if !(0.0..=1.0).contains(&threshold) {
        return Err(refuse("threshold", threshold, "0 to 1"));
    }
    let period = [r.f64_le()?, r.f64_le()?];
    let mut lists: [Vec<f64>; 3] = Default::default();
    for list in &mut lists {
        let count = r.u32_le()? as usize;
        if count == 0 || count > MOST_LEVELS || r.rest().len() < 8 * count {
            return Err(refuse("lights along an axis", count as f64, "1 to 65,536, and all there"));
        }
        *list = (0..count).map(|_| r.f64_le()).collect::<Result<_, _>>()?;
        if !list.iter().all(|v| v.is_finite()) || list.windows(2).any(|w| w[1] <= w[0]) {
            return Err(refuse("positions of lights", f64::NAN, "finite and ascending"));
        }
    }
    let [x_m, y_m, z_m] = lists;
    let count = x_m.len().saturating_mul(y_m.len()).saturating_mul(z_m.len());
    if count > MOST_LIGHTS {
        return Err(refuse("lights", count as f64, "at most 1,048,576"));
    }
    let periodic = pick("periodic", r.u8()?, 1)? == 1;
    if periodic && !period.iter().all(|p| p.is_finite() && *p > 0.0) {
        return Err(refuse("period_m", period[0], "finite and positive"));
    }
    let mut cells = [0; 3];
    for n in &mut cells {
        *n = r.u32_le()? as usize;
    }
    let spacing_m = [r.f64_le()?, r.f64_le()?, r.f64_le()?];
    let needed = cells.iter().try_fold(1_usize, |n, c| n.checked_mul(*c)).filter(|n| *n <= MOST_CELLS);
    if needed.and_then(|n| n.checked_mul(4)) != Some(r.rest().len()) {
        return Err(refuse("bytes of the medium", r.rest().len() as f64, "four a cell"));
    }
    let values = (0..needed.unwrap_or(0)).map(|_| r.f32_le()).collect::<Result<_, _>>()?;
    let medium = Medium::new(cells, spacing_m, values, periodic)?;
    let lights = Lights { x_m, y_m, z_m, period_m: periodic.then_some(period) };
    Ok(Recipe { medium, params, lights, content, packing: Packing { threshold, width } })
}

#[cfg(test)]
mod tests;
