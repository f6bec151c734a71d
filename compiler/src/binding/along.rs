//! Axes in which the values of a task are expressed: those of the world, or selected by other parameters of the task.

use dsl::Diagnostic;
use stdlib_tasks::bound::{Bound, BoundParams};
use stdlib_tasks::task::{Condition, CurrentValueType, ExpressedIn, TaskKind};

use super::robot_state::axes_of;
use super::{Binder, Owner};
use crate::expr::{Axes, Frame, Typed};

impl Binder<'_> {
    /// Records the axes of the task's own values, from the parameters that are bound so far. The axes of expressions
    /// are recorded when the expressions are bound.
    pub(super) fn own_axes(&mut self, kind: &'static TaskKind, bound: &BoundParams) {
        for a in kind.current_values.iter().filter(|a| !matches!(a.ty, CurrentValueType::Scalar(_))) {
            let frame = match a.expressed_in {
                ExpressedIn::World => Frame::World,
                ExpressedIn::Tip { arm, when, .. } => self.tip(arm, when, bound),
                ExpressedIn::SameAsParameter => continue,
            };
            // The difference between two tips has no origin.
            let origins = if matches!(a.expressed_in, ExpressedIn::World) { Some(1.0) } else { None };
            let axes = match a.ty {
                CurrentValueType::Vector(_) | CurrentValueType::Pose => Axes { origins, ..Axes::direction(frame) },
                _ => Axes::orientation(Frame::Any, frame),
            };
            self.axes.insert(a.name, axes);
        }
    }

    /// Axes of the arm's tip if all conditions in `when` hold, else those of the world; `Frame::Any` if a parameter was
    /// rejected, so that the conditions are unknown.
    fn tip(&self, arm: &str, when: &[Condition], bound: &BoundParams) -> Frame {
        let Some(Bound::Arm(arm)) = bound.get(arm) else { return Frame::Any };
        let mut all = true;
        for is in when {
            let holds = match (
                is,
                bound.get(match is {
                    Condition::Number(name, _) | Condition::Word(name, _) => *name,
                }),
            ) {
                (Condition::Number(_, x), Some(Bound::Value(slot))) => {
                    self.table.nodes.get(slot.at).and_then(|&n| self.graph.constant(n)).map(|n| n == *x)
                }
                (Condition::Word(_, word), Some(Bound::Choice(said))) => Some(said == word),
                _ => None,
            };
            match holds {
                Some(holds) => all &= holds,
                None => return Frame::Any,
            }
        }
        if all { axes_of(&self.robot.model, arm.tip) } else { Frame::World }
    }

    /// Axes that the target of a task's own value must have.
    pub(super) fn target_axes(&self, owner: Owner) -> Frame {
        let path = format!("{}{}", owner.prefix, owner.param);
        self.axes.get(path.as_str()).map_or(Frame::World, |a| a.to.clone())
    }

    /// Adds a note to the diagnostic of a value in the wrong axes, if another parameter determines the axes.
    pub(super) fn because(&self, owner: Owner, typed: &Typed, d: Diagnostic) -> Diagnostic {
        let path = format!("{}{}", owner.prefix, owner.param);
        let along = owner.kind.current_values.iter().find(|a| a.name == path).map(|a| a.expressed_in);
        let Some(ExpressedIn::Tip { text, .. }) = along else { return d };
        let wanted = self.target_axes(owner);
        let kind = if typed.kind == crate::expr::Kind::Rotation { "rpy(..)" } else { "[x, y, z] m" };
        let name = wanted.written();
        d.note(format!("`{path}` {text}")).help(format!(
            "write what it is along {}, `{kind} in {name}`, or bring it there as it is at the start, `initial((..) in {name})`",
            wanted.describe()
        ))
    }
}
