//! Warns of angles that jump behind the robot: limits of an `atan2` that its seam crosses, and targets of what is made of one.
//!
//! The error of a tracked `atan2`, alone or in a sum, is taken to the nearest turn. A margin has no nearest turn: the value
//! jumps by a turn at the seam, and the limit on its one side is violated at once by what was a large margin of the other.
//! Only limits on both sides, within the half turns of the `atan2`, keep the value away from its seam.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use dsl::Diagnostic;
use runtime::program::{Op, Program};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::expression::{Expression, Turning};
use stdlib_tasks::task::RowKind;

use super::{Checked, limit, place};
use crate::analysis::value_ranges::Ranges;
use crate::checks::reachability::in_stacks;
use crate::expr::{Interval, Typed};

/// Warns of each value that can jump, once.
pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    for task in in_stacks(c.program) {
        let (Some(program), Some(places)) = (c.program.tasks.get(task), c.places.tasks.get(task)) else { continue };
        let Some(Bound::Expression(value)) = program.params.get("value") else { continue };
        let turning = value.turning(&c.program.robot.model);
        let limits = places.kind.row_kind == RowKind::Inequality;
        let crosses = match turning {
            Turning::Steady | Turning::OnCircle => false,
            Turning::JumpsByTurns => limits && !confined(c, task, value),
            Turning::Jumps => true,
        };
        if !crosses {
            continue;
        }
        let jump =
            "an `atan2` jumps from 180 to -180 degrees where its point crosses the seam, `y` = 0 with a negative `x`";
        let at = place(c.places, task, "value");
        let d = Diagnostic::warning("HQ0528", at, format!("the angle that `{}` is about can jump", program.name));
        out.push(match turning {
            Turning::JumpsByTurns => d
                .label(limit(c.places, task), "a limit on one side of the jump")
                .note(format!("{jump}; behind it the limit is violated by up to a whole turn"))
                .help("write `min` and `max` within -180 and 180 degrees of the `atan2`; or turn its axes, so that the seam lies where the robot never is; or keep a number that does not jump, such as `angle_between(a, b)` or `dot(a, b)`"),
            _ => d
                .note(format!("{jump}; what is made of it here jumps by something else than a whole turn"))
                .help("use the `atan2` itself, in a sum at most; or a number that does not jump, such as `angle_between(a, b)`, `dot(a, b)`, or sine and cosine of the angle"),
        });
    }
}

/// Returns true if limits on both sides keep a value away from the jumps of its `atan2`.
fn confined(c: &Checked, task: usize, value: &Expression) -> bool {
    let Some(around) = between_jumps(c.program, value) else { return false };
    let side = |param: &str| c.places.tasks.get(task).and_then(|t| t.operands.get(param)).and_then(|t| range(c, t));
    let (Some(min), Some(max)) = (side("min"), side("max")) else { return false };
    around.low < min.low && max.high < around.high
}

/// Range of a number.
fn range(c: &Checked, typed: &Typed) -> Option<Interval> {
    let [node] = typed.nodes.as_slice() else { return None };
    Some(Ranges::new(c.context, &typed.nodes, &BTreeMap::new()).at(*node))
}

/// The values between two jumps of an `atan2`, with either sign and constants added; `None` for anything else.
fn between_jumps(program: &Program, value: &Expression) -> Option<Interval> {
    let constant = |op: usize| match *value.ops.get(op)? {
        Op::Const(x) => Some(x),
        Op::Input(k) => {
            let at = *value.inputs.get(k)?;
            let moves = program.values.tape.outputs.iter().any(|o| o.at == at);
            program.values.initial.get(at).copied().filter(|_| !moves)
        }
        _ => None,
    };
    let [mut op] = *value.outputs.as_slice() else { return None };
    // The value is `offset + sign * atan2`; operands come before their users, so that this ends.
    let (mut sign, mut offset) = (1.0, 0.0);
    loop {
        match *value.ops.get(op)? {
            Op::Atan2(..) => return Some(Interval::new(offset - PI, offset + PI)),
            Op::Neg(a) => (op, sign) = (a, -sign),
            Op::Add(a, b) | Op::Sub(a, b) if constant(a).is_none() => {
                let added = constant(b)? * if matches!(value.ops[op], Op::Sub(..)) { -1.0 } else { 1.0 };
                (op, offset) = (a, offset + sign * added);
            }
            Op::Add(a, b) => (op, offset) = (b, offset + sign * constant(a)?),
            Op::Sub(a, b) => {
                offset += sign * constant(a)?;
                (op, sign) = (b, -sign);
            }
            _ => return None,
        }
    }
}
