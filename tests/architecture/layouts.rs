//! Compares each `#[repr(C)]` struct of `src/passes` with the WGSL struct of the same name: names, offsets, sizes and
//! scalar kinds of the members. A struct with no counterpart must say `/// No WGSL struct: why`.
//!
//! The Rust layout is computed from the source text by the rules of `repr(C)`, so that no struct can be forgotten; a test
//! holds these rules against the compiler's own `offset_of!`. Members whose names begin with `_` are padding.

use super::files::Source;
use super::shaders::Module;
use super::tokens::{Token, tokens};
use std::collections::BTreeMap;
use wgpu::naga::{self, Handle, Type, TypeInner};

/// One member: what must agree on both sides.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Member {
    name: String,
    offset: u32,
    size: u32,
    /// `f32`, `u32`, ..., or the name of a struct.
    kind: String,
}

/// A struct, of either language.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Layout {
    members: Vec<Member>,
    size: u32,
    align: u32,
}

impl Layout {
    fn without_padding(&self) -> Vec<&Member> {
        self.members.iter().filter(|m| !m.name.starts_with('_')).collect()
    }
}

/// Every difference.
pub fn complaints(sources: &[Source], modules: &[Module]) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut known = BTreeMap::new();
    for source in sources.iter().filter(|s| s.path.ends_with(".rs")) {
        for declared in declarations(source) {
            let place = format!("{}: {}", source.path, declared.name);
            let layout = match layout(&declared.fields, &known) {
                Ok(layout) => layout,
                Err(why) => {
                    complaints.push(format!("{place}: {why}"));
                    continue;
                }
            };
            known.insert(declared.name.clone(), layout.clone());
            let twins: Vec<_> =
                modules.iter().filter_map(|m| Some((&m.path, in_wgsl(&m.module, &declared.name)?))).collect();
            if twins.is_empty() != declared.excused {
                complaints.push(match declared.excused {
                    true => format!("{place}: has a WGSL struct, but is excused from one"),
                    false => format!("{place}: no WGSL struct of this name, and no line `/// No WGSL struct: ...`"),
                });
            }
            for (path, twin) in twins {
                if twin.size != layout.size || twin.without_padding() != layout.without_padding() {
                    complaints.push(format!("{place} differs from {path}:\n  Rust {layout:#?}\n  WGSL {twin:#?}"));
                }
            }
        }
    }
    complaints
}

/// A `#[repr(C)]` struct as it is written.
struct Declared {
    name: String,
    fields: Vec<(String, Vec<Token>)>,
    excused: bool,
}

/// The `#[repr(C)]` structs of a file, in order.
fn declarations(source: &Source) -> Vec<Declared> {
    let tokens = tokens(&source.text);
    let lines: Vec<&str> = source.text.lines().collect();
    let mut found = Vec::new();
    let mut is_shared = false;
    for at in 0..tokens.len() {
        let follows =
            |words: &[&str]| words.iter().enumerate().all(|(i, w)| tokens.get(at + i).is_some_and(|t| t.is(w)));
        is_shared |= follows(&["repr", "(", "C"]);
        if !tokens[at].is("struct") && !tokens[at].is("enum") {
            continue;
        }
        if std::mem::take(&mut is_shared) && tokens[at].is("struct") {
            let name = tokens[at + 1].text.clone();
            let docs = lines[..tokens[at].line - 1].iter().rev().take_while(|l| {
                let line = l.trim();
                line.starts_with("///") || line.starts_with("#[")
            });
            let excused = docs.into_iter().any(|l| l.trim().starts_with("/// No WGSL struct: "));
            found.push(Declared { name, fields: fields(&tokens[at + 2..]), excused });
        }
    }
    found
}

/// Names and types of the fields of a struct whose body begins here.
fn fields(tokens: &[Token]) -> Vec<(String, Vec<Token>)> {
    let mut found = Vec::new();
    let mut depth = 0;
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        match token.text.as_str() {
            "{" | "[" | "(" | "<" => depth += 1,
            "}" if depth == 1 => break,
            "]" | ")" | ">" => depth -= 1,
            ";" if depth == 0 => break,
            _ if depth == 1 && token.is_word() && tokens.get(at + 1).is_some_and(|t| t.is(":")) => {
                let (begin, mut inner) = (at + 2, 0);
                at = begin;
                while let Some(t) = tokens.get(at).filter(|t| inner > 0 || !(t.is(",") || t.is("}"))) {
                    inner += i32::from(t.is("[") || t.is("<")) - i32::from(t.is("]") || t.is(">"));
                    at += 1;
                }
                found.push((token.text.clone(), tokens[begin..at].to_vec()));
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// The layout that `repr(C)` gives these fields.
fn layout(fields: &[(String, Vec<Token>)], known: &BTreeMap<String, Layout>) -> Result<Layout, String> {
    let (mut end, mut widest) = (0_u32, 1_u32);
    let mut members = Vec::new();
    for (name, ty) in fields {
        let (size, align, kind) = measured(ty, known).map_err(|why| format!("{name}: {why}"))?;
        let offset = end.next_multiple_of(align);
        members.push(Member { name: name.clone(), offset, size, kind });
        (end, widest) = (offset + size, widest.max(align));
    }
    Ok(Layout { members, size: end.next_multiple_of(widest), align: widest })
}

/// Size, alignment and scalar kind of a Rust type.
fn measured(ty: &[Token], known: &BTreeMap<String, Layout>) -> Result<(u32, u32, String), String> {
    let words: Vec<&str> = ty.iter().map(|t| t.text.as_str()).collect();
    match words.as_slice() {
        ["f32" | "u32" | "i32"] => Ok((4, 4, words[0].to_owned())),
        [.., "Vec2"] => Ok((8, 4, "f32".into())),
        [.., "Vec3"] => Ok((12, 4, "f32".into())),
        [.., "Vec4"] => Ok((16, 16, "f32".into())),
        [.., "Mat4"] => Ok((64, 16, "f32".into())),
        ["[", inner @ .., ";", count, "]"] => {
            let (size, align, kind) = measured(&ty[1..=inner.len()], known)?;
            let count: u32 = count.parse().map_err(|_| format!("`{count}` is not a plain number of elements"))?;
            Ok((size * count, align, kind))
        }
        [.., name] if known.contains_key(*name) => Ok((known[*name].size, known[*name].align, (*name).to_owned())),
        _ => Err(format!("`{}` is no type of the table in tests/architecture/layouts.rs", words.join(""))),
    }
}

/// The struct of this name in a shader.
fn in_wgsl(module: &naga::Module, name: &str) -> Option<Layout> {
    let (_, ty) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name))?;
    let TypeInner::Struct { members, span } = &ty.inner else { return None };
    let member = |m: &naga::StructMember| Member {
        name: m.name.clone().unwrap_or_default(),
        offset: m.offset,
        size: module.types[m.ty].inner.size(module.to_ctx()),
        kind: kind_of(module, m.ty),
    };
    Some(Layout { members: members.iter().map(member).collect(), size: *span, align: 0 })
}

/// The scalar that a type is made of in the end, or the struct's name.
fn kind_of(module: &naga::Module, ty: Handle<Type>) -> String {
    let ty = &module.types[ty];
    match &ty.inner {
        TypeInner::Array { base, .. } => kind_of(module, *base),
        TypeInner::Struct { .. } => ty.name.clone().unwrap_or_default(),
        inner => match inner.scalar() {
            Some(naga::Scalar::F32) => "f32".into(),
            Some(naga::Scalar::U32) => "u32".into(),
            Some(naga::Scalar::I32) => "i32".into(),
            other => format!("{other:?}"),
        },
    }
}

#[cfg(test)]
fn about(rust: &str, wgsl: &str) -> Vec<String> {
    let module = super::shaders::validated(wgsl).expect("the test's shader");
    complaints(&[Source::new("src/passes/a/mod.rs", rust)], &[Module { path: "a.wgsl".into(), module }])
}

#[test]
fn a_different_layout_is_found() {
    let wgsl = "struct A { eye: vec3<f32>, far: f32, grid: mat4x4<f32>, n: u32, _a: u32, s: vec2<i32> }";
    let agrees = "#[repr(C)]\n#[derive(Clone)]\npub struct A { /// Eye.\n pub eye: [f32; 3], pub far: f32, grid: [[f32; 4]; 4], \
                  n: u32, _pad: u32, s: [i32; 2], }";
    assert_eq!(about(agrees, wgsl), Vec::<String>::new());
    for (from, to) in [
        ("far", "near"),
        ("n: u32", "n: i32"),
        ("_pad: u32, ", ""),
        ("eye: [f32; 3]", "eye: [f32; 4]"),
        ("s: [i32; 2]", "s: [i32; 2], end: [u32; 4]"),
        ("[[f32; 4]; 4]", "[[f32; 4]; 3]"),
        ("pub far: f32, grid: [[f32; 4]; 4]", "grid: [[f32; 4]; 4], pub far: f32"),
        ("n: u32", "n: Unknown"),
        ("struct A", "struct B"),
    ] {
        assert!(agrees.contains(from), "{from}");
        assert_eq!(about(&agrees.replace(from, to), wgsl).len(), 1, "{from} -> {to}");
    }
    assert_eq!(about("/// No WGSL struct: rows of a vertex buffer.\n#[repr(C)]\nstruct B { x: f32 }", wgsl), [""; 0]);
    assert_eq!(about("/// No WGSL struct: stale.\n#[repr(C)]\nstruct A { x: f32 }", "struct A { x: f32 }").len(), 1);
    assert_eq!(about("pub struct Plain { x: String }", wgsl), Vec::<String>::new());
}

#[test]
fn the_computed_layout_is_the_compilers() {
    #[repr(C)]
    struct Inner {
        a: f32,
        b: [u32; 3],
    }
    #[repr(C)]
    struct Outer {
        a: f32,
        b: glam::Vec4,
        c: [Inner; 2],
        d: glam::Vec3,
        e: glam::Mat4,
        f: u32,
    }
    let text = "#[repr(C)] struct Inner { a: f32, b: [u32; 3] }
                #[repr(C)] struct Outer { a: f32, b: glam::Vec4, c: [Inner; 2], d: glam::Vec3, e: glam::Mat4, f: u32 }";
    let declared = declarations(&Source::new("a.rs", text));
    let mut known = BTreeMap::new();
    known.insert("Inner".to_owned(), layout(&declared[0].fields, &known).expect("known types"));
    let outer = layout(&declared[1].fields, &known).expect("known types");
    let offsets: Vec<usize> = outer.members.iter().map(|m| m.offset as usize).collect();
    macro_rules! offset {
        ($($field:ident),*) => { [$(std::mem::offset_of!(Outer, $field)),*] };
    }
    assert_eq!(offsets, offset!(a, b, c, d, e, f));
    assert_eq!(outer.size as usize, size_of::<Outer>());
    assert_eq!(known["Inner"].size as usize, size_of::<Inner>());
}
