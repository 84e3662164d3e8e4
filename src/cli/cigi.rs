//! `stormdeck cigi decode` and `encode`: any CIGI message as JSON, and back.

use super::Failure;
use super::scenario::text_of;
use crate::wire::cigi::{ByteOrder, Version, decode, decode_packets, json, message};
use crate::wire::limits;
use std::io::Read as _;
use std::path::Path;

/// Shows CIGI messages as JSON, and makes them from JSON.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, clap::Subcommand)]
enum Task {
    /// Prints a message as JSON. Ends with 1 if it was rejected; the JSON then says why.
    Decode {
        /// The bytes as hexadecimal digits, with or without spaces; `-` reads them from standard input.
        #[arg(value_name = "HEX")]
        hex: String,
        /// With a byte order: HEX is packets alone, which need not begin with an IG Control or a Start of Frame.
        #[arg(long, requires = "byte_order", value_parser = ["3.3", "4.0"])]
        version: Option<String>,
        /// With a version: byte order of the packets.
        #[arg(long, requires = "version", value_parser = ["little", "big"])]
        byte_order: Option<String>,
    },
    /// Prints the bytes of a message that is given as JSON, as hexadecimal digits.
    Encode {
        /// The JSON that `decode` prints; fields that are not given have their defaults. Also the name of a file with it, or
        /// `-` for standard input.
        #[arg(value_name = "JSON")]
        json: String,
    },
}

/// Longest text that is read: three characters a byte for HEX, and room for names in JSON.
const TEXT_BYTES: usize = 256 * limits::CIGI_MESSAGE_BYTES;

/// Decodes or encodes one message.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    match &options.task {
        Task::Decode { hex, version, byte_order } => {
            let version = Version::ALL.into_iter().find(|one| version.as_deref() == Some(one.name()));
            let byte_order = ByteOrder::ALL.into_iter().find(|one| byte_order.as_deref() == Some(one.name()));
            let text = if hex == "-" { standard_input()? } else { hex.clone() };
            let Some(bytes) = json::from_hex(&text) else {
                let limit = limits::CIGI_MESSAGE_BYTES;
                return Err(Failure::Input(format!(
                    "HEX: not pairs of hexadecimal digits, or more than {limit} bytes"
                )));
            };
            show(&bytes, version.zip(byte_order))
        }
        Task::Encode { json: given } => {
            let text = match given.trim_start() {
                "-" => standard_input()?,
                text if text.starts_with(['{', '[']) => given.clone(),
                _ => text_of(Path::new(given), TEXT_BYTES)?,
            };
            let bytes = json::encode_json(&text).map_err(|wrong| Failure::Input(wrong.to_string()))?;
            println!("{}", json::to_hex(&bytes));
            Ok(())
        }
    }
}

fn show(bytes: &[u8], alone: Option<(Version, ByteOrder)>) -> Result<(), Failure> {
    let decoded = match alone {
        Some((version, byte_order)) => decode_packets(bytes, version, byte_order),
        None => decode(bytes),
    };
    match decoded {
        Ok(message) => {
            println!("{:#}", json::show(&message, bytes));
            Ok(())
        }
        Err(rejected) => {
            let opens = || message::opening(bytes).ok().map(|opening| (opening.version, opening.byte_order));
            println!("{:#}", json::show_rejected(alone.or_else(opens), &rejected.to_string()));
            Err(Failure::Run(format!("rejected: {rejected}")))
        }
    }
}

fn standard_input() -> Result<String, Failure> {
    let mut text = String::new();
    let most = TEXT_BYTES as u64 + 1;
    std::io::stdin()
        .take(most)
        .read_to_string(&mut text)
        .map_err(|error| Failure::Input(format!("standard input: {error}")))?;
    if text.len() > TEXT_BYTES {
        return Err(Failure::Input(format!("standard input: more than {TEXT_BYTES} bytes")));
    }
    Ok(text)
}
