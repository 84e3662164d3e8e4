//! `stormdeck sheet`: many scenes in one labelled picture, to be looked at before a change of what is drawn is believed.

mod canvas;
mod font;
mod scenes;

use super::progress::Progress;
use super::{Failure, executor};
use crate::encode::{Format, encode_pixels};
use crate::frame::Pixels;
use crate::plan::executor::Executor;
use crate::plan::{Output, plan};
use crate::settings::{ExecutorChoice, TerrainChoice};
use canvas::Canvas;
use scenes::{SHEETS, Scene, Sheet};
use std::path::PathBuf;
use std::sync::Arc;

/// Most pixels of one sheet: its picture is held whole.
const MOST_PIXELS: u64 = 64 << 20;

/// Draws a contact sheet: scenes in labelled rows and columns, as one PNG file.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// Which sheet; `--list` shows what there is.
    #[arg(value_name = "SHEET", required_unless_present = "list")]
    sheet: Option<String>,
    /// The PNG file.
    #[arg(long, value_name = "FILE", required_unless_present = "list")]
    out: Option<PathBuf>,
    /// Width and height of one cell in pixels.
    #[arg(long, value_name = "WxH", value_parser = super::render::size, default_value = "256x144")]
    size: [u32; 2],
    /// Only rows whose label contains one of these words, separated by commas.
    #[arg(long, value_name = "WORDS", value_delimiter = ',')]
    rows: Vec<String>,
    /// Only columns whose label contains one of these words, separated by commas.
    #[arg(long, value_name = "WORDS", value_delimiter = ',')]
    columns: Vec<String>,
    /// Coverage of every layer instead of the sheet's own, 0 to 1.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    coverage: Option<f64>,
    /// What draws: gpu, reference, or auto (the GPU when there is one).
    #[arg(long, value_name = "E", value_parser = executor::choice, default_value = "auto")]
    executor: ExecutorChoice,
    /// Where the ground is: procedural, or ellipsoid (level everywhere).
    #[arg(long, value_name = "T", value_parser = super::render::terrain, default_value = "ellipsoid")]
    terrain: TerrainChoice,
    /// Shows the sheets with their rows and columns and ends.
    #[arg(long)]
    list: bool,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("a number of 0 to 1".to_owned()),
    }
}

/// Draws the sheet asked for.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let (Some(name), Some(out), false) = (&options.sheet, &options.out, options.list) else {
        for sheet in SHEETS {
            println!("{}: {}", sheet.name, sheet.about);
            println!("  rows: {}\n  columns: {}", (sheet.rows)().join(", "), (sheet.columns)().join(", "));
        }
        return Ok(());
    };
    let sheet = SHEETS.iter().find(|sheet| sheet.name == name).ok_or_else(|| {
        let names: Vec<&str> = SHEETS.iter().map(|sheet| sheet.name).collect();
        Failure::Input(format!("no sheet `{name}`; there are: {}", names.join(", ")))
    })?;
    let rows = chosen("row", (sheet.rows)(), &options.rows)?;
    let columns = chosen("column", (sheet.columns)(), &options.columns)?;
    let labels = |chosen: &[(usize, String)]| chosen.iter().map(|(_, label)| label.clone()).collect::<Vec<_>>();
    let mut canvas = Canvas::new(options.size, &labels(&rows), &labels(&columns), MOST_PIXELS)
        .ok_or_else(|| Failure::Input(format!("the sheet would have more than {MOST_PIXELS} pixels")))?;
    let (mut executor, why) = executor::make(options.executor, &Arc::default())?;
    eprintln!("drawn by {why}");

    let progress = Progress::new("sheet", rows.len() * columns.len());
    let mut done = 0;
    for (y, (row, _)) in rows.iter().enumerate() {
        for (x, (column, _)) in columns.iter().enumerate() {
            let pixels = cell(executor.as_mut(), sheet, [*row, *column], options)?;
            canvas.paste([x, y], &pixels);
            done += 1;
            progress.show(done);
        }
    }
    let ([width, height], pixels) = canvas.finish();
    let wrong = |why: String| Failure::Run(format!("{}: {why}", out.display()));
    let bytes = encode_pixels(&pixels, width, height, Format::Png).map_err(|error| wrong(error.to_string()))?;
    std::fs::write(out, bytes).map_err(|error| wrong(format!("cannot be written: {error}")))
}

/// One cell's picture.
fn cell(
    executor: &mut dyn Executor,
    sheet: &Sheet,
    [row, column]: [usize; 2],
    options: &Options,
) -> Result<Vec<u8>, Failure> {
    let mut scene: Scene = (sheet.scene)(row, column);
    for layer in &mut scene.layers {
        layer.coverage = options.coverage.unwrap_or(layer.coverage);
    }
    let snapshot =
        scene.snapshot(options.size, options.terrain.terrain()).map_err(|refused| Failure::Run(refused.to_string()))?;
    let view = snapshot.views.first().ok_or_else(|| Failure::Run("the scene has no view".to_owned()))?;
    executor.submit(0, &plan(&snapshot, view, Output::Srgb8))?;
    let finished = executor.collect(true)?;
    match finished.into_iter().next().map(|finished| finished.pixels) {
        Some(Pixels::Srgb8(pixels)) => Ok(pixels),
        _ => Err(Failure::Run("the executor lost a picture".to_owned())),
    }
}

/// Indices and labels of those that contain one of the words, whatever their case; all without words.
fn chosen(what: &str, labels: Vec<String>, words: &[String]) -> Result<Vec<(usize, String)>, Failure> {
    let fits = |label: &str| {
        words.is_empty() || words.iter().any(|word| label.to_lowercase().contains(&word.trim().to_lowercase()))
    };
    let all = labels.join(", ");
    let found: Vec<(usize, String)> = labels.into_iter().enumerate().filter(|(_, label)| fits(label)).collect();
    if found.is_empty() {
        return Err(Failure::Input(format!("no {what} is called so; there are: {all}")));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::terrain::Terrain;

    #[test]
    fn rows_are_chosen_by_a_part_of_their_label() {
        let labels = || ["Cumulus", "Altocumulus", "Stratus"].map(str::to_owned).to_vec();
        let indices = |words: &[&str]| {
            let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
            chosen("row", labels(), &words).map(|c| c.iter().map(|(i, _)| *i).collect::<Vec<_>>()).ok()
        };
        assert_eq!(indices(&[]), Some(vec![0, 1, 2]));
        assert_eq!(indices(&["cumulus"]), Some(vec![0, 1]));
        assert_eq!(indices(&["strat", "ALTO"]), Some(vec![1, 2]));
        assert_eq!(indices(&["nimbus"]), None);
    }

    #[test]
    fn every_scene_of_every_sheet_is_accepted_by_the_world() {
        for sheet in SHEETS {
            for row in 0..(sheet.rows)().len() {
                for column in 0..(sheet.columns)().len() {
                    let snapshot = (sheet.scene)(row, column).snapshot([32, 18], Terrain::ELLIPSOID);
                    assert!(snapshot.is_ok(), "{}, {row}, {column}: {:?}", sheet.name, snapshot.err());
                }
            }
        }
    }
}
