//! The report in a terminal: one table for each case, values on a Pareto front marked with a star.

use super::pivot::{Row, Table, tables};
use super::result::{CaseResult, TimeSpread};
use super::units;

/// The results as tables of plain text.
pub fn table(results: &[CaseResult]) -> String {
    let mut text = String::new();
    for table in tables(results) {
        text += &format!("\n{}: {}\n", table.subject, table.case);
        text += &aligned(&cells(&table));
        for row in table.rows.iter().filter(|row| !row.notes.is_empty()) {
            text += &format!("  ({} {}: {})\n", row.method, row.settings(), row.notes.join("; "));
        }
    }
    if !text.is_empty() {
        text += "\n* on the Pareto front of error and time: nothing measured here is both better and faster\n";
    }
    text
}

/// Median with the spread around it and the number of runs.
pub fn spread(time_s: TimeSpread) -> String {
    let TimeSpread { median, min, max, runs } = time_s;
    format!("{} ({} to {}, {runs} runs)", units::time(median), units::time(min), units::time(max))
}

fn cells(table: &Table) -> Vec<Vec<String>> {
    let mut head = vec!["method".to_owned(), "settings".to_owned()];
    head.extend(table.columns.iter().map(|(metric, reference)| format!("{metric} vs {reference}")));
    head.extend(["time (spread)".to_owned(), "memory".to_owned()]);
    let mut lines = vec![head];
    lines.extend(table.rows.iter().map(|row| {
        let mut line = vec![row.method.to_owned(), row.settings()];
        line.extend((0..table.columns.len()).map(|column| error(row, column)));
        line.push(row.time_s.map_or_else(|| "-".to_owned(), spread));
        line.push(row.memory_bytes.map_or_else(|| "-".to_owned(), units::bytes));
        line
    }));
    lines
}

/// An error as it stands in a table, with the star of the front.
fn error(row: &Row, column: usize) -> String {
    let star = if row.front[column] { "*" } else { " " };
    match row.errors[column] {
        Some(error) => format!("{}{star}", error.value.map_or_else(|| "none".to_owned(), units::number)),
        None => "- ".to_owned(),
    }
}

/// Columns under each other, the first two to the left and the others to the right.
fn aligned(lines: &[Vec<String>]) -> String {
    let columns = lines.first().map_or(0, Vec::len);
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let mut shown = String::from(" ");
        for (column, (cell, width)) in line.iter().zip(&widths).enumerate() {
            let pad = " ".repeat(width - cell.chars().count());
            shown += &if column < 2 { format!(" {cell}{pad} ") } else { format!(" {pad}{cell} ") };
        }
        text += shown.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::result::Case;
    use super::*;

    #[test]
    fn columns_stand_under_each_other_and_the_front_has_stars() {
        let time = |s: f64| TimeSpread { median: s, min: s, max: 2.0 * s, runs: 3 };
        let mut results = Vec::new();
        for (method, error, seconds) in [("fast", 0.5, 0.001), ("exact", 0.0, 0.1), ("bad", 0.6, 0.2)] {
            results.extend(Case::new("c", method).time(time(seconds)).error("mse", "fine", error).results("deck"));
        }
        results.extend(Case::new("c", "broken").note("it is").error("mse", "fine", f64::INFINITY).results("deck"));
        let text = table(&results);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "deck: c");
        assert_eq!(
            lines[3].trim_end(),
            "  fast                   0.500*  1.00 ms (1.00 ms to 2.00 ms, 3 runs)       -"
        );
        assert!(lines[4].contains(" 0* ") && lines[5].contains("0.600 "), "{text}");
        assert!(
            lines[6].contains("none") && text.contains("(broken : it is; mse against fine is not finite)"),
            "{text}"
        );
        let column = |line: &str| line.find("runs)").expect("a time");
        assert_eq!(column(lines[3]), column(lines[5]));
        assert_eq!(table(&[]), "");
    }
}
