//! Arithmetic on typed values, and helps for operands that do not match.

use dsl::tree::BinaryOp;
use dsl::{Diagnostic, Span, Spanned};
use runtime::program::Op;
use stdlib_tasks::dimension::{Dimension, NONE};

use super::errors;
use super::helps::{help_for_kinds, help_for_sum};
use super::ops::{self, Mismatch};
use super::scope::Failed;
use super::{Axes, Kind, Lowering, Typed, frames};
use crate::units;

impl Lowering<'_> {
    /// Applies a unit, which is `factor` SI units.
    pub(super) fn scaled(
        &mut self,
        inner: Typed,
        factor: f64,
        dimension: Dimension,
        span: Span,
    ) -> Result<Typed, Failed> {
        if matches!(inner.kind, Kind::Rotation | Kind::Pose | Kind::Truth) {
            let text = format!("{} has no unit", inner.kind.describe());
            return self.fail(Diagnostic::error("HQ0304", span, text).help("leave the unit out"));
        }
        let Some(total) = inner.dimension.times(dimension) else {
            return self.fail(errors::unit_error(&units::UnitError::TooLarge, span));
        };
        let f = self.graph.number(factor);
        let nodes = inner.nodes.iter().map(|&n| self.graph.push(Op::Mul(n, f))).collect();
        Ok(Typed { dimension: total, nodes, bare: false, span, ..inner })
    }

    /// Applies a binary operator.
    pub(super) fn binary(&mut self, op: &Spanned<BinaryOp>, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Failed> {
        if !matches!(op.value, BinaryOp::Mul | BinaryOp::Div | BinaryOp::Pow) {
            self.angles_alike(&[a, b]);
        }
        let result = match op.value {
            BinaryOp::Add => ops::additive(self.graph, a, b, Op::Add, span),
            BinaryOp::Sub => ops::additive(self.graph, a, b, Op::Sub, span),
            BinaryOp::Mul => ops::multiply(self.graph, a, b, span),
            BinaryOp::Div => {
                if b.kind == Kind::Scalar && self.graph.constant(b.nodes[0]) == Some(0.0) {
                    return self.fail(
                        Diagnostic::error("HQ0309", b.span, "this divides by zero")
                            .here("zero")
                            .help("change the divisor"),
                    );
                }
                ops::divide(self.graph, a, b, span)
            }
            BinaryOp::Pow => return self.power(a, b, span),
            _ => return self.truth(op, a, b, span),
        };
        let (verb, what) = match op.value {
            BinaryOp::Add => ("add", "to"),
            BinaryOp::Sub => ("subtract", "from"),
            BinaryOp::Mul => ("multiply", "with"),
            _ => ("divide", "by"),
        };
        match result {
            Ok(x) => Ok(x),
            Err(Mismatch::Dimensions) => self.fail(
                errors::different(a, b, &format!("only like can be {verb}ed {what} like"), span)
                    .help(help_for_sum(a, b)),
            ),
            Err(Mismatch::Kinds) => self.fail(
                Diagnostic::error(
                    "HQ0304",
                    op.span,
                    format!("cannot {verb} {} and {}", a.kind.describe(), b.kind.describe()),
                )
                .label(a.span, a.kind.describe())
                .label(b.span, b.kind.describe())
                .help(help_for_kinds(op.value, a.kind, b.kind)),
            ),
            Err(Mismatch::Axes) if op.value == BinaryOp::Mul => {
                self.fail(frames::turned(a, b, span, self.scope.follows()))
            }
            Err(Mismatch::Axes) => self.fail(frames::different(a, b, span, self.scope.follows())),
            Err(Mismatch::TooLarge) => self.fail(errors::unit_error(&units::UnitError::TooLarge, span)),
        }
    }

    fn power(&mut self, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Failed> {
        let exponent = self.graph.constant(b.nodes[0]).filter(|_| b.kind == Kind::Scalar && b.dimension == NONE);
        if b.kind == Kind::Scalar && b.dimension != NONE {
            let d = Diagnostic::error("HQ0304", b.span, "an exponent has no unit").here(b.dimension.describe());
            return self.fail(
                d.help("a unit after an exponent belongs to the exponent: put the power in brackets, `(2^3) m`"),
            );
        }
        let (Kind::Scalar, Some(exponent)) = (a.kind, exponent) else {
            return self.fail(
                Diagnostic::error("HQ0304", span, "`^` raises a number to a constant whole number")
                    .help("for other powers of a bare number write `exp(y*log(x))`"),
            );
        };
        if exponent.fract() != 0.0 || exponent.abs() > 100.0 {
            return self.fail(
                Diagnostic::error(
                    "HQ0304",
                    b.span,
                    format!("the exponent {exponent} is not a whole number within -100 and 100"),
                )
                .help("for a root write `sqrt(x)`; for other powers of a bare number `exp(y*log(x))`"),
            );
        }
        let n = exponent as i32;
        let Some(dimension) = a.dimension.power(n) else {
            return self.fail(errors::unit_error(&units::UnitError::TooLarge, span));
        };
        let node = self.graph.push(Op::Powi(a.nodes[0], n));
        Ok(Typed { kind: Kind::Scalar, dimension, nodes: vec![node], bare: a.bare, axes: Axes::default(), span })
    }
}
