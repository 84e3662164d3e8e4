//! Tells the tests whether a graphics adapter can be expected: without one they are listed as ignored, never as passed.
//!
//! A Vulkan driver counts when the loader is there, its manifest names a library that is there, and the hardware that the
//! library drives can be opened. (Distributions install manifests for every maker's hardware at once.) A software driver
//! needs no hardware. Whoever says REQUIRE_GPU=1 gets the tests in any case, and they fail without an adapter.
//! The same with Wireshark's `tshark`, which reads our CIGI traffic as a second opinion, and REQUIRE_TSHARK=1.

use std::path::{Path, PathBuf};

/// Where manifests of drivers lie.
const MANIFESTS: [&str; 3] = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
/// Where a library is looked for that is named without its folder.
const LIBRARIES: [&str; 8] = [
    "/usr/lib",
    "/usr/lib64",
    "/lib",
    "/lib64",
    "/usr/local/lib",
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/run/opengl-driver/lib",
];
/// Libraries of drivers that draw on the processor: Mesa's lavapipe, SwiftShader.
const SOFTWARE: [&str; 2] = ["lvp", "swiftshader"];
/// What graphics hardware is opened by: a file, or a folder and the beginning of the files' names.
const DEVICES: [(&str, &str); 3] = [("/dev/dri", "renderD"), ("/dev", "nvidiactl"), ("/dev", "dxg")];

fn main() {
    println!("cargo::rustc-check-cfg=cfg(gpu_tests, tshark_tests)");
    for variable in ["REQUIRE_GPU", "VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    println!("cargo::rerun-if-changed=build.rs");
    // Cargo takes a path that is not there for one that has changed, and would build everything anew each time.
    for folder in MANIFESTS.iter().filter(|folder| Path::new(folder).exists()) {
        println!("cargo::rerun-if-changed={folder}");
    }
    let always = cfg!(any(target_os = "macos", target_os = "windows"));
    if std::env::var("REQUIRE_GPU").is_ok_and(|v| v == "1") || always || vulkan() {
        println!("cargo::rustc-cfg=gpu_tests");
    }
    for variable in ["REQUIRE_TSHARK", "PATH"] {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    if std::env::var("REQUIRE_TSHARK").is_ok_and(|v| v == "1") || tshark().is_some() {
        println!("cargo::rustc-cfg=tshark_tests");
    }
}

/// Where `tshark` is, if it is in the search path.
fn tshark() -> Option<PathBuf> {
    let name = if cfg!(windows) { "tshark.exe" } else { "tshark" };
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// Whether a Vulkan driver of this machine can be expected to work.
fn vulkan() -> bool {
    let hardware = DEVICES.iter().any(|(folder, name)| can_be_opened(Path::new(folder), name));
    let works = |manifest: PathBuf| {
        let text = std::fs::read_to_string(&manifest).unwrap_or_default();
        let folder = manifest.parent().unwrap_or(Path::new("/"));
        usable(&text, hardware, &|library| exists(library, folder))
    };
    exists("libvulkan.so.1", Path::new("/")) && manifests().into_iter().any(works)
}

/// The manifests that the loader would read.
fn manifests() -> Vec<PathBuf> {
    let named = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].into_iter().find_map(std::env::var_os);
    if let Some(files) = named {
        return std::env::split_paths(&files).collect();
    }
    let files = MANIFESTS.iter().filter_map(|folder| Path::new(folder).read_dir().ok()).flatten();
    files.filter_map(|file| Some(file.ok()?.path())).collect()
}

/// Whether a driver works by its manifest, given whether there is hardware, and which libraries there are.
pub fn usable(manifest: &str, hardware: bool, there: &dyn Fn(&str) -> bool) -> bool {
    let Some(library) = library_path(manifest) else { return false };
    there(library) && (hardware || SOFTWARE.iter().any(|name| library.contains(name)))
}

/// The value of `library_path`.
fn library_path(manifest: &str) -> Option<&str> {
    let after = manifest.split_once("\"library_path\"")?.1.split_once(':')?.1;
    after.trim_start().strip_prefix('"')?.split_once('"').map(|(path, _)| path)
}

/// A library by its whole path, relative to its manifest, or by its name alone.
fn exists(library: &str, manifest_folder: &Path) -> bool {
    if library.contains('/') {
        return manifest_folder.join(library).exists();
    }
    let own = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let folders = std::env::split_paths(&own).chain(LIBRARIES.iter().map(PathBuf::from));
    folders.into_iter().any(|folder| folder.join(library).exists())
}

fn can_be_opened(folder: &Path, name: &str) -> bool {
    let Ok(files) = folder.read_dir() else { return false };
    let opens = |path: PathBuf| std::fs::OpenOptions::new().read(true).write(true).open(path).is_ok();
    files.filter_map(Result::ok).any(|file| file.file_name().to_string_lossy().starts_with(name) && opens(file.path()))
}
