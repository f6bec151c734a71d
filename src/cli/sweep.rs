//! `hierarq sweep SPEC`

use std::fmt::Write;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::Args;
use hierarq::scenario_runner::MAX_SEED;
use hierarq::sweep::axis::{Axis, axis};
use hierarq::sweep::digest::{Figure, Spread, Worst};
use hierarq::sweep::journal;
use hierarq::sweep::plan::MAX_RUNS;
use hierarq::sweep::stored::{self, Execution};
use hierarq::sweep::{Digest, Head, Plan, Refusal, Request, Row, Shard, merge, row, table};
use indicatif::{ProgressBar, ProgressStyle};
use runtime::expect::Verdict;
use runtime::quantity::quantity;
use runtime::text::number;

use super::{Outcome, SpecOptions, output, table as tables};

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    #[arg(required_unless_present = "merge", conflicts_with = "merge")]
    spec: Option<PathBuf>,
    #[command(flatten)]
    options: SpecOptions,
    /// Scenario to run; may be omitted if the spec has only one.
    #[arg(long, value_name = "NAME", conflicts_with = "merge")]
    scenario: Option<String>,
    /// Vary a `param`: `x=A..B` draws a value between the two for each run, `x=A,B,C` takes each of these, `x=A..B:N` takes
    /// N in equal steps. Lists make a grid. May be repeated.
    #[arg(long, value_name = "NAME=VALUES", value_parser = varied, conflicts_with = "merge")]
    vary: Vec<Axis>,
    /// Number of runs at each point of the grid [default: 200, or 1 if all values are listed].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_RUNS), conflicts_with = "merge")]
    runs: Option<u64>,
    /// Seed of the first run; later runs use the following numbers [default: the scenario's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(0..=MAX_SEED), conflicts_with = "merge")]
    seed: Option<u64>,
    /// The Parquet file [default: out/NAME/sweep.parquet].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Number of runs in parallel [default: one for each processor]. The results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Continue an interrupted sweep.
    #[arg(long, conflicts_with = "merge")]
    resume: bool,
    /// Run only shard I of N, I from 1; `--merge` merges the shards.
    #[arg(long, value_name = "I/N", conflicts_with = "merge")]
    shard: Option<Shard>,
    /// Merge the files of all shards, without running anything.
    #[arg(long, value_name = "FILE", num_args = 1.., requires = "out")]
    merge: Vec<PathBuf>,
    /// Print the summary as JSON.
    #[arg(long)]
    json: bool,
}

fn varied(text: &str) -> Result<Axis, String> {
    let (name, values) = super::name_value(text)?;
    axis(&name, &values)
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    match &a.spec {
        Some(spec) => sweep(a, spec),
        None => merged(a),
    }
}

/// Merges shards.
fn merged(a: &Arguments) -> Result<Outcome, String> {
    if !a.options.set.is_empty() || !a.options.package_path.is_empty() || a.jobs.is_some() {
        return Err("`--merge` runs nothing: remove `--set`, `--package-path` and `--jobs`".to_string());
    }
    let out = a.out.clone().unwrap_or_default();
    let target = table::target(&out, &a.merge)?;
    let (head, rows) = merge::merge(&a.merge)?;
    stored::folder(&out)?;
    table::write(target, &head, &rows)?;
    Ok(show(a, &head, &rows, &out, None))
}

fn sweep(a: &Arguments, spec: &Path) -> Result<Outcome, String> {
    let request = Request {
        spec: spec.to_path_buf(),
        settings: a.options.settings(),
        scenario: a.scenario.clone(),
        vary: a.vary.clone(),
        runs: a.runs,
        seed: a.seed,
        shard: a.shard,
    };
    let plan = match Plan::new(&request) {
        Ok(plan) => plan,
        Err(Refusal::Spec(report)) => {
            return output::refuse(&report, a.spec.as_deref().unwrap_or(Path::new("")), a.json);
        }
        Err(Refusal::Usage(message)) => return Err(message),
    };
    output::show(&plan.report);
    let out = a.out.clone().unwrap_or_else(|| default(&plan.head));
    let jobs = a.jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let bar = progress();
    let interrupted = super::interruption::flag();
    let execution = Execution {
        jobs,
        resume: a.resume,
        go_on: &|| !interrupted.load(Ordering::Relaxed),
        progress: &mut |done, all| {
            let first = bar.length() != Some(all as u64);
            bar.set_length(all as u64);
            bar.set_position(done as u64);
            if first {
                // Runs of an earlier execution say nothing of the speed of this one.
                bar.reset_eta();
            }
        },
    };
    let stored = stored::run(&plan, &out, execution);
    bar.finish_and_clear();
    let stored = stored?;
    Ok(show(a, &stored.head, &stored.rows, &out, stored.speed))
}

/// Returns the default path of the output file.
fn default(head: &Head) -> PathBuf {
    let name = Path::new(&head.spec).file_stem().unwrap_or_default();
    let file = match head.shard {
        Some(shard) => format!("sweep.{}of{}.parquet", shard.index, shard.of),
        None => "sweep.parquet".to_string(),
    };
    Path::new("out").join(name).join(file)
}

fn progress() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(0);
    if let Ok(style) =
        ProgressStyle::with_template("  {bar:40.cyan/black} {percent:>3} %  {pos} of {len} runs, {eta} left")
    {
        bar.set_style(style);
    }
    bar
}

/// Prints the results of the runs. `speed` is the number of runs per second.
fn show(a: &Arguments, head: &Head, rows: &[Row], out: &Path, speed: Option<f64>) -> Outcome {
    let digest = Digest::new(head, rows);
    let shown = out.display().to_string();
    if a.json {
        output::data(&format!("{:#}\n", digest.json(&shown)));
    } else {
        output::print(&text(&digest, head, &shown, speed));
    }
    if digest.runs < digest.wanted {
        let journal = journal::path(out);
        output::error_line(&format!(
            "interrupted: {} of {} runs are stored in {}; the same command with `--resume` continues",
            digest.runs,
            digest.wanted,
            journal.display()
        ));
    }
    Outcome::of(digest.ok())
}

fn text(digest: &Digest, head: &Head, out: &str, speed: Option<f64>) -> String {
    let mut rows = tables::wide_table(&["expectation, limit", "holds in", "worst margin", "at", "in run"]);
    for (f, limit) in digest.expectations.iter().map(|f| (f, false)).chain(digest.limits.iter().map(|f| (f, true))) {
        let [margin, at, run] = f.worst.map_or_else(Default::default, |w| cells(&w, f));
        let title = if limit { format!("limit `{}`", f.title) } else { f.title.to_string() };
        rows.add_row([title, format!("{} of {}", f.hold, f.of), margin, at, run]);
    }
    let mut text = format!("\n{}: {}\n{rows}\n{}", head.scenario, head.command, measures(digest));
    let share = digest.share().map_or_else(String::new, |s| format!(" ({:.1} %)", 100.0 * s));
    let _ = writeln!(text, "{} of {} runs as expected{share}", digest.hold, digest.runs);
    if digest.refused > 0 {
        let _ = writeln!(text, "{} did not run, because the spec does not compile with their values", digest.refused);
    }
    if !digest.ends.is_empty() {
        let all: Vec<String> = digest.ends.iter().map(|(how, runs)| format!("{how} in {runs}")).collect();
        let _ = writeln!(text, "the mission was {} {}", all.join(", "), if digest.runs == 1 { "run" } else { "runs" });
    }
    if digest.is_unseeded() {
        let _ = writeln!(text, "no result depends on the seed: nothing in this scenario is random");
    }
    if digest.halted > 0 {
        let _ = writeln!(text, "in {} the robot was halted by a fault without a transition", digest.halted);
    }
    let mut shown: Vec<u64> = Vec::new();
    let telling = |w: &Worst| w.margin.is_some() || w.verdict != Some(Verdict::Holds);
    for f in &digest.expectations {
        let Some(w) = f.worst.filter(|w| telling(w) && !shown.contains(&w.row.run)) else { continue };
        shown.push(w.row.run);
        let _ = writeln!(text, "worst for `{}`:\n  {}", f.title, digest.replay(w.row));
    }
    // Failures without an expectation: faults, violated margins, values that give no program.
    let told = |row: &Row| row.expectations.iter().any(|e| e.verdict.is_some_and(|v| v != Verdict::Holds));
    for row in digest.failed.iter().filter(|row| !told(row)).take(3) {
        let trouble = || row.mission.as_ref().and_then(|mission| mission.trouble.clone());
        let why = match &row.refused {
            Some(codes) => format!("refused, {codes}"),
            None => trouble().unwrap_or_else(|| "failed".to_string()),
        };
        let _ = writeln!(text, "{why}, run {}:\n  {}", row.run, digest.replay(row));
    }
    if let Some(speed) = speed {
        let _ = writeln!(text, "{} runs a second", number((speed * 100.0).round() / 100.0));
    }
    if digest.runs == digest.wanted {
        let _ = writeln!(text, "{} rows in {out}", digest.runs);
    }
    text
}

/// Returns the table of the measures of a mission; empty for a controller. Those of members are in the file alone.
fn measures(digest: &Digest) -> String {
    let of_mission: Vec<&Spread> = digest.measures.iter().filter(|m| m.of.member.is_none() && m.runs > 0).collect();
    if of_mission.is_empty() {
        return String::new();
    }
    let mut rows = tables::wide_table(&[
        "at the end",
        "mean",
        "95 % of the mean",
        "deviation",
        "smallest",
        "in run",
        "largest",
        "in run",
    ]);
    for m in of_mission {
        let Some(unit) = m.of.unit.as_deref() else {
            let share = m.mean.map_or_else(String::new, |share| format!("true in {:.1} %", 100.0 * share));
            let [low, high] = m.interval.unwrap_or_default().map(|share| 100.0 * share);
            let interval = m.interval.map_or_else(String::new, |_| format!("{low:.1} to {high:.1} %"));
            rows.add_row([m.of.title.clone(), share, interval]);
            continue;
        };
        let shown = |x: f64| quantity(x, unit);
        let cell = |x: Option<f64>| x.map_or_else(String::new, shown);
        let [least, in_least, most, in_most] = m.extremes.map_or_else(Default::default, |[(least, a), (most, b)]| {
            [shown(least), a.run.to_string(), shown(most), b.run.to_string()]
        });
        let interval = m.interval.map_or_else(String::new, |[low, high]| format!("{} to {}", shown(low), shown(high)));
        let [mean, deviation] = [m.mean, m.deviation].map(cell);
        rows.add_row([m.of.title.clone(), mean, interval, deviation, least, in_least, most, in_most]);
    }
    format!("{rows}\n")
}

/// Returns the cells of a figure: margin, instant and run.
fn cells(w: &Worst, f: &Figure) -> [String; 3] {
    let margin = match (w.margin, w.verdict) {
        (Some(m), _) => tables::margin(m, f.unit),
        (None, Some(verdict)) => row::word(verdict).to_string(),
        (None, None) => String::new(),
    };
    let at = w.at.map_or_else(String::new, |s| format!("{s:.2} s"));
    [margin, at, w.row.run.to_string()]
}
