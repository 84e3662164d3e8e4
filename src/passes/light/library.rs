//! The nodes that have been made, for all executors of the process, and those that will be needed next.
//!
//! A node is a function of its key alone, so that it does not matter who made it or when: a picture that needs one that is not
//! there makes it; one that has been made ahead is there. What is drawn is the same.

use super::encoding::Encoding;
use super::node::{self, Node};
use super::volume::{Texels, VOXELS, stored};
use super::{Corner, Light, Shares, grid};
use crate::clouds::CloudKind;
use crate::clouds::density::DensityVolume;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Nodes kept (2 or 4 MiB each).
const KEPT: usize = 96;

type Key = (CloudKind, Node, Encoding);
type Slot = Arc<OnceLock<Arc<Texels>>>;

static NODES: Mutex<VecDeque<(Key, Slot)>> = Mutex::new(VecDeque::new());

fn nodes() -> MutexGuard<'static, VecDeque<(Key, Slot)>> {
    NODES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The place of a node, made where it is not there yet, as the one used last.
fn slot(key: &Key) -> Slot {
    let mut nodes = nodes();
    let found = nodes.iter().position(|(k, _)| k == key).and_then(|at| nodes.remove(at));
    let entry = found.unwrap_or_else(|| (*key, Slot::default()));
    let slot = entry.1.clone();
    nodes.push_front(entry);
    nodes.truncate(KEPT);
    slot
}

fn key(kind: CloudKind, light: &Light, k: u32, at: [i32; 2]) -> Key {
    let node = Node {
        direction: Corner { at, weight: 0 }.direction(),
        theta: light.nodes.theta(k),
        voxel_height_m: light.voxel_height_m,
        extinction_per_m: light.extinction_per_m,
        inverse_edge: light.inverse_edge,
        bounded: light.bounded,
    };
    (kind, node, light.encoding)
}

/// The texels of node `k` of a layer's light for a corner of the grid.
pub fn node(shape: &DensityVolume, kind: CloudKind, light: &Light, k: u32, at: [i32; 2]) -> Arc<Texels> {
    let key = key(kind, light, k, at);
    // Made outside the lock; whoever needs the same one meanwhile waits for it. A node is made on one thread that waits for
    // nobody, so that this cannot lock up; therefore it is given the shape, which may first have to be made on many.
    slot(&key).get_or_init(|| Arc::new(made(&key, shape))).clone()
}

fn made((_, node, encoding): &Key, volume: &DensityVolume) -> Texels {
    let mut shares = vec![Shares::default(); VOXELS];
    node::shares(node, &volume.shape, |i, found| shares[i] = found);
    stored(*encoding, shares.iter().map(|s| encoding.encode(s, node.direction)))
}

/// Begins to make what the next triangle of the grid will need, where the light is near its edge.
pub fn ahead(shape: &Arc<DensityVolume>, kind: CloudKind, light: &Light) {
    let Some(at) = grid::next(&light.corners) else { return };
    for k in 0..light.nodes.count {
        let key = key(kind, light, k, at);
        let known = nodes().iter().any(|(known, _)| *known == key);
        if !known {
            let (slot, shape) = (slot(&key), shape.clone());
            rayon::spawn(move || {
                slot.get_or_init(|| Arc::new(made(&key, &shape)));
            });
        }
    }
}

/// Forgets all nodes, so that a test or a measurement has them made again.
pub fn forget() {
    nodes().clear();
}
