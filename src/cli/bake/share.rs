//! One share of a bake, or the whole, in its file: begun, gone on with after any interruption, and ended.

use super::super::Failure;
use super::super::progress::Progress;
use super::failed;
use crate::scattering::basis::{BakeError, Recipe};
use crate::scattering::file::{self, Blocks, FileError, Trailer};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Bakes one share into a file, going on where one was left.
pub(super) fn bake(recipe: &Recipe, index: usize, of: usize, out: &Path) -> Result<(), Failure> {
    let batches = recipe.batches();
    let share = recipe.share(index, of);
    let (mut file, mut done) = open(recipe, out)?;
    // Whole batches only: the lights of half a batch are baked again.
    let due: usize = batches[share.clone()].iter().map(std::ops::Range::len).sum();
    let mut from = share.start;
    let mut there = 0;
    while from < share.end && there + batches[from].len() <= done.lights.len() {
        there += batches[from].len();
        from += 1;
    }
    if done.lights.first().is_some_and(|(light, _)| *light != batches[share.start].start) {
        return Err(Failure::Input(format!("{}: holds another share of this bake", out.display())));
    }
    if done.lights.len() > due {
        return Err(Failure::Input(format!("{}: holds more than this share; it is not cut", out.display())));
    }
    done.lights.truncate(there);
    let end = done.ends[there];
    file.set_len(end).and_then(|()| file.seek(SeekFrom::Start(end))).map_err(|why| failed(out, &why))?;
    if there > 0 {
        println!("{}: going on after {there} of {due} lights", out.display());
    }
    let mut trailer = Trailer::default();
    done.lights.iter().for_each(|(_, squares)| trailer.add(*squares));
    let progress = Progress::new("baking lights", due);
    let mut baked = there;
    let outcome = recipe.bake(from..share.end, |light, block| {
        file.write_all(&file::block(recipe, light, &block))?;
        trailer.add(block.squares);
        baked += 1;
        progress.show(baked);
        Ok::<(), io::Error>(())
    });
    drop(progress);
    outcome.map_err(|why| match why {
        BakeError::Sink(why) => failed(out, &why),
        other @ BakeError::Solve { .. } => Failure::Run(other.to_string()),
    })?;
    let ended = if of == 1 { file.write_all(&trailer.bytes(recipe)) } else { Ok(()) };
    ended.and_then(|()| file.sync_all()).map_err(|why| failed(out, &why))?;
    println!("{}: {baked} lights of {}", out.display(), recipe.lights.len());
    Ok(())
}

/// What a file of this bake holds already.
pub(super) struct Done {
    /// Lights and their sums of squares.
    lights: Vec<(usize, [f64; 2])>,
    /// Where the header ends, and each light's block.
    ends: Vec<u64>,
}

/// Opens the file, new or begun by the same recipe; any other file is left alone.
pub(super) fn open(recipe: &Recipe, out: &Path) -> Result<(File, Done), Failure> {
    let header = file::header(recipe);
    let mut done = Done { lights: Vec::new(), ends: vec![header.len() as u64] };
    match std::fs::metadata(out) {
        Ok(found) if !found.is_file() => return Err(Failure::Input(format!("{}: is no file", out.display()))),
        Err(why) if why.kind() != io::ErrorKind::NotFound => return Err(failed(out, &why)),
        _ => {}
    }
    let opened = File::options().create(true).truncate(false).read(true).write(true).open(out);
    let mut file = opened.map_err(|why| failed(out, &why))?;
    let mut old = Vec::new();
    (&mut file).take(header.len() as u64).read_to_end(&mut old).map_err(|why| failed(out, &why))?;
    file.rewind().map_err(|why| failed(out, &why))?;
    // A bake killed in the header has written a part of just these bytes.
    if old.len() < header.len() && header.starts_with(&old) {
        file.write_all(&header).map_err(|why| failed(out, &why))?;
        return Ok((file, done));
    }
    let foreign = |why: FileError| Failure::Input(format!("{}: {why}", out.display()));
    let mut blocks = Blocks::open(BufReader::new(&mut file)).map_err(foreign)?;
    if blocks.recipe() != recipe {
        return Err(Failure::Input(format!("{}: is of another bake; it is not written over", out.display())));
    }
    loop {
        match blocks.next_block() {
            Ok(Some((light, block))) => {
                done.lights.push((light, block.squares));
                done.ends.push(blocks.sound_bytes());
            }
            // No bake of ours leaves that.
            Err(why @ FileError::Value { field: file::AFTER_THE_END, .. }) => return Err(foreign(why)),
            // The end, or what a killed bake leaves behind its last whole block.
            Ok(None) | Err(_) => break,
        }
    }
    drop(blocks);
    Ok((file, done))
}
