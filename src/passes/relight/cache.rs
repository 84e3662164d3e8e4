//! Baked tables in a folder, by content: an unchanged cloud is never baked twice, by whichever program and after any restart.
//!
//! *What it is.* Basis files (`protocol/basis-file.md`): a whole table is `KEY.basis`, and as long as one is being baked each batch of
//! its lights is a share, `KEY-FIRSTLIGHT.share`. *What a key is.* The hash of everything that decides the table: its recipe, and
//! what this program's solver makes of a tiny cloud ([`key`]). So a solver that was changed finds no table of the old one.
//! *How it is written.* Under another name, then renamed: a file is there whole or not at all, and several programs may share a
//! folder. *How it is read.* As a stream, checked block by block; what is damaged or foreign is told once, taken away, and
//! baked again. *How large it gets.* When it is full, tables that were not used for longest go.

mod folder;
mod key;

pub use key::{Key, key};

use crate::scattering::basis::Recipe;
use crate::scattering::compress::Block;
use crate::scattering::file::{self, Blocks, FileError, Trailer};
use folder::{Kept, Kind, list, named};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

/// What was left half written for so long has lost its writer.
const FORSAKEN: Duration = Duration::from_secs(3_600);
/// Different complaints that are remembered; beyond them there is silence.
const MOST_SAID: usize = 1_000;

/// A folder of tables.
pub struct Cache {
    folder: PathBuf,
    most_bytes: u64,
    /// Part of the names of files that are being written.
    number: AtomicU64,
    refused: AtomicU64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Bytes of all tables, as far as this program has seen.
    bytes: u64,
    /// Everything complained of so far, and what of it nobody has taken yet.
    said: BTreeSet<String>,
    complaints: Vec<String>,
    /// Tables that alone are larger than all may be.
    too_large: BTreeSet<Key>,
}

impl Cache {
    /// The tables of a folder, which is made if it is not there; all of them may take `most_bytes`.
    ///
    /// # Errors
    /// The folder can neither be read nor made.
    pub fn open(folder: &Path, most_bytes: u64) -> io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let cache = Self {
            folder: folder.to_owned(),
            most_bytes,
            number: AtomicU64::new(0),
            refused: AtomicU64::new(0),
            state: Mutex::default(),
        };
        for table in list(folder)?.values() {
            for (path, kind, changed) in &table.files {
                let age = SystemTime::now().duration_since(*changed).unwrap_or_default();
                if *kind == Kind::Partial && age > FORSAKEN {
                    // It may have gone meanwhile.
                    let _gone = std::fs::remove_file(path);
                }
            }
        }
        cache.state().bytes = list(folder)?.values().map(|table| table.bytes).sum();
        Ok(cache)
    }

    /// Bytes of all tables, as far as this program has seen.
    pub fn bytes(&self) -> u64 {
        self.state().bytes
    }

    /// Files that were refused so far.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    /// What went wrong since this was asked last, each once.
    pub fn complaints(&self) -> Vec<String> {
        std::mem::take(&mut self.state().complaints)
    }

    /// Hands over the blocks of a table that are there, of the whole one or of its shares: each share's in order, some
    /// perhaps twice.
    pub fn load(&self, key: &Key, recipe: &Recipe, mut take: impl FnMut(usize, Block)) {
        let mut files = match list(&self.folder) {
            Ok(mut all) => all.remove(key).map_or_else(Vec::new, |table| table.files),
            Err(why) => return self.complain(format!("{}: cannot be read: {why}", self.folder.display())),
        };
        files.sort();
        if let Some(whole) = files.iter().find(|(_, kind, _)| *kind == Kind::Whole)
            && self.read(&whole.0, recipe, &mut take)
        {
            return;
        }
        for (path, ..) in files.iter().filter(|(_, kind, _)| *kind == Kind::Share) {
            self.read(path, recipe, &mut take);
        }
    }

    /// Where the whole table lies, if it is there and sound from the first byte to the last.
    pub fn whole(&self, key: &Key, recipe: &Recipe) -> Option<PathBuf> {
        let path = self.path(key, ".basis");
        (path.is_file() && self.read(&path, recipe, &mut |_, _| {})).then_some(path)
    }

    /// Puts a batch of lights in that follow one another; what cannot be written is complained of.
    pub fn put_share(&self, key: &Key, recipe: &Recipe, first: usize, blocks: &[Block]) {
        self.put(key, &format!("-{first:07}.share"), |out| {
            out.write_all(&file::header(recipe))?;
            blocks.iter().enumerate().try_for_each(|(i, b)| out.write_all(&file::block(recipe, first + i, b)))
        });
    }

    /// Puts a whole table in, in place of its shares.
    pub fn put_whole<'a>(&self, key: &Key, recipe: &Recipe, blocks: impl Iterator<Item = &'a Block>) {
        self.put(key, ".basis", |out| {
            out.write_all(&file::header(recipe))?;
            let mut trailer = Trailer::default();
            for block in blocks {
                out.write_all(&file::block(recipe, trailer.lights(), block))?;
                trailer.add(block.squares);
            }
            out.write_all(&trailer.bytes(recipe))
        });
    }

    /// Puts a basis file in that has been read before.
    pub fn put_file(&self, key: &Key, whole: &Path) {
        self.put(key, ".basis", |out| io::copy(&mut File::open(whole)?, out).map(drop));
    }

    fn drop_shares(&self, key: &Key) {
        let Ok(mut all) = list(&self.folder) else { return };
        let files = all.remove(key).map_or_else(Vec::new, |table| table.files);
        for (path, ..) in files.iter().filter(|(_, kind, _)| *kind == Kind::Share) {
            self.remove(path);
        }
    }

    /// Reads a file of a recipe; false, with a complaint, where something is wrong with it.
    fn read(&self, path: &Path, recipe: &Recipe, take: &mut dyn FnMut(usize, Block)) -> bool {
        match read(path, recipe, take) {
            Ok(()) => {
                // Used now: others go first. A folder that only can be read forgets by age instead.
                let touched = File::options().append(true).open(path);
                let _age = touched.and_then(|file| file.set_modified(SystemTime::now()));
                true
            }
            Err(Trouble::Gone) => false,
            // It may be sound for others, or later.
            Err(Trouble::Unreadable(why)) => {
                self.complain(format!("{}: cannot be read: {why}", path.display()));
                false
            }
            Err(Trouble::Wrong(why)) => {
                self.refused.fetch_add(1, Ordering::Relaxed);
                self.complain(format!("{}: {why}; it is baked again", path.display()));
                self.remove(path);
                false
            }
        }
    }

    /// Writes a file of a table, whole or not at all; a whole table takes the place of its shares.
    fn put(&self, key: &Key, ending: &str, fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) {
        if self.state().too_large.contains(key) {
            return;
        }
        let number = self.number.fetch_add(1, Ordering::Relaxed);
        let partial = self.path(key, &format!("-{}-{number}.partial", std::process::id()));
        let path = self.path(key, ending);
        let written = File::create(&partial).map(BufWriter::new).and_then(|mut out| {
            fill(&mut out)?;
            let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
            // A share is checked when it is read, and soon gone; a whole table is to last.
            if ending == ".basis" {
                file.sync_all()?;
            }
            let bytes = file.metadata()?.len();
            let before = std::fs::metadata(&path).map_or(0, |old| old.len());
            std::fs::rename(&partial, &path)?;
            Ok((bytes, before))
        });
        match written {
            Ok((bytes, before)) => {
                // Before anything is counted, or a table would seem twice as large as it is.
                if ending == ".basis" {
                    self.drop_shares(key);
                }
                let mut state = self.state();
                state.bytes = (state.bytes + bytes).saturating_sub(before);
                if state.bytes > self.most_bytes {
                    self.make_room(&mut state, key);
                }
            }
            Err(why) => {
                let _gone = std::fs::remove_file(&partial);
                self.complain(format!("{}: nothing can be kept: {why}", self.folder.display()));
            }
        }
    }

    /// Takes away the tables that were not used for longest, but this one.
    fn make_room(&self, state: &mut State, key: &Key) {
        let Ok(all) = list(&self.folder) else { return };
        let mut bytes: u64 = all.values().map(|table| table.bytes).sum();
        let mut oldest: Vec<_> = all.iter().filter(|(other, _)| *other != key).collect();
        oldest.sort_by_key(|(other, table)| (table.used, (*other).clone()));
        // A tenth more than must be, so that not every batch looks through the folder.
        let enough = self.most_bytes - self.most_bytes / 10;
        // What is too large for itself alone costs no other table its place.
        if let Some(own) = all.get(key).filter(|table| table.bytes > self.most_bytes) {
            bytes = bytes.saturating_sub(self.removed(state, own));
            if state.too_large.len() < MOST_SAID {
                state.too_large.insert(key.clone());
            }
            let most = self.most_bytes >> 20;
            complain(state, format!("{}: a table is larger than the {most} MiB of all", self.folder.display()));
        }
        for (_, table) in oldest {
            if bytes <= enough || bytes <= self.most_bytes && state.too_large.contains(key) {
                break;
            }
            bytes = bytes.saturating_sub(self.removed(state, table));
        }
        state.bytes = bytes;
    }

    /// Takes a table away and tells its bytes. What is being written stays for its writer.
    fn removed(&self, state: &mut State, table: &Kept) -> u64 {
        let mut bytes = 0;
        for (path, kind, changed) in &table.files {
            let age = SystemTime::now().duration_since(*changed).unwrap_or_default();
            if *kind == Kind::Partial && age < FORSAKEN {
                continue;
            }
            let own = std::fs::metadata(path).map_or(0, |file| file.len());
            match std::fs::remove_file(path) {
                Ok(()) => bytes += own,
                // Another program took it away: its bytes are gone all the same.
                Err(why) if why.kind() == io::ErrorKind::NotFound => bytes += own,
                Err(why) => complain(state, format!("{}: cannot be taken away: {why}", path.display())),
            }
        }
        bytes
    }

    fn remove(&self, path: &Path) {
        let bytes = std::fs::metadata(path).map_or(0, |file| file.len());
        if std::fs::remove_file(path).is_ok() {
            let mut state = self.state();
            state.bytes = state.bytes.saturating_sub(bytes);
        }
    }

    fn path(&self, key: &Key, ending: &str) -> PathBuf {
        let path = self.folder.join(format!("{key}{ending}"));
        debug_assert!(path.file_name().and_then(|name| named(&name.to_string_lossy())).is_some());
        path
    }

    fn complain(&self, what: String) {
        complain(&mut self.state(), what);
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // What is guarded is whole between any two statements.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn complain(state: &mut State, what: String) {
    if state.said.len() < MOST_SAID && state.said.insert(what.clone()) {
        state.complaints.push(what);
    }
}

/// Why a file was not read.
enum Trouble {
    /// Another program took it away, or put a whole table in its place.
    Gone,
    /// The system does not hand it over.
    Unreadable(String),
    /// It is damaged, cut off, foreign or of another cloud.
    Wrong(String),
}

/// Reads a file of a recipe, block by block.
fn read(path: &Path, recipe: &Recipe, take: &mut dyn FnMut(usize, Block)) -> Result<(), Trouble> {
    let unreadable = |why: io::Error| match why.kind() {
        io::ErrorKind::NotFound => Trouble::Gone,
        _ => Trouble::Unreadable(why.to_string()),
    };
    let wrong = |why: FileError| match why {
        FileError::Unreadable(why) => Trouble::Unreadable(why),
        other => Trouble::Wrong(other.to_string()),
    };
    // A pipe or a device of this name would be waited for.
    if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(Trouble::Unreadable("it is no file".to_owned()));
    }
    let mut file = Blocks::open(BufReader::new(File::open(path).map_err(unreadable)?)).map_err(wrong)?;
    if file.recipe() != recipe {
        return Err(Trouble::Wrong("is of another cloud than its name says".to_owned()));
    }
    let mut lights = 0;
    while let Some((light, block)) = file.next_block().map_err(wrong)? {
        take(light, block);
        lights += 1;
    }
    let is_whole = path.extension().is_some_and(|ending| ending == "basis");
    if is_whole && !(file.complete() && lights == recipe.lights.len()) {
        return Err(Trouble::Wrong(format!("ends after {lights} of {} lights", recipe.lights.len())));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
