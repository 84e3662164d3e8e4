//! Which drivers make the tests on the GPU be run: the rule of the build script.

#[allow(dead_code, reason = "cargo runs the rest")]
#[path = "../../build.rs"]
mod build_script;

use build_script::usable;

fn manifest(library: &str) -> String {
    format!("{{\n  \"ICD\": {{\n    \"api_version\": \"1.3.0\",\n    \"library_path\": \"{library}\"\n  }}\n}}")
}

#[test]
fn a_manifest_alone_is_no_adapter() {
    let (there, gone) = (|_: &str| true, |_: &str| false);
    let [intel, lavapipe] = ["/usr/lib/libvulkan_intel.so", "libvulkan_lvp.so"].map(manifest);
    assert!(!usable(&intel, false, &there), "no hardware to drive");
    assert!(usable(&intel, true, &there));
    assert!(!usable(&intel, true, &gone), "its library is not there");
    assert!(usable(&lavapipe, false, &there), "software needs no hardware");
    assert!(!usable(&lavapipe, false, &gone));
    for broken in ["", "{}", "{\"library_path\": 3}", "\"library_path\"", "{\"library_path\": \"never ends"] {
        assert!(!usable(broken, true, &there), "{broken}");
    }
}

#[test]
fn the_library_asked_for_is_the_one_that_is_named() {
    usable(&manifest("../lib/x.so"), true, &|library| {
        assert_eq!(library, "../lib/x.so");
        true
    });
}
