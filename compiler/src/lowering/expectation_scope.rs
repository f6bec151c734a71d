//! Scope of an expectation: measures of a running scenario, by name, and everything that other expressions may use.

use std::collections::BTreeSet;

use dsl::tree::Value;
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};
use names::{list, suggest};
use runtime::FaultKind;
use runtime::expect::Unit;
use runtime::program::{Measure, PredicateTable, Program};
use stdlib_tasks::dimension::{Dimension, NONE};
use stdlib_tasks::task::RowKind;

use super::expectations::of_a_stack;
use super::predicates::{Graphs, measure, predicate};
use super::shapes::Shape;
use super::states::state;
use crate::binding::TaskScope;
use crate::binding::motion;
use crate::binding::settled::{all_below, settled};
use crate::diagnostics::examples;
use crate::diagnostics::refused::{Refused, refuse};
use crate::expr::constants::Constants;
use crate::expr::{
    Axes, Frame, Graph, Kind, Lowering, Meaning, REACHED, RobotStateTerm, SETTLED, Scope, Start, Symbol, Typed,
    not_measured,
};

/// The scope of an expectation.
pub(super) struct Watch<'s> {
    /// Scope of ordinary expressions.
    pub inner: TaskScope<'s>,
    /// The program, without its scenarios.
    pub program: &'s Program,
    /// See [`super::shapes::shapes`].
    pub shapes: &'s [Option<Shape>],
    /// All measures. Their numbers follow those of the signals.
    pub measures: &'s mut Vec<Measure>,
    /// Nodes of measures whose sign alone is meaningful.
    pub mixed: &'s mut BTreeSet<usize>,
    /// Node of the measure that a fault is present, for the name `fault`.
    pub fault: usize,
    /// Tasks that the expectation measures.
    pub named: &'s mut BTreeSet<usize>,
    /// Measures of the scenario, in the order of their numbers.
    pub used: &'s mut Vec<Measure>,
    /// True inside `initial(..)`.
    pub capturing: bool,
}

/// Diagnostic for an unknown name, with a suggestion.
fn unknown<'n>(what: &str, name: &str, at: Span, names: impl Iterator<Item = &'n str> + Clone) -> Diagnostic {
    let d = Diagnostic::undeclared(what, name, at);
    d.help(format!("this spec has no {what}")).one_of("there is", name, names)
}

fn typed(node: usize, kind: Kind, dimension: Dimension, span: Span) -> Typed {
    Typed { kind, dimension, nodes: vec![node], bare: false, axes: Axes::default(), span }
}

impl Watch<'_> {
    /// Splits a path into the task that it starts with and the rest.
    fn task<'p>(&self, path: &'p str, at: Span) -> Result<(usize, &'p str), Refused> {
        let tasks = &self.program.tasks;
        let rest = |name: &str| {
            let rest = path.strip_prefix(name)?;
            if rest.is_empty() { Some(rest) } else { rest.strip_prefix('.') }
        };
        let found = tasks.iter().enumerate().filter_map(|(i, t)| Some((t.name.len(), i, rest(&t.name)?))).max();
        match found {
            Some((_, i, rest)) => Ok((i, rest)),
            None => {
                let name = path.split('.').next().unwrap_or(path);
                refuse(unknown("task", name, at, tasks.iter().map(|t| t.name.as_str())))
            }
        }
    }

    fn margin(&mut self, path: &str, at: Span) -> Result<(Measure, Dimension), Refused> {
        let (task, rest) = self.task(path, at)?;
        self.named.insert(task);
        let name = &self.program.tasks[task].name;
        let Some(shape) = &self.shapes[task] else { return Err(None) };
        if shape.row_kind != RowKind::Inequality {
            let d = Diagnostic::error("HQ0304", at, format!("`{name}` is a target, and only limits have a margin"));
            return refuse(d.help(format!("write `error({name})`")));
        }
        if !rest.is_empty() {
            let d = Diagnostic::unknown_name(at, format!("the margin of `{name}` has no part `{rest}`"));
            return refuse(d.help(format!("write `margin({name})` for the smallest of its rows")));
        }
        Ok((Measure::Margin(task), shape.margin.unwrap_or(NONE)))
    }

    fn error(&mut self, path: &str, at: Span) -> Result<(Measure, Dimension), Refused> {
        let (task, rest) = self.task(path, at)?;
        self.named.insert(task);
        let name = &self.program.tasks[task].name;
        let Some(shape) = &self.shapes[task] else { return Err(None) };
        if shape.row_kind != RowKind::Equality {
            let d = Diagnostic::error("HQ0304", at, format!("`{name}` is a limit, and only targets have an error"));
            return refuse(d.help(format!("write `margin({name})`")));
        }
        let parts = || shape.parts.iter().map(|p| p.0.as_str());
        let several = || format!("its parts are {}: write `error({name}.PART)`", list(parts(), 12));
        if rest.is_empty() {
            let Some((_, first)) = shape.parts.first() else {
                let d = Diagnostic::error("HQ0304", at, format!("`{name}` reports no error"));
                return refuse(d.help("compare the quantity itself by an expression"));
            };
            if shape.parts.iter().any(|p| p.1 != *first) {
                let text = format!("the errors of `{name}` have several units, and no common size");
                return refuse(Diagnostic::error("HQ0304", at, text).help(several()));
            }
            let part = (shape.parts.len() == 1).then_some(0);
            return Ok((Measure::Error { task, part }, *first));
        }
        // The frame may be omitted if it is unique: `position` for `tool.position`.
        let end = |p: &str| p.rsplit('.').next() == Some(rest);
        let alone = if parts().filter(|p| end(p)).count() == 1 { parts().position(end) } else { None };
        match parts().position(|p| p == rest).or(alone) {
            Some(part) => Ok((Measure::Error { task, part: Some(part) }, shape.parts[part].1)),
            None => {
                let d = Diagnostic::unknown_name(at, format!("the error of `{name}` has no part `{rest}`"));
                refuse(match suggest(rest, parts().flat_map(|p| [p, p.rsplit('.').next().unwrap_or(p)])) {
                    Some(near) => d.meant(near),
                    None if shape.parts.len() > 1 => d.help(several()),
                    None => d.help(format!("write `error({name})`")),
                })
            }
        }
    }

    /// Measure of a state, named by its path, or by a suffix that only one state has.
    fn state(&self, path: &str, at: Span) -> Result<Measure, Refused> {
        let Some(machine) = &self.program.machine else {
            let d = Diagnostic::unknown_name(at, "there are no states, because this spec has no machine");
            return refuse(d.help(Help::with("declare one: {}", [examples::machine(Snippet::dots())])));
        };
        state(machine, path, at).map(Measure::In).map_err(Some)
    }

    fn of(
        &mut self,
        function: &Spanned<String>,
        args: &[Value],
        span: Span,
    ) -> Result<(Measure, Kind, Dimension), Refused> {
        let form = match function.value.as_str() {
            "margin" => "margin(TASK)",
            "error" => "error(TASK)` or `error(TASK.PART)",
            "in" => "in(STATE)",
            other => motion::form(other).unwrap_or("fault(KIND)"),
        };
        let (argument, path) = motion::named(function, args, span, form)?;
        let at = argument.span;
        let scalar = |(measure, dimension)| (measure, Kind::Scalar, dimension);
        let truth = |measure| (measure, Kind::Truth, NONE);
        match function.value.as_str() {
            "margin" => self.margin(&path, at).map(scalar),
            "error" => self.error(&path, at).map(scalar),
            "in" => self.state(&path, at).map(truth),
            of if motion::form(of).is_some() => motion::motion(self.inner.robot, of, argument, &path).map(scalar),
            _ if path == "any" => Ok(truth(Measure::Fault(None))),
            _ => match FaultKind::ALL.into_iter().find(|k| k.word() == path) {
                Some(kind) => Ok(truth(Measure::Fault(Some(kind)))),
                None => refuse(unknown("kind of fault", &path, at, FaultKind::ALL.into_iter().map(FaultKind::word))),
            },
        }
    }
}

impl Scope for Watch<'_> {
    fn name(&mut self, name: &str) -> Meaning {
        match self.inner.name(name) {
            Meaning::Unknown if name == "fault" => {
                let value = typed(self.fault, Kind::Truth, NONE, Span::default());
                Meaning::Value(Symbol { value, declared: Span::default() })
            }
            meaning => meaning,
        }
    }

    fn names(&self) -> Vec<String> {
        self.inner.names()
    }

    fn presence(&mut self, name: &str) -> Option<usize> {
        self.inner.presence(name)
    }

    fn age(&mut self, name: &str) -> Option<usize> {
        self.inner.age(name)
    }

    /// Value at the start of the run; each of its numbers is a separate measure.
    fn initial(
        &mut self,
        graph: &mut Graph,
        argument: &Value,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        if self.capturing {
            let d = Diagnostic::error("HQ0311", span, "an `initial(..)` inside another");
            diagnostics.push(d.help("remove it: everything inside the outer one is captured at the same time"));
            return None;
        }
        self.capturing = true;
        let typed = Lowering { graph: &mut *graph, scope: &mut *self, diagnostics: &mut *diagnostics }.value(argument);
        self.capturing = false;
        let typed = typed.ok()?;
        let width = self.program.interface.width();
        let layout = PredicateTable { signals: width, measures: 0 };
        let mut nodes = Vec::new();
        for &node in &typed.nodes {
            let graphs = Graphs { graph, table: self.inner.table, width };
            let number = (node, Unit::Quantity(typed.dimension));
            let Some(p) = predicate(number, graphs, layout, (self.measures, self.used)) else {
                diagnostics.push(of_a_stack(graph.moves_along(&typed.nodes), argument.span));
                return None;
            };
            nodes.push(measure(graph, width, self.measures, Measure::Initial(p.value)));
        }
        Some(Typed { nodes, span, ..typed })
    }

    fn start(
        &mut self,
        _: &mut Graph,
        _: Option<&Value>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Start> {
        diagnostics.push(
            Diagnostic::error("HQ0312", span, "a trajectory is not allowed in an expectation")
                .note("it begins when a stack is entered, and an expectation belongs to no stack")
                .help("expect something of the robot: `error(TASK) < 1 cm`, or where `frame(F).position` is"),
        );
        None
    }

    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame> {
        self.inner.frame(name, diagnostics)
    }

    fn now(
        &mut self,
        graph: &mut Graph,
        what: &RobotStateTerm,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        self.inner.now(graph, what, span, diagnostics)
    }

    fn measured(
        &mut self,
        graph: &mut Graph,
        function: &Spanned<String>,
        args: &[Value],
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        if function.value == SETTLED {
            let mut constants = Constants { graph: &mut *graph, params: &mut *self.inner.params };
            let limits = match settled(self.inner.robot, args, span, &mut constants, diagnostics) {
                Ok(limits) => limits,
                Err(d) => {
                    diagnostics.extend(d.map(|d| *d));
                    return None;
                }
            };
            let (width, measures) = (self.program.interface.width(), &mut *self.measures);
            let mut number = |graph: &mut Graph, _: &str, wanted, _| measure(graph, width, measures, wanted);
            let node = all_below(graph, limits, &mut number);
            return Some(typed(node, Kind::Truth, NONE, span));
        }
        if function.value == REACHED {
            diagnostics.push(not_measured(function, span));
            return None;
        }
        match self.of(function, args, span) {
            Ok((wanted, kind, dimension)) => {
                let mixed = matches!(&wanted, Measure::Margin(t) if self.shapes[*t].as_ref().is_some_and(|s| s.margin.is_none()));
                let node = measure(graph, self.program.interface.width(), self.measures, wanted);
                if mixed {
                    self.mixed.insert(node);
                }
                Some(typed(node, kind, dimension, span))
            }
            Err(d) => {
                diagnostics.extend(d.map(|d| *d));
                None
            }
        }
    }
}
