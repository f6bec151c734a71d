//! The scope of an expectation of a mission: what is measured of it, of its agents and of its robots.

use dsl::tree::Value;
use dsl::{Diagnostic, Span, Spanned};
use mission::schedule::problem::Problem;
use runtime::program::{MissionMeasure, Op};
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE};

use super::super::predicates::measure;
use crate::constants::Params;
use crate::expr::{Axes, Frame, Graph, Kind, Meaning, Now, Scope, Start, Symbol, Typed};
use crate::forms::{text_of, written};
use crate::names::{list, suggest};
use crate::quantities::{Form, MissionQuantity, Whose, find, instead};

/// The scope of an expectation of a mission.
pub(super) struct Watch<'s> {
    /// Declared parameters.
    pub params: &'s mut Params,
    /// The name of the mission in the spec.
    pub mission: &'s str,
    /// What is planned.
    pub problem: &'s Problem,
    /// What is measured. The numbers of measures stand behind those of signals.
    pub measures: &'s mut Vec<MissionMeasure>,
    /// Numbers of the table of signals.
    pub width: usize,
    /// That everything is done: a node, for the name `done`.
    pub done: usize,
}

const PRESENT: &str = "of a mission is measured what its agents and robots come to, and no robot's joints or tasks";

impl Watch<'_> {
    /// Who is called so.
    fn who(&self, name: &str) -> Option<(Whose, usize)> {
        let robot = self.problem.robots.iter().position(|m| m.name == name).map(|i| (Whose::Robot, i));
        let agent = || self.problem.agents.iter().position(|a| a.name == name).map(|i| (Whose::Agent, i));
        robot.or_else(agent).or((name == self.mission).then_some((Whose::Mission, 0)))
    }

    fn members(&self) -> impl Iterator<Item = &str> + Clone {
        let robots = self.problem.robots.iter().map(|m| m.name.as_str());
        robots.chain(self.problem.agents.iter().map(|a| a.name.as_str())).chain([self.mission])
    }

    fn unknown(&self, what: &str, name: &str, at: Span) -> Diagnostic {
        let d = Diagnostic::error("HQ0201", at, format!("there is no {what} `{name}` in mission `{}`", self.mission));
        match suggest(name, self.members()) {
            Some(near) => d.help(format!("did you mean `{near}`?")),
            None => d.help(format!("there is {}", list(self.members(), 12))),
        }
    }

    fn quantity(&mut self, graph: &mut Graph, q: &MissionQuantity, index: usize, span: Span) -> Typed {
        let (first, second) = q.measures(index);
        let mut number = |wanted| measure(graph, self.width, self.measures, wanted);
        let first = number(first);
        let second = second.map(&mut number);
        let (kind, dimension) = match q.form {
            Form::Number(dimension) => (Kind::Scalar, dimension),
            Form::Truth => (Kind::Truth, NONE),
            Form::Point => (Kind::Vector, LENGTH),
        };
        let mut nodes = vec![first];
        if let Some(second) = second {
            nodes.extend([second, graph.number(0.0)]);
        }
        typed(nodes, kind, dimension, span)
    }

    /// Where somebody is, from a name.
    fn position(&mut self, graph: &mut Graph, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let Some(name) = text_of(value) else {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a robot or an agent is needed here");
            diagnostics.push(d.help("write for instance `distance(m1, m2)`"));
            return None;
        };
        let who = self.who(name).filter(|who| who.0 != Whose::Mission);
        let found = who.and_then(|(whose, index)| Some((find(whose, "position")?, index)));
        match found {
            Some((q, index)) => Some(self.quantity(graph, q, index, value.span)),
            None => {
                diagnostics.push(self.unknown("robot or agent", name, value.span));
                None
            }
        }
    }
}

fn typed(nodes: Vec<usize>, kind: Kind, dimension: Dimension, span: Span) -> Typed {
    Typed { kind, dimension, nodes, bare: false, axes: Axes::default(), span }
}

impl Scope for Watch<'_> {
    fn name(&mut self, name: &str) -> Meaning {
        match self.params.meaning(name) {
            Meaning::Unknown if name == "done" => {
                let value = typed(vec![self.done], Kind::Truth, NONE, Span::default());
                Meaning::Value(Symbol { value, declared: Span::default() })
            }
            meaning => meaning,
        }
    }

    fn names(&self) -> Vec<String> {
        let mut names = self.params.names();
        names.push("done".to_string());
        names
    }

    fn instead(&self, name: &str) -> Option<String> {
        let example = match self.who(name)?.0 {
            Whose::Mission => "makespan",
            Whose::Agent => "waited",
            Whose::Robot => "position",
        };
        Some(format!("name what of it is meant, for instance `{name}.{example}`"))
    }

    fn presence(&mut self, _: &str) -> Option<usize> {
        None
    }

    fn part(
        &mut self,
        graph: &mut Graph,
        (of, at): (&str, Span),
        field: &Spanned<String>,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Option<Typed>> {
        let name = written(of);
        let Some((whose, index)) = self.who(name) else {
            if self.params.knows(of) {
                return None;
            }
            diagnostics.push(self.unknown("robot or agent", name, at));
            return Some(None);
        };
        let Some(q) = find(whose, &field.value) else {
            let text = format!("nothing called `{}` is measured of {}", field.value, whose.describe());
            diagnostics.push(Diagnostic::error("HQ0201", field.span, text).help(instead(whose, &field.value)));
            return Some(None);
        };
        Some(Some(self.quantity(graph, q, index, at.to(field.span))))
    }

    fn initial(&mut self, _: &mut Graph, _: &Value, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let d = Diagnostic::error("HQ0311", span, "`initial(..)` has no meaning in an expectation");
        diagnostics.push(d.note(PRESENT).help("write the value that is meant as a constant"));
        None
    }

    fn start(
        &mut self,
        _: &mut Graph,
        _: Option<&Value>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Start> {
        let d = Diagnostic::error("HQ0312", span, "a trajectory has no meaning in an expectation");
        diagnostics.push(d.note(PRESENT).help("expect something of where a robot is: `m1.position`"));
        None
    }

    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame> {
        let d = Diagnostic::error("HQ0312", name.span, "axes of a robot have no meaning in a mission");
        diagnostics.push(d.note(PRESENT).help(format!("leave `in {}` out: all counts along the ground", name.value)));
        None
    }

    fn now(&mut self, graph: &mut Graph, what: &Now, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let Now::Distance(a, b) = what else {
            let d = Diagnostic::error("HQ0312", span, "what a robot's links and joints do has no meaning in a mission");
            diagnostics
                .push(d.note(PRESENT).help("write for instance `m1.position`, `m1.speed` or `distance(m1, m2)`"));
            return None;
        };
        let (a, b) = (self.position(graph, a, diagnostics), self.position(graph, b, diagnostics));
        let (a, b) = (a?, b?);
        let mut squared = |k: usize| {
            let d = graph.push(Op::Sub(a.nodes[k], b.nodes[k]));
            graph.push(Op::Mul(d, d))
        };
        let (x, y) = (squared(0), squared(1));
        let sum = graph.push(Op::Add(x, y));
        let node = graph.push(Op::Sqrt(sum));
        Some(typed(vec![node], Kind::Scalar, LENGTH, span))
    }

    fn measured(
        &mut self,
        _: &mut Graph,
        function: &Spanned<String>,
        _: &[Value],
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        let text = format!("`{}(..)` has no meaning in a scenario of a mission", function.value);
        let d = Diagnostic::error("HQ0312", span, text).note(PRESENT);
        diagnostics.push(d.help("write for instance `h1.waited`, `m1.speed` or `distance(m1, m2)`"));
        None
    }
}
