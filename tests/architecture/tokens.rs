//! Rust source cut into identifiers and punctuation, without comments, strings and lifetimes: enough to read paths and
//! plain structs. Keeps attributes, since `#[serde(...)]` names serde.

/// An identifier or number, or one character of punctuation; `::` is one token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Token {
    pub text: String,
    pub line: usize,
}

impl Token {
    pub fn is(&self, text: &str) -> bool {
        self.text == text
    }

    pub fn is_word(&self) -> bool {
        self.text.starts_with(|c: char| c.is_alphanumeric() || c == '_')
    }
}

/// The tokens of a source text.
pub fn tokens(text: &str) -> Vec<Token> {
    let chars: Vec<char> = text.chars().collect();
    let mut found = Vec::new();
    let (mut at, mut line) = (0, 1);
    while at < chars.len() {
        let begin = at;
        let rest = &chars[at..];
        let next = rest.get(1).copied().unwrap_or(' ');
        match rest[0] {
            '/' if next == '/' => at += rest.iter().position(|&c| c == '\n').unwrap_or(rest.len()),
            '/' if next == '*' => at += block_comment(rest),
            '"' => at += string(rest),
            'r' if raw_string(rest).is_some() => at += raw_string(rest).unwrap_or(1),
            'b' if next == 'r' && raw_string(&rest[1..]).is_some() => at += 1 + raw_string(&rest[1..]).unwrap_or(1),
            '\'' => at += character_or_lifetime(rest),
            ':' if next == ':' => {
                found.push(Token { text: "::".into(), line });
                at += 2;
            }
            c if c.is_alphanumeric() || c == '_' => {
                let length = rest.iter().take_while(|c| c.is_alphanumeric() || **c == '_').count();
                found.push(Token { text: rest[..length].iter().collect(), line });
                at += length;
            }
            c => {
                if !c.is_whitespace() {
                    found.push(Token { text: c.into(), line });
                }
                at += 1;
            }
        }
        line += chars[begin..at.min(chars.len())].iter().filter(|&&c| c == '\n').count();
    }
    found
}

/// Length of a block comment, which may hold others.
fn block_comment(rest: &[char]) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < rest.len() {
        match (rest[at], rest.get(at + 1)) {
            ('/', Some('*')) => (depth, at) = (depth + 1, at + 2),
            ('*', Some('/')) => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at
}

fn string(rest: &[char]) -> usize {
    let mut at = 1;
    while at < rest.len() && rest[at] != '"' {
        at += if rest[at] == '\\' { 2 } else { 1 };
    }
    at + 1
}

/// Length of `r"..."` or `r#"..."#`, if this is one.
fn raw_string(rest: &[char]) -> Option<usize> {
    let hashes = rest.iter().skip(1).take_while(|&&c| c == '#').count();
    if rest.get(1 + hashes) != Some(&'"') {
        return None;
    }
    let mut at = 2 + hashes;
    while at < rest.len() {
        if rest[at] == '"' && rest.len() > at + hashes && rest[at + 1..=at + hashes].iter().all(|&c| c == '#') {
            return Some(at + 1 + hashes);
        }
        at += 1;
    }
    Some(rest.len())
}

/// Length of `'a'`, `'\n'`, or the lifetime `'a`.
fn character_or_lifetime(rest: &[char]) -> usize {
    match (rest.get(1), rest.get(2)) {
        (Some('\\'), _) => 3 + rest.iter().skip(3).position(|&c| c == '\'').map_or(rest.len(), |n| n + 1),
        (Some(_), Some('\'')) => 3,
        _ => 1 + rest.iter().skip(1).take_while(|c| c.is_alphanumeric() || **c == '_').count(),
    }
}

#[test]
fn comments_strings_and_lifetimes_are_not_code() {
    let text = "a /* b /* c */ d */ \"e\\\" f\" r#\"g \" h\"# 'i' '\\'' j<'k> // l\nb\"m\" br\"n\" rough::o";
    let found: Vec<_> = tokens(text).into_iter().map(|t| t.text).collect();
    assert_eq!(found, ["a", "j", "<", ">", "b", "rough", "::", "o"]);
}

#[test]
fn lines_are_counted_through_everything() {
    let found = tokens("/*\n\n*/ a\n\"\n\" b");
    assert_eq!(found.iter().map(|t| t.line).collect::<Vec<_>>(), [3, 5]);
}
