//! Error over time as inline SVG: a point for each row, a line along the Pareto front, bars for the spread of time.

use super::super::pivot::{Row, Table};
use super::super::result::TimeSpread;
use super::super::units;
use super::axis::Axis;
use super::escape;
use std::fmt::Write;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 340.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;
/// Height of the strip below the axis where errors of exactly 0 lie.
const ZERO: f64 = 24.0;
/// Colours of `style.css`; with more methods they come again with another shape.
const COLOURS: usize = 8;

/// A row that has a place in the plot.
struct Point<'a> {
    number: usize,
    row: &'a Row<'a>,
    series: usize,
    error: f64,
    time_s: TimeSpread,
    front: bool,
}

/// The methods of a table, in the order in which they get their colours.
pub fn methods<'a>(table: &Table<'a>) -> Vec<&'a str> {
    let mut methods: Vec<&str> = Vec::new();
    for row in &table.rows {
        if !methods.contains(&row.method) {
            methods.push(row.method);
        }
    }
    methods
}

/// The mark of a method in a line of text.
pub fn swatch(series: usize) -> String {
    format!("<svg class=\"swatch\" viewBox=\"-7 -7 14 14\">{}</svg>", mark(series, 0.0, 0.0))
}

/// The plot of one column of errors with its caption; `None` when no row has both an error over 0 and a time.
pub fn plot(table: &Table, column: usize) -> Option<String> {
    let methods = methods(table);
    let points: Vec<Point> = table
        .rows
        .iter()
        .enumerate()
        .filter_map(|(at, row)| {
            let error = row.errors[column]?.value?.max(0.0);
            let series = methods.iter().position(|m| *m == row.method)?;
            let time_s = row.time_s.filter(|t| t.median > 0.0)?;
            Some(Point { number: at + 1, row, series, error, time_s, front: row.front[column] })
        })
        .collect();
    let times = Axis::over(points.iter().flat_map(|p| [p.time_s.min, p.time_s.median, p.time_s.max]))?;
    let errors = Axis::over(points.iter().map(|p| p.error))?;
    let frame = Frame { times, errors, zero: points.iter().any(|p| p.error == 0.0) };
    let (metric, reference) = table.columns[column];
    let mut legend = String::new();
    for (series, method) in methods.iter().enumerate().filter(|(s, _)| points.iter().any(|p| p.series == *s)) {
        let _ = write!(legend, "<span>{}{}</span> ", swatch(series), escape(method));
    }
    Some(format!(
        "<figure class=\"plot\"><figcaption><b>{}</b> against {}</figcaption>\n\
         <svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{} over time\">\n{}{}{}</svg>\n\
         <div class=\"legend\">{legend}</div></figure>\n",
        escape(metric),
        escape(reference),
        escape(metric),
        grid(&frame, metric),
        front(&frame, &points),
        points.iter().map(|p| point(&frame, p)).collect::<String>()
    ))
}

/// Where values lie in the picture.
struct Frame {
    times: Axis,
    errors: Axis,
    zero: bool,
}

impl Frame {
    fn x(&self, time_s: f64) -> f64 {
        LEFT + self.times.place(time_s).clamp(0.0, 1.0) * (WIDTH - LEFT - RIGHT)
    }

    /// Lowest place of positive errors.
    fn floor(&self) -> f64 {
        HEIGHT - BOTTOM - if self.zero { ZERO } else { 0.0 }
    }

    fn y(&self, error: f64) -> f64 {
        if error > 0.0 {
            self.floor() - self.errors.place(error) * (self.floor() - TOP)
        } else {
            HEIGHT - BOTTOM - 0.5 * ZERO
        }
    }
}

fn grid(frame: &Frame, metric: &str) -> String {
    let mut svg = String::new();
    let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
    for tick in frame.times.ticks() {
        let x = frame.x(tick);
        let _ = write!(svg, "<path class=\"grid\" d=\"M{x:.1} {TOP}V{bottom}\"/>");
        let _ = write!(svg, "<text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">", bottom + 16.0);
        let _ = writeln!(svg, "{}</text>", short(&units::time(tick)));
    }
    let errors = frame.errors.ticks().into_iter().map(|tick| (frame.y(tick), short(&units::number(tick))));
    let zero = frame.zero.then(|| (frame.y(0.0), "0".to_owned()));
    for (y, label) in errors.chain(zero) {
        let _ = write!(svg, "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{right}\"/>");
        let _ = write!(svg, "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">", LEFT - 8.0, y + 4.0);
        let _ = writeln!(svg, "{label}</text>");
    }
    let _ = writeln!(
        svg,
        "<path class=\"frame\" d=\"M{LEFT} {TOP}V{bottom}H{right}\"/>\n\
         <text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">time</text>\n\
         <text class=\"axis\" transform=\"translate(14 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        0.5 * (LEFT + right),
        HEIGHT - 8.0,
        0.5 * (TOP + bottom),
        escape(metric)
    );
    svg
}

/// A label without digits that say nothing: `1.00 ms` is `1 ms`.
fn short(label: &str) -> String {
    let end = label.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(label.len());
    let (digits, rest) = label.split_at(end);
    if digits.contains('.') {
        format!("{}{rest}", digits.trim_end_matches('0').trim_end_matches('.'))
    } else {
        label.to_owned()
    }
}

/// The front as a staircase: from one of its points to the next nothing better is known.
fn front(frame: &Frame, points: &[Point]) -> String {
    let mut on: Vec<(f64, f64)> =
        points.iter().filter(|p| p.front).map(|p| (frame.x(p.time_s.median), frame.y(p.error))).collect();
    on.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let Some((x, _)) = on.first() else { return String::new() };
    let mut path = format!("M{x:.1} {TOP}");
    for (x, y) in on {
        let _ = write!(path, "H{x:.1}V{y:.1}");
    }
    format!("<path class=\"line\" d=\"{path}H{:.1}\"/>\n", WIDTH - RIGHT)
}

fn point(frame: &Frame, point: &Point) -> String {
    let Point { number, row, series, error, time_s, front } = point;
    let (x, y) = (frame.x(time_s.median), frame.y(*error));
    let class = if *front { "point on" } else { "point" };
    let title = format!(
        "{number}: {} {}\nerror {}\ntime {}",
        row.method,
        row.settings(),
        units::number(*error),
        super::spread(*time_s)
    );
    let mut svg = format!("<g class=\"{class}\"><title>{}</title>", escape(&title));
    let _ = write!(
        svg,
        "<path class=\"bar c{}\" d=\"M{:.1} {y:.1}H{:.1}\"/>{}",
        series % COLOURS,
        frame.x(time_s.min),
        frame.x(time_s.max),
        mark(*series, x, y)
    );
    if *front {
        let _ = write!(svg, "<text class=\"number\" x=\"{:.1}\" y=\"{:.1}\">{number}</text>", x + 7.0, y - 6.0);
    }
    svg + "</g>\n"
}

/// The mark of a series: its colour, and a shape for each round of colours.
fn mark(series: usize, x: f64, y: f64) -> String {
    let class = format!("class=\"mark c{}\"", series % COLOURS);
    match series / COLOURS % 3 {
        0 => format!("<circle {class} cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"/>"),
        1 => format!("<rect {class} x=\"{:.1}\" y=\"{:.1}\" width=\"8\" height=\"8\"/>", x - 4.0, y - 4.0),
        _ => format!("<path {class} d=\"M{x:.1} {:.1}l5.5 9.5h-11z\"/>", y - 6.0),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::pivot::tables;
    use super::super::super::result::Case;
    use super::*;

    #[test]
    fn points_lie_where_their_numbers_say() {
        let mut results = Vec::new();
        for (n, error, seconds) in [(1, 1.0, 1e-3), (2, 1e-2, 1.0), (3, 0.0, 10.0)] {
            let time_s = TimeSpread { median: seconds, min: seconds, max: seconds, runs: 1 };
            results.extend(Case::new("c", "m").param("n", n).time(time_s).error("mse", "r", error).results("s"));
        }
        let tables = tables(&results);
        let svg = plot(&tables[0], 0).expect("points");
        let place = |nth: usize| {
            let circle = svg.split("<circle").nth(nth).expect("a circle");
            let value = |name: &str| -> f64 {
                let rest = circle.split(name).nth(1).expect(name);
                rest.split('"').next().and_then(|v| v.parse().ok()).expect("a number")
            };
            (value("cx=\""), value("cy=\""))
        };
        let (a, b, c) = (place(1), place(2), place(3));
        assert!(a.0 < b.0 && b.0 < c.0, "later is to the right");
        assert!(a.1 < b.1 && b.1 < c.1, "smaller errors lie lower, 0 lowest");
        // Four decades of time between the first and the last: the second lies at three quarters (0.1 px of rounding).
        assert!(((b.0 - a.0) / (c.0 - a.0) - 0.75).abs() < 1e-3);
        assert!(svg.contains(">0</text>"));
    }

    #[test]
    fn without_times_or_errors_there_is_no_plot() {
        let results = Case::new("c", "m").error("mse", "r", 1.0).results("s");
        assert!(plot(&tables(&results)[0], 0).is_none());
        let time_s = TimeSpread { median: 1.0, min: 1.0, max: 1.0, runs: 1 };
        let results = Case::new("c", "m").time(time_s).error("mse", "r", 0.0).results("s");
        assert!(plot(&tables(&results)[0], 0).is_none());
    }

    #[test]
    fn short_labels() {
        assert_eq!(
            ["1.00 ms", "0.500", "100 s", "2.50e-4"].map(short),
            ["1 ms", "0.5", "100 s", "2.5e-4"].map(str::to_owned)
        );
    }
}
