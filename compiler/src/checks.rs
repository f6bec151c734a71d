//! Checks that look at the finished program: gains against the period, the start against the limits, freedom left.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Span};
use runtime::program::{Program, Times};
use runtime::record::summary::MARGIN_TOLERANCE;
use runtime::{Controller, Evaluator, Fault, Member, Observation, Rest, build_tasks};
use solver::{Active, Status};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{ANGLE, ANGULAR_VELOCITY, Dimension, LENGTH, RATE, VELOCITY};
use stdlib_tasks::task::{BuildError, Nature, RowInfo};

use crate::binding::Number;
use crate::codes;
use crate::lowering::Places;
use crate::one_place;
use crate::planners;
use crate::pointless;
use crate::ranges::Ground;
use crate::units::shown;
use crate::{bounds, braking};
use crate::{jumps, reach, standing};

/// Checks a program that has no errors so far.
pub(crate) fn program(ground: &Ground, program: &Program, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    let before = diagnostics.len();
    planners::check(program, places, diagnostics);
    reach::limits(ground, program, places, diagnostics);
    jumps::check(ground, program, places, diagnostics);
    standing::check(program, places, diagnostics);
    let values = &program.values.initial;
    wider(program, places, diagnostics);
    let mut reported: Vec<(usize, String)> = Vec::new();
    for (i, stack) in program.stacks.iter().enumerate() {
        if let Some(refusal) = bounds::pairs(program, stack, places) {
            diagnostics.push(refusal);
            continue;
        }
        let model = &program.robot.model;
        let built = build_tasks(model, program.robot.period, &program.values.initial, &program.tasks, stack);
        let members = stack.levels.iter().enumerate().flat_map(|(k, l)| l.members.iter().map(move |m| (k, m)));
        let rows = built.iter().flat_map(|b| &b.task).map(|t| t.rows().len()).sum();
        if let Some(refusal) = bounds::rows(rows, i, places) {
            diagnostics.push(refusal);
            continue;
        }
        let mut complete = true;
        for (task, (level, m)) in built.iter().zip(members) {
            match &task.task {
                Ok(task) => {
                    for gain in task.gains(&program.values.initial) {
                        let once = (m.task, "gain".to_string());
                        if gain * program.robot.period > 1.0 + 1e-12 && !reported.contains(&once) {
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
            start(program, i, places, diagnostics);
        }
    }
    let mut told = BTreeSet::new();
    if diagnostics[before..].iter().all(|d| d.severity == dsl::Severity::Warning) {
        braking::check(program, places, diagnostics);
        one_place::check(program, places, diagnostics);
        told = pointless::program(program, places, diagnostics);
    }
    reach::targets(ground, program, places, &told, diagnostics);
}

fn place(places: &Places, task: usize, param: &str) -> Span {
    let t = &places.tasks[task];
    t.spans.get(param).copied().unwrap_or(t.span)
}

/// Where a number of a task was written; the parameter, or the task's type, where it is a default.
fn number(places: &Places, task: usize, param: &str, is: impl Fn(&Number) -> bool) -> Span {
    let t = &places.tasks[task];
    let written = t.numbers.iter().find(|n| n.written && is(n));
    written.map_or_else(|| place(places, task, param), |n| n.span)
}

/// The parameter that sets a limit, where only one of them was written.
fn limit(places: &Places, task: usize) -> Span {
    let t = &places.tasks[task];
    let written = ["d_min", "min", "max", "lower", "upper"].iter().filter_map(|p| t.spans.get(*p)).collect::<Vec<_>>();
    match written.as_slice() {
        [one] => **one,
        _ => t.span,
    }
}

fn overshoot(gain: f64, values: &[f64], period: f64, places: &Places, task: usize) -> Diagnostic {
    let at = number(places, task, "gain", |n| n.dimension == RATE && values.get(n.slot.at) == Some(&gain));
    codes::overshoot(at, gain, (period, places.rate), places.tasks[task].kind.nature)
}

/// Limits that a task sets beyond those of the robot: its rows then let through what the joint cannot do.
fn wider(program: &Program, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
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

fn cannot_build(e: &BuildError, places: &Places, task: usize) -> Diagnostic {
    let d = Diagnostic::error("HQ0503", place(places, task, &e.param), e.message.clone());
    match &e.help {
        Some(h) => d.help(h.clone()),
        None => d,
    }
}

/// Points at speed limits of the stack that do not count for a wall on this level, because they are soft or stand below.
fn loose_speeds(mut d: Diagnostic, program: &Program, (stack, level): (usize, usize), places: &Places) -> Diagnostic {
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

/// Warns of limits whose reserve is larger than the margin at the start: they push the robot away from the first tick.
fn reserves(evaluator: &Evaluator, program: &Program, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    for (i, m) in evaluator.members().iter().enumerate() {
        let kept = evaluator.reserve(i);
        let margins = &evaluator.margins()[m.margins.clone()];
        let rows = m.row_info.iter().zip(margins.iter().zip(&kept));
        let short: Vec<(&RowInfo, f64, f64)> =
            rows.filter(|(_, (h, k))| *h < *k).map(|(r, (h, k))| (r, *h, *k)).collect();
        let worst = short.iter().copied().reduce(|a, b| if b.2 - b.1 > a.2 - a.1 { b } else { a });
        let Some((row, margin, reserve)) = worst else { continue };
        let text = |x: f64| match row.dimension {
            LENGTH => millimetres(x),
            other => measured(x, other),
        };
        let more = match short.len() - 1 {
            0 => String::new(),
            n => format!(", and {n} more rows with theirs"),
        };
        let text = format!(
            "`{}` starts inside its reserve: {} has a margin of {}, and {} are held back{more}",
            m.name,
            row.name,
            text(margin),
            text(reserve)
        );
        let d = Diagnostic::warning("HQ0505", place(places, m.program_index, "sampled_margin"), text)
            .label(places.home, "the robot starts here")
            .note(
                "the limit pushes the robot away from the first tick on, until the margin is as large as the reserve",
            );
        let written = program.tasks[m.program_index].params.get("sampled_margin");
        diagnostics.push(d.help(match written {
            Some(Bound::Choice(_)) => smaller_reserve(margin, reserve, program.robot.period),
            _ => "start further away, or hold less back".to_string(),
        }));
    }
}

/// What makes a reserve fit a margin: it grows with the square of the speeds and with the period.
fn smaller_reserve(margin: f64, reserve: f64, period: f64) -> String {
    let share = margin / reserve;
    if share < 1e-3 {
        return "start further away, lower the speed limits, or raise the rate".to_string();
    }
    // Rounded to the side that suffices.
    let slower = (share.sqrt() * 100.0).floor();
    let rate = (1.0 / (period * share)).ceil();
    format!(
        "start further away; or lower the speed limits of all joints to {slower} % of what they are, or raise the rate to \
         {rate} Hz, and the reserve is as small as the margin"
    )
}

/// A length in mm, to a thousandth.
fn millimetres(x: f64) -> String {
    format!("{} mm", runtime::text::number((x * 1e3 * 1e3).round() / 1e3))
}

/// Evaluates a stack at the home configuration.
fn start(program: &Program, stack: usize, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    let Ok((mut evaluator, mut problem)) = Evaluator::new(program, stack) else { return };
    // What signals will say is not known.
    if !evaluator.needs().is_empty() {
        return;
    }
    let rest = Rest::new(program);
    let moment = rest.at(Times::default());
    evaluator.enter(&program.robot.home, moment);
    if let Err(fault) = evaluator.update(&program.robot.home, moment, &mut problem) {
        let text = Controller::for_stack(program, stack).map(|mut c| {
            c.step(&Observation { time: 0.0, q: &program.robot.home });
            c.describe(&fault)
        });
        let text = text.unwrap_or_else(|e| e.to_string());
        let task = |member: usize| evaluator.members().get(member).map(|m| limit(places, m.program_index));
        let has = |n: &Number, at: usize| (n.slot.at..n.slot.at + n.slot.len).contains(&at);
        let at = match fault {
            Fault::Overlap { member, .. } | Fault::NotFinite { member, .. } | Fault::Crossed { member, .. } => {
                task(member)
            }
            Fault::Gain { member } => evaluator.members().get(member).map(|m| place(places, m.program_index, "gain")),
            Fault::Value { at } => (0..places.tasks.len())
                .find(|&t| places.tasks[t].numbers.iter().any(|n| has(n, at)))
                .map(|t| number(places, t, "", |n| has(n, at))),
            _ => None,
        };
        let d = Diagnostic::error("HQ0502", at.unwrap_or(places.home), format!("at home, {text}"));
        let joined = match fault {
            Fault::Overlap { member, row } => {
                evaluator.members().get(member).and_then(|m| neighbours(program, m, std::iter::once(row)))
            }
            _ => None,
        };
        diagnostics.push(match (at, fault) {
            (Some(_), Fault::Overlap { .. }) if joined.is_some() => d.help(joined.unwrap_or_default()),
            (_, Fault::Value { at }) if evaluator.rate(at).is_none_or(|r| !r.is_finite()) => d
                .note("a target that jumps or starts infinitely fast asks for an infinite velocity in the first tick")
                .help(
                    "let the argument of a root, a logarithm or a power start above zero, as in `sqrt(t/(1 s) + 0.01)`",
                ),
            (_, Fault::Value { .. } | Fault::Gain { .. }) => d.help("keep the value inside its range from the start"),
            (_, Fault::Crossed { .. }) => d.help("move the two limits apart"),
            (Some(_), _) => d.label(places.home, "the robot starts here").help("move the home configuration"),
            (None, _) => d.help("move the home configuration"),
        });
        return;
    }
    let mut outside = false;
    for m in evaluator.members() {
        let rows = m.row_info.iter().zip(&evaluator.margins()[m.margins.clone()]);
        // Margins of velocities exist only once a velocity was chosen: they are infinite here.
        let bad: Vec<String> = rows
            .filter(|(_, h)| **h < -MARGIN_TOLERANCE)
            .map(|(r, h)| format!("{} by {}", r.name, measured(-h, r.dimension)))
            .collect();
        let Some(first) = bad.first() else { continue };
        outside = true;
        let more = if bad.len() > 1 { format!(" and {} more", bad.len() - 1) } else { String::new() };
        let text = format!("`{}` is violated at the start: {first}{more}", m.name);
        let mut d = Diagnostic::error("HQ0502", limit(places, m.program_index), text)
            .label(places.home, "the robot starts here")
            .note("a barrier function keeps a limit only from inside it");
        if bad.len() > 1 {
            let shown = bad.iter().take(8).cloned().collect::<Vec<_>>().join(", ");
            let rest = bad.len().saturating_sub(8);
            d = d.note(format!(
                "violated are {shown}{}",
                if rest > 0 { format!(", .. ({rest} more)") } else { String::new() }
            ));
        }
        let rows = m.row_info.iter().zip(&evaluator.margins()[m.margins.clone()]).enumerate();
        let violated = rows.filter(|(_, (_, h))| **h < 0.0).map(|(row, _)| row);
        diagnostics.push(if let Some(help) = neighbours(program, m, violated) {
            d.help(help)
        } else if m.kind == "virtual_wall" {
            d.help("move the home configuration or the wall; to keep the other side, swap two of the three points")
        } else {
            d.help("move the home configuration or the limit")
        });
    }
    if !outside {
        reserves(&evaluator, program, places, diagnostics);
        first_tick(program, stack, places, diagnostics);
    }
}

/// A number with its unit, to three digits.
fn measured(x: f64, dimension: Dimension) -> String {
    shown(format!("{x:.2e}").parse().unwrap_or(x), dimension)
}

/// The help for a collision limit between links that one joint connects: they touch wherever the robot stands.
fn neighbours(program: &Program, member: &Member, rows: impl Iterator<Item = usize>) -> Option<String> {
    if member.kind != "self_collision" {
        return None;
    }
    let model = &program.robot.model;
    let params = &program.tasks[member.program_index].params;
    let link_of = |name: &str| {
        ["between", "and"].iter().find_map(|side| match params.get(*side) {
            Some(Bound::Geometries(all)) => all.iter().find(|g| g.name == name).map(|g| g.link),
            _ => None,
        })
    };
    for row in rows {
        let Some((a, b)) = member.row_info.get(row).and_then(|r| r.name.split_once(" to ")) else { continue };
        let Some((i, k)) = link_of(a).zip(link_of(b)) else { continue };
        let (on_a, on_b) = (model.support(i), model.support(k));
        let between = on_a.iter().filter(|j| !on_b.contains(j)).chain(on_b.iter().filter(|j| !on_a.contains(j)));
        if between.count() == 1 {
            let [a, b] = [a, b].map(|name| name.split('[').next().unwrap_or(name));
            return Some(format!(
                "`{a}` and `{b}` are neighbours: one joint connects them, and they touch wherever the robot stands. Name \
                 links that are further apart"
            ));
        }
    }
    None
}

fn first_tick(program: &Program, stack: usize, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    let Ok(mut controller) = Controller::for_stack(program, stack) else { return };
    let fault = controller.step(&Observation { time: 0.0, q: &program.robot.home }).fault;
    let levels = &places.stacks[stack].1;
    if let Status::Infeasible { level } = controller.solution().status {
        let text = fault.map(|f| controller.describe(&f)).unwrap_or_default();
        diagnostics.push(
            Diagnostic::error("HQ0504", levels[level], format!("at home, {text}"))
                .label(places.home, "the robot starts here")
                .note("a hard level takes no slack, so the first tick would be a fault")
                .help(if program.stacks[stack].levels[level].damping > 0.0 {
                    "remove the level's `damping`: it trades the rows against the size of the velocity, and a hard level may not"
                } else {
                    "relax the level, or remove `hard`"
                }),
        );
        return;
    }
    let nv = program.robot.model.nv();
    let program = &program.stacks[stack];
    let free = nv.saturating_sub(program.locked.len());
    for (k, level) in program.levels.iter().enumerate() {
        let left = if k == 0 { free } else { controller.freedom(k - 1) };
        let targets = level.members.iter().any(|m| places.tasks[m.task].kind.nature == Nature::Target);
        let asks = controller.solution().levels[k].active.iter().any(|a| *a != Active::Free);
        if left > 0 || !targets || (k > 0 && !asks) {
            continue;
        }
        let d = Diagnostic::warning("HQ0604", levels[k], format!("level `{}` has no freedom left at home", level.name));
        let d = if free == 0 {
            d.label(places.stacks[stack].0, "this stack locks every degree of freedom")
        } else {
            d.label(levels[k - 1], "this level and those above it fix every degree of freedom")
        };
        diagnostics.push(d.help(if program.levels[..k].iter().any(|l| l.damping > 0.0) {
            "remove `damping` from the level above: a damped level decides every direction, and leaves none to those below"
        } else {
            "ask less of the levels above, or unlock joints"
        }));
        // Those below have none either, for the same reason.
        break;
    }
}
