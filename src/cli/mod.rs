//! What was typed and what it means: one verb a file.
//!
//! Exit codes: 0 done, 1 the run failed, 2 the command line or a file is wrong.

mod bake;
mod bolt;
mod check;
mod cigi;
mod executor;
mod host;
mod progress;
mod render;
mod report;
mod scenario;
mod serve;
mod sheet;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// A headless visual-system server for flight simulators: draws the sky around the ownship and streams the pictures.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
struct CommandLine {
    #[command(subcommand)]
    verb: Option<Verb>,
    /// The options of `serve`, the default verb.
    #[command(flatten)]
    serve: serve::Options,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Serve(serve::Options),
    Render(render::Options),
    Bolt(bolt::Options),
    Bake(bake::Options),
    Check(check::Options),
    Host(host::Options),
    Report(report::Options),
    Cigi(cigi::Options),
    Sheet(sheet::Options),
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
    let CommandLine { verb, serve } = CommandLine::parse();
    let outcome = match verb.unwrap_or(Verb::Serve(serve)) {
        Verb::Serve(options) => serve::run(options),
        Verb::Render(options) => render::run(&options),
        Verb::Bolt(options) => bolt::run(&options),
        Verb::Bake(options) => bake::run(&options),
        Verb::Check(options) => check::run(&options),
        Verb::Host(options) => host::run(&options),
        Verb::Report(options) => report::run(&options),
        Verb::Cigi(options) => cigi::run(&options),
        Verb::Sheet(options) => sheet::run(&options),
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

    #[test]
    fn serve_is_the_default_verb_with_its_options() {
        let line = CommandLine::try_parse_from(["stormdeck", "--listen", "127.0.0.1:0"]).expect("options of serve");
        assert!(line.verb.is_none());
        assert!(CommandLine::try_parse_from(["stormdeck", "--listen", "127.0.0.1:0", "check", "a.json"]).is_err());
        let line = CommandLine::try_parse_from(["stormdeck", "check", "a.json"]).expect("a verb");
        assert!(matches!(line.verb, Some(Verb::Check(_))));
    }
}
