//! A few lights that stand for a channel: its light divided again and again where it is heaviest and widest.

use super::{Lit, StrikeChannel};
use glam::DVec3;

/// A light that stands for a part of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Centre of the part's light: east, north and up from the strike's ground point.
    pub position_m: [f32; 3],
    /// From there to either end of an even line that has the same spread along its axis.
    pub half_m: [f32; 3],
    /// Light of the part, in the unit of the lights that it is lit by.
    pub weight: f64,
}

/// Pieces of a channel longer than this are not divided by points: below it, the grid's cells, light is even enough.
const PIECE_M: f32 = 3.0;

/// A piece of a line: where its light is, and how much.
#[derive(Clone, Copy)]
struct Piece {
    at: DVec3,
    /// Half of its extent.
    half: DVec3,
    weight: f64,
}

/// A part of the channel.
struct Part {
    pieces: Vec<Piece>,
    /// Weight times mean square extent: the error of putting it into one point.
    spread: f64,
}

/// At most `count` sources, in an order that depends on the channel alone.
pub(super) fn sources(channel: &StrikeChannel, count: usize, lit: &Lit) -> Vec<Source> {
    let mut pieces = Vec::new();
    channel.visit(PIECE_M, |stretch| {
        let weight = lit.of(channel, &stretch);
        if weight > 0.0 {
            let [a, b] = [stretch.from, stretch.to]
                .map(|point| DVec3::from_array(channel.points[point as usize].position_m.map(f64::from)));
            pieces.push(Piece { at: 0.5 * (a + b), half: 0.5 * (b - a), weight });
        }
    });
    if pieces.is_empty() || count == 0 {
        return Vec::new();
    }
    let mut divided = vec![Part::new(pieces)];
    while divided.len() < count {
        let widest = (0..divided.len()).max_by(|&a, &b| divided[a].spread.total_cmp(&divided[b].spread));
        let Some(widest) = widest.filter(|&part| divided[part].pieces.len() > 1) else { break };
        let (low, high) = divided.swap_remove(widest).halves();
        divided.push(low);
        divided.push(high);
    }
    let mut found: Vec<Source> = divided.iter().map(Part::source).collect();
    found.sort_by(|a, b| a.position_m[2].total_cmp(&b.position_m[2]));
    found
}

impl Part {
    fn new(pieces: Vec<Piece>) -> Self {
        let mut part = Self { pieces, spread: 0.0 };
        let [xx, yy, zz, ..] = part.moments();
        part.spread = part.weight() * (xx + yy + zz);
        part
    }

    fn weight(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.weight).sum()
    }

    fn centre(&self) -> DVec3 {
        self.pieces.iter().map(|piece| piece.at * piece.weight).sum::<DVec3>() / self.weight()
    }

    /// Mean squares and products of distances from the centre: xx, yy, zz, xy, xz, yz.
    fn moments(&self) -> [f64; 6] {
        let (centre, weight) = (self.centre(), self.weight());
        let mut sums = [0.0; 6];
        for piece in &self.pieces {
            let d = piece.at - centre;
            // An even line of half length h has the mean square h^2 / 3.
            let h = piece.half / 3.0_f64.sqrt();
            let products = |v: DVec3| [v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z];
            for (sum, (a, b)) in sums.iter_mut().zip(products(d).into_iter().zip(products(h))) {
                *sum += piece.weight * (a + b) / weight;
            }
        }
        sums
    }

    /// Two parts of about half the light, cut across the axis along which it is widest.
    fn halves(mut self) -> (Self, Self) {
        let [xx, yy, zz, ..] = self.moments();
        let axis = if zz >= xx && zz >= yy { 2 } else { usize::from(yy > xx) };
        self.pieces.sort_by(|a, b| a.at[axis].total_cmp(&b.at[axis]));
        let half = 0.5 * self.weight();
        let mut sum = 0.0;
        let cut = self.pieces.iter().position(|piece| {
            sum += piece.weight;
            sum >= half
        });
        let cut = cut.unwrap_or(0).clamp(1, self.pieces.len() - 1);
        let high = self.pieces.split_off(cut);
        (Self::new(self.pieces), Self::new(high))
    }

    fn source(&self) -> Source {
        let [xx, yy, zz, xy, xz, yz] = self.moments();
        // The widest axis of the spread by power iteration; where two are nearly alike either serves.
        let mut axis = DVec3::new(xx + xy + xz, xy + yy + yz, xz + yz + zz).normalize_or(DVec3::Z);
        let turned = |v: DVec3| {
            DVec3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
        };
        for _ in 0..24 {
            axis = turned(axis).normalize_or(axis);
        }
        let half = axis * (3.0 * axis.dot(turned(axis)).max(0.0)).sqrt();
        let position_m = self.centre().as_vec3().to_array();
        Source { position_m, half_m: half.as_vec3().to_array(), weight: self.weight() }
    }
}
