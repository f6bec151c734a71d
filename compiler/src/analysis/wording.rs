//! Values that conditions read, in the words of the spec: `d = 0.15 m`, `norm(right_ft.force) = 4 N`.

use runtime::program::{Op, Program};
use stdlib_tasks::dimension::{Dimension, FORCE, MOMENT, NONE};

use super::conditions::{Key, Value};
use crate::expand::quantity;
use crate::expr::Graph;
use crate::units::shown;

/// Number of a signal, as an expression names it.
fn named(program: &Program, number: usize) -> Option<(String, Dimension)> {
    let signal = &program.interface.signals[program.interface.signal_of(number)?];
    let part = number.checked_sub(signal.at + 1).filter(|&i| i < signal.len)?;
    let axis = |i: usize| ["x", "y", "z"][i % 3];
    let name = &signal.name;
    Some(match (signal.kind.as_str(), signal.len) {
        ("wrench", _) if part < 3 => (format!("{name}.force.{}", axis(part)), FORCE),
        ("wrench", _) => (format!("{name}.moment.{}", axis(part)), MOMENT),
        ("flag", _) => (name.clone(), NONE),
        (kind, 1) => (name.clone(), quantity(kind)?.1?),
        (kind, 3) => (format!("{name}.{}", axis(part)), quantity(kind)?.1?),
        _ => return None,
    })
}

/// A node that has a name: a number of a signal, or the norm of a vector of one.
fn expression(graph: &Graph, program: &Program, node: usize) -> Option<(String, Dimension)> {
    match graph.ops()[node] {
        Op::Signal(k) => named(program, k),
        Op::Sqrt(sum) => {
            let (mut open, mut numbers) = (vec![sum], Vec::new());
            while let Some(n) = open.pop() {
                match graph.ops()[n] {
                    Op::Add(a, b) => open.extend([a, b]),
                    Op::Mul(a, b) if a == b => match graph.ops()[a] {
                        Op::Signal(k) => numbers.push(k),
                        _ => return None,
                    },
                    _ => return None,
                }
            }
            numbers.sort_unstable();
            let [x, y, z] = numbers[..] else { return None };
            let (name, dimension) = named(program, x)?;
            let vector = name.strip_suffix(".x").filter(|_| y == x + 1 && z == x + 2)?;
            Some((format!("norm({vector})"), dimension))
        }
        _ => None,
    }
}

/// A value of a condition in words; `None` if it has no short name.
pub(crate) fn described(key: &Key, value: Value, graph: &Graph, program: &Program) -> Option<String> {
    match (key, value) {
        (Key::Present(signal), Value::Truth(present)) => {
            let name = &program.interface.signals[*signal].name;
            Some(format!("`{name}` {}", if present { "present" } else { "absent" }))
        }
        (Key::Flag(term), Value::Truth(yes)) => match graph.ops()[term.node] {
            Op::Signal(k) => Some(format!("`{}` {yes}", named(program, k)?.0)),
            _ => None,
        },
        (Key::Number(terms), Value::Number(x)) => {
            let mut text = String::new();
            let mut dimension = NONE;
            for (i, (term, factor)) in terms.iter().enumerate() {
                let (name, of) = expression(graph, program, Some(term.node).filter(|n| *n < graph.ops().len())?)?;
                let factor = f64::from_bits(*factor);
                let size =
                    if factor.abs() == 1.0 { name } else { format!("{}*{name}", runtime::text::number(factor.abs())) };
                text.push_str(match (i, factor < 0.0) {
                    (0, false) => "",
                    (0, true) => "-",
                    (_, false) => " + ",
                    (_, true) => " - ",
                });
                text.push_str(&size);
                dimension = of;
            }
            Some(format!("`{text}` = {}", shown(x, dimension)))
        }
        _ => None,
    }
}
