//! Targets of joints that the name of a posture stands for.

use dsl::tree::Value;
use stdlib_tasks::bound::Slot;

use super::Binder;
use crate::forms::KEY_SEPARATOR;

impl Binder<'_> {
    /// Joints of the posture that a value names, each with its place in the table: those that the posture leaves out stand where
    /// they are at home. `None` if the value names no posture, `Some(None)` if there is no such posture, which is reported.
    pub(super) fn posture(&mut self, value: &Value, key: Option<&str>) -> Option<Option<Vec<(usize, Slot)>>> {
        let robot = self.robot;
        // A parameter can stand for several keys.
        let key = key.filter(|key| !key.contains(KEY_SEPARATOR));
        let name = robot.postures.named_by(value, key, self.params)?;
        let positions = match robot.postures.positions(name, key, value.span) {
            Ok(positions) => positions,
            Err(d) => {
                self.diagnostics.push(*d);
                return Some(None);
            }
        };
        let mut targets = Vec::new();
        for position in positions {
            // A joint that the robot's `lock` holds has no target.
            let Some(dof) = robot.model.dof(&position.joint) else { continue };
            let Some(q) = robot.model.dofs[dof].q_index else { continue };
            let node = self.graph.number(position.value.unwrap_or(robot.home[q]));
            targets.push((dof, self.table.place(&[node])));
        }
        Some(Some(targets))
    }
}
