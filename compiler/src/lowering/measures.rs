//! Errors that a bound task measures.

use stdlib_tasks::task::{Context, Measure};

use super::machine::MachineLowering;
use crate::binding::BoundTask;

impl MachineLowering<'_, '_> {
    /// Returns the errors that a task measures, by building it; `None` if that fails, which is reported elsewhere.
    pub(super) fn measures(&self, bound: &BoundTask) -> Option<Vec<Measure>> {
        let values = self.values_so_far();
        let model = &self.around.robot.model;
        let speed = vec![f64::INFINITY; model.nv()];
        let context =
            Context { model, values: &values, period: self.around.robot.period, speed: &speed, entry_speed: &speed };
        (bound.kind.build)(&bound.params, &context).ok().map(|task| task.measures())
    }

    /// Table of values with its constants; zero for all others.
    fn values_so_far(&self) -> Vec<f64> {
        self.lowerer.table.nodes.iter().map(|&n| self.lowerer.graph.constant(n).unwrap_or(0.0)).collect()
    }
}
