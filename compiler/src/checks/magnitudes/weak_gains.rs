//! Warns of gains that are too small to have an effect: of a target that the run ends long before, and of position limits
//! in whose whole range the joints creep.
//!
//! The error of a target falls as `exp(-g t)`. A joint at the distance h from its limit moves towards it with at most `φ h`.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::Built;
use runtime::program::{Op, Program};
use stdlib_tasks::bound::{Bound, BoundParams};
use stdlib_tasks::dimension::{ANGULAR_VELOCITY, RATE, TIME, VELOCITY};
use stdlib_tasks::task::RowKind;

use crate::checks::reachability::in_stacks;
use crate::checks::{Checked, number};
use crate::units::shown;

/// Part of the error's time constants that the run must have: in 0.2 of them the error falls by 18 %.
const ENOUGH: f64 = 0.2;

/// Duration (s) of a run that nothing bounds.
const A_MINUTE: f64 = 60.0;

/// Speeds above which the limit of a joint says nothing about how fast it is to move (m/s, rad/s): URDFs with 1000 rad/s are
/// common.
const USUAL_LINEAR: f64 = 1.0;
const USUAL_ANGULAR: f64 = 6.0;

/// Part of its speed limit that a joint in the middle of its range must be allowed.
const CREEPING: f64 = 0.2;

/// Warns of targets at rest that the gain cannot reach within the longest run.
pub(super) fn targets(c: &Checked, out: &mut Vec<Diagnostic>) {
    let scenarios = c.program.scenarios.iter().map(|s| s.run.duration);
    let runs = (!c.expanded.runs.is_empty()).then_some(c.program.run.duration);
    let longest = scenarios.chain(runs).reduce(f64::max);
    let duration = longest.unwrap_or(A_MINUTE);
    for task in in_stacks(c.program) {
        let kind = stdlib_tasks::find(&c.program.tasks[task].kind);
        if !kind.is_some_and(|k| k.row_kind == RowKind::Equality) || moves(c.program, &c.program.tasks[task].params) {
            continue;
        }
        let own = &c.places.tasks[task].numbers;
        for n in own.iter().filter(|n| n.written && n.dimension == RATE && n.slot.len == 1) {
            let Some(&gain) = c.program.values.initial.get(n.slot.at) else { continue };
            if gain <= 0.0 || gain * duration >= ENOUGH || out.iter().any(|d| d.primary.span == n.span) {
                continue;
            }
            let needs = shown(rounded(3.0 / gain), TIME);
            let name = &c.program.tasks[task].name;
            let has = match longest {
                Some(longest) => format!("the longest run has {}", shown(longest, TIME)),
                None => "no run is declared that long".to_string(),
            };
            out.push(
                Diagnostic::warning("HQ0551", n.span, format!("`{name}` needs {needs} for its target"))
                    .here(shown(gain, RATE))
                    .note(format!("the error falls to a third in {}, and {has}", shown(rounded(1.0 / gain), TIME)))
                    .help("a gain is one over the time constant: 2 /s for half a second"),
            );
        }
    }
}

/// True if a parameter other than a gain moves with time or a signal.
fn moves(program: &Program, params: &BoundParams) -> bool {
    let tape = &program.values.tape;
    let moving = |bound: &Bound| {
        bound.slots().iter().any(|s| {
            let own = s.at..s.at + s.len;
            tape.outputs.iter().any(|o| {
                let read = own.contains(&o.at).then(|| tape.only(&BTreeSet::from([o.at])));
                read.is_some_and(|t| {
                    t.ops.iter().any(|op| matches!(op, Op::T | Op::Time | Op::Signal(_) | Op::Trajectory(_)))
                })
            })
        })
    };
    params.values().any(moving)
}

/// Warns of position limits whose gain lets no joint move at a usual part of its speed, anywhere in its range.
pub(super) fn limits(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for (index, stack) in c.program.stacks.iter().enumerate() {
        let members = stack.levels.iter().flat_map(|l| &l.members);
        for (member, built) in members.zip(c.stacks.tasks(index)) {
            let Some(creep) = creeping(c.program, member.task, built).filter(|_| told.insert(member.task)) else {
                continue;
            };
            let dof = &c.program.robot.model.dofs[creep.dof];
            let speed = dof.unit.select(VELOCITY, ANGULAR_VELOCITY);
            let at = number(c.places, member.task, "gain", |n| n.dimension == RATE);
            let name = &c.program.tasks[member.task].name;
            out.push(
                Diagnostic::warning("HQ0551", at, format!("`{name}` lets the joints creep in their whole range"))
                    .here(shown(creep.gain, RATE))
                    .note(format!(
                        "in the middle of its range `{}` may move at {}, and its limit is {}",
                        dof.name,
                        shown(rounded(creep.speed), speed),
                        shown(dof.velocity, speed)
                    ))
                    .help(format!(
                        "write {} /s or more; the gain is one over the time in which a joint stops before its limit",
                        runtime::text::number(rounded(creep.gain * dof.velocity / creep.speed))
                    )),
            );
        }
    }
}

/// A joint that creeps, with the gain of its limit and its speed in the middle of its range.
struct Creep {
    dof: usize,
    gain: f64,
    speed: f64,
}

/// The first joint of a task that limits positions, if all of its joints creep.
fn creeping(program: &Program, task: usize, built: &Built) -> Option<Creep> {
    let kind = stdlib_tasks::find(&program.tasks[task].kind)?;
    // Limits of positions have both sides as parameters.
    let sides = ["lower", "upper"].iter().all(|side| kind.params.iter().any(|p| p.name == *side));
    let made = built.task.as_ref().ok().filter(|_| sides && kind.row_kind == RowKind::Inequality)?;
    let gain = *made.gains(&program.values.initial).first().filter(|g| **g > 0.0)?;
    let one = |dof: usize| {
        let d = program.robot.model.dofs.get(dof)?;
        let speed = 0.5 * gain * (d.upper - d.lower);
        let usual = d.velocity.min(d.unit.select(USUAL_LINEAR, USUAL_ANGULAR));
        (speed.is_finite() && d.velocity.is_finite()).then_some((speed, usual, Creep { dof, gain, speed }))
    };
    let all: Vec<_> = made.degrees_of_freedom()?.into_iter().filter_map(one).collect();
    all.iter().all(|(speed, limit, _)| *speed < CREEPING * limit).then(|| all.into_iter().next().map(|x| x.2))?
}

/// Two digits of a number.
fn rounded(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}
