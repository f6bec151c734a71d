//! Warns of people who are assumed to be slower than people walk: 1.6 m/s in ISO 13855.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Span};
use runtime::program::{Lost, Program, SignalProgram, Velocity};
use stdlib_tasks::bound::{Bound, BoundParams, Slot};
use stdlib_tasks::dimension::VELOCITY;

use super::WALKING;
use crate::checks::reachability::in_stacks;
use crate::checks::{Checked, number, readings};
use crate::units::shown;

/// Growth (m/s) of an uncertainty below which nobody walks. Between two readings of a slow tracker, or of somebody who
/// sits, less than the walking speed can be enough.
const SLOWEST_GROWTH: f64 = 0.3;

/// Rounding of speeds that were converted.
const SLIP: f64 = 1e-6;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    declared(c, out);
    assumed(c, out);
}

/// A speed that is too small, and what follows.
struct Slow {
    at: Span,
    what: String,
    speed: f64,
    consequence: &'static str,
}

impl Slow {
    fn diagnostic(self) -> Diagnostic {
        let Slow { at, what, speed, consequence } = self;
        let text = match speed > 0.0 {
            true => format!("{what} is below the walking speed of people"),
            false => format!("{what} assumes that people stand still"),
        };
        Diagnostic::warning("HQ0542", at, text)
            .here(shown(speed, VELOCITY))
            .note(format!("people approach at 1.6 m/s (ISO 13855): {consequence}"))
            .help("write 1.6 m/s or more")
    }
}

/// Speeds in the declarations of people whom a limit concerns.
fn declared(c: &Checked, out: &mut Vec<Diagnostic>) {
    let read: BTreeSet<usize> = readings::limits(c.program).into_iter().flat_map(|(_, numbers)| numbers).collect();
    for human in &c.program.interface.humans {
        let signals: Vec<&SignalProgram> = readings::points(c.program, human).collect();
        let reads = |at: usize, len: usize| (at..at + len).any(|n| read.contains(&n));
        let Some(motion) = signals.first().and_then(|s| s.motion) else { continue };
        let Some(declared) = readings::human(c.expanded, &human.name) else { continue };
        let fast = motion.max_speed.filter(|_| motion.velocity != Velocity::None);
        let fast = fast.filter(|_| signals.iter().any(|s| reads(s.velocity_at(), 3)));
        let growth = match motion.lost {
            Lost::Hold(growth) if signals.iter().any(|s| reads(s.uncertainty_at(), 2)) => Some(growth),
            _ => None,
        };
        let speeds = [
            ("max_speed", fast, "a larger velocity is shortened to it, so the limits react to a slower person"),
            ("growth", growth, "a lost person may be further away from the last place than the limits assume"),
        ];
        for (key, speed, consequence) in speeds {
            let (Some(speed), Some(entry)) = (speed, declared.body.get(key)) else { continue };
            let least = if key == "growth" { SLOWEST_GROWTH } else { WALKING };
            if speed < least - SLIP {
                let what = format!("the `{key}` of `{}`", human.name);
                out.push(Slow { at: readings::entry(entry), what, speed, consequence }.diagnostic());
            }
        }
    }
}

/// Speeds that tasks assume.
fn assumed(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<Span> = BTreeSet::new();
    for task in in_stacks(c.program) {
        let t = &c.program.tasks[task];
        let Some(slot) = speed_of(&t.params) else { continue };
        let Some(speed) = constant(c.program, slot).filter(|v| *v < WALKING - SLIP) else { continue };
        let at = number(c.places, task, "human_speed", |n| n.slot.at == slot.at);
        if told.insert(at) {
            let what = format!("`{}`", t.name);
            let consequence = "who walks is nearer than assumed before the robot stands";
            out.push(Slow { at, what, speed, consequence }.diagnostic());
        }
    }
}

/// The assumed speed of a person, also in a group; `None` if the speed is measured.
fn speed_of(params: &BoundParams) -> Option<Slot> {
    if matches!(params.get("human"), Some(Bound::Choice(word)) if word == "measured") {
        return None;
    }
    params.iter().find_map(|(name, bound)| match bound {
        Bound::Value(slot) if name == "human_speed" => Some(*slot),
        Bound::Group(group) => speed_of(group),
        _ => None,
    })
}

/// Constant number of a slot.
fn constant(program: &Program, slot: Slot) -> Option<f64> {
    let moves = program.values.tape.outputs.iter().any(|o| o.at == slot.at);
    program.values.initial.get(slot.at).copied().filter(|_| !moves)
}
