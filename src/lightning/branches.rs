//! Main channel and side channels: what belongs to which, and how thick and bright it is.
//!
//! Yun et al., section 4.3: the main channel leads from the start to the target, thick and evenly bright; side channels are half as
//! thick and fade with their distance from it. What is added here: a short twig starts fainter than a long branch, as the less
//! charge that runs through it would have it.

use super::channel::Channel;
use crate::numeric::exact::pow;

/// How side channels look against the main channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Appearance {
    /// Thickness of a side channel, of the main channel's.
    pub side_thickness: f64,
    /// Brightness at which the longest side channel leaves the main channel, of the main channel's.
    pub side_brightness: f64,
    /// How much fainter short side channels start: the exponent of their length as a share of the longest one's; 0 for all alike.
    pub twig_exponent: f64,
}

impl Default for Appearance {
    fn default() -> Self {
        Self { side_thickness: 0.5, side_brightness: 0.6, twig_exponent: 0.5 }
    }
}

/// What each node of a channel is, by its number.
#[derive(Clone, Debug, PartialEq)]
pub struct Branches {
    /// 0 on the main channel, 1 on what leaves it, one more where a side channel is left by a shorter one.
    pub order: Vec<u32>,
    /// Length along the channel from the start, in cells.
    pub along: Vec<f64>,
    /// Length along side channels from the main channel, in cells; 0 on it.
    pub beside: Vec<f64>,
    /// Thickness, 0 to 1.
    pub thickness: Vec<f64>,
    /// Brightness, 0 to 1; 0 at the tip of a side channel.
    pub brightness: Vec<f64>,
    /// The node on which the same line goes on; none at a tip.
    pub next: Vec<Option<u32>>,
}

/// Divides a channel into main and side channels.
///
/// The main channel is every way from the start to a target that was reached; where none was, the longest way there is.
pub fn branches(channel: &Channel, appearance: &Appearance) -> Branches {
    let count = channel.nodes.len();
    let mut along = vec![0.0; count];
    for node in 1..count {
        along[node] = along[channel.nodes[node].parent as usize] + channel.step_length(node);
    }
    // Length from a node to the farthest tip behind it.
    let mut ahead = vec![0.0_f64; count];
    for node in (1..count).rev() {
        let parent = channel.nodes[node].parent as usize;
        ahead[parent] = ahead[parent].max(ahead[node] + channel.step_length(node));
    }
    let mut main = vec![false; count];
    let farthest = (0..count).max_by(|&a, &b| along[a].total_cmp(&along[b])).unwrap_or_default() as u32;
    let ends = if channel.ends.is_empty() { &[farthest][..] } else { &channel.ends[..] };
    for node in ends.iter().flat_map(|&end| channel.path_to(end)) {
        main[node as usize] = true;
    }
    // A line goes on with the main channel, else with the child that leads farthest.
    let mut next: Vec<Option<u32>> = vec![None; count];
    for node in 1..count {
        let better = |other: u32| {
            let far = |node: usize| (main[node], ahead[node] + channel.step_length(node));
            let ((here_main, here), (other_main, there)) = (far(node), far(other as usize));
            (here_main && !other_main) || (here_main == other_main && here > there)
        };
        let slot = &mut next[channel.nodes[node].parent as usize];
        if slot.is_none_or(better) {
            *slot = Some(node as u32);
        }
    }
    let mut order = vec![0; count];
    let mut beside = vec![0.0; count];
    let mut reach = vec![0.0; count];
    for node in 1..count {
        let parent = channel.nodes[node].parent as usize;
        if main[node] {
            continue;
        }
        let goes_on = !main[parent] && next[parent] == Some(node as u32);
        order[node] = order[parent] + u32::from(!goes_on);
        beside[node] = beside[parent] + channel.step_length(node);
        reach[node] = if goes_on { reach[parent] } else { beside[node] + ahead[node] };
    }
    let longest = reach.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let look = |node: usize| {
        if main[node] {
            return (1.0, 1.0);
        }
        let start = appearance.side_brightness * pow(reach[node] / longest, appearance.twig_exponent);
        (appearance.side_thickness, start * (1.0 - beside[node] / reach[node]).max(0.0))
    };
    let (thickness, brightness) = (0..count).map(look).unzip();
    Branches { order, along, beside, thickness, brightness, next }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lightning::channel::Node;

    /// A main channel of 5 nodes down the y axis; from its second node a side channel of 3 with a twig of 1.
    fn channel() -> Channel {
        let node = |x: f64, y: f64, parent| Node { position: [x, y, 0.0], parent };
        let nodes = vec![
            node(0.0, 4.0, 0),
            node(0.0, 3.0, 0),
            node(0.0, 2.0, 1),
            node(1.0, 3.0, 1),
            node(2.0, 3.0, 3),
            node(1.0, 4.0, 3),
            node(0.0, 1.0, 2),
            node(3.0, 3.0, 4),
            node(0.0, 0.0, 6),
        ];
        Channel { nodes, ends: vec![8] }
    }

    #[test]
    fn main_and_side_channels_by_hand() {
        let found = branches(&channel(), &Appearance { twig_exponent: 1.0, ..Default::default() });
        assert_eq!(found.order, [0, 0, 0, 1, 1, 2, 0, 1, 0]);
        assert_eq!(found.along, [0.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0, 4.0, 4.0]);
        assert_eq!(found.beside, [0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 0.0, 3.0, 0.0]);
        assert_eq!(found.next, [Some(1), Some(2), Some(6), Some(4), Some(7), None, Some(8), None, None]);
        assert_eq!(found.thickness[3..6], [0.5; 3]);
        // The long one starts at 0.6 and loses a third a cell; the twig, of reach 2 of 3, is at its tip.
        let expected = [1.0, 1.0, 1.0, 0.4, 0.2, 0.0, 1.0, 0.0, 1.0];
        assert!(found.brightness.iter().zip(expected).all(|(b, e)| (b - e).abs() < 1e-12), "{:?}", found.brightness);
    }

    #[test]
    fn without_a_target_the_longest_way_is_the_main_channel() {
        let free = Channel { ends: Vec::new(), ..channel() };
        assert_eq!(branches(&free, &Appearance::default()).order[8], 0);
        let one = Channel { nodes: vec![channel().nodes[0]], ends: Vec::new() };
        assert_eq!(branches(&one, &Appearance::default()).brightness, [1.0]);
    }
}
