//! Warns of limits of people with unknown velocity: they hold only for people at rest.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{Program, TaskProgram, Velocity};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::task::PersonVelocityUse;

use crate::source_map::SourceMap;

/// Warns of people with `velocity none` whose velocity limits and planners use; once for each person.
pub(crate) fn check(program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    for human in &program.interface.humans {
        let signals = || human.points.iter().filter_map(|&s| program.interface.signals.get(s));
        if !signals().any(|s| s.motion.is_some_and(|m| m.velocity == Velocity::None)) {
            continue;
        }
        let numbers: BTreeSet<usize> = signals().flat_map(|s| s.at + 1..=s.at + s.len).collect();
        let uses =
            program.tasks.iter().enumerate().filter_map(|(i, t)| Some((i, person_velocity(program, t, &numbers)?)));
        let uses: Vec<(usize, (&str, &PersonVelocityUse))> = uses.collect();
        let Some(&(task, (param, how))) = uses.first() else { continue };
        let t = &program.tasks[task];
        let more = match uses.len() - 1 {
            0 => String::new(),
            1 => ", and so does one other task".to_string(),
            n => format!(", and so do {n} other tasks"),
        };
        let text = format!("`{}` assumes that `{}` does not move{more}", t.name, human.name);
        let at = places.tasks.get(task).map(|b| b.spans.get(param).copied().unwrap_or(b.span)).unwrap_or_default();
        let note = format!("with `velocity none` the points of `{}` have no speed: {}", human.name, how.consequence);
        diagnostics.push(Diagnostic::warning("HQ0524", at, text).note(note).help(Help::with(
            &format!(
                "write {{}} into the human `{}`, or {{}} where the host sends it{}",
                human.name,
                how.alternative.map_or_else(String::new, |instead| format!("; or {instead}"))
            ),
            ["estimated", "measured"].map(|how| Snippet::entry("velocity", how)),
        )));
    }
}

/// Returns the parameter with which a task uses the velocity of points, and the kind of use; `None` if it uses none.
/// `numbers` are the numbers of these points in the table of signals.
fn person_velocity<'t>(
    program: &Program,
    task: &'t TaskProgram,
    numbers: &BTreeSet<usize>,
) -> Option<(&'t str, &'static PersonVelocityUse)> {
    let how = stdlib_tasks::find(&task.kind)?.person_velocity?;
    let reads = |bound: &Bound| {
        let places: BTreeSet<usize> = match bound {
            Bound::Field(field) => program.fields.get(*field)?.points.iter().flatten().copied().collect(),
            _ => bound.slots().into_iter().flat_map(|s| s.at..s.at + s.len).collect(),
        };
        (!program.values.tape.only(&places).signals().is_disjoint(numbers)).then_some(())
    };
    let counts = |(name, bound): &(&'t String, &Bound)| (how.uses_rate)(name, &task.params) && reads(bound).is_some();
    task.params.iter().find(counts).map(|(name, _)| (name.as_str(), how))
}
