//! Shares of one bake become the whole, in any order, one block in memory at a time.

use super::read::Blocks;
use super::{FileError, TRAILER, Trailer, block, header};
use crate::scattering::compress::Block;
use std::io::{Read, Write};

/// Why shares were not joined.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    /// A share is none.
    #[error("share {0}: {1}")]
    Share(usize, FileError),
    /// They do not make a whole.
    #[error(transparent)]
    Whole(#[from] FileError),
    /// The whole cannot be written.
    #[error("cannot be written: {0}")]
    Write(#[from] std::io::Error),
}

/// Writes the whole of the shares of one recipe, given in any order; gives the number of lights. `shares` opens the share of a
/// number, as often as is asked; what has been written when it fails is no basis.
///
/// # Errors
/// [`JoinError`]: a damaged share, another recipe, missing or doubled lights, or a full disk.
pub fn join<R: Read>(
    count: usize,
    mut shares: impl FnMut(usize) -> std::io::Result<R>,
    into: &mut impl Write,
) -> Result<usize, JoinError> {
    let unreadable = |i: usize, why: std::io::Error| JoinError::Share(i, FileError::Unreadable(why.to_string()));
    // Which light each begins with; empty ones have nothing to say.
    let mut order: Vec<(usize, usize)> = Vec::new();
    let mut recipe = None;
    for i in 0..count {
        let mut share =
            Blocks::open(shares(i).map_err(|why| unreadable(i, why))?).map_err(|why| JoinError::Share(i, why))?;
        let first = share.next_block().map_err(|why| JoinError::Share(i, why))?;
        order.extend(first.map(|(light, _)| (light, i)));
        if recipe.get_or_insert_with(|| share.recipe().clone()) != share.recipe() {
            return Err(FileError::Mixed(i).into());
        }
    }
    let recipe = recipe.ok_or(FileError::Foreign)?;
    order.sort_unstable();
    into.write_all(&header(&recipe))?;
    let mut trailer = Trailer::default();
    for (_, i) in order {
        let mut share =
            Blocks::open(shares(i).map_err(|why| unreadable(i, why))?).map_err(|why| JoinError::Share(i, why))?;
        let mut next = || -> Result<Option<(usize, Block)>, JoinError> {
            share.next_block().map_err(|why| JoinError::Share(i, why))
        };
        while let Some((light, found)) = next()? {
            if light != trailer.lights() {
                return Err(FileError::Order { found: light as u32, expected: trailer.lights() as u32 }.into());
            }
            into.write_all(&block(&recipe, light, &found))?;
            trailer.add(found.squares);
        }
    }
    if trailer.lights() != recipe.lights.len() {
        return Err(FileError::Order { found: TRAILER, expected: trailer.lights() as u32 }.into());
    }
    into.write_all(&trailer.bytes(&recipe))?;
    Ok(trailer.lights())
}
