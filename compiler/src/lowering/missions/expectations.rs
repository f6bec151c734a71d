//! Expectations of a scenario of a mission: their scope, predicates and formulas.

use dsl::tree::{BinaryOp, Expect, Value, ValueKind};
use dsl::{Diagnostic, Span};
use runtime::expect::Unit;
use runtime::program::{MissionMeasure, MissionScenarioProgram, Op, PredicateTable};

use super::super::Lowerer;
use super::super::formulas::{Source, Ticks};
use super::super::predicates::{Graphs, measure, number, predicate};
use super::executed::Executed;
use super::expectation_scope::Watch;
use super::runs::Machines;
use crate::expr::Graph;

/// Source of the predicates of a scenario of a mission.
struct OfMissions<'b> {
    of: Executed<'b>,
    machines: &'b Machines,
    scenario: &'b mut MissionScenarioProgram,
    /// Everything that was measured for any of them.
    measures: Vec<MissionMeasure>,
}

impl Lowerer<'_> {
    /// The expectations of a scenario whose run is known. `at` is where its step was written.
    pub(super) fn mission_expectations(
        &mut self,
        written: (&[Expect], &[String]),
        (of, machines): (Executed, &Machines),
        scenario: &mut MissionScenarioProgram,
        at: Span,
    ) {
        let ticks = Ticks { period: scenario.step, count: scenario.instants(), at };
        let mut source = OfMissions { of, machines, scenario, measures: Vec::new() };
        let expectations = self.formulas(written, ticks, &mut source);
        scenario.expectations = expectations;
    }
}

/// True for `<` and `>`.
fn is_strict(value: &Value) -> bool {
    matches!(&value.kind, ValueKind::Binary(op, ..) if matches!(op.value, BinaryOp::Less | BinaryOp::Greater))
}

/// A number that is below zero where this one is zero, and the same elsewhere. A formula is true from zero on; what is
/// measured of a mission are often counts, of which `served < 3` must not hold at 3.
fn strictly(graph: &mut Graph, node: usize) -> usize {
    let least = graph.number(f64::MIN_POSITIVE);
    graph.push(Op::Sub(node, least))
}

impl Source for OfMissions<'_> {
    fn units(&self) -> Vec<Unit> {
        self.scenario.units()
    }

    fn predicate(&mut self, lowerer: &mut Lowerer, value: &Value) -> Option<usize> {
        let width = lowerer.interface.width();
        let Lowerer { graph, table, params, diagnostics, .. } = lowerer;
        let done = measure(graph, width, &mut self.measures, MissionMeasure::of_mission("done"));
        let (of, measures) = (self.of, &mut self.measures);
        let machines = (self.machines, self.scenario.sampled);
        let mut scope = Watch { params, of, machines, measures, width, done };
        let (node, unit) = number(value, graph, &mut scope, diagnostics)?;
        let node = if is_strict(value) && matches!(unit, Unit::Quantity(_)) { strictly(graph, node) } else { node };
        let before = self.scenario.measures.len();
        let used = &mut self.scenario.measures;
        let layout = PredicateTable { signals: 0, measures: 0 };
        let Some(p) = predicate((node, unit), Graphs { graph, table, width }, layout, (&self.measures, used)) else {
            self.scenario.measures.truncate(before);
            let text = "values of a robot's controller are not available in a scenario of a mission";
            let d = Diagnostic::error("HQ0312", value.span, text);
            let example = self.of.example().0;
            lowerer.push(d.help(format!("compare measures of the mission, `{example}.position`, with constants")));
            return None;
        };
        let known = self.scenario.predicates.iter().position(|k| *k == p);
        Some(known.unwrap_or_else(|| {
            self.scenario.predicates.push(p);
            self.scenario.predicates.len() - 1
        }))
    }
}
