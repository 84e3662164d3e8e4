//! The check of a value against its rule: every problem at once, each with path, value, limit and reason.

use super::node::{Kind, Node};
use super::problem::Problem;
use super::rule::{Field, Rule, Shape};
use crate::wire::limits;
use crate::world::event::Refused;

impl Rule {
    /// What is wrong with a value; nothing when all is well. At most as many as the limit of complaints.
    pub fn check(&self, node: &Node) -> Vec<Problem> {
        let mut check = Check { path: String::new(), problems: Vec::new() };
        check.value(self, node);
        check.problems
    }
}

struct Check {
    path: String,
    problems: Vec<Problem>,
}

impl Check {
    fn value(&mut self, rule: &Rule, node: &Node) {
        if rule.nullable && node.kind == Kind::Null {
            return;
        }
        match (&rule.shape, &node.kind) {
            (_, Kind::BadNumber) => {}
            (Shape::Number { min, max }, Kind::Number(number)) => {
                self.range(rule, node, number.as_f64().unwrap_or(f64::NAN), *min, *max);
            }
            (Shape::Whole { min, max }, Kind::Number(number)) if !number.is_f64() => {
                self.range(rule, node, number.as_f64().unwrap_or(f64::NAN), *min, *max);
            }
            (Shape::Text { min, max, allowed }, Kind::Text(text)) => {
                let length = text.chars().count();
                if !(*min..=*max).contains(&length) || allowed.is_some_and(|allowed| !allowed.allow(text)) {
                    self.report(node, rule, "not allowed");
                }
            }
            (Shape::Flag, Kind::Flag(_)) | (Shape::Null, Kind::Null) => {}
            (Shape::Word(words), Kind::Text(text)) if words.contains(text) => {}
            (Shape::Word(_), Kind::Text(_)) => self.report(node, rule, "unknown word"),
            (Shape::List { element, min, max }, Kind::List(elements)) => {
                if !(*min..=*max).contains(&elements.len()) {
                    self.report(node, rule, "wrong number of elements");
                }
                for (index, node) in elements.iter().enumerate().take(*max) {
                    self.inside(&format!("[{index}]"), |check| check.value(element, node));
                }
            }
            (Shape::Fields(fields), Kind::Object(members)) => self.fields(fields, node, members),
            (Shape::Tagged { tag, variants }, Kind::Object(_)) => self.tagged(rule, tag, variants, node),
            (Shape::Either(rules), _) => match rules.iter().find(|rule| rule.takes(&node.kind)) {
                Some(fitting) => self.value(fitting, node),
                None => self.report(node, rule, "wrong type"),
            },
            _ => self.report(node, rule, "wrong type"),
        }
    }

    fn range(&mut self, rule: &Rule, node: &Node, value: f64, min: f64, max: f64) {
        if !(min..=max).contains(&value) {
            self.report(node, rule, "out of range");
        }
    }

    fn fields(&mut self, fields: &[Field], node: &Node, members: &[(String, usize, Node)]) {
        for (key, key_offset, member) in members {
            match fields.iter().find(|field| field.name == *key) {
                Some(field) => self.inside(key, |check| check.value(&field.rule, member)),
                None => {
                    let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
                    let limit = format!("one of: {}", names.join(", "));
                    let key: String = key.chars().take(60).collect();
                    self.inside(&key, |check| check.problem(*key_offset, member.shown(), limit, "unknown field"));
                }
            }
        }
        for field in fields.iter().filter(|field| field.required && node.member(&field.name).is_none()) {
            self.inside(&field.name, |check| check.missing(&field.rule, node));
        }
    }

    fn tagged(&mut self, rule: &Rule, tag: &str, variants: &[(String, Rule)], node: &Node) {
        let names: Vec<&str> = variants.iter().map(|(name, _)| name.as_str()).collect();
        let limit = format!("one of: {}", names.join(", "));
        match node.member(tag) {
            None => self.inside(tag, |check| {
                check.problem(node.offset, "not given".into(), limit, &format!("missing{}", rule.explained()));
            }),
            Some(Node { kind: Kind::Text(name), .. }) if names.contains(&name.as_str()) => {
                if let Some((_, rule)) = variants.iter().find(|(variant, _)| variant == name) {
                    self.value(rule, node);
                }
            }
            Some(other) => self.inside(tag, |check| {
                check.problem(other.offset, other.shown(), limit, "unknown word");
            }),
        }
    }

    fn missing(&mut self, rule: &Rule, node: &Node) {
        let why = format!("missing{}", rule.explained());
        self.problem(node.offset, "not given".into(), rule.limit(), &why);
    }

    fn report(&mut self, node: &Node, rule: &Rule, what: &str) {
        self.problem(node.offset, node.shown(), rule.limit(), &format!("{what}{}", rule.explained()));
    }

    fn problem(&mut self, offset: usize, value: String, limit: String, why: &str) {
        if self.problems.len() < limits::COMPLAINTS {
            let refused = Refused::new(self.path.clone(), value, limit, why);
            self.problems.push(Problem { offset, refused });
        }
    }

    /// Runs with the path longer by one step.
    fn inside(&mut self, step: &str, run: impl FnOnce(&mut Self)) {
        let length = self.path.len();
        if length > 0 && !step.starts_with('[') {
            self.path.push('.');
        }
        self.path.push_str(step);
        run(self);
        self.path.truncate(length);
    }
}

impl Rule {
    /// Whether a value is of the right type, whatever its range.
    fn takes(&self, kind: &Kind) -> bool {
        match (&self.shape, kind) {
            (Shape::Number { .. } | Shape::Whole { .. }, Kind::Number(_))
            | (Shape::Text { .. } | Shape::Word(_), Kind::Text(_))
            | (Shape::Flag, Kind::Flag(_))
            | (Shape::List { .. }, Kind::List(_))
            | (Shape::Fields(_) | Shape::Tagged { .. }, Kind::Object(_)) => true,
            (Shape::Either(rules), kind) => rules.iter().any(|rule| rule.takes(kind)),
            _ => false,
        }
    }

    /// What is allowed, in words.
    fn limit(&self) -> String {
        match &self.shape {
            Shape::Number { min, max } => format!("a number{}", between(*min, *max, f64::MIN, f64::MAX)),
            Shape::Whole { min, max } => {
                format!("a whole number{}", between(*min, *max, i64::MIN as f64, u64::MAX as f64))
            }
            Shape::Text { min, max, allowed } => {
                let set = match allowed {
                    Some(set) if set.upper => " of letters, digits, - and _",
                    Some(_) => " of small letters, digits and -",
                    None => "",
                };
                format!("a text{set}, {min} to {max} characters")
            }
            Shape::Flag => "true or false".into(),
            Shape::Word(words) => format!("one of: {}", words.join(", ")),
            Shape::List { min, max, .. } if min == max => format!("a list of {min}"),
            Shape::List { min, max, .. } => format!("a list of {min} to {max}"),
            Shape::Fields(_) | Shape::Tagged { .. } => "an object".into(),
            Shape::Either(rules) => rules.iter().map(Rule::limit).collect::<Vec<_>>().join(", or "),
            Shape::Null => "null".into(),
        }
    }

    fn explained(&self) -> String {
        if self.meaning.is_empty() { String::new() } else { format!(": {}", self.meaning) }
    }
}

fn between(min: f64, max: f64, least: f64, most: f64) -> String {
    match (min > least, max < most) {
        (true, true) => format!(", {min} to {max}"),
        (true, false) => format!(", at least {min}"),
        (false, true) => format!(", at most {max}"),
        (false, false) => String::new(),
    }
}
