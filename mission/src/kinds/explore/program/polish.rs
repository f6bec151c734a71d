//! A better plan with the same choices: the linear program that is left once the binaries are those of known motions.
//!
//! Of the sides on which a motion passes, the one with the largest margin is chosen, and of the robots that see the person, the one that sees
//! it best: a plan on a lattice is on many sides at once. Few of the rows are tight in a plan. The engine gets those that nearly are, and
//! then those that its points break, until a point breaks none.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::super::problem::Problem;
use super::{Binary, Present, Program, Trajectories, Visit};
use crate::engine::{Budget, Microlp, Milp, Model, Row};

/// Rounds in which rows are added.
const ROUNDS: usize = 12;
/// Slack (m) below which a row counts as nearly tight.
const NEAR: f64 = 0.05;
/// Tolerance (m) of a row: less than the distance that the program keeps beyond each constraint.
const BROKEN: f64 = 1e-6;

impl Program {
    /// The best motions that make the choices of the given ones; none: the engine finds none within a wall time.
    pub fn polished(
        &self,
        problem: &Problem,
        present: &Present,
        of: &Trajectories,
        time: Duration,
    ) -> Option<Trajectories> {
        let begun = Instant::now();
        let point = self.point(of);
        let choices = self.choices(of, &point, present)?;
        let (mut fixed, open) = self.with_choices(&choices);
        let (mut rows, mut others): (Vec<Row>, Vec<Row>) =
            open.into_iter().partition(|row| row.low == row.high || slack(row, &point) < NEAR);
        let values = (0..ROUNDS).find_map(|_| {
            let left = time.checked_sub(begun.elapsed())?;
            fixed.rows.clone_from(&rows);
            let budget = Budget { time: left, nodes: u64::MAX, gap: problem.planner.gap };
            let values = Microlp.solve(&fixed, &[], &budget).ok()?.values?;
            let (broken, kept): (Vec<Row>, Vec<Row>) =
                std::mem::take(&mut others).into_iter().partition(|row| slack(row, &values) < -BROKEN);
            others = kept;
            let ready = broken.is_empty();
            rows.extend(broken);
            ready.then_some(values)
        })?;
        let mut motions = self.trajectories(problem, present, &values);
        motions.visits.clone_from(&of.visits);
        Some(motions)
    }

    /// The values of all binaries that the motions choose; none: they meet no side of a group.
    fn choices(&self, of: &Trajectories, point: &[f64], present: &Present) -> Option<Vec<(usize, f64)>> {
        let margins: Vec<f64> = self.rows.iter().map(|rows| margin(rows, point)).collect();
        let robots = present.active.len();
        // Connections of a robot to another one are kept as they are, unless there are only these two.
        let mut best: BTreeMap<Binary, usize> = BTreeMap::new();
        for (index, (binary, _)) in self.binaries.iter().enumerate() {
            let group = match *binary {
                Binary::Visit(_) => continue,
                Binary::Link([_, member, step]) if member == robots => Binary::Link([0, member, step]),
                own => own.group(),
            };
            let known = best.entry(group).or_insert(index);
            if margins[index] > margins[*known] {
                *known = index;
            }
        }
        let chosen = |index: usize, binary: Binary| match binary {
            Binary::Visit([robot, target, step]) => of.visits.contains(&Visit { robot, target, step }),
            Binary::Link([_, member, _]) if member < robots => margins[index] >= -super::ROUNDING,
            _ => best.values().any(|best| *best == index),
        };
        let all = best.values().all(|index| {
            let optional = matches!(self.binaries[*index].0, Binary::Link([_, member, _]) if member < robots);
            optional || margins[*index] >= -super::ROUNDING
        });
        let value = |(index, (binary, column)): (usize, &(Binary, usize))| {
            (*column, f64::from(u8::from(chosen(index, *binary))))
        };
        all.then(|| self.binaries.iter().enumerate().map(value).collect())
    }

    /// The model without its rows and with its binaries as constants, and the rows that are left of it.
    fn with_choices(&self, choices: &[(usize, f64)]) -> (Model, Vec<Row>) {
        let mut known: Vec<Option<f64>> = vec![None; self.model.columns.len()];
        let mut fixed = Model { rows: Vec::new(), ..self.model.clone() };
        for (column, value) in choices {
            known[*column] = Some(*value);
            let of = &mut fixed.columns[*column];
            (of.low, of.high, of.integer) = (*value, *value, false);
        }
        let rows = self.model.rows.iter().filter_map(|row| {
            let sum: f64 = row.terms.iter().filter_map(|(column, factor)| Some(factor * known[*column]?)).sum();
            // A row that stands for a choice says nothing without it.
            if row.terms.iter().any(|(column, _)| known[*column] == Some(0.0)) {
                return None;
            }
            let terms: Vec<(usize, f64)> =
                row.terms.iter().filter(|(column, _)| known[*column].is_none()).copied().collect();
            (!terms.is_empty()).then_some(Row { terms, low: row.low - sum, high: row.high - sum })
        });
        (fixed, rows.collect())
    }
}

/// The least margin of rows of a choice at a point.
fn margin(rows: &[super::Side], point: &[f64]) -> f64 {
    let each = rows
        .iter()
        .map(|row| row.along.iter().map(|(column, factor)| factor * point[*column]).sum::<f64>() - row.bound);
    each.fold(f64::INFINITY, f64::min)
}

/// Distance of a point from the nearer bound of a row; negative: the row is broken.
fn slack(row: &Row, point: &[f64]) -> f64 {
    let value: f64 = row.terms.iter().map(|(column, factor)| factor * point[*column]).sum();
    (value - row.low).min(row.high - value)
}
