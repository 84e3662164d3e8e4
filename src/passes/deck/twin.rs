//! Twin of `walk.wgsl` and `march.wgsl`: walks the stretches of a ray that lie inside layers, from near to far.

use super::clumps::{self, VARIED_M, varied};
use super::field::{Look, Step, Textures, city_glow, light_at, look, relieved, shown, source, view};
use super::spans::{Heights, Leg};
use super::{FLASH_COLOUR, Layer};
use crate::passes::common::Camera;
use crate::passes::light::encoding::decode;
use crate::passes::relight::{self, twin::scattered};
use glam::Vec3;

/// Transmittance at which a pixel counts as opaque: what is behind adds less than this share.
pub const OPAQUE: f32 = 0.004;

/// What a ray has gathered: luminance towards the eye, and how much of what is behind still passes.
#[derive(Clone, Copy, Debug)]
pub struct Gathered {
    /// cd/m2 per colour.
    pub luminance: Vec3,
    /// 0 to 1.
    pub transmittance: f32,
}

/// One layer ready to be walked.
pub struct Prepared<'a> {
    /// Parameters.
    pub layer: &'a Layer,
    /// What its look-ups read.
    pub textures: Textures<'a>,
    /// Fields of flashes' light in the clouds, if any.
    pub lit: Option<&'a relight::Prepared>,
}

impl<'a> Prepared<'a> {
    /// A layer with what its look-ups read.
    pub fn new(layer: &'a Layer, textures: Textures<'a>) -> Self {
        Self { layer, textures, lit: None }
    }

    /// The same, lit by flashes' fields.
    #[must_use]
    pub fn lit_by(self, lit: &'a relight::Prepared) -> Self {
        Self { lit: Some(lit).filter(|lit| lit.lits.fields > 0), ..self }
    }
}

/// One ray.
struct Ray<'a> {
    camera: &'a Camera,
    direction: Vec3,
    /// Horizontal share of the direction.
    flat: f32,
    /// Range at which the ground (or the end of sight) stops it.
    end_m: f32,
    /// Luminance of the air behind, per unit of what the air hides.
    air: Vec3,
}

/// Walks the legs of layers (see [`super::spans::legs`]) along a ray that ends at `end_m`; `air` is the luminance of an
/// infinite column of air along it.
pub fn walk(camera: &Camera, layers: &[Prepared], legs: &[Leg], direction: Vec3, end_m: f32, air: Vec3) -> Gathered {
    let flat = (1.0 - direction.z * direction.z).max(0.0).sqrt();
    let ray = Ray { camera, direction, flat, end_m, air };
    let mut gathered = Gathered { luminance: Vec3::ZERO, transmittance: 1.0 };
    for leg in legs {
        ray.leg(&layers[leg.layer], leg, &mut gathered);
    }
    gathered
}

impl Ray<'_> {
    /// A span of a layer's heights on the way down or on the way up.
    fn leg(&self, prepared: &Prepared, leg: &Leg, gathered: &mut Gathered) {
        let (layer, up, down) = (prepared.layer, self.direction.z, leg.falling);
        if gathered.transmittance < layer.hidden_below || (down && up >= 0.0) {
            return;
        }
        let r = self.camera.earth_m + self.camera.eye_m;
        let lowest_t = (-r * up).max(0.0);
        let Heights { low_m: base, high_m: top } = leg.heights;
        let cross = |height: f32| {
            let (falling, rising) = self.camera.crossings(up, height);
            if down { falling } else { rising }
        };
        let eye = self.camera.eye_m;
        let (from, to) = if down {
            // A shell that the ray does not reach turns the leg at the lowest point.
            (if eye > top { cross(top) } else { 0.0 }, cross(base).min(lowest_t))
        } else {
            let begin = cross(base);
            (if begin.is_finite() && (eye < base || up < 0.0) { begin } else { lowest_t }, cross(top))
        };
        // What the ray rises through is left through its upper end, or not met.
        if to.is_infinite() {
            return;
        }
        let to = to.min(self.end_m).min(layer.extent_m / self.flat.max(1e-3));
        let [enters, leaves] = layer.bounded(self.camera.eye_m, self.direction);
        let (from, to) = (from.max(enters), to.min(leaves));
        // Infinite where the leg does not meet the layer.
        if from >= to {
            return;
        }
        self.stretch(prepared, from, to, gathered);
    }

    /// What lies between two ranges, near to far, until nothing passes any more.
    fn stretch(&self, prepared: &Prepared, from: f32, to: f32, gathered: &mut Gathered) {
        let layer = prepared.layer;
        let steps = Steps::new(self.camera, layer);
        let mut at = from;
        let Look { margin: mut near, beyond_m: mut beyond } = self.look(prepared, at, steps.shortest_m(at));
        // Where a straight line between two looks enters a cloud.
        let mut edge: Option<f32> = None;
        for _ in 0..MOST_LOOKS {
            let end = edge.filter(|edge| *edge > at).unwrap_or_else(|| to.min(steps.next_look(at, beyond)));
            let found = self.look(prepared, end, steps.shortest_m(end));
            let far = found.margin;
            // A long step that ends inside the cloud went too far: its edge is looked for.
            if near < 0.0 && far > 0.0 && steps.is_long(at, end) {
                beyond *= RETREAT;
                continue;
            }
            // A long step that enters a cloud ends at its edge first, or stripes would show where the looks stood.
            if near < 0.0 && far > 0.0 && edge.is_none() && end - at > EDGE_STEP_M {
                edge = Some(at + (end - at) * (near / (near - far)));
                continue;
            }
            // Where it lies a little further than expected, once is enough.
            edge = edge.filter(|edge| *edge >= end && far <= 0.0);
            let ends = [near, far].map(|margin| margin * layer.inverse_edge);
            let whole = mean_clamped(ends[0], ends[1]);
            if whole > 0.0 {
                let share = seen_share(ends, layer.extinction_per_m * (end - at) * whole);
                self.gather(prepared, at + (end - at) * share, (end - at) * whole, gathered);
            }
            if gathered.transmittance < layer.hidden_below || end >= to {
                break;
            }
            (at, near, beyond) = (end, far, found.beyond_m);
        }
    }

    fn look(&self, prepared: &Prepared, t: f32, step_m: f32) -> Look {
        let p = self.direction * t + Vec3::new(0.0, 0.0, self.camera.eye_m);
        let height = self.camera.height_at(self.direction.z, t);
        let r = self.camera.earth_m;
        let sine = ((r + self.camera.eye_m) * self.direction.z + t) / (r + height);
        look(prepared.layer, &prepared.textures, r, p, height, &Step { t_m: t, length_m: step_m, sine })
    }

    /// Adds cloud of a given path length at full extinction, as it is lit at range `t`.
    fn gather(&self, prepared: &Prepared, t: f32, path_m: f32, gathered: &mut Gathered) {
        let layer = prepared.layer;
        let height = self.camera.height_at(self.direction.z, t);
        let p = self.direction * t + Vec3::new(0.0, 0.0, self.camera.eye_m);
        let density = varied(layer, &prepared.textures, self.camera.earth_m, p, height, t);
        let alpha = 1.0 - (-layer.extinction_per_m * path_m * density).exp();
        let passed = self.camera.air_transmittance(height, t);
        let light = light_at(layer, &prepared.textures, self.camera.earth_m, p, height);
        let shown = shown(layer, &prepared.textures, self.camera.earth_m, p, height)
            * relieved(layer, &prepared.textures, self.camera.earth_m, p, height, t);
        let view = view(layer, self.direction);
        let mut lit = source(layer, light, &view, p, height, shown);
        if prepared.textures.glow.is_some() {
            let from_below = decode(layer.encoding(), light, &view).ground;
            lit += city_glow(layer, &prepared.textures, self.camera.earth_m, p, height, from_below);
        }
        if let Some(fields) = prepared.lit {
            lit += FLASH_COLOUR * scattered(&fields.lits, &fields.fields, p, height, -self.direction);
        }
        let seen = lit * passed + self.air * (1.0 - passed);
        gathered.luminance += seen * (alpha * gathered.transmittance);
        gathered.transmittance *= 1.0 - alpha;
    }
}

/// Pixels across which a step reaches from the range on at which it has grown far beyond its shortest: more draws grazing
/// silhouettes as stripes.
const STEP_PIXELS: f32 = 3.5;
/// Least and greatest growth of a step with the range: very fine pictures end somewhere, coarse ones must not miss clouds.
const STEP_GROWTH: [f32; 2] = [0.004, 0.025];
/// What is left of a leap that ended inside the cloud.
const RETREAT: f32 = 0.25;
/// Steps up to this one find the edge well enough by a straight line between their ends, m.
const EDGE_STEP_M: f32 = 90.0;
/// Looks through one piece at most: twice as many as the finest steps to the end of sight, since some go too far.
const MOST_LOOKS: u32 = 4_096;

/// The ladder on whose rungs looks stand, the same for all rays of a picture and however many are left out: leaving out changes
/// no picture, and neighbouring pixels find the same cloud at the same range.
struct Steps {
    at_eye_m: f32,
    growth: f32,
    /// Whether there are rungs between those of the ladder around the eye.
    varied: bool,
}

impl Steps {
    /// Steps grow with the range, as pixels do.
    fn new(camera: &Camera, layer: &Layer) -> Self {
        let pixel_rad = 2.0 * Vec3::from(camera.up).length() / camera.height_px;
        let growth = (STEP_PIXELS * pixel_rad).clamp(STEP_GROWTH[0], STEP_GROWTH[1]);
        Self { at_eye_m: layer.step_m, growth, varied: layer.varied > 0.0 }
    }

    /// Rungs for each of the ladder's: clumps are finer than its steps.
    fn rungs_between(&self, at: f32) -> f32 {
        if self.varied && at < VARIED_M[1] { clumps::RUNGS } else { 1.0 }
    }

    /// The step at the cloud's edge and inside.
    fn shortest_m(&self, at: f32) -> f32 {
        (self.at_eye_m + self.growth * at) / self.rungs_between(at)
    }

    /// Whether a look went further than one step: from between two rungs one step reaches past the next by the rounding.
    fn is_long(&self, at: f32, end: f32) -> bool {
        end - at > (1.0 + 3.0 * RUNG_ROUNDING) * self.shortest_m(at)
    }

    /// The range of the next look: the next rung, or the last one that surely lies outside the cloud, which is `beyond` away.
    /// Rungs are counted from the eye and not from where the ray enters a layer, which for a level ray moves by hundreds of
    /// metres when the eye rises by one.
    fn next_look(&self, at: f32, beyond: f32) -> f32 {
        let origin = self.at_eye_m / self.growth;
        let surely = at + self.shortest_m(at) + beyond;
        let octaves = (1.0 + self.growth).log2();
        let step = (surely / origin + 1.0).log2() / octaves;
        let between = self.rungs_between(at);
        let rung = |step: f32| origin * (step * octaves).exp2() - origin;
        let whole = rung((step + RUNG_ROUNDING).floor());
        // Far away all rays keep to the ladder's own.
        if between > 1.0 && (surely < VARIED_M[1] || whole <= at) {
            rung((step * between + RUNG_ROUNDING).floor() / between)
        } else {
            whole
        }
    }
}

/// Share of a step by which a rung may lie beyond where it surely may: else one that rounds down would be looked for twice.
const RUNG_ROUNDING: f32 = 0.01;

/// Where between two looks that which is seen of the cloud lies, as a share of the way: about a free path behind its edge,
/// however long the step is, so that the look that happens to find it does not show. `near` and `far` are margins over the
/// edge's width, `depth` is the optical depth between.
pub fn seen_share([near, far]: [f32; 2], depth: f32) -> f32 {
    let begin = (-near / (far - near).max(1e-6)).clamp(0.0, 1.0);
    let end = if far < 0.0 { (near / (near - far).max(1e-6)).clamp(0.0, 1.0) } else { 1.0 };
    let (n, f) = (near.clamp(0.0, 1.0), far.clamp(0.0, 1.0));
    let middle = (n + 2.0 * f) / (3.0 * (n + f)).max(1e-6);
    begin + (end - begin) * middle / (1.0 + middle * middle * depth * depth).sqrt()
}

/// Mean of clamp(m, 0, 1) while m runs evenly from `a` to `b` (pre-integration: a slab that cloud enters half-way
/// counts half, so that slices do not show as lines).
pub fn mean_clamped(a: f32, b: f32) -> f32 {
    // Antiderivative of clamp: 0, then m^2 / 2, then m - 1/2.
    let sum = |m: f32| {
        let c = m.clamp(0.0, 1.0);
        0.5 * c * c + (m - 1.0).max(0.0)
    };
    if (b - a).abs() < 1e-4 { (0.5 * (a + b)).clamp(0.0, 1.0) } else { (sum(b) - sum(a)) / (b - a) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_seen_of_a_step_lies_a_free_path_behind_the_edge() {
        // Whole cloud: the mean of the place by what is seen of it is 1 / tau - 1 / (e^tau - 1).
        for depth in [0.01f32, 0.5, 1.0, 2.0, 5.0, 50.0] {
            let exact = 1.0 / depth - 1.0 / depth.exp_m1();
            // The root that joins thin and thick in one line is off by 0.03 of the step at most.
            assert!((seen_share([3.0, 3.0], depth) - exact).abs() < 0.03, "{depth}");
        }
        // Thin cloud: the middle of a density that grows or falls evenly, from or to the edge.
        assert!((seen_share([0.0, 1.0], 1e-3) - 2.0 / 3.0).abs() < 1e-3);
        assert!((seen_share([1.0, 0.0], 1e-3) - 1.0 / 3.0).abs() < 1e-3);
        assert!((seen_share([-1.0, 1.0], 1e-3) - 5.0 / 6.0).abs() < 1e-3);
        assert!((seen_share([1.0, -1.0], 1e-3) - 1.0 / 6.0).abs() < 1e-3);
        // Thick cloud: the edge, wherever the looks stand.
        for edge in [0.1f32, 0.5, 0.9] {
            assert!((seen_share([-edge * 9.0, (1.0 - edge) * 9.0], 1e4) - edge).abs() < 1e-3);
        }
    }

    #[test]
    fn many_steps_at_once_end_on_the_same_rungs_as_one_by_one() {
        for (at_eye_m, growth, varied) in [
            (4.0, 0.004, false),
            (37.0, 0.0126, false),
            (1_200.0, 0.025, false),
            (37.0, 0.0126, true),
            (4.0, 0.004, true),
        ] {
            let steps = Steps { at_eye_m, growth, varied };
            // From anywhere, a step that nothing lengthens is not a long one: it would be taken back for ever.
            for k in 0..20_000 {
                let at = 1.37 * k as f32;
                let end = steps.next_look(at, 0.0);
                assert!(end > at && !steps.is_long(at, end), "{at}: {end}");
            }
            for begin in [0.0f32, 800.0, 12_345.0] {
                let rungs: Vec<f32> =
                    std::iter::successors(Some(begin), |at| Some(steps.next_look(*at, 0.0))).take(60).collect();
                for (rung, at) in rungs.iter().enumerate().take(20) {
                    for beyond in [0.0, 0.5 * steps.shortest_m(*at), 700.0, 2_500.0] {
                        let end = steps.next_look(*at, beyond);
                        let nearest =
                            rungs.iter().skip(rung + 1).map(|t| (t - end).abs()).fold(f32::INFINITY, f32::min);
                        // Rungs are computed one by one: some 1e-6 of the range and the steps' origin.
                        assert!(nearest < 0.1 || end > rungs[59], "{at} {beyond}: {end} is {nearest} from a rung");
                        let step = steps.shortest_m(*at);
                        let furthest = at + step + beyond;
                        let most = furthest + 2.0 * RUNG_ROUNDING * steps.shortest_m(furthest);
                        assert!(end > *at && end <= most, "{at} {beyond}: {end}");
                        // No rung that is surely outside is left for later.
                        let next = steps.next_look(end, 0.0);
                        assert!(next > furthest - 0.1 || beyond < steps.shortest_m(*at), "{at} {beyond}: {end} {next}");
                    }
                }
            }
        }
    }
}
