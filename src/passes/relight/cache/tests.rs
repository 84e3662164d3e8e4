//! Names of files and of tables. What the folder does for tables is pinned beside these.

use super::folder::{Kind, named};
use super::*;
use crate::scattering::basis::{Content, Recipe};
use crate::scattering::lights::Lights;
use crate::scattering::medium::Medium;
use crate::scattering::ordinates::{Params, Treatment};

fn recipe() -> Recipe {
    let medium = Medium { cells: [3, 2, 2], spacing_m: [100.0; 3], extinction_per_m: vec![0.01; 12], periodic: false };
    Recipe {
        lights: Lights::even([2, 1, 1], medium.size_m(), 2.0, false).expect("lights"),
        params: Params { rays: 64, ..Params::default() },
        content: Content::Diffuse,
        packing: Content::Diffuse.usual_packing(),
        medium,
    }
}

#[test]
fn names_tell_what_a_file_is_and_names_of_others_tell_nothing() {
    let key = "0123456789abcdef0123456789abcdef";
    let of = |ending: &str| named(&format!("{key}{ending}")).map(|(found, kind)| (found.to_string(), kind));
    assert_eq!(of(".basis"), Some((key.to_owned(), Kind::Whole)));
    assert_eq!(of("-0000016.share"), Some((key.to_owned(), Kind::Share)));
    assert_eq!(of("-4711-3.partial"), Some((key.to_owned(), Kind::Partial)));
    for other in ["", ".share", "-.share", "-x.share", "-1.basis", "-1.partial", "-1-.partial", "0.basis", ".basis.gz"]
    {
        assert_eq!(of(other), None, "{other}");
    }
    for other in ["notes.txt", "0123.basis", "0123456789ABCDEF0123456789ABCDEF.basis", "../.basis"] {
        assert_eq!(named(other), None, "{other}");
    }
}

#[test]
fn a_table_has_another_name_if_anything_that_decides_its_light_is_another() {
    let own = recipe();
    assert_eq!(key(&own), key(&own.clone()));
    let mut others: Vec<Recipe> = (0..6).map(|_| own.clone()).collect();
    others[0].medium.extinction_per_m[7] += 1e-6;
    others[1].params.tolerance = 2e-4;
    others[2].params.treatment = Treatment::Truncated;
    others[3].content = Content::Total;
    others[4].packing.threshold = 2e-5;
    others[5].lights.z_m[0] -= 1.0;
    let mut names: Vec<Key> = others.iter().chain([&own]).map(key).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), 7);
    // The solver's own answer is in it: the same header under the answer to another question is another name.
    let header = file::header(&own);
    assert_ne!(key(&own).to_string()[..16], format!("{:016x}", file::hash(&header, 0)));
    assert!(Key::of(&key(&own).to_string()).is_some());
}

#[test]
fn what_a_killed_writer_left_goes_when_it_is_old_enough() {
    let folder = std::env::temp_dir().join(format!("stormdeck-cache-left-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let left = |n: u32| folder.join(format!("0123456789abcdef0123456789abcdef-1-{n}.partial"));
    for n in 0..2 {
        std::fs::write(left(n), b"half").expect("a file");
    }
    let old = File::options().append(true).open(left(0)).expect("a file");
    old.set_modified(SystemTime::now() - 2 * FORSAKEN).expect("a time");
    let cache = Cache::open(&folder, 1 << 20).expect("a folder");
    assert!(!left(0).exists() && left(1).exists(), "another program may be writing the younger one");
    assert_eq!(cache.bytes(), 4);
    let _gone = std::fs::remove_dir_all(&folder);
}
