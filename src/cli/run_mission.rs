//! `hierarq run SPEC --scenario NAME` for a scenario that executes a mission.

use std::fmt::Write;
use std::io::{BufWriter, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use comfy_table::CellAlignment;
use files::Results;
use hierarq::{gantt, outputs, report};
use mission::kind::Cell;
use runtime::missions::csv::MissionCsv;
use runtime::missions::{End, MissionRun};
use runtime::program::{MAX_INSTANTS, MAX_MISSION, MAX_TICKS, MissionProgram, MissionScenarioProgram};
use runtime::quantity::quantity;
use runtime::text::number;

use super::run::{Arguments, LogFormat};
use super::{Outcome, interruption, output, table};

/// Maximum number of events in the output.
const SHOWN: usize = 40;

pub fn run(
    a: &Arguments,
    mission: &MissionProgram,
    scenario: &MissionScenarioProgram,
    sources: &[PathBuf],
) -> Result<Outcome, String> {
    if a.solver.is_some() || a.verify || a.problems.is_some() || a.log != LogFormat::Csv {
        let text = "`--solver`, `--verify`, `--problems` and `--log mcap` need a robot's controller, and this scenario \
                    executes a mission";
        return Err(text.to_string());
    }
    let mut scenario = scenario.clone();
    scenario.seed = a.seed.unwrap_or(scenario.seed);
    if let Some(d) = a.duration {
        let most = MAX_MISSION.min(scenario.step * f64::from(MAX_INSTANTS));
        if d.is_nan() || d <= 0.0 || d > most {
            let text =
                format!("--duration {d} s: the duration of a mission must be more than 0 s and at most {most} s");
            return Err(text);
        }
        scenario.last(d);
        let late = scenario.happens.iter().filter(|h| h.at > d).count();
        if late > 0 {
            let what = if late == 1 { "1 event is" } else { &format!("{late} events are") };
            output::eprint(&format!("note: {what} after the end of the run at {} s and will not occur\n", number(d)));
        }
    }
    let ticks = if scenario.sampled { mission.running.ticks(scenario.duration) } else { 0.0 };
    if ticks > MAX_TICKS {
        let d = scenario.duration;
        return Err(format!(
            "--duration {d} s: the controllers of working robots need more than {MAX_TICKS} ticks in total"
        ));
    }
    let name = a.spec.file_stem().map_or_else(|| PathBuf::from("spec"), PathBuf::from);
    let folder = a.out.clone().unwrap_or_else(|| Path::new("out").join(name));
    execute(a, mission, &scenario, &folder, sources).map(Outcome::of)
}

/// Runs, writes the files and prints the results; returns true if all is well.
fn execute(
    a: &Arguments,
    mission: &MissionProgram,
    scenario: &MissionScenarioProgram,
    folder: &Path,
    sources: &[PathBuf],
) -> Result<bool, String> {
    let mut results = Results::begin(folder, &outputs::RESULTS, sources)?;
    let log = folder.join("log.csv");
    let failed = |e: std::io::Error| format!("cannot write {}: {e}", log.display());
    let mut rows = BufWriter::new(results.part("log.csv")?);
    let interrupted = interruption::flag();
    let mut go_on = |_| !interrupted.load(Ordering::Relaxed);
    let mut csv = MissionCsv::new(&mut rows);
    let run = runtime::missions::run(mission, scenario, &mut csv, &mut go_on);
    let run = csv.finish().map(|()| run);
    let run = run.map_err(failed)?.map_err(|e| e.to_string())?;
    let text = serde_json::to_string_pretty(&run.summary).map_err(|e| e.to_string())? + "\n";
    results.add("log.csv", rows.into_inner().map_err(|e| failed(e.into_error()))?);
    results.write("report.html", &report::mission(&a.spec.display().to_string(), &run))?;
    results.write("summary.json", &text)?;
    results.finish()?;
    if a.json {
        output::data(&text);
    } else {
        output::painted(&shown(&run, folder));
    }
    Ok(run.summary.ok)
}

/// Returns the results of a run for the terminal.
fn shown(run: &MissionRun, folder: &Path) -> String {
    let summary = &run.summary;
    let head = format!("\n{}, {}, seed {}\n", summary.mission, summary.scenario, summary.seed);
    let mut out = output::plain(&head);
    if let Some(plan) = &run.executed {
        let colour = std::io::stdout().is_terminal();
        let _ = write!(out, "\n{}", gantt::text(plan, output::width(), colour));
    }
    out.push('\n');
    let chart = out.len();
    let notable: Vec<_> = summary.log.iter().filter(|h| h.notable).collect();
    for entry in notable.iter().take(SHOWN) {
        let _ = writeln!(out, "{:>9.1} s  {}", entry.at_s, entry.what);
    }
    if notable.len() > SHOWN {
        let _ = writeln!(out, "and {} more, in summary.json", notable.len() - SHOWN);
    }
    out += &team(run);
    out += &table::expectations(&summary.expectations, summary.ok);
    for (at, text) in summary.trouble() {
        let at = at.map(|t| format!(" at {t:.1} s")).unwrap_or_default();
        let _ = writeln!(out, "FAILED{at}: {text}");
    }
    let end = match &summary.end {
        End::Done { at_s } => format!("done after {at_s:.1} s"),
        End::Unfinished => format!("not done after {} s", number(summary.duration_s)),
        End::Stranded { .. } => "stranded".to_string(),
        End::Refused { .. } => "not planned".to_string(),
        End::Interrupted => "INTERRUPTED before its end".to_string(),
    };
    let changes = summary.results.as_ref().map_or_else(String::new, |results| {
        format!("; reschedules {}, reallocations {}", results.reschedules, results.reallocations)
    });
    let files = ["report.html", "log.csv", "summary.json"].map(|n| folder.join(n).display().to_string());
    let _ = writeln!(out, "{end}{changes}\nwrote {}", files.join(", "));
    let below = output::plain(&out.split_off(chart));
    out + &below
}

/// Returns the results of the members, and of their controllers.
fn team(run: &MissionRun) -> String {
    let Some(results) = &run.summary.results else { return String::new() };
    let mut out = String::new();
    for of in &results.tables {
        let mut table = table::wide_table(&of.columns);
        for row in &of.rows {
            table.add_row(row.iter().map(|cell| match cell {
                Cell::Text(text) => text.clone(),
                Cell::Count(count) => count.to_string(),
                Cell::Number(x, unit) => quantity(*x, unit),
            }));
        }
        for i in 1..of.columns.len() {
            if let Some(c) = table.column_mut(i) {
                c.set_cell_alignment(CellAlignment::Right);
            }
        }
        let _ = writeln!(out, "{table}");
    }
    for w in &run.summary.workers {
        let _ = writeln!(out, "{} ran {}; {}", run.labels.member(&w.name), w.spec, w.describe());
    }
    out
}
