//! Limits of people whose velocity nobody knows: they hold for people who stand.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::program::{HumanProgram, Program, TaskProgram, Velocity};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::task::Nature;

use crate::lowering::Places;

/// Warns of people with `velocity none` that limits and planners reckon with, each of them once.
pub(crate) fn check(program: &Program, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    for human in &program.interface.humans {
        let signals = || human.points.iter().filter_map(|&s| program.interface.signals.get(s));
        if !signals().any(|s| s.motion.is_some_and(|m| m.velocity == Velocity::None)) {
            continue;
        }
        let numbers: BTreeSet<usize> = signals().flat_map(|s| s.at + 1..=s.at + s.len).collect();
        let uses = program.tasks.iter().enumerate().filter_map(|(i, t)| Some((i, reckons(program, t, &numbers)?)));
        let uses: Vec<(usize, &str)> = uses.collect();
        let Some(&(task, param)) = uses.first() else { continue };
        let t = &program.tasks[task];
        let more = match uses.len() - 1 {
            0 => String::new(),
            1 => ", and so does one other task".to_string(),
            n => format!(", and so do {n} other tasks"),
        };
        let text = format!("`{}` takes `{}` to stand{more}", t.name, human.name);
        let at = places.tasks.get(task).map(|b| b.spans.get(param).copied().unwrap_or(b.span)).unwrap_or_default();
        diagnostics.push(Diagnostic::warning("HQ0524", at, text).note(why(t, human)).help(format!(
            "write `velocity estimated` into `human {}`, or `velocity measured` where the host sends it{}",
            human.name,
            if t.kind == "speed_separation" { "; or `human assumed` here" } else { "" }
        )));
    }
}

/// What the missing velocity does.
fn why(task: &TaskProgram, human: &HumanProgram) -> String {
    let none = format!("with `velocity none` the points of `{}` have no speed", human.name);
    match task.kind.as_str() {
        "speed_separation" => format!("{none}, and nothing is added to the distance for how fast they come"),
        _ => format!("{none}: a row that lacks it lets whoever comes get inside the limit, by their speed over `gain`"),
    }
}

/// The parameter by which a limit or a planner depends on how fast the points move that have these numbers of the table of
/// signals; none where it does not.
fn reckons<'t>(program: &Program, task: &'t TaskProgram, numbers: &BTreeSet<usize>) -> Option<&'t str> {
    let kind = stdlib_tasks::find(&task.kind)?;
    let planner = task.kind == "safety_planner";
    let assumed = matches!(task.params.get("human"), Some(Bound::Choice(human)) if human == "assumed");
    if assumed || !(planner || kind.nature == Nature::Limit) {
        return None;
    }
    let reads = |bound: &Bound| {
        let places: BTreeSet<usize> = match bound {
            Bound::Field(field) => program.fields.get(*field)?.points.iter().flatten().copied().collect(),
            _ if planner => return None,
            _ => bound.slots().into_iter().flat_map(|s| s.at..s.at + s.len).collect(),
        };
        (!program.values.tape.only(&places).signals().is_disjoint(numbers)).then_some(())
    };
    task.params.iter().find(|(_, bound)| reads(bound).is_some()).map(|(name, _)| name.as_str())
}
