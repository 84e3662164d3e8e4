//! GPU against twin, pass by pass, and what must fail: a wrong shader, a lost device.
//!
//! The comparison is of linear light. Both executors compute in f32 from the same bytes; the GPU's target is f16, which
//! rounds each blended value by 2^-11 = 0.05 %, and its sampler may weigh texels with 8 bits (a 256th of the difference
//! between neighbours).

use super::GpuExecutor;
use super::pipelines::{Pipelines, shaders};
use crate::frame::Pixels;
use crate::passes::ground::Ground;
use crate::passes::light::encoding::Encoding;
use crate::plan::executor::{Executor, Fault};
use crate::plan::{FramePlan, Output};
use crate::reference::ReferenceExecutor;
use crate::world::snapshot::DeckForm;
use scene::{BELOW, CITY, LOW_OVER_A_CITY, MOUNTAINS, Scene};
use std::collections::HashMap;

mod relight;
mod scene;
mod strokes;

fn gpu() -> GpuExecutor {
    GpuExecutor::new().expect("deploy/install-vulkan installs a software adapter")
}

fn draw(executor: &mut dyn Executor, plan: &FramePlan) -> Pixels {
    executor.submit(1, plan).expect("submitted");
    let mut finished = executor.collect(true).expect("drawn");
    assert_eq!(finished.len(), 1);
    finished.remove(0).pixels
}

/// Mean difference and the share of values that differ by more than `apart`, both of the picture's mean light.
fn difference(a: &Pixels, b: &Pixels, apart: f32) -> (f32, f32, f32) {
    let (Pixels::LinearRgb(a), Pixels::LinearRgb(b)) = (a, b) else { panic!("linear pictures are compared") };
    assert_eq!(a.len(), b.len());
    let mean = b.iter().sum::<f32>() / b.len() as f32;
    let differences: Vec<f32> = a.iter().zip(b).map(|(a, b)| (a - b).abs() / mean).collect();
    let largest = differences.iter().fold(0.0f32, |a, b| a.max(*b));
    let beyond = differences.iter().filter(|d| **d > apart).count() as f32 / differences.len() as f32;
    (differences.iter().sum::<f32>() / differences.len() as f32, largest, beyond)
}

fn compare(name: &str, gpu: &mut GpuExecutor, scene: Scene) -> (f32, f32) {
    let plan = scene.plan(Output::LinearRgb);
    let (drawn, twin) = (draw(gpu, &plan), draw(&mut ReferenceExecutor::new(), &plan));
    let (mean, largest, beyond) = difference(&drawn, &twin, 0.05);
    println!(
        "{name}: mean {:.4} %, largest {:.2} %, beyond 5 %: {:.3} %",
        100.0 * mean,
        100.0 * largest,
        100.0 * beyond
    );
    (mean, beyond)
}

#[test]
fn the_metric_has_hand_computed_values() {
    let (a, b) = (Pixels::LinearRgb(vec![1.0, 2.0, 3.0]), Pixels::LinearRgb(vec![1.0, 2.0, 6.0]));
    // Mean of b is 3; the only difference is 3 of 3 values: mean 1/3, largest 1, one value of three beyond a half.
    assert_eq!(difference(&a, &b, 0.5), (1.0 / 3.0, 1.0, 1.0 / 3.0));
    assert_eq!(difference(&b, &b, 0.0), (0.0, 0.0, 0.0));
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn sky_and_ground_equal_their_twins() {
    let mut gpu = gpu();
    for (name, pitch_deg, altitude_m) in [("sky", 3.0, 9000.0), ("ground", -50.0, 3000.0), ("horizon", 0.0, 9000.0)] {
        let (mean, beyond) = compare(name, &mut gpu, Scene { coverage: 0.0, altitude_m, pitch_deg, ..BELOW });
        // f16 rounds by 0.05 %, the sampler's 8-bit weights add a few times that where the table or the map is steep.
        assert!(mean < 0.003, "{name}: {mean}");
        // The sun's rim, the coastline and the edges of fields are steps, and fields are bent by the map, so that single pixels fall
        // on the other side: at half a field a pixel 0.4 % did.
        assert!(beyond < 0.008, "{name}: {beyond}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn terrain_equals_its_twin_and_hides_what_is_behind() {
    let mut gpu = gpu();
    let scenes = [
        ("mountains", Scene { coverage: 0.0, ..MOUNTAINS }),
        ("clouds among mountains", MOUNTAINS),
        ("the same at half size", Scene { deck_scale: 2, ..MOUNTAINS }),
        ("a coast", Scene { latitude_deg: 43.65, longitude_deg: 6.95, altitude_m: 1_600.0, ..MOUNTAINS }),
        ("from 60 km", Scene { altitude_m: 60_000.0, pitch_deg: -40.0, ..MOUNTAINS }),
    ];
    for (name, scene) in scenes {
        let plan = scene.plan(Output::LinearRgb);
        assert!(plan.terrain(), "{name}");
        let (mean, beyond) = compare(name, &mut gpu, scene);
        // Rays that graze a crest meet it or pass by as the last bit falls, and a step's length follows from the one before:
        // single pixels at silhouettes, and what the deck's and the shadows' own comparisons have.
        assert!(mean < 0.006, "{name}: {mean}");
        assert!(beyond < 0.02, "{name}: {beyond}");
        let flat = FramePlan { relief: None, ..plan.clone() };
        let (mean, ..) = difference(&draw(&mut gpu, &plan), &draw(&mut gpu, &flat), 0.05);
        assert!(mean > 0.05, "{name}: there is relief to compare: {mean}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn light_of_hills_clouds_and_lamps_on_the_ground_equals_its_twin() {
    let mut gpu = gpu();
    let hills = Scene { coverage: 0.0, low_sun: true, ..MOUNTAINS };
    let glow = Scene { coverage: 1.0, ..LOW_OVER_A_CITY };
    let own = Scene { own_lights: true, ..LOW_OVER_A_CITY };
    type Without = fn(&mut Ground);
    let scenes: [(&str, Scene, Without); 3] = [
        ("shadows of hills", hills, |ground| ground.hills = 0),
        ("glow on the ground", glow, |ground| ground.glow_lux = 0.0),
        ("the own ship's lights on the ground", own, |ground| ground.lamps = 0),
    ];
    for (name, scene, without) in scenes {
        let (mean, beyond) = compare(name, &mut gpu, scene);
        // As for ground with heights and with lamps.
        assert!(mean < 0.01 && beyond < 0.06, "{name}: {mean} {beyond}");
        let plan = scene.plan(Output::LinearRgb);
        let mut plain = plan.clone();
        without(plain.ground.as_mut().expect("ground is in sight"));
        let (mean, ..) = difference(&draw(&mut gpu, &plain), &draw(&mut gpu, &plan), 0.05);
        assert!(mean > 0.01, "{name}: there is something to compare: {mean}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn shadows_on_the_ground_equal_their_twins() {
    let mut gpu = gpu();
    let down = Scene { pitch_deg: -35.0, altitude_m: 900.0, ..BELOW };
    let seam = (0..360).map(|i| Scene { longitude_deg: f64::from(i) - 180.0, ..down });
    let sunlit = |plan: &FramePlan| plan.ground.is_some_and(|g| g.light_lux[1] * g.light_direction[2] > 3e4);
    let meets = |plan: &FramePlan| plan.layers[0].layer.charts > 1 && sunlit(plan);
    let seam = seam.clone().find(|s| meets(&s.plan(Output::LinearRgb))).expect("a seam by day");
    let scenes = [
        ("below", down),
        ("coarse", Scene { deck_scale: 2, ..down }),
        ("where charts meet", seam),
        ("above", Scene { altitude_m: 12_000.0, pitch_deg: -40.0, coverage: 0.3, ..down }),
        ("region", Scene { region: true, ..down }),
    ];
    for (name, scene) in scenes {
        let plan = scene.plan(Output::LinearRgb);
        assert!(plan.shadow.is_some(), "{name}");
        let lit = FramePlan { shadow: None, ..plan.clone() };
        let (_, _, shaded) = difference(&draw(&mut gpu, &plan), &draw(&mut gpu, &lit), 0.05);
        assert!(shaded > 0.1, "{name}: there are shadows to compare: {shaded}");
        let (mean, beyond) = compare(&format!("shadows, {name}"), &mut gpu, scene);
        // Bytes filtered with weights of 8 bits: a 256th of a step from light to dark, at shadows' edges only. From above
        // the deck's own difference counts (see below).
        assert!(mean < if name == "above" { 0.005 } else { 0.003 }, "{name}: {mean}");
        assert!(beyond < 0.02, "{name}: {beyond}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn the_deck_equals_its_twin() {
    let mut gpu = gpu();
    // Somewhere along the parallel, where it is day, two charts meet.
    let seam = (0..90).map(|i| Scene { longitude_deg: 8.0 + f64::from(i), ..BELOW });
    let seam = seam.clone().find(|s| s.plan(Output::LinearRgb).layers[0].layer.charts > 1).expect("a seam");
    let scenes = [
        ("below", BELOW),
        ("where charts meet", seam),
        ("below, coarse", Scene { deck_scale: 2, ..BELOW }),
        ("above", Scene { altitude_m: 4000.0, pitch_deg: -15.0, ..BELOW }),
        ("inside", Scene { altitude_m: 1500.0, pitch_deg: 0.0, ..BELOW }),
        ("overcast", Scene { coverage: 1.0, ..BELOW }),
        ("flash", Scene { strike: true, ..BELOW }),
        ("region", Scene { region: true, coverage: 0.1, ..BELOW }),
        ("tower", Scene { region: true, tower: true, coverage: 0.1, ..BELOW }),
    ];
    let needs = |scene: Scene| scene.plan(Output::LinearRgb).layers[0].layer;
    assert!(needs(scenes[6].1).flashes > 0 && needs(scenes[7].1).regions > 0, "each variant of the shader is drawn");
    for ((name, scene), form) in scenes.iter().flat_map(|s| [(s, DeckForm::Marched), (s, DeckForm::Instanced)]) {
        let (mean, beyond) = compare(&format!("{name}, {form:?}"), &mut gpu, Scene { form, ..*scene });
        // A step's length follows the look before it, so rounding and 8-bit filtering move later looks: at silhouettes
        // that decides whether a thin edge is met. The mean was 0.38 % at most; occlusion that
        // hides a fifth of the light too early moves it by 0.58 %.
        // The instanced form rounds after each instance besides (below), where little haze stands before the cloud most.
        assert!(mean < if form == DeckForm::Marched { 0.005 } else { 0.007 }, "{name}: {mean}");
        assert!(beyond < 0.04, "{name}: {beyond}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn a_storm_cell_equals_its_twin_from_far_under_and_inside() {
    let mut gpu = gpu();
    let far = Scene { coverage: 0.2, cell_km: Some(60.0), altitude_m: 3_000.0, pitch_deg: 3.0, ..BELOW };
    let scenes = [
        ("cell, far", far),
        ("cell, under", Scene { cell_km: Some(3.0), coverage: 0.0, altitude_m: 400.0, pitch_deg: 30.0, ..far }),
        ("cell, in its anvil", Scene { cell_km: Some(-6.0), altitude_m: 11_200.0, pitch_deg: 0.0, ..far }),
        ("cell, shadow", Scene { cell_km: Some(30.0), coverage: 0.0, altitude_m: 9_000.0, pitch_deg: -20.0, ..far }),
    ];
    for (name, scene) in scenes {
        let (mean, beyond) = compare(name, &mut gpu, scene);
        // As for the deck; the cell's edge is thinner against its steps, so more silhouettes fall on the other side.
        assert!(mean < 0.006, "{name}: {mean}");
        assert!(beyond < 0.04, "{name}: {beyond}");
        let [with, without] =
            [scene, Scene { cell_km: None, ..scene }].map(|scene| draw(&mut gpu, &scene.plan(Output::LinearRgb)));
        let (mean, ..) = difference(&with, &without, 0.05);
        assert!(mean > 0.03, "{name}: there is a cell to compare: {mean}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn the_own_ships_lights_in_cloud_equal_their_twin() {
    let mut gpu = gpu();
    for (name, scene) in [
        ("in an overcast", Scene { coverage: 1.0, altitude_m: 1_600.0, pitch_deg: 0.0, ..CITY }),
        (
            "over a coast with heights",
            Scene {
                coverage: 1.0,
                altitude_m: 1_600.0,
                latitude_deg: 43.65,
                longitude_deg: 6.95,
                night: true,
                ..MOUNTAINS
            },
        ),
    ] {
        let lit = Scene { own_lights: true, ..scene };
        assert!(lit.plan(Output::LinearRgb).beams.is_some_and(|beams| beams.lamps == 4), "{name}");
        let (mean, beyond) = compare(name, &mut gpu, lit);
        // Twenty sums in f32, rounded to f16.
        assert!(mean < 0.004 && beyond < 0.01, "{name}: {mean} {beyond}");
        let [lit, dark] = [lit, scene].map(|scene| draw(&mut gpu, &scene.plan(Output::LinearRgb)));
        let (mean, ..) = difference(&dark, &lit, 0.05);
        assert!(mean > 0.5, "{name}: they are most of the light: {mean}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn lamps_of_a_city_equal_their_twin() {
    let mut gpu = gpu();
    for (name, altitude_m, pitch_deg) in [("low", 700.0, -25.0), ("high", 4_000.0, -35.0), ("flat", 2_500.0, -8.0)] {
        let scene = Scene { coverage: 0.0, altitude_m, pitch_deg, ..CITY };
        let (mean, beyond) = compare(name, &mut gpu, scene);
        // Streets are bent by the map, whose sampler weighs texels with 8 bits: some decimetres, of lamps seven metres wide.
        assert!(mean < 0.01, "{name}: {mean}");
        assert!(beyond < 0.06, "{name}: {beyond}");
        let plan = scene.plan(Output::LinearRgb);
        let mut unlit = plan.clone();
        unlit.ground.as_mut().expect("ground is in sight").city_luminance = 0.0;
        let (mean, ..) = difference(&draw(&mut gpu, &unlit), &draw(&mut gpu, &plan), 0.05);
        assert!(mean > 0.3, "{name}: there are lamps to compare: {mean}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn both_forms_of_the_deck_give_the_same_picture() {
    let mut gpu = gpu();
    for (name, scene) in
        [("below", BELOW), ("inside", Scene { altitude_m: 1500.0, pitch_deg: 0.0, coverage: 0.7, ..BELOW })]
    {
        let drawn = |gpu: &mut GpuExecutor, form| draw(gpu, &Scene { form, ..scene }.plan(Output::LinearRgb));
        let forms = [drawn(&mut gpu, DeckForm::Instanced), drawn(&mut gpu, DeckForm::Marched)];
        let (mean, largest, _) = difference(&forms[0], &forms[1], 0.05);
        println!("{name}: mean {:.4} %, largest {:.2} %", 100.0 * mean, 100.0 * largest);
        // The instanced form rounds to f16 (0.05 %) after each instance that a pixel meets, of which there are about ten, and
        // stops a pixel between batches only: what comes after the last bit of transmittance, 0.4 %, is added or not.
        assert!(mean < 0.005, "{name}: {mean}");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn a_wrong_shader_is_noticed() {
    let mut gpu = gpu();
    for (module, right, wrong) in [
        ("march", "walked.light += source(", "walked.light += 1.1 * source("),
        ("march", "let depth = layer.extinction_per_m", "let depth = 0.7 * layer.extinction_per_m"),
        ("march", "mix(at, end, seen_share(", "mix(at, end, 0.3 * seen_share("),
        ("march", "rising, 1.0 - nearer.a", "rising, 0.9 - nearer.a"),
        ("march", "left *= exp(-layer.relief_depth", "left *= exp(layer.relief_depth"),
        ("march", "1.0 + share * clumps(", "1.0 - share * clumps("),
        ("march", "air_before_clouds(direction) * hidden", "endless_air(air_along(direction)) * hidden"),
        ("march", "-CLUMP_SHADE * near", "CLUMP_SHADE * near"),
        ("deck", "walked.light += source(", "walked.light += 1.1 * source("),
        ("cull", ".a < 1.0 - OPAQUE", ".a < -1.0"),
        ("ground", "seen = lit * made.albedo * 0.31830987", "seen = lit * made.albedo * 0.36"),
        ("relief", "found.x * HEIGHT_UNIT_M", "found.x * (0.97 * HEIGHT_UNIT_M)"),
        ("shadow", "p + layer.light_direction * distance", "p + layer.light_direction * (0.9 * distance)"),
        ("shadow", "entry * (1.0 / 3.0)", "entry * 0.3"),
        ("ground", "ground_luminance(direction, t, passed)", "ground_luminance(direction, t, 1.0)"),
        ("sky", "found.rgb * sky.table_scale", "found.rgb * sky.table_scale * 1.05"),
        ("march", "glow.strength * arrives", "glow.strength * (1.1 * arrives)"),
        ("beams", "* extinction * ds * passed", "* extinction * (1.1 * ds) * passed"),
        ("ground", "spread * spread * inside", "spread * spread"),
        ("ground", "passed *= through_hills(", "passed *= 0.3 * through_hills("),
        ("ground", "0.6 * city_light(place_m, level)", "0.8 * city_light(place_m, level)"),
        ("ground", "let shines = lamp.intensity_cd", "let shines = 3.0 * lamp.intensity_cd"),
    ] {
        gpu.pipelines = broken(&gpu, module, right, wrong);
        let scene = match module {
            "shadow" => Scene { pitch_deg: -35.0, altitude_m: 900.0, ..BELOW },
            "relief" => MOUNTAINS,
            "march" if right.contains("clumps") => {
                Scene { coverage: 0.3, altitude_m: 1_500.0, pitch_deg: 0.0, ..BELOW }
            }
            "march" if right.contains("before_clouds") => Scene { coverage: 1.0, pitch_deg: 2.0, ..BELOW },
            "march" if right.contains("CLUMP") => Scene { coverage: 1.0, altitude_m: 1_500.0, pitch_deg: 0.0, ..BELOW },
            "march" if right.contains("glow") => Scene { coverage: 1.0, ..CITY },
            "ground" if right.contains("t, passed") => Scene { pitch_deg: -35.0, altitude_m: 900.0, ..BELOW },
            "ground" if right.contains("inside") => {
                Scene { coverage: 0.0, altitude_m: 4_000.0, pitch_deg: -35.0, ..CITY }
            }
            "ground" if right.contains("hills") => Scene { coverage: 0.0, low_sun: true, ..MOUNTAINS },
            "ground" if right.contains("city_light") => Scene { coverage: 1.0, ..LOW_OVER_A_CITY },
            "ground" if right.contains("shines") => Scene { own_lights: true, ..LOW_OVER_A_CITY },
            "ground" => Scene { coverage: 0.0, pitch_deg: -50.0, ..BELOW },
            "beams" => Scene { own_lights: true, coverage: 1.0, altitude_m: 1_600.0, pitch_deg: 0.0, ..CITY },
            "sky" => Scene { coverage: 0.0, altitude_m: 9000.0, pitch_deg: 3.0, ..BELOW },
            "deck" | "cull" => Scene { form: DeckForm::Instanced, ..BELOW },
            _ => BELOW,
        };
        let (mean, _) = compare(&format!("{module} made wrong"), &mut gpu, scene);
        assert!(mean > 0.01, "{module} with {wrong:?} differs by {mean} only");
    }
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn light_is_read_alike_however_it_is_stored() {
    let mut gpu = gpu();
    let plan = |encoding| {
        let mut plan = BELOW.plan(Output::LinearRgb);
        plan.layers.iter_mut().for_each(|l| {
            l.layer.light_encoding = encoding as u32;
            l.light.iter_mut().for_each(|light| light.encoding = encoding);
        });
        plan
    };
    for encoding in Encoding::ALL {
        let apart = |gpu: &mut GpuExecutor| {
            let plan = plan(encoding);
            difference(&draw(gpu, &plan), &draw(&mut ReferenceExecutor::new(), &plan), 0.05)
        };
        let (mean, _, beyond) = apart(&mut gpu);
        println!("{encoding:?}: mean {:.4} %, beyond 5 %: {:.3} %", 100.0 * mean, 100.0 * beyond);
        // As for the deck itself.
        assert!(mean < 0.005 && beyond < 0.04, "{encoding:?}: {mean} {beyond}");
        gpu.pipelines = broken(&gpu, "march", "const FLUX_FACTOR: f32 = 2.55", "const FLUX_FACTOR: f32 = 1.9");
        let (mean, _, _) = apart(&mut gpu);
        assert!(mean > 0.01, "{encoding:?}: a wrong shader differs by {mean} only");
        gpu.pipelines = Pipelines::new(&gpu.gpu);
    }
}

/// Pipelines with one shader made wrong.
fn broken(gpu: &GpuExecutor, module: &'static str, right: &str, wrong: &str) -> Pipelines {
    let mut sources: HashMap<_, _> = shaders().into_iter().collect();
    let source = sources.get_mut(module).expect("a module");
    assert!(source.contains(right), "{module} has no {right:?}");
    *source = source.replace(right, wrong);
    Pipelines::from_sources(&gpu.gpu, &sources)
}

/// Share of codes by which tone mapping and its twin differ by more than one.
fn tones_apart(gpu: &mut GpuExecutor) -> f32 {
    let plan = Scene { coverage: 0.0, pitch_deg: 10.0, ..BELOW }.plan(Output::Srgb8);
    let (drawn, twin) = (draw(gpu, &plan), draw(&mut ReferenceExecutor::new(), &plan));
    let (Pixels::Srgb8(drawn), Pixels::Srgb8(twin)) = (drawn, twin) else { panic!("8 bits were asked for") };
    let apart: Vec<u8> = drawn.iter().zip(&twin).map(|(a, b)| a.abs_diff(*b)).collect();
    let beyond = apart.iter().filter(|d| **d > 1).count() as f32 / apart.len() as f32;
    println!("tonemap: largest {:?} codes, {:.3} % beyond one", apart.iter().max(), 100.0 * beyond);
    beyond
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn tone_mapping_equals_its_twin() {
    let mut gpu = gpu();
    let beyond = tones_apart(&mut gpu);
    // The light differs by up to 0.3 % (see above), that is half a code; the noise decides the rounding.
    assert!(beyond < 0.005, "{beyond}");
    gpu.pipelines = broken(&gpu, "tonemap", "1.0 / 2.4", "1.0 / 2.3");
    let beyond = tones_apart(&mut gpu);
    assert!(beyond > 0.1, "a wrong shader is noticed: {beyond}");
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn pictures_come_back_in_order_and_again_the_same() {
    let mut gpu = gpu();
    let plan = BELOW.plan(Output::Srgb8);
    (1..=3).for_each(|ticket| gpu.submit(ticket, &plan).expect("submitted"));
    let mut finished = Vec::new();
    while finished.len() < 3 {
        finished.extend(gpu.collect(true).expect("collected"));
    }
    assert_eq!(finished.iter().map(|f| f.ticket).collect::<Vec<_>>(), [1, 2, 3]);
    assert!(finished.windows(2).all(|w| w[0].pixels == w[1].pixels), "the same plan gives the same bytes");
    assert!(gpu.collect(true).expect("nothing under way").is_empty());
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn objects_stay_flat() {
    let mut gpu = gpu();
    let plan = BELOW.plan(Output::Srgb8);
    draw(&mut gpu, &plan);
    let before = gpu.object_count();
    (0..20).for_each(|_| drop(draw(&mut gpu, &plan)));
    assert_eq!(gpu.object_count(), before);
    let kept = gpu.gpu.buffer("kept", &[0; 16], wgpu::BufferUsages::STORAGE);
    assert_eq!(gpu.object_count(), before + 1, "what somebody keeps is counted");
    drop(kept);
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn a_lost_device_is_a_fault() {
    let mut gpu = gpu();
    gpu.gpu.device.destroy();
    let _ = gpu.gpu.device.poll(wgpu::PollType::Poll);
    let plan = BELOW.plan(Output::Srgb8);
    let outcome = gpu.submit(1, &plan).and_then(|()| gpu.collect(true).map(|_| ()));
    assert!(matches!(outcome, Err(Fault::DeviceLost(_))), "{outcome:?}");
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn a_picture_that_is_too_large_is_refused_before_the_device_is_asked() {
    let mut gpu = gpu();
    let right = BELOW.plan(Output::Srgb8);
    let before = draw(&mut gpu, &right);
    // More pixels a side than any adapter has, and more bytes than a buffer of any adapter holds are both told apart.
    for size_px in [[1 << 20, 16], [16, 1 << 20]] {
        let outcome = gpu.submit(9, &FramePlan { size_px, ..right.clone() });
        let Err(Fault::Unsupported(why)) = outcome else { panic!("{outcome:?}") };
        assert!(why.contains(&format!("{}x{}", size_px[0], size_px[1])) && why.contains("at most"), "{why}");
    }
    assert_eq!(draw(&mut gpu, &right), before, "the executor is as it was");
}

#[test]
#[cfg_attr(not(gpu_tests), ignore = "no graphics adapter")]
fn what_the_device_refuses_is_the_pictures_fault() {
    let mut gpu = gpu();
    // Nothing of ours asks for a buffer without a use; wgpu's validation refuses it.
    gpu.gpu.buffer("of no use", &[0; 16], wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE);
    let outcome = gpu.submit(1, &BELOW.plan(Output::Srgb8));
    assert!(matches!(outcome, Err(Fault::Rejected(_))), "{outcome:?}");
}
