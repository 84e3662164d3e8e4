//! What the parser and the check pin: limits before memory, problems with the right path and place, never a panic.

use super::{Kind, Rule, Size, parse};
use serde_json::json;

const SIZE: Size = Size { bytes: 1000, values: 100 };

fn refusal(text: &str) -> crate::world::event::Refused {
    parse(text, SIZE).expect_err(text).refused
}

#[test]
fn what_serde_json_reads_is_read_alike() {
    for text in [
        "null",
        " true ",
        "false",
        "0",
        "-1.5e3",
        "1E+2",
        "\"a\\u00e9\\n\\ud83d\\ude00\"",
        "[]",
        "[1, [2], {}]",
        "{\"a\": {\"b\": [null, \"\"]}, \"c\": 0.1}",
        "18446744073709551615",
        "-9007199254740991",
        "4.9e-324",
    ] {
        let parsed = parse(text, SIZE).expect(text);
        assert_eq!(parsed.problems, [], "{text}");
        let expected: serde_json::Value = serde_json::from_str(text).expect(text);
        let (ours, theirs) = (parsed.root.to_value(), expected);
        let same = ours == theirs || ours.as_f64() == theirs.as_f64() && ours.is_number();
        assert!(same, "{text}: {ours} and {theirs}");
    }
}

#[test]
fn what_serde_json_refuses_is_refused() {
    for text in [
        "",
        " ",
        "nul",
        "01",
        "1.",
        ".5",
        "+1",
        "-",
        "1e",
        "\"",
        "\"\\x\"",
        "\"\u{1}\"",
        "[",
        "[1,]",
        "[1 2]",
        "{",
        "{a:1}",
        "{\"a\" 1}",
        "{\"a\":1,}",
        "1 2",
        "[1]]",
        "'a'",
        "\"\\ud83d\"",
        "NaN",
        "Infinity",
        "\u{feff}1",
    ] {
        assert!(serde_json::from_str::<serde_json::Value>(text).is_err(), "serde_json reads {text:?}");
        assert!(!refusal(text).why.is_empty(), "{text:?}");
    }
}

#[test]
fn limits_hold() {
    let nested = |depth: usize| format!("{}{}", "[".repeat(depth), "]".repeat(depth));
    assert!(parse(&nested(13), SIZE).is_ok(), "twelve levels below the outermost list");
    assert_eq!(refusal(&nested(14)).why, "too deep");
    assert_eq!(refusal(&"[".repeat(900)).why, "too deep");
    assert_eq!(refusal(&" ".repeat(1001)).why, "too large");
    assert!(parse(&format!("[{}]", vec!["1"; 99].join(",")), SIZE).is_ok());
    assert_eq!(refusal(&format!("[{}]", vec!["1"; 100].join(","))).why, "too many values in one text");
    let members: Vec<String> = (0..65).map(|k| format!("\"{k}\":1")).collect();
    assert_eq!(refusal(&format!("{{{}}}", members.join(","))).why, "too many fields");
}

#[test]
fn a_field_given_twice_and_a_number_beyond_f64_are_reported_with_their_paths() {
    let text = "{\"a\": [1,\n {\"b\": 1, \"b\": 2}, 1e999], \"c\": -1e400}";
    let parsed = parse(text, SIZE).expect("readable");
    let complaints: Vec<_> = parsed.problems.into_iter().map(|problem| problem.in_text(text)).collect();
    let places: Vec<_> = complaints.iter().map(|c| (c.path.as_str(), c.line, c.column)).collect();
    assert_eq!(places, [("a[1].b", 2, 11), ("a[2]", 2, 20), ("c", 2, 33)]);
    assert_eq!(parsed.root.member("c").map(|node| &node.kind), Some(&Kind::BadNumber));
}

fn example_rule() -> Rule {
    Rule::from_schema(&json!({
        "type": "object", "additionalProperties": false, "required": ["n"],
        "properties": {
            "n": { "description": "A share.", "type": "number", "minimum": 0, "maximum": 1 },
            "k": { "type": ["integer", "null"], "format": "uint8", "minimum": 2 },
            "t": { "type": "string", "minLength": 1, "maxLength": 3, "pattern": "^[a-z0-9-]+$" },
            "f": { "type": "boolean" },
            "w": { "oneOf": [{ "const": "x", "type": "string" }, { "const": "y", "type": "string" }] },
            "l": { "type": "array", "minItems": 1, "maxItems": 2, "items": { "type": "number" } },
            "e": { "anyOf": [{ "const": "now", "type": "string" }, { "type": "number", "minimum": 0 }] },
            "u": { "oneOf": [
                { "type": "object", "additionalProperties": false, "required": ["is"],
                  "properties": { "is": { "const": "a", "type": "string" } } },
                { "type": "object", "additionalProperties": false, "required": ["is", "v"],
                  "properties": { "is": { "const": "b", "type": "string" }, "v": { "type": "number" } } }
            ] }
        }
    }))
    .expect("a schema of the known keywords")
}

#[test]
fn every_kind_of_rule_passes_and_refuses() {
    let rule = example_rule();
    let problems = |text: &str| -> Vec<(String, String)> {
        let parsed = parse(text, SIZE).expect(text);
        rule.check(&parsed.root).into_iter().map(|p| (p.refused.field, p.refused.why)).collect()
    };
    for good in [
        r#"{"n": 0}"#,
        r#"{"n": 1.0, "k": 2}"#,
        r#"{"n": 0.5, "k": null}"#,
        r#"{"n": 0, "k": 255.0}"#,
        r#"{"n": 0, "t": "a-1"}"#,
        r#"{"n": 0, "f": false}"#,
        r#"{"n": 0, "w": "y"}"#,
        r#"{"n": 0, "l": [1, 2]}"#,
        r#"{"n": 0, "e": "now"}"#,
        r#"{"n": 0, "e": 3}"#,
        r#"{"n": 0, "u": {"is": "b", "v": 1}}"#,
    ] {
        assert_eq!(problems(good), [], "{good}");
    }
    for (bad, field, why) in [
        (r#"{}"#, "n", "missing: A share"),
        (r#"{"n": -0.1}"#, "n", "out of range: A share"),
        (r#"{"n": 1.1}"#, "n", "out of range: A share"),
        (r#"{"n": null}"#, "n", "wrong type: A share"),
        (r#"{"n": "0"}"#, "n", "wrong type: A share"),
        (r#"{"n": 0, "k": 1}"#, "k", "out of range"),
        (r#"{"n": 0, "k": 256}"#, "k", "out of range"),
        (r#"{"n": 0, "k": 2.5}"#, "k", "wrong type"),
        (r#"{"n": 0, "t": ""}"#, "t", "not allowed"),
        (r#"{"n": 0, "t": "abcd"}"#, "t", "not allowed"),
        (r#"{"n": 0, "t": "../"}"#, "t", "not allowed"),
        (r#"{"n": 0, "f": 1}"#, "f", "wrong type"),
        (r#"{"n": 0, "w": "z"}"#, "w", "unknown word"),
        (r#"{"n": 0, "l": []}"#, "l", "wrong number of elements"),
        (r#"{"n": 0, "l": [1, 2, 3]}"#, "l", "wrong number of elements"),
        (r#"{"n": 0, "l": [1, true]}"#, "l[1]", "wrong type"),
        (r#"{"n": 0, "e": "then"}"#, "e", "unknown word"),
        (r#"{"n": 0, "e": -1}"#, "e", "out of range"),
        (r#"{"n": 0, "e": []}"#, "e", "wrong type"),
        (r#"{"n": 0, "u": {"is": "c"}}"#, "u.is", "unknown word"),
        (r#"{"n": 0, "u": {}}"#, "u.is", "missing"),
        (r#"{"n": 0, "u": {"is": "b"}}"#, "u.v", "missing"),
        (r#"{"n": 0, "u": {"is": "a", "v": 1}}"#, "u.v", "unknown field"),
        (r#"{"n": 0, "x": 1}"#, "x", "unknown field"),
        (r#"[]"#, "", "wrong type"),
    ] {
        assert_eq!(problems(bad), [(field.to_owned(), why.to_owned())], "{bad}");
    }
    assert_eq!(problems(r#"{"n": 2, "k": 0, "x": 1}"#).len(), 3, "all at once");
}

#[test]
fn a_schema_beyond_the_check_is_an_error() {
    for schema in [
        json!({ "type": "number", "exclusiveMinimum": 0 }),
        json!({ "type": "object", "properties": {} }),
        json!({ "type": "string", "pattern": ".*" }),
        json!({ "$ref": "#/$defs/Nowhere" }),
        json!({ "$defs": { "A": { "$ref": "#/$defs/A" } }, "$ref": "#/$defs/A" }),
        json!({ "type": "array" }),
        json!(true),
    ] {
        assert!(Rule::from_schema(&schema).is_err(), "{schema}");
    }
}
