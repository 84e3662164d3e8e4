//! `stormdeck serve`: settings from a file, flags over them, then the server until Ctrl-C or SIGTERM.

use super::scenario::text_of;
use super::{Failure, executor};
use crate::serve::{self, ServeError};
use crate::settings::{DEFAULT_TEXT, ExecutorChoice, Settings};
use crate::wire::limits;
use serde_json::{Map, Value};
use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use tracing_subscriber::EnvFilter;

/// Runs the server (the default verb).
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// Settings file (JSON); without it the settings of config/default.json hold. Flags override it.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Address and port to listen on; port 0 takes any free one. Beyond this machine only with a token.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: Option<SocketAddr>,
    /// What draws: gpu, reference, or auto (the GPU when there is one).
    #[arg(long, value_name = "E", value_parser = executor::choice)]
    executor: Option<ExecutorChoice>,
    /// Scenario to start with: the name of one, or a file.
    #[arg(long, value_name = "SCENARIO")]
    scenario: Option<String>,
    /// What every client has to show. Other users of this machine can see a command line: a settings file is safer.
    #[arg(long)]
    token: Option<String>,
    /// Frames a second while running free.
    #[arg(long, value_name = "HZ")]
    frame_rate: Option<f64>,
    /// Slices per cloud layer.
    #[arg(long, value_name = "N")]
    slices: Option<u32>,
    /// Quality of JPEGs where nobody asks for another.
    #[arg(long, value_name = "Q")]
    jpeg_quality: Option<u8>,
    /// Most WebSocket clients at once.
    #[arg(long, value_name = "N")]
    max_clients: Option<u32>,
    /// Lets a client take the host role from another.
    #[arg(long)]
    allow_take_over: bool,
    /// What is logged, as `tracing` filters say it: info, stormdeck=debug.
    #[arg(long, value_name = "FILTER")]
    log: Option<String>,
}

/// Serves until a signal.
pub(super) fn run(options: Options) -> Result<(), Failure> {
    let settings = settings(options)?;
    start_log(&settings.log)?;
    if let Some(name) = &settings.scenario {
        settings.timeline(name).map_err(|refused| Failure::Input(refused.to_string()))?;
    }
    let choice = settings.executor;
    // They outlive a device that is lost.
    let tables = executor::tables(settings.basis_cache.as_deref(), settings.basis_cache_mib)?;
    let factory = Box::new(move || {
        let (executor, why) = executor::make(choice, &tables)?;
        tracing::info!("drawn by {why}");
        Ok(executor)
    });
    serve::run_until_signal(settings, factory).map_err(Failure::from)
}

impl From<ServeError> for Failure {
    fn from(error: ServeError) -> Self {
        match error {
            ServeError::Scenario(_) | ServeError::Ground(_) => Self::Input(error.to_string()),
            _ => Self::Run(error.to_string()),
        }
    }
}

/// The settings of the file, or the usual ones, with the flags over them.
fn settings(options: Options) -> Result<Settings, Failure> {
    let (name, text) = match &options.config {
        Some(path) => (path.display().to_string(), text_of(path, limits::SETTINGS_BYTES)?),
        None => ("config/default.json".to_owned(), DEFAULT_TEXT.to_owned()),
    };
    overlaid(&name, &text, flags(&options))
}

/// A file's settings with other values for some fields; complaints about both, the file's with their lines.
fn overlaid(name: &str, text: &str, flags: Map<String, Value>) -> Result<Settings, Failure> {
    // Whether a token is needed depends on the address, so it is judged when both are known.
    let is_flag = |path: &str| flags.contains_key(path) || path == "token";
    let in_file = Settings::parse(text).err().unwrap_or_default();
    let in_file = in_file.iter().filter(|complaint| !is_flag(&complaint.path)).map(|c| format!("{name}: {c}"));
    let mut complaints: Vec<String> = in_file.collect();
    if let Ok(Value::Object(mut fields)) = serde_json::from_str(text) {
        fields.extend(flags.clone());
        match Settings::parse(&Value::Object(fields).to_string()) {
            Ok(settings) if complaints.is_empty() => return Ok(settings),
            Ok(_) => {}
            Err(together) => {
                let by_flags = together.iter().filter(|complaint| is_flag(&complaint.path));
                complaints.extend(by_flags.map(|c| format!("--{}: {}", c.path.replace('_', "-"), c.why)));
            }
        }
    }
    Err(Failure::Input(complaints.join("\n")))
}

/// The flags as fields of a settings file: what they may be is checked as there.
fn flags(options: &Options) -> Map<String, Value> {
    let mut fields = Map::new();
    let mut set = |name: &str, value: Option<Value>| {
        if let Some(value) = value {
            fields.insert(name.to_owned(), value);
        }
    };
    set("listen", options.listen.map(|address| address.to_string().into()));
    set("executor", options.executor.map(|choice| serde_json::to_value(choice).unwrap_or_default()));
    set("token", options.token.clone().map(Into::into));
    set("frame_rate_hz", options.frame_rate.map(Into::into));
    set("slices", options.slices.map(Into::into));
    set("jpeg_quality", options.jpeg_quality.map(Into::into));
    set("max_clients", options.max_clients.map(Into::into));
    set("allow_take_over", options.allow_take_over.then_some(true.into()));
    set("log", options.log.clone().map(Into::into));
    if let Some(scenario) = &options.scenario {
        let path = Path::new(scenario);
        let is_file = scenario.contains(['/', '\\']) || scenario.ends_with(".json");
        let name = if is_file { path.file_stem().unwrap_or_default().to_string_lossy() } else { scenario.into() };
        set("scenario", Some(name.into()));
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        set("scenario_folder", is_file.then(|| parent.to_string_lossy().into()));
    }
    fields
}

/// One line on stderr for each thing an operator wants to know; in colour on a terminal alone.
fn start_log(filter: &str) -> Result<(), Failure> {
    let filter = EnvFilter::try_new(filter).map_err(|error| Failure::Input(format!("log = {filter}: {error}")))?;
    let colours = std::io::stderr().is_terminal();
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colours).init();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        options: Options,
    }

    fn with(arguments: &[&str], text: &str) -> Result<Settings, String> {
        let line = Line::try_parse_from([&["serve"], arguments].concat()).expect("known flags");
        overlaid("a.json", text, flags(&line.options)).map_err(|failure| failure.to_string())
    }

    #[test]
    fn flags_override_the_file_and_are_checked_like_it() {
        let settings =
            with(&["--frame-rate", "12", "--scenario", "some/where/storm.json"], "{\"slices\": 7}").expect("right");
        assert_eq!((settings.frame_rate_hz, settings.slices), (12.0, 7));
        assert_eq!(
            (settings.scenario.as_deref(), settings.scenario_folder.to_str()),
            (Some("storm"), Some("some/where"))
        );
        let settings = with(&["--scenario", "clear-day", "--executor", "reference"], "{}").expect("right");
        assert_eq!(settings.scenario.as_deref(), Some("clear-day"));
        assert_eq!(settings.executor, ExecutorChoice::Reference);
        assert_eq!(settings.scenario_folder, Settings::default().scenario_folder);
    }

    #[test]
    fn everything_wrong_in_file_and_flags_is_told() {
        let told = with(&["--slices", "9999"], "{\"frame_rate_hz\": -1,\n\"colour\": 1}").expect_err("wrong");
        for word in ["a.json: line 1", "frame_rate_hz", "a.json: line 2", "colour", "--slices"] {
            assert!(told.contains(word), "{word}: {told}");
        }
        assert!(with(&[], "{").expect_err("wrong").contains("line 1"));
        assert!(with(&["--slices", "4"], "{\"slices\": 0}").is_ok(), "the flag takes the place of the file's value");
    }

    #[test]
    fn a_public_address_needs_a_token_wherever_the_two_come_from() {
        let public = "{\"listen\": \"0.0.0.0:1\"}";
        assert!(with(&[], public).expect_err("open").contains("token"));
        assert!(with(&["--token", "long-enough"], public).is_ok());
        assert!(with(&["--listen", "127.0.0.1:0"], public).is_ok());
        assert!(with(&["--listen", "0.0.0.0:1"], "{\"token\": \"long-enough\"}").is_ok());
    }
}
