//! The ways to draw the deck that are compared: one setting changed at a time against 32 slices at full resolution.

use crate::clouds::density::{DensityVolume, HEIGHT, WIDTH};
use crate::clouds::modulation;
use crate::frame::Pixels;
use crate::gpu::GpuExecutor;
use crate::passes::deck::field::{Textures, column_bounds};
use crate::passes::deck::twin::Prepared;
use crate::passes::light::Nodes;
use crate::passes::light::encoding::Encoding;
use crate::plan::executor::Executor;
use crate::plan::{FramePlan, LayerPlan};
use crate::reference::{self, ReferenceExecutor};
use crate::report::subject::Stopped;
use crate::world::DEFAULT_QUALITY;
use crate::world::snapshot::{DeckForm, Quality};

/// One way to draw.
pub struct Method {
    /// Which setting is changed.
    pub name: &'static str,
    /// Its values.
    pub params: Vec<(&'static str, f64)>,
    plan: FramePlan,
    with: With,
}

/// What draws, and from which textures.
enum With {
    Reference,
    Gpu,
    /// Shape volumes with fewer voxels and their column bounds, one a layer.
    Volumes(Vec<(Vec<u8>, Vec<u8>)>),
    /// A modulation map with fewer texels.
    Map(Vec<u8>),
    /// Light made for thetas at other distances, or for one alone.
    Thetas(Option<f32>),
}

impl With {
    /// Divisors of the voxels across and upwards.
    fn coarser_volumes(plan: &FramePlan, divisors: [usize; 2]) -> Self {
        let one = |layer: &LayerPlan| {
            let shape = coarser(&DensityVolume::of(layer.kind).shape, [WIDTH, WIDTH, HEIGHT], divisors);
            let bounds = column_bounds(&shape);
            (shape, bounds)
        };
        Self::Volumes(plan.layers.iter().map(one).collect())
    }
}

impl Method {
    /// Name and values in one line.
    pub fn title(&self) -> String {
        let params: Vec<String> = self.params.iter().map(|(name, value)| format!("{name}={value}")).collect();
        format!("{} {}", self.name, params.join(" "))
    }
}

/// Every method of a case. `plan_for`: the plan of the case at a quality.
///
/// # Errors
/// Those of `plan_for`.
pub fn methods(
    quick: bool,
    plan_for: &dyn Fn(Quality) -> Result<FramePlan, Stopped>,
    has_gpu: bool,
) -> Result<Vec<Method>, Stopped> {
    let base = Quality { deck_scale: 1, ..DEFAULT_QUALITY };
    let mut found = Vec::new();
    let mut add = |name, params: &[(&'static str, f64)], quality, with| -> Result<(), Stopped> {
        found.push(Method { name, params: params.to_vec(), plan: plan_for(quality)?, with });
        Ok(())
    };
    let plan = plan_for(base)?;
    let all = |quick_values: &[u32], values: &[u32]| if quick { quick_values.to_vec() } else { values.to_vec() };
    for slices in all(&[4, 32, 128], &[4, 8, 16, 32, 64, 128]) {
        add("slices", &[("slices", f64::from(slices))], Quality { slices, ..base }, With::Reference)?;
    }
    for deck_scale in all(&[2, 4], &[2, 3, 4]) {
        let params = [("deck_scale", f64::from(deck_scale))];
        add("coarser deck", &params, Quality { deck_scale, ..base }, With::Reference)?;
    }
    for ring_ratio in if quick { vec![1.5] } else { vec![1.25, 1.5, 2.0, 8.0] } {
        add("rings", &[("ring_ratio", ring_ratio)], Quality { ring_ratio, ..base }, With::Reference)?;
    }
    for divisors in if quick { vec![[2, 1]] } else { vec![[2, 1], [1, 2], [2, 2], [4, 4]] } {
        let [across, up] = divisors;
        let params = [("voxels_across", (WIDTH / across) as f64), ("voxels_up", (HEIGHT / up) as f64)];
        add("coarser volume", &params, base, With::coarser_volumes(&plan, divisors))?;
    }
    for divisor in if quick { vec![2] } else { vec![2, 4, 8] } {
        let params = [("map_texels", (modulation::WIDTH / divisor) as f64)];
        add("coarser map", &params, base, With::Map(map(divisor)))?;
    }
    for (name, bits, light_encoding) in [
        ("light as shares", 8.0, Encoding::Shares8),
        ("light as shares", 16.0, Encoding::Shares16),
        ("light as vectors", 8.0, Encoding::Paper),
        ("light as vectors", 16.0, Encoding::Harmonics),
    ] {
        add(name, &[("bits", bits)], Quality { light_encoding, ..base }, With::Reference)?;
    }
    for step in if quick { vec![0.24] } else { vec![0.06, 0.12, 0.24] } {
        add("thetas of light", &[("step", f64::from(step))], base, With::Thetas(Some(step)))?;
    }
    add("one theta of light", &[], base, With::Thetas(None))?;
    let forms = [("GPU, instanced", DeckForm::Instanced), ("GPU, marched", DeckForm::Marched)];
    for (name, deck_form) in forms.into_iter().filter(|_| has_gpu) {
        for slices in all(&[32], &[8, 32, 128]) {
            add(name, &[("slices", f64::from(slices))], Quality { slices, deck_form, ..base }, With::Gpu)?;
        }
    }
    Ok(found)
}

/// Textures in place of those that the executor prepared.
#[derive(Clone, Copy)]
enum Other<'a> {
    Volumes(&'a [(Vec<u8>, Vec<u8>)]),
    Map(&'a [u8]),
}

/// Draws methods; keeps what the executors keep between pictures, so that only a first one pays for the light.
pub struct Drawer {
    reference: ReferenceExecutor,
    gpu: Option<GpuExecutor>,
}

impl Drawer {
    /// With a reference executor, and the GPU where there is one.
    pub fn new(reference: ReferenceExecutor) -> Self {
        Self { reference, gpu: GpuExecutor::new().ok() }
    }

    /// Whether there is a graphics adapter.
    pub fn has_gpu(&self) -> bool {
        self.gpu.is_some()
    }

    /// The linear picture by a method.
    ///
    /// # Errors
    /// [`Stopped::Failed`]: the graphics adapter failed.
    pub fn draw(&mut self, method: &Method) -> Result<Vec<f32>, Stopped> {
        let plan = &method.plan;
        let pixels = match &method.with {
            With::Reference => self.reference.draw(plan),
            With::Thetas(step) => self.reference.draw(&with_thetas(plan, *step)),
            With::Gpu => by_gpu(self.gpu.as_mut(), plan)?,
            With::Volumes(volumes) => self.with_textures(plan, Other::Volumes(volumes)),
            With::Map(map) => self.with_textures(plan, Other::Map(map)),
        };
        match pixels {
            Pixels::LinearRgb(values) => Ok(values),
            Pixels::Srgb8(_) => Err(Stopped::Failed("the plan is not for a linear picture".into())),
        }
    }

    /// A picture by the reference executor whose layers read `other` textures.
    fn with_textures(&mut self, plan: &FramePlan, other: Other) -> Pixels {
        self.reference.prepared(plan, |table, layers, casters, grids| {
            let changed: Vec<Prepared> = layers
                .iter()
                .enumerate()
                .map(|(i, layer)| {
                    let textures = match other {
                        Other::Volumes(volumes) => {
                            Textures { shape: &volumes[i].0, bounds: &volumes[i].1, ..layer.textures }
                        }
                        Other::Map(map) => Textures { map, ..layer.textures },
                    };
                    Prepared::new(layer.layer, textures)
                })
                .collect();
            reference::picture(plan, table, &changed, casters, grids)
        })
    }
}

/// A plan whose light is made for thetas at a distance from each other, or for the one that lies where the cloud that is there
/// has it in the mean: half of the map's range for the share that is covered.
pub fn with_thetas(plan: &FramePlan, step: Option<f32>) -> FramePlan {
    let mut plan = plan.clone();
    for LayerPlan { layer, light, .. } in &mut plan.layers {
        let typical = (layer.theta + 0.25 * layer.patchiness).max(0.01);
        let nodes = match step {
            Some(step) => Nodes::spaced(layer.theta, layer.patchiness, 1.0 / layer.inverse_edge, step),
            None => Nodes { first: 1, count: 1, step: typical },
        };
        light.iter_mut().for_each(|light| light.nodes = nodes);
        (layer.light_low, layer.light_per_theta, layer.light_nodes) =
            (nodes.theta(0), 1.0 / nodes.step, nodes.count as f32);
    }
    plan
}

/// The modulation map with its texels across divided.
fn map(divisor: usize) -> Vec<u8> {
    coarser(modulation::map(), [modulation::WIDTH, modulation::WIDTH, 1], [divisor, 1])
}

fn by_gpu(gpu: Option<&mut GpuExecutor>, plan: &FramePlan) -> Result<Pixels, Stopped> {
    let failed = |why: &dyn std::fmt::Display| Stopped::Failed(format!("graphics adapter: {why}"));
    let gpu = gpu.ok_or_else(|| failed(&"there is none"))?;
    gpu.submit(0, plan).map_err(|fault| failed(&fault))?;
    let finished = gpu.collect(true).map_err(|fault| failed(&fault))?;
    finished.into_iter().next().map(|f| f.pixels).ok_or_else(|| failed(&"it lost the picture"))
}

/// What a linear sampler reads from a texture with fewer texels, written down at the old size: means over blocks of
/// `[across, across, up]`, interpolated between the blocks' centres; wraps across, is clamped upwards.
fn coarser(texels: &[u8], [width, depth, height]: [usize; 3], [across, up]: [usize; 2]) -> Vec<u8> {
    let size = [width / across, depth / across, height / up];
    let blocks: Vec<f32> = (0..size[0] * size[1] * size[2])
        .map(|i| {
            let [x, y, z] = [i % size[0] * across, i / size[0] % size[1] * across, i / (size[0] * size[1]) * up];
            let mut sum = 0.0;
            for (dz, dy, dx) in each([up, across, across]) {
                sum += f32::from(texels[x + dx + width * (y + dy + depth * (z + dz))]);
            }
            sum / (across * across * up) as f32
        })
        .collect();
    // Centre of an old texel in coordinates of blocks: the two nearest and the share of the second.
    let split = |at: usize, by: usize, count: usize, wraps: bool| {
        let place = (at as f32 + 0.5) / by as f32 - 0.5;
        let low = place.floor();
        let index = |i: i32| {
            if wraps { i.rem_euclid(count as i32) as usize } else { i.clamp(0, count as i32 - 1) as usize }
        };
        ([index(low as i32), index(low as i32 + 1)], place - low)
    };
    (0..texels.len())
        .map(|i| {
            let ((x, fx), (y, fy), (z, fz)) = (
                split(i % width, across, size[0], true),
                split(i / width % depth, across, size[1], true),
                split(i / (width * depth), up, size[2], false),
            );
            let mut value = 0.0;
            for (a, b, c) in each([2, 2, 2]) {
                let weight = |share: f32, upper: usize| if upper == 1 { share } else { 1.0 - share };
                value +=
                    weight(fx, a) * weight(fy, b) * weight(fz, c) * blocks[x[a] + size[0] * (y[b] + size[1] * z[c])];
            }
            (value + 0.5) as u8
        })
        .collect()
}

/// Every triple below three counts.
fn each([a, b, c]: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..a).flat_map(move |i| (0..b).flat_map(move |j| (0..c).map(move |k| (i, j, k))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarser_texture_is_the_interpolated_mean_of_blocks() {
        // One row of four texels in blocks of two: means 10 and 30, wrapping.
        let row = [5, 15, 25, 35];
        assert_eq!(coarser(&row, [4, 1, 1], [1, 1]), row);
        let texels: Vec<u8> = [row; 4].concat();
        let found = coarser(&texels, [4, 4, 1], [2, 1]);
        // Centres at a quarter and three quarters between the blocks'.
        assert_eq!(found[..4], [15, 15, 25, 25]);
        // Upwards it is clamped: a column of 0, 20 becomes two means of 10.
        assert_eq!(coarser(&[0, 20], [1, 1, 2], [1, 2]), [10, 10]);
    }
}
