//! The built binary as a user meets it: exit codes, complaints in words, pictures on disk, a server that starts and stops.

#[path = "cli/tables.rs"]
mod tables;

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const SCENARIO: &str = r#"{
  "type": "scenario", "protocol": "stormdeck.v1", "name": "test", "description": "A deck.", "duration_s": 10,
  "entries": [
    {"at": 0, "type": "time", "utc": "2026-06-21T11:30:00Z"},
    {"at": 0, "type": "ownship", "latitude_deg": 47, "longitude_deg": 8, "altitude_m": 700, "yaw_deg": 0, "pitch_deg": 5, "roll_deg": 0},
    {"at": 0, "type": "weather", "layers": [{"cloud_type": "cumulus", "base_m": 1200, "thickness_m": 800, "coverage": 0.5}]}
  ]
}"#;

/// The same without the deck: its light takes most of the time of a first picture.
fn clear_sky() -> String {
    let (before, _) = SCENARIO.split_once("[{\"cloud_type\"").expect("the deck");
    format!("{before}[]}}\n  ]\n}}")
}

/// A folder of this test's own, gone when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-{test}"));
        let _old = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a folder for the test");
        Self(path)
    }

    fn file(&self, name: &str, text: &str) -> String {
        std::fs::write(self.0.join(name), text).expect("a file for the test");
        self.path(name)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _gone = std::fs::remove_dir_all(&self.0);
    }
}

fn stormdeck(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stormdeck"));
    command.args(arguments).stdin(Stdio::null()).current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

/// Runs to the end and returns the exit code and everything printed.
fn run(command: &mut Command) -> (i32, String) {
    let Output { status, stdout, stderr } = command.output().expect("the binary");
    let text = String::from_utf8_lossy(&stdout).into_owned() + &String::from_utf8_lossy(&stderr);
    (status.code().expect("an exit code, not a signal"), text)
}

/// Fails unless the command ends with this code and says all of these.
fn expect(arguments: &[&str], code: i32, says: &[&str]) -> String {
    let (found, text) = run(&mut stormdeck(arguments));
    assert_eq!(found, code, "{arguments:?}: {text}");
    for word in says {
        assert!(text.contains(word), "{arguments:?} does not say {word:?}: {text}");
    }
    text
}

#[test]
fn a_wrong_command_line_ends_with_2_and_help_with_0() {
    expect(&["--help"], 0, &["serve", "render", "check", "host"]);
    expect(&["--version"], 0, &[env!("CARGO_PKG_VERSION")]);
    expect(&["fly"], 2, &["fly"]);
    expect(&["check"], 2, &["FILE"]);
    expect(&["serve", "--executor", "abacus"], 2, &["gpu, reference or auto"]);
    expect(&["render", "clear-day", "--out", "a.png"], 2, &["--at"]);
    expect(&["host", "clear-day", "--to", "127.0.0.1:1", "--rate", "0"], 2, &["0.1 to 120"]);
}

#[test]
fn check_tells_everything_that_is_wrong_with_line_and_path() {
    let folder = Folder::new("check");
    let good = folder.file("good.json", SCENARIO);
    expect(&["check", &good], 0, &["good.json: scenario \"test\", 3 entries"]);
    expect(&["check", "config/default.json"], 0, &["settings"]);

    let bad = SCENARIO.replace("\"latitude_deg\": 47", "\"latitude_deg\": 91").replace("800", "-800");
    let bad = folder.file("bad.json", &bad.replace("\"coverage\": 0.5", "\"colour\": 0.5"));
    let complaints = ["line 5", "entries[1].latitude_deg", "line 6", "thickness_m", "colour"];
    expect(&["check", &good, &bad], 2, &complaints);

    let infinite = folder.file("infinite.json", &SCENARIO.replace("800", "1e999"));
    let told = expect(&["check", &infinite], 2, &["thickness_m", "1e999"]);
    assert!(!told.contains("unknown field"), "one bad number makes it no settings file: {told}");

    let over = SCENARIO.replace(
        "0.5}]",
        "0.5}, {\"cloud_type\": \"stratus\", \"base_m\": 1500, \"thickness_m\": 100, \"coverage\": 1}]",
    );
    expect(&["check", &folder.file("over.json", &over)], 2, &["entries[2]"]);

    expect(&["check", &folder.file("broken.json", "{\n  \"a\": ]\n}")], 2, &["broken.json", "line 2"]);
    expect(&["check", &folder.path("missing.json")], 2, &["missing.json: cannot be read"]);
    let settings = folder.file("settings.json", "{\"frame_rate_hz\": 1000, \"jpeg_quality\": 0, \"colour\": 1}");
    expect(&["check", &settings], 2, &["frame_rate_hz", "jpeg_quality", "colour"]);
}

#[test]
fn a_report_writes_its_files_and_a_broken_bound_ends_with_1() {
    let folder = Folder::new("report");
    expect(&["report", "--list"], 0, &["deck", "encode"]);
    expect(&["report", "weather"], 2, &["no subject `weather`", "encode"]);
    expect(&["report", "encode", "--json", &folder.path("none/r.json")], 2, &["none/r.json: cannot be written"]);
    let wrong = folder.file("wrong.json", r#"{"bounds": [{"subject": "encode", "max_eror": 1}]}"#);
    expect(&["report", "encode", "--quick", "--check", &wrong], 2, &["wrong.json", "max_eror"]);
    // One run for the rest: it draws a picture.
    let bounds = r#"{"bounds": [{"subject": "encode", "method": "PNG", "max_error": 0},
        {"subject": "encode", "method": "JPEG", "max_error": 0}]}"#;
    let (json, csv, html) = (folder.path("r.json"), folder.path("r.csv"), folder.path("r.html"));
    let check = folder.file("bounds.json", bounds);
    let files = ["--json", &json, "--csv", &csv, "--html", &html, "--check", &check];
    let arguments = [&["report", "encode", "--quick"][..], &files].concat();
    expect(&arguments, 1, &["JPEG", "Pareto front", "at most 0"]);
    let text = |path: &str| std::fs::read_to_string(path).expect("the file");
    let report: serde_json::Value = serde_json::from_str(&text(&json)).expect("JSON");
    let results = report["results"].as_array().expect("results").len();
    assert!(results > 5 && report["machine"].is_string(), "{report}");
    assert_eq!(text(&csv).lines().count(), results + 1);
    assert!(text(&html).contains("<svg") && text(&html).ends_with("</html>\n"));
}

#[test]
fn render_writes_pictures_of_the_size_asked_for() {
    let folder = Folder::new("render");
    let scenario = folder.file("scenario.json", &clear_sky());
    let small = ["--size", "64x36", "--slices", "4", "--executor", "reference"];
    for name in ["sky.png", "sky.jpg", "sky.exr"] {
        let out = folder.path(name);
        expect(&[&["render", &scenario, "--at", "1", "--out", &out], &small[..]].concat(), 0, &["reference"]);
        let bytes = std::fs::read(&out).expect("the picture");
        assert!(bytes.len() > 200, "{name}: {} bytes", bytes.len());
        if name == "sky.png" {
            assert_eq!(bytes[16..24], [0, 0, 0, 64, 0, 0, 0, 36], "width and height in IHDR");
        }
    }
    let out = folder.path("deck.png");
    let deck = folder.file("deck.json", SCENARIO);
    expect(
        &[&["render", &deck, "--at", "1", "--out", &out, "--explain"], &small[..]].concat(),
        0,
        &["Cumulus", "4 slices"],
    );
    let out = folder.path("many.png");
    let sequence = ["render", &scenario, "--from", "0", "--to", "1", "--fps", "2", "--out", &out];
    expect(&[&sequence, &small[..]].concat(), 0, &[]);
    for number in 0..3 {
        assert!(Path::new(&folder.path(&format!("many-0000{number}.png"))).exists(), "picture {number}");
    }
    assert!(!Path::new(&folder.path("many-00003.png")).exists(), "no picture after the end");
}

#[test]
fn render_says_what_is_wrong() {
    let folder = Folder::new("render-wrong");
    let scenario = folder.file("scenario.json", SCENARIO);
    let out = folder.path("sky.png");
    let render = |rest: &[&'static str], code, says: &[&str]| {
        expect(&[&["render", &scenario, "--executor", "reference"], rest].concat(), code, says);
    };
    expect(&["render", "no-such-scenario", "--at", "0", "--out", &out], 2, &["no-such-scenario", "clear-day"]);
    render(&["--at", "99", "--out", "a.png"], 2, &["after the scenario's end at 10 s"]);
    render(&["--at", "0", "--out", "a.gif"], 2, &[".png, .jpg or .exr"]);
    render(&["--at", "NaN", "--out", "a.png"], 2, &["--at"]);
    render(&["--at", "0", "--out", "a.png", "--view", "tail"], 2, &["no such view", "main"]);
    render(&["--at", "0", "--out", "a.png", "--size", "9x9"], 2, &["16 to"]);
    render(&["--at", "0", "--size", "16x16", "--out", "/no/such/folder/a.png"], 1, &["cannot be written"]);
    render(&["--at", "0", "--explain"], 0, &["kept", "640 x 360"]);
}

/// The loader is told of a driver that is not there, so no machine has an adapter here.
#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_gpu_fails_with_advice_and_auto_goes_on() {
    let folder = Folder::new("no-adapter");
    let (scenario, out) = (folder.file("scenario.json", &clear_sky()), folder.path("sky.png"));
    let render = |executor: &str| {
        let arguments = ["render", &scenario, "--at", "0", "--size", "16x16", "--out", &out, "--executor", executor];
        run(stormdeck(&arguments)
            .env("VK_DRIVER_FILES", "/nonexistent.json")
            .env("VK_ICD_FILENAMES", "/nonexistent.json"))
    };
    let (code, text) = render("gpu");
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("deploy/install-vulkan") && text.contains("--executor reference"), "{text}");
    let (code, text) = render("auto");
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("reference") && text.contains("no graphics adapter"), "{text}");
}

#[test]
fn serve_refuses_a_wrong_file_and_a_taken_port() {
    let folder = Folder::new("serve-wrong");
    let settings = folder.file("settings.json", "{\"frame_rate_hz\": 1000, \"colour\": 1}");
    expect(&["serve", "--config", &settings], 2, &["frame_rate_hz", "colour"]);
    expect(&["serve", "--config", &folder.file("broken.json", "{")], 2, &["broken.json", "line 1"]);
    expect(&["serve", "--config", &folder.path("missing.json")], 2, &["cannot be read"]);
    expect(&["serve", "--scenario", "no-such-scenario", "--listen", "127.0.0.1:0"], 2, &["no-such-scenario"]);

    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("an address").to_string();
    expect(&["serve", "--listen", &address, "--executor", "reference"], 1, &[&address, "cannot be listened on"]);
}

#[test]
fn host_says_when_nobody_answers() {
    let free = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = free.local_addr().expect("an address").to_string();
    drop(free);
    expect(&["host", "clear-day", "--to", &address], 1, &["cannot connect"]);
    expect(&["host", "no-such-scenario", "--to", &address], 2, &["no-such-scenario"]);
}

/// A server that is killed when the test fails.
#[cfg(unix)]
struct Server {
    child: Child,
    address: String,
}

#[cfg(unix)]
impl Server {
    fn start(arguments: &[&str]) -> Self {
        let all = [&["serve", "--listen", "127.0.0.1:0", "--executor", "reference"], arguments].concat();
        let mut child = stormdeck(&all).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the binary");
        let mut lines = BufReader::new(child.stderr.take().expect("its log")).lines();
        let address = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| Some(line.split_once("http://")?.1.split('/').next()?.to_owned()))
            .expect("a line that says where it listens");
        // Somebody has to read on, or the server would stop at a full pipe.
        std::thread::spawn(move || lines.map_while(Result::ok).for_each(drop));
        Self { child, address }
    }

    /// Ends it by a signal and returns its exit code.
    fn stop(mut self, signal: &str) -> Option<i32> {
        let sent = Command::new("kill").args([signal, &self.child.id().to_string()]).status().expect("kill");
        assert!(sent.success());
        // The server ends within two seconds; the rest is for a busy machine. A server that hangs is the failure.
        let guard = Instant::now() + Duration::from_secs(10);
        while Instant::now() < guard {
            if let Some(status) = self.child.try_wait().expect("its status") {
                return status.code();
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("the server did not end after {signal}");
    }
}

#[cfg(unix)]
impl Drop for Server {
    fn drop(&mut self) {
        let _ended = self.child.kill();
        let _ended = self.child.wait();
    }
}

#[cfg(unix)]
#[test]
fn serve_starts_is_played_to_by_a_host_and_stops_by_a_signal() {
    let folder = Folder::new("serve");
    let scenario = folder.file("scenario.json", &clear_sky().replace(
        "\"entries\": [",
        "\"entries\": [{\"at\": 0, \"type\": \"view\", \"action\": \"change\", \"name\": \"main\", \"size_px\": [64, 36]},",
    ));
    for signal in ["-TERM", "-INT"] {
        let server = Server::start(&[]);
        // A free run after one in lockstep: what an earlier host left behind must not matter.
        for mode in ["--lockstep", "--format=png"] {
            let says = ["connected to stormdeck", "view main", "message to frame received: median"];
            let host = ["host", &scenario, "--to", &server.address, "--rate", "10", "--frames", "5", mode];
            expect(&host, 0, &says);
        }
        assert_eq!(server.stop(signal), Some(0), "{signal}");
    }
}

#[cfg(unix)]
#[test]
fn a_server_with_a_token_wants_it() {
    let server = Server::start(&["--token", "a-long-secret"]);
    let host = ["host", "clear-day", "--to", &server.address, "--frames", "1", "--rate", "10"];
    expect(&host, 1, &[]);
    expect(&[&host[..], &["--token", "a-long-secret"]].concat(), 0, &["connected"]);
    assert_eq!(server.stop("-TERM"), Some(0));
}

#[test]
fn a_cigi_message_becomes_json_and_comes_back() {
    let hex = "011803003d0000806400000020a107006300000000000000";
    let shown = stormdeck(&["cigi", "decode", hex]).output().expect("the binary");
    assert!(shown.status.success());
    let text = String::from_utf8(shown.stdout).expect("UTF-8");
    assert!(text.contains(r#""packet": "IG Control""#) && text.contains(r#""timestamp": 500000"#), "{text}");
    assert_eq!(run(&mut stormdeck(&["cigi", "encode", &text])), (0, format!("{hex}\n")));
    // Packets alone, in the other byte order; then what is wrong, and where.
    let alone = ["cigi", "decode", "1e10000000000003", "--version", "3.3", "--byte-order", "big"];
    let (code, text) = run(&mut stormdeck(&alone));
    assert!(code == 1 && text.contains("packet 30 at byte 0: size 16, but 8 bytes are left"), "{code} {text}");
    let (code, text) = run(&mut stormdeck(&["cigi", "decode", &hex[..46]]));
    assert!(code == 1 && text.contains("23 bytes: a message begins with a packet of 24 bytes"), "{code} {text}");
    assert_eq!(run(&mut stormdeck(&["cigi", "decode", "xyz"])).0, 2);
    assert_eq!(run(&mut stormdeck(&["cigi", "decode", hex, "--version", "3.3"])).0, 2);
    assert_eq!(run(&mut stormdeck(&["cigi", "encode", "{}"])).0, 2);
}
