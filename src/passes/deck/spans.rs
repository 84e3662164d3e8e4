//! In which order the layers are walked: near to far along any ray, also where layers share heights.
//!
//! A ray meets layers that lie one above the other as wholes. Where two share heights each is cut at the other's base and
//! top, so that what towers over a lower layer hides the part of it that lies behind. Within a shared span the layer with
//! the lower base comes first on the way up: there the order is a choice.

use bytemuck::{Pod, Zeroable};

/// Heights between which one dispatch walks a layer. Parameters; twin of `Heights` in `march.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Heights {
    /// Lower end over the sphere.
    pub low_m: f32,
    /// Upper end.
    pub high_m: f32,
}

/// A part of a layer that is walked at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Which layer.
    pub layer: usize,
    /// Between which heights.
    pub heights: Heights,
    /// On the way down, to the ray's lowest point; otherwise on the way up, also beyond that point.
    pub falling: bool,
}

/// Spans at most: each is a walk over the whole picture. Where there are more, layers stay whole and their order by base is a
/// choice.
const MOST_SPANS: usize = 64;

/// The legs of layers given by base and top over the sphere, for an eye at a height.
pub fn legs(layers: &[[f32; 2]], eye_m: f32) -> Vec<Leg> {
    let mut spans: Vec<(usize, Heights)> =
        layers.iter().enumerate().flat_map(|(i, own)| pieces(*own, layers).map(move |heights| (i, heights))).collect();
    if spans.len() > MOST_SPANS.max(layers.len()) {
        spans = layers.iter().map(|[low_m, high_m]| Heights { low_m: *low_m, high_m: *high_m }).enumerate().collect();
    }
    spans.sort_by(|(i, a), (j, b)| a.low_m.total_cmp(&b.low_m).then(i.cmp(j)));
    let leg = |falling: bool| move |&(layer, heights): &(usize, Heights)| Leg { layer, heights, falling };
    let down = spans.iter().rev().filter(|(_, heights)| heights.low_m < eye_m).map(leg(true));
    down.chain(spans.iter().map(leg(false))).collect()
}

/// Whether the base or top of any layer lies inside another: then one must be walked in spans. (Two with the same base and
/// top are not cut.)
pub fn overlap(layers: &[[f32; 2]]) -> bool {
    layers.iter().any(|own| pieces(*own, layers).count() > 1)
}

/// A layer cut at the bases and tops of all that lie strictly inside it.
fn pieces(own: [f32; 2], layers: &[[f32; 2]]) -> impl Iterator<Item = Heights> {
    let mut cuts: Vec<f32> = layers.iter().flatten().copied().filter(|h| own[0] < *h && *h < own[1]).collect();
    cuts.extend(own);
    cuts.sort_by(f32::total_cmp);
    cuts.dedup();
    let ends = cuts.clone().into_iter().skip(1);
    cuts.into_iter().zip(ends).map(|(low_m, high_m)| Heights { low_m, high_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(legs: &[Leg]) -> Vec<(usize, f32, f32, bool)> {
        legs.iter().map(|l| (l.layer, l.heights.low_m, l.heights.high_m, l.falling)).collect()
    }

    #[test]
    fn layers_apart_stay_whole_and_only_those_below_the_eye_are_met_falling() {
        let layers = [[1000.0, 2000.0], [3000.0, 3500.0]];
        let up = [(0, 1000.0, 2000.0, false), (1, 3000.0, 3500.0, false)];
        assert_eq!(told(&legs(&layers, 500.0)), up);
        let inside = [vec![(0, 1000.0, 2000.0, true)], up.to_vec()].concat();
        assert_eq!(told(&legs(&layers, 2500.0)), inside);
        let above = [vec![(1, 3000.0, 3500.0, true), (0, 1000.0, 2000.0, true)], up.to_vec()].concat();
        assert_eq!(told(&legs(&layers, 9000.0)), above);
        assert!(!overlap(&layers));
        // Layers that only touch do not overlap.
        assert!(!overlap(&[[0.0, 1.0], [1.0, 2.0]]));
    }

    #[test]
    fn a_tower_is_cut_at_the_layer_that_it_rises_through() {
        let layers = [[900.0, 10_000.0], [1200.0, 1700.0]];
        let falling: Vec<_> = told(&legs(&layers, 6000.0)).into_iter().filter(|l| l.3).collect();
        let expected = [
            (0, 1700.0, 10_000.0, true),
            (1, 1200.0, 1700.0, true),
            (0, 1200.0, 1700.0, true),
            (0, 900.0, 1200.0, true),
        ];
        assert_eq!(falling, expected);
        assert!(overlap(&layers));
    }

    #[test]
    fn however_many_layers_overlap_the_walks_stay_few() {
        let layers: Vec<[f32; 2]> = (0..40).map(|i| [1000.0 + i as f32, 5000.0 + i as f32]).collect();
        assert_eq!(legs(&layers, 20_000.0).len(), 80, "whole layers, each down and up");
        let few: Vec<[f32; 2]> = layers[..4].to_vec();
        assert!(legs(&few, 20_000.0).len() > 8);
    }

    #[test]
    fn two_equal_layers_are_both_walked_once_each_way() {
        let layers = [[1000.0, 2000.0]; 2];
        assert_eq!(legs(&layers, 1500.0).len(), 4);
        assert!(!overlap(&layers));
    }
}
