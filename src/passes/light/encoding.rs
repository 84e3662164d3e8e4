//! How the light of a voxel is stored in four values of a texel, and what is read from them: twin of `lit` in `lit.wgsl`.
//!
//! *Shares* keep the beam, the diffuse light, what passes the slab, and the sky's light: what the beam's lobe needs and the
//! sky's own way in. Square roots, so that dark values keep relative precision in 8 bits. *Harmonics* keep the spherical
//! harmonics of degree 0 and 1 of all light of the source: its mean and its net flux as a vector; the sky's light is taken to
//! spread as the source's does. *The paper's* (section 3.2) is the same in 8 bits, vectors as n/2 + 0.5.

use super::{FLUX_FACTOR, Shares};
use glam::{Vec3, Vec4};

/// How light is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Four shares in 8 bits each.
    #[default]
    Shares8,
    /// Four shares in f16.
    Shares16,
    /// Mean and flux vector in f16.
    Harmonics,
    /// Mean and flux vector in 8 bits each, as in the deck paper.
    Paper,
}

/// Diffuse values are stored as shares of this, and so are means.
const RANGE: f32 = 5.0;
/// What is left of the beam in reduced depths, as a power of what is left by [`super::LEAVING`].
const LEFT_POWER: f32 = (1.0 - super::ASYMMETRY) / super::LEAVING;

impl Encoding {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Shares8, Self::Shares16, Self::Harmonics, Self::Paper];

    /// Whether texels are four bytes; else they are four f16.
    pub fn in_bytes(self) -> bool {
        matches!(self, Self::Shares8 | Self::Paper)
    }

    /// Whether a texel holds the flux as a vector.
    pub fn is_vector(self) -> bool {
        matches!(self, Self::Harmonics | Self::Paper)
    }

    /// The four values of a voxel; `direction` towards the light in the axes of the volume.
    pub fn encode(self, light: &Shares, direction: [f32; 3]) -> [f32; 4] {
        if !self.is_vector() {
            let Shares { beam, diffuse, through, sky, .. } = *light;
            return [beam, diffuse / RANGE, through, 0.25 * sky].map(|v| v.clamp(0.0, 1.0).sqrt());
        }
        let direction = Vec3::from(direction);
        let facet = Vec3::Z * (1.0 - light.facing) + direction * light.facing;
        let cosine = direction.z + (1.0 - direction.z) * light.facing;
        let flux = -direction * light.beam - facet * (cosine * (light.through - light.beam.powf(LEFT_POWER)));
        let mean = light.beam + light.diffuse;
        match self {
            Self::Harmonics => [flux.x, flux.y, flux.z, mean],
            _ => {
                let half = flux * 0.5 + 0.5;
                [half.x, half.y, half.z, (mean / RANGE).sqrt()].map(|v| v.clamp(0.0, 1.0))
            }
        }
    }
}

/// A ray of the picture as light that comes along it sees it.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// From the eye, in the axes of the volume's chart where these differ from east, north, up.
    pub direction: Vec3,
    /// Towards the light.
    pub light: Vec3,
    /// Phase functions for light from the source, 1/sr: narrow and broad.
    pub lobes: [f32; 2],
}

/// What of the light outside a point sends towards the eye, 1/sr: from the source (of its illuminance of a plane facing it),
/// from the sky and from below (of 1 / (4 pi) of their illuminance of the level plane).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lit {
    /// From the source.
    pub source: f32,
    /// From the sky.
    pub sky: f32,
    /// From below.
    pub ground: f32,
}

/// What a texel says; values as a sampler reads them.
pub fn decode(encoding: Encoding, stored: Vec4, view: &View) -> Lit {
    let mu = view.light.z.max(super::grid::LEAST_UP);
    let up = view.direction.z;
    let per_steradian = 0.079_577_47;
    let (source, sky, net);
    if encoding.is_vector() {
        let (flux, mean) = match encoding {
            Encoding::Harmonics => (stored.truncate(), stored.w),
            _ => (stored.truncate() * 2.0 - 1.0, RANGE * stored.w * stored.w),
        };
        source = per_steradian * (mean - FLUX_FACTOR * flux.dot(view.direction)).max(0.0);
        sky = (mean * (4.0 / (1.0 + 2.0 * mu))).min(4.0);
        net = (-flux.z / mu).clamp(0.0, 1.0).min(0.5 * sky);
    } else {
        let shares = stored * stored;
        let (beam, diffuse, through) = (shares.x, RANGE * shares.y, shares.z);
        sky = 4.0 * shares.w;
        // Lit, but deep below the zenith: a flank.
        let facing = (2.0 * beam * (1.0 - shares.w)).min(1.0);
        let cosine = mu + (1.0 - mu) * facing;
        // What leaves the beam in reduced depths: the power 1.25.
        let flux = cosine * (through - beam * beam.sqrt().sqrt());
        let along = up + (view.direction.dot(view.light) - up) * facing;
        source = beam * (view.lobes[1] + (view.lobes[0] - view.lobes[1]) * beam)
            + per_steradian * (diffuse + FLUX_FACTOR * flux * along).max(0.0);
        // The same slab under diffuse light.
        net = (through * ((4.0 / 3.0) / (2.0 / 3.0 + mu))).min(0.5 * sky);
    }
    let from_above = (sky + FLUX_FACTOR * net * up).clamp(0.0, 4.0);
    Lit { source, sky: from_above, ground: 4.0 - from_above }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_encoding_gives_back_the_mean_and_the_flux() {
        let direction = Vec3::new(0.48, 0.36, 0.8);
        let light = Shares { beam: 0.3, diffuse: 1.4, through: 0.4, sky: 2.0, facing: 0.25 };
        let mean = 0.3 + 1.4;
        for encoding in Encoding::ALL.into_iter().filter(|e| e.is_vector()) {
            let stored = Vec4::from(encoding.encode(&light, direction.into()));
            let seen = |d: Vec3| {
                let view = View { direction: d, light: direction, lobes: [0.0; 2] };
                decode(encoding, stored, &view).source * 12.566_37
            };
            // Opposite directions add up to twice the mean; their difference is the flux.
            let d = Vec3::new(0.0, 0.6, 0.8);
            assert!((seen(d) + seen(-d) - 2.0 * mean).abs() < 1e-3, "{encoding:?}");
            assert!(seen(Vec3::Z) > seen(Vec3::NEG_Z) + 0.1, "light comes from above: {encoding:?}");
        }
        let stored = Vec4::from(Encoding::Shares8.encode(&light, direction.into()));
        assert!((stored * stored - Vec4::new(0.3, 0.28, 0.4, 0.5)).abs().max_element() < 1e-6);
    }

    #[test]
    fn an_even_light_shows_nothing_of_the_cloud() {
        for (sky, through) in [(0.4, 0.1), (2.0, 0.3), (3.8, 0.1)] {
            let light = Shares { beam: 0.0, diffuse: 0.0, through, sky, facing: 0.0 };
            let stored = Vec4::from(Encoding::Shares16.encode(&light, [0.0, 0.0, 1.0]));
            for direction in [Vec3::Z, Vec3::NEG_Z, Vec3::X] {
                let lit = decode(Encoding::Shares16, stored, &View { direction, light: Vec3::Z, lobes: [0.0; 2] });
                // The square root and its square in f32.
                assert!((lit.sky + lit.ground - 4.0).abs() < 1e-5, "{sky} {direction}: {lit:?}");
            }
        }
    }
}
