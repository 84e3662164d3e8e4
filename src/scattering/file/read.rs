//! Reading of basis files: block by block from any source of bytes, so that a file of any size takes the memory of one block;
//! whole, and torn.
//!
//! Files are read as a stream and not mapped into memory. Checksums mean that every byte is read before it is believed, so a map saves
//! no reading; a table is used in another layout than the file's; and a file that another process cuts short while it is
//! mapped kills the reader, where a stream ends with an error.

use super::{AFTER_THE_END, FileError, MAGIC, MOST_LEVELS, TRAILER, TRAILER_BYTES, VERSION, hash, header};
use crate::bytes::{Reader, TooShort};
use crate::numeric::sphere::Rule;
use crate::scattering::basis::{Basis, Content, Recipe};
use crate::scattering::compress::{Block, Packing, Values, Width};
use crate::scattering::krylov::Method;
use crate::scattering::lights::{Lights, MOST_LIGHTS};
use crate::scattering::medium::{MOST_CELLS, Medium};
use crate::scattering::ordinates::{self, Ground, Params, SolveError, Treatment};
use crate::scattering::phase::Phase;
use half::f16;
use std::io::Read;

/// Longest body of a header, bytes: the medium, three lists of lights, and what stands before them.
const LONGEST_HEADER: usize = 4 * MOST_CELLS + 3 * (8 * MOST_LEVELS + 4) + 1024;

/// What a file holds so far, for resuming.
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

/// A file that is read block by block.
pub struct Blocks<R> {
    from: R,
    recipe: Recipe,
    offset: u64,
    last: Option<usize>,
    count: usize,
    complete: bool,
    body: Vec<u8>,
}

impl<R: Read> Blocks<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn open(mut from: R) -> Result<Self, FileError> {
        let (mut body, mut offset) = (Vec::new(), 0);
        let mut take = |length: usize, body: &mut Vec<u8>| filled(&mut from, length, body, &mut offset);
        match take(MAGIC.len(), &mut body) {
            Ok(()) if body == MAGIC => {}
            Err(other @ FileError::Unreadable(_)) => return Err(other),
            _ => return Err(FileError::Foreign),
        }
        take(4, &mut body)?;
        let version = Reader::new(&body).u32_le()?;
        if version != VERSION {
            return Err(FileError::Version(version));
        }
        take(4, &mut body)?;
        let length = Reader::new(&body).u32_le()? as usize;
        if length > LONGEST_HEADER {
            let limit = "that of the most cells and lights at most";
            return Err(FileError::Value { field: "length of the header", value: length as f64, limit });
        }
        take(length, &mut body)?;
        let found = hash(&body, 0);
        let mut sum = Vec::new();
        take(8, &mut sum)?;
        if found != Reader::new(&sum).u64_le()? {
            return Err(FileError::Damaged("the header".into()));
        }
        let recipe = recipe(&body)?;
        Ok(Self { from, recipe, offset, last: None, count: 0, complete: false, body })
    }

    /// What it was made by.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// Bytes up to the end of the last whole block.
    pub fn sound_bytes(&self) -> u64 {
        self.offset
    }

    /// Whether the trailer has been read: the basis is complete.
    pub fn complete(&self) -> bool {
        self.complete
    }

    /// The next light and its block; `None` at the end of the file.
    ///
    /// # Errors
    /// [`FileError`]; what was read before is sound.
    pub fn next_block(&mut self) -> Result<Option<(usize, Block)>, FileError> {
        let mut offset = self.offset;
        let mut first = [0; 1];
        if self.complete || read_some(&mut self.from, &mut first)? == 0 {
            return Ok(None);
        }
        offset += 1;
        let mut frame = Vec::new();
        filled(&mut self.from, 15, &mut frame, &mut offset)?;
        frame.insert(0, first[0]);
        let mut frame = Reader::new(&frame);
        let (light, length, sum) = (frame.u32_le()?, frame.u32_le()? as usize, frame.u64_le()?);
        let longest = if light == TRAILER { TRAILER_BYTES } else { longest_block(&self.recipe) };
        if length > longest {
            let (value, limit) = (length as f64, "that of a field without a loss at most; 32 for the trailer");
            return Err(FileError::Value { field: "length of a block", value, limit });
        }
        filled(&mut self.from, length, &mut self.body, &mut offset)?;
        if hash(&self.body, u64::from(light)) != sum {
            let what = if light == TRAILER { "the trailer".into() } else { format!("the block of light {light}") };
            return Err(FileError::Damaged(what));
        }
        if light == TRAILER {
            self.end()?;
            self.offset = offset;
            return Ok(None);
        }
        // Shares begin anywhere, but go on one by one.
        let expected = self.last.map_or(light as usize, |last| last + 1);
        if light as usize != expected || expected >= self.recipe.lights.len() {
            return Err(FileError::Order { found: light, expected: expected as u32 });
        }
        let block = decode(&self.body, &self.recipe)?;
        self.offset = offset;
        self.last = Some(expected);
        self.count += 1;
        Ok(Some((expected, block)))
    }

    /// The trailer has been read: it must be that of what came before, and nothing may come after.
    fn end(&mut self) -> Result<(), FileError> {
        if self.body.len() != TRAILER_BYTES {
            let (value, limit) = (self.body.len() as f64, "32 bytes");
            return Err(FileError::Value { field: "trailer", value, limit });
        }
        let mut trailer = Reader::new(&self.body);
        let count = trailer.u64_le()?;
        let _squares = (trailer.f64_le()?, trailer.f64_le()?);
        if count != self.count as u64 {
            return Err(FileError::Order { found: TRAILER, expected: self.count as u32 });
        }
        if trailer.u64_le()? != hash(&header(&self.recipe), count) {
            return Err(FileError::Damaged("the trailer (it is of another header)".into()));
        }
        let mut more = [0; 1];
        if read_some(&mut self.from, &mut more)? > 0 {
            return Err(FileError::Value { field: AFTER_THE_END, value: 1.0, limit: "0" });
        }
        self.complete = true;
        Ok(())
    }
}

/// Longest block of a recipe: every coefficient of every component, four bytes for a value and less for its place.
fn longest_block(recipe: &Recipe) -> usize {
    20 + recipe.components() * (16 + 8 * recipe.medium.len())
}

/// Reads so many bytes; memory is taken for what is there alone.
fn filled(from: &mut impl Read, length: usize, into: &mut Vec<u8>, offset: &mut u64) -> Result<(), FileError> {
    into.clear();
    let unreadable = |error: std::io::Error| FileError::Unreadable(error.to_string());
    let found = from.by_ref().take(length as u64).read_to_end(into).map_err(unreadable)?;
    if found < length {
        return Err(TooShort { offset: *offset as usize, needed: length, left: found }.into());
    }
    *offset += length as u64;
    Ok(())
}

/// The next byte, if there is one.
fn read_some(from: &mut impl Read, into: &mut [u8; 1]) -> Result<usize, FileError> {
    let mut found = Vec::new();
    let unreadable = |error: std::io::Error| FileError::Unreadable(error.to_string());
    from.by_ref().take(1).read_to_end(&mut found).map_err(unreadable)?;
    found.iter().for_each(|byte| into[0] = *byte);
    Ok(found.len())
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
    let mut file = Blocks::open(bytes)?;
    let mut blocks = Vec::new();
    loop {
        match file.next_block() {
            Ok(Some(found)) => blocks.push(found),
            Ok(None) => break,
            // No bake leaves that.
            Err(why @ FileError::Value { field: AFTER_THE_END, .. }) => return Err(why),
            Err(_) if torn => break,
            Err(error) => return Err(error),
        }
    }
    let (sound_bytes, complete) = (file.sound_bytes() as usize, file.complete());
    Ok(Contents { recipe: file.recipe, blocks, sound_bytes, complete })
}

pub(super) fn decode(body: &[u8], recipe: &Recipe) -> Result<Block, FileError> {
    let refuse = |field, value: f64, limit| Err(FileError::Value { field, value, limit });
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

pub(super) fn recipe(body: &[u8]) -> Result<Recipe, FileError> {
    let mut r = Reader::new(body);
    let refuse = |field: &'static str, value: f64, limit| FileError::Value { field, value, limit };
    let pick = |field: &'static str, value: u8, most: u8| {
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
    ordinates::check(&params).map_err(|e| match e {
        SolveError::Parameter { field, value, limit } => refuse(field, value, limit),
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
