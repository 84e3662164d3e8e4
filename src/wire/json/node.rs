//! A JSON value that knows where it stood in the text.

use serde_json::{Map, Number, Value};

/// A value and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Byte offset of its first character.
    pub offset: usize,
    /// The value.
    pub kind: Kind,
}

/// A value. A number too large for f64 and a second member of the same name have been reported and are not in here.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// `null`.
    Null,
    /// `true` or `false`.
    Flag(bool),
    /// A finite number; whole numbers that f64 holds exactly are whole here, however they were written.
    Number(Number),
    /// A number that was reported because it is not finite.
    BadNumber,
    /// A text.
    Text(String),
    /// A list.
    List(Vec<Node>),
    /// An object: key, offset of the key, value, in the order of the text.
    Object(Vec<(String, usize, Node)>),
}

impl Node {
    /// The member of this name, when this is an object that has one.
    pub fn member(&self, name: &str) -> Option<&Node> {
        match &self.kind {
            Kind::Object(members) => members.iter().find(|(key, _, _)| key == name).map(|(_, _, node)| node),
            _ => None,
        }
    }

    /// The elements, when this is a list.
    pub fn elements(&self) -> Option<&[Node]> {
        match &self.kind {
            Kind::List(elements) => Some(elements),
            _ => None,
        }
    }

    /// The value at a path like `layers[2].base_m`, or the nearest one above it.
    pub fn nearest(&self, path: &str) -> &Node {
        let mut node = self;
        for step in path.split(['.', '[']).filter(|step| !step.is_empty()) {
            let index = step.strip_suffix(']').and_then(|index| index.parse::<usize>().ok());
            let next = match index {
                Some(index) => node.elements().and_then(|elements| elements.get(index)),
                None => node.member(step),
            };
            let Some(next) = next else { break };
            node = next;
        }
        node
    }

    /// The value without places, for serde.
    pub fn to_value(&self) -> Value {
        match &self.kind {
            Kind::Null | Kind::BadNumber => Value::Null,
            Kind::Flag(flag) => Value::Bool(*flag),
            Kind::Number(number) => Value::Number(number.clone()),
            Kind::Text(text) => Value::String(text.clone()),
            Kind::List(elements) => Value::Array(elements.iter().map(Node::to_value).collect()),
            Kind::Object(members) => Value::Object(
                members.iter().map(|(key, _, node)| (key.clone(), node.to_value())).collect::<Map<_, _>>(),
            ),
        }
    }

    /// A short form for people, made without walking through long values.
    pub fn shown(&self) -> String {
        match &self.kind {
            Kind::Null => "null".into(),
            Kind::Flag(flag) => flag.to_string(),
            Kind::Number(number) => number.to_string(),
            Kind::BadNumber => "a number that is not finite".into(),
            Kind::Text(text) => format!("\"{}\"", text.chars().take(60).collect::<String>()),
            Kind::List(elements) => format!("a list of {}", elements.len()),
            Kind::Object(members) => format!("an object of {} fields", members.len()),
        }
    }
}
