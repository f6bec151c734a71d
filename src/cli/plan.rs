//! `hierarq plan SPEC [MISSION]`: plans a mission of any kind, and prints and draws the plan.

use std::fmt::Write;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use files::{Target, is_same};
use hierarq::{gantt, outputs, project};
use mission::engine::{Engine, EngineError};
use mission::kind::{Kind, Mission};
use mission::kinds::KINDS;
use mission::numbers::MAX_BATCH;
use mission::plan::{Limit, Status};
use mission::planned::{Listing, PlanOptions, Planned, Refusal};
use runtime::program::MissionProgram;
use runtime::text::{number, running};

use super::{Outcome, SpecOptions, output};

/// Maximum time limit of a planner (s).
const LONGEST: f64 = 1e6;

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    spec: PathBuf,
    /// The mission; may be omitted if the spec declares only one.
    mission: Option<String>,
    #[command(flatten)]
    options: SpecOptions,
    /// Solver for mixed-integer programs.
    #[arg(long, value_parser = engines(), default_value = "built-in")]
    engine: Engine,
    /// Formulation of the planner, in place of the one that it chooses.
    #[arg(long, value_parser = formulations())]
    formulation: Option<String>,
    /// Number of operations or tasks per batch if there are too many for a single plan, in place of the spec's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_BATCH as u64))]
    batch: Option<u64>,
    /// Time limit of the planner [default: 10s]: `2s`, `500ms`; a number without a unit is in seconds.
    #[arg(long, value_name = "TIME", value_parser = super::duration)]
    budget: Option<f64>,
    /// Print the plan as JSON.
    #[arg(long)]
    json: bool,
    /// Write a Gantt chart of the plan to this file (SVG).
    #[arg(long, value_name = "FILE")]
    gantt: Option<PathBuf>,
    /// Write a map of positions and paths to this file (SVG).
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
}

fn engines() -> impl TypedValueParser<Value = Engine> {
    PossibleValuesParser::new(Engine::ALL.map(Engine::name))
        .map(|s| Engine::ALL.into_iter().find(|e| e.name() == s).unwrap_or_default())
}

/// Returns the formulations of all kinds of mission.
fn formulations() -> PossibleValuesParser {
    let mut all: Vec<&str> = Vec::new();
    for name in KINDS.iter().flat_map(|kind| (kind.formulations)()) {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    PossibleValuesParser::new(all)
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let compiled = project::load(&a.spec, &a.options.settings());
    if !compiled.is_good() {
        return output::refuse(&compiled.report, &a.spec, a.json);
    }
    if !a.json {
        output::show(&compiled.report);
    }
    let mission = project::mission(&compiled.missions, a.mission.as_deref())
        .map_err(|message| format!("{}: {message}", a.spec.display()))?;
    // Checked before the search, which may take a while.
    let pictures = Pictures::new(a, &project::sources(&a.spec, &compiled.report))?;
    let printed = plan(a, mission, pictures)?;
    if a.json {
        output::data(&printed)
    } else {
        output::painted(&printed)
    }
    Ok(Outcome::Good)
}

/// Plans a mission, and draws the requested drawings; returns the output.
fn plan(a: &Arguments, mission: &MissionProgram, pictures: Pictures) -> Result<String, String> {
    let (of, name): (&dyn Mission, &str) = (&*mission.kind, &mission.name);
    if let Some(tasks) = of.generation().filter(|_| of.waits_for_tasks()) {
        return Err(format!(
            "mission `{name}` has no {} yet: let a model write them, `hierarq context {} {name} --out {name}.json`, and name \
             the file in the mission, `{} \"{name}.json\"`",
            tasks.noun(),
            a.spec.display(),
            tasks.key(),
        ));
    }
    let options = PlanOptions {
        formulation: a.formulation.as_deref(),
        engine: a.engine,
        batch: a.batch.and_then(|batch| usize::try_from(batch).ok()),
        time: budget(a)?,
    };
    let planned = of.plan(&options).map_err(|why| refused(&why, of.kind()))?;
    pictures.draw(&planned)?;
    if a.json {
        return Ok(data(&planned, &a.spec.display().to_string(), name, of.kind()));
    }
    Ok(text(name, &planned, &running(mission)))
}

/// Returns the plan as text.
fn text(name: &str, p: &Planned, running: &[String]) -> String {
    let end = p.chart.end().unwrap_or(0.0);
    let mut out = format!("mission {name}: {}, all done after {end:.1} s\n", p.summary);
    let engine = if p.engine == p.method.formulation { String::new() } else { format!(" ({})", p.engine) };
    let _ = writeln!(out, "planned by {}{engine}: {}", p.method.formulation, p.method.why);
    let _ = writeln!(out, "{}", status(&p.status));
    let _ = writeln!(out, "validated: the plan meets all constraints of the mission\n");
    let mut out = output::plain(&out) + &gantt::text(&p.chart, output::width(), coloured());
    let chart = out.len();
    let Listing { columns, rows, names, note } = &p.table;
    let _ = writeln!(out, "\n{}{note}\n{}", aligned(columns, rows, *names), p.cost_text);
    for line in running {
        let _ = writeln!(out, "{line}");
    }
    let below = output::plain(&out.split_off(chart));
    out + &below
}

/// Returns the time limit of the planner, if one is requested.
fn budget(a: &Arguments) -> Result<Option<Duration>, String> {
    let Some(seconds) = a.budget else { return Ok(None) };
    let time = Duration::try_from_secs_f64(seconds).ok().filter(|t| !t.is_zero() && seconds <= LONGEST);
    time.map(Some)
        .ok_or_else(|| format!("--budget {seconds} s: the time limit must be more than 0 s and at most {LONGEST} s"))
}

/// Returns the reason why there is no plan of a mission of this kind, with the options that help.
pub fn refused(why: &Refusal, kind: &Kind) -> String {
    match why {
        Refusal::NoFormulation { written, known } => {
            let names = compiler::names::list(known.iter().copied(), known.len());
            format!("{} has no formulation `{written}`; it has {names}", kind.title)
        }
        Refusal::Formulation { why, instead } => {
            format!("{why}; leave `--formulation` out, or write `--formulation {instead}`")
        }
        Refusal::Engine(e @ EngineError::Missing { .. }) => {
            format!("{e}; without `--engine`, the built-in engine is used")
        }
        Refusal::Mission(_) | Refusal::Engine(_) => why.to_string(),
        Refusal::Invalid(violations) => {
            let mut text =
                "the planner gave what is no plan of this mission, and it is not shown: a mistake in Hierarq, \
                            and none in the spec; please report it with the spec"
                    .to_string();
            for violation in violations.iter().take(8) {
                let _ = write!(text, "\n  {violation}");
            }
            text
        }
    }
}

/// Returns a plan as JSON.
pub fn data(plan: &Planned, spec: &str, mission: &str, kind: &Kind) -> String {
    // Serialization cannot fail: the data are names, numbers and lists.
    plan.to_json(spec, mission, kind.name).unwrap_or_default() + "\n"
}

/// Output files of the drawings of a plan.
struct Pictures {
    gantt: Option<Target>,
    map: Option<Target>,
}

impl Pictures {
    fn new(a: &Arguments, sources: &[PathBuf]) -> Result<Pictures, String> {
        if let (Some(gantt), Some(map)) = (&a.gantt, &a.map)
            && (gantt == map || is_same(gantt, map))
        {
            return Err(format!("--gantt and --map name the same file, `{}`", map.display()));
        }
        let target = |option: &str, path: &Option<PathBuf>| {
            path.as_deref().map(|path| Target::new(option, path, outputs::PICTURE, sources)).transpose()
        };
        Ok(Pictures { gantt: target("--gantt", &a.gantt)?, map: target("--map", &a.map)? })
    }

    /// Draws the requested drawings.
    fn draw(self, plan: &Planned) -> Result<(), String> {
        let standing = gantt::Standing { styled: true, ..gantt::Standing::default() };
        self.gantt.map_or(Ok(()), |target| target.write(&gantt::svg(&plan.chart)))?;
        self.map.map_or(Ok(()), |target| target.write(&gantt::map(&plan.map, &standing)))
    }
}

fn coloured() -> bool {
    output::style(std::io::stdout().is_terminal()) == compiler::Style::Terminal
}

fn limit(stopped: Limit) -> &'static str {
    match stopped {
        Limit::Time => "the search reached its time limit; `--budget 60s` raises it",
        Limit::Work => "the search reached its limit of steps; with `--budget` only the time limit applies",
        Limit::Accuracy => "the engine reached its numerical accuracy",
    }
}

/// Returns the status of a plan as a sentence.
fn status(status: &Status) -> String {
    match status {
        Status::Proven { bound } => format!("optimal: no plan costs less than {}", number(*bound)),
        Status::Gap { bound, gap, stopped } => format!(
            "not proven optimal: every plan costs at least {}, {:.2} % below this one; {}",
            number(*bound),
            100.0 * gap,
            limit(*stopped)
        ),
        Status::Unbounded { stopped: None } => "no bound on the optimum".to_string(),
        Status::Unbounded { stopped: Some(stopped) } => format!("no bound on the optimum; {}", limit(*stopped)),
    }
}

/// Returns aligned rows below a header: the first `left` columns left-aligned, numbers right-aligned.
pub fn aligned(header: &[&str], rows: &[Vec<String>], left: usize) -> String {
    let width = |i: usize| {
        let cells = rows.iter().filter_map(|row| row.get(i)).map(|cell| gantt::columns(cell));
        cells.chain(header.get(i).map(|h| gantt::columns(h))).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: Vec<&str>| {
        let all = cells.iter().zip(&widths).enumerate();
        let all = all.map(|(i, (cell, w))| {
            let space = " ".repeat(w.saturating_sub(gantt::columns(cell)));
            if i < left { format!("{cell}{space}") } else { format!("{space}{cell}") }
        });
        all.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
    };
    let body = rows.iter().map(|row| line(row.iter().map(String::as_str).collect()));
    std::iter::once(line(header.to_vec())).chain(body).collect()
}
