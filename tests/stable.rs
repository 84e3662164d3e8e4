//! The same snapshot gives the same bytes, whatever else the process has done: two processes, one thread and two, a seek
//! and playing through, alone and beside other views, after weather that is gone. On the processor, and on a graphics adapter.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Two layers at a low sun while the clock runs sixty times too fast and weather eases: light between corners of its grid, shade
/// of one layer on another, shadows on the ground. Before it something quite different was there.
fn low_sun(other_views: bool, different_before: bool) -> String {
    let mut entries = vec![
        r#"{"at": 0, "type": "time", "utc": "2026-05-10T16:30:00Z", "rate": 60}"#.to_owned(),
        r#"{"at": 0, "type": "ownship", "latitude_deg": 47, "longitude_deg": 8, "altitude_m": 2500, "yaw_deg": 250, "pitch_deg": -8, "roll_deg": 0}"#.to_owned(),
        view("main", "change", 0),
    ];
    if other_views {
        entries.push(view("left", "create", 300));
        entries.push(view("above", "create", 60));
    }
    if different_before {
        entries.push(DIFFERENT.to_owned());
    }
    entries.push(r#"{"at": 1, "type": "weather", "layers": [{"cloud_type": "stratocumulus", "base_m": 1200, "thickness_m": 600, "coverage": 0.7}, {"cloud_type": "altocumulus", "base_m": 4000, "thickness_m": 400, "coverage": 0.5}], "visibility_m": 40000}"#.to_owned());
    entries.push(
        r#"{"at": 2, "type": "weather", "changes": [{"index": 0, "coverage": 0.4}], "transition_s": 4}"#.to_owned(),
    );
    whole(&entries)
}

/// A night under an overcast near Milan with a strike at 2 s and another at the moment that is looked at, 4 s: channels,
/// fields of light in the cloud, towns, stars in the gaps.
fn flash(other_views: bool, different_before: bool) -> String {
    let strike = |at: u32, latitude_deg: f64, flash_type: &str| {
        format!(
            r#"{{"at": {at}, "type": "strike", "latitude_deg": {latitude_deg}, "longitude_deg": 9.5, "altitude_m": 2000, "flash_type": "{flash_type}", "seed": {at}, "strokes": "sample", "at_s": "now"}}"#
        )
    };
    let mut entries = vec![
        r#"{"at": 0, "type": "time", "utc": "2026-07-20T22:30:00Z", "rate": 1}"#.to_owned(),
        r#"{"at": 0, "type": "ownship", "latitude_deg": 45.17, "longitude_deg": 9.5, "altitude_m": 700, "yaw_deg": 0, "pitch_deg": 8, "roll_deg": 0}"#.to_owned(),
        view("main", "change", 0),
    ];
    if other_views {
        entries.push(view("left", "create", 300));
    }
    if different_before {
        entries.push(DIFFERENT.to_owned());
    }
    entries.push(r#"{"at": 1, "type": "weather", "layers": [{"cloud_type": "stratocumulus", "base_m": 1200, "thickness_m": 700, "coverage": 0.8, "wind_speed_mps": 12, "wind_from_deg": 220}], "visibility_m": 25000}"#.to_owned());
    entries.push(strike(2, 45.22, "intra_cloud"));
    entries.push(strike(4, 45.25, "cloud_to_ground"));
    whole(&entries)
}

/// Weather that is gone before the moment that is looked at.
const DIFFERENT: &str = r#"{"at": 0, "type": "weather", "layers": [{"cloud_type": "stratus", "base_m": 300, "thickness_m": 500, "coverage": 1}], "visibility_m": 3000}"#;

fn view(name: &str, action: &str, yaw_deg: u32) -> String {
    format!(
        r#"{{"at": 0, "type": "view", "action": "{action}", "name": "{name}", "size_px": [48, 27], "yaw_deg": {yaw_deg}}}"#
    )
}

fn whole(entries: &[String]) -> String {
    format!(
        r#"{{"type": "scenario", "protocol": "stormdeck.v1", "name": "stable", "description": "One moment.", "duration_s": 10, "entries": [{}]}}"#,
        entries.join(",\n")
    )
}

/// A folder of this test's own, gone when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("stable-{test}"));
        let _old = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a folder for the test");
        Self(path)
    }

    /// Runs `render` on a scenario, on so many threads, and returns the pictures it wrote, in their order.
    fn render(&self, run: &str, scenario: &str, threads: u32, what: &[&str]) -> Vec<Vec<u8>> {
        let folder = self.0.join(run);
        std::fs::create_dir_all(&folder).expect("a folder for the run");
        let file = folder.join("scenario.json");
        std::fs::write(&file, scenario).expect("a scenario");
        let out = folder.join("picture.png");
        let mut command = Command::new(env!("CARGO_BIN_EXE_stormdeck"));
        command.arg("render").arg(&file).args(what).arg("--view").arg("main").arg("--out").arg(&out);
        command.env("RAYON_NUM_THREADS", threads.to_string()).stdin(Stdio::null());
        let output = command.output().expect("the binary");
        assert!(output.status.success(), "{run}: {}", String::from_utf8_lossy(&output.stderr));
        let mut names: Vec<PathBuf> = std::fs::read_dir(&folder)
            .expect("the folder of the run")
            .map(|entry| entry.expect("an entry").path())
            .filter(|path| path.extension().is_some_and(|e| e == "png"))
            .collect();
        names.sort();
        names.iter().map(|name| std::fs::read(name).expect("a picture")).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _gone = std::fs::remove_dir_all(&self.0);
    }
}

/// Every way to come to the moment of 4 s shows the same picture; another moment shows another.
fn every_way_shows_the_same(name: &str, scenario: fn(bool, bool) -> String, executor: &str) {
    let folder = Folder::new(&format!("{name}-{executor}"));
    let at = |seconds: &'static str| vec!["--at", seconds, "--executor", executor, "--terrain", "procedural"];
    let first = folder.render("first", &scenario(false, false), 2, &at("4"));
    assert_eq!(first.len(), 1);
    assert_eq!(folder.render("again", &scenario(false, false), 2, &at("4")), first, "another process");
    assert_eq!(folder.render("one-thread", &scenario(false, false), 1, &at("4")), first, "one thread");
    assert_eq!(folder.render("views", &scenario(true, false), 2, &at("4")), first, "beside other views");
    assert_eq!(folder.render("before", &scenario(false, true), 2, &at("4")), first, "after different weather");
    // Playing through draws the moments before in the same process: other weather, other corners of the grid of light.
    let through = ["--from", "0", "--to", "4", "--fps", "1", "--executor", executor, "--terrain", "procedural"];
    let played = folder.render("played", &scenario(true, true), 2, &through);
    assert_eq!(played.len(), 5);
    assert_eq!(played[4], first[0], "played through");
    assert_ne!(played[3], first[0], "another moment is another picture");
}

#[test]
fn the_reference_executor_is_stable() {
    every_way_shows_the_same("low-sun", low_sun, "reference");
    every_way_shows_the_same("flash", flash, "reference");
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn the_gpu_executor_is_stable() {
    every_way_shows_the_same("low-sun", low_sun, "gpu");
    every_way_shows_the_same("flash", flash, "gpu");
}
