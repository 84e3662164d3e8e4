//! Names of tables by content: the recipe, and the solver as it shows itself on a tiny cloud.

use crate::numeric::hash::{pcg3d, unit};
use crate::scattering::basis::{Basis, Recipe};
use crate::scattering::file;
use crate::scattering::lights::Lights;
use crate::scattering::medium::Medium;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// Name of a table: equal content, equal names; 32 hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(String);

impl Key {
    /// A name as it is written; `None` for text that is none.
    pub fn of(text: &str) -> Option<Self> {
        let is_digit = |b: u8| b.is_ascii_digit() || (b'a'..=b'f').contains(&b);
        (text.len() == 32 && text.bytes().all(is_digit)).then(|| Self(text.to_owned()))
    }
}

impl fmt::Display for Key {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str(&self.0)
    }
}

/// Solvers whose probe is remembered: one for each set of parameters, of which a program has a few.
const PROBES: usize = 64;

/// The name of a recipe's table.
///
/// A recipe says what is asked of the solver, not which solver answers. So a tiny cloud is baked by the same parameters, some
/// milliseconds once, and its blocks are hashed into the name: whatever is changed in how light is found, and any machine that
/// rounds otherwise, has tables of its own.
pub fn key(recipe: &Recipe) -> Key {
    static KNOWN: Mutex<BTreeMap<String, u64>> = Mutex::new(BTreeMap::new());
    let probe = probe(recipe);
    let name = probe.name();
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let found = known().get(&name).copied();
    // Not baked under the lock: the thread may take on other work meanwhile that asks for a name itself.
    let solver = found.unwrap_or_else(|| solver(probe));
    let mut known = known();
    if known.len() < PROBES {
        known.insert(name, solver);
    }
    drop(known);
    let header = file::header(recipe);
    Key(format!("{:016x}{:016x}", file::hash(&header, solver), file::hash(&header, solver ^ 0x5bd1_e995)))
}

/// The same question about a tiny cloud: thin and thick cells, lights in, between and below them.
fn probe(recipe: &Recipe) -> Recipe {
    // Rows that fill the lanes, as a piece of cloud has them: others take another way through the solver.
    const CELLS: [usize; 3] = [16, 16, 4];
    let look = |i: u32| unit(pcg3d(i, 11, 5)[0]);
    let extinction_per_m = (0..1024).map(|i| 0.08 * look(i) * look(i)).collect();
    let periodic = recipe.medium.periodic;
    let medium = Medium { cells: CELLS, spacing_m: [100.0, 100.0, 60.0], extinction_per_m, periodic };
    let period_m = periodic.then_some([1_600.0; 2]);
    let lights = Lights { x_m: vec![650.0, 930.0], y_m: vec![740.0], z_m: vec![-300.0, 90.0, 170.0], period_m };
    Recipe { medium, lights, ..recipe.clone() }
}

/// What the solver makes of it; that it finds no light is an answer too.
fn solver(probe: Recipe) -> u64 {
    match Basis::bake(probe) {
        Ok(basis) => file::hash(&file::write(&basis), 0),
        Err(why) => file::hash(why.to_string().as_bytes(), 1),
    }
}
