//! Rules: a published schema, made ready for checking.
//!
//! Only the part of JSON Schema that our types give is understood, and a keyword outside it is an error of ours, found by
//! the tests: no bound that is published can be forgotten in the check.

use serde_json::{Map, Value};

/// What a value has to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// What the value means, for the refusal.
    pub(super) meaning: String,
    /// Whether `null` stands for "not given".
    pub(super) nullable: bool,
    pub(super) shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    Number { min: f64, max: f64 },
    Whole { min: f64, max: f64 },
    Text { min: usize, max: usize, allowed: Option<Characters> },
    Flag,
    Word(Vec<String>),
    List { element: Box<Rule>, min: usize, max: usize },
    Fields(Vec<Field>),
    Tagged { tag: String, variants: Vec<(String, Rule)> },
    Either(Vec<Rule>),
    Null,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub name: String,
    pub required: bool,
    pub rule: Rule,
}

/// The sets of characters that our patterns mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Characters {
    pub upper: bool,
    pub underscore: bool,
}

impl Characters {
    pub fn allow(self, text: &str) -> bool {
        text.chars().all(|c| {
            c.is_ascii_lowercase()
                || c.is_ascii_digit()
                || c == '-'
                || (self.upper && c.is_ascii_uppercase())
                || (self.underscore && c == '_')
        })
    }

    fn of(pattern: &str) -> Option<Self> {
        match pattern {
            crate::wire::limits::NAME_PATTERN => Some(Self { upper: true, underscore: true }),
            crate::wire::limits::SCENARIO_NAME_PATTERN => Some(Self { upper: false, underscore: false }),
            _ => None,
        }
    }
}

const KEYWORDS: &[&str] = &[
    "$defs",
    "$ref",
    "$schema",
    "additionalProperties",
    "anyOf",
    "const",
    "default",
    "description",
    "enum",
    "format",
    "items",
    "maxItems",
    "maxLength",
    "maximum",
    "minItems",
    "minLength",
    "minimum",
    "oneOf",
    "pattern",
    "properties",
    "required",
    "title",
    "type",
];

impl Rule {
    /// The rule of a schema with its definitions under `$defs`.
    ///
    /// # Errors
    /// The schema says something that this check does not understand.
    pub fn from_schema(root: &Value) -> Result<Self, String> {
        let empty = Map::new();
        let definitions = root.get("$defs").and_then(Value::as_object).unwrap_or(&empty);
        rule(root, definitions, 0)
    }
}

fn rule(schema: &Value, definitions: &Map<String, Value>, depth: usize) -> Result<Rule, String> {
    let Some(map) = schema.as_object() else { return Err(format!("no schema: {schema}")) };
    if depth > 2 * crate::wire::limits::JSON_DEPTH {
        return Err("a definition contains itself".into());
    }
    if let Some(unknown) = map.keys().find(|key| !KEYWORDS.contains(&key.as_str())) {
        return Err(format!("keyword {unknown} in {schema}"));
    }
    let within = |schema: &Value| rule(schema, definitions, depth + 1);
    let own_meaning = map.get("description").and_then(Value::as_str).map(first_sentence);
    let named = |rule: Rule| Rule { meaning: own_meaning.clone().unwrap_or(rule.meaning.clone()), ..rule };

    if let Some(reference) = map.get("$ref").and_then(Value::as_str) {
        let name = reference.strip_prefix("#/$defs/").ok_or(format!("reference {reference}"))?;
        let target = definitions.get(name).ok_or(format!("no definition {name}"))?;
        return within(target).map(named);
    }
    if let Some(branches) = map.get("anyOf").and_then(Value::as_array) {
        let rules = branches.iter().map(within).collect::<Result<Vec<_>, _>>()?;
        let nullable = rules.iter().any(|rule| rule.shape == Shape::Null);
        let mut rules: Vec<Rule> = rules.into_iter().filter(|rule| rule.shape != Shape::Null).collect();
        let one = if rules.len() == 1 { rules.pop() } else { None };
        let rule = one.unwrap_or(Rule { meaning: String::new(), nullable, shape: Shape::Either(rules) });
        return Ok(named(Rule { nullable: nullable || rule.nullable, ..rule }));
    }
    let (shape, nullable) = if let Some(branches) = map.get("oneOf").and_then(Value::as_array) {
        (one_of(branches, &within)?, false)
    } else if let Some(words) = map.get("enum").and_then(Value::as_array) {
        (Shape::Word(words.iter().filter_map(Value::as_str).map(str::to_owned).collect()), false)
    } else if let Some(word) = map.get("const").and_then(Value::as_str) {
        (Shape::Word(vec![word.to_owned()]), false)
    } else {
        typed(map, &within)?
    };
    Ok(Rule { meaning: own_meaning.unwrap_or_default(), nullable, shape })
}

type Within<'a> = dyn Fn(&Value) -> Result<Rule, String> + 'a;

fn one_of(branches: &[Value], within: &Within) -> Result<Shape, String> {
    let words: Option<Vec<&str>> = branches.iter().map(|branch| branch.get("const")?.as_str()).collect();
    if let Some(words) = words {
        return Ok(Shape::Word(words.into_iter().map(str::to_owned).collect()));
    }
    let tag = tag(branches).ok_or("a union without a tag")?;
    let variant = |branch: &Value| {
        let name = tag_value(branch, &tag).ok_or("a variant without its tag")?;
        Ok::<_, String>((name.to_owned(), within(branch)?))
    };
    let variants = branches.iter().map(variant).collect::<Result<Vec<_>, _>>()?;
    Ok(Shape::Tagged { tag, variants })
}

fn tag_value<'a>(branch: &'a Value, tag: &str) -> Option<&'a str> {
    branch.get("properties")?.get(tag)?.get("const")?.as_str()
}

/// The property that has a constant of its own in each branch.
fn tag(branches: &[Value]) -> Option<String> {
    let candidates = branches.first()?.get("properties")?.as_object()?.keys();
    candidates.into_iter().find_map(|candidate| {
        let values: Option<Vec<&str>> = branches.iter().map(|branch| tag_value(branch, candidate)).collect();
        let mut values = values?;
        values.sort_unstable();
        values.windows(2).all(|pair| pair[0] != pair[1]).then(|| candidate.clone())
    })
}

fn typed(map: &Map<String, Value>, within: &Within) -> Result<(Shape, bool), String> {
    let types: Vec<&str> = match map.get("type") {
        Some(Value::String(one)) => vec![one],
        Some(Value::Array(several)) => several.iter().filter_map(Value::as_str).collect(),
        _ => return Err(format!("no type in {map:?}")),
    };
    let nullable = types.len() > 1 && types.contains(&"null");
    let number = |key: &str, otherwise: f64| map.get(key).and_then(Value::as_f64).unwrap_or(otherwise);
    let count = |key: &str, otherwise: usize| map.get(key).and_then(Value::as_u64).map_or(otherwise, |n| n as usize);
    let shape = match types.iter().find(|name| **name != "null") {
        None => Shape::Null,
        Some(&"number") => Shape::Number { min: number("minimum", f64::MIN), max: number("maximum", f64::MAX) },
        Some(&"integer") => Shape::Whole {
            min: number("minimum", i64::MIN as f64),
            max: number("maximum", largest(map.get("format").and_then(Value::as_str))),
        },
        Some(&"boolean") => Shape::Flag,
        Some(&"string") => {
            let pattern = map.get("pattern").and_then(Value::as_str);
            let allowed =
                pattern.map(|pattern| Characters::of(pattern).ok_or(format!("pattern {pattern}"))).transpose()?;
            Shape::Text { min: count("minLength", 0), max: count("maxLength", usize::MAX), allowed }
        }
        Some(&"array") => Shape::List {
            element: Box::new(within(map.get("items").ok_or("a list without items")?)?),
            min: count("minItems", 0),
            max: count("maxItems", usize::MAX),
        },
        Some(&"object") => Shape::Fields(fields(map, within)?),
        Some(other) => return Err(format!("type {other}")),
    };
    Ok((shape, nullable))
}

fn fields(map: &Map<String, Value>, within: &Within) -> Result<Vec<Field>, String> {
    if map.get("additionalProperties") != Some(&Value::Bool(false)) {
        return Err(format!("an object that lets unknown fields pass: {map:?}"));
    }
    let required: Vec<&str> =
        map.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect();
    let properties = map.get("properties").and_then(Value::as_object);
    let field = |(name, schema): (&String, &Value)| {
        Ok(Field { name: name.clone(), required: required.contains(&name.as_str()), rule: within(schema)? })
    };
    properties.into_iter().flatten().map(field).collect()
}

/// The largest whole number of a Rust type, by the format that schemars gives it.
fn largest(format: Option<&str>) -> f64 {
    match format {
        Some("uint8") => f64::from(u8::MAX),
        Some("uint16") => f64::from(u16::MAX),
        Some("uint32") => f64::from(u32::MAX),
        _ => u64::MAX as f64,
    }
}

fn first_sentence(description: &str) -> String {
    let line = description.split("\n\n").next().unwrap_or_default().replace('\n', " ");
    line.trim_end_matches('.').to_owned()
}
