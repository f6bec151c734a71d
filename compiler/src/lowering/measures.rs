//! Errors and rows of a bound task.

use stdlib_tasks::task::{Context, Measure, RowInfo};

use super::machine::MachineLowering;
use crate::binding::BoundTask;

/// Numbers that a task computes at every tick.
pub(super) struct Measured {
    /// Its errors.
    pub errors: Vec<Measure>,
    /// Its rows.
    pub rows: Vec<RowInfo>,
}

impl MachineLowering<'_, '_> {
    /// Returns the errors and the rows of a task, by building it; `None` if that fails, which is reported elsewhere.
    pub(super) fn measures(&self, bound: &BoundTask) -> Option<Measured> {
        let values = self.values_so_far();
        let model = &self.around.robot.model;
        let speed = vec![f64::INFINITY; model.nv()];
        let context =
            Context { model, values: &values, period: self.around.robot.period, speed: &speed, entry_speed: &speed };
        let task = (bound.kind.build)(&bound.params, &context).ok()?;
        Some(Measured { errors: task.measures(), rows: task.rows() })
    }

    /// Table of values with its constants; zero for all others.
    fn values_so_far(&self) -> Vec<f64> {
        self.lowerer.table.nodes.iter().map(|&n| self.lowerer.graph.constant(n).unwrap_or(0.0)).collect()
    }
}
