//! Checks of the finished program: gains against the period, start against the limits, remaining freedom.

mod accelerations;
mod braking;
mod conflicting_targets;
mod discontinuities;
mod entries;
mod first_tick;
mod ineffective;
mod machine;
mod reachability;
mod safety_planners;
mod scenario_start;
pub(crate) mod size_limits;
mod unknown_velocity;

use std::collections::BTreeSet;

use dsl::{Diagnostic, Sources, Span};
use runtime::build_tasks;
use runtime::program::{Program, overshoots};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{ANGLE, ANGULAR_VELOCITY, LENGTH, RATE, VELOCITY};
use stdlib_tasks::task::BuildError;

use crate::analysis::value_ranges::Ground;
use crate::binding::Number;
use crate::binding::gain;
use crate::expand::Expanded;
use crate::lowering::LoweredController;
use crate::source_map::SourceMap;
use crate::units::shown;

/// Checks a controller that was lowered without errors.
pub(crate) fn controller(
    lowered: &LoweredController,
    expanded: &Expanded,
    sources: &Sources,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let LoweredController { program: lowered, source_map, graph, table } = lowered;
    let ground = Ground::new(graph, table, &lowered.robot.model);
    program(&ground, lowered, source_map, sources, diagnostics);
    if diagnostics.iter().all(|d| d.severity != dsl::Severity::Error) {
        scenario_start::check(lowered, &source_map.scenario_starts, diagnostics);
    }
    if let Some(places) = &source_map.machine {
        machine::checks(lowered, places, diagnostics);
    }
    ineffective::spec(expanded, lowered, diagnostics);
}

/// Checks the program itself.
fn program(
    ground: &Ground,
    program: &Program,
    places: &SourceMap,
    sources: &Sources,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let before = diagnostics.len();
    safety_planners::check(program, places, diagnostics);
    reachability::limits(ground, program, places, diagnostics);
    discontinuities::check(ground, program, places, diagnostics);
    unknown_velocity::check(program, places, diagnostics);
    let values = &program.values.initial;
    wider(program, places, diagnostics);
    let mut reported: Vec<(usize, String)> = Vec::new();
    for (i, stack) in program.stacks.iter().enumerate() {
        if let Some(refusal) = size_limits::pairs(program, stack, places) {
            diagnostics.push(refusal);
            continue;
        }
        let built = build_tasks(program, stack);
        let members = stack.levels.iter().enumerate().flat_map(|(k, l)| l.members.iter().map(move |m| (k, m)));
        let rows = built.iter().flat_map(|b| &b.task).map(|t| t.rows().len()).sum();
        if let Some(refusal) = size_limits::rows(rows, i, places) {
            diagnostics.push(refusal);
            continue;
        }
        let mut complete = true;
        for (task, (level, m)) in built.iter().zip(members) {
            match &task.task {
                Ok(task) => {
                    for gain in task.gains(&program.values.initial) {
                        let once = (m.task, "gain".to_string());
                        if overshoots(gain, program.robot.period) && !reported.contains(&once) {
                            reported.push(once);
                            diagnostics.push(overshoot(gain, values, program.robot.period, places, m.task));
                        }
                    }
                }
                Err(e) => {
                    complete = false;
                    let once = (m.task, e.param.clone());
                    if !reported.contains(&once) {
                        reported.push(once);
                        let d = cannot_build(e, places, m.task);
                        diagnostics.push(if e.param == "sampled_margin" {
                            loose_speeds(d, program, (i, level), places)
                        } else {
                            d
                        });
                    }
                }
            }
        }
        if complete && diagnostics[before..].iter().all(|d| d.severity == dsl::Severity::Warning) {
            first_tick::start(program, i, places, diagnostics);
        }
    }
    let mut told = BTreeSet::new();
    if diagnostics[before..].iter().all(|d| d.severity == dsl::Severity::Warning) {
        accelerations::check(program, places, sources, diagnostics);
        braking::check(program, places, diagnostics);
        conflicting_targets::check(program, places, diagnostics);
        told = ineffective::program(program, places, diagnostics);
    }
    reachability::targets(ground, program, places, &told, diagnostics);
}

fn place(places: &SourceMap, task: usize, param: &str) -> Span {
    let t = &places.tasks[task];
    t.spans.get(param).copied().unwrap_or(t.span)
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

fn overshoot(gain: f64, values: &[f64], period: f64, places: &SourceMap, task: usize) -> Diagnostic {
    let at = number(places, task, "gain", |n| n.dimension == RATE && values.get(n.slot.at) == Some(&gain));
    gain::overshoot(at, gain, (period, places.rate), places.tasks[task].kind.nature)
}

/// Warns of limits of a task that are wider than the robot's: their rows permit motions that the joint cannot perform.
fn wider(program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    let dofs = &program.robot.model.dofs;
    for (i, task) in program.tasks.iter().enumerate() {
        let params: &[&str] = match task.kind.as_str() {
            "joint_position_limits" => &["lower", "upper"],
            "joint_velocity_limits" => &["max"],
            _ => continue,
        };
        for param in params {
            let Some(Bound::PerJoint(list)) = task.params.get(*param) else { continue };
            let beyond = list.iter().filter_map(|(dof, slot)| {
                let (d, x) = (dofs.get(*dof)?, *program.values.initial.get(slot.at)?);
                let own = match *param {
                    "lower" => d.lower,
                    "upper" => d.upper,
                    _ => d.velocity,
                };
                let wide = if *param == "lower" { x < own } else { x > own };
                (wide && own.is_finite()).then_some((d, slot, x, own))
            });
            let beyond: Vec<_> = beyond.collect();
            let Some((d, slot, x, own)) = beyond.first() else { continue };
            let dimension = match (d.unit, *param) {
                (robot::DofUnit::Metre, "max") => VELOCITY,
                (robot::DofUnit::Metre, _) => LENGTH,
                (robot::DofUnit::Radian, "max") => ANGULAR_VELOCITY,
                (robot::DofUnit::Radian, _) => ANGLE,
            };
            let (x, own) = (shown(*x, dimension), shown(*own, dimension));
            let at = number(places, i, param, |n| n.slot.at == slot.at);
            let more = if beyond.len() > 1 { format!(", and {} more joints", beyond.len() - 1) } else { String::new() };
            diagnostics.push(
                Diagnostic::warning("HQ0506", at, format!("`{}` is wider than the limit of the robot", param))
                    .here(format!("{x}; `{}` has {own}{more}", d.name))
                    .note("the rows allow what the joint cannot do, and the robot then falls behind its reference")
                    .help(format!("stay within {own}, or change the robot's `limits` if the URDF is wrong")),
            );
        }
    }
}

fn cannot_build(e: &BuildError, places: &SourceMap, task: usize) -> Diagnostic {
    let d = Diagnostic::error("HQ0503", place(places, task, &e.param), e.message.clone());
    match &e.help {
        Some(h) => d.help(h.clone()),
        None => d,
    }
}

/// Labels the speed limits of the stack that do not count for a wall on this level, because they are soft or lower.
fn loose_speeds(
    mut d: Diagnostic,
    program: &Program,
    (stack, level): (usize, usize),
    places: &SourceMap,
) -> Diagnostic {
    let levels = program.stacks[stack].levels.iter().zip(&places.stacks[stack].1);
    for (k, (l, span)) in levels.enumerate() {
        let limits = l.members.iter().any(|m| program.tasks[m.task].kind == "joint_velocity_limits");
        let why = if !limits || (l.hard && k <= level) {
            continue;
        } else if l.hard {
            "the speed limits of this level do not count: it stands below"
        } else {
            "the speed limits of this level do not count: it is soft and may give way"
        };
        d = d.label(*span, why);
    }
    d
}
