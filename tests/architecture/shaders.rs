//! The passes on disk: each folder of `src/passes` has a shader and a twin, or its `mod.rs` says `//! No shader: why` or
//! `//! No twin: why`; each `.wgsl` file of the repository is compiled by the GPU executor, and valid as it joins it.

use super::files::{Source, sources};
use std::collections::BTreeSet;
use wgpu::naga;

/// Where passes live.
const PASSES: &str = "src/passes/";

/// The files on disk, and the shaders as the GPU executor compiles them, by name.
pub struct Passes {
    files: Vec<Source>,
    joined: Vec<(String, String)>,
}

/// A shader that naga has read and accepted.
pub struct Module {
    pub name: String,
    pub module: naga::Module,
}

impl Passes {
    /// What is on disk now.
    pub fn on_disk() -> Self {
        let joined = stormdeck::gpu::shaders().into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
        Self { files: sources(&["src", "tests", "benches"]), joined }
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

    /// The valid shaders, parsed.
    pub fn modules(&self) -> Vec<Module> {
        let read = |(name, text): &(String, String)| Some(Module { name: name.clone(), module: validated(text).ok()? });
        self.joined.iter().filter_map(read).collect()
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
    for (name, text) in &passes.joined {
        if let Err(e) = validated(text) {
            complaints.push(format!("shader {name}: {e}"));
        }
    }
    for file in passes.files.iter().filter(|file| file.path.ends_with(".wgsl")) {
        if !passes.joined.iter().any(|(_, text)| text.contains(&file.text)) {
            complaints.push(format!("{}: is compiled by nobody", file.path));
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

/// The complaints about made-up files, each shader compiled as it stands.
#[cfg(test)]
fn about(files: &[(&str, &str)]) -> Vec<String> {
    let shaders = files.iter().filter(|(path, _)| path.ends_with(".wgsl"));
    let joined = shaders.map(|(path, text)| (path.to_string(), text.to_string())).collect();
    complaints(&Passes { files: files.iter().map(|(path, text)| Source::new(path, text)).collect(), joined })
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
    let stray = Passes { files: vec![Source::new("src/gpu/old.wgsl", "fn f() {}")], joined: Vec::new() };
    assert_eq!(complaints(&stray).len(), 1, "a shader that nobody compiles");
}
