//! The parser: text to nodes, under limits that hold before memory is taken.
//!
//! serde_json alone would not do: it keeps the last of two members of one name, forgets where a value stood, and limits
//! nothing but the depth. Its readers of one text and one number are used for exactly those.

use super::node::{Kind, Node};
use super::problem::Problem;
use crate::wire::limits;
use crate::world::event::Refused;
use serde_json::Number;

/// How large a text may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Bytes.
    pub bytes: usize,
    /// Values of any kind.
    pub values: usize,
}

/// What was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed {
    /// The outermost value.
    pub root: Node,
    /// Members given twice and numbers that are not finite; the rest could be read.
    pub problems: Vec<Problem>,
}

/// Reads a JSON text.
///
/// # Errors
/// The text is no JSON, or is larger or deeper than allowed: it was not read further than that.
pub fn parse(text: &str, size: Size) -> Result<Parsed, Box<Problem>> {
    if text.len() > size.bytes {
        let refused = Refused::new("", format!("{} bytes", text.len()), format!("{} bytes", size.bytes), "too large");
        return Err(Box::new(Problem { offset: 0, refused }));
    }
    let mut parser = Parser { text, at: 0, values: size.values, path: Vec::new(), problems: Vec::new() };
    let root = parser.value(0)?;
    parser.space();
    if parser.at < text.len() {
        return Err(parser.wrong(parser.at, "nothing more", "there is text after the JSON value"));
    }
    Ok(Parsed { root, problems: parser.problems })
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    /// Values that may still come.
    values: usize,
    path: Vec<Step>,
    problems: Vec<Problem>,
}

enum Step {
    Member(String),
    Element(usize),
}

type Outcome<T> = Result<T, Box<Problem>>;

impl Parser<'_> {
    /// One value. The recursion is bounded by the limit of depth.
    fn value(&mut self, depth: usize) -> Outcome<Node> {
        self.space();
        let offset = self.at;
        if depth > limits::JSON_DEPTH {
            return Err(self.wrong(offset, format!("{} levels", limits::JSON_DEPTH), "too deep"));
        }
        self.values = match self.values.checked_sub(1) {
            Some(left) => left,
            None => return Err(self.wrong(offset, "fewer values", "too many values in one text")),
        };
        let kind = match self.peek() {
            Some(b'{') => self.object(depth)?,
            Some(b'[') => self.list(depth)?,
            Some(b'"') => Kind::Text(self.string()?),
            Some(b'-' | b'0'..=b'9') => self.number()?,
            _ => self.word()?,
        };
        Ok(Node { offset, kind })
    }

    fn object(&mut self, depth: usize) -> Outcome<Kind> {
        let mut members: Vec<(String, usize, Node)> = Vec::new();
        self.at += 1;
        self.space();
        if self.take(b'}') {
            return Ok(Kind::Object(members));
        }
        loop {
            self.space();
            let key_offset = self.at;
            if self.peek() != Some(b'"') {
                return Err(self.wrong(self.at, "a field's name in quotes", "this is no JSON"));
            }
            let key = self.string()?;
            self.space();
            if !self.take(b':') {
                return Err(self.wrong(self.at, "`:` after a field's name", "this is no JSON"));
            }
            // A linear search per member stays cheap because an object has few of them.
            if members.len() == limits::OBJECT_FIELDS {
                let limit = format!("{} fields in one object", limits::OBJECT_FIELDS);
                return Err(self.wrong(key_offset, limit, "too many fields"));
            }
            self.path.push(Step::Member(key.chars().take(60).collect()));
            let node = self.value(depth + 1)?;
            if members.iter().any(|(other, _, _)| *other == key) {
                self.report(
                    key_offset,
                    Refused::new(self.path_text(), node.shown(), "once", "the field is given twice"),
                );
            } else {
                members.push((key, key_offset, node));
            }
            self.path.pop();
            self.space();
            if self.take(b'}') {
                return Ok(Kind::Object(members));
            }
            if !self.take(b',') {
                return Err(self.wrong(self.at, "`,` or `}`", "this is no JSON"));
            }
        }
    }

    fn list(&mut self, depth: usize) -> Outcome<Kind> {
        let mut elements = Vec::new();
        self.at += 1;
        self.space();
        if self.take(b']') {
            return Ok(Kind::List(elements));
        }
        loop {
            self.path.push(Step::Element(elements.len()));
            elements.push(self.value(depth + 1)?);
            self.path.pop();
            self.space();
            if self.take(b']') {
                return Ok(Kind::List(elements));
            }
            if !self.take(b',') {
                return Err(self.wrong(self.at, "`,` or `]`", "this is no JSON"));
            }
        }
    }

    fn string(&mut self) -> Outcome<String> {
        let begin = self.at;
        let mut escaped = false;
        let bytes = self.text.as_bytes();
        let length = bytes[begin + 1..].iter().position(|&byte| {
            let ends = byte == b'"' && !escaped;
            escaped = byte == b'\\' && !escaped;
            ends
        });
        let Some(length) = length else {
            return Err(self.wrong(begin, "a closing quote", "this is no JSON"));
        };
        let end = begin + 1 + length + 1;
        self.at = end;
        serde_json::from_str(&self.text[begin..end])
            .map_err(|_| self.wrong(begin, "a text without control characters and bad escapes", "this is no JSON"))
    }

    fn number(&mut self) -> Outcome<Kind> {
        let begin = self.at;
        let bytes = &self.text.as_bytes()[begin..];
        let is_part = |byte: &u8| matches!(byte, b'0'..=b'9' | b'-' | b'+' | b'.' | b'e' | b'E');
        let length = bytes.iter().position(|byte| !is_part(byte)).unwrap_or(bytes.len());
        let token = &self.text[begin..begin + length];
        self.at += length;
        if !is_number(token) {
            return Err(self.wrong(begin, "a JSON number", "this is no JSON"));
        }
        if let Ok(whole) = token.parse::<u64>() {
            return Ok(Kind::Number(whole.into()));
        }
        // Rust's reader rounds correctly, so that a value printed by us comes back as the same f64.
        let value = token.parse::<f64>().unwrap_or(f64::INFINITY);
        const EXACT: f64 = 9_007_199_254_740_992.0;
        if value.fract() == 0.0 && value.abs() < EXACT && !(value == 0.0 && value.is_sign_negative()) {
            return Ok(Kind::Number((value as i64).into()));
        }
        match Number::from_f64(value) {
            Some(number) => Ok(Kind::Number(number)),
            None => {
                self.report(
                    begin,
                    Refused::new(self.path_text(), token, "a finite 64-bit number", "too large a number"),
                );
                Ok(Kind::BadNumber)
            }
        }
    }

    fn word(&mut self) -> Outcome<Kind> {
        for (word, kind) in [("null", Kind::Null), ("true", Kind::Flag(true)), ("false", Kind::Flag(false))] {
            if self.text.as_bytes()[self.at..].starts_with(word.as_bytes()) {
                self.at += word.len();
                return Ok(kind);
            }
        }
        Err(self.wrong(self.at, "a JSON value", "this is no JSON"))
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn take(&mut self, byte: u8) -> bool {
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    fn space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    fn report(&mut self, offset: usize, refused: Refused) {
        if self.problems.len() < limits::COMPLAINTS {
            self.problems.push(Problem { offset, refused });
        }
    }

    fn wrong(&self, offset: usize, limit: impl Into<String>, why: &str) -> Box<Problem> {
        let rest = self.text.as_bytes().get(offset..).unwrap_or_default();
        let found = String::from_utf8_lossy(&rest[..rest.len().min(20)]).into_owned();
        let found = if found.is_empty() { "the end of the text".to_owned() } else { found };
        Box::new(Problem { offset, refused: Refused::new(self.path_text(), found, limit, why) })
    }

    fn path_text(&self) -> String {
        let mut text = String::new();
        for step in &self.path {
            match step {
                Step::Member(name) if text.is_empty() => text.push_str(name),
                Step::Member(name) => text.extend([".", name]),
                Step::Element(index) => text.push_str(&format!("[{index}]")),
            }
        }
        text
    }
}

/// Whether a token follows the grammar of numbers in RFC 8259.
fn is_number(token: &str) -> bool {
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let unsigned = token.strip_prefix('-').unwrap_or(token);
    let (mantissa, exponent) = match unsigned.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, Some(exponent)),
        None => (unsigned, None),
    };
    let (whole, fraction) = match mantissa.split_once('.') {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (mantissa, None),
    };
    digits(whole)
        && (whole == "0" || !whole.starts_with('0'))
        && fraction.is_none_or(digits)
        && exponent.is_none_or(|exponent| digits(exponent.strip_prefix(['+', '-']).unwrap_or(exponent)))
}
