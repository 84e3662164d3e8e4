//! The thunder of a bolt as a WAV file.

use super::super::Failure;
use crate::lightning::flash::{Flash, FlashKind, Polarity};
use crate::lightning::shape::Line;
use crate::lightning::thunder::air::Air;
use crate::lightning::thunder::{Chord, Path, chords, pulses, wave};
use std::path::Path as FilePath;

/// Samples a second: thunder has next to nothing above 5 kHz.
const RATE_HZ: u32 = 22_050;
/// Greatest sample, of the largest that the format has.
const FULL: f32 = 0.89;

/// Writes what a listener hears of a flash along these lines (metres, the third axis up, 0 the ground), 16 bit, as loud as the
/// format allows, and says on standard output when and how loud it is.
///
/// The first stroke runs through all lines, later ones through those of order 0.
///
/// # Errors
/// [`Failure::Run`] when the listener is too far away to hear anything, or the file cannot be written.
pub(super) fn write(
    file: &FilePath,
    lines: &[Line],
    listener_m: [f64; 3],
    peak_current_ka: f64,
    seed: u64,
) -> Result<(), Failure> {
    let air = Air::default();
    let flash = Flash::sample(FlashKind::CloudToGround, Polarity::Negative, Some(peak_current_ka), false, seed);
    let [tree, main] = [u32::MAX, 0].map(|most| chords(&paths(lines, most)));
    let of_stroke = |opens: bool| -> &[Chord] { if opens { &tree } else { &main } };
    let heard: Vec<_> = flash
        .strokes
        .iter()
        .flat_map(|stroke| pulses(of_stroke(stroke.opens), stroke.delay_s, stroke.peak_current_ka, listener_m, &air))
        .collect();
    let Some(loudest) = heard.iter().max_by(|a, b| a.level_db.total_cmp(&b.level_db)) else {
        return Err(Failure::Run("--listener: too far away to hear any thunder (25 km)".to_owned()));
    };
    let sound = wave::wave(&heard, &air, RATE_HZ);
    let greatest = sound.pressure_pa.iter().fold(f32::MIN_POSITIVE, |most, p| most.max(p.abs()));
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: RATE_HZ,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let failed = |error: hound::Error| Failure::Run(format!("{}: cannot be written: {error}", file.display()));
    let mut writer = hound::WavWriter::create(file, spec).map_err(failed)?;
    for pressure in &sound.pressure_pa {
        let sample = FULL * f32::from(i16::MAX) * pressure / greatest;
        writer.write_sample(sample.round() as i16).map_err(failed)?;
    }
    writer.finalize().map_err(failed)?;
    let first_s = heard.iter().map(|pulse| pulse.arrival_s).fold(f64::INFINITY, f64::min);
    println!(
        "thunder      {} strokes, heard from {first_s:.2} s on for {:.1} s, loudest piece {:.0} dB at {:.0} m, full scale {:.2} Pa",
        flash.strokes.len(),
        sound.pressure_pa.len() as f64 / f64::from(RATE_HZ),
        loudest.level_db,
        loudest.distance_m,
        greatest / FULL,
    );
    Ok(())
}

/// Lines up to an order as paths; a side channel has the current of its mean brightness.
fn paths(lines: &[Line], most_order: u32) -> Vec<Path> {
    let share = |line: &Line| line.points.iter().map(|point| point.brightness).sum::<f64>() / line.points.len() as f64;
    let path = |line: &Line| Path { points_m: line.points.iter().map(|p| p.position_m).collect(), share: share(line) };
    lines.iter().filter(|line| line.order <= most_order).map(path).collect()
}
