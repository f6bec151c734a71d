//! The rows to blame where a hard level cannot be met: labels on the tasks of a smallest set of rows that contradict each other.

use std::collections::BTreeMap;

use dsl::Diagnostic;
use runtime::Member;
use solver::Problem;
use solver::contradiction::{RowIndex, contradiction};
use stdlib_tasks::dimension::{
    ACCELERATION, ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, Dimension, LENGTH, VELOCITY,
};

use super::{Checked, limit};
use crate::units::shown;

/// A hard level that could not be met.
pub(super) struct Unmet<'p> {
    /// The problem.
    pub problem: &'p Problem,
    /// Tasks that wrote its rows.
    pub members: &'p [Member],
    /// Index of the level.
    pub level: usize,
    /// Its compromise: the velocities that violate its rows least.
    pub x: &'p [f64],
}

/// Labels the tasks that take part.
pub(super) fn blame(c: &Checked, unmet: &Unmet, mut d: Diagnostic) -> Diagnostic {
    let Unmet { problem, members, level, x } = *unmet;
    let mut of_tasks: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for RowIndex { level, row } in contradiction(problem, level, x) {
        let owner = members.iter().find(|m| m.level == level && m.rows.contains(&row));
        let Some((m, info)) = owner.and_then(|m: &Member| Some((m, m.row_info.get(row - m.rows.start)?))) else {
            continue;
        };
        let (lower, upper) = (problem.levels[level].lower[row], problem.levels[level].upper[row]);
        let asked = |x: f64| rate(x, info.dimension);
        let asks = match (lower.is_finite(), upper.is_finite()) {
            (true, true) if lower == upper => format!("exactly {}", asked(lower)),
            (true, true) => format!("{} to {}", asked(lower), asked(upper)),
            (true, false) => format!("at least {}", asked(lower)),
            _ => format!("at most {}", asked(upper)),
        };
        of_tasks.entry(m.program_index).or_default().push(format!("{}: {asks}", info.name));
    }
    if of_tasks.is_empty() {
        return d;
    }
    for (&task, rows) in &of_tasks {
        let more = match rows.len() - 1 {
            0 => String::new(),
            1 => ", and one more row".to_string(),
            n => format!(", and {n} more rows"),
        };
        d = d.label(limit(c.places, task), format!("{}{more}", rows[0]));
    }
    d.note("the labelled rows contradict each other; without any one of them, the others can be met")
}

/// Formats the bound of a row, which is a velocity whatever the row limits, to three digits.
fn rate(x: f64, dimension: Dimension) -> String {
    let x = format!("{x:.2e}").parse().unwrap_or(x);
    match dimension {
        LENGTH | VELOCITY | ACCELERATION => shown(x, VELOCITY),
        ANGLE | ANGULAR_VELOCITY | ANGULAR_ACCELERATION => shown(x, ANGULAR_VELOCITY),
        other => format!("{}/s", shown(x, other)),
    }
}
