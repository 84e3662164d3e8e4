//! The plan: what one frame needs, as a value. Pure, no I/O, cannot fail.
//!
//! `plan` reads a snapshot and one of its views and writes down every number that the passes read, already relative to
//! the eye and narrowed to f32, and for each pass whether it is there and why. Two equal plans give the same picture.

mod beams;
mod cells;
pub mod executor;
mod eye;
mod illuminance;
mod layers;
mod regions;
mod relief;
mod relight;
mod shade;
mod shadow;
mod stroke;

use crate::clouds::CloudKind;
use crate::passes::beams::Beams;
use crate::passes::common::Camera;
use crate::passes::deck::Layer;
use crate::passes::deck::spans::{Leg, legs, overlap};
use crate::passes::ground::Ground;
use crate::passes::light::Light;
use crate::passes::relight::{LitFlash, Request};
use crate::passes::sky::table::TableParams;
use crate::passes::sky::{Sky, Stars};
use crate::world::snapshot::{DeckForm, Snapshot, ViewState};
use std::sync::Arc;

pub use relief::{GlowPlan, ReliefPlan};
pub use shadow::{LayerShadow, ShadowPlan};
pub use stroke::StrokePlan;

/// What one frame of one view needs: the passes' parameters, and why each pass is there or not.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePlan {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Form of the picture.
    pub output: Output,
    /// Eye and air.
    pub camera: Camera,
    /// Sky, sun and moon.
    pub sky: Sky,
    /// The stars, at night.
    pub stars: Option<Stars>,
    /// What the table of scattered light is made from.
    pub table: TableParams,
    /// Land and heights around the eye, unless there is only sea in sight.
    pub relief: Option<ReliefPlan>,
    /// The glow of cities on the clouds, unless it is day or there are none.
    pub glow: Option<GlowPlan>,
    /// The ground, unless it is out of sight.
    pub ground: Option<Ground>,
    /// Shadows of single clouds on it, unless there are none to be seen.
    pub shadow: Option<ShadowPlan>,
    /// Pixels of the picture each way to one of the deck, which is drawn apart and laid over what is behind.
    pub deck_scale: u32,
    /// How a GPU draws the deck: never [`DeckForm::Auto`].
    pub deck_form: DeckForm,
    /// Cloud layers in sight, lowest base first.
    pub layers: Vec<LayerPlan>,
    /// Channels of lightning, their glow and their light in the air, while a flash gives light.
    pub strokes: Option<StrokePlan>,
    /// The own ship's lights, while they shine in cloud or haze.
    pub beams: Option<Beams>,
    /// Flashes whose light inside the clouds is found as a field; other flashes are points of the layers and the ground.
    pub lit: Vec<LitFlash>,
    /// What the coming frames' flashes may be lit by: made beforehand where pictures do not wait.
    pub ahead: Vec<Arc<Request>>,
    /// Memory in MiB that tables of virtual lights may take.
    pub basis_memory_mib: u32,
    /// Whether the picture waits until everything that it needs has been made. Running free it does not: what is still
    /// being made is stood in for, and the picture is provisional.
    pub waits: bool,
    /// One line a pass: kept or left out, and why.
    pub notes: Vec<PassNote>,
}

/// One cloud layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerPlan {
    /// Which density volume.
    pub kind: CloudKind,
    /// Slices (eq. 12, N).
    pub slices: u32,
    /// Parameters of the deck pass.
    pub layer: Layer,
    /// What its light volumes are made from, one for each chart in use; an executor keeps the volumes it has made by these.
    pub light: Vec<Light>,
    /// Towards the light in the axes of each of these charts (x, y, up).
    pub towards: Vec<[f32; 3]>,
    /// Higher layers that shade this one; empty where that is not to be seen.
    pub shade: Vec<LayerShadow>,
}

/// One line of the explanation of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PassNote {
    /// Name of the pass.
    pub pass: &'static str,
    /// Whether it runs.
    pub kept: bool,
    /// The sentence that explains it.
    pub why: String,
}

impl FramePlan {
    /// Whether the ground is more than a sphere: then rays are followed to it.
    pub fn terrain(&self) -> bool {
        self.relief.as_ref().is_some_and(|relief| relief.rays)
    }

    /// In which order the layers are walked, near to far along any ray.
    pub fn legs(&self) -> Vec<Leg> {
        legs(&heights(&self.layers), self.camera.eye_m)
    }
}

impl FramePlan {
    /// Tables of columns that its shadows and shades read, at most.
    pub fn tables(&self) -> usize {
        let shades = self.layers.iter().flat_map(|layer| &layer.shade);
        let shadows = self.shadow.iter().flat_map(|shadow| &shadow.casters);
        shades.chain(shadows).map(|caster| caster.columns.len()).sum()
    }
}

/// Base and top of each layer over the sphere.
fn heights(layers: &[LayerPlan]) -> Vec<[f32; 2]> {
    layers.iter().map(|l| [l.layer.base_m, l.layer.base_m + l.layer.thickness_m]).collect()
}

/// What form the picture takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Tone-mapped, 8 bits, sRGB.
    Srgb8,
    /// Linear luminance in cd/m2, before exposure.
    LinearRgb,
}

/// The plan of one view of a snapshot.
pub fn plan(snapshot: &Snapshot, view: &ViewState, output: Output) -> FramePlan {
    let eye = eye::Eye::new(&snapshot.ownship, view, &snapshot.terrain);
    let mut notes = Vec::new();
    if eye.lifted_m > 0.0 {
        let (height_m, lifted_m) = (eye::LOWEST_EYE_M, eye.lifted_m);
        let over = if snapshot.terrain.is_ellipsoid() { "ellipsoid" } else { "ground" };
        let why = format!("the eye is {lifted_m:.1} m too low and is drawn {height_m} m above the {over}");
        notes.push(PassNote { pass: "eye", kept: true, why });
    }
    let regions = regions::near(snapshot, &eye, &mut notes);
    let light = illuminance::Illuminance::new(snapshot, &eye, view, &regions);
    let (mut lit, mut bare, mut ahead) = relight::split(snapshot, &eye, &mut notes);
    let mut flashes = layers::flashes(&bare, &eye, &mut notes);
    let mut layers = layers::in_sight(snapshot, &eye, &light, &regions, &flashes, &mut notes);
    shade::cast(&light, &mut layers, &mut notes);
    if layers.is_empty() && !lit.is_empty() {
        // With no cloud in sight all of the light is that of points on the ground.
        (lit, bare, ahead) = (Vec::new(), relight::points_of(snapshot), Vec::new());
        flashes = layers::flashes(&bare, &eye, &mut notes);
    }
    let deck_scale = deck_scale(snapshot.quality.deck_scale, eye.height_m as f32, &layers, &mut notes);
    let mut camera = light.camera(&eye, view);
    let beams = beams::lit(snapshot, &eye, view, &camera, &layers, &mut notes);
    if let Some(beams) = &beams {
        camera.exposure = beams::exposure(view.exposure, &camera, beams, illuminance::FULL_LUX_EXPOSURE);
    }
    let shadow = shadow::cast(&camera, &light.between_clouds(), &layers, deck_scale, &mut notes);
    let below = stroke::on_ground(&bare, &eye, &flashes);
    let relief = relief::in_sight(snapshot, &eye, light.night > 0.0, &mut notes);
    let glow = relief::glow(snapshot, &eye, light.night, !layers.is_empty(), &mut notes);
    let own = beams::on_ground(snapshot, &eye, view, &light.ground, light.source.z, &mut notes);
    let ground = light.ground(&eye, shadow.as_ref(), relief.as_ref(), &below, &own, &mut notes);
    let stars = light.stars(&eye, &camera, &mut notes);
    notes.push(PassNote { pass: "sky", kept: true, why: "the sky is behind everything".into() });
    let tonemap = output == Output::Srgb8;
    let why = if tonemap { "the picture is for a screen" } else { "linear luminance was asked for" };
    notes.push(PassNote { pass: "tonemap", kept: tonemap, why: why.into() });
    let mut strokes = stroke::strokes(snapshot, &eye, &camera, &mut notes);
    if let (Output::LinearRgb, Some(strokes)) = (output, &mut strokes) {
        camera.exposure = stroke::linear_exposure(camera.exposure, strokes);
        strokes.airlight.scale = camera.exposure;
    }
    let terrain = relief.as_ref().is_some_and(|relief| relief.rays);
    let deck_form = deck_form(snapshot.quality.deck_form, &layers, terrain, &mut notes);
    FramePlan {
        size_px: view.size_px,
        output,
        camera,
        sky: light.sky(&eye),
        stars,
        table: light.table,
        relief,
        glow,
        ground,
        shadow,
        deck_scale,
        deck_form,
        layers,
        strokes,
        beams,
        lit,
        ahead,
        basis_memory_mib: snapshot.quality.basis_memory_mib,
        waits: true,
        notes,
    }
}

/// Pixels of the picture each way to one of the deck. Between a layer's base and top, where every ray runs through it and
/// what is near is soft, a deck that is coarser than the picture is coarsened by one more; a deck at full size stays so.
fn deck_scale(asked: u32, eye_m: f32, layers: &[LayerPlan], notes: &mut Vec<PassNote>) -> u32 {
    let inside = |l: &LayerPlan| {
        let beside = glam::Vec3::from(l.layer.bound_m) - glam::Vec3::new(0.0, 0.0, eye_m);
        let near = l.layer.bound_radius_m == 0.0 || beside.length() < l.layer.bound_radius_m;
        near && l.layer.base_m < eye_m && eye_m < l.layer.base_m + l.layer.thickness_m
    };
    if asked > 1 && layers.iter().any(inside) {
        let why = format!("one pixel for {0} x {0} of the picture, since the eye is inside a layer", asked + 1);
        notes.push(PassNote { pass: "deck", kept: true, why });
        return asked + 1;
    }
    asked.max(1)
}

/// How a GPU draws the deck. The walk was the faster one wherever it was measured (`cargo bench --bench deck`): on Mesa's llvmpipe a frame
/// took 0.43 to 0.78 of the instanced form's time, under, in and above a deck, at covers from 0.2 to 1.
fn deck_form(asked: DeckForm, layers: &[LayerPlan], terrain: bool, notes: &mut Vec<PassNote>) -> DeckForm {
    let (form, why) = match asked {
        DeckForm::Auto | DeckForm::Marched => (DeckForm::Marched, "a GPU draws the deck as one walk a pixel"),
        DeckForm::Instanced if overlap(&heights(layers)) => {
            (DeckForm::Marched, "layers share heights, which only the walk a pixel puts in order")
        }
        DeckForm::Instanced if terrain => {
            (DeckForm::Marched, "the ground has heights, at which only the walk a pixel stops")
        }
        DeckForm::Instanced => (DeckForm::Instanced, "a GPU draws the deck as instanced geometry, as asked"),
    };
    if !layers.is_empty() {
        notes.push(PassNote { pass: "form", kept: true, why: why.into() });
    }
    form
}

#[cfg(test)]
pub(crate) mod scenes;

#[cfg(test)]
mod tests;
