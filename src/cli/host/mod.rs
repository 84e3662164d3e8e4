//! `stormdeck host`: a mock host plays a scenario to a running server as a simulator would, and checks what comes back.

mod part;
mod picture;
mod session;
mod spread;
mod watch;

use super::{Failure, scenario};
use crate::serve;
use crate::serve::client::ClientError;
use crate::wire::control::Format;
use std::time::{Duration, SystemTime};

/// Plays a scenario to a running server as a simulator host would, and checks what comes back.
///
/// Begins with an empty world at the server, sends each of the scenario's messages at its time and the ownship at a
/// steady rate, subscribes to the views, and ends with 1 when an answer or a frame is wrong or missing.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// A scenario file, or the name of a built-in scenario.
    scenario: String,
    /// Where the server is: HOST:PORT, or a whole ws:// address.
    #[arg(long, value_name = "ADDRESS")]
    to: String,
    /// The server's access token.
    #[arg(long)]
    token: Option<String>,
    /// Ownship messages (in lockstep: steps) per second of simulation.
    #[arg(long, value_name = "HZ", default_value_t = 60.0, value_parser = rate)]
    rate: f64,
    /// Steps the server's time and waits for the frames of each step, instead of running by the clock.
    #[arg(long)]
    lockstep: bool,
    /// Ends after so many ownship messages instead of at the scenario's end.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    frames: Option<u32>,
    /// Format of the pictures.
    #[arg(long, value_parser = format, default_value = "jpeg")]
    format: Format,
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(rate) if (0.1..=120.0).contains(&rate) => Ok(rate),
        _ => Err("a number of 0.1 to 120".to_owned()),
    }
}

fn format(text: &str) -> Result<Format, String> {
    match text {
        "raw" => Ok(Format::Raw),
        "png" => Ok(Format::Png),
        "jpeg" => Ok(Format::Jpeg),
        _ => Err("raw, png or jpeg".to_owned()),
    }
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        match error {
            ClientError::Address { .. } => Self::Input(error.to_string()),
            _ => Self::Run(error.to_string()),
        }
    }
}

/// Plays, checks, prints the summary.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let timeline = scenario::read(&options.scenario)?;
    let part = part::Part::new(timeline, options.rate, options.frames, first_host_frame())?;
    let watched = serve::block_on(session::play(options, part))
        .map_err(|error| Failure::Run(format!("cannot start the runtime: {error}")))??;
    let (summary, complaints) = watched.summary();
    println!("{summary}");
    match complaints {
        0 => Ok(()),
        _ => Err(Failure::Run(format!("{complaints} things were wrong"))),
    }
}

/// A number of this run's own: frames that the server drew for an earlier host do not look like ours.
fn first_host_frame() -> u32 {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    (since_1970.as_millis() & 0x3fff_ffff) as u32
}

/// How long the server may take to answer before the run is given up. A step may have to wait for tables that are built
/// once, on a slow machine.
const PATIENCE: Duration = Duration::from_secs(60);
