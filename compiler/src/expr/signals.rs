//! Signals in expressions: their presence, and the parts of a wrench.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};
use runtime::program::Op;
use stdlib_tasks::dimension::{LENGTH, NONE, TIME};

use super::scope::{Failed, Meaning};
use super::{Axes, Kind, Lowering, Typed};
use crate::diagnostics::examples;

/// Parts of a wrench.
const PARTS: [&str; 2] = ["force", "moment"];

/// Velocities of a tracked signal: of a point the first one, of a pose both.
pub(crate) const VELOCITIES: [&str; 2] = ["velocity", "angular_velocity"];

/// Function that is the age of a reading.
pub(crate) const AGE: &str = "age";

/// Name of the symbol for a part of a signal. Users cannot write it.
pub(crate) fn part_of_signal(name: &str, part: &str) -> String {
    format!("{name}.#{part}")
}

impl Lowering<'_> {
    /// Lowers `present(SIGNAL)`.
    pub(super) fn presence(&mut self, args: &[Value], span: Span) -> Result<Typed, Failed> {
        if let [who] = args
            && let Some(numbers) = self.numbers_of_human(who, |p| p.1)
        {
            // All points must be present: `if a then b else a`, the same as `and`.
            let nodes = numbers?.into_iter().map(|at| self.graph.push(Op::Signal(at))).collect::<Vec<usize>>();
            let all = nodes.into_iter().reduce(|a, b| self.graph.push(Op::Select(a, b, a)));
            let nodes = all.into_iter().collect();
            return Ok(Typed { kind: Kind::Truth, dimension: NONE, nodes, bare: false, axes: Axes::default(), span });
        }
        let [Value { kind: ValueKind::Name(name), .. }] = args else {
            let d = Diagnostic::error(
                "HQ0310",
                span,
                "`present` takes the name of one signal, person or point of a person",
            );
            return self.fail(d.help("write for instance `present(peduncle)`"));
        };
        let Some(at) = self.scope.presence(name) else {
            if matches!(self.scope.name(name), Meaning::Failed) {
                return Err(Failed);
            }
            let text = format!("there is no signal `{}`", crate::forms::written(name));
            return self.fail(
                Diagnostic::unknown_name(args[0].span, text)
                    .help(Help::with("declare it: {}", [examples::signal("point?")])),
            );
        };
        let nodes = vec![self.graph.push(Op::Signal(at))];
        Ok(Typed { kind: Kind::Truth, dimension: NONE, nodes, bare: false, axes: Axes::default(), span })
    }

    /// Lowers `age(SIGNAL)`, `age(HUMAN)` and `age(HUMAN.POINT)`: the time since the last valid reading.
    pub(super) fn age(&mut self, args: &[Value], span: Span) -> Result<Typed, Failed> {
        let [who] = args else {
            let d =
                Diagnostic::error("HQ0310", span, "`age` takes the name of one signal, person or point of a person");
            return self.fail(d.help("write for instance `age(peduncle)`"));
        };
        let names = match (self.names_of_human(who), &who.kind) {
            (Some(names), _) => names?,
            (None, ValueKind::Name(name)) => vec![name.clone()],
            _ => {
                let d =
                    Diagnostic::error("HQ0310", who.span, "this is neither a signal nor a person nor a point of one");
                return self.fail(d.help("write for instance `age(peduncle)`, without an operation inside"));
            }
        };
        let mut oldest: Option<usize> = None;
        for name in names {
            let Some(at) = self.scope.age(&name) else { return self.no_age(&name, who.span) };
            // The number that says that it is there is 1, which is also how fast an age grows.
            let node = self.graph.moving_signal(at + 1, at);
            oldest = Some(oldest.map_or(node, |other| self.graph.push(Op::Max(other, node))));
        }
        let nodes = oldest.into_iter().collect();
        Ok(Typed { kind: Kind::Scalar, dimension: TIME, nodes, bare: false, axes: Axes::default(), span })
    }

    fn no_age(&mut self, name: &str, span: Span) -> Result<Typed, Failed> {
        let written = crate::forms::written(name);
        match self.scope.name(name) {
            Meaning::Failed => Err(Failed),
            Meaning::Event => {
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is an event, which has no age"));
                self.fail(
                    d.note("an event is visible only at the tick after it was raised")
                        .help("name a signal with a value"),
                )
            }
            Meaning::Unknown => {
                let d = Diagnostic::unknown_name(span, format!("there is no signal `{written}`"));
                self.fail(d.help(Help::with("declare it: {}", [examples::signal("point?")])))
            }
            _ => {
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is no signal, so it has no readings"));
                self.fail(
                    d.note("the age of a value is the time since the host sent it").help("name a signal or a person"),
                )
            }
        }
    }

    /// Lowers `right_ft.force`, if the name is that of a wrench.
    pub(super) fn part_of_wrench(
        &mut self,
        inner: &Value,
        field: &Spanned<String>,
        span: Span,
    ) -> Option<Result<Typed, Failed>> {
        let ValueKind::Name(name) = &inner.kind else { return None };
        if !matches!(self.scope.name(name), Meaning::Wrench) {
            return None;
        }
        if !PARTS.contains(&field.value.as_str()) {
            let d = Diagnostic::unknown_name(field.span, format!("a wrench has no `{}`", field.value));
            return Some(self.fail(d.help("it has `force` and `moment`")));
        }
        let part = part_of_signal(crate::forms::target(name), &field.value);
        match self.scope.name(&part) {
            Meaning::Value(symbol) => Some(Ok(Typed { span, ..symbol.value })),
            _ => Some(Err(Failed)),
        }
    }

    /// Lowers `crate.velocity`, if the name is that of a signal.
    pub(super) fn velocity_of_signal(
        &mut self,
        inner: &Value,
        field: &Spanned<String>,
        span: Span,
    ) -> Option<Result<Typed, Failed>> {
        let ValueKind::Name(name) = &inner.kind else { return None };
        if !VELOCITIES.contains(&field.value.as_str()) {
            return None;
        }
        self.scope.presence(name)?;
        match self.scope.name(&part_of_signal(crate::forms::target(name), &field.value)) {
            Meaning::Value(symbol) => return Some(Ok(Typed { span, ..symbol.value })),
            Meaning::Failed => return Some(Err(Failed)),
            _ => {}
        }
        let written = crate::forms::written(name);
        let first = part_of_signal(crate::forms::target(name), VELOCITIES[0]);
        if matches!(self.scope.name(&first), Meaning::Value(_)) {
            let d = Diagnostic::unknown_name(field.span, format!("`{written}` has no `{}`", field.value));
            return Some(self.fail(d.note("only a pose has one").help(format!("write `{written}.{}`", VELOCITIES[0]))));
        }
        let d = Diagnostic::unknown_name(field.span, format!("signal `{written}` has no velocity"));
        let may_have = match self.scope.name(name) {
            Meaning::Value(s) => {
                s.value.kind == Kind::Pose || (s.value.kind == Kind::Vector && s.value.dimension == LENGTH)
            }
            _ => false,
        };
        if !may_have {
            return Some(self.fail(d.note("points and poses have one").help(format!("leave `.{}` out", field.value))));
        }
        let setting = Snippet::entry(VELOCITIES[0], "estimated");
        Some(
            self.fail(
                d.note(
                    "a point or a pose counts as at rest between readings, unless its declaration gives it a velocity",
                )
                .help(Help::with(&format!("write {{}} into the signal `{written}`"), [setting])),
            ),
        )
    }
}
