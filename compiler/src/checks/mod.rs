//! Checks of the finished program. Each rule is a file, and an entry of [`CHECKS`].

mod accelerations;
mod braking;
mod built_stacks;
mod compliance;
mod conflicting_targets;
mod contradictions;
pub mod coverage;
mod deep;
mod discontinuities;
mod entries;
mod first_tick;
mod fixed_above;
mod ineffective;
mod inert_limits;
mod kept_distances;
mod large_reserves;
mod machine;
mod magnitudes;
mod missing_limits;
mod partial_limits;
mod people;
mod plants;
mod postures;
mod reachability;
mod readings;
mod safety_planners;
mod scenario_start;
mod scenarios;
mod seams;
mod sensors;
mod short_runs;
mod singular_targets;
pub(crate) mod size_limits;
mod soft_limits;
mod tracking_gain;
mod unknown_velocity;
mod wall_reach;
mod watches;
mod wider_limits;

use std::collections::BTreeSet;

use dsl::{Diagnostic, Severity, Sources, Span};
use runtime::program::Program;

use crate::analysis::stacks::Stacks;
use crate::analysis::value_ranges::RangeContext;
use crate::binding::Number;
use crate::expand::Expanded;
use crate::lowering::LoweredController;
use crate::sampled::{Deep, Sampled};
use crate::source_map::SourceMap;

/// A controller that was lowered without errors, as the checks see it.
struct Checked<'c> {
    program: &'c Program,
    /// Source spans of the parts of the program.
    places: &'c SourceMap,
    /// Ranges of expressions.
    context: &'c RangeContext<'c>,
    /// The declarations that the program was made from.
    expanded: &'c Expanded,
    sources: &'c Sources,
    /// The stacks, built once for all rules.
    stacks: Stacks<'c>,
}

/// A rule: adds its diagnostics.
type Check = fn(&Checked, &mut Vec<Diagnostic>);

/// The rules, in the order in which they run. A rule of [`On::GoodProgram`] evaluates the program at configurations, which
/// has no meaning after an error of a rule before it.
static CHECKS: &[(On, Check)] = &[
    (On::AnyProgram, |c, out| safety_planners::check(c.program, c.places, out)),
    (On::AnyProgram, |c, out| reachability::limits(c.context, c.program, c.places, out)),
    (On::AnyProgram, |c, out| discontinuities::check(c.context, c.program, c.places, out)),
    (On::AnyProgram, seams::check),
    (On::AnyProgram, |c, out| unknown_velocity::check(c.program, c.places, out)),
    (On::AnyProgram, |c, out| wider_limits::check(c.program, c.places, out)),
    (On::AnyProgram, built_stacks::check),
    (On::GoodProgram, accelerations::check),
    (On::GoodProgram, braking::check),
    (On::GoodProgram, large_reserves::check),
    (On::GoodProgram, soft_limits::check),
    (On::GoodProgram, |c, out| conflicting_targets::check(c.program, c.places, out)),
    (On::GoodProgram, magnitudes::checks),
    (On::AnyProgram, targets),
    (On::GoodProgram, inert_limits::check),
    (On::GoodProgram, fixed_above::check),
    (On::GoodProgram, scenario_start::check),
    (On::GoodProgram, scenarios::check),
    (On::AnyProgram, machine::checks),
    (On::AnyProgram, |c, out| ineffective::spec(c.expanded, c.program, out)),
    (On::GoodProgram, sensors::checks),
    (On::GoodProgram, people::checks),
    (On::GoodProgram, plants::check),
    (On::GoodProgram, tracking_gain::check),
    (On::GoodProgram, compliance::checks),
    (On::GoodProgram, partial_limits::check),
    (On::GoodProgram, missing_limits::check),
    (On::GoodProgram, kept_distances::check),
    (On::GoodProgram, watches::check),
    (On::GoodProgram, singular_targets::check),
    (On::GoodProgram, short_runs::check),
    (On::GoodProgram, coverage::check),
];

/// Programs that a rule examines.
#[derive(Clone, Copy, PartialEq, Eq)]
enum On {
    /// Every program.
    AnyProgram,
    /// Programs in which the rules before found no error.
    GoodProgram,
}

/// Checks a controller that was lowered without errors; also at sampled postures, if these are asked for.
pub(crate) fn controller(
    lowered: &LoweredController,
    expanded: &Expanded,
    sources: &Sources,
    deep: Option<&Deep>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Sampled> {
    let LoweredController { program, source_map: places, graph, table } = lowered;
    let context = &RangeContext::new(graph, table, program);
    let checked = Checked { program, places, context, expanded, sources, stacks: Stacks::new(program) };
    for (on, check) in CHECKS {
        if *on == On::AnyProgram || !has_errors(diagnostics) {
            check(&checked, diagnostics);
        }
    }
    let deep = deep.filter(|_| !has_errors(diagnostics))?;
    Some(deep::check(&checked, deep, diagnostics))
}

/// Targets without effect, and out of reach. A task that nothing moves is not reported again as out of reach.
fn targets(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told = if has_errors(out) { BTreeSet::new() } else { ineffective::program(c, out) };
    reachability::targets(c.context, c.program, c.places, &mut told, out);
    reachability::frames(c.context, c.program, c.places, &mut told, out);
    if !has_errors(out) {
        let mut found = Vec::new();
        postures::check(c, told, out, &mut found);
        found.retain(|d| !questioned(out, d.primary.span));
        out.extend(found);
    }
}

/// True if a diagnostic is about a part of this text already, such as a number without a unit. What follows from the number
/// may follow from the same mistake.
fn questioned(found: &[Diagnostic], span: Span) -> bool {
    let (a, b) = (span.range(), |d: &Diagnostic| d.primary.span.range());
    found.iter().any(|d| d.primary.span.source == span.source && a.start < b(d).end && b(d).start < a.end)
}

fn has_errors(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().any(|d| d.severity == Severity::Error)
}

fn place(places: &SourceMap, task: usize, param: &str) -> Span {
    let t = &places.tasks[task];
    // A parameter of a group that was not written is at its group.
    let mut paths = std::iter::successors(Some(param), |path| path.rsplit_once('.').map(|(group, _)| group));
    paths.find_map(|path| t.spans.get(path)).copied().unwrap_or(t.span)
}

/// Span of a task's number; for a default, that of the parameter or of the task's type.
fn number(places: &SourceMap, task: usize, param: &str, is: impl Fn(&Number) -> bool) -> Span {
    let t = &places.tasks[task];
    let written = t.numbers.iter().find(|n| n.written && is(n));
    written.map_or_else(|| place(places, task, param), |n| n.span)
}

/// Span of the parameter that sets a limit, if only one such parameter was written.
fn limit(places: &SourceMap, task: usize) -> Span {
    let t = &places.tasks[task];
    let written = ["d_min", "min", "max", "lower", "upper"].iter().filter_map(|p| t.spans.get(*p)).collect::<Vec<_>>();
    match written.as_slice() {
        [one] => **one,
        _ => t.span,
    }
}
