//! Expectations: formulas over predicates, their windows in ticks.

use std::collections::BTreeSet;

use dsl::tree::{Expect, Formula as Written, FormulaKind, Value, Window as Times};
use dsl::{Diagnostic, Span};
use runtime::expect::{Formula, MAX_KEPT, MAX_NODES, Monitor, Node, Window, WindowError};
use runtime::program::{ExpectationProgram, Measure, Predicate, Program, ScenarioProgram};
use runtime::world::is_bound_to_its_stack;
use stdlib_tasks::dimension::TIME;

use super::Lowerer;
use super::predicates::{measure, number, predicate};
use super::shapes::Shape;
use super::watch::Watch;
use crate::binding::TaskScope;
use crate::constants::Constants;
use crate::names::list;
use crate::robot_binding::BoundRobot;

/// The most parts that all expectations of a spec may have.
const MAX_PARTS: usize = 3000;

/// The expectations of a scenario under construction.
struct Builder<'b, 'l> {
    lowerer: &'b mut Lowerer<'l>,
    robot: &'b BoundRobot,
    program: &'b Program,
    shapes: &'b [Option<Shape>],
    scenario: &'b mut ScenarioProgram,
    /// Everything that was measured anywhere in the program.
    measures: &'b mut Vec<Measure>,
    /// Nodes of which only the sign means something.
    mixed: BTreeSet<usize>,
    /// Predicates of this expectation that look at a task, each with where it was written.
    tasks: Vec<(usize, Span)>,
    /// It speaks of states.
    of_states: bool,
}

impl Lowerer<'_> {
    /// The expectations of a scenario whose run is known.
    pub(super) fn expectations(
        &mut self,
        (expects, texts): (&[Expect], &[String]),
        scenario: &mut ScenarioProgram,
        (program, robot, shapes): (&Program, &BoundRobot, &[Option<Shape>]),
        measures: &mut Vec<Measure>,
    ) {
        let runs = scenario.program(program);
        let mut kept = 0_usize;
        let ticks = (scenario.run.duration / program.robot.period).round() as u32;
        for (expect, text) in expects.iter().zip(texts) {
            if self.expected > MAX_PARTS {
                let text = format!("the expectations of this spec have more than {MAX_PARTS} parts");
                let d = Diagnostic::error("HQ0803", expect.span, text).here("counted up to here");
                self.push(d.help("write several specs"));
                return;
            }
            let mut b = Builder {
                lowerer: self,
                robot,
                program,
                shapes,
                scenario,
                measures,
                mixed: BTreeSet::new(),
                tasks: Vec::new(),
                of_states: false,
            };
            let mut formula = Formula::new(program.robot.period);
            if b.formula(&expect.formula, &mut formula).is_none() {
                continue;
            }
            let (tasks, of_states) = (std::mem::take(&mut b.tasks), b.of_states);
            let remembers = |task: usize| shapes[task].as_ref().is_some_and(|s| s.remembers_entry);
            let bound = |task: usize| remembers(task) || is_bound_to_its_stack(program, task);
            let unknown =
                tasks.iter().filter(|t| bound(t.0)).find_map(|&(task, at)| no_value(&runs, task, at, of_states));
            if let Some(d) = unknown {
                self.push(d);
                continue;
            }
            let monitor = if formula.nodes.len() > MAX_NODES {
                None
            } else {
                Monitor::new(&formula, &scenario.units(), ticks).ok()
            };
            let Some(monitor) = monitor else {
                let d = Diagnostic::error("HQ0803", expect.span, "this expectation is too large to be watched");
                self.push(d.help("shorten its windows, or write it as several"));
                continue;
            };
            kept = kept.saturating_add(monitor.kept());
            if kept > MAX_KEPT {
                let text = "the expectations of this scenario are too many to be watched together";
                let d = Diagnostic::error("HQ0803", expect.span, text).here("up to here");
                self.push(d.help("shorten their windows, or spread them over several scenarios"));
                return;
            }
            let label = expect.label.as_ref().map(|l| l.value.clone());
            scenario.expectations.push(ExpectationProgram { label, text: text.clone(), formula });
        }
    }
}

/// A task that has a value only while its stack runs, and that not at all ticks of a run.
fn no_value(program: &Program, task: usize, at: Span, of_states: bool) -> Option<Diagnostic> {
    let holds = |s: &usize| program.stacks[*s].levels.iter().flat_map(|l| &l.members).any(|m| m.task == task);
    let stacks = program.run_stacks();
    let without: Vec<&str> = stacks.iter().filter(|s| !holds(s)).map(|s| program.stacks[*s].name.as_str()).collect();
    let name = &program.tasks[task].name;
    let text = format!("`{name}` has no value while it does not run");
    let d = Diagnostic::error("HQ0801", at, text)
        .note("what it asks for depends on when its stack was entered, or on where");
    if without.len() == stacks.len() {
        return Some(d.help("run a stack that holds it, or expect something of a task that it does not depend on"));
    }
    let machine = program.run.subject == runtime::program::Subject::Machine;
    let stands =
        machine && program.machine.as_ref().is_some_and(|m| (1..m.states.len()).any(|s| m.stack(m.leaf(s)).is_none()));
    if of_states || (without.is_empty() && !stands) {
        return None;
    }
    let where_ = if without.is_empty() {
        "some states have no stack".to_string()
    } else {
        format!("it is not in {}", list(without, 4))
    };
    Some(d.here(where_).help("say for which states it is meant: `always (in(STATE) implies ..)`"))
}

impl Builder<'_, '_> {
    /// Adds a formula; gives its index.
    fn formula(&mut self, f: &Written, out: &mut Formula) -> Option<usize> {
        use FormulaKind as F;
        self.lowerer.expected += 1;
        if out.nodes.len() > MAX_NODES {
            return Some(0);
        }
        let node = match &f.kind {
            F::Missing => return None,
            F::Value(value) => Node::Predicate(self.predicate(value)?),
            F::Not(a) => Node::Not(self.formula(a, out)?),
            F::And(a, b) => {
                let (a, b) = (self.formula(a, out), self.formula(b, out));
                Node::And(vec![a?, b?])
            }
            F::Or(a, b) => {
                let (a, b) = (self.formula(a, out), self.formula(b, out));
                Node::Or(vec![a?, b?])
            }
            F::Implies(a, b) => {
                let (a, b) = (self.formula(a, out), self.formula(b, out));
                Node::Implies([a?, b?])
            }
            F::After(a, b) => {
                let (a, b) = (self.formula(a, out), self.formula(b, out));
                return Some(out.after(a?, b?));
            }
            F::Always(w, a) => {
                let (w, a) = (self.window(w), self.formula(a, out));
                Node::Always(w?, a?)
            }
            F::Never(w, a) => {
                let (w, a) = (self.window(w), self.formula(a, out));
                let not = out.add(Node::Not(a?));
                Node::Always(w?, not)
            }
            F::Eventually(w, a) => {
                let (w, a) = (self.window(w), self.formula(a, out));
                match (w?, a?) {
                    (Window { first: 0, last: Some(last) }, a) => {
                        return Some(out.within(last, a, &self.scenario.units()));
                    }
                    (w, a) => Node::Eventually(w, a),
                }
            }
            F::Until(a, w, b) => {
                let (a, w, b) = (self.formula(a, out), self.window(w), self.formula(b, out));
                Node::Until(w?, [a?, b?])
            }
        };
        Some(out.add(node))
    }

    fn window(&mut self, w: &Times) -> Option<Window> {
        let mut time = |value: &Option<Value>| match value {
            Some(value) => {
                let mut constants = Constants { graph: &mut self.lowerer.graph, params: &mut self.lowerer.params };
                constants.scalar(value, TIME, self.lowerer.diagnostics).map(Some)
            }
            None => Some(None),
        };
        let (from, to) = (time(&w.from), time(&w.to));
        let wrong = match Window::seconds(from?.unwrap_or(0.0), to?, self.program.robot.period) {
            Ok(window) => return Some(window),
            Err(wrong) => wrong,
        };
        let code = if wrong == WindowError::NotATime { "HQ0308" } else { "HQ0802" };
        let help = match wrong {
            WindowError::NotATime => "count from now: write `from 0 s`",
            WindowError::UpsideDown => "write the earlier time first: `from 2 s to 5 s`",
            WindowError::Empty => "make the window longer than a tick",
            WindowError::TooLong => "leave its end out",
        };
        let d = Diagnostic::error(code, w.span, wrong.to_string());
        self.lowerer.push(d.label(self.robot.rate_span, format!("one tick is {} s", self.robot.period)).help(help));
        None
    }

    /// The place of a predicate among those of the scenario.
    fn predicate(&mut self, value: &Value) -> Option<usize> {
        let Lowerer { graph, table, params, diagnostics, meant, .. } = &mut *self.lowerer;
        let fault = measure(graph, self.program, self.measures, Measure::Fault(None));
        let (forms, mut named) = (Default::default(), BTreeSet::new());
        let mut scope = Watch {
            inner: TaskScope::free(self.robot, params, table, &forms),
            program: self.program,
            shapes: self.shapes,
            measures: self.measures,
            mixed: &mut self.mixed,
            fault,
            named: &mut named,
        };
        let found = number(value, graph, &mut scope, diagnostics);
        // Who is watched is used.
        meant.extend(named.iter().map(|&t| self.program.tasks[t].name.clone()));
        self.tasks.extend(named.into_iter().map(|t| (t, value.span)));
        let (node, unit) = found?;
        let before = self.scenario.measures.len();
        let p: Option<Predicate> =
            predicate((node, unit), (graph, table), (self.program, self.measures), &mut self.scenario.measures);
        let Some(p) = p else {
            self.scenario.measures.truncate(before);
            let d = if self.lowerer.graph.moves_along(&[node]) {
                Diagnostic::error("HQ0312", value.span, "a trajectory has no meaning in an expectation")
            } else {
                Diagnostic::error("HQ0311", value.span, "`initial(..)` has no meaning in an expectation")
            };
            self.lowerer.push(d.help("a `let` that holds it belongs into the parameters of tasks"));
            return None;
        };
        let is_state = |at: &usize| {
            let first = self.scenario.table(self.program).measure(0);
            at.checked_sub(first)
                .and_then(|k| self.scenario.measures.get(k))
                .is_some_and(|m| matches!(m, Measure::In(_)))
        };
        self.of_states |= p.value.inputs.iter().any(is_state);
        let known = self.scenario.predicates.iter().position(|k| *k == p);
        Some(known.unwrap_or_else(|| {
            self.scenario.predicates.push(p);
            self.scenario.predicates.len() - 1
        }))
    }
}
