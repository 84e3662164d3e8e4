//! The report as one page that needs nothing else: plots, tables and pictures, on light and on dark screens.

mod axis;
mod plot;

use super::pivot::{Row, Table, tables};
use super::result::Report;
use super::subjects;
use super::table::spread;
use super::units;

const STYLE: &str = include_str!("style.css");

/// The page. No script, no font and no picture comes from elsewhere.
pub fn page(report: &Report) -> String {
    let tables = tables(&report.results);
    let mut names: Vec<&str> = tables.iter().map(|t| t.subject).collect();
    names.extend(report.figures.iter().map(|f| f.subject.as_str()));
    let mut seen: Vec<&str> = Vec::new();
    for name in names {
        if !seen.contains(&name) {
            seen.push(name);
        }
    }
    let links: String =
        seen.iter().map(|name| format!("<a href=\"#{0}\">{0}</a>", escape(name))).collect::<Vec<_>>().join(" ");
    let sections: String = seen.iter().map(|name| section(report, &tables, name)).collect();
    let facts = [
        ("machine", &report.machine),
        ("adapter", &report.adapter),
        ("version", &report.version),
        ("commit", &report.commit),
    ];
    let facts: String =
        facts.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>", escape(value))).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>stormdeck: error against run time</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n\
         <h1>Error against run time</h1>\n<dl>{facts}</dl>\n<nav>{links}</nav>\n\
         <p class=\"key\">Each point is one method with its settings. Down is more exact, left is faster. The line is the \
         Pareto front: nothing measured is both more exact and faster than its points. Bars show the shortest and the \
         longest run. Numbers are rows of the table below.</p>\n</header>\n{sections}</body>\n</html>\n"
    )
}

fn section(report: &Report, tables: &[Table], name: &str) -> String {
    let about = subjects().iter().find(|s| s.name == name).map_or("", |s| s.about);
    let cases: String = tables.iter().filter(|t| t.subject == name).map(case).collect();
    let figures: String = report
        .figures
        .iter()
        .filter(|f| f.subject == name)
        .map(|f| {
            format!(
                "<figure><img src=\"{}\" alt=\"{title}\"><figcaption><b>{title}</b> {}</figcaption></figure>\n",
                f.address(),
                escape(&f.caption),
                title = escape(&f.title)
            )
        })
        .collect();
    let figures = if figures.is_empty() { figures } else { format!("<div class=\"figures\">\n{figures}</div>\n") };
    format!("<section id=\"{0}\">\n<h2>{0}</h2>\n<p>{1}</p>\n{cases}{figures}</section>\n", escape(name), escape(about))
}

/// One case: a plot for each metric that has points, then the table.
fn case(table: &Table) -> String {
    let plots: String = (0..table.columns.len()).filter_map(|column| plot::plot(table, column)).collect();
    let plots = if plots.is_empty() { plots } else { format!("<div class=\"plots\">\n{plots}</div>\n") };
    let head: String = table
        .columns
        .iter()
        .map(|(metric, reference)| {
            format!("<th>{}<br><small>against {}</small></th>", escape(metric), escape(reference))
        })
        .collect();
    let methods = plot::methods(table);
    let rows: String = table.rows.iter().enumerate().map(|(at, row)| line(row, at, &methods)).collect();
    format!(
        "<h3>{}</h3>\n{plots}<div class=\"scroll\"><table>\n<thead><tr><th>#</th><th class=\"text\">method</th>\
         <th class=\"text\">settings</th>{head}<th>time (spread)</th><th>memory</th><th class=\"text\">notes</th></tr></thead>\n\
         <tbody>\n{rows}</tbody></table></div>\n",
        escape(table.case)
    )
}

fn line(row: &Row, at: usize, methods: &[&str]) -> String {
    let error = |(column, error): (usize, &Option<&super::ErrorValue>)| {
        let class = if row.front[column] { " class=\"front\"" } else { "" };
        let value = match error {
            Some(error) => error.value.map_or_else(|| "none".to_owned(), units::number),
            None => String::new(),
        };
        format!("<td{class}>{value}</td>")
    };
    let errors: String = row.errors.iter().enumerate().map(error).collect();
    let series = methods.iter().position(|m| *m == row.method).unwrap_or_default();
    format!(
        "<tr><td>{}</td><td class=\"text\">{}{}</td><td class=\"text\"><code>{}</code></td>{errors}<td>{}</td><td>{}</td>\
         <td class=\"text note\">{}</td></tr>\n",
        at + 1,
        plot::swatch(series),
        escape(row.method),
        escape(&row.settings()),
        row.time_s.map_or_else(String::new, spread),
        row.memory_bytes.map_or_else(String::new, units::bytes),
        escape(&row.notes.join("; "))
    )
}

/// Text as it may stand in an element or in a quoted attribute.
fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\'' => safe += "&#39;",
            _ => safe.push(letter),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::super::figure::Figure;
    use super::super::result::{Case, TimeSpread};
    use super::*;

    fn report() -> Report {
        let mut report = Report::new("<adapter> & \"driver\"".into());
        for (n, error, seconds) in [(8, 0.5, 0.01), (16, 0.0, 0.02), (32, 0.1, 0.5)] {
            let time_s = TimeSpread { median: seconds, min: 0.9 * seconds, max: 1.2 * seconds, runs: 3 };
            let case = Case::new("<b>under</b>", "a<script>").param("n", n).time(time_s).note("'quoted' & <i>");
            report.results.extend(case.error("mse", "fine", error).results("deck"));
        }
        report.figures.push(Figure::png("extreme", "a & b", vec![1, 2, 3]));
        report
    }

    #[test]
    fn nothing_measured_becomes_markup() {
        let page = page(&report());
        for text in ["<script", "<b>under", "<adapter>", "<i>", "& <", "& \""] {
            assert!(!page.contains(text), "{text}");
        }
        assert!(page.contains("a&lt;script&gt;") && page.contains("&lt;adapter&gt; &amp; &quot;driver&quot;"));
    }

    #[test]
    fn the_page_reaches_for_nothing_outside_and_is_well_formed() {
        let page = page(&report());
        for word in ["http", "//", "@import", "url("] {
            // Base64 may hold two slashes; here it does not.
            assert!(!page.contains(word), "{word}");
        }
        assert!(page.contains("src=\"data:image/png;base64,AQID\""));
        let mut open: Vec<&str> = Vec::new();
        for tag in page.split('<').skip(1) {
            let name = tag.split(['>', ' ', '\n']).next().unwrap_or_default();
            let alone = tag.split('>').next().is_some_and(|t| t.ends_with('/'));
            match name.strip_prefix('/') {
                Some(name) => assert_eq!(open.pop(), Some(name)),
                None if alone || ["!DOCTYPE", "meta", "img", "br"].contains(&name) => {}
                None => open.push(name),
            }
        }
        assert!(open.is_empty(), "{open:?}");
    }

    #[test]
    fn the_front_is_marked_in_table_and_plot() {
        let page = page(&report());
        assert_eq!(page.matches("<td class=\"front\">").count(), 2);
        assert_eq!(page.matches("class=\"line\"").count(), 1);
        assert_eq!(page.matches("<g class=\"point").count(), 3);
    }

    #[test]
    fn an_empty_report_is_a_page() {
        assert!(page(&Report::new("none".into())).contains("</html>"));
    }
}
