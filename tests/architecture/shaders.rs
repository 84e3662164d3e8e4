//! The passes on disk: each folder of `src/passes` has a shader and a twin, or its `mod.rs` says `//! No shader: why` or
//! `//! No twin: why`; each `.wgsl` file of the repository is valid, joined as the GPU executor joins it.

use super::files::{Source, sources};
use std::collections::BTreeSet;
use wgpu::naga;

/// Shared declarations that are put before the text of every pass.
const COMMON: &str = "src/passes/common.wgsl";
/// Where passes live.
const PASSES: &str = "src/passes/";

/// The files under `src/passes`, and every shader of the repository.
pub struct Passes {
    files: Vec<Source>,
}

/// A shader that naga has read and accepted.
pub struct Module {
    pub path: String,
    pub module: naga::Module,
}

impl Passes {
    /// What is on disk now.
    pub fn on_disk() -> Self {
        Self { files: sources(&["src", "tests", "benches"]) }
    }

    fn text(&self, path: &str) -> Option<&str> {
        self.files.iter().find(|f| f.path == path).map(|f| f.text.as_str())
    }

    /// Names of the pass folders.
    fn names(&self) -> BTreeSet<&str> {
        self.files
            .iter()
            .filter_map(|f| f.path.strip_prefix(PASSES)?.split_once('/'))
            .map(|(folder, _)| folder)
            .collect()
    }

    /// Each shader with its path and the text that the device is given.
    fn joined(&self) -> Vec<(String, String)> {
        let common = self.text(COMMON).unwrap_or_default();
        let shaders = self.files.iter().filter(|f| f.path.ends_with(".wgsl"));
        shaders
            .map(|f| match f.path.as_str() {
                COMMON => (f.path.clone(), common.to_owned()),
                _ => (f.path.clone(), format!("{common}\n{}", f.text)),
            })
            .collect()
    }

    /// The valid shaders, parsed.
    pub fn modules(&self) -> Vec<Module> {
        let read = |(path, text): (String, String)| Some(Module { path, module: validated(&text).ok()? });
        self.joined().into_iter().filter_map(read).collect()
    }
}

/// Parses and validates one shader.
pub fn validated(text: &str) -> Result<naga::Module, String> {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
    validator.validate(&module).map_err(|e| e.emit_to_string(text))?;
    Ok(module)
}

/// Invalid shaders, and passes that lack a part without saying why.
pub fn complaints(passes: &Passes) -> Vec<String> {
    let mut complaints = Vec::new();
    for (path, text) in passes.joined() {
        if let Err(e) = validated(&text) {
            complaints.push(format!("{path}: {e}"));
        }
    }
    for name in passes.names() {
        let folder = format!("{PASSES}{name}");
        let Some(declared) = passes.text(&format!("{folder}/mod.rs")) else {
            complaints.push(format!("{folder}: no mod.rs declares the pass"));
            continue;
        };
        for (part, file) in [("shader", format!("{name}.wgsl")), ("twin", "twin.rs".to_owned())] {
            let excuse = format!("//! No {part}: ");
            let excused = declared.lines().any(|l| l.strip_prefix(&excuse).is_some_and(|why| why.len() >= 20));
            let present = passes.text(&format!("{folder}/{file}")).is_some();
            if present == excused {
                complaints.push(match present {
                    true => format!("{folder}: has {file}, but mod.rs excuses its absence"),
                    false => format!("{folder}: no {file}, and no line `{excuse}...` in mod.rs"),
                });
            }
        }
    }
    complaints
}

#[cfg(test)]
fn about(files: &[(&str, &str)]) -> Vec<String> {
    complaints(&Passes { files: files.iter().map(|(path, text)| Source::new(path, text)).collect() })
}

#[test]
fn a_pass_without_a_part_is_found_unless_excused() {
    let shader = ("src/passes/sky/sky.wgsl", "fn f() -> f32 { return 1.0; }");
    let twin = ("src/passes/sky/twin.rs", "");
    let plain = ("src/passes/sky/mod.rs", "//! The sky.");
    assert_eq!(about(&[shader, twin, plain]), Vec::<String>::new());
    assert_eq!(about(&[shader, plain]).len(), 1);
    assert_eq!(about(&[twin, plain]).len(), 1);
    assert_eq!(about(&[shader, twin]).len(), 1);
    let excused = ("src/passes/sky/mod.rs", "//! The sky.\n//! No twin: it is geometry; counterpart.rs traces rays.");
    assert_eq!(about(&[shader, excused]), Vec::<String>::new());
    assert_eq!(about(&[shader, twin, excused]).len(), 1, "an excuse for what is there is stale");
    assert_eq!(about(&[shader, ("src/passes/sky/mod.rs", "//! No twin: later")]).len(), 1, "a bad excuse");
}

#[test]
fn an_invalid_shader_is_found() {
    for bad in ["fn f() -> f32 { return 1u; }", "not wgsl", "fn f() { g(); }", "@group(0) @binding(0) var x: f32;"] {
        assert_eq!(about(&[("src/gpu/blit.wgsl", bad)]).len(), 1, "{bad}");
    }
    let common = (COMMON, "fn g() -> f32 { return 1.0; }");
    assert_eq!(about(&[common, ("src/gpu/blit.wgsl", "fn f() -> f32 { return g(); }")]), Vec::<String>::new());
}
