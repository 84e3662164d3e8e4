//! Tables of virtual lights across processes: found again, and whole after a bake was killed.

use super::{Folder, expect, run, stormdeck};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A night under a thin overcast with one flash: tables of thin clouds are baked quickly.
const FLASH: &str = r#"{
  "type": "scenario", "protocol": "stormdeck.v1", "name": "flash", "description": "One flash in a thin overcast.", "duration_s": 3,
  "entries": [
    {"at": 0, "type": "time", "utc": "2026-07-20T22:30:00Z", "rate": 1},
    {"at": 0, "type": "ownship", "latitude_deg": 45.17, "longitude_deg": 9.5, "altitude_m": 700, "yaw_deg": 0, "pitch_deg": 8, "roll_deg": 0},
    {"at": 0, "type": "view", "action": "change", "name": "main", "size_px": [32, 18]},
    {"at": 0, "type": "weather", "layers": [{"cloud_type": "stratocumulus", "base_m": 1200, "thickness_m": 100, "coverage": 1, "density": 0.1}], "visibility_m": 25000},
    {"at": 1, "type": "strike", "latitude_deg": 45.19, "longitude_deg": 9.5, "altitude_m": 1250, "flash_type": "intra_cloud", "seed": 2, "strokes": "sample", "at_s": "now"}
  ]
}"#;

/// Starts a command, kills it (SIGKILL) as soon as `begun` says so, and makes sure that it did not end by itself.
fn killed(command: &mut Command, begun: impl Fn() -> bool) {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary");
    let end = Instant::now() + Duration::from_secs(120);
    while !begun() {
        assert!(child.try_wait().expect("a state").is_none(), "it ended before it could be killed");
        assert!(Instant::now() < end, "nothing was begun");
        // There is no news of a file that grows.
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().expect("killed");
    assert_eq!(child.wait().expect("a state").code(), None, "it ended before it was killed");
}

fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let Ok(all) = std::fs::read_dir(folder) else { return Vec::new() };
    let paths = all.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.to_string_lossy().ends_with(ending)).collect()
}

#[test]
fn a_bake_that_is_killed_and_gone_on_with_has_the_bytes_of_one_that_was_left_alone() {
    let folder = Folder::new("killed");
    let bake = |out: &str| {
        let mut command = stormdeck(&["bake", "overcast-night-cities", "--cells", "32x32x4", "--lights", "4x4x3"]);
        // Batches are written when all threads have one: with two, often enough to be killed between them.
        command.args(["--tolerance", "1e-2", "--out", &folder.path(out)]).env("RAYON_NUM_THREADS", "2");
        command
    };
    let (code, text) = run(&mut bake("whole"));
    assert_eq!(code, 0, "{text}");
    let whole = std::fs::read(folder.path("whole")).expect("a basis");
    // Killed in the first block, and once more somewhere behind it.
    let length = |out: &str| std::fs::metadata(folder.path(out)).map_or(0, |file| file.len());
    killed(&mut bake("torn"), || length("torn") > 0);
    let before = length("torn");
    assert!(before < whole.len() as u64);
    killed(&mut bake("torn"), || length("torn") > before.max(whole.len() as u64 * 2 / 3));
    assert!(length("torn") < whole.len() as u64);
    let (code, text) = run(&mut bake("torn"));
    assert!(code == 0 && text.contains("going on after"), "{text}");
    assert!(std::fs::read(folder.path("torn")).expect("a basis") == whole, "the same bytes");
}

#[test]
fn a_second_picture_bakes_nothing_and_a_killed_bake_leaves_lights_that_are_used() {
    let folder = Folder::new("tables");
    let (scenario, cache) = (folder.file("flash.json", FLASH), folder.path("cache"));
    let render = |out: &str, more: &[&str], says: &[&str]| {
        let out = folder.path(out);
        let mut arguments = vec!["render", &scenario, "--at", "1", "--executor", "reference", "--out", &out];
        arguments.extend(["--relight", "hybrid"].iter().chain(more));
        let text = expect(&arguments, 0, says);
        (std::fs::read(&out).expect("a picture"), text)
    };
    let with = ["--basis-cache", cache.as_str()];
    let (alone, _) = render("alone.png", &[], &["0 read"]);
    // The bake of all lights, killed when it has some.
    let mut bake = stormdeck(&["bake", &scenario, "--struck", "hybrid", "--cache", &cache]);
    killed(&mut bake, || files(Path::new(&cache), ".share").len() > 1);
    let left = files(Path::new(&cache), ".share").len();
    let (first, text) = render("first.png", &with, &["lights baked"]);
    assert!(!text.contains(" 0 lights baked") && !text.contains(" 0 read"), "{text}");
    assert!(files(Path::new(&cache), ".share").len() > left && !text.contains("baked again"));
    let (second, _) = render("second.png", &with, &[": 0 lights baked"]);
    assert!(first == alone && second == alone, "whoever baked the lights, the picture is the same");
    // A damaged file is told and baked again.
    let hit = files(Path::new(&cache), ".share").pop().expect("a share");
    let mut bytes = std::fs::read(&hit).expect("a share");
    bytes[60] ^= 1;
    std::fs::write(&hit, bytes).expect("a file");
    let (third, _) = render("third.png", &with, &["the header is damaged", "baked again"]);
    assert!(third == alone);
    let no_folder = folder.file("no-folder", "a file");
    expect(
        &["render", &scenario, "--at", "1", "--out", &folder.path("x.png"), "--basis-cache", &no_folder],
        2,
        &["basis_cache"],
    );
    expect(&["bake", &scenario, "--struck", "solve", "--cache", &cache], 2, &["basis and hybrid have tables"]);
    expect(&["bake", &scenario, "--struck", "hybrid"], 2, &["--cache"]);
}
