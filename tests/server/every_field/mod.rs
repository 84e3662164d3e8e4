//! Every field of every message counts: changing it alone changes the picture or an answer that the client gets.
//!
//! The list of fields comes from the published schema, so that a new field without a case fails here. What went wrong
//! once: a table compared snapshots, and would have passed had the plan ignored a field.

mod answers;
mod fields;
mod pictures;

use std::collections::BTreeSet;

/// Fields whose effect takes a client that reads slowly or a clock that runs; the tests that show it.
const ELSEWHERE: [(&str, fn()); 2] = [
    ("subscribe.max_rate_hz", crate::frames::each_client_gets_its_own_rate),
    ("subscribe.when_slow", crate::frames::a_client_that_asked_for_it_is_disconnected_when_slow),
];

#[test]
fn every_published_field_has_a_case() {
    let published = fields::published();
    // The walk finds fields at every depth.
    for field in ["hello.token", "view.create.size_px", "strike.strokes[].delay_s", "weather.region.name"] {
        assert!(published.contains(field), "{field} in {published:#?}");
    }
    let mut covered: BTreeSet<String> = ELSEWHERE.iter().map(|(field, _)| (*field).to_owned()).collect();
    covered.extend(pictures::cases().into_iter().map(|case| case.field.to_owned()));
    covered.extend(answers::cases().into_iter().map(|case| case.field.to_owned()));
    covered.extend(answers::numbered().into_iter().map(|(message, _)| format!("{message}.seq")));
    let missing: Vec<_> = published.difference(&covered).collect();
    assert!(missing.is_empty(), "fields without a case: {missing:#?}");
    let unknown: Vec<_> = covered.difference(&published).collect();
    assert!(unknown.is_empty(), "cases for fields that are not published: {unknown:#?}");
}

#[test]
fn every_message_is_asked_for_its_number() {
    let published = fields::published();
    let asked: BTreeSet<&str> = answers::numbered().into_iter().map(|(message, _)| message).collect();
    assert_eq!(fields::messages(&published), asked);
}
