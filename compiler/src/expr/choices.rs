//! Comparisons, truth values, and the choice `if(..)`.
//!
//! True is the number 1 and false the number -1, so a choice and a negation are one operation each. A comparison with
//! NaN is NaN.

use dsl::tree::{BinaryOp, Value};
use dsl::{Diagnostic, Span, Spanned};
use runtime::program::Op;
use stdlib_tasks::dimension::NONE;

use super::arguments::CallError;
use super::errors;
use super::helps::help_for_sum;
use super::scope::Failed;
use super::{Axes, Graph, Kind, Lowering, Typed, ops};
use crate::expr::constants::bare_angle;

impl Lowering<'_> {
    /// Warns of bare numbers beside an angle, which are read as angles.
    pub(super) fn angles_alike(&mut self, values: &[&Typed]) {
        let numbers = || values.iter().filter(|a| a.kind == Kind::Scalar);
        if let Some(angle) = numbers().map(|a| a.dimension).find(|d| d.is_number() && *d != NONE) {
            for a in numbers().filter(|a| a.bare && !ops::is_zero(self.graph, a)) {
                self.diagnostics.push(bare_angle(self.graph, a, angle));
            }
        }
    }

    fn is_truth(&mut self, a: &Typed) -> Result<(), Failed> {
        if a.kind == Kind::Truth {
            return Ok(());
        }
        let is = a.kind.describe();
        let text = format!("a truth value is needed here, and this is {is}");
        self.fail(
            Diagnostic::error("HQ0304", a.span, text).here(is).help("compare it with something, as in `x > 0.1 m`"),
        )
    }

    /// Lowers `not a`.
    pub(super) fn not(&mut self, inner: &Value, span: Span) -> Result<Typed, Failed> {
        let a = self.value(inner)?;
        self.is_truth(&a)?;
        Ok(Typed { nodes: vec![self.graph.push(Op::Neg(a.nodes[0]))], span, ..a })
    }

    /// Lowers a comparison, `and`, or `or`.
    pub(super) fn truth(&mut self, op: &Spanned<BinaryOp>, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Failed> {
        let (x, y) = (a.nodes[0], b.nodes[0]);
        let op = match op.value {
            BinaryOp::And | BinaryOp::Or => {
                let (left, right) = (self.is_truth(a), self.is_truth(b));
                left.and(right)?;
                if op.value == BinaryOp::And { Op::Select(x, y, x) } else { Op::Select(x, x, y) }
            }
            compared => {
                if let Some(bad) = [a, b].into_iter().find(|t| t.kind != Kind::Scalar) {
                    let is = bad.kind.describe();
                    let text = format!("only numbers have an order, and this is {is}");
                    let d = Diagnostic::error("HQ0304", op.span, text).label(bad.span, is);
                    return self.fail(d.help("compare one of its numbers, or its `norm`"));
                }
                if ops::joined(self.graph, a, b).is_none() {
                    let d = errors::different(a, b, "only like can be compared with like", span);
                    return self.fail(d.help(help_for_sum(a, b)));
                }
                match compared {
                    BinaryOp::Less => Op::Less(x, y),
                    BinaryOp::LessEqual => Op::LessEqual(x, y),
                    BinaryOp::Greater => Op::Less(y, x),
                    _ => Op::LessEqual(y, x),
                }
            }
        };
        Ok(Typed {
            kind: Kind::Truth,
            dimension: NONE,
            nodes: vec![self.graph.push(op)],
            bare: false,
            axes: Axes::default(),
            span,
        })
    }
}

/// Lowers `if(condition, value, other value)`. Both values have the same kind and dimension.
pub(super) fn choose(g: &mut Graph, args: &[Typed], span: Span) -> Result<Typed, CallError> {
    let (condition, a, b) = (&args[0], &args[1], &args[2]);
    if condition.kind != Kind::Truth {
        return Err(CallError::Argument { index: 0, wanted: "a condition such as `x > 0.1 m`".into() });
    }
    if a.kind != b.kind {
        return Err(CallError::Argument { index: 2, wanted: format!("{} on both sides", a.kind.describe()) });
    }
    let dimension = match a.kind {
        Kind::Rotation | Kind::Pose | Kind::Truth => NONE,
        _ => ops::joined(g, a, b).ok_or(CallError::Different { first: 1, second: 2 })?,
    };
    let axes = a.axes.joined(&b.axes).ok_or(CallError::Axes { first: 1, second: 2 })?;
    let nodes = a.nodes.iter().zip(&b.nodes).map(|(&x, &y)| g.push(Op::Select(condition.nodes[0], x, y))).collect();
    Ok(Typed { kind: a.kind, dimension, nodes, bare: a.bare && b.bare, axes, span })
}
