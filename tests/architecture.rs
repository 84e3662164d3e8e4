//! The walls of the house, as `ARCHITECTURE.md` states them: who may import whom, who may name which crate, how a file
//! begins and how long it may grow, that each shader is valid and has a twin, that shared structs have one layout.
//!
//! Each checker has its own tests in which it must fail: a checker that cannot fail pins nothing.

#[path = "architecture/drivers.rs"]
mod drivers;
#[path = "architecture/files.rs"]
mod files;
#[path = "architecture/layouts.rs"]
mod layouts;
#[path = "architecture/paths.rs"]
mod paths;
#[path = "architecture/shaders.rs"]
mod shaders;
#[path = "architecture/tokens.rs"]
mod tokens;
#[path = "architecture/walls.rs"]
mod walls;

/// Fails with every complaint at once: the reader mends them in one go.
fn none(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

#[test]
fn no_group_imports_one_to_its_right() {
    let sources = files::sources(&["src"]);
    assert!(sources.len() > 10, "only {} source files were found: the search is broken", sources.len());
    none(walls::complaints(&sources));
}

#[test]
fn every_file_opens_with_what_it_is_and_stays_short() {
    none(files::complaints(&files::sources(&["src", "tests", "benches", "protocol", "deploy"])));
}

#[test]
fn every_pass_has_a_valid_shader_and_a_twin_or_says_why_not() {
    none(shaders::complaints(&shaders::Passes::on_disk()));
}

#[test]
fn structs_shared_with_shaders_have_the_same_layout_there() {
    let passes = shaders::Passes::on_disk();
    none(layouts::complaints(&files::sources(&["src/passes"]), &passes.modules()));
}
