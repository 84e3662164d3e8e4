//! Tells the tests whether a graphics adapter can be expected: without one they are listed as ignored, never as passed.

use std::path::Path;

fn main() {
    println!("cargo::rustc-check-cfg=cfg(gpu_tests)");
    println!("cargo::rerun-if-env-changed=REQUIRE_GPU");
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    // Cargo takes a path that is not there for one that has changed, and would build everything anew each time.
    println!("cargo::rerun-if-changed=build.rs");
    for folder in folders.iter().filter(|folder| Path::new(folder).exists()) {
        println!("cargo::rerun-if-changed={folder}");
    }
    let driver = |folder: &&str| Path::new(folder).read_dir().is_ok_and(|mut files| files.next().is_some());
    let always = cfg!(any(target_os = "macos", target_os = "windows"));
    if std::env::var("REQUIRE_GPU").is_ok_and(|v| v == "1") || always || folders.iter().any(driver) {
        println!("cargo::rustc-cfg=gpu_tests");
    }
}
