//! Fuzzing of every decoder: bytes that nobody thought of never panic, hang or take memory out of proportion.
//!
//! An equivalent of cargo-fuzz that needs no other compiler: inputs are bent at random from a corpus, and one that is answered
//! in a way not seen before (another packet, another complaint) joins the corpus for the run. Without a word each target runs
//! a fixed number of inputs from a fixed seed. `FUZZ_SECONDS=600 cargo test --release --test fuzz cigi -- --nocapture` runs
//! one target for so long from a seed of its own, and prints executions and seconds.

#[path = "fuzz/heights.rs"]
mod heights;
#[path = "../src/wire/heights/tests/maker.rs"]
mod maker;
#[path = "fuzz/mutate.rs"]
mod mutate;
#[path = "fuzz/targets.rs"]
mod targets;

use mutate::Mutator;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};
use targets::Target;

/// Inputs kept for having been answered in a new way.
const KEPT: usize = 4_096;
/// Longest answer to one input: a guard against what never ends, far beyond what any takes.
const LONGEST: Duration = Duration::from_secs(10);

fn run(target: &Target) {
    let seconds: Option<f64> =
        std::env::var("FUZZ_SECONDS").ok().map(|text| text.parse().expect("FUZZ_SECONDS: a number"));
    let seed = if seconds.is_some() { u64::from(std::process::id()) << 20 | 1 } else { 1 };
    let mut mutator = Mutator::new(seed);
    let mut corpus = (target.corpus)();
    assert!(!corpus.is_empty(), "a corpus to begin with");
    let mut answers = BTreeSet::new();
    for input in &corpus {
        answers.insert((target.answer)(input));
    }
    let (began, known) = (Instant::now(), corpus.len());
    let mut executions = 0_u64;
    let goes_on = |executions: u64| match seconds {
        Some(seconds) => began.elapsed().as_secs_f64() < seconds,
        None => executions < target.inputs,
    };
    while goes_on(executions) {
        let input = mutator.bend(&corpus, target.longest);
        let asked = Instant::now();
        // What panics here is printed by the guard below, so that it can be kept.
        let guard = PrintIfPanics { target: target.name, seed, input: &input };
        let answer = (target.answer)(&input);
        std::mem::forget(guard);
        executions += 1;
        assert!(asked.elapsed() < LONGEST, "{}: no end with {:02x?}", target.name, input);
        if answers.len() < KEPT && answers.insert(answer) {
            corpus.push(input);
        }
    }
    let took_s = began.elapsed().as_secs_f64();
    println!(
        "{}: {executions} executions in {took_s:.1} s, seed {seed}; corpus {known} to {}, {} kinds of answers",
        target.name,
        corpus.len(),
        answers.len()
    );
    assert!(corpus.len() > known, "{}: bent inputs find nothing new: the fuzzer does not work", target.name);
}

/// Prints the input when the answer panics.
struct PrintIfPanics<'a> {
    target: &'a str,
    seed: u64,
    input: &'a [u8],
}

impl Drop for PrintIfPanics<'_> {
    fn drop(&mut self) {
        let hex: String = self.input.iter().map(|byte| format!("{byte:02x}")).collect();
        eprintln!("{} panics (seed {}) with {hex}", self.target, self.seed);
    }
}

#[test]
fn cigi_messages() {
    run(&targets::CIGI_MESSAGES);
}

#[test]
fn cigi_scene() {
    run(&targets::CIGI_SCENE);
}

#[test]
fn cigi_scene_over_mountains() {
    run(&targets::CIGI_TERRAIN);
}

#[test]
fn cigi_json() {
    run(&targets::CIGI_JSON);
}

#[test]
fn control_messages() {
    run(&targets::CONTROL);
}

#[test]
fn scenario_files() {
    run(&targets::SCENARIO);
}

#[test]
fn settings_files() {
    run(&targets::SETTINGS);
}

#[test]
fn frame_messages() {
    run(&targets::FRAMES);
}

#[test]
fn bounds_files() {
    run(&targets::BOUNDS);
}

#[test]
fn basis_files() {
    run(&targets::BASIS);
}

#[test]
fn geotiff_height_files() {
    run(&heights::GEOTIFF);
}

#[test]
fn hgt_height_files() {
    run(&heights::HGT);
}
