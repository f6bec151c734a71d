//! `hierarq run SPEC`

use std::io::{BufWriter, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use clap::Args;
use files::{Results, Target};
use hierarq::scenario_runner::MAX_SEED;

use hierarq::{outputs, project, report, scenario_runner};
use indicatif::{ProgressBar, ProgressStyle};
use runtime::program::ScenarioProgram;
use runtime::record::All;
use runtime::record::columns::Columns;
use runtime::record::csv::{CsvRecorder, header};
use runtime::record::expectations::{is_good, records};
use runtime::record::series::SeriesRecorder;
use runtime::record::summary::{Summary, SummaryRecorder};
use runtime::record::verify::{UNPROVEN, Verifier};
use runtime::{ExpectationMonitors, Program, Simulation};
use solver::Backend;

use super::mcap_log::{self, McapLog};
use super::{Outcome, SpecOptions, interruption, output, run_mission, table};
use hierarq::qp_log::ProblemRecorder;

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    pub(super) spec: PathBuf,
    #[command(flatten)]
    options: SpecOptions,
    /// Folder for report.html, log.csv and summary.json [default: out/NAME].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print the summary as JSON.
    #[arg(long)]
    pub(super) json: bool,
    /// Solver, in place of the spec's: `active_set` or `clarabel`.
    #[arg(long, visible_alias = "backend", value_name = "BACKEND", value_parser = backend)]
    pub(super) solver: Option<Backend>,
    /// Also solve every tick with the other solver, and report the largest difference.
    #[arg(long)]
    pub(super) verify: bool,
    /// Write the optimisation problem of each tick to this file, in the format of `hierarq solve`.
    #[arg(long, value_name = "FILE")]
    pub(super) problems: Option<PathBuf>,
    /// Logs of the run: `mcap` also writes log.mcap, with messages of ROS 2 that other programs read.
    #[arg(long, value_name = "FORMAT", value_enum, default_value = "csv")]
    pub(super) log: LogFormat,
    /// Run this scenario of the spec, and evaluate its expectations.
    #[arg(long, value_name = "NAME")]
    scenario: Option<String>,
    /// Duration of the run, in place of the spec's: `2s`, `500ms`; a number without a unit is in seconds.
    #[arg(long, value_name = "TIME", value_parser = super::duration, allow_hyphen_values = true)]
    pub(super) duration: Option<f64>,
    /// Seed of all random numbers, in place of the spec's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(0..=MAX_SEED))]
    pub(super) seed: Option<u64>,
}

/// Format of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum LogFormat {
    /// log.csv alone.
    Csv,
    /// log.csv and log.mcap.
    Mcap,
}

fn backend(text: &str) -> Result<Backend, String> {
    Backend::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = Backend::ALL.iter().map(|b| b.name()).collect();
        format!("known are {}", names.join(" and "))
    })
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    if a.log == LogFormat::Mcap {
        mcap_log::possible()?;
    }
    let compiled = project::load(&a.spec, &a.options.settings());
    if !compiled.is_good() || (compiled.program.is_none() && a.scenario.is_none()) {
        return output::refuse(&compiled.report, &a.spec, a.json);
    }
    output::show(&compiled.report);
    let sources = project::sources(&a.spec, &compiled.report);
    let mut scenario = match &a.scenario {
        Some(name) => match scenario_runner::find(compiled.program.as_ref(), &compiled.missions, name)? {
            scenario_runner::Found::Controller(_, scenario) => Some(scenario.clone()),
            scenario_runner::Found::Mission(mission, scenario) => {
                return run_mission::run(a, mission, scenario, &sources);
            }
        },
        None => None,
    };
    let Some(mut program) = compiled.program else { return output::refuse(&compiled.report, &a.spec, a.json) };
    let run = scenario.as_mut().map_or(&mut program.run, |s| &mut s.run);
    run.duration = a.duration.unwrap_or(run.duration);
    run.solver = a.solver.unwrap_or(run.solver);
    run.simulator.seed = a.seed.unwrap_or(run.simulator.seed);
    if let Some(s) = &scenario {
        program = s.program(&program);
    }
    if let Err(e) = program.check() {
        let d = program.run.duration;
        return Err(format!("--duration {d} s: {}", e.message));
    }
    let folder = a.out.clone().unwrap_or_else(|| Path::new("out").join(&program.name));
    let unproven = |s: &Summary| s.verification.as_ref().is_some_and(|v| v.max_certificate > UNPROVEN);
    let (summary, good) = execute((&program, scenario.as_ref()), &compiled.report, &folder, &sources, a)?;
    Ok(Outcome::of(good && !unproven(&summary)))
}

/// Runs, writes the files and prints the results; returns the summary, and true if all is well.
fn execute(
    (program, scenario): (&Program, Option<&ScenarioProgram>),
    report: &compiler::Report,
    folder: &Path,
    sources: &[PathBuf],
    a: &Arguments,
) -> Result<(Summary, bool), String> {
    let mut simulation = match scenario {
        Some(scenario) => Simulation::in_world(program, scenario),
        None => Simulation::new(program),
    }
    .map_err(|e| e.to_string())?;
    let ticks = simulation.ticks();
    let mut monitors = match scenario {
        Some(scenario) => Some(ExpectationMonitors::new(program, scenario, ticks).map_err(|e| e.to_string())?),
        None => None,
    };
    let path = |name: &str| folder.join(name);
    let failed = |p: &Path| {
        let p = p.display().to_string();
        move |e: std::io::Error| format!("cannot write {p}: {e}")
    };
    let log = path("log.csv");
    // Checked before results of an earlier run are removed.
    let problems =
        a.problems.as_deref().map(|p| Target::new("--problems", p, outputs::PROBLEMS, sources)).transpose()?;
    let mut results = Results::begin(folder, &outputs::RESULTS, sources)?;
    let problems = problems.map(Target::begin).transpose()?;
    let mut problems = problems.map(|output| ProblemRecorder::new(BufWriter::with_capacity(1 << 16, output)));
    let mut rows = BufWriter::with_capacity(1 << 16, results.part("log.csv")?);
    let controller = simulation.controller();
    let columns = header(program, &Columns::new(program, controller)).len();
    if let Some(warning) = large_log(ticks, columns) {
        output::error_line(&warning);
    }
    let mut csv = CsvRecorder::new(&mut rows, program, controller).map_err(failed(&log))?;
    let mut mcap = match a.log {
        LogFormat::Csv => None,
        LogFormat::Mcap => Some(McapLog::begin(&results, program, scenario, report, controller)?),
    };
    let mut statistics = SummaryRecorder::new(controller, ticks);
    let mut series = SeriesRecorder::new(controller, ticks, report::drawn_links(program));

    let bar = progress(ticks);
    let started = Instant::now();
    let mut clock = || started.elapsed().as_secs_f64();
    let interrupted = interruption::flag();
    let mut go_on = |tick: usize| {
        if tick.is_multiple_of(64) {
            bar.set_position(tick as u64);
        }
        !interrupted.load(Ordering::Relaxed)
    };
    let mut verifier = a.verify.then(|| Verifier::new(program, simulation.controller()));
    let mut all = All(vec![&mut csv, &mut statistics, &mut series]);
    if let Some(verifier) = &mut verifier {
        all.0.push(verifier);
    }
    if let Some(monitors) = &mut monitors {
        all.0.push(monitors);
    }
    if let Some(mcap) = &mut mcap {
        all.0.push(mcap);
    }
    // Last recorder: if it fails to write, all others have recorded this tick.
    if let Some(problems) = &mut problems {
        all.0.push(problems);
    }
    let ran = simulation.run(&mut all, &mut clock, &mut go_on);
    if let Err(e) = ran {
        let path = a.problems.as_deref().filter(|_| problems.as_ref().is_some_and(ProblemRecorder::has_failed));
        return Err(format!("cannot write {}: {e}", path.unwrap_or(&log).display()));
    }
    bar.finish_and_clear();
    let took = started.elapsed();
    csv.finish().map_err(failed(&log))?;
    results.add("log.csv", rows.into_inner().map_err(|e| failed(&log)(e.into_error()))?);
    let names = written(mcap.is_some());
    if let Some(mcap) = mcap {
        mcap.finish(&mut results)?;
    }
    if let Some((problems, p)) = problems.zip(a.problems.as_ref()) {
        problems.finish().map_err(failed(p))?.finish()?;
    }

    let outputs: Vec<String> = names.iter().map(|n| path(n).display().to_string()).collect();
    let mut summary = statistics.summary(program, simulation.controller(), outputs.clone());
    summary.verification = verifier.map(|v| v.result().clone());
    summary.interrupted = interrupted.load(Ordering::Relaxed);
    let mut good = summary.ok && !summary.interrupted;
    if let Some((monitors, scenario)) = monitors.zip(scenario) {
        summary.expectations = records(scenario, &monitors.finish(), program.robot.period);
        good = is_good(scenario, &summary.expectations, &summary);
    }
    let text = serde_json::to_string_pretty(&summary).map_err(|e| e.to_string())? + "\n";
    let held = if summary.expectations.is_empty() { summary.ok } else { good };
    let spec = a.spec.display().to_string();
    let run = report::Run { program, scenario, spec: &spec, summary: &summary, good: held, series: &series };
    let page = report::html(&run);
    results.write("report.html", &page)?;
    results.write("summary.json", &text)?;
    results.finish()?;
    if a.json {
        output::data(&text);
    } else {
        show(program, &summary, good, &outputs, took);
    }
    Ok((summary, good))
}

/// The files of a run, as people read them.
fn written(mcap: bool) -> Vec<&'static str> {
    let log = if mcap { Some("log.mcap") } else { None };
    ["report.html", "log.csv"].into_iter().chain(log).chain(["summary.json"]).collect()
}

/// Size of a log (bytes) that is announced before the run.
const LARGE_LOG: f64 = (1_u64 << 30) as f64;

/// Size of a number in a log (bytes), with its comma: most numbers have all digits.
const NUMBER: f64 = 19.0;

/// Returns a warning about a log that may fill the disk.
fn large_log(ticks: usize, columns: usize) -> Option<String> {
    let bytes = ticks as f64 * columns as f64 * NUMBER;
    (bytes > LARGE_LOG).then(|| {
        format!(
            "log.csv will take about {:.1} GiB: {ticks} ticks of {columns} numbers; `--duration` shortens the run",
            bytes / LARGE_LOG
        )
    })
}

fn progress(ticks: usize) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(ticks as u64);
    if let Ok(style) =
        ProgressStyle::with_template("  {bar:40.cyan/black} {percent:>3} %  {pos} of {len} ticks, {eta} left")
    {
        bar.set_style(style);
    }
    bar
}

/// Prints the results of a run; `good` is true if all expectations hold.
fn show(program: &Program, summary: &Summary, good: bool, outputs: &[String], took: Duration) {
    let order = report::task_order(program);
    let speed = summary.duration_s / took.as_secs_f64().max(1e-9);
    let t = &summary.tick_us.all;
    let verified = summary.verification.as_ref().map(table::verification).unwrap_or_default();
    let mark = match summary.ok {
        true if !summary.remarks.is_empty() => "held, but",
        true => "held",
        // The expectations of a scenario decide, and may expect a limit to be violated.
        false if good => "limits",
        false => "FAILED",
    };
    let cut = if summary.interrupted { "INTERRUPTED before its end\n" } else { "" };
    output::print(&format!(
        "\n{}\n{}\n{}{}{}{}{}{}\n{cut}{mark}: {}{}\n{}{}{} ticks of {} ms; controller median {:.0} us, p99 {:.0} us, max {:.0} us; {speed:.0} times real time\n{verified}wrote {}\n",
        program.title,
        table::tasks(summary, &order),
        table::levels(summary),
        table::joints(summary),
        table::held_back(summary),
        table::states(summary),
        table::answered(summary),
        table::expectations(&summary.expectations, good),
        report::verdict(summary),
        report::allowed(&summary.allowed),
        table::rough(summary),
        table::hints(summary),
        summary.ticks,
        program.robot.period * 1e3,
        t.median,
        t.p99,
        t.max,
        outputs.join(", "),
    ));
}

#[cfg(test)]
mod tests {
    use super::large_log;

    #[test]
    fn a_log_that_fills_the_disk_is_told() {
        assert_eq!(large_log(2_000, 60), None);
        let text = large_log(10_000_000, 60).expect("more than a GiB");
        assert!(text.contains("10.6 GiB") && text.contains("10000000 ticks of 60 numbers"), "{text}");
    }
}
