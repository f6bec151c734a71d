//! Warns of virtual masses, dampings and stiffnesses that do not fit each other, the period or a person's push.
//!
//! On one axis, with mass m, damping d, stiffness k and period T:
//!
//! ```text
//! m/d                     time constant without a spring
//! sqrt(k/m), d/(2 sqrt(m k))   natural frequency, damping ratio
//! f/d                     speed at which a steady push f leads the frame, without a spring
//! d/k                     time constant of the return, with much damping
//! ```
//!
//! The bounds are an order of magnitude away from what is used beside people.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Span};
use runtime::program::{Op, Program};
use stdlib_tasks::bound::{Bound, BoundParams, Slot};
use stdlib_tasks::dimension::{
    ANGULAR_DAMPING, ANGULAR_VELOCITY, DAMPING, Dimension, FORCE, INERTIA, MASS, MOMENT, STIFFNESS, TIME, VELOCITY,
};

use crate::checks::reachability::in_stacks;
use crate::checks::{Checked, number, place};
use crate::units::shown;

/// Smallest damping ratio: the motion halves its amplitude at every second swing.
const SMALLEST_RATIO: f64 = 0.15;

/// Longest time constant (s) of the way to the speed of a steady push, and of the return of a spring.
const LONGEST: f64 = 10.0;
const LONGEST_RETURN: f64 = 60.0;

/// A part of a pose: its names and the sizes that are usual beside people.
struct Part {
    name: &'static str,
    target: &'static str,
    dimensions: [Dimension; 3],
    /// Mass, damping, stiffness in the middle of what is usual.
    usual: [f64; 3],
    /// A light push, and the largest speed at which it may lead the frame.
    push: f64,
    push_dimension: Dimension,
    fastest: f64,
    speed_dimension: Dimension,
}

const PARTS: [Part; 2] = [
    Part {
        name: "linear",
        target: "position",
        dimensions: [MASS, DAMPING, STIFFNESS],
        usual: [10.0, 100.0, 800.0],
        push: 20.0,
        push_dimension: FORCE,
        fastest: 4.0,
        speed_dimension: VELOCITY,
    },
    Part {
        name: "angular",
        target: "orientation",
        dimensions: [INERTIA, ANGULAR_DAMPING, MOMENT],
        usual: [1.0, 10.0, 30.0],
        push: 2.0,
        push_dimension: MOMENT,
        fastest: 20.0,
        speed_dimension: ANGULAR_VELOCITY,
    },
];

/// Names of the groups of a body's numbers.
const GROUPS: [&str; 3] = ["mass", "damping", "stiffness"];

/// Constants of an axis, with the place of each in the table of values.
struct Axis {
    /// Mass, damping and stiffness; zero for none.
    numbers: [f64; 3],
    slots: [Option<usize>; 3],
}

/// A fault of an axis.
struct Wrong {
    text: String,
    note: &'static str,
    help: String,
    /// Index of the number to blame.
    at: usize,
}

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<Span> = BTreeSet::new();
    for task in in_stacks(c.program) {
        let params = &c.program.tasks[task].params;
        if !GROUPS[..2].iter().all(|g| matches!(params.get(*g), Some(Bound::Group(_)))) {
            continue;
        }
        for part in &PARTS {
            let found = (0..3).find_map(|axis| {
                let of = axis_of(c.program, params, part, axis)?;
                wrong(c, &of, part).or_else(|| unsprung(c, params, part, axis, &of)).map(|wrong| (of, wrong))
            });
            let Some((of, Wrong { text, note, help, at })) = found else { continue };
            let slot = of.slots[at];
            let mut span = number(c.places, task, GROUPS[at], |n| {
                slot.is_some_and(|s| n.slot.at <= s && s < n.slot.at + n.slot.len)
            });
            if span == Span::default() {
                span = place(c.places, task, GROUPS[at]);
            }
            // A size that is unusual by itself is reported already.
            if told.insert(span) && out.iter().all(|d| d.primary.span != span) {
                let shown_number = shown(of.numbers[at], part.dimensions[at]);
                out.push(
                    Diagnostic::warning("HQ0544", span, format!("`{}`: {text}", c.program.tasks[task].name))
                        .here(shown_number)
                        .note(note)
                        .help(help),
                );
            }
        }
    }
}

/// A constant, and its place in the table of values.
struct Constant {
    x: f64,
    at: usize,
}

/// Constant number of a group for one axis; `None` if it moves.
fn constant(program: &Program, group: &BoundParams, part: &Part, axis: usize) -> Option<Constant> {
    let Some(Bound::Value(Slot { at, len })) = group.get(part.name) else { return None };
    let at = at + if *len > 1 { axis } else { 0 };
    let moves = program.values.tape.outputs.iter().any(|o| o.at == at);
    program.values.initial.get(at).copied().filter(|_| !moves).map(|x| Constant { x, at })
}

/// Numbers of an axis; `None` if one of them moves.
fn axis_of(program: &Program, params: &BoundParams, part: &Part, axis: usize) -> Option<Axis> {
    let mut of = Axis { numbers: [0.0; 3], slots: [None; 3] };
    for (i, name) in GROUPS.iter().enumerate() {
        let Some(Bound::Group(group)) = params.get(*name) else { continue };
        let Constant { x, at } = constant(program, group, part, axis)?;
        (of.numbers[i], of.slots[i]) = (x, Some(at));
    }
    Some(of)
}

impl Axis {
    /// The number among some that is farthest from its usual size.
    fn farthest(&self, part: &Part, among: &[usize]) -> usize {
        let far = |i: usize| (self.numbers[i] / part.usual[i]).ln().abs();
        among.iter().copied().max_by(|&a, &b| far(a).total_cmp(&far(b))).unwrap_or_default()
    }
}

fn wrong(c: &Checked, of: &Axis, part: &Part) -> Option<Wrong> {
    let [mass, damping, stiffness] = of.numbers;
    let period = c.program.robot.period;
    if !(mass > 0.0 && damping > 0.0) {
        return None;
    }
    let time = |x: f64| shown(rounded(x), TIME);
    let of_mass = |x: f64| shown(rounded(x), part.dimensions[0]);
    let of_damping = |x: f64| shown(rounded(x), part.dimensions[1]);
    let constant = mass / damping;
    if constant < 0.1 * period {
        return Some(Wrong {
            text: format!("the time constant m/d of {} is far below the period of {}", time(constant), time(period)),
            note: "within one period the mass has no effect: the frame follows the noise of the sensor",
            help: format!("with this damping a mass from {} is felt", of_mass(damping * period)),
            at: of.farthest(part, &[0, 1]),
        });
    }
    if stiffness > 0.0 {
        let frequency = (stiffness / mass).sqrt();
        let ratio = damping / (2.0 * (mass * stiffness).sqrt());
        let critical = of_damping(2.0 * (mass * stiffness).sqrt());
        if frequency * period > 1.0 {
            return Some(Wrong {
                text: format!(
                    "the spring is too fast for the period: `T sqrt(k/m)` is {}",
                    runtime::text::number(rounded(frequency * period))
                ),
                note: "sampled at this period, mass and spring do not move like mass and spring; well below 1 they do",
                help: "lower the stiffness, or raise the mass or the rate".to_string(),
                at: of.farthest(part, &[0, 2]),
            });
        }
        if ratio < SMALLEST_RATIO {
            return Some(Wrong {
                text: format!("the damping ratio is {}", runtime::text::number(rounded(ratio))),
                note: "after a touch the frame swings for long; with a ratio of 1 it returns without overshooting",
                help: format!("with this mass and stiffness write a damping of {critical}"),
                at: of.farthest(part, &[0, 1, 2]),
            });
        }
        if damping / stiffness > LONGEST_RETURN {
            return Some(Wrong {
                text: format!("the spring needs {} for the return", time(damping / stiffness)),
                note: "the time constant of the return is d/k where the damping is large",
                help: "raise the stiffness, or lower the damping".to_string(),
                at: of.farthest(part, &[1, 2]),
            });
        }
        return None;
    }
    if constant > LONGEST {
        return Some(Wrong {
            text: format!("the frame needs {} to follow a push, and as long to come to rest", time(constant)),
            note: "without a spring the time constant is m/d",
            help: "lower the mass, or raise the damping".to_string(),
            at: of.farthest(part, &[0, 1]),
        });
    }
    let speed = part.push / damping;
    (speed > part.fastest).then(|| Wrong {
        text: format!(
            "a light push of {} leads the frame at {}",
            shown(part.push, part.push_dimension),
            shown(rounded(speed), part.speed_dimension)
        ),
        note: "a steady push leads it at f/d; only the limits of the joints would stop it",
        help: format!("write a damping of {} or more", of_damping(10.0 * part.push / part.fastest)),
        at: of.farthest(part, &[1]),
    })
}

/// A target that moves along an axis without a spring towards it.
fn unsprung(c: &Checked, params: &BoundParams, part: &Part, axis: usize, of: &Axis) -> Option<Wrong> {
    of.slots[2].filter(|_| of.numbers[2] == 0.0)?;
    let Some(Bound::Group(target)) = params.get("target") else { return None };
    let Some(Bound::Value(slot)) = target.get(part.target) else { return None };
    let tape = &c.program.values.tape;
    // An orientation has no axes of its own in the table.
    let own = if slot.len == 3 { slot.at + axis..slot.at + axis + 1 } else { slot.at..slot.at + slot.len };
    let moves = tape.outputs.iter().any(|o| own.contains(&o.at) && tape.ops[o.rate] != Op::Const(0.0));
    moves.then(|| Wrong {
        text: format!("the target moves, and without stiffness nothing pulls the frame to its {}", part.target),
        note: "the frame follows the velocity of the target only: after a push it stays beside the way for ever",
        help: "give the axis a stiffness, or guide the frame without a target".to_string(),
        at: 2,
    })
}

/// Two digits of a number.
fn rounded(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}
