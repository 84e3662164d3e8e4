//! Results as tables: one table for each case, a row for each method with its settings, a column for each metric.

use super::pareto;
use super::result::{CaseResult, ErrorValue, TimeSpread};
use super::units;
use serde_json::Value;
use std::collections::BTreeMap;

/// The results of one case.
pub struct Table<'a> {
    /// Subject.
    pub subject: &'a str,
    /// Case.
    pub case: &'a str,
    /// Metric and reference of each column of errors.
    pub columns: Vec<(&'a str, &'a str)>,
    /// Methods with their settings, in the order in which they were recorded.
    pub rows: Vec<Row<'a>>,
}

/// One method with its settings.
pub struct Row<'a> {
    /// Method.
    pub method: &'a str,
    /// Its settings.
    pub params: &'a BTreeMap<String, Value>,
    /// Run time.
    pub time_s: Option<TimeSpread>,
    /// Memory.
    pub memory_bytes: Option<u64>,
    /// Notes.
    pub notes: &'a [String],
    /// What was measured, by column.
    pub errors: Vec<Option<&'a ErrorValue>>,
    /// Whether the row is on the Pareto front of error and time, by column.
    pub front: Vec<bool>,
}

impl Row<'_> {
    /// The settings in one line.
    pub fn settings(&self) -> String {
        let shown = |value: &Value| match value {
            Value::String(text) => text.clone(),
            Value::Number(n) if n.is_f64() => n.as_f64().map_or_else(|| n.to_string(), units::number),
            other => other.to_string(),
        };
        let each: Vec<String> = self.params.iter().map(|(name, value)| format!("{name}={}", shown(value))).collect();
        each.join(" ")
    }
}

/// Results as tables, in the order in which their cases were first recorded.
pub fn tables(results: &[CaseResult]) -> Vec<Table<'_>> {
    let mut tables: Vec<Table> = Vec::new();
    for result in results {
        let at = tables.iter().position(|t| t.subject == result.subject && t.case == result.case);
        let at = at.unwrap_or_else(|| {
            let (subject, case) = (result.subject.as_str(), result.case.as_str());
            tables.push(Table { subject, case, columns: Vec::new(), rows: Vec::new() });
            tables.len() - 1
        });
        place(&mut tables[at], result);
    }
    for table in &mut tables {
        for column in 0..table.columns.len() {
            let value = |row: &Row| row.errors.get(column).copied().flatten().and_then(|e| e.value);
            let points: Vec<_> = table.rows.iter().map(|row| (value(row), row.time_s.map(|t| t.median))).collect();
            for (row, on_front) in table.rows.iter_mut().zip(pareto::front(&points)) {
                row.front.push(on_front);
            }
        }
        let columns = table.columns.len();
        table.rows.iter_mut().for_each(|row| row.errors.resize(columns, None));
    }
    tables
}

/// Puts a result into the row of its method and settings, and the column of its metric and reference.
fn place<'a>(table: &mut Table<'a>, result: &'a CaseResult) {
    let name = (result.error.metric.as_str(), result.error.reference.as_str());
    let column = table.columns.iter().position(|c| *c == name).unwrap_or_else(|| {
        table.columns.push(name);
        table.columns.len() - 1
    });
    // A method that was measured twice with the same settings gets a second row.
    let free = |row: &Row| row.errors.get(column).is_none_or(Option::is_none) && row.time_s == result.time_s;
    let same = |row: &Row| row.method == result.method && *row.params == result.params && free(row);
    let row = table.rows.iter().position(same).unwrap_or_else(|| {
        table.rows.push(Row {
            method: &result.method,
            params: &result.params,
            time_s: result.time_s,
            memory_bytes: result.memory_bytes,
            notes: &result.notes,
            errors: Vec::new(),
            front: Vec::new(),
        });
        table.rows.len() - 1
    });
    let errors = &mut table.rows[row].errors;
    errors.resize(errors.len().max(column + 1), None);
    errors[column] = Some(&result.error);
}

#[cfg(test)]
mod tests {
    use super::super::result::Case;
    use super::*;

    #[test]
    fn two_references_are_two_columns_of_one_row() {
        let time = |s: f64| TimeSpread { median: s, min: s, max: s, runs: 1 };
        let mut results = Vec::new();
        for (slices, error, other, seconds) in [(8, 0.5, 0.6, 1.0), (32, 0.1, 0.7, 2.0)] {
            let case = Case::new("under", "slices").param("n", slices).time(time(seconds));
            results.extend(case.error("mse", "fine", error).error("mse", "monte carlo", other).results("deck"));
        }
        results.extend(Case::new("above", "slices").error("mse", "fine", 1.0).results("deck"));
        let tables = tables(&results);
        assert_eq!(tables.iter().map(|t| t.case).collect::<Vec<_>>(), ["under", "above"]);
        assert_eq!(tables[0].columns, [("mse", "fine"), ("mse", "monte carlo")]);
        assert_eq!(tables[0].rows.len(), 2);
        assert_eq!(tables[0].rows[0].settings(), "n=8");
        assert_eq!(tables[0].rows[0].front, [true, true]);
        assert_eq!(tables[0].rows[1].front, [true, false], "slower and worse against the second reference");
        assert_eq!(tables[1].rows[0].front, [false], "without a time it is on no front");
    }

    #[test]
    fn what_was_measured_twice_stands_twice() {
        let case = || Case::new("c", "m").error("mse", "fine", 1.0).results("s");
        let results = [case(), case()].concat();
        assert_eq!(tables(&results)[0].rows.len(), 2);
    }
}
