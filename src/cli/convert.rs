//! `hierarq convert LOG OUT`: `log.csv` to MCAP with the spec of the run, and MCAP to `log.csv`.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use files::Target;
use hierarq::scenario_runner::MAX_SEED;
use hierarq::{outputs, project, scenario_runner};
use logs::csv::{self, Rows, ToCsvError};
use logs::{About, Log, LogFile, Messages, Origin};
use runtime::{Controller, Program};

use super::mcap_log::texts;
use super::replay::MAX_LOG;
use super::{Outcome, SpecOptions, output};

#[derive(Args)]
pub struct Arguments {
    /// The log: `log.csv` of a run, or a log in MCAP.
    log: PathBuf,
    /// The file to write: `*.mcap`, or `*.csv`.
    out: PathBuf,
    /// The spec of the run, or its compiled program; needed for MCAP.
    #[arg(long)]
    spec: Option<PathBuf>,
    /// The scenario of the run, if it was one.
    #[arg(long, value_name = "NAME", requires = "spec")]
    scenario: Option<String>,
    /// The seed of the run, if it was not the spec's.
    #[arg(long, value_name = "N", requires = "spec", value_parser = clap::value_parser!(u64).range(0..=MAX_SEED))]
    seed: Option<u64>,
    #[command(flatten)]
    options: SpecOptions,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let ending = |path: &Path| path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match (ending(&a.log).as_deref(), ending(&a.out).as_deref()) {
        (Some("csv"), Some("mcap")) => to_mcap(a),
        (Some("mcap"), Some("csv")) => to_csv(a),
        _ => Err(format!(
            "cannot convert `{}` to `{}`: one of them ends in .csv, and the other one in .mcap",
            a.log.display(),
            a.out.display()
        )),
    }
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    files::read(path, MAX_LOG).map_err(|e| format!("cannot read `{}`: {e}", path.display()))
}

fn to_csv(a: &Arguments) -> Result<Outcome, String> {
    let shown = a.log.display();
    let unusable = |e: &dyn std::fmt::Display| format!("cannot use `{shown}`: {e}");
    let target = Target::new("the output", &a.out, outputs::LOG, std::slice::from_ref(&a.log))?;
    let bytes = read(&a.log)?;
    let log = Log::read(&bytes).map_err(|e| unusable(&e))?;
    let mut output = target.begin()?;
    let mut out = BufWriter::with_capacity(1 << 16, &mut output);
    let written = csv::write(&log, &mut out).and_then(|ticks| Ok(out.flush().map(|()| ticks)?));
    drop(out);
    let ticks = match written {
        Ok(ticks) => ticks,
        Err(ToCsvError::Write(e)) => return Err(output.cannot(&e)),
        Err(e) => return Err(unusable(&e)),
    };
    output.finish()?;
    wrote(&a.out, ticks)
}

fn wrote(path: &Path, ticks: usize) -> Result<Outcome, String> {
    output::print(&format!("wrote {}: {ticks} ticks\n", path.display()));
    Ok(Outcome::Good)
}

fn to_mcap(a: &Arguments) -> Result<Outcome, String> {
    let shown = a.log.display();
    let Some(spec) = &a.spec else {
        return Err(format!("`{shown}` does not say which robot it is of: give the spec of the run, `--spec SPEC`"));
    };
    let compiled = project::load(spec, &a.options.settings());
    let Some(mut program) = compiled.program else { return output::refuse(&compiled.report, spec, false) };
    output::show(&compiled.report);
    let mut sources = project::sources(spec, &compiled.report);
    sources.push(a.log.clone());
    let target = Target::new("the output", &a.out, outputs::MCAP, &sources)?;
    let mut scenario = match &a.scenario {
        Some(name) => Some(scenario_runner::of_controller(&program, name)?.clone()),
        None => None,
    };
    let text = String::from_utf8(read(&a.log)?).map_err(|_| format!("cannot use `{shown}`: it is not UTF-8 text"))?;
    let run = scenario.as_mut().map_or(&mut program.run, |s| &mut s.run);
    run.simulator.seed = a.seed.unwrap_or(run.simulator.seed);
    // As long as the log, so that a replay is as long too.
    let rows = text.lines().count().saturating_sub(1).max(1);
    run.duration = rows as f64 * program.robot.period;
    if let Some(s) = &scenario {
        program = s.program(&program);
    }
    let controller = Controller::new(&program).map_err(|e| e.to_string())?;
    let about = About::new(&program, scenario.as_ref(), texts(&compiled.report), Origin::Csv);
    let mut output = target.begin()?;
    let ticks = match write(&text, &about, (&program, &controller), &mut output) {
        Ok(ticks) => ticks,
        Err(Failure::Log(e)) => return Err(format!("cannot use `{shown}`: {e}")),
        Err(Failure::Write(e)) => return Err(output.cannot(&e)),
    };
    output.finish()?;
    wrote(&a.out, ticks)
}

/// Reason why a log is not converted.
enum Failure {
    Log(csv::CsvError),
    Write(std::io::Error),
}

impl From<csv::CsvError> for Failure {
    fn from(e: csv::CsvError) -> Failure {
        Failure::Log(e)
    }
}

impl From<std::io::Error> for Failure {
    fn from(e: std::io::Error) -> Failure {
        Failure::Write(e)
    }
}

fn write(
    text: &str,
    about: &About,
    (program, controller): (&Program, &Controller),
    output: &mut files::Output,
) -> Result<usize, Failure> {
    let mut messages = Messages::new(program, controller);
    let rows = Rows::new(text, program, controller, messages.signals_at())?;
    let mut file = LogFile::new(BufWriter::with_capacity(1 << 16, output), about, &messages)?;
    messages.begin(&mut |topic, time, message| file.write(topic, time, message))?;
    let mut ticks = 0;
    for row in rows {
        messages.tick(&row?, &mut |topic, time, message| file.write(topic, time, message))?;
        ticks += 1;
    }
    file.finish(ticks, 0)?.flush()?;
    Ok(ticks)
}
