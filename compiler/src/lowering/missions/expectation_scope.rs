//! The scope of an expectation of a mission: what is measured of it, of its agents and of its robots.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned};
use mission::kind::{Form, Measure};
use runtime::program::{MachineProgram, MissionMeasure, Op};
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE};

use super::super::predicates::measure;
use super::super::states::state;
use super::executed::{Executed, Owner};
use super::runs::Machines;
use crate::expr::constants::Params;
use crate::expr::{Axes, Frame, Graph, Kind, Meaning, RobotStateTerm, Scope, Start, Symbol, Typed};
use crate::forms::{path_of, text_of, written};

/// The scope of an expectation of a mission.
pub(super) struct Watch<'s> {
    /// Declared parameters.
    pub params: &'s mut Params,
    /// The mission under execution.
    pub of: Executed<'s>,
    /// The machines that working robots run, and whether they do in this scenario.
    pub machines: (&'s Machines, bool),
    /// All measures. Their numbers follow those of the signals.
    pub measures: &'s mut Vec<MissionMeasure>,
    /// Numbers of the table of signals.
    pub width: usize,
    /// Node of the measure that the mission is done, for the name `done`.
    pub done: usize,
}

const PRESENT: &str = "a mission has measures of its members; joints and tasks of robots are not measured";

impl Watch<'_> {
    /// The owner of a name.
    fn who(&self, name: &str) -> Option<Owner> {
        self.of.owner(name)
    }

    fn members(&self) -> Vec<&str> {
        self.of.members().into_iter().chain([self.of.name]).collect()
    }

    fn unknown(&self, what: &str, name: &str, at: Span) -> Diagnostic {
        let d = Diagnostic::unknown_name(at, format!("there is no {what} `{name}` in mission `{}`", self.of.name));
        d.one_of("there is", name, self.members().iter().copied())
    }

    fn quantity(&mut self, graph: &mut Graph, q: &Measure, of: Owner, span: Span) -> Typed {
        let value = |axis| MissionMeasure::Value { name: q.name.into(), member: of.member(), axis };
        let wanted = match (q.form, of) {
            (Form::OfController, Owner::Member(member, _)) => vec![MissionMeasure::Faulted(member)],
            (Form::Point, _) if self.of.mission.has_height() => (0..3).map(value).collect(),
            (Form::Point, _) => (0..2).map(value).collect(),
            _ => vec![value(0)],
        };
        let mut nodes: Vec<usize> =
            wanted.into_iter().map(|wanted| measure(graph, self.width, self.measures, wanted)).collect();
        let (kind, dimension) = match q.form {
            Form::Number(dimension) => (Kind::Scalar, dimension),
            Form::Truth | Form::OfController => (Kind::Truth, NONE),
            Form::Point => (Kind::Vector, LENGTH),
        };
        if nodes.len() == 2 {
            nodes.push(graph.number(0.0));
        }
        typed(nodes, kind, dimension, span)
    }

    /// Reports an agent whose controller does not run.
    fn runs(&self, agent: usize, at: Span, diagnostics: &mut Vec<Diagnostic>) -> bool {
        let (machines, run) = self.machines;
        if machines.has(agent) && run {
            return true;
        }
        let d =
            Diagnostic::error("HQ0312", at, format!("`{}` runs no controller in this scenario", self.called(agent)));
        diagnostics.push(match machines.has(agent) {
            true => d.note("operations take as long as planned here").help(Help::with(
                "leave {} out, or expect something of the mission",
                [Snippet::entry("operations", "planned")],
            )),
            false if self.of.mission.drivable(agent).is_some() => {
                d.help("give it one with `runs`, or expect something of its position")
            }
            false => d.help("a worker with `runs` does; others only work, `w1.working`"),
        });
        false
    }

    fn called(&self, agent: usize) -> &str {
        self.of.members().get(agent).copied().unwrap_or_default()
    }

    /// The machine of an agent whose controller runs.
    fn machine(&self, agent: usize, at: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<&MachineProgram> {
        if !self.runs(agent, at, diagnostics) {
            return None;
        }
        let machine = self.machines.0.of_agent(agent);
        if machine.is_none() {
            let text = format!("`{}` runs a stack, which has no states", self.called(agent));
            let d = Diagnostic::error("HQ0312", at, text);
            diagnostics.push(d.help("let its spec run a machine, or name a scenario of it that runs one"));
        }
        machine
    }

    /// `in(w1.picking)`: that the machine of a working robot is in a state.
    fn state_of(
        &mut self,
        graph: &mut Graph,
        args: &[Value],
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        const FORM: &str = "write `in(WORKER.STATE)`, with a worker that runs a controller";
        let [argument] = args else {
            let text = format!("`in` takes one name, not {} arguments", args.len());
            diagnostics.push(Diagnostic::error("HQ0310", span, text).help(FORM));
            return None;
        };
        let path = path_of(argument);
        let Some((who, path)) = path.as_deref().and_then(|p| p.split_once('.')) else {
            if !matches!(argument.kind, ValueKind::Missing) {
                let text = "a worker and a state of its machine are needed here";
                diagnostics.push(Diagnostic::error("HQ0304", argument.span, text).help(FORM));
            }
            return None;
        };
        let agent = match self.who(who) {
            Some(Owner::Member(member, "human" | "worker")) => member,
            Some(Owner::Member(member, _)) if self.of.mission.drivable(member).is_some() => member,
            Some(_) => {
                let text = format!("`{who}` is no worker, and has no states");
                diagnostics.push(Diagnostic::error("HQ0312", argument.span, text).help(FORM));
                return None;
            }
            None => {
                diagnostics.push(self.unknown("worker", who, argument.span));
                return None;
            }
        };
        let machine = self.machine(agent, argument.span, diagnostics)?;
        match state(machine, path, argument.span) {
            Ok(state) => {
                let node = measure(graph, self.width, self.measures, MissionMeasure::In(agent, state));
                Some(typed(vec![node], Kind::Truth, NONE, span))
            }
            Err(d) => {
                diagnostics.push(*d);
                None
            }
        }
    }

    /// Lowers the position of a member, given by name.
    fn position(&mut self, graph: &mut Graph, value: &Value, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let Some(name) = text_of(value) else {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a robot or an agent is needed here");
            let (a, b) = self.of.example();
            diagnostics.push(d.help(format!("write for instance `distance({a}, {b})`")));
            return None;
        };
        let who = self.who(name).filter(|who| *who != Owner::Mission);
        let found = who.and_then(|who| Some((self.of.kind().measure(who.role(), "position")?, who)));
        match found {
            Some((q, who)) => Some(self.quantity(graph, q, who, value.span)),
            None if self.who(name).is_some() => {
                let (a, b) = self.of.example();
                let d = Diagnostic::error("HQ0304", value.span, format!("`{name}` is a mission, which has no place"));
                diagnostics.push(d.help(format!("write for instance `distance({a}, {b})`")));
                None
            }
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

    fn instead(&self, name: &str) -> Option<Help> {
        let who = self.who(name)?;
        let has = |name: &&str| self.of.kind().measure(who.role(), name).is_some();
        let example = ["makespan", "waited", "position"].into_iter().find(has).unwrap_or("lost");
        Some(format!("name a measure, for instance `{name}.{example}`").into())
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
        let Some(who) = self.who(name) else {
            if self.params.knows(of) {
                return None;
            }
            diagnostics.push(self.unknown("robot or agent", name, at));
            return Some(None);
        };
        let kind = self.of.kind();
        let Some(q) = kind.measure(who.role(), &field.value) else {
            let text = format!("`{}` is not a measure of {}", field.value, who.describe(kind));
            let names = || self.of.measures(who).map(|measure| measure.name);
            let d = Diagnostic::unknown_name(field.span, text);
            diagnostics.push(d.one_of("there is", &field.value, names()));
            return Some(None);
        };
        if let (Form::OfController, Owner::Member(member, _)) = (q.form, who)
            && !self.runs(member, at.to(field.span), diagnostics)
        {
            return Some(None);
        }
        Some(Some(self.quantity(graph, q, who, at.to(field.span))))
    }

    fn initial(&mut self, _: &mut Graph, _: &Value, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed> {
        let d = Diagnostic::error("HQ0311", span, "`initial(..)` is not allowed in an expectation");
        diagnostics.push(d.note(PRESENT).help("write the value as a constant"));
        None
    }

    fn start(
        &mut self,
        _: &mut Graph,
        _: Option<&Value>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Start> {
        let d = Diagnostic::error("HQ0312", span, "a trajectory is not allowed in an expectation");
        diagnostics.push(
            d.note(PRESENT).help(format!("expect something of where a robot is: `{}.position`", self.of.example().0)),
        );
        None
    }

    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame> {
        let d = Diagnostic::error("HQ0312", name.span, "axes of a robot are not available in a mission");
        diagnostics
            .push(d.note(PRESENT).help(format!("remove `in {}`: positions of a mission have no axes", name.value)));
        None
    }

    fn now(
        &mut self,
        graph: &mut Graph,
        what: &RobotStateTerm,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        let RobotStateTerm::Distance(a, b) = what else {
            let d = Diagnostic::error("HQ0312", span, "links and joints of a robot are not available in a mission");
            let (a, b) = self.of.example();
            diagnostics
                .push(d.note(PRESENT).help(format!("write for instance `{a}.position` or `distance({a}, {b})`")));
            return None;
        };
        let (a, b) = (self.position(graph, a, diagnostics), self.position(graph, b, diagnostics));
        let (a, b) = (a?, b?);
        let mut squared = |k: usize| {
            let d = graph.push(Op::Sub(a.nodes[k], b.nodes[k]));
            graph.push(Op::Mul(d, d))
        };
        let (x, y) = (squared(0), squared(1));
        let height = self.of.mission.has_height().then(|| squared(2));
        let mut sum = graph.push(Op::Add(x, y));
        if let Some(z) = height {
            sum = graph.push(Op::Add(sum, z));
        }
        let node = graph.push(Op::Sqrt(sum));
        Some(typed(vec![node], Kind::Scalar, LENGTH, span))
    }

    fn measured(
        &mut self,
        graph: &mut Graph,
        function: &Spanned<String>,
        args: &[Value],
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        if function.value == "in" {
            return self.state_of(graph, args, span, diagnostics);
        }
        let text = format!("`{}(..)` is not allowed in a scenario of a mission", function.value);
        let d = Diagnostic::error("HQ0312", span, text).note(PRESENT);
        let (a, b) = self.of.example();
        let works = self.of.mission.members().iter().any(|member| member.role == "worker");
        let of_state = if works { " or `in(w1.STATE)`" } else { "" };
        diagnostics.push(d.help(format!("write for instance `{a}.position`, `distance({a}, {b})`{of_state}")));
        None
    }
}
