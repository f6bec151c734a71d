//! Parameters that are expressions of the robot's state: parts that depend on time alone go to the table of values, the
//! rest becomes a list of operations of its own.

use dsl::Diagnostic;
use dsl::tree::{Value, ValueKind};
use runtime::program::ValueRange;
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::expression::{Expression, Op};
use stdlib_tasks::kinds::keep;
use stdlib_tasks::params::{Form, ParamInfo, Quantity};
use stdlib_tasks::task::RowKind;

use super::partition::partition;
use super::{Binder, Number, Owner};
use crate::expr::constants::with_units;
use crate::expr::{Kind, Typed};

/// A vector of limits of which some are `none`.
struct OpenSides {
    /// The vector with zero in place of each `none`.
    closed: Value,
    /// The numbers that are `none`.
    numbers: Vec<usize>,
}

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
            if value.word() == Some("auto") && !self.params.knows("auto") {
                return Some(Bound::Choice("auto".to_string()));
            }
            let dimension = self.forms.get(other)?.1;
            let size = Quantity::at_least(dimension, 0.0).constant();
            return self.value(owner, value, (Kind::Scalar, dimension), Some(size), &what).map(Bound::Value);
        }
        let open = match form {
            Form::Like(_) if owner.kind.row_kind == RowKind::Inequality => self.open_sides(value, info)?,
            _ => None,
        };
        let mut typed = self.typed(owner, open.as_ref().map_or(value, |open| &open.closed), true, true)?;
        if let Form::Like(_) = form {
            self.turn_near(owner, &mut typed);
        }
        for &i in open.iter().flat_map(|open| &open.numbers) {
            if let Some(node) = typed.nodes.get_mut(i) {
                *node = self.graph.number(if info.name == "min" { -keep::OPEN } else { keep::OPEN });
            }
        }
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

    /// Finds `none` among the numbers of a vector of limits.
    fn open_sides(&mut self, value: &Value, info: &ParamInfo) -> Option<Option<OpenSides>> {
        let is_none = |item: &Value| {
            let word = match &item.kind {
                ValueKind::Unit(inner, _) => inner.word(),
                _ => item.word(),
            };
            word == Some("none") && !self.params.knows("none")
        };
        let Some(mut items) = with_units(value) else { return Some(None) };
        let numbers: Vec<usize> = items.iter().enumerate().filter(|(_, item)| is_none(item)).map(|(i, _)| i).collect();
        if numbers.is_empty() {
            return Some(None);
        }
        if numbers.len() == items.len() {
            let text = format!("no number of `{}` is a limit", info.name);
            let d = Diagnostic::error("HQ0304", value.span, text);
            self.diagnostics.push(d.help(format!("remove `{}`, or write a limit in place of one `none`", info.name)));
            return None;
        }
        for &i in &numbers {
            // Zero has any unit.
            items[i].kind = ValueKind::Number(dsl::tree::Number { value: 0.0, text: "0".to_string() });
        }
        Some(Some(OpenSides { closed: Value { kind: ValueKind::List(items), span: value.span }, numbers }))
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
        let always = always_read(&e);
        for (input, always) in e.inputs.iter_mut().zip(always) {
            let slot = self.table.place(&[*input]);
            self.numbers.push(Number { slot, dimension: NONE, span: value.span, written: true });
            // The branch of an `if` that is not chosen has no value where a signal is absent. If the branch is chosen, a number
            // that is not finite shows in the rows of the task.
            if always {
                self.table.ranges.push(ValueRange { at: slot.at, min: None, max: None, gain: false });
            }
            *input = slot.at;
        }
        e
    }
}

/// For each input of an expression, true if its value counts whichever branches are chosen.
fn always_read(e: &Expression) -> Vec<bool> {
    let mut read = vec![false; e.ops.len()];
    for &output in &e.outputs {
        read[output] = true;
    }
    let mut inputs = vec![false; e.inputs.len()];
    // Operands precede their users. A leaf that reads operations, such as the distance to a person, is a user of them.
    for i in (0..e.ops.len()).rev() {
        if !read[i] {
            continue;
        }
        match e.ops[i] {
            Op::Input(k) => inputs[k] = true,
            Op::Select(test, ..) => read[test] = true,
            op => op.operands().iter().flatten().for_each(|&o| read[o] = true),
        }
        if let Op::State(k) = e.ops[i] {
            let mut at = 0;
            for leaf in &e.leaves {
                if (at..at + leaf.width()).contains(&k) {
                    leaf.reads().iter().flatten().for_each(|&o| read[o] = true);
                }
                at += leaf.width();
            }
        }
    }
    inputs
}
