//! The pipelines: one for each pass, and for the deck one for each combination of what a scene needs.

mod state;

use super::device::Gpu;
use super::layouts::{Layouts, pipeline_layout};
use super::targets::{PICTURE_FORMAT, STROKES_FORMAT};
use crate::passes::ground::Ground;
use crate::passes::light::encoding::Encoding;
use crate::plan::FramePlan;
use state::{added, compute, marked, multiplied, render, replaced, tested, under};
use std::collections::HashMap;

const COMMON: &str = include_str!("../passes/common.wgsl");
const RELIGHT: &str = include_str!("../passes/relight/relight.wgsl");
/// Sums of tables of virtual lights.
pub const SUM: &str = include_str!("../passes/relight/sum.wgsl");
const FIELD: &str = concat!(
    include_str!("../passes/deck/field.wgsl"),
    "\n",
    include_str!("../passes/deck/lit.wgsl"),
    "\n",
    include_str!("../passes/deck/walk.wgsl")
);
const GROUND: &str = concat!(
    include_str!("../passes/ground/hills.wgsl"),
    "\n",
    include_str!("../passes/ground/ground.wgsl"),
    "\n",
    include_str!("../passes/ground/lamps.wgsl")
);
const RELIEF: &str = include_str!("../passes/relief/field.wgsl");

/// All WGSL modules by name, as they are compiled.
pub fn shaders() -> Vec<(&'static str, String)> {
    let with_common = |name, text: &str| (name, format!("{COMMON}\n{text}"));
    vec![
        with_common("sky", include_str!("../passes/sky/sky.wgsl")),
        with_common("ground", &format!("{RELIGHT}\n{RELIEF}\n{GROUND}")),
        with_common("relief", &format!("{RELIEF}\n{}", include_str!("../passes/relief/relief.wgsl"))),
        with_common("deck", &format!("{RELIGHT}\n{FIELD}\n{}", include_str!("../passes/deck/deck.wgsl"))),
        with_common("march", &format!("{RELIGHT}\n{FIELD}\n{}", include_str!("../passes/deck/march.wgsl"))),
        with_common("shadow", &format!("{RELIGHT}\n{FIELD}\n{}", include_str!("../passes/shadow/shadow.wgsl"))),
        with_common("veil", &format!("{RELIGHT}\n{FIELD}\n{}", include_str!("../passes/veil/veil.wgsl"))),
        with_common("stroke", include_str!("../passes/stroke/stroke.wgsl")),
        with_common("beams", include_str!("../passes/beams/beams.wgsl")),
        with_common("airlight", include_str!("../passes/airlight/airlight.wgsl")),
        ("glow", include_str!("../passes/glow/glow.wgsl").to_string()),
        with_common("cull", include_str!("../passes/cull/cull.wgsl")),
        ("sum", SUM.to_string()),
        ("tonemap", include_str!("../passes/tonemap/tonemap.wgsl").to_string()),
    ]
}

/// What of the deck's shader a layer needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DeckVariant {
    pub several_charts: bool,
    pub regions: bool,
    pub clumps: bool,
    pub leaps: bool,
    pub flashes: bool,
    pub light: Encoding,
    pub shaded: bool,
    pub terrain: bool,
    pub glow: bool,
}

impl DeckVariant {
    fn constants(self) -> [(&'static str, f64); 9] {
        let flag = |on: bool| f64::from(u8::from(on));
        [
            ("SEVERAL_CHARTS", flag(self.several_charts)),
            ("SHADED", flag(self.shaded)),
            ("REGIONS", flag(self.regions)),
            ("CLUMPS", flag(self.clumps)),
            ("LEAPS", flag(self.leaps)),
            ("FLASHES", flag(self.flashes)),
            // Texels of four bytes and of four f16 are read alike.
            ("FLUX", if self.light.is_vector() { if self.light.in_bytes() { 2.0 } else { 1.0 } } else { 0.0 }),
            ("TERRAIN", flag(self.terrain)),
            ("GLOW", flag(self.glow)),
        ]
    }
}

/// Which ways of a ray a walk takes: to its lowest point, and up from there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Ways {
    pub falling: bool,
    pub rising: bool,
}

/// What of the ground's shader a scene needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GroundVariant {
    pub several_charts: bool,
    pub flashes: bool,
    pub cities: bool,
    pub shadows: bool,
    pub land: bool,
    pub terrain: bool,
    pub hills: bool,
    pub own_lamps: bool,
}

impl GroundVariant {
    /// For the ground of a plan.
    pub fn of(ground: &Ground, plan: &FramePlan) -> Self {
        Self {
            several_charts: ground.charts > 1,
            flashes: ground.flashes > 0 || !plan.lit.is_empty(),
            cities: plan.relief.as_ref().is_some_and(|relief| relief.lights),
            shadows: plan.shadow.is_some(),
            land: plan.relief.is_some(),
            terrain: plan.terrain(),
            hills: ground.hills > 0,
            own_lamps: ground.lamps > 0,
        }
    }

    fn constants(self) -> [(&'static str, f64); 8] {
        let flag = |on: bool| f64::from(u8::from(on));
        [
            ("SEVERAL_CHARTS", flag(self.several_charts)),
            ("FLASHES", flag(self.flashes)),
            ("CITIES", flag(self.cities)),
            ("SHADOWS", flag(self.shadows)),
            ("LAND", flag(self.land)),
            ("TERRAIN", flag(self.terrain)),
            ("HILLS", flag(self.hills)),
            ("OWN_LAMPS", flag(self.own_lamps)),
        ]
    }
}

/// Pipelines and the layouts of their bind groups.
pub struct Pipelines {
    pub frame_layout: wgpu::BindGroupLayout,
    pub deck_layout: wgpu::BindGroupLayout,
    pub mesh_layout: wgpu::BindGroupLayout,
    pub ground_layout: wgpu::BindGroupLayout,
    pub relief_layout: wgpu::BindGroupLayout,
    pub stars_layout: wgpu::BindGroupLayout,
    pub shadow_layout: wgpu::BindGroupLayout,
    pub image_layout: wgpu::BindGroupLayout,
    pub march_layout: wgpu::BindGroupLayout,
    pub relief: wgpu::RenderPipeline,
    pub cull: wgpu::RenderPipeline,
    pub tonemap: wgpu::RenderPipeline,
    beams_module: wgpu::ShaderModule,
    beams_pipeline_layout: wgpu::PipelineLayout,
    beams: HashMap<bool, wgpu::RenderPipeline>,
    sky_module: wgpu::ShaderModule,
    sky_pipeline_layout: wgpu::PipelineLayout,
    sky: HashMap<(bool, bool), wgpu::RenderPipeline>,
    ground_module: wgpu::ShaderModule,
    ground_pipeline_layout: wgpu::PipelineLayout,
    ground: HashMap<GroundVariant, wgpu::RenderPipeline>,
    shadow_module: wgpu::ShaderModule,
    shadow_pipeline_layout: wgpu::PipelineLayout,
    shadow: HashMap<DeckVariant, wgpu::RenderPipeline>,
    shade: HashMap<DeckVariant, wgpu::RenderPipeline>,
    deck_module: wgpu::ShaderModule,
    deck_pipeline_layout: wgpu::PipelineLayout,
    deck: HashMap<DeckVariant, wgpu::RenderPipeline>,
    march_module: wgpu::ShaderModule,
    march_pipeline_layout: wgpu::PipelineLayout,
    march: HashMap<(DeckVariant, Ways), wgpu::ComputePipeline>,
    pub nodes_layout: wgpu::BindGroupLayout,
    pub strokes_layout: wgpu::BindGroupLayout,
    pub glow_layout: wgpu::BindGroupLayout,
    pub stroke: wgpu::RenderPipeline,
    pub airlight: wgpu::RenderPipeline,
    pub glow_down: wgpu::RenderPipeline,
    pub glow_up: wgpu::RenderPipeline,
    pub glow_last: wgpu::RenderPipeline,
    veil_module: wgpu::ShaderModule,
    veil_pipeline_layout: wgpu::PipelineLayout,
    veil: HashMap<DeckVariant, wgpu::ComputePipeline>,
}

impl Pipelines {
    /// Builds every pipeline but the deck's variants, which are built when first needed.
    pub fn new(gpu: &Gpu) -> Self {
        let sources: HashMap<_, _> = shaders().into_iter().collect();
        Self::from_sources(gpu, &sources)
    }

    /// The same from given sources, so that a test can break one.
    pub fn from_sources(gpu: &Gpu, sources: &HashMap<&'static str, String>) -> Self {
        let module = |name: &str| {
            let source = sources.get(name).cloned().unwrap_or_default();
            gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        };
        let layouts = Layouts::new(gpu);
        let relief_layout = pipeline_layout(gpu, &[Some(&layouts.frame), None, Some(&layouts.relief)]);
        let cull_layout = pipeline_layout(gpu, &[None, Some(&layouts.image)]);
        let tonemap_layout = pipeline_layout(gpu, &[Some(&layouts.image)]);
        let opaque = replaced(PICTURE_FORMAT);
        let single = replaced(STROKES_FORMAT);
        let strokes_layout = pipeline_layout(gpu, &[Some(&layouts.frame), Some(&layouts.strokes)]);
        let glow_layout = pipeline_layout(gpu, &[Some(&layouts.glow)]);
        let glow_module = module("glow");
        let glow = |name: &str, target| render(gpu, name, &glow_module, &glow_layout, Some(target), None, &[]);
        Self {
            stroke: render(gpu, "stroke", &module("stroke"), &strokes_layout, Some(added(STROKES_FORMAT)), None, &[]),
            airlight: render(gpu, "airlight", &module("airlight"), &strokes_layout, Some(single.clone()), None, &[]),
            glow_down: glow("glow_down", single.clone()),
            glow_up: glow("glow_up", single),
            glow_last: glow("glow_last", added(gpu.light_format)),
            veil_module: module("veil"),
            veil_pipeline_layout: pipeline_layout(
                gpu,
                &[Some(&layouts.frame), Some(&layouts.deck), Some(&layouts.nodes)],
            ),
            veil: HashMap::new(),
            relief: render(
                gpu,
                "relief",
                &module("relief"),
                &relief_layout,
                Some(replaced(super::relief::FORMAT)),
                None,
                &[],
            ),
            beams_module: module("beams"),
            beams_pipeline_layout: pipeline_layout(gpu, &[Some(&layouts.frame), Some(&layouts.mesh)]),
            beams: HashMap::new(),
            sky_module: module("sky"),
            sky_pipeline_layout: pipeline_layout(gpu, &[Some(&layouts.frame), Some(&layouts.stars)]),
            sky: HashMap::new(),
            ground_module: module("ground"),
            ground_pipeline_layout: pipeline_layout(
                gpu,
                &[Some(&layouts.frame), Some(&layouts.ground), Some(&layouts.relief)],
            ),
            ground: HashMap::new(),
            cull: render(gpu, "cull", &module("cull"), &cull_layout, None, Some(marked()), &[]),
            tonemap: render(gpu, "tonemap", &module("tonemap"), &tonemap_layout, Some(opaque), None, &[]),
            shadow_module: module("shadow"),
            shadow_pipeline_layout: pipeline_layout(
                gpu,
                &[Some(&layouts.frame), Some(&layouts.deck), Some(&layouts.shadow)],
            ),
            shadow: HashMap::new(),
            shade: HashMap::new(),
            deck_module: module("deck"),
            deck_pipeline_layout: pipeline_layout(
                gpu,
                &[Some(&layouts.frame), Some(&layouts.deck), Some(&layouts.mesh)],
            ),
            deck: HashMap::new(),
            march_module: module("march"),
            march_pipeline_layout: pipeline_layout(
                gpu,
                &[Some(&layouts.frame), Some(&layouts.deck), Some(&layouts.march)],
            ),
            march: HashMap::new(),
            frame_layout: layouts.frame,
            deck_layout: layouts.deck,
            mesh_layout: layouts.mesh,
            ground_layout: layouts.ground,
            relief_layout: layouts.relief,
            stars_layout: layouts.stars,
            shadow_layout: layouts.shadow,
            image_layout: layouts.image,
            march_layout: layouts.march,
            nodes_layout: layouts.nodes,
            strokes_layout: layouts.strokes,
            glow_layout: layouts.glow,
        }
    }

    /// The veil's pipeline for what a layer needs.
    pub fn veil(&mut self, gpu: &Gpu, variant: DeckVariant) -> &wgpu::ComputePipeline {
        // Its light does not matter to what a cloud hides.
        let variant = DeckVariant {
            clumps: false,
            flashes: false,
            glow: false,
            light: Encoding::Shares8,
            shaded: false,
            ..variant
        };
        self.veil.entry(variant).or_insert_with(|| {
            let constants = variant.constants();
            let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
            compute(gpu, "veil", &self.veil_module, &self.veil_pipeline_layout, options)
        })
    }

    /// The pipeline of the own ship's lights, over terrain or over a sphere.
    pub fn beams(&mut self, gpu: &Gpu, terrain: bool) -> &wgpu::RenderPipeline {
        self.beams.entry(terrain).or_insert_with(|| {
            let constants = [("TERRAIN", f64::from(u8::from(terrain)))];
            let target = Some(added(gpu.light_format));
            render(gpu, "beams", &self.beams_module, &self.beams_pipeline_layout, target, None, &constants)
        })
    }

    /// The sky's pipeline, over terrain or over a sphere, with stars or without.
    pub fn sky(&mut self, gpu: &Gpu, terrain: bool, stars: bool) -> &wgpu::RenderPipeline {
        self.sky.entry((terrain, stars)).or_insert_with(|| {
            let flag = |on: bool| f64::from(u8::from(on));
            let constants = [("TERRAIN", flag(terrain)), ("STARS", flag(stars))];
            let target = Some(added(gpu.light_format));
            render(gpu, "sky", &self.sky_module, &self.sky_pipeline_layout, target, None, &constants)
        })
    }

    /// The ground's pipeline for what a scene needs.
    pub fn ground(&mut self, gpu: &Gpu, variant: GroundVariant) -> &wgpu::RenderPipeline {
        self.ground.entry(variant).or_insert_with(|| {
            let target = Some(added(gpu.light_format));
            let constants = variant.constants();
            render(gpu, "ground", &self.ground_module, &self.ground_pipeline_layout, target, None, &constants)
        })
    }

    /// The shadow pipeline for what a layer needs.
    pub fn shadow(&mut self, gpu: &Gpu, variant: DeckVariant) -> &wgpu::RenderPipeline {
        // Flashes and cities cast no shadow, nor does it matter how the layer is lit.
        let variant = DeckVariant {
            clumps: false,
            flashes: false,
            glow: false,
            light: Encoding::Shares8,
            shaded: false,
            ..variant
        };
        self.shadow.entry(variant).or_insert_with(|| {
            let target = Some(multiplied(super::shadow::FORMAT));
            let constants = variant.constants();
            render(gpu, "shadow", &self.shadow_module, &self.shadow_pipeline_layout, target, None, &constants)
        })
    }

    /// The same for the shade on a lower layer.
    pub fn shade(&mut self, gpu: &Gpu, variant: DeckVariant) -> &wgpu::RenderPipeline {
        let variant = DeckVariant {
            clumps: false,
            flashes: false,
            glow: false,
            light: Encoding::Shares8,
            shaded: false,
            ..variant
        };
        self.shade.entry(variant).or_insert_with(|| {
            let target = Some(multiplied(super::shadow::FORMAT));
            let constants = variant.constants();
            render(gpu, "shade", &self.shadow_module, &self.shadow_pipeline_layout, target, None, &constants)
        })
    }

    /// The deck's pipeline for what a layer needs.
    pub fn deck(&mut self, gpu: &Gpu, variant: DeckVariant) -> &wgpu::RenderPipeline {
        self.deck.entry(variant).or_insert_with(|| {
            let target = Some(under(gpu.light_format));
            let constants = variant.constants();
            render(gpu, "deck", &self.deck_module, &self.deck_pipeline_layout, target, Some(tested()), &constants)
        })
    }

    /// The walking form of it, for rays on the way down, on the way up, or both.
    pub fn march(&mut self, gpu: &Gpu, variant: DeckVariant, ways: Ways) -> &wgpu::ComputePipeline {
        self.march.entry((variant, ways)).or_insert_with(|| {
            let mut constants = variant.constants().to_vec();
            let flag = |on: bool| f64::from(u8::from(on));
            constants.extend([("FALLING", flag(ways.falling)), ("RISING", flag(ways.rising))]);
            let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
            compute(gpu, "deck_march", &self.march_module, &self.march_pipeline_layout, options)
        })
    }
}
