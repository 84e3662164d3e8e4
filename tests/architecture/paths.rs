//! The paths that a Rust file names, as full paths from the crate root: `use` trees with nested braces, `crate::`,
//! `self::` and `super::` in the middle of code, and outside crates.

use super::files::Source;
use super::tokens::{Token, tokens};

/// A path that a file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// Segments; the first is `crate` or the name of an outside crate (or of anything in scope).
    pub segments: Vec<String>,
    pub line: usize,
}

/// The module of a file as segments below the crate root: `src/gpu/ring.rs` is `gpu::ring`.
pub fn module_of(path: &str) -> Vec<String> {
    let inner = path.trim_start_matches("src/").trim_end_matches(".rs");
    let mut segments: Vec<String> = inner.split('/').map(str::to_owned).collect();
    if matches!(segments.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        segments.pop();
    }
    segments
}

/// Every path with at least two segments, and every `use` of a single name.
pub fn named(source: &Source) -> Vec<Named> {
    let tokens = tokens(&source.text);
    let mut found = Vec::new();
    // The module at each open brace: `mod tests {` goes one deeper.
    let mut modules = vec![module_of(&source.path)];
    let mut at = 0;
    while at < tokens.len() {
        let token = &tokens[at];
        let here = modules.last().cloned().unwrap_or_default();
        let follows_path = at > 0 && (tokens[at - 1].is(".") || continues(&tokens[..at]));
        if token.is("{") {
            let mut inner = here;
            if at >= 2 && tokens[at - 2].is("mod") {
                inner.push(tokens[at - 1].text.clone());
            }
            modules.push(inner);
        } else if token.is("}") && modules.len() > 1 {
            modules.pop();
        } else if token.is("use") || (token.is("crate") && at > 0 && tokens[at - 1].is("extern")) {
            // A leading `::` says that an outside crate is meant.
            at += 1 + usize::from(tokens.get(at + 1).is_some_and(|t| t.is("::")));
            at = tree(&tokens, at, &[], &here, &mut found);
            continue;
        } else if token.is_word() && !follows_path && tokens.get(at + 1).is_some_and(|t| t.is("::")) {
            at = tree(&tokens, at, &[], &here, &mut found);
            continue;
        }
        at += 1;
    }
    found
}

/// Whether the last token is a `::` inside a path, and not one that leads it (`-> ::wgpu::Limits`).
fn continues(before: &[Token]) -> bool {
    const LEADING: &[&str] = &["as", "return", "in", "mut", "dyn", "impl", "else", "match", "if", "const"];
    let [.., earlier, previous, last] = before else { return false };
    let ends_path = previous.is_word() && !LEADING.contains(&previous.text.as_str());
    last.is("::") && (ends_path || (previous.is(">") && !earlier.is("-")))
}

/// Reads one path or `use` tree beginning at `at`; returns where it ends.
fn tree(tokens: &[Token], mut at: usize, prefix: &[String], here: &[String], found: &mut Vec<Named>) -> usize {
    let mut path = prefix.to_vec();
    let line = tokens.get(at).map_or(0, |t| t.line);
    while let Some(token) = tokens.get(at) {
        if token.is("{") {
            at += 1;
            while tokens.get(at).is_some_and(|t| !t.is("}")) {
                let begin = at;
                at = tree(tokens, at, &path, here, found);
                while tokens.get(at).is_some_and(|t| !t.is(",") && !t.is("}") && !t.is("{")) {
                    at += 1;
                }
                at += usize::from(tokens.get(at).is_some_and(|t| t.is(",")) || at == begin);
            }
            return at + 1;
        }
        if !(token.is_word() || token.is("*")) {
            break;
        }
        path.push(token.text.clone());
        at += 1;
        if !tokens.get(at).is_some_and(|t| t.is("::")) {
            break;
        }
        at += 1;
    }
    if !path.is_empty() {
        found.push(Named { segments: from_root(&path, here), line });
    }
    at
}

/// Resolves `self` and `super` against the module that the path stands in.
fn from_root(path: &[String], here: &[String]) -> Vec<String> {
    let mut module = here.to_vec();
    let mut at = 0;
    let mut relative = false;
    while let Some(segment) = path.get(at) {
        match segment.as_str() {
            "self" => relative = true,
            "super" => {
                module.pop();
                relative = true;
            }
            _ => break,
        }
        at += 1;
    }
    if !relative {
        return path.to_vec();
    }
    let mut full = vec!["crate".to_owned()];
    full.extend(module);
    full.extend(path[at..].iter().cloned());
    full
}

#[cfg(test)]
fn joined(path: &str, text: &str) -> Vec<String> {
    named(&Source::new(path, text)).into_iter().map(|n| n.segments.join("::")).collect()
}

#[test]
fn use_trees_are_flattened() {
    let text = "use crate::{a::{B, c::*}, d as e, self};\nuse std::fmt;\nuse ::wgpu as w;\nextern crate tokio;";
    assert_eq!(
        joined("src/x/y.rs", text),
        ["crate::a::B", "crate::a::c::*", "crate::d", "crate::self", "std::fmt", "wgpu", "tokio"]
    );
}

#[test]
fn inline_paths_and_macros_are_seen() {
    let text = "fn f() -> crate::gpu::Ring<crate::b::T> { $crate::m!(); a.b::<C>(); wgpu::Limits::default() }";
    assert_eq!(joined("src/x.rs", text), ["crate::gpu::Ring", "crate::b::T", "crate::m", "wgpu::Limits::default"]);
}

#[test]
fn super_is_resolved_even_inside_an_inline_module() {
    assert_eq!(joined("src/clouds/light.rs", "use super::super::gpu::Ring;"), ["crate::gpu::Ring"]);
    assert_eq!(joined("src/clouds/mod.rs", "use super::gpu::Ring;"), ["crate::gpu::Ring"]);
    let nested = "mod tests { use super::*; fn f() { super::super::g::h() } } use super::a;";
    assert_eq!(joined("src/units.rs", nested), ["crate::units::*", "crate::g::h", "crate::a"]);
}
