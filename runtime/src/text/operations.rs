//! Operations of expressions as text.

use super::number;
use crate::program::{Motion, Op, TrajectoryProgram};

/// Formats an operation; `sign` precedes the numbers of other operations.
pub(super) fn operation(op: &Op, sign: char) -> String {
    let r = |a: usize| format!("{sign}{a}");
    let of = |name: &str, a: usize| format!("{name} {}", r(a));
    let two = |a: usize, name: &str, b: usize| format!("{} {name} {}", r(a), r(b));
    match *op {
        Op::Const(x) => number(x),
        Op::T => "t".to_string(),
        Op::Time => "time".to_string(),
        Op::Input(k) => format!("captured {k}"),
        Op::State(k) => format!("state {k}"),
        Op::Signal(k) => format!("signal {k}"),
        Op::Trajectory(k) => format!("trajectory {k}"),
        Op::Add(a, b) => two(a, "+", b),
        Op::Sub(a, b) => two(a, "-", b),
        Op::Mul(a, b) => two(a, "*", b),
        Op::Div(a, b) => two(a, "/", b),
        Op::Neg(a) => format!("-{}", r(a)),
        Op::Sin(a) => of("sin", a),
        Op::Cos(a) => of("cos", a),
        Op::Asin(a) => of("asin", a),
        Op::Acos(a) => of("acos", a),
        Op::Atan2(a, b) => format!("atan2 {} {}", r(a), r(b)),
        Op::Exp(a) => of("exp", a),
        Op::Log(a) => of("log", a),
        Op::Sqrt(a) => of("sqrt", a),
        Op::Abs(a) => of("abs", a),
        Op::Powi(a, n) => format!("{} ^ {n}", r(a)),
        Op::Min(a, b) => format!("min {} {}", r(a), r(b)),
        Op::Max(a, b) => format!("max {} {}", r(a), r(b)),
        Op::Less(a, b) => two(a, "<", b),
        Op::LessEqual(a, b) => two(a, "<=", b),
        Op::Select(a, b, c) => format!("if {} >= 0 then {} else {}", r(a), r(b), r(c)),
    }
}

/// Formats a trajectory.
pub(super) fn trajectory(t: &TrajectoryProgram) -> String {
    let all = |list: &[usize]| list.iter().map(|o| format!("%{o}")).collect::<Vec<_>>().join(", ");
    let name = match t.motion {
        Motion::Trapezoid => "trapezoid",
        Motion::SCurve => "s_curve",
        Motion::Waypoints => "waypoints",
    };
    let numbers = t.numbers();
    let velocity = if t.velocity.is_empty() { String::new() } else { format!(" moving [{}]", all(&t.velocity)) };
    let turn = if t.turn { " by the nearest turn" } else { "" };
    format!(
        "trajectory {}..{}: {name} to [{}] within [{}] from [{}]{velocity}{turn}",
        numbers.start,
        numbers.end,
        all(&t.goals),
        all(&t.limits),
        all(&t.start)
    )
}
