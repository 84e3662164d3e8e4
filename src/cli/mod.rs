//! What was typed and what it means: one verb a file.
//!
//! Exit codes: 0 done, 1 the run failed, 2 the command line or a file is wrong.

mod check;
mod executor;
mod host;
mod progress;
mod render;
mod scenario;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// A headless visual-system server for flight simulators: draws the sky around the ownship and streams the pictures.
#[derive(Debug, Parser)]
#[command(version)]
struct CommandLine {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Render(render::Options),
    Check(check::Options),
    Host(host::Options),
}

/// Why a verb did not do what was asked.
#[derive(Debug, thiserror::Error)]
enum Failure {
    /// The command line or a file is wrong: exit code 2.
    #[error("{0}")]
    Input(String),
    /// The run failed: exit code 1.
    #[error("{0}")]
    Run(String),
}

impl Failure {
    fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Run(_) => 1,
            Self::Input(_) => 2,
        })
    }
}

/// Does what the command line of this process asks for; the binary's whole work.
pub fn main() -> ExitCode {
    // clap prints its own complaints, and ends with 2 for a wrong command line and 0 for --help and --version.
    let CommandLine { verb } = CommandLine::parse();
    let outcome = match verb {
        Verb::Render(options) => render::run(&options),
        Verb::Check(options) => check::run(&options),
        Verb::Host(options) => host::run(&options),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("stormdeck: {failure}");
            failure.exit_code()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
