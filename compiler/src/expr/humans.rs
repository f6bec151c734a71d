//! People in expressions: their tracked points, with velocity and uncertainty.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};
use stdlib_tasks::dimension::LENGTH;

use super::scope::{Failed, Meaning};
use super::{Axes, Kind, Lowering, Typed};
use crate::expr::constants::Human;
use crate::forms::{target, written};

/// Suffix of a point for its velocity, `operator.chest.velocity`.
const VELOCITY: &str = "velocity";

/// Name of the symbol for a human's point or its velocity. Users cannot write it.
pub(crate) fn symbol(human: &str, point: &str, velocity: bool) -> String {
    format!("{human}.#{point}{}", if velocity { ".#velocity" } else { "" })
}

/// Name of the symbol for the value of a safety field. Users cannot write it.
pub(crate) fn field_symbol(field: &str) -> String {
    format!("{field}.#field")
}

impl Lowering<'_> {
    fn human(&mut self, value: &Value) -> Option<(String, Human)> {
        let ValueKind::Name(name) = &value.kind else { return None };
        match self.scope.name(name) {
            Meaning::Human(human) => Some((name.clone(), human)),
            _ => None,
        }
    }

    /// True for the name of a declaration with a reported error.
    fn is_failed(&mut self, value: &Value) -> bool {
        matches!(&value.kind, ValueKind::Name(name) if matches!(self.scope.name(name), Meaning::Failed))
    }

    /// Lowers `operator.chest` and `operator.chest.velocity`, if the first name is that of a human.
    pub(super) fn tracked(
        &mut self,
        inner: &Value,
        field: &Spanned<String>,
        span: Span,
    ) -> Option<Result<Typed, Failed>> {
        if self.is_failed(inner) {
            return Some(Err(Failed));
        }
        if let Some((name, human)) = self.human(inner) {
            return Some(
                self.point_of(&name, &human, field)
                    .and_then(|point| self.known(&symbol(point, &field.value, false), span)),
            );
        }
        let ValueKind::Field(outer, point) = &inner.kind else { return None };
        if self.is_failed(outer) {
            return Some(Err(Failed));
        }
        if field.value != VELOCITY {
            return None;
        }
        let (name, human) = self.human(outer)?;
        Some(self.point_of(&name, &human, point).and_then(|name| self.known(&symbol(name, &point.value, true), span)))
    }

    /// Name of the human in the program, if it has the point.
    fn point_of<'n>(&mut self, name: &'n str, human: &Human, point: &Spanned<String>) -> Result<&'n str, Failed> {
        if human.points.iter().any(|p| p.0 == point.value) {
            return Ok(target(name));
        }
        let names = human.points.iter().map(|p| p.0.as_str());
        let d = Diagnostic::unknown_name(point.span, format!("`{}` has no point `{}`", written(name), point.value));
        self.fail(d.one_of("its points are", &point.value, names))
    }

    fn known(&mut self, symbol: &str, span: Span) -> Result<Typed, Failed> {
        match self.scope.name(symbol) {
            Meaning::Value(symbol) => Ok(Typed { span, ..symbol.value }),
            _ => Err(Failed),
        }
    }

    /// One number for each point of `operator`, or for the point `operator.chest`; `None` if `who` is not a human.
    pub(super) fn numbers_of_human(
        &mut self,
        who: &Value,
        number: impl Fn(&(String, usize, usize)) -> usize,
    ) -> Option<Result<Vec<usize>, Failed>> {
        if let Some((_, human)) = self.human(who) {
            return Some(Ok(human.points.iter().map(number).collect()));
        }
        let ValueKind::Field(outer, point) = &who.kind else { return None };
        if self.is_failed(outer) {
            return Some(Err(Failed));
        }
        let (name, human) = self.human(outer)?;
        let found = self.point_of(&name, &human, point);
        Some(found.map(|_| human.points.iter().filter(|p| p.0 == point.value).map(number).collect()))
    }

    /// Names of the signals of `operator`, or of the point `operator.chest`; `None` if `who` is not a human.
    pub(super) fn names_of_human(&mut self, who: &Value) -> Option<Result<Vec<String>, Failed>> {
        let outer = if let ValueKind::Field(outer, _) = &who.kind { outer } else { who };
        let points = match self.numbers_of_human(who, |p| p.1)? {
            Ok(points) => points,
            Err(failed) => return Some(Err(failed)),
        };
        let (name, human) = self.human(outer)?;
        let signal = |p: &(String, usize, usize)| format!("{}.{}", target(&name), p.0);
        Some(Ok(human.points.iter().filter(|p| points.contains(&p.1)).map(signal).collect()))
    }

    /// Lowers `uncertainty(operator)` and `uncertainty(operator.chest)`.
    pub(super) fn uncertainty(&mut self, args: &[Value], span: Span) -> Result<Typed, Failed> {
        let [who] = args else {
            let d = Diagnostic::error(
                "HQ0310",
                span,
                "`uncertainty` takes the name of one person, or of one of its points",
            );
            return self.fail(d.help("write for instance `uncertainty(operator)`"));
        };
        let Some(numbers) = self.numbers_of_human(who, |p| p.2) else {
            if self.is_failed(who) {
                return Err(Failed);
            }
            let d = Diagnostic::unknown_name(who.span, "this is neither a person nor a point of one");
            return self.fail(d.help(Help::with(
                "declare it: {}",
                [Snippet::declared(
                    "human",
                    "operator",
                    [Snippet::entry("points", "[chest]"), Snippet::each("lost hold", "lost: hold")],
                )],
            )));
        };
        let numbers = numbers?;
        let outer = if let ValueKind::Field(outer, _) = &who.kind { outer } else { who };
        if let Some((name, _)) = self.human(outer).filter(|(_, human)| !human.held) {
            let text = format!("`{}` is never uncertain: it is absent when its readings stop", written(&name));
            let d = Diagnostic::error("HQ0304", who.span, text);
            return self.fail(d.help(Help::with(
                &format!("write {{}} into the human `{}`, or leave this out", written(&name)),
                [Snippet::each("lost hold", "lost: hold")],
            )));
        }
        let nodes: Vec<usize> = numbers.into_iter().map(|at| self.graph.moving_signal(at, at + 1)).collect();
        let most = nodes.into_iter().reduce(|a, b| self.graph.push(runtime::program::Op::Max(a, b)));
        let nodes = most.into_iter().collect();
        Ok(Typed { kind: Kind::Scalar, dimension: LENGTH, nodes, bare: false, axes: Axes::default(), span })
    }
}
