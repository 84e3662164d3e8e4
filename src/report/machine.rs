//! On what a report was measured: processor, threads, system, commit.

use std::path::Path;

/// Processor, threads and system in one line.
pub fn describe() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| processor(&text));
    let processor = processor.unwrap_or_else(|| "unknown processor".to_owned());
    let profile = if cfg!(debug_assertions) { ", debug build" } else { "" };
    let (architecture, system) = (std::env::consts::ARCH, std::env::consts::OS);
    format!("{processor}, {threads} threads, {architecture} {system}{profile}")
}

/// The model that Linux names first.
fn processor(cpuinfo: &str) -> Option<String> {
    let line = cpuinfo.lines().find(|line| line.starts_with("model name"))?;
    let (_, name) = line.split_once(':')?;
    Some(name.trim().to_owned()).filter(|name| !name.is_empty())
}

/// The commit that this binary belongs to: as told at build time (`STORMDECK_COMMIT`), or that of the checkout in whose
/// folder the binary lies; "unknown" otherwise.
pub fn commit() -> String {
    let told = option_env!("STORMDECK_COMMIT").map(str::to_owned);
    let found = || {
        let binary = std::env::current_exe().ok()?;
        binary.ancestors().find_map(|folder| head(&folder.join(".git")))
    };
    told.or_else(found).unwrap_or_else(|| "unknown".to_owned())
}

/// The commit that a `.git` folder has checked out.
fn head(git: &Path) -> Option<String> {
    let text = std::fs::read_to_string(git.join("HEAD")).ok()?;
    let text = text.trim();
    let Some(name) = text.strip_prefix("ref: ") else { return hash(text) };
    let loose = std::fs::read_to_string(git.join(name)).ok().and_then(|text| hash(text.trim()));
    let packed = || {
        let text = std::fs::read_to_string(git.join("packed-refs")).ok()?;
        text.lines().find_map(|line| line.split_once(' ').filter(|(_, n)| *n == name).and_then(|(h, _)| hash(h)))
    };
    loose.or_else(packed)
}

fn hash(text: &str) -> Option<String> {
    (text.len() >= 40 && text.bytes().all(|b| b.is_ascii_hexdigit())).then(|| text[..12].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_is_the_first_named() {
        let text = "processor\t: 0\nmodel name\t: Some CPU @ 2 GHz\nprocessor\t: 1\nmodel name\t: Other\n";
        assert_eq!(processor(text).as_deref(), Some("Some CPU @ 2 GHz"));
        assert_eq!(processor("nothing"), None);
    }

    #[test]
    fn a_commit_is_found_loose_packed_and_detached() {
        let git = std::env::temp_dir().join(format!("stormdeck-git-{}", std::process::id()));
        let _old = std::fs::remove_dir_all(&git);
        std::fs::create_dir_all(git.join("refs/heads")).expect("a folder");
        let write = |name: &str, text: &str| std::fs::write(git.join(name), text).expect("a file");
        let (one, two) = ("0123456789abcdef0123456789abcdef01234567", "fedcba9876543210fedcba9876543210fedcba98");
        write("HEAD", "ref: refs/heads/main\n");
        write("packed-refs", &format!("# pack-refs\n{two} refs/heads/other\n{one} refs/heads/main\n"));
        assert_eq!(head(&git).as_deref(), Some(&one[..12]));
        write("refs/heads/main", &format!("{two}\n"));
        assert_eq!(head(&git).as_deref(), Some(&two[..12]));
        write("HEAD", one);
        assert_eq!(head(&git).as_deref(), Some(&one[..12]));
        write("HEAD", "no hash");
        assert_eq!(head(&git), None);
        let _gone = std::fs::remove_dir_all(&git);
    }
}
