//! Tables light as solves do, are baked as far as they are needed, kept within their memory, and found again in a folder.

use super::super::tests::request;
use super::super::{Window, patch};
use super::*;

/// A flash of one point in a piece of overcast.
fn struck(method: Lighting, position_m: [f32; 3]) -> Request {
    let solved = request(600.0, 1.0, 0.03, vec![super::super::Point { position_m, share: 1.0 }]);
    let window = patch::window(1_000.0, 600.0, patch::wide_m(600.0, 0.0));
    Request { method, patch: Some(window), ..solved }
}

fn relative(found: &Field, truth: &Field) -> f64 {
    let square = |f: &dyn Fn(usize) -> f32| (0..truth.quotients.len()).map(|i| f64::from(f(i)).powi(2)).sum::<f64>();
    (square(&|i| found.quotients[i][0] - truth.quotients[i][0]) / square(&|i| truth.quotients[i][0])).sqrt()
}

#[test]
fn a_table_lights_as_a_solve_does_and_bakes_what_is_asked_for_alone() {
    let tables = Arc::new(Tables::default());
    let at = [210.0, -130.0, 1_320.0];
    let truth = solve::field(&struck(Lighting::Solve, at)).expect("a cloud");
    let found = tables.field(&struck(Lighting::Hybrid, at), true, false).expect("a cloud");
    assert!(!found.stand_in && found.method == Lighting::Hybrid.method());
    // Lights stand two cells, eighteen free paths, apart: what is scattered more often is blended between their places, far
    // from where it comes from (0.4 to 0.5 of b in such decks). All of it is still better than none of it.
    let single = solve::field(&struck(Lighting::Single, at)).expect("a cloud");
    let (error, without) = (relative(&found, &truth), relative(&single, &truth));
    assert!(error < 0.7 && error < 0.75 * without, "{error} {without}");
    let Status { lights: baked, of: all, .. } = tables.status();
    assert!(baked > 0 && baked * 10 < all, "{baked} of {all}");
    let bytes = tables.bytes();
    assert!(bytes > 0);
    // The same place again costs nothing, and another flash in the cloud finds the piece.
    assert_eq!(tables.field(&struck(Lighting::Hybrid, at), true, false).expect("a cloud"), found);
    let again = tables.status();
    assert_eq!((again.lights, again.of, again.baked, tables.bytes()), (baked, all, baked, bytes));
    tables.field(&struck(Lighting::Hybrid, [900.0, 500.0, 1_200.0]), true, false).expect("a cloud");
    assert_eq!(tables.status().of, all);
    // Memory that is full forgets.
    tables.set_most(1);
    tables.field(&struck(Lighting::Hybrid, at), true, false).expect("lit all the same");
    assert_eq!((tables.bytes(), tables.status().lights, tables.status().of), (0, 0, 0));
    let clear = Request {
        layer: crate::passes::deck::Layer { theta: 1.0, ..struck(Lighting::Hybrid, at).layer },
        ..struck(Lighting::Hybrid, at)
    };
    assert!(tables.field(&clear, true, false).is_none());
}

#[test]
fn running_free_a_solve_stands_in_until_the_lights_are_there() {
    let tables = Arc::new(Tables::default());
    let flash = struck(Lighting::Hybrid, [40.0, 30.0, 1_250.0]);
    let first = tables.field(&flash, false, false).expect("a cloud");
    assert!(first.stand_in && first.method == Lighting::Solve.method());
    // What the background does, here: the flash's own lights come first.
    let weak = Arc::downgrade(&tables);
    assert!(!tables.has(&flash));
    while !tables.has(&flash) {
        assert!(fill_one(&weak));
    }
    let second = tables.field(&flash, false, false).expect("a cloud");
    assert!(!second.stand_in);
    // By whomever and whenever lights are baked: the same bits.
    assert_eq!(Arc::new(Tables::default()).field(&flash, true, false), Some(second));
}

/// A thin piece of few cells, whose lights are baked in no time.
fn light_cloud(method: Lighting, position_m: [f32; 3]) -> Request {
    let solved = request(300.0, 1.0, 0.0012, vec![super::super::Point { position_m, share: 1.0 }]);
    let window = Window { corner_m: [-600.0, -600.0, 1_000.0], cell_m: [150.0, 150.0, 75.0], cells: [8, 8, 4] };
    Request { method, patch: Some(window), ..solved }
}

/// A folder of its own, gone at the end.
struct Folder(std::path::PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("stormdeck-tables-{name}-{}", std::process::id()));
        let _old = std::fs::remove_dir_all(&path);
        Self(path)
    }

    fn tables(&self) -> Arc<Tables> {
        Arc::new(Tables::new(Some(Arc::new(Cache::open(&self.0, 1 << 30).expect("a folder")))))
    }

    fn names(&self, ending: &str) -> Vec<std::path::PathBuf> {
        let all = std::fs::read_dir(&self.0).expect("a folder").map(|entry| entry.expect("an entry").path());
        let mut all: Vec<_> = all.filter(|path| path.to_string_lossy().ends_with(ending)).collect();
        all.sort();
        all
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_second_run_finds_the_lights_of_the_first_and_bakes_nothing() {
    for method in [Lighting::Hybrid, Lighting::Basis] {
        let folder = Folder::new(&format!("second-{}", method.name()));
        let flash = light_cloud(method, [40.0, 30.0, 1_150.0]);
        let first = folder.tables();
        let lit = first.field(&flash, true, false).expect("a cloud");
        let baked = first.status().baked;
        assert!(baked > 0 && first.status().read == 0 && first.status().cache_bytes > 0);
        let second = folder.tables();
        assert_eq!(second.field(&flash, true, false).as_ref(), Some(&lit), "the same bits");
        let status = second.status();
        assert_eq!((status.baked, status.read, status.refused), (0, baked, 0));
        // A flash beside it needs some more, and finds the others.
        second.field(&light_cloud(method, [900.0, 800.0, 1_150.0]), true, false).expect("a cloud");
        let more = second.status().baked;
        assert!(more > 0);
        // What is whole is one file, with all lights, and a basis like any other.
        let whole = second.bake_whole(&flash, |_, _| {}).expect("a cloud");
        assert_eq!(whole, [(second.status().of - baked - more) as usize, 0]);
        assert_eq!((folder.names(".basis").len(), folder.names(".share").len()), (1, 0));
        let bytes = std::fs::read(&folder.names(".basis")[0]).expect("a file");
        let basis = crate::scattering::file::read(&bytes).expect("a basis");
        assert_eq!(basis.blocks.len() as u64, second.status().of);
        assert_eq!(folder.tables().status().cache_bytes, bytes.len() as u64);
        let third = folder.tables();
        assert_eq!(third.bake_whole(&flash, |_, _| {}), Some([0, 0]));
        assert_eq!(third.field(&flash, true, false), Some(lit));
        assert_eq!((third.status().baked, third.status().read), (0, third.status().of));
        // Without the folder everything is baked again, to the same light.
        assert!(first.status().baked == baked && Tables::default().status().cache_bytes == 0);
    }
}

#[test]
fn what_is_damaged_or_foreign_is_told_once_and_baked_again() {
    let folder = Folder::new("damaged");
    let flash = light_cloud(Lighting::Hybrid, [40.0, 30.0, 1_150.0]);
    let lit = folder.tables().field(&flash, true, false).expect("a cloud");
    let shares = folder.names(".share");
    let sound: Vec<Vec<u8>> = shares.iter().map(|path| std::fs::read(path).expect("a share")).collect();
    let name = |file: &str| folder.0.join(file);
    for beside in ["notes.txt", "a.basis", &format!("{}.basis", "x".repeat(32))] {
        std::fs::write(name(beside), b"of somebody else").expect("a file");
    }
    let bent = |at: usize| {
        let mut bytes = sound[0].clone();
        bytes[at] ^= 64;
        bytes
    };
    let last = sound[0].len() - 20;
    let of_another_cloud = {
        let other = Folder::new("damaged-other");
        let thicker =
            Request { layer: crate::passes::deck::Layer { extinction_per_m: 0.0013, ..flash.layer }, ..flash.clone() };
        other.tables().field(&thicker, true, false).expect("a cloud");
        std::fs::read(&other.names(".share")[0]).expect("a share")
    };
    let harms = [
        (Vec::new(), "SDBASIS"),
        (b"PNG and so on, long enough".to_vec(), "SDBASIS"),
        (bent(8), "version"),
        (bent(40), "damaged"),
        (bent(last), "damaged"),
        (sound[0][..last].to_vec(), "cut off"),
        (of_another_cloud, "another cloud"),
    ];
    for (harm, why) in harms {
        std::fs::write(&shares[0], &harm).expect("a file");
        let tables = folder.tables();
        assert_eq!(tables.field(&flash, true, false).as_ref(), Some(&lit), "{why}");
        let told = tables.complaints();
        assert!(told.len() == 1 && told[0].contains(why), "{why}: {told:?}");
        let status = tables.status();
        assert!(status.refused == 1 && status.baked > 0 && status.baked <= 16, "{why}: {status:?}");
        // It is whole again, and nothing of others was touched.
        assert_eq!(std::fs::read(&shares[0]).expect("a share"), sound[0], "{why}");
        assert!(tables.complaints().is_empty() && folder.tables().complaints().is_empty());
    }
    // What cannot even be taken away: a folder of that name. It is told, and lights are baked in memory.
    std::fs::remove_file(&shares[0]).expect("gone");
    std::fs::create_dir(&shares[0]).expect("a folder");
    let tables = folder.tables();
    assert_eq!(tables.field(&flash, true, false).as_ref(), Some(&lit));
    assert!(tables.complaints().iter().any(|told| told.contains("is no file")));
    assert_eq!(std::fs::read(name("notes.txt")).expect("there"), b"of somebody else");
    // A whole table that was cut short: what is sound of it is used, the rest is baked again.
    std::fs::remove_dir(&shares[0]).expect("gone");
    folder.tables().bake_whole(&flash, |_, _| {}).expect("a cloud");
    let whole = folder.names(".basis").into_iter().find(|path| path.metadata().expect("a file").len() > 1_000);
    let whole = whole.expect("a table");
    let bytes = std::fs::read(&whole).expect("a table");
    std::fs::write(&whole, &bytes[..bytes.len() / 2]).expect("a file");
    let tables = folder.tables();
    tables.bake_whole(&flash, |_, _| {}).expect("a cloud");
    let status = tables.status();
    assert!(status.refused == 1 && status.read > 100 && status.read + status.baked == status.of, "{status:?}");
    assert_eq!(std::fs::read(&whole).expect("a table"), bytes);
}

#[test]
fn what_is_full_forgets_what_was_not_used_for_longest_and_nothing_of_others() {
    let folder = Folder::new("full");
    let flash = |extinction: f32| {
        let thin = light_cloud(Lighting::Hybrid, [40.0, 30.0, 1_150.0]);
        Request { layer: crate::passes::deck::Layer { extinction_per_m: extinction, ..thin.layer }, ..thin }
    };
    let open = |most: u64| Arc::new(Tables::new(Some(Arc::new(Cache::open(&folder.0, most).expect("a folder")))));
    folder.tables().field(&flash(0.0011), true, false).expect("a cloud");
    std::fs::write(folder.0.join("notes.txt"), vec![7; 1 << 20]).expect("a file");
    let old = folder.names(".share");
    let one: u64 = old.iter().map(|path| path.metadata().expect("a share").len()).sum();
    // Time stamps are as coarse as the system has them.
    let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(1_000);
    for path in &old {
        let file = std::fs::File::options().append(true).open(path).expect("a share");
        file.set_modified(long_ago).expect("a time");
    }
    let tables = open(one * 5 / 2);
    tables.field(&flash(0.0012), true, false).expect("a cloud");
    assert!(old.iter().all(|path| path.exists()), "there is room for two");
    // Read again, the first is the younger one.
    let again = open(one * 5 / 2);
    again.field(&flash(0.0011), true, false).expect("a cloud");
    assert_eq!(again.status().baked, 0);
    let middle: Vec<_> = folder.names(".share").into_iter().filter(|path| !old.contains(path)).collect();
    for path in &middle {
        let file = std::fs::File::options().append(true).open(path).expect("a share");
        file.set_modified(long_ago).expect("a time");
    }
    again.field(&flash(0.0013), true, false).expect("a cloud");
    assert!(old.iter().all(|path| path.exists()) && !middle.iter().any(|path| path.exists()));
    assert!(again.status().cache_bytes <= one * 5 / 2 && again.complaints().is_empty());
    assert!(folder.0.join("notes.txt").exists());
    // A table that is larger than all may be is told once, and not written again and again.
    let tiny = open(1_000);
    tiny.field(&flash(0.0014), true, false).expect("lit all the same");
    assert!(matches!(&tiny.complaints()[..], [told] if told.contains("larger than")));
    assert!(folder.names(".share").is_empty() && tiny.status().cache_bytes == 0);
}

#[test]
fn a_folder_that_is_none_is_refused_and_one_that_vanishes_is_told() {
    let folder = Folder::new("none");
    std::fs::write(&folder.0, b"a file").expect("a file");
    assert!(Cache::open(&folder.0, 1 << 20).is_err());
    std::fs::remove_file(&folder.0).expect("gone");
    let tables = folder.tables();
    std::fs::remove_dir_all(&folder.0).expect("gone");
    let flash = light_cloud(Lighting::Hybrid, [40.0, 30.0, 1_150.0]);
    assert!(tables.field(&flash, true, false).is_some());
    let told = tables.complaints();
    assert!(told.len() == 2 && told.iter().any(|told| told.contains("nothing can be kept")), "{told:?}");
}

#[test]
fn what_is_left_to_a_device_is_the_same_field() {
    let tables = Arc::new(Tables::default());
    let flash = light_cloud(Lighting::Basis, [40.0, 30.0, 1_150.0]);
    let here = tables.field(&flash, true, false).expect("a cloud");
    let there = tables.field(&flash, true, true).expect("a cloud");
    let summed = there.summed.clone().expect("left to a device");
    assert!(here.summed.is_none() && there.quotients.is_empty() && !here.quotients.is_empty());
    // The twin sums in the same order: what is left is how f32 rounds.
    let most = here.quotients.as_flattened().iter().fold(0.0_f32, |m, v| m.max(v.abs()));
    let twin = summed.quotients();
    let pairs = twin.as_flattened().iter().zip(here.quotients.as_flattened());
    let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / most;
    assert!(twin.len() == here.quotients.len() && apart < 1e-6, "{apart}");
    assert_eq!(
        (there.window, &there.points, there.cap_m2, there.method),
        (here.window, &here.points, here.cap_m2, here.method)
    );
    for (a, b) in [(there.below, here.below), (there.above, here.above)] {
        // Single directions that dropped coefficients made negative count as they are, where the field has them as dark.
        assert!((a.share / b.share - 1.0).abs() < 0.01 && a.share > 0.0, "{} {}", a.share, b.share);
        assert!((a.spread_m2 / b.spread_m2 - 1.0).abs() < 0.05);
        assert!((0..2).all(|k| (a.middle_m[k] - b.middle_m[k]).abs() < 5.0));
    }
    // Only the published scheme ends with its sum.
    let hybrid = tables.field(&light_cloud(Lighting::Hybrid, [40.0, 30.0, 1_150.0]), true, true).expect("a cloud");
    assert!(hybrid.summed.is_none() && !hybrid.quotients.is_empty());
}
