//! Diagnostics of targets that the robot does not get to.

use dsl::{Diagnostic, Span};
use stdlib_tasks::dimension::{ANGLE, ANGULAR_VELOCITY, Dimension, LENGTH, NONE, VELOCITY};
use stdlib_tasks::task::RowKind;

use super::parts::Target;
use crate::analysis::postures::{Parts, Posture, PostureSearch, STARTS};
use crate::checks::{Checked, limit};
use crate::units::shown;

/// A target that is not met.
pub(super) struct Missed {
    stack: usize,
    /// Tasks of the limits that exclude it; none: it is out of reach.
    blamed: Vec<usize>,
    /// Error at the best posture, in words.
    error: String,
    /// Name of the measure with this error, such as `position`.
    measure: String,
    /// Time since the entry of the stack (s).
    t: f64,
    /// The manner in which it is not met.
    manner: Manner,
}

/// The manner in which a target is not met.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Manner {
    /// No posture meets it.
    Nowhere,
    /// Other postures meet it, and nothing moves at home.
    Stuck,
    /// At home it is half a turn away.
    HalfTurn,
}

impl Missed {
    /// A target that no posture meets.
    pub fn new(search: &PostureSearch, parts: &Parts, best: Posture, blamed: Vec<usize>, t: f64) -> Missed {
        let member = &search.members()[best.member];
        let (measure, dimension) = match member.row_kind {
            RowKind::Equality => {
                let measure = &member.measure_info[best.part];
                (measure.name.clone(), measure.dimension)
            }
            RowKind::Inequality => (String::new(), member.row_info[best.part].dimension),
        };
        Missed {
            stack: parts.stack,
            blamed,
            error: rounded(best.error, dimension),
            measure,
            t,
            manner: Manner::Nowhere,
        }
    }

    /// A target that nothing moves towards at home.
    pub fn stuck(search: &PostureSearch, parts: &Parts, at_home: Posture) -> Missed {
        Missed { manner: Manner::Stuck, ..Missed::new(search, parts, at_home, Vec::new(), 0.0) }
    }

    /// A target orientation that is half a turn away at home.
    pub fn half_turn(search: &PostureSearch, parts: &Parts, at_home: Posture) -> Missed {
        Missed { manner: Manner::HalfTurn, ..Missed::new(search, parts, at_home, Vec::new(), 0.0) }
    }

    /// Description of the search.
    fn note(&self) -> String {
        let at = if self.t > 0.0 { format!(", at t = {}", seconds(self.t)) } else { String::new() };
        format!(
            "searched from home and from {STARTS} random postures{at}: the nearest posture within the limits is {} off",
            self.error
        )
    }
}

/// Formats a velocity along a row: the rate of its value, or the value of a row of velocities.
pub(super) fn velocity(x: f64, dimension: Dimension) -> String {
    match dimension {
        VELOCITY => format!("{} mm/s", runtime::text::number((x * 1e3).round())),
        ANGULAR_VELOCITY => format!("{} deg/s", runtime::text::number((x.to_degrees() * 10.0).round() / 10.0)),
        other => format!("{}/s", rounded(x, other)),
    }
}

/// Formats an error, to a thousandth of a metre or degree.
pub(super) fn rounded(x: f64, dimension: Dimension) -> String {
    match dimension {
        LENGTH => format!("{} mm", runtime::text::number((x * 1e3).round())),
        ANGLE => format!("{} deg", runtime::text::number((x.to_degrees() * 10.0).round() / 10.0)),
        NONE => runtime::text::number((x * 1e3).round() / 1e3),
        other => shown((x * 1e3).round() / 1e3, other),
    }
}

pub(super) fn seconds(t: f64) -> String {
    format!("{} s", runtime::text::number((t * 100.0).round() / 100.0))
}

/// Span of a target: the parameter of the measure, or the only one that says where to go.
pub(super) fn place(c: &Checked, task: usize, measure: &str) -> Span {
    let t = &c.places.tasks[task];
    let own = measure.split('.').next().and_then(|p| t.spans.get(p));
    let usual = ["position", "target", "orientation", "angle"].iter().find_map(|p| t.spans.get(*p));
    own.or(usual).copied().unwrap_or(t.span)
}

/// Reports a target by itself.
pub(super) fn target(c: &Checked, missed: &Missed, target: &Target) -> Diagnostic {
    let (name, at) = (&c.program.tasks[target.member.task].name, place(c, target.member.task, &missed.measure));
    let names: Vec<String> = missed.blamed.iter().map(|&t| format!("`{}`", c.program.tasks[t].name)).collect();
    if missed.manner == Manner::HalfTurn {
        let text = format!("at home, the target of `{name}` is half a turn away");
        return half_turn(c, target.member.task, text).label(c.places.home, "the robot starts here");
    }
    if missed.manner == Manner::Stuck {
        return Diagnostic::warning("HQ0532", at, format!("at home, nothing moves `{name}` towards its target"))
            .label(c.places.home, "the robot starts here")
            .note(format!(
                "its error is {}, in a direction in which the joints move it by nothing at first order: a singular posture",
                missed.error
            ))
            .help("start at a posture with bent joints, or choose a target in another direction");
    }
    if names.is_empty() {
        let d = Diagnostic::warning("HQ0531", at, format!("no posture found at which `{name}` is at its target"));
        let d = match c.program.stacks[missed.stack].locked.is_empty() {
            true => d,
            false => d.label(c.places.stacks[missed.stack].0, "this stack locks joints"),
        };
        return d
            .note(missed.note())
            .help("choose a target within the joints' reach; positions are those in the world");
    }
    let text =
        format!("{} keep{} `{name}` from its target", names.join(" and "), if names.len() == 1 { "s" } else { "" });
    let mut d = Diagnostic::warning("HQ0530", at, text);
    for &task in &missed.blamed {
        d = d.label(limit(c.places, task), "without this limit the target is reached");
    }
    d.note(missed.note()).help("move the target to where the limits allow it, or change the limit")
}

/// Reports a target that is half a turn away where a state begins, after the targets of the state `from`, or else at home.
pub(super) fn half_turn_in_state(c: &Checked, task: usize, state: &str, from: Option<&str>) -> Diagnostic {
    let text = format!("in state `{state}`, the target of `{}` is half a turn away", c.program.tasks[task].name);
    let d = half_turn(c, task, text);
    match from {
        Some(from) => d.note(format!("seen from where the targets of state `{from}` leave the robot")),
        None => d.label(c.places.home, "seen from here, since it is not known where the state begins"),
    }
}

/// A warning of a target half a turn away.
fn half_turn(c: &Checked, task: usize, text: String) -> Diagnostic {
    let turns = c.program.tasks[task].params.contains_key("turns");
    Diagnostic::warning("HQ0536", place(c, task, "orientation"), text)
        .note("both ways round are equally long, so rounding decides which one the robot takes")
        .help(match turns {
            true => "write a target on the way first, or `turns exact` with the target on the side to which to turn",
            false => "write an orientation on the way first, or start at another one",
        })
}

/// Reports a limit that moves to where no posture keeps it.
pub(super) fn moving_limit(c: &Checked, missed: &Missed, task: usize) -> Diagnostic {
    let text = format!("no posture found that keeps `{}` at t = {}", c.program.tasks[task].name, seconds(missed.t));
    Diagnostic::warning("HQ0537", limit(c.places, task), text)
        .note(missed.note())
        .help("end the motion of the limit, for example with `smoothstep`, where the robot can still keep it")
}

/// Reports targets of one level that exclude each other.
pub(super) fn level(c: &Checked, missed: &Missed, level: usize, targets: &[&Target]) -> Diagnostic {
    let (span, stack) = (c.places.stacks[missed.stack].1[level], &c.program.stacks[missed.stack]);
    let text = format!("the targets of level `{}` exclude each other", stack.levels[level].name);
    let mut d = Diagnostic::warning("HQ0533", span, text);
    for target in targets {
        let name = &c.program.tasks[target.member.task].name;
        d = d.label(place(c, target.member.task, ""), format!("target of `{name}`"));
    }
    d.note(missed.note())
        .note("tasks of one soft level share the error by their weights: each of them stops short of its target")
        .help("put one of them on a level below, or give the tasks of a compromise different weights")
}
