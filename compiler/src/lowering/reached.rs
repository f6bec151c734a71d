//! `reached(TASK, 5 mm, 2 deg, 1 mm/s)`: tolerances of a task's errors, and bounds on its speeds, by their units.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use quantities::usual::{ANGLE_TOLERANCE, TOLERANCE};
use runtime::program::{Op, Reached, ReachedProgram, SpeedBound};
use stdlib_tasks::dimension::{ANGLE, ANGULAR_VELOCITY, Dimension, LENGTH, NONE, RATE, VELOCITY};
use stdlib_tasks::task::{Measure, RowInfo, RowKind};

use super::machine::MachineLowering;
use super::measures::Measured;
use super::triggers;
use crate::binding::motion::TargetFlag;
use crate::expr::constants::Constants;
use crate::expr::{Kind, REACHED, Typed, unusual};

/// A number in the arguments, with its place.
struct Bound<'v> {
    typed: Typed,
    value: Option<f64>,
    written: &'v Value,
}

/// Task whose target is to be reached.
struct Target<'t> {
    name: &'t str,
    errors: Vec<Measure>,
    rows: Vec<RowInfo>,
    /// Span of the call.
    at: Span,
}

impl MachineLowering<'_, '_> {
    /// Lowers the arguments of `reached(..)`; `None` if they are wrong, with diagnostics.
    pub(super) fn reached(&mut self, args: &[Value], at: Span) -> Option<Reached> {
        let task = match triggers::task_of(args.first(), at, &self.around.tasks) {
            Ok(task) => task,
            Err(d) => {
                self.lowerer.push(*d);
                return None;
            }
        };
        let bound = self.around.bound.get(task)?.as_ref()?;
        if bound.kind.row_kind == RowKind::Inequality {
            let text = format!("`{}` is a limit, and has no target that could be reached", self.around.tasks[task]);
            let d = Diagnostic::error("HQ0703", args[0].span, text).label(bound.span, "declared here");
            self.lowerer.push(d.help(Help::with(
                "name a task with a target; for a limit write {}",
                [Snippet::entry("on", "fault(limit(TASK))")],
            )));
            return None;
        }
        let Measured { errors, rows } = self.measures(bound)?;
        let target = Target { name: self.around.tasks[task], errors, rows, at };
        let mut constants = Constants { graph: &mut self.lowerer.graph, params: &mut self.lowerer.params };
        let given: Option<Vec<_>> = (args[1..].iter())
            .map(|v| constants.constant(v, self.lowerer.diagnostics).map(|typed| (typed, v)))
            .collect();
        let bounds: Vec<Bound> = (given?.into_iter())
            .map(|(typed, written)| {
                let value = typed.nodes.first().and_then(|&n| self.lowerer.graph.constant(n));
                Bound { typed, value, written }
            })
            .collect();
        match target.criterion(task, &bounds) {
            Ok(criterion) => {
                self.lowerer.diagnostics.extend(bounds.iter().filter_map(Bound::unusual));
                Some(criterion)
            }
            Err(d) => {
                self.lowerer.push(*d);
                None
            }
        }
    }

    /// Lowers all calls of `reached` in a condition, each to a flag that the controller sets.
    pub(super) fn target_flags(&mut self, condition: &Value) -> Vec<TargetFlag> {
        let mut calls = Vec::new();
        collect(condition, &mut calls);
        let flag =
            |(value, args): (&Value, &[Value])| TargetFlag { span: value.span, node: self.target_flag(value, args) };
        calls.into_iter().map(flag).collect()
    }

    fn target_flag(&mut self, value: &Value, args: &[Value]) -> Option<usize> {
        let criterion = self.reached(args, value.span)?;
        let known = self.reached.iter().find(|r| r.criterion == criterion);
        let signal = known.map(|r| r.signal).unwrap_or_else(|| {
            let text = super::wording::call(value);
            let taken = |name: &str| self.lowerer.interface.signals.iter().any(|s| s.name == name);
            // Equal texts may have different numbers, in the copies of a repetition.
            let numbered = (2..).map(|k| format!("{text} {k}"));
            let name = std::iter::once(text.clone()).chain(numbered).find(|name| !taken(name)).unwrap_or(text.clone());
            let signal = self.lowerer.interface.declare_output(name, "flag");
            self.reached.push(ReachedProgram { signal, criterion });
            signal
        });
        Some(self.lowerer.graph.push(Op::Signal(self.lowerer.interface.signals[signal].at + 1)))
    }
}

/// Adds the calls of `reached` in a value.
fn collect<'v>(value: &'v Value, out: &mut Vec<(&'v Value, &'v [Value])>) {
    match &value.kind {
        ValueKind::Call(function, args) if function.value == REACHED => out.push((value, args)),
        _ => value.parts().into_iter().for_each(|part| collect(part, out)),
    }
}

impl Bound<'_> {
    /// True if it is a tolerance of errors of this dimension. A bare number is one of anything but angles.
    fn tolerates(&self, error: Dimension) -> bool {
        let Typed { kind, dimension, bare, .. } = self.typed;
        kind == Kind::Scalar && (error == dimension || (error != ANGLE && bare))
    }

    /// True if it bounds the rate of errors of this dimension. A row whose error is a velocity is no rate of it.
    fn slows(&self, error: Dimension) -> bool {
        ![VELOCITY, ANGULAR_VELOCITY].contains(&error)
            && self.typed.kind == Kind::Scalar
            && !self.typed.bare
            && error.times(RATE) == Some(self.typed.dimension)
    }

    fn unusual(&self) -> Option<Diagnostic> {
        let q = if self.typed.dimension == ANGLE { ANGLE_TOLERANCE } else { TOLERANCE };
        if self.typed.dimension != q.dimension {
            return None;
        }
        unusual(self.written, "a tolerance", &[self.value?], &q)
    }
}

impl Target<'_> {
    /// Returns the criterion that the arguments describe.
    fn criterion(&self, task: usize, given: &[Bound]) -> Result<Reached, Box<Diagnostic>> {
        for bound in given {
            let at = bound.written.span;
            let known = |f: &dyn Fn(&Measure) -> bool| self.errors.iter().any(f);
            let slows = known(&|m| bound.slows(m.dimension)) && self.rows.iter().any(|row| bound.slows(row.dimension));
            if !slows && !known(&|m| bound.tolerates(m.dimension)) {
                let text = format!("`{}` has no error of this dimension", self.name);
                let d = Diagnostic::error("HQ0301", at, text).here(bound.typed.dimension.describe());
                return Err(Box::new(d.help(self.form())));
            }
            if bound.value.is_some_and(|x| x <= 0.0) {
                let d = Diagnostic::error("HQ0308", at, "a tolerance must be more than zero");
                return Err(Box::new(
                    d.help("an error is rarely exactly zero: write the largest error that is acceptable"),
                ));
            }
        }
        let mut tolerances = Vec::with_capacity(self.errors.len());
        for m in &self.errors {
            let found = given.iter().find(|bound| bound.tolerates(m.dimension));
            if let Some(x) = found.and_then(|bound| bound.value) {
                tolerances.push(x);
                continue;
            }
            let name = if m.name.is_empty() { "its error".to_string() } else { format!("its error `{}`", m.name) };
            let d = Diagnostic::error("HQ0703", self.at, format!("`reached` has no tolerance for {name}"));
            return Err(Box::new(d.note(format!("it is {}", m.dimension.describe())).help(self.form())));
        }
        Ok(Reached { task, tolerances, speeds: self.speeds(given)? })
    }

    /// Returns the bounds on the speeds of the rows. A number in the unit of an error is its tolerance.
    fn speeds(&self, given: &[Bound]) -> Result<Vec<SpeedBound>, Box<Diagnostic>> {
        let mut speeds: Vec<SpeedBound> = Vec::new();
        for bound in given.iter().filter(|b| !self.errors.iter().any(|m| b.tolerates(m.dimension))) {
            let rows = self.rows.iter().enumerate().filter(|(_, row)| bound.slows(row.dimension));
            let rows: Vec<usize> = rows.map(|(i, _)| i).collect();
            let Some(most) = bound.value.filter(|_| !rows.is_empty()) else { continue };
            if speeds.iter().any(|s| s.rows == rows) {
                let d = Diagnostic::error("HQ0310", bound.written.span, "a second bound of this unit");
                return Err(Box::new(d.help(self.form())));
            }
            speeds.push(SpeedBound { rows, most });
        }
        Ok(speeds)
    }

    /// Help with a call that fits the task.
    fn form(&self) -> String {
        let (mut units, mut speeds): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
        for m in &self.errors {
            let (unit, speed) = match m.dimension {
                LENGTH => ("5 mm", Some("1 mm/s")),
                ANGLE => ("2 deg", Some("1 deg/s")),
                VELOCITY => ("5 mm/s", None),
                ANGULAR_VELOCITY => ("2 deg/s", None),
                NONE => ("0.01", None),
                _ => ("a tolerance in its unit", None),
            };
            if !units.contains(&unit) {
                units.push(unit);
                speeds.extend(speed);
            }
        }
        let call = |bounds: &[&str]| format!("`reached({}, {})`", self.name, bounds.join(", "));
        match speeds.as_slice() {
            [] => format!("write {}", call(&units)),
            _ => format!(
                "write {}, or {} for one that is at rest too",
                call(&units),
                call(&[units.clone(), speeds].concat())
            ),
        }
    }
}
