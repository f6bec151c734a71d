//! Report of an executed mission: plan and execution in comparison, a map of a schedule, expectations, and all events.
//! A single page that loads no other files.

use std::fmt::Write;

use mission::chart::Chart;
use mission::kind::{Cell, ReportPart};
use runtime::expect::Verdict;
use runtime::missions::{End, MissionRun};

use crate::gantt::{self, Look, Standing};
use crate::xml::escaped;

/// Renders the page.
pub fn mission(spec: &str, run: &MissionRun) -> String {
    let summary = &run.summary;
    let title = escaped(&format!("{}: {}", summary.mission, summary.scenario));
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"generator\" content=\"hierarq\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
         <title>{title}</title>\n<style>\n{STYLE}{}</style>\n</head>\n\
         <body>\n<h1>{title}</h1>\n<p class=\"quiet\">{}, seed {}, {}</p>\n",
        gantt::STYLE,
        escaped(spec),
        summary.seed,
        escaped(&end(&summary.end)),
    );
    // Writing to a `String` cannot fail.
    let _ = body(run, &mut out);
    out.push_str("</body></html>\n");
    out
}

static STYLE: &str = include_str!("assets/mission.css");

/// A cell of a table for people.
fn words(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Count(count) => count.to_string(),
        Cell::Number(x, "") => format!("{x:.3}"),
        Cell::Number(x, unit) => format!("{x:.3} {unit}"),
    }
}

fn end(end: &End) -> String {
    match end {
        End::Done { at_s } => format!("done after {at_s:.1} s"),
        End::Unfinished => "not done".to_string(),
        End::Stranded { why } => format!("there is no plan any more: {why}"),
        End::Refused { why } => format!("there is no plan: {why}"),
        End::Interrupted => "interrupted".to_string(),
    }
}

fn body(run: &MissionRun, out: &mut String) -> std::fmt::Result {
    let summary = &run.summary;
    for (at, text) in summary.trouble() {
        let at = at.map(|t| format!(" at {t:.1} s")).unwrap_or_default();
        writeln!(out, "<p class=\"bad\">Failed{at}: {}</p>", escaped(&text))?;
    }
    if !summary.expectations.is_empty() {
        writeln!(out, "<h2>Expected</h2>\n<table><tr><th>expectation<th>verdict<th>at")?;
        for e in &summary.expectations {
            let (class, verdict) = match e.verdict {
                Verdict::Holds => ("", "holds"),
                Verdict::Fails => (" class=\"bad\"", "fails"),
                Verdict::Undecided => (" class=\"bad\"", "undecided"),
            };
            let at = e.worst_s.map_or_else(|| "-".to_string(), |t| format!("{t:.1} s"));
            writeln!(out, "<tr><td>{}<td{class}>{verdict}<td>{at}", escaped(e.title()))?;
        }
        writeln!(out, "</table>")?;
    }
    if !summary.allowed.is_empty() {
        writeln!(out, "<p class=\"quiet\">{}</p>", escaped(super::allowed(&summary.allowed).trim()))?;
    }
    let until = run.planned.iter().chain(&run.executed).filter_map(Chart::end).reduce(f64::max);
    for (name, chart) in [("Planned", &run.planned), ("Executed", &run.executed)] {
        if let Some(chart) = chart {
            let look = Look { until, styled: false, ..Look::default() };
            writeln!(out, "<h2>{name}</h2>\n<div class=\"rolls\">\n{}</div>", gantt::picture(chart, &look))?;
        }
    }
    if let Some(map) = &run.map {
        let map = gantt::map(map, &Standing::default());
        writeln!(out, "<h2>Places and ways</h2>\n<div class=\"rolls\">\n{map}</div>")?;
    }
    if !run.maps.is_empty() {
        writeln!(out, "<h2>Map over time</h2>\n<div class=\"maps\">")?;
        for of in &run.maps {
            let map = gantt::map(&of.map, &Standing { moving: of.positions.clone(), ..Standing::default() });
            writeln!(
                out,
                "<figure><figcaption>at {:.1} s</figcaption>\n<div class=\"rolls\">\n{map}</div></figure>",
                of.time
            )?;
        }
        writeln!(out, "</div>")?;
    }
    for part in &run.parts {
        match part {
            ReportPart::Chart { title, chart } => {
                let picture = gantt::picture(chart, &Look { until, styled: false, ..Look::default() });
                writeln!(out, "<h2>{}</h2>\n<div class=\"rolls\">\n{picture}</div>", escaped(title))?;
            }
            ReportPart::Table { title, table } => {
                writeln!(out, "<h2>{}</h2>\n<div class=\"rolls\"><table>", escaped(title))?;
                let heads = table.columns.iter().map(|head| format!("<th>{}", escaped(head)));
                writeln!(out, "<tr>{}", heads.collect::<String>())?;
                for row in &table.rows {
                    let cells = row.iter().map(|cell| format!("<td>{}", escaped(&words(cell))));
                    writeln!(out, "<tr>{}", cells.collect::<String>())?;
                }
                writeln!(out, "</table></div>")?;
            }
        }
    }
    if !summary.workers.is_empty() {
        let driven = summary.workers.iter().all(|w| w.drive.is_some());
        let (who, took) = if driven { ("robot", "drives") } else { ("worker", "operations took") };
        writeln!(out, "<h2>Controllers of {who}s</h2>\n<table><tr><th>{who}<th>runs<th>{took}<th>broke down")?;
        for w in &summary.workers {
            let took: Vec<String> = w.operations_s.iter().map(|s| format!("{s:.1} s")).collect();
            let took = if w.drive.is_some() { w.describe() } else { took.join(", ") };
            let broke = w.broke_down.as_ref().map(|b| format!("at {:.1} s: {}", b.at_s, b.why));
            let class = if broke.is_some() { " class=\"bad\"" } else { "" };
            let broke = broke.unwrap_or_else(|| "-".to_string());
            let name = run.labels.member(&w.name);
            let cells = [name, &w.spec, &took].map(escaped);
            writeln!(out, "<tr><td>{}<td>{}<td>{}<td{class}>{}", cells[0], cells[1], cells[2], escaped(&broke))?;
        }
        writeln!(out, "</table>")?;
    }
    writeln!(out, "<h2>What happened</h2>\n<table>")?;
    for h in &summary.log {
        writeln!(out, "<tr><td class=\"at\">{:.1} s<td>{}", h.at_s, escaped(&h.what))?;
    }
    writeln!(out, "</table>")
}
