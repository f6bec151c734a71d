//! Monitors of the expectations of a scenario while its mission is executed.

use stdlib_tasks::expression::{Expression, Op};

use crate::expect::{MAX_KEPT, Monitor, Outcome, PushError, Unit};
use crate::program::{MissionMeasure, MissionScenarioProgram, PredicateTable, ProgramError, error};

/// Predicate prepared for evaluation: an expression of the table of numbers alone.
struct ReadyPredicate {
    expression: Expression,
    registers: Vec<f64>,
    unit: Unit,
}

impl ReadyPredicate {
    /// Value of the predicate. The expression has passed [`Expression::check_alone`] for a table of this length.
    fn value(&mut self, table: &[f64]) -> f64 {
        let ReadyPredicate { expression, registers, unit } = self;
        for (i, op) in expression.ops.iter().enumerate() {
            let (before, rest) = registers.split_at_mut(i);
            let leaf = |op: Op| match op {
                Op::Input(k) => expression.inputs.get(k).and_then(|&at| table.get(at)).copied().unwrap_or(f64::NAN),
                _ => f64::NAN,
            };
            rest[0] = op.value(|a| before[a], leaf);
        }
        let number = expression.outputs.first().and_then(|&o| registers.get(o)).copied().unwrap_or(f64::NAN);
        match unit {
            // Only the sign of a truth value counts.
            Unit::Truth if number > 0.0 => f64::INFINITY,
            Unit::Truth if number <= 0.0 => f64::NEG_INFINITY,
            _ => number,
        }
    }
}

/// Monitors of all expectations of a scenario.
pub(super) struct MissionMonitors {
    layout: PredicateTable,
    measures: Vec<MissionMeasure>,
    predicates: Vec<ReadyPredicate>,
    monitors: Vec<Monitor>,
    table: Vec<f64>,
    row: Vec<f64>,
}

impl MissionMonitors {
    /// Prepares the monitors of a scenario of a checked program.
    ///
    /// # Errors
    /// A formula would need too much memory, which the compiler excludes.
    pub(super) fn new(scenario: &MissionScenarioProgram) -> Result<MissionMonitors, ProgramError> {
        let (units, layout) = (scenario.units(), scenario.table());
        let (mut monitors, mut kept) = (Vec::with_capacity(scenario.expectations.len()), 0_usize);
        for e in &scenario.expectations {
            let monitor = Monitor::new(&e.formula, &units, scenario.instants())?;
            kept = kept.saturating_add(monitor.kept());
            if kept > MAX_KEPT {
                return Err(error("expectations", "their windows have too many instants to be watched together"));
            }
            monitors.push(monitor);
        }
        let ready = |p: &crate::program::Predicate| ReadyPredicate {
            registers: vec![f64::NAN; p.value.ops.len()],
            expression: p.value.clone(),
            unit: p.unit,
        };
        Ok(MissionMonitors {
            measures: scenario.measures.clone(),
            predicates: scenario.predicates.iter().map(ready).collect(),
            monitors,
            table: vec![f64::NAN; layout.width()],
            row: vec![f64::NAN; units.len()],
            layout,
        })
    }

    /// Evaluates the predicates at an instant; `value` returns the value of a measure.
    pub(super) fn instant(&mut self, time: f64, value: &dyn Fn(&MissionMeasure) -> f64) -> Result<(), PushError> {
        self.table[PredicateTable::T] = time;
        self.table[PredicateTable::TIME] = time;
        for (k, measure) in self.measures.iter().enumerate() {
            self.table[self.layout.measure(k)] = value(measure);
        }
        for (ready, out) in self.predicates.iter_mut().zip(&mut self.row) {
            *out = ready.value(&self.table);
        }
        self.monitors.iter_mut().try_for_each(|monitor| monitor.push(&self.row))
    }

    /// Outcome of each expectation, in the order written.
    pub(super) fn finish(self) -> Vec<Outcome> {
        self.monitors.into_iter().map(Monitor::finish).collect()
    }
}
