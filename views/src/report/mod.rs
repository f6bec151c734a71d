//! Report of a run: one HTML file with plots and a 3D replay, usable offline.
//!
//! The page is built from `assets/` (see its README); this module computes its data from the recording.

mod mission;
mod obstacles;
mod people;
mod plots;
pub mod roughness;
mod scene;

use runtime::Program;
use runtime::expect::Verdict;
use runtime::program::{AllowedWarning, ScenarioProgram};
use runtime::quantity::quantity;
use runtime::record::expectations::ExpectationRecord;
use runtime::record::series::SeriesRecorder;
use runtime::record::summary::{MANY_FAULTS, MARGIN_TOLERANCE, Summary, TaskSummary, Waited};
use serde_json::{Value as Json, json};

static TEMPLATE: &str = include_str!("assets/report.html");
static PLACEHOLDER: &str = "@@HIERARQ_DATA@@";

pub use mission::mission;
pub use scene::drawn_links;

/// The run that a report is about.
pub struct Run<'a> {
    /// The program that ran.
    pub program: &'a Program,
    /// Its scenario, if it ran in one.
    pub scenario: Option<&'a ScenarioProgram>,
    /// Name of the spec's file.
    pub spec: &'a str,
    /// Its summary.
    pub summary: &'a Summary,
    /// True if the result is as expected.
    pub good: bool,
    /// Its recording.
    pub series: &'a SeriesRecorder,
}

/// Renders the report as HTML.
pub fn html(run: &Run) -> String {
    let data = data(run).to_string().replace('<', "\\u003c");
    TEMPLATE.replacen(PLACEHOLDER, &data, 1)
}

/// Data of the page, version 1.
pub fn data(run: &Run) -> Json {
    let &Run { program, scenario, spec, summary, good, series } = run;
    let truth = scenario.and_then(|scenario| scenario.true_program(program));
    json!({
        "version": 1,
        "title": program.title,
        "program": program.name,
        "spec": spec,
        "generated_by": concat!("hierarq ", env!("CARGO_PKG_VERSION")),
        "duration": summary.duration_s,
        "period": program.robot.period,
        "ticks": summary.ticks,
        "verdict": { "ok": good, "text": expected(summary) + &verdict(summary) + &allowed(&summary.allowed) },
        "expectations": summary.expectations.iter().map(expectation).collect::<Vec<_>>(),
        "states": summary.states.iter().map(|s| json!({ "state": s.state, "from": s.from_s, "to": s.to_s })).collect::<Vec<_>>(),
        "entries": entries(summary),
        "stopping": summary.stopping.iter().map(|s| json!({
            "stack": s.stack, "states": s.states, "time": finite(s.time_s),
            "links": s.links.iter().map(|l| json!({ "link": l.link, "way": finite(l.way_m) })).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "summary_rows": rows(program, summary),
        "levels": summary.levels.iter().map(|l| json!({
            "name": l.stack.as_ref().map_or_else(|| l.name.clone(), |s| format!("{s}: {}", l.name)), "hard": l.hard, "rows": l.rows, "freedom": l.min_freedom,
            "saturated_share": l.saturated_share, "worst_violation": l.max_violation,
        })).collect::<Vec<_>>(),
        "held_back": summary.held_back,
        "joints": roughness::rough(&summary.joints).iter().map(|(name, j)| json!({
            "joint": name, "unit": j.unit, "acceleration": j.max_acceleration, "at": j.at_s, "reversals": j.reversals,
            "first_reversal": j.first_reversal_s, "jumps": j.jumps, "first_jump": j.first_jump_s,
        })).collect::<Vec<_>>(),
        "tick_us": summary.tick_us.all,
        "faults": summary.faults,
        "time": series.times,
        "plots": plots::all(program, series),
        "scene": scene::scene(program, truth.as_ref(), series),
    })
}

/// Number of entries of each state, in descending order.
fn entries(summary: &Summary) -> Vec<Json> {
    let mut all: Vec<_> = summary.entries.iter().collect();
    all.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    all.into_iter().map(|(state, count)| json!({ "state": state, "count": count })).collect()
}

fn expectation(e: &ExpectationRecord) -> Json {
    json!({
        "label": e.label, "text": e.text, "verdict": e.verdict, "margin": e.margin, "unit": e.unit, "at": e.worst_s,
        "undefined_at": e.undefined_s, "untested": e.untested,
    })
}

/// Sentence about the expectations; empty if there are none.
fn expected(summary: &Summary) -> String {
    let all = summary.expectations.len();
    let count = |v: Verdict| summary.expectations.iter().filter(|e| e.verdict == v).count();
    match (count(Verdict::Fails), count(Verdict::Undecided)) {
        _ if all == 0 => String::new(),
        (0, 0) if all == 1 => format!("The expectation holds{}. ", untested(summary)),
        (0, 0) => format!("All {all} expectations hold{}. ", untested(summary)),
        (fail, 0) => format!("Expectations that fail: {fail} of {all}. "),
        (0, open) => format!("Expectations that are undecided: {open} of {all}. "),
        (fail, open) => format!("Of {all} expectations {fail} fail, and undecided are {open}. "),
    }
}

/// Part of a sentence about the expectations whose condition was never true.
fn untested(summary: &Summary) -> String {
    let all = summary.expectations.len();
    match summary.expectations.iter().filter(|e| e.untested).count() {
        0 => String::new(),
        1 if all == 1 => ", but was never put to the test".to_string(),
        1 => ", but one was never put to the test".to_string(),
        n => format!(", but {n} were never put to the test"),
    }
}

/// Summary of faults and limits, of the closest approach to a limit, of joints that jumped or reversed, and of the physics that
/// moved the robot.
pub fn verdict(summary: &Summary) -> String {
    let answered = match summary.faults.iter().filter(|f| f.answered).count() {
        0 => String::new(),
        n if n >= MANY_FAULTS => String::new(),
        1 => "The machine handled a fault. ".to_string(),
        n => format!("The machine handled {n} faults. "),
    };
    let rough = roughness::sentence(&summary.joints).map(|text| format!(" But {text}.")).unwrap_or_default();
    let remarks: String = summary.remarks.iter().map(|r| format!("{r}. ")).collect();
    let ended = summary.diverged.iter().map(|why| format!("The run ended early: {why}. ")).collect::<String>();
    let plant = summary.plant.iter().map(|plant| format!(" {}.", plant.describe())).collect::<String>();
    ended + &waited(summary) + &remarks + &answered + &limits(summary) + &rough + &late(summary) + &plant
}

/// Sentence about the warnings that the spec allows; empty if there are none.
pub fn allowed(all: &[AllowedWarning]) -> String {
    let each: Vec<String> = all.iter().map(|a| format!("{} ({})", a.code, a.reason)).collect();
    match each.as_slice() {
        [] => String::new(),
        [one] => format!(" The spec allows a warning: {one}."),
        _ => format!(" The spec allows {} warnings: {}.", each.len(), each.join(", ")),
    }
}

/// Sentence about the wait for a signal.
fn waited(summary: &Summary) -> String {
    let Some(Waited { signal, from_s, ticks }) = &summary.waited else { return String::new() };
    let period = summary.duration_s / summary.ticks.max(1) as f64;
    let time = quantity(*ticks as f64 * period, "s");
    if from_s + (*ticks as f64 + 0.5) * period >= summary.duration_s {
        return format!("The robot stood still for {time}, to the end of the run: `{signal}` was awaited. ");
    }
    format!("The robot stood still for {time} until the first value of `{signal}` arrived. ")
}

/// Sentence about ticks that exceeded their budget.
fn late(summary: &Summary) -> String {
    let Some(late) = summary.late.filter(|late| late.ticks > 0) else { return String::new() };
    let budget = quantity(1e-6 * late.budget_us, "s");
    let (ticks, of) = (late.ticks, summary.ticks);
    let row = if late.in_a_row > 1 { format!(", {} in a row at most", late.in_a_row) } else { String::new() };
    format!(
        " {ticks} of {of} ticks took longer than their budget of {budget}{row}: the robot made do there with hard levels and what was known of the answer."
    )
}

/// Sentence about limits, or about the fault that the machine did not handle.
fn limits(summary: &Summary) -> String {
    if let Some(f) = summary.faults.iter().find(|f| !f.answered) {
        let until = if summary.halted { "from then on" } else { "until the machine left the state" };
        return format!("Fault at {:.2} s: {}. The robot was kept still {until}.", f.time, f.text);
    }
    // Distances only: a joint at rest at its limit has a margin of zero, which is no problem.
    let closest = |t: &&(&String, &TaskSummary)| t.1.unit == "m" && t.1.min_margin.is_some_and(f64::is_finite);
    let limits: Vec<(&String, &TaskSummary)> = summary.tasks.iter().filter(|t| t.1.min_margin.is_some()).collect();
    let broken: Vec<String> = limits
        .iter()
        .filter(|(_, t)| t.min_margin.is_some_and(|m| m < -MARGIN_TOLERANCE))
        .map(|(name, t)| format!("`{name}` ({})", t.min_margin_row.as_deref().unwrap_or("?")))
        .collect();
    if !broken.is_empty() {
        return format!("Limits that did not hold: {}.", broken.join(", "));
    }
    let distance = limits
        .iter()
        .filter(closest)
        .min_by(|a, b| a.1.min_margin.partial_cmp(&b.1.min_margin).unwrap_or(std::cmp::Ordering::Equal));
    match distance {
        Some((name, t)) => {
            let row = t.min_margin_row.as_deref().unwrap_or("?");
            format!(
                "No limit was passed. Smallest distance to one: {} (`{name}`, {row}).",
                quantity(t.min_margin.map_or(0.0, tidy), "m")
            )
        }
        None if limits.is_empty() => "No fault. The stack has no limits.".to_string(),
        None => "No limit was passed.".to_string(),
    }
}

/// Names of the tasks of a run, in the order of stacks and levels, without duplicates.
pub fn task_order(program: &Program) -> Vec<String> {
    let mut order: Vec<String> = Vec::new();
    let stacks = program.run_stacks();
    let members = stacks.iter().flat_map(|&s| &program.stacks[s].levels).flat_map(|l| &l.members);
    for name in members.map(|m| &program.tasks[m.task].name) {
        if !order.contains(name) {
            order.push(name.clone());
        }
    }
    order
}

fn rows(program: &Program, summary: &Summary) -> Vec<Json> {
    task_order(program)
        .into_iter()
        .filter_map(|name| summary.tasks.get(&name).map(|t| (name, t)))
        .map(|(name, t)| {
            let measures: Vec<Json> = if let Some(m) = t.min_margin {
                let unit = t.min_margin_unit.as_deref().unwrap_or(&t.unit);
                // Rows of different units have no common last value.
                let last = t.final_margin.filter(|_| unit == t.unit).and_then(finite).map(tidy);
                vec![json!({ "name": "margin", "unit": unit, "smallest": finite(m).map(tidy), "final": last, "at": t.at_s })]
            } else if t.errors.is_empty() {
                vec![json!({ "name": "error", "unit": t.unit, "largest": t.max_error, "final": t.final_error, "at": t.at_s })]
            } else {
                (t.errors.iter())
                    .map(|(part, e)| json!({ "name": part, "unit": e.unit, "largest": e.max, "final": finite(e.last), "at": e.at_s }))
                    .collect()
            };
            json!({
                "task": name, "kind": t.kind, "level": t.level, "measures": measures,
                "active_share": t.active_share, "active_rows": t.active_rows,
            })
        })
        .collect()
}

/// Rounds numbers to zero that are zero up to rounding errors.
fn tidy(x: f64) -> f64 {
    if x.abs() < MARGIN_TOLERANCE { 0.0 } else { x }
}

/// A finite number, or null.
fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
