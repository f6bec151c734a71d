//! Checks of a stack at the home configuration: margins, reserves, and the first tick.
//!
//! A stack that is entered elsewhere has no margins yet, so only mistakes that are independent of the configuration are
//! reported for it.

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{MemberProgram, Program, Times};
use runtime::record::summary::MARGIN_TOLERANCE;
use runtime::{Controller, Evaluator, Fault, Member, Observation, RestInputs, TickInputs};
use solver::{Problem, Status};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{Dimension, LENGTH};
use stdlib_tasks::kinds::{joint_acceleration_limits, joint_position_limits, joint_velocity_limits};
use stdlib_tasks::task::{RowInfo, RowKind};

use super::contradictions::Unmet;
use super::{Checked, contradictions, entries, fixed_above, limit, number, place};
use crate::analysis::postures::alone;
use crate::analysis::stacks::Prepared;
use crate::binding::Number;
use crate::source_map::SourceMap;
use crate::units::shown;

/// Coefficient of a row up to which a joint does not change it.
const STILL: f64 = 1e-9;

/// Evaluates a stack at the home configuration and simulates its first tick.
pub(super) fn start(c: &Checked, stack: usize, diagnostics: &mut Vec<Diagnostic>) {
    let Some(mut prepared) = c.stacks.take(stack) else { return };
    evaluated(c, stack, &mut prepared, diagnostics);
    c.stacks.give(stack, prepared);
}

fn evaluated(c: &Checked, stack: usize, prepared: &mut Prepared, diagnostics: &mut Vec<Diagnostic>) {
    let (program, places) = (c.program, c.places);
    let at_home = entries::at_home(program, stack);
    if !prepared.evaluator.needs().is_empty() {
        if at_home {
            without_signals(c, stack, diagnostics);
        }
        return;
    }
    let Some(outside) = margins(c, Entered { program, stack, at_home }, prepared, diagnostics) else { return };
    let reduced;
    let first = match at_home {
        true if outside.hard => return,
        true => {
            reserves(&prepared.evaluator, program, places, diagnostics);
            FirstTick::new(program, stack)
        }
        false => {
            reduced = alone(program, entries::anywhere(program, stack));
            FirstTick::new(&reduced, 0)
        }
    };
    if let Some(first) = first
        && !first.hard_levels(c, stack, at_home, diagnostics)
    {
        if at_home {
            first.freedom(c, stack, diagnostics);
        } else if !outside.any
            && let Some(first) = FirstTick::new(program, stack)
        {
            first.freedom(c, stack, diagnostics);
        }
    }
}

/// Checks the part of a stack at home that needs no signal: the values of signals are unknown at compile time. What this
/// part cannot do, the whole stack cannot do either.
fn without_signals(c: &Checked, stack: usize, diagnostics: &mut Vec<Diagnostic>) {
    let reduced = alone(c.program, entries::without_signals(c.program, stack));
    let Ok((evaluator, problem)) = Evaluator::new(&reduced, 0) else { return };
    let mut prepared = Prepared { evaluator, problem };
    if !prepared.evaluator.needs().is_empty() {
        return;
    }
    let entered = Entered { program: &reduced, stack: 0, at_home: true };
    let Some(outside) = margins(c, entered, &mut prepared, diagnostics) else { return };
    if outside.hard {
        return;
    }
    reserves(&prepared.evaluator, c.program, c.places, diagnostics);
    if let Some(first) = FirstTick::new(&reduced, 0) {
        first.hard_levels(c, stack, true, diagnostics);
    }
}

/// A stack, or the part of one, at the home configuration.
#[derive(Clone, Copy)]
struct Entered<'a> {
    program: &'a Program,
    /// Its index in this program.
    stack: usize,
    /// True if a run can enter it there.
    at_home: bool,
}

/// Limits that are violated at home.
#[derive(Clone, Copy)]
struct Outside {
    /// True if there is one.
    any: bool,
    /// True if one of them is on a hard level.
    hard: bool,
}

/// Reports a stack that cannot be entered at home, and limits that are violated there. Returns `None` if there are no
/// margins.
fn margins(
    c: &Checked,
    Entered { program, stack, at_home }: Entered,
    prepared: &mut Prepared,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Outside> {
    let places = c.places;
    let Prepared { evaluator, problem } = prepared;
    let rest = RestInputs::new(program);
    let moment = rest.at(Times::default());
    evaluator.enter(&program.robot.home, moment);
    if let Err(fault) = evaluator.update(&program.robot.home, moment, problem) {
        if !at_home && !anywhere(program, evaluator, &fault) {
            return None;
        }
        let place_of_start = if at_home { "at home" } else { "when its state is entered" };
        let text = Controller::for_stack(program, stack).map(Controller::without_enabling).map(|mut c| {
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
        let d = Diagnostic::error("HQ0502", at.unwrap_or(places.home), format!("{place_of_start}, {text}"));
        let joined = match fault {
            Fault::Overlap { member, row } => {
                let row = || std::iter::once(row);
                let member = evaluator.members().get(member);
                member.and_then(|m| neighbours(program, m, row()).or_else(|| exception(program, m, row())))
            }
            _ => None,
        };
        diagnostics.push(match (at.and(joined), fault) {
            (Some(help), Fault::Overlap { .. }) => d.help(help),
            (_, Fault::Value { at }) if evaluator.rate(at).is_none_or(|r| !r.is_finite()) => d
                .note("a target that jumps or starts infinitely fast asks for an infinite velocity in the first tick")
                .help(
                    "let the argument of a root, a logarithm or a power start above zero, as in `sqrt(t/(1 s) + 0.01)`",
                ),
            (_, Fault::Value { .. } | Fault::Gain { .. }) => d.help("keep the value inside its range from the start"),
            (_, Fault::Crossed { .. }) => d.help("move the two limits apart"),
            _ if at.is_some() => d.label(places.home, "the robot starts here").help("move the home configuration"),
            _ => d.help("move the home configuration"),
        });
        return None;
    }
    if at_home {
        undefined(evaluator, places, diagnostics);
    }
    if at_home && doubts(evaluator, (&program.robot.home, moment), places, diagnostics) {
        return None;
    }
    let mut outside = Outside { any: false, hard: false };
    for m in evaluator.members() {
        let rows = m.row_info.iter().zip(&evaluator.margins()[m.margins.clone()]);
        // Margins of velocities are infinite here, because no velocity has been chosen yet.
        let bad: Vec<String> = rows
            .filter(|(_, h)| **h < -MARGIN_TOLERANCE)
            .map(|(r, h)| format!("{} by {}", r.name, measured(-h, r.dimension)))
            .collect();
        let Some(first) = bad.first() else { continue };
        outside.any = true;
        if !at_home {
            continue;
        }
        let hard = program.stacks[stack].levels[m.level].hard;
        outside.hard |= hard;
        let more = if bad.len() > 1 { format!(" and {} more", bad.len() - 1) } else { String::new() };
        let text = format!("`{}` is violated at the start: {first}{more}", m.name);
        let at = limit(places, m.program_index);
        let mut d = match hard {
            true => Diagnostic::error("HQ0502", at, text)
                .label(places.home, "the robot starts here")
                .note("a barrier function keeps a limit only from inside"),
            false => Diagnostic::warning("HQ0502", at, text).label(places.home, "the robot starts here").note(
                match moves(problem, program, stack, m, &evaluator.margins()[m.margins.clone()]) {
                    true => "the level is soft: the robot first moves back inside, as far as the levels above allow",
                    false => "no joint of the stack changes this value at home, so the robot does not move back inside",
                },
            ),
        };
        if bad.len() > 1 {
            let shown = bad.iter().take(8).cloned().collect::<Vec<_>>().join(", ");
            let rest = bad.len().saturating_sub(8);
            d = d.note(format!(
                "violated are {shown}{}",
                if rest > 0 { format!(", .. ({rest} more)") } else { String::new() }
            ));
        }
        let rows = m.row_info.iter().zip(&evaluator.margins()[m.margins.clone()]).enumerate();
        let violated: Vec<usize> = rows.filter(|(_, (_, h))| **h < 0.0).map(|(row, _)| row).collect();
        let rows = || violated.iter().copied();
        diagnostics.push(
            if let Some(help) = neighbours(program, m, rows()).or_else(|| exception(program, m, rows())) {
                d.help(help)
            } else if m.kind == "virtual_wall" {
                d.help("move the home configuration or the wall; to keep the other side, swap two of the three points")
            } else {
                d.help("move the home configuration or the limit")
            },
        );
    }
    Some(outside)
}

/// True if a joint of the stack changes a violated row of a limit at home.
fn moves(problem: &Problem, program: &Program, stack: usize, member: &Member, margins: &[f64]) -> bool {
    let free = (0..program.robot.model.nv()).filter(|dof| !program.stacks[stack].locked.contains(dof));
    let free: Vec<usize> = free.collect();
    let violated = member.rows.clone().zip(margins).filter(|(_, h)| **h < -MARGIN_TOLERANCE);
    let level = &problem.levels[member.level];
    violated.map(|(r, _)| level.row(r)).any(|row| free.iter().any(|&dof| row[dof].abs() > STILL))
}

/// Warns of targets whose value is undefined at home.
fn undefined(evaluator: &Evaluator, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    for (m, _) in evaluator.members().iter().zip(evaluator.undefined()).filter(|(_, is)| **is) {
        let at = places.tasks[m.program_index].span;
        diagnostics.push(
            Diagnostic::warning("HQ0538", at, format!("the value of `{}` is undefined at home", m.name))
                .label(places.home, "the robot starts here")
                .note("its rows are left free there, so the task moves nothing until another one changes the posture")
                .help("start at a posture where the value exists, such as that of a bent arm"),
        );
    }
}

/// Reports what tasks take for granted and what is not so at home; returns true if rows cannot be met for this reason.
fn doubts(
    evaluator: &mut Evaluator,
    (home, moment): (&[f64], TickInputs),
    places: &SourceMap,
    diagnostics: &mut Vec<Diagnostic>,
) -> bool {
    let mut certain = false;
    for member in 0..evaluator.members().len() {
        let Some(doubt) = evaluator.doubt(member, home, moment) else { continue };
        certain |= doubt.certain;
        let at = place(places, evaluator.members()[member].program_index, &doubt.error.param);
        let text = doubt.error.message;
        let d = match doubt.certain {
            true => Diagnostic::error("HQ0508", at, text),
            false => Diagnostic::warning("HQ0508", at, text),
        };
        let d = d.label(places.home, "the robot starts here");
        diagnostics.push(match doubt.error.help {
            Some(help) => d.help(help),
            None => d,
        });
    }
    certain
}

/// Returns true if a fault at home occurs at every configuration: its numbers depend only on the time in the state.
fn anywhere(program: &Program, evaluator: &Evaluator, fault: &Fault) -> bool {
    let certain = |member: usize| {
        let slots = evaluator.members().get(member).map(|m| &m.slots);
        slots.is_some_and(|slots| slots.iter().all(|&at| entries::is_certain(program, at)))
    };
    match *fault {
        Fault::Value { at } => entries::is_certain(program, at),
        Fault::Crossed { member, .. } => certain(member),
        Fault::Gain { member } => {
            let task = evaluator.members().get(member).and_then(|m| program.tasks.get(m.program_index));
            let of_state = task.is_some_and(|t| matches!(t.params.get("gain"), Some(Bound::Expression(_))));
            certain(member) && !of_state
        }
        _ => false,
    }
}

/// Help for a hard level that cannot be met. Limits of joints are what the robot can do, so other tasks give way.
pub(super) fn relaxed(program: &Program, stack: usize, level: usize) -> &'static str {
    let levels = &program.stacks[stack].levels;
    let of_joints = |m: &MemberProgram| {
        let kind = program.tasks[m.task].kind.as_str();
        [joint_position_limits::KIND.name, joint_velocity_limits::KIND.name, joint_acceleration_limits::KIND.name]
            .contains(&kind)
    };
    let (own, above) = (&levels[level].members, levels[..level].iter().any(|l| l.hard));
    match (own.iter().any(of_joints), own.iter().all(of_joints)) {
        (true, true) if above => "relax the hard levels above: these limits are what the joints can do",
        (true, true) if level > 0 => "put these limits on the first level: they are what the joints can do",
        (true, true) => {
            "start inside of the limits of positions; those of velocities and accelerations hold from rest on"
        }
        (true, false) => "relax the other tasks of the level: the limits of joints are what the robot can do",
        _ => "relax the level, or remove `hard`",
    }
}

/// A stack after one tick at home.
struct FirstTick {
    controller: Controller,
    fault: Option<Fault>,
}

impl FirstTick {
    fn new(program: &Program, stack: usize) -> Option<FirstTick> {
        let mut controller = Controller::for_stack(program, stack).ok()?.without_enabling();
        let fault = controller.step(&Observation { time: 0.0, q: &program.robot.home }).fault;
        Some(FirstTick { controller, fault })
    }

    /// Reports a hard level that cannot be met; returns true if there is one. If the stack is not entered at home, this is
    /// the first tick of its part that holds everywhere.
    fn hard_levels(&self, c: &Checked, stack: usize, at_home: bool, diagnostics: &mut Vec<Diagnostic>) -> bool {
        let place = if at_home { "at home" } else { "wherever its state is entered" };
        let Status::Infeasible { level } = self.controller.solution().status else { return false };
        let text = self.fault.as_ref().map(|f| self.controller.describe(f)).unwrap_or_default();
        let d = Diagnostic::error("HQ0504", c.places.stacks[stack].1[level], format!("{place}, {text}"));
        let d = if at_home { d.label(c.places.home, "the robot starts here") } else { d };
        let (problem, members) = (self.controller.problem(), self.controller.evaluator().members());
        let x = &self.controller.solution().x;
        let d = contradictions::blame(c, &Unmet { problem, members, level, x }, d);
        diagnostics.push(d.note("a hard level has no slack, so the first tick would be a fault").help(
            if c.program.stacks[stack].levels[level].damping > 0.0 {
                "remove the level's `damping`: a damped level does not meet its rows exactly, and a hard level must"
            } else {
                relaxed(c.program, stack, level)
            },
        ));
        true
    }

    /// Warns of levels that the targets above, or locked joints, leave no freedom at home. Limits do not count: those that
    /// act at the first tick release the robot later.
    fn freedom(&self, c: &Checked, stack: usize, diagnostics: &mut Vec<Diagnostic>) {
        // A hard level that is infeasible at home may be feasible at the configuration where the stack is entered.
        if self.controller.solution().status != Status::Optimal {
            return;
        }
        let (program, places) = (c.program, c.places);
        let levels = &places.stacks[stack].1;
        let free = program.robot.model.nv().saturating_sub(program.stacks[stack].locked.len());
        let damped = |k: usize| program.stacks[stack].levels[..k].iter().any(|l| l.damping > 0.0);
        let above = fixed_above::fixed_at_home(c, stack).unwrap_or_default();
        for (k, level) in program.stacks[stack].levels.iter().enumerate() {
            let fixed = if damped(k) { free } else { above.get(k).copied().unwrap_or(0) };
            // A hard limit must hold, whatever is above.
            let idle =
                level.hard && level.members.iter().all(|m| places.tasks[m.task].kind.row_kind == RowKind::Inequality);
            if fixed < free || idle || level.members.is_empty() {
                continue;
            }
            let d =
                Diagnostic::warning("HQ0604", levels[k], format!("level `{}` has no freedom left at home", level.name));
            let d = if free == 0 || k == 0 {
                d.label(places.stacks[stack].0, "this stack locks every degree of freedom")
            } else {
                d.label(levels[k - 1], "this level and those above it fix every degree of freedom")
            };
            diagnostics.push(d.help(if damped(k) {
                "remove `damping` from the level above: a damped level uses all degrees of freedom"
            } else {
                "reduce the tasks of the levels above, or unlock joints"
            }));
            // The levels below have no freedom for the same reason.
            break;
        }
    }
}

/// Warns of limits whose reserve exceeds the margin at the start: they push the robot away from the first tick on.
fn reserves(evaluator: &Evaluator, program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    for (i, m) in evaluator.members().iter().enumerate() {
        let kept = evaluator.sampled_margin(i);
        let margins = &evaluator.margins()[m.margins.clone()];
        let rows = m.row_info.iter().zip(margins.iter().zip(&kept));
        let short: Vec<(&RowInfo, f64, f64)> =
            rows.filter(|(_, (h, k))| *h < *k && **h >= -MARGIN_TOLERANCE).map(|(r, (h, k))| (r, *h, *k)).collect();
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
            "`{}` starts inside its reserve: {} has a margin of {}, and its reserve is {}{more}",
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
            _ => "start further away, or reduce the reserve".to_string(),
        }));
    }
}

/// Help that makes the reserve fit the margin. The reserve grows with the square of the speeds and with the period.
fn smaller_reserve(margin: f64, reserve: f64, period: f64) -> String {
    let share = margin / reserve;
    if share < 1e-3 {
        return "start further away, lower the speed limits, raise the rate, or leave `sampled_margin` out, so that the limit looks ahead".to_string();
    }
    // Rounded so that the advice suffices.
    let slower = (share.sqrt() * 100.0).floor();
    let rate = (1.0 / (period * share)).ceil();
    format!(
        "start further away; or lower the speed limits of all joints to {slower} % of what they are, or raise the rate to \
         {rate} Hz, and the reserve is as small as the margin; or leave `sampled_margin` out, so that the limit looks ahead"
    )
}

/// Formats a length in mm, to a thousandth.
pub(crate) fn millimetres(x: f64) -> String {
    format!("{} mm", runtime::text::number((x * 1e3 * 1e3).round() / 1e3))
}

/// Formats a number with its unit, to three digits.
fn measured(x: f64, dimension: Dimension) -> String {
    shown(format!("{x:.2e}").parse().unwrap_or(x), dimension)
}

/// Help for a limit that keeps the parts of one side apart: pairs can be left out.
fn exception(program: &Program, member: &Member, mut rows: impl Iterator<Item = usize>) -> Option<Help> {
    let params = &program.tasks[member.program_index].params;
    let one_side = !params.contains_key("and") && params.values().any(|bound| matches!(bound, Bound::Pairs(_)));
    let (a, b) = member.row_info.get(rows.next()?)?.name.split_once(" to ").filter(|_| one_side)?;
    let [a, b] = [a, b].map(|name| name.split('[').next().unwrap_or(name));
    Some(Help::with(
        "move the home configuration, or keep a smaller distance; if the shapes of the two are larger than the links, leave \
         them out: {}",
        [Snippet::entry("except", format!("[[{a}, {b}]]"))],
    ))
}

/// Help for a collision limit between links connected by one joint: they touch at every configuration.
fn neighbours(program: &Program, member: &Member, rows: impl Iterator<Item = usize>) -> Option<Help> {
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
            let help = format!(
                "`{a}` and `{b}` are neighbours: one joint connects them, and they touch wherever the robot stands. Name \
                 links that are further apart"
            );
            return Some(Help::from(help));
        }
    }
    None
}
