//! What the verb makes of what is typed: scenes, refusals, the documented JSON.

use super::*;
use clap::Parser;

#[derive(clap::Parser)]
struct Line {
    #[command(flatten)]
    options: Options,
}

fn options(arguments: &str) -> Options {
    Line::try_parse_from(std::iter::once("bolt").chain(arguments.split_whitespace())).expect("right options").options
}

#[test]
fn every_field_of_the_json_is_documented() {
    let options = options("--grid 24x24 --seed 5 --eta 2 --rho 3");
    let scene = scene(&options).expect("a right scene");
    let drawn = grown(method(options.method, &options), &scene, &options).expect("a bolt");
    let text = json::text(&drawn, &scene, 5, 10.0).expect("JSON");
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let page = include_str!("../../../protocol/bolt.md");
    let node = &value["nodes"][1];
    let keys = value.as_object().expect("an object").keys().chain(node.as_object().expect("an object").keys());
    for key in keys {
        assert!(page.contains(&format!("| `{key}` |")), "{key} is not in protocol/bolt.md");
    }
    assert_eq!(
        (&value["method"], &value["grid"][1], &value["reached"]),
        (&"rational".into(), &24.into(), &true.into())
    );
    assert_eq!(value["nodes"][0]["parent"], serde_json::Value::Null);
    let cells = value["cells"].as_u64().expect("a number");
    assert_eq!(value["nodes"].as_array().expect("nodes").len() as u64, cells + 1);
}

#[test]
fn scenes_are_what_was_typed_and_the_rest_is_refused() {
    let typed =
        options("--grid 16x16x16 --target 3,4,5 --target 1,2,3 --goal chain --start 8,8,15 --wall 2,2,2:3,3,2 --faces");
    let found = scene(&typed).expect("a right scene");
    assert_eq!((found.targets().len(), found.obstacles.len(), found.start), (2, 4, found.grid.cell([8, 8, 15])));
    for wrong in [
        "--grid 16",
        "--grid 0x4",
        "--grid 9000x2",
        "--start 1",
        "--wall 3,3",
        "--height-m nan",
        "--cells 0",
        "--compare",
        "--thunder a.wav --listener 1,2",
        "--thunder a.wav --listener 1,2,-3",
        "--thunder a.wav --listener nan,0,0",
        "--thunder a.wav --peak-current-ka 0",
        "--listener 1,2,3",
    ] {
        assert!(Line::try_parse_from(std::iter::once("bolt").chain(wrong.split_whitespace())).is_err(), "{wrong}");
    }
    assert!(matches!(scene(&options("--grid 16x16 --target 16,0")), Err(Failure::Input(_))));
    assert!(matches!(run(&options("--grid 16x16 --rho 99")), Err(Failure::Input(_))));
    assert!(matches!(run(&options("--method reed-wyvill --grid 16x16 --wall 1,1:2,2")), Err(Failure::Input(_))));
}

#[test]
fn the_thunder_of_a_bolt_is_a_wav_that_begins_when_sound_has_come() {
    let path = std::env::temp_dir().join(format!("stormdeck-thunder-{}.wav", std::process::id()));
    let file = path.to_str().expect("a path in Unicode");
    run(&options(&format!("--grid 32x32x32 --seed 5 --thunder {file} --listener 800,-600,0"))).expect("a sound");
    let mut read = hound::WavReader::open(&path).expect("a WAV file");
    assert_eq!((read.spec().channels, read.spec().bits_per_sample), (1, 16));
    let samples: Vec<i16> = read.samples().collect::<Result<_, _>>().expect("samples");
    let greatest = samples.iter().map(|sample| sample.unsigned_abs()).max().expect("samples");
    assert!(samples.len() > 22_050 && (29_000..29_300).contains(&greatest), "{} {greatest}", samples.len());
    std::fs::remove_file(&path).expect("its own file");
    let deaf = run(&options(&format!("--grid 16x16 --thunder {file} --listener 60000,0,0")));
    assert!(matches!(deaf, Err(Failure::Run(_))) && !path.exists());
}
