//! Function of the distance in a safety field: a word, or a non-decreasing expression in `d`.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::program::Op;
use stdlib_tasks::dimension::{Dimension, LENGTH};
use stdlib_tasks::field::{DistanceFunction, DistanceProgram, ExpressionDistance};

use super::Lowerer;
use crate::expr::constants::Constants;
use crate::expr::functions_of_arguments::{Argument, Extracted};
use crate::expr::{Kind, Typed};
use crate::forms::text_of;
use crate::units::shown;

/// The distance, the argument of the function.
const D: Argument = Argument { name: "d", kind: Kind::Scalar, dimension: LENGTH, first: 0 };

impl Lowerer<'_> {
    /// Lowers the function of the distance, and returns it with the dimension of its value.
    pub(super) fn distance(&mut self, value: &Value) -> Option<(DistanceProgram, Dimension)> {
        match &value.kind {
            ValueKind::Name(_) if text_of(value) == Some("identity") => {
                return Some((DistanceProgram::Identity, LENGTH));
            }
            ValueKind::Call(function, args) if function.value == "saturating" => {
                let [reach] = args.as_slice() else {
                    let d = Diagnostic::error(
                        "HQ0310",
                        value.span,
                        "`saturating` takes the distance that it never exceeds",
                    );
                    self.push(d.help("write for instance `saturating(1.5 m)`"));
                    return None;
                };
                return self.positive_number(reach, LENGTH).map(|reach| (DistanceProgram::Saturating(reach), LENGTH));
            }
            _ => {}
        }
        let typed = self.function_of_distance(value)?;
        let node = typed.nodes[0];
        let (d, constant) = (D.node(&mut self.graph), |s: &Self, n| s.graph.constant(n));
        let reach = match self.graph.ops()[node] {
            _ if node == d => return Some((DistanceProgram::Identity, LENGTH)),
            Op::Min(a, b) if a == d => constant(self, b),
            Op::Min(a, b) if b == d => constant(self, a),
            _ => None,
        };
        if let Some(reach) = reach.filter(|r| *r > 0.0 && r.is_finite()) {
            return Some((DistanceProgram::Clamped(reach), LENGTH));
        }
        let written = self.written(&typed, value.span)?;
        self.never_falls(&written, typed.dimension, value.span)?;
        Some((DistanceProgram::Written(written), typed.dimension))
    }

    /// Types an expression in which `d` is the distance.
    fn function_of_distance(&mut self, value: &Value) -> Option<Typed> {
        let mut constants = Constants { graph: &mut self.graph, params: &mut self.params };
        let typed = constants.function(value, &[D], self.diagnostics)?;
        if typed.kind != Kind::Scalar {
            let is = typed.kind.describe();
            let d =
                Diagnostic::error("HQ0304", value.span, format!("a function of the distance is a number, not {is}"));
            self.push(d.help(Help::with(
                "write for instance {}, with `d` for the distance",
                [Snippet::entry("distance", "min(d, 2 m)")],
            )));
            return None;
        }
        Some(typed)
    }

    /// Operations of the function of the distance and of its derivative.
    fn written(&mut self, typed: &Typed, at: Span) -> Option<ExpressionDistance> {
        let value = typed.nodes[0];
        let slope = self.graph.rate(value);
        match Extracted::new(&self.graph, &[value, slope], &["d"], true, at) {
            Ok(Extracted { ops, index }) => {
                Some(ExpressionDistance { ops, value: index[&value], slope: index[&slope] })
            }
            Err(wrong) => {
                self.push(*wrong);
                None
            }
        }
    }

    /// Rejects a function that is undefined or decreasing at a distance from zero to a kilometre.
    fn never_falls(&mut self, function: &ExpressionDistance, dimension: Dimension, at: Span) -> Option<()> {
        let near = (0..=4000).map(|i| f64::from(i) * 0.005);
        let far = (1..=400).map(|i| 20.0 * (f64::from(i) * 0.01).exp());
        let mut before: Option<(f64, f64)> = None;
        let (mut rises, mut size) = (false, 0.0_f64);
        for d in near.chain(far) {
            let (value, slope) = function.evaluate(d);
            let here = shown((d * 1e3).round() / 1e3, LENGTH);
            if !value.is_finite() || !slope.is_finite() {
                let text = format!("this function of the distance has no value, or no derivative, at d = {here}");
                let d = Diagnostic::error("HQ0309", at, text);
                self.push(d.help(
                    "check for a root of zero, a division by zero, or a logarithm of a number that is not positive",
                ));
                return None;
            }
            size = size.max(value.abs());
            let last = before.map_or(value, |b| b.1);
            if slope < -1e-9 * (1.0 + size) || value < last - 1e-9 * (1.0 + size) {
                let text = format!("this function of the distance falls at d = {here}");
                let d = Diagnostic::error("HQ0523", at, text)
                    .here(format!("{} there, with the slope {}", shown(round(value), dimension), round(slope)))
                    .note("to raise such a field, the robot would move towards people");
                self.push(d.help("write one that rises with `d`, or stays the same where `d` is large: `min(d, 2 m)`"));
                return None;
            }
            rises |= value > last + 1e-12 * (1.0 + size);
            before = Some((d, value));
        }
        if !rises {
            let d = Diagnostic::error("HQ0523", at, "this function of the distance never rises");
            self.push(
                d.note("the field would be the same wherever people are")
                    .help("write an expression of `d`: `min(d, 2 m)`"),
            );
            return None;
        }
        Some(())
    }
}

/// Rounds to four digits, for messages.
fn round(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}
