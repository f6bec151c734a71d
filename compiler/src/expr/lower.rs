//! Lowers values of the syntax tree to typed expressions, and reports each mistake at its place.

use dsl::tree::{BinaryOp, Unit, Value, ValueKind};
use dsl::{Diagnostic, Help, Span};
use runtime::program::Op;
use stdlib_tasks::dimension::{Dimension, NONE};

use super::dimension_check::unit_of_some;
use super::errors;
use super::helps::{bracketed, for_list};
use super::scope::{Failed, Scope};
use super::{Axes, Graph, Kind, Typed, ops};
use crate::units;

/// Lowers values into a graph.
pub struct Lowering<'a> {
    /// Receives the nodes.
    pub graph: &'a mut Graph,
    /// Meaning of names.
    pub scope: &'a mut dyn Scope,
    /// Receives the diagnostics.
    pub diagnostics: &'a mut Vec<Diagnostic>,
}

impl Lowering<'_> {
    pub(super) fn fail<T>(&mut self, diagnostic: Diagnostic) -> Result<T, Failed> {
        self.diagnostics.push(diagnostic);
        Err(Failed)
    }

    /// Types a value and converts it to SI.
    ///
    /// # Errors
    /// The value has no type; the diagnostics report the reason.
    pub fn value(&mut self, value: &Value) -> Result<Typed, Failed> {
        let span = value.span;
        let scalar = |node: usize, dimension: Dimension, bare: bool| Typed {
            kind: Kind::Scalar,
            dimension,
            nodes: vec![node],
            bare,
            axes: Axes::default(),
            span,
        };
        match &value.kind {
            ValueKind::Missing => Err(Failed),
            ValueKind::Number(n) => Ok(scalar(self.graph.number(n.value), NONE, true)),
            ValueKind::Unit(inner, unit) => {
                let inner = match &inner.kind {
                    ValueKind::List(items) => self.list(items, inner.span, Some(unit))?,
                    _ => self.value(inner)?,
                };
                // The argument already had the warning for a bare angle.
                if units::is_assumed(unit) && !inner.bare {
                    return Ok(Typed { span, ..inner });
                }
                let (factor, dimension) = match units::meaning(unit) {
                    Ok(x) => x,
                    Err(e) => return self.fail(errors::unit_error(&e, unit.span)),
                };
                self.scaled(inner, factor, dimension, span)
            }
            ValueKind::Text(_) => self.fail(
                Diagnostic::error("HQ0304", span, "this is text, and a number is needed here")
                    .help(Help::each("write it without quotes", "write it without inner quotes")),
            ),
            ValueKind::Name(name) => self.name(name, span),
            ValueKind::Call(function, args) => self.call(function, args, span),
            ValueKind::Named(..) => self.fail(
                Diagnostic::error("HQ0214", span, "only an argument of a call has a name").help("leave the name out"),
            ),
            ValueKind::Field(inner, field) => self.field(inner, field, span),
            ValueKind::List(items) => self.list(items, span, None),
            ValueKind::Block(block) => {
                let d =
                    Diagnostic::error("HQ0304", span, "these are named values in braces, and a number is needed here");
                self.fail(match block.entries.as_slice() {
                    [one] if !["x", "y", "z"].contains(&one.key.value.as_str()) => {
                        d.help(format!("write its value alone, without `{}`", one.key.value))
                    }
                    _ => d.help("write a number, or `[x, y, z]` for a vector"),
                })
            }
            ValueKind::Negate(inner) => {
                let a = self.value(inner)?;
                if matches!(a.kind, Kind::Rotation | Kind::Pose) {
                    let text = format!("{} has no negative", a.kind.describe());
                    return self
                        .fail(Diagnostic::error("HQ0304", span, text).help("for the way back write `inverse(..)`"));
                }
                if a.kind == Kind::Truth {
                    let d = Diagnostic::error("HQ0304", span, "a truth value has no negative");
                    return self.fail(d.help("write `(not ..)` for its opposite"));
                }
                let nodes = a.nodes.iter().map(|&n| self.graph.push(Op::Neg(n))).collect();
                let axes = a.axes.scaled(Some(-1.0));
                Ok(Typed { nodes, axes, span, ..a })
            }
            ValueKind::In(inner, frame) => self.in_frame(inner, frame, span),
            ValueKind::Not(inner) => self.not(inner, span),
            ValueKind::Binary(op, left, right) => {
                let (a, b) = (self.value(left), self.value(right));
                let (a, b) = (a?, b?);
                let result = self.binary(op, &a, &b, span);
                // `2^2 m`: the unit was probably meant for the whole.
                let meant = bracketed(op.value, left, right).filter(|_| op.value == BinaryOp::Pow && result.is_err());
                if let (Some(meant), Some(d)) = (meant, self.diagnostics.last_mut()) {
                    d.help = Some(format!("a unit after an exponent belongs to the exponent: write `{meant}`").into());
                }
                result
            }
        }
    }

    fn list(&mut self, items: &[Value], span: Span, unit: Option<&Unit>) -> Result<Typed, Failed> {
        let typed: Vec<Result<Typed, Failed>> = items.iter().map(|i| self.value(i)).collect();
        let typed: Vec<Typed> = typed.into_iter().collect::<Result<_, _>>()?;
        if typed.len() != 3 {
            return self.fail(
                Diagnostic::error(
                    "HQ0310",
                    span,
                    format!("a vector has three numbers, and this list has {}", typed.len()),
                )
                .help(if unit.is_some() { "write `[x, y, z]`".to_string() } else { for_list(items) }),
            );
        }
        if let Some(bad) = typed.iter().find(|x| x.kind != Kind::Scalar) {
            return self.fail(
                Diagnostic::error("HQ0304", bad.span, format!("{} cannot be a part of a vector", bad.kind.describe()))
                    .help("a vector is made of three numbers"),
            );
        }
        let mut sum = typed[0].clone();
        for x in &typed[1..] {
            match ops::joined(self.graph, &sum, x) {
                Some(dimension) => sum.dimension = if ops::is_zero(self.graph, &sum) { x.dimension } else { dimension },
                None => {
                    let help = match unit_of_some(items).zip(unit) {
                        Some((own, unit)) => {
                            format!("`{own}` is the unit of one number, and `{unit}` that of the list: leave out one")
                        }
                        None => "give all three the same unit".to_string(),
                    };
                    return self
                        .fail(errors::different(&sum, x, "the parts of a vector have one unit", span).help(help));
                }
            }
            if !ops::is_zero(self.graph, x) {
                sum.nodes = x.nodes.clone();
                sum.span = x.span;
            }
        }
        let nodes = typed.iter().map(|x| x.nodes[0]).collect();
        Ok(Typed {
            kind: Kind::Vector,
            dimension: sum.dimension,
            nodes,
            bare: typed.iter().all(|x| x.bare),
            axes: Axes::default(),
            span,
        })
    }
}
