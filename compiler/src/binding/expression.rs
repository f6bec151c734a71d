//! Parameters that are expressions of the robot's state: parts that depend on time alone go to the table of values, the
//! rest becomes a list of operations of its own.

use dsl::Diagnostic;
use dsl::tree::Value;
use runtime::program::ValueRange;
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::expression::Expression;
use stdlib_tasks::params::{Form, ParamInfo, Quantity};

use super::partition::partition;
use super::{Binder, Number, Owner};
use crate::expr::{Kind, Typed};

impl Binder<'_> {
    pub(super) fn expression(
        &mut self,
        owner: Owner,
        value: &Value,
        form: Form,
        info: &'static ParamInfo,
    ) -> Option<Bound> {
        let what = format!("`{}`", info.name);
        if let Form::Size(other) = form {
            let dimension = self.forms.get(other)?.1;
            let size = Quantity::at_least(dimension, 0.0).constant();
            return self.value(owner, value, (Kind::Scalar, dimension), Some(size), &what).map(Bound::Value);
        }
        let typed = self.typed(owner, value, true, true)?;
        let state = typed.nodes.iter().any(|&n| self.graph.is_state(n));
        let (wanted, quantity) = match form {
            Form::Value { orientation } => {
                self.good_value(&typed, value, orientation, state, info)?;
                self.forms.insert(info.name, (typed.kind, typed.dimension));
                self.axes.insert(info.name, typed.axes.clone());
                ((typed.kind, typed.dimension), None)
            }
            Form::Like(other) | Form::Size(other) => {
                if let Some(axes) = self.axes.get(other).cloned() {
                    self.expressed(&typed, &axes.to, true, &what)?;
                }
                (*self.forms.get(other)?, None)
            }
            Form::Number(q) => ((Kind::Scalar, q.dimension), Some(q)),
            Form::Vector(d) => {
                let axes = self.deviating.clone();
                self.expressed(&typed, &axes, true, &what)?;
                ((Kind::Vector, d), None)
            }
        };
        if matches!(form, Form::Value { .. } | Form::Like(_)) {
            self.operands.insert(info.name, typed.clone());
        }
        if !state {
            return self.allocate_slot(owner, value, &typed, (wanted, quantity), &what).map(Bound::Value);
        }
        self.check_type(&typed, value, wanted, &what)?;
        Some(Bound::Expression(self.of_state(&typed, value)))
    }

    /// Rejects a value that cannot be kept or tracked.
    fn good_value(
        &mut self,
        typed: &Typed,
        value: &Value,
        orientation: bool,
        state: bool,
        info: &ParamInfo,
    ) -> Option<()> {
        let good = matches!(typed.kind, Kind::Scalar | Kind::Vector)
            || (orientation && matches!(typed.kind, Kind::Rotation | Kind::Pose));
        if !good {
            let is = typed.kind.describe();
            let wanted =
                if orientation { "a number, a vector, an orientation or a pose" } else { "a number or a vector" };
            let d = Diagnostic::error("HQ0304", value.span, format!("`{}` is {wanted}, and this is {is}", info.name));
            self.diagnostics.push(d.here(is).help(match typed.kind {
                Kind::Pose => "keep its position, or a number of it: `.position.z`",
                Kind::Rotation => {
                    "keep a number that is made of it, such as `dot(frame(F).orientation*[0, 0, 1], [0, 0, 1])`"
                }
                _ => "name the number that the comparison is about, and its limit with `min` or `max`",
            }));
            return None;
        }
        if !state {
            let text = format!("`{}` does not depend on the robot's state, so no motion changes it", info.name);
            self.diagnostics.push(
                Diagnostic::error("HQ0313", value.span, text)
                    .note("`initial(..)` and params are constants, `t` is the time, and a link that does not move is a constant too")
                    .help("use `frame(F).position`, `frame(F).orientation`, `frame(F).pose`, `point(F, [..] m)`, `joint(J)`, `distance(a, b)` or `com` in it"),
            );
            return None;
        }
        Some(())
    }

    /// Expression of the state; its parts that depend on time alone are stored in the table of values.
    fn of_state(&mut self, typed: &Typed, value: &Value) -> Expression {
        let mut e = partition(self.graph, self.table, typed);
        for input in &mut e.inputs {
            let slot = self.table.place(&[*input]);
            self.numbers.push(Number { slot, dimension: NONE, span: value.span, written: true });
            self.table.ranges.push(ValueRange { at: slot.at, min: None, max: None, gain: false });
            *input = slot.at;
        }
        e
    }
}
