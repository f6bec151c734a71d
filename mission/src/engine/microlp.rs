//! The built-in engine: `microlp`, simplex with branch and bound in pure Rust. For small programs.

use microlp::{ComparisonOp, OptimizationDirection, Problem, SolveOptions, SolveOutcome, TerminationReason, Variable};

use crate::plan::Limit;

use super::{Answer, Budget, EngineError, Milp, Model};

/// `microlp` as a [`Milp`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Microlp;

impl Milp for Microlp {
    fn name(&self) -> &str {
        "microlp"
    }

    fn solve(&self, model: &Model, start: &[(usize, f64)], budget: &Budget) -> Result<Answer, EngineError> {
        let mut problem = Problem::new(OptimizationDirection::Minimize);
        let columns: Vec<Variable> = model
            .columns
            .iter()
            .map(|column| {
                if column.integer {
                    problem.add_integer_var(column.cost, (column.low as i32, column.high as i32))
                } else {
                    problem.add_var(column.cost, (column.low, column.high))
                }
            })
            .collect();
        for row in &model.rows {
            let terms: Vec<(Variable, f64)> = row.terms.iter().map(|(column, c)| (columns[*column], *c)).collect();
            if row.low == row.high {
                problem.add_constraint(terms, ComparisonOp::Eq, row.low);
                continue;
            }
            if row.low.is_finite() {
                problem.add_constraint(terms.clone(), ComparisonOp::Ge, row.low);
            }
            if row.high.is_finite() {
                problem.add_constraint(terms, ComparisonOp::Le, row.high);
            }
        }
        let mut options = SolveOptions::default();
        options.time_limit = Some(budget.time);
        options.node_limit = Some(budget.nodes);
        options.mip_gap = budget.gap / 4.0;
        if !start.is_empty() {
            options.warm_start = Some(start.iter().map(|(column, value)| (columns[*column], *value)).collect());
        }
        let outcome = problem.solve_with(options).map_err(|error| match error {
            microlp::Error::Infeasible => EngineError::Infeasible { engine: "microlp".into() },
            error => EngineError::Failed { engine: "microlp".into(), message: error.to_string() },
        })?;
        let stats = outcome.stats();
        let stopped = match outcome.termination_reason() {
            TerminationReason::TimeLimit => Some(Limit::Time),
            TerminationReason::NodeLimit => Some(Limit::Work),
            _ => None,
        };
        let (values, objective) = match &outcome {
            SolveOutcome::Solution(solution) => {
                (Some(columns.iter().map(|c| solution.var_value(*c)).collect()), Some(solution.objective()))
            }
            SolveOutcome::Interrupted(_) => (None, None),
        };
        let proven = if stopped.is_none() { objective } else { None };
        let bound = stats.best_bound.or(proven).unwrap_or(f64::NEG_INFINITY);
        Ok(Answer { values, bound: bound + model.offset, stopped, nodes: stats.nodes_solved })
    }
}
