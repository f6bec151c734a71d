//! Expectations of a robot that runs its program: the measures of their predicates, and predicates without a value.

use std::collections::BTreeSet;

use dsl::tree::{Expect, Value};
use dsl::{Diagnostic, Help, Snippet, Span};
use names::list;
use runtime::expect::Unit;
use runtime::program::{Measure, PredicateTable, Program, ScenarioProgram};
use runtime::world::is_bound_to_its_stack;

use super::expectation_scope::Watch;
use super::formulas::{Source, Ticks};
use super::predicates::{Graphs, measure, mixed, number, predicate};
use super::shapes::Shape;
use super::{Lowerer, expectation_checks};
use crate::binding::{Known, TaskScope};
use crate::robot_binding::BoundRobot;
use crate::source_map::{Atom, ScenarioPlaces};

/// Source of predicates for the expectations of a scenario.
struct OfRobot<'b> {
    robot: &'b BoundRobot,
    program: &'b Program,
    /// The program that runs in the scenario.
    runs: Program,
    shapes: &'b [Option<Shape>],
    scenario: &'b mut ScenarioProgram,
    places: &'b mut ScenarioPlaces,
    /// All measures of the program.
    measures: &'b mut Vec<Measure>,
    /// Nodes whose sign alone is meaningful.
    mixed: BTreeSet<usize>,
    /// Tasks that the predicates of this expectation measure, with the spans of the predicates.
    tasks: Vec<(usize, Span)>,
    /// True if this expectation refers to states.
    of_states: bool,
    /// People of whom it was reported that nobody plays them.
    missed: BTreeSet<usize>,
}

impl Lowerer<'_> {
    /// Lowers the expectations of a scenario whose run is known.
    pub(super) fn expectations(
        &mut self,
        written: (&[Expect], &[String]),
        (scenario, places): (&mut ScenarioProgram, &mut ScenarioPlaces),
        (program, robot, shapes): (&Program, &BoundRobot, &[Option<Shape>]),
        measures: &mut Vec<Measure>,
    ) {
        let period = program.robot.period;
        let count = (scenario.run.duration / period).round() as u32;
        let runs = scenario.program(program);
        let (mixed, tasks, missed) = (BTreeSet::new(), Vec::new(), BTreeSet::new());
        let of_states = false;
        let mut source =
            OfRobot { robot, program, runs, shapes, scenario, places, measures, mixed, tasks, of_states, missed };
        let expectations = self.formulas(written, Ticks { period, count, at: robot.rate_span }, &mut source);
        scenario.expectations = expectations;
    }
}

/// Diagnostic for a measured task that has a value only while its stack runs, if the stack does not run at every tick.
fn no_value(program: &Program, task: usize, at: Span, of_states: bool) -> Option<Diagnostic> {
    let holds = |s: &usize| program.stacks[*s].levels.iter().flat_map(|l| &l.members).any(|m| m.task == task);
    let stacks = program.run_stacks();
    let without: Vec<&str> = stacks.iter().filter(|s| !holds(s)).map(|s| program.stacks[*s].name.as_str()).collect();
    let name = &program.tasks[task].name;
    let text = format!("`{name}` has no value while it does not run");
    let d = Diagnostic::error("HQ0801", at, text)
        .note("its target depends on the time or configuration at which its stack was entered");
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
    Some(d.here(where_).help("restrict it to states: `always (in(STATE) implies ..)`"))
}

/// Diagnostic for a named value that belongs to a stack: a trajectory, or a captured value.
pub(super) fn of_a_stack(moves: bool, at: Span) -> Diagnostic {
    let help = "a `let` that holds it belongs into the parameters of tasks";
    if moves {
        return Diagnostic::error("HQ0312", at, "a trajectory is not allowed in an expectation").help(help);
    }
    Diagnostic::error("HQ0311", at, "a `let` with `initial(..)` is not allowed in an expectation")
        .note("there it captures a value when a stack becomes active, and an expectation belongs to no stack")
        .help("write `initial(..)` in the expectation itself: the value at the start of the run")
}

impl OfRobot<'_> {
    /// Warns of a comparison that reads the position of a person whom nobody plays in the scenario.
    fn not_played(&mut self, inputs: &[usize], value: &Value) -> Option<Diagnostic> {
        // A comparison that asks for the presence of a person has a value without readings.
        if expectation_checks::asks_for_presence(value) {
            return None;
        }
        let at = value.span;
        let interface = &self.program.interface;
        let of_position = |number: usize| {
            let index = interface.signal_of(number).filter(|_| number < interface.width())?;
            let signal = interface.signals.get(index)?;
            let person = interface.humans.iter().position(|human| human.points.contains(&index))?;
            (signal.at < number && number <= signal.at + signal.len).then_some(person)
        };
        let played = |person: &usize| self.scenario.world.humans.iter().any(|script| script.human == *person);
        let person = inputs.iter().filter_map(|i| of_position(*i)).find(|person| !played(person))?;
        let name = &interface.humans[person].name;
        if !self.missed.insert(person) {
            return None;
        }
        let text = format!("nobody plays `{name}` in this scenario");
        let d = Diagnostic::warning("HQ0810", at, text).here("false at every tick");
        let script =
            Snippet::block("humans", [Snippet::block(name, [Snippet::entry("value", "[1, 0, 0] m"), Snippet::dots()])]);
        Some(
            d.note("a comparison with a position that is never received is false, so `never` holds and `always` fails")
                .help(Help::with("say where the person is: {}", [script])),
        )
    }
}

impl Source for OfRobot<'_> {
    fn is_of_robot(&self) -> bool {
        true
    }

    fn units(&self) -> Vec<Unit> {
        self.scenario.units()
    }

    fn whole(&mut self) -> Option<Diagnostic> {
        let (tasks, of_states) = (std::mem::take(&mut self.tasks), std::mem::take(&mut self.of_states));
        let remembers = |task: usize| self.shapes[task].as_ref().is_some_and(|s| s.remembers_entry);
        let bound = |task: usize| remembers(task) || is_bound_to_its_stack(self.program, task);
        tasks.iter().filter(|t| bound(t.0)).find_map(|&(task, at)| no_value(&self.runs, task, at, of_states))
    }

    fn predicate(&mut self, lowerer: &mut Lowerer, value: &Value) -> Option<usize> {
        let Lowerer { graph, table, params, diagnostics, used_tasks, .. } = lowerer;
        let width = self.program.interface.width();
        let fault = measure(graph, width, self.measures, Measure::Fault(None));
        let (forms, axes, mut named) = (Default::default(), Default::default(), BTreeSet::new());
        let mut scope = Watch {
            inner: TaskScope::free(self.robot, params, table, Known { forms: &forms, axes: &axes }),
            program: self.program,
            shapes: self.shapes,
            measures: self.measures,
            mixed: &mut self.mixed,
            fault,
            named: &mut named,
            used: &mut self.scenario.measures,
            capturing: false,
        };
        let found = number(value, graph, &mut scope, diagnostics);
        // Measured tasks count as used.
        used_tasks.extend(named.iter().map(|&t| self.program.tasks[t].name.clone()));
        self.tasks.extend(named.into_iter().map(|t| (t, value.span)));
        let found = mixed(graph, found?, &self.mixed);
        let before = self.scenario.measures.len();
        let layout = PredicateTable { signals: width, measures: 0 };
        let p = predicate(found, Graphs { graph, table, width }, layout, (self.measures, &mut self.scenario.measures));
        let Some(p) = p else {
            self.scenario.measures.truncate(before);
            let d = of_a_stack(lowerer.graph.moves_along(&[found.0]), value.span);
            lowerer.push(d);
            return None;
        };
        lowerer.diagnostics.extend(self.not_played(&p.value.inputs, value));
        let is_state = |at: &usize| {
            let first = self.scenario.table(self.program).measure(0);
            at.checked_sub(first)
                .and_then(|k| self.scenario.measures.get(k))
                .is_some_and(|m| matches!(m, Measure::In(_)))
        };
        self.of_states |= p.value.inputs.iter().any(is_state);
        let known = self.scenario.predicates.iter().position(|k| *k == p);
        let predicate = known.unwrap_or_else(|| {
            self.scenario.predicates.push(p);
            self.places.nodes.push(found.0);
            self.scenario.predicates.len() - 1
        });
        self.places.atoms.push(Atom { at: value.span, predicate });
        Some(predicate)
    }
}
