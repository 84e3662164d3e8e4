//! Compares each `#[repr(C)]` struct of `src/passes` with the WGSL struct of the same name: names, offsets, sizes and
//! scalar kinds of the members. A struct with no counterpart must say `/// No WGSL struct: why`.
//!
//! The Rust layout is computed from the source text by the rules of `repr(C)`, so that no struct can be forgotten; a test
//! holds these rules against the compiler's own `offset_of!`. Members whose names begin with `_` or `pad` are padding.

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
        self.members.iter().filter(|m| !m.name.starts_with('_') && !m.name.starts_with("pad")).collect()
    }
}

/// Every difference.
pub fn complaints(sources: &[Source], modules: &[Module]) -> Vec<String> {
    let crate_types = Known::read(sources);
    let mut complaints = crate_types.twice.clone();
    for declared in crate_types.structs.values() {
        let place = format!("{}: {}", declared.path, declared.name);
        let layout = match crate_types.layout(declared) {
            Ok(layout) => layout,
            Err(why) => {
                complaints.push(format!("{place}: {why}"));
                continue;
            }
        };
        let twins: Vec<_> =
            modules.iter().filter_map(|m| Some((&m.name, in_wgsl(&m.module, &declared.name)?))).collect();
        if twins.is_empty() != declared.excused {
            complaints.push(match declared.excused {
                true => format!("{place}: has a WGSL struct, but is excused from one"),
                false => format!("{place}: no WGSL struct of this name, and no line `/// No WGSL struct: ...`"),
            });
        }
        let differs = |twin: &Layout| twin.size != layout.size || twin.without_padding() != layout.without_padding();
        // Every shader holds its own copy of a shared struct: the first that differs says it all.
        if let Some((shader, twin)) = twins.iter().find(|(_, twin)| differs(twin)) {
            complaints.push(format!("{place} differs from shader {shader}:\n  Rust {layout:#?}\n  WGSL {twin:#?}"));
        }
    }
    complaints
}

/// The shared structs by name, and the constants that may stand as the length of an array.
struct Known {
    structs: BTreeMap<String, Declared>,
    lengths: BTreeMap<String, u32>,
    /// Complaints about names that were used twice.
    twice: Vec<String>,
}

impl Known {
    fn read(sources: &[Source]) -> Self {
        let rust = || sources.iter().filter(|s| s.path.ends_with(".rs"));
        let (mut structs, mut twice) = (BTreeMap::new(), Vec::new());
        for declared in rust().flat_map(declarations) {
            let place = format!("{}: {}", declared.path, declared.name);
            if let Some(other) = structs.insert(declared.name.clone(), declared) {
                twice.push(format!("{place}: {} has a shared struct of this name too", other.path));
            }
        }
        Self { structs, lengths: rust().flat_map(|s| lengths(&s.text)).collect(), twice }
    }

    /// The layout that `repr(C)` gives a struct.
    fn layout(&self, declared: &Declared) -> Result<Layout, String> {
        let (mut end, mut widest) = (0_u32, 1_u32);
        let mut members = Vec::new();
        for (name, ty) in &declared.fields {
            let (size, align, kind) = self.measured(ty).map_err(|why| format!("{name}: {why}"))?;
            let offset = end.next_multiple_of(align);
            members.push(Member { name: name.clone(), offset, size, kind });
            (end, widest) = (offset + size, widest.max(align));
        }
        Ok(Layout { members, size: end.next_multiple_of(widest), align: widest })
    }

    /// Size, alignment and scalar kind of a Rust type.
    fn measured(&self, ty: &[Token]) -> Result<(u32, u32, String), String> {
        let words: Vec<&str> = ty.iter().map(|t| t.text.as_str()).collect();
        match words.as_slice() {
            ["f32" | "u32" | "i32"] => Ok((4, 4, words[0].to_owned())),
            [.., "Vec2"] => Ok((8, 4, "f32".into())),
            [.., "Vec3"] => Ok((12, 4, "f32".into())),
            [.., "Vec4"] => Ok((16, 16, "f32".into())),
            [.., "Mat4"] => Ok((64, 16, "f32".into())),
            ["[", inner @ .., "]"] => {
                let semicolon = words.iter().rposition(|w| *w == ";").ok_or("a slice has no layout")?;
                let (size, align, kind) = self.measured(&ty[1..semicolon])?;
                let length = inner.last().copied().unwrap_or_default();
                let count = length.parse().ok().or_else(|| self.lengths.get(length).copied());
                Ok((size * count.ok_or(format!("`{length}` is not a plain number of elements"))?, align, kind))
            }
            [.., name] => {
                let unknown =
                    || format!("`{}` is no type of the table in tests/architecture/layouts.rs", words.join(""));
                let layout = self.layout(self.structs.get(*name).ok_or_else(unknown)?)?;
                Ok((layout.size, layout.align, (*name).to_owned()))
            }
            [] => Err("a field without a type".into()),
        }
    }
}

/// `const NAME: usize = 3;`, by name.
fn lengths(text: &str) -> Vec<(String, u32)> {
    let words: Vec<String> = tokens(text).into_iter().map(|t| t.text).collect();
    let constant = |w: &[String]| match w {
        [word, name, colon, ty, is, value, end] if word == "const" && colon == ":" && ty == "usize" && is == "=" => {
            value.replace('_', "").parse().ok().filter(|_| end == ";").map(|value| (name.clone(), value))
        }
        _ => None,
    };
    words.windows(7).filter_map(constant).collect()
}

/// A `#[repr(C)]` struct as it is written.
struct Declared {
    path: String,
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
            let path = source.path.clone();
            found.push(Declared { path, name, fields: fields(&tokens[at + 2..]), excused });
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
    complaints(&[Source::new("src/passes/a/mod.rs", rust)], &[Module { name: "a".into(), module }])
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
    assert_eq!(about(&format!("{agrees}\n{agrees}"), wgsl).len(), 1, "a name used twice");
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
    let text = "const TWO: usize = 2;
                #[repr(C)] struct Outer { a: f32, b: glam::Vec4, c: [Inner; TWO], d: glam::Vec3, e: glam::Mat4, f: u32 }
                #[repr(C)] struct Inner { a: f32, b: [u32; 3] }";
    let known = Known::read(&[Source::new("a.rs", text)]);
    let outer = known.layout(&known.structs["Outer"]).expect("known types");
    let inner = known.layout(&known.structs["Inner"]).expect("known types");
    let offsets: Vec<usize> = outer.members.iter().map(|m| m.offset as usize).collect();
    macro_rules! offset {
        ($($field:ident),*) => { [$(std::mem::offset_of!(Outer, $field)),*] };
    }
    assert_eq!(offsets, offset!(a, b, c, d, e, f));
    assert_eq!(outer.size as usize, size_of::<Outer>());
    assert_eq!(inner.size as usize, size_of::<Inner>());
}
