//! Names in expressions: built-in names, names of the scope, and helps for unknown names.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span};
use names::suggest;
use runtime::program::Op;
use stdlib_tasks::dimension::{Dimension, NONE, TIME};

use super::functions::function;
use super::robot_state::RobotStateTerm;
use super::scope::{Failed, Meaning};
use super::{Axes, Kind, Lowering, Typed};
use crate::forms::{target, written};
use crate::units;

impl Lowering<'_> {
    /// Lowers a name.
    pub(super) fn name(&mut self, name: &str, span: Span) -> Result<Typed, Failed> {
        let scalar = |node: usize, dimension: Dimension| Typed {
            kind: Kind::Scalar,
            dimension,
            nodes: vec![node],
            bare: false,
            axes: Axes::default(),
            span,
        };
        match name {
            "pi" => return Ok(scalar(self.graph.number(std::f64::consts::PI), NONE)),
            "t" => return Ok(scalar(self.graph.push(Op::T), TIME)),
            "com" => return self.now(&RobotStateTerm::Com, span),
            "time" => return Ok(scalar(self.graph.push(Op::Time), TIME)),
            "true" | "false" => {
                let node = self.graph.number(if name == "true" { 1.0 } else { -1.0 });
                return Ok(Typed { kind: Kind::Truth, ..scalar(node, NONE) });
            }
            _ => {}
        }
        match self.scope.name(name) {
            Meaning::Value(symbol) => return Ok(Typed { span, ..symbol.value }),
            Meaning::Failed => return Err(Failed),
            Meaning::Later => {
                let written = crate::forms::written(name);
                let text = format!("`{written}` depends on the robot's state, and this value is needed before the run");
                let d = Diagnostic::error("HQ0312", span, text);
                return self.fail(d.help("write a constant here; such a `let` can be used in parameters of tasks"));
            }
            Meaning::Wrench => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is a wrench, which is no single value"));
                return self.fail(d.help(format!("write `{written}.force` or `{written}.moment`")));
            }
            Meaning::Human(human) => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is a person, who is no single value"));
                let points: Vec<String> = human.points.iter().map(|p| format!("`{written}.{}`", p.0)).collect();
                return self.fail(d.help(format!("name one of its points: {}", points.join(", "))));
            }
            Meaning::Field => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error(
                    "HQ0304",
                    span,
                    format!("`{written}` is a safety field, and no number by itself"),
                );
                return self.fail(d.help(format!("write `field({written})` for its value at this moment")));
            }
            Meaning::Obstacle => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is an obstacle, which has no value"));
                return self.fail(d.help(Help::with(
                    "a task keeps clear of it: {}",
                    [Snippet::typed(
                        "task",
                        "NAME",
                        stdlib_tasks::kinds::keep_clear::KIND.name,
                        [Snippet::entry("links", "LINK"), Snippet::entry("of", written)],
                    )],
                )));
            }
            Meaning::Event => {
                let written = crate::forms::written(name);
                let d = Diagnostic::error("HQ0304", span, format!("`{written}` is an event, which has no value"));
                return self.fail(
                    d.help(Help::with("a transition waits for it: {}", [Snippet::transition(written, "STATE")])),
                );
            }
            Meaning::Unknown => {}
        }
        let mut known = self.scope.names();
        let moving: &[&str] = if self.scope.moves() { &["t", "time", "com"] } else { &[] };
        known.extend(moving.iter().chain(&["pi"]).map(|name| (*name).to_string()));
        let mut d = Diagnostic::undeclared("value called", crate::forms::written(name), span);
        if let Some(help) = self.scope.instead(name) {
            d = d.help(help);
        } else if let Some(near) = suggest(name, known.iter().map(String::as_str)) {
            d = d.meant(near);
        } else if function(name).is_some() {
            d = d.help(format!("`{name}` is a function: write `{name}(..)`"));
        } else if units::symbols().any(|u| u == name) {
            d = d.note("a unit must follow a number or a bracket").help(Help::with(
                &format!("for the unit write `1 {name}` or `1 /{name}`; for a value declare {{}}"),
                [Snippet::defined("param", name, "..")],
            ));
        } else if self.scope.moves() {
            d = d.help(Help::with(
                "declare it with {}, or use `t`, `time`, `pi`",
                [Snippet::defined("param", "NAME", "VALUE")],
            ));
        } else {
            d = d.help(Help::with(
                "write the value itself, or declare it with {}",
                [Snippet::defined("param", "NAME", "VALUE")],
            ));
        }
        self.fail(d)
    }

    /// Diagnostic for an unknown name before a dot that is similar to that of a person, a signal or a value.
    pub(super) fn misspelt(&mut self, inner: &Value) -> Option<Diagnostic> {
        let ValueKind::Name(name) = &inner.kind else { return None };
        if !matches!(self.scope.name(name), Meaning::Unknown) {
            return None;
        }
        let names = self.scope.names();
        let near = suggest(target(name), names.iter().map(String::as_str))?;
        let text = format!("there is no person, signal or value `{}`", written(name));
        Some(Diagnostic::unknown_name(inner.span, text).meant(near))
    }
}
