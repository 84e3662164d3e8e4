//! Images at their own resolution that a picture is put together from: the deck, and the shadows on the ground.

use crate::passes::common::Camera;
use crate::passes::deck::twin::{OPAQUE, Prepared, walk};
use crate::passes::glow::twin::Level;
use crate::passes::relief::field::Grids;
use crate::passes::relief::twin as relief;
use crate::passes::shadow::twin::{Caster, through_all};
use crate::passes::sky::table::Texel;
use crate::passes::sky::twin as sky;
use crate::passes::veil::Node;
use crate::passes::{airlight, glow, ground, stroke, veil};
use crate::plan::FramePlan;
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::ops::{Add, Mul};

/// What a picture is put together from, at a size of its own.
pub struct Image<T> {
    size: [usize; 2],
    /// Row by row.
    pub texels: Vec<T>,
}

impl<T: Copy + Send + Add<Output = T> + Mul<f32, Output = T>> Image<T> {
    fn uniform(value: T) -> Self {
        Self { size: [1, 1], texels: vec![value] }
    }

    /// An image of the size of a camera's picture.
    fn drawn(size: [f32; 2], blank: T, texel: impl Fn(usize, usize) -> T + Sync) -> Self {
        let size = size.map(|n| n as usize);
        let mut texels = vec![blank; size[0] * size[1]];
        texels.par_chunks_mut(size[0]).enumerate().for_each(|(y, row)| {
            row.iter_mut().enumerate().for_each(|(x, value)| *value = texel(x, y));
        });
        Self { size, texels }
    }

    /// The texel under a point of the whole picture, 0 to 1.
    pub fn under(&self, u: f32, v: f32) -> T {
        let at = |share: f32, count: usize| ((share * count as f32) as usize).min(count - 1);
        self.texels[at(u, self.size[0]) + at(v, self.size[1]) * self.size[0]]
    }

    /// Bilinear, clamped; coordinates in the whole picture, 0 to 1.
    pub fn at(&self, u: f32, v: f32) -> T {
        let [width, height] = self.size;
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let texel = |dx: i32, dy: i32| {
            let column = (x0 as i32 + dx).clamp(0, width as i32 - 1) as usize;
            let row = (y0 as i32 + dy).clamp(0, height as i32 - 1) as usize;
            self.texels[column + row * width]
        };
        let between = |a: T, b: T, share: f32| a * (1.0 - share) + b * share;
        let low = between(texel(0, 0), texel(1, 0), x - x0);
        between(low, between(texel(0, 1), texel(1, 1), x - x0), y - y0)
    }
}

/// Range at which the ray of a point of the picture meets the ground; infinite where it does not.
pub fn range(ranges: Option<&Image<f32>>, camera: &Camera, at: [f32; 2], direction: Vec3) -> f32 {
    match ranges {
        Some(ranges) => ranges.under(at[0] / camera.width_px, at[1] / camera.height_px),
        None => ground::twin::range(camera, direction),
    }
}

/// Range at which each pixel's ray meets the ground; `None`: the ground is a sphere.
pub fn ranges(plan: &FramePlan, grids: Option<&Grids>) -> Option<Image<f32>> {
    let grids = grids.filter(|_| plan.terrain())?;
    let camera = &plan.camera;
    Some(Image::drawn([camera.width_px, camera.height_px], f32::INFINITY, |x, y| {
        relief::range(grids, camera, camera.ray(x as f32 + 0.5, y as f32 + 0.5))
    }))
}

/// The deck by itself: luminance and what it hides.
pub fn deck(plan: &FramePlan, table: &[Texel], layers: &[Prepared], ranges: Option<&Image<f32>>) -> Image<Vec4> {
    if layers.is_empty() {
        return Image::uniform(Vec4::ZERO);
    }
    let camera = plan.camera.coarser(plan.deck_scale);
    let legs = plan.legs();
    Image::drawn([camera.width_px, camera.height_px], Vec4::ZERO, |x, y| {
        let at = [x as f32 + 0.5, y as f32 + 0.5];
        let direction = camera.ray(at[0], at[1]);
        let end_m = range(ranges, &camera, at, direction);
        let gathered = walk(&camera, layers, &legs, direction, end_m, sky::endless(&plan.sky, table, direction));
        gathered.luminance.extend(1.0 - gathered.transmittance)
    })
}

/// The channels of lightning with their glow and their light in the air, cd/m2 of their colour.
pub fn strokes(plan: &FramePlan, layers: &[Prepared]) -> Option<Image<f32>> {
    let strokes = plan.strokes.as_ref()?;
    let camera = &plan.camera;
    let passed = |node: &Node| -> f32 {
        layers.iter().map(|layer| veil::twin::passed(camera, layer, Vec3::from(node.position_m))).product()
    };
    let passed: Vec<f32> = strokes.nodes.par_iter().map(passed).collect();
    let channels = stroke::twin::image(plan.size_px, &strokes.segments, &passed);
    let size = plan.size_px.map(|n| n as usize);
    let glowing = glow::twin::glowing(Level { size, values: channels }, &strokes.glow);
    let coarse = camera.coarser(strokes.air_scale);
    let air = Image::drawn([coarse.width_px, coarse.height_px], 0.0, |x, y| {
        let direction = coarse.ray(x as f32 + 0.5, y as f32 + 0.5);
        airlight::twin::luminance(&coarse, &strokes.sources, &passed, direction)
    });
    Some(Image::drawn([camera.width_px, camera.height_px], 0.0, |x, y| {
        let at = [(x as f32 + 0.5) / camera.width_px, (y as f32 + 0.5) / camera.height_px];
        glowing.values[x + y * size[0]] + air.at(at[0], at[1])
    }))
}

/// Share of the light that reaches the ground through all layers.
pub fn shadow(plan: &FramePlan, casters: &[Caster], deck: &Image<Vec4>, ranges: Option<&Image<f32>>) -> Image<f32> {
    let Some(shadow) = &plan.shadow else { return Image::uniform(1.0) };
    let camera = plan.camera.coarser(shadow.scale);
    let [width, height] = [camera.width_px, camera.height_px];
    Image::drawn([width, height], 1.0, |x, y| {
        let at = [x as f32 + 0.5, y as f32 + 0.5];
        let direction = camera.ray(at[0], at[1]);
        let t = range(ranges, &camera, at, direction);
        // What the deck hides is read by its neighbours where a texel is larger than a pixel.
        let hidden = shadow.scale == 1 && 1.0 - deck.at(at[0] / width, at[1] / height).w < OPAQUE;
        if t.is_infinite() || hidden { 1.0 } else { through_all(casters, &camera, direction, t, plan.terrain()) }
    })
}
