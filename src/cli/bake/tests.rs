//! Pins what a bake leaves behind: the same bytes however it was cut up or killed, and nothing of others touched.

use super::*;

fn options(out: &Path) -> Options {
    Options {
        scenario: Some("overcast-night-cities".into()),
        out: Some(out.to_path_buf()),
        struck: None,
        until: None,
        at: 0.0,
        layer: 0,
        tolerance: 1e-2,
        width: None,
        threshold: None,
        error: None,
        interval: None,
        fall: 1e-6,
        content: "diffuse".into(),
        cells: [8, 8, 2],
        lights: [2, 2, 3],
        index: None,
        of: None,
        merge: Vec::new(),
        cache: None,
        cache_mib: 1024,
    }
}

/// A folder of its own, gone at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("stormdeck-bake-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn shares_torn_files_and_the_cache_all_give_the_same_bytes() {
    let folder = Folder::new("same");
    let at = |name: &str| folder.0.join(name);
    let cache = Some(at("cache"));
    run(&Options { cache: cache.clone(), ..options(&at("whole")) }).expect("baked");
    let whole = std::fs::read(at("whole")).expect("written");
    assert_eq!(file::read(&whole).expect("a basis").blocks.len(), 12);
    for index in 0..3 {
        let share = at(&format!("share{index}"));
        run(&Options { index: Some(index), of: Some(3), ..options(&share) }).expect("baked");
    }
    let merge = vec![at("share2"), at("share0"), at("share1")];
    run(&Options { scenario: None, merge, ..options(&at("merged")) }).expect("merged");
    assert_eq!(std::fs::read(at("merged")).expect("written"), whole);
    // Killed anywhere: in the header, in a block, between blocks, in the trailer, and not at all.
    let steps = (0..=24).map(|i| whole.len() * i / 24);
    for cut in steps.chain([5, 700, whole.len() - 3]) {
        std::fs::write(at("torn"), &whole[..cut]).expect("written");
        run(&options(&at("torn"))).expect("gone on with");
        assert_eq!(std::fs::read(at("torn")).expect("written"), whole, "{cut}");
    }
    run(&Options { cache, ..options(&at("cached")) }).expect("copied");
    assert_eq!(std::fs::read(at("cached")).expect("written"), whole);
}

#[test]
fn a_target_error_is_kept_by_every_width_that_can() {
    let folder = Folder::new("error");
    for (width, error) in [(Width::F32, 0.01), (Width::F16, 0.03), (Width::Log8, 0.06)] {
        let out = folder.0.join(format!("{width:?}"));
        run(&Options { width: Some(width), error: Some(error), interval: Some(4_000.0), ..options(&out) })
            .expect("baked");
        let basis = file::read(&std::fs::read(&out).expect("written")).expect("a basis");
        assert_eq!(basis.recipe.packing.width, width);
        // A sample told the threshold: the other lights may be a little worse.
        assert!(basis.error() < 1.5 * error && basis.error() > 0.1 * error, "{width:?}: {}", basis.error());
        // Below the layer lights stand farther and farther apart.
        assert!(basis.recipe.lights.z_m[0] < 0.0);
    }
}

#[test]
fn other_files_are_left_alone_and_bad_options_are_told() {
    let folder = Folder::new("alone");
    let other = folder.0.join("other");
    std::fs::write(&other, vec![7; 5000]).expect("written");
    assert!(matches!(run(&options(&other)), Err(Failure::Input(_))));
    assert_eq!(std::fs::read(&other).expect("there"), vec![7; 5000]);
    let out = folder.0.join("out");
    for bad in [
        Options { layer: 99, ..options(&out) },
        Options { at: -1.0, ..options(&out) },
        Options { cells: [7, 8, 2], ..options(&out) },
        Options { lights: [0, 1, 1], ..options(&out) },
        Options { interval: Some(-1.0), ..options(&out) },
        Options { threshold: Some(f64::NAN), ..options(&out) },
        Options { error: Some(1.5), ..options(&out) },
        Options { tolerance: 0.0, ..options(&out) },
        Options { index: Some(3), of: Some(3), ..options(&out) },
        Options { scenario: Some("no such".into()), ..options(&out) },
    ] {
        assert!(matches!(run(&bad), Err(Failure::Input(_))), "{bad:?}");
    }
    assert!(!out.exists());
}
