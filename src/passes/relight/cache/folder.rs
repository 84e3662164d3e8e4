//! What lies in the folder: files by their table, told by name alone; anything else in it is left alone.

use super::Key;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What a file of a table is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// All of it.
    Whole,
    /// Some lights.
    Share,
    /// Being written.
    Partial,
}

/// The files of one table.
pub struct Kept {
    /// Bytes of all of them.
    pub bytes: u64,
    /// When one of them was written or read last.
    pub used: SystemTime,
    /// Their paths, what they are, and when each was written or read last.
    pub files: Vec<(PathBuf, Kind, SystemTime)>,
}

/// All tables of a folder.
///
/// # Errors
/// The folder cannot be read.
pub fn list(folder: &Path) -> io::Result<BTreeMap<Key, Kept>> {
    let mut tables = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let Ok(entry) = entry else { continue };
        let Some((key, kind)) = named(&entry.file_name().to_string_lossy()) else { continue };
        // Another program may have taken it away since.
        let Ok(about) = entry.metadata() else { continue };
        let changed = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        let table: &mut Kept = tables.entry(key).or_insert_with(|| Kept { bytes: 0, used: changed, files: Vec::new() });
        table.bytes += about.len();
        table.used = table.used.max(changed);
        table.files.push((entry.path(), kind, changed));
    }
    Ok(tables)
}

/// The table and kind that a name tells; `None` for names of others.
pub fn named(name: &str) -> Option<(Key, Kind)> {
    let (stem, ending) = name.rsplit_once('.')?;
    let (key, numbers) = stem.split_once('-').unwrap_or((stem, ""));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let kind = match ending {
        "basis" if stem == key => Kind::Whole,
        "share" if digits(numbers) => Kind::Share,
        "partial" if numbers.split_once('-').is_some_and(|(a, b)| digits(a) && digits(b)) => Kind::Partial,
        _ => return None,
    };
    Some((Key::of(key)?, kind))
}
