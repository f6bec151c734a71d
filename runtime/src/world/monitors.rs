//! Evaluates the expectations of a scenario during its run.

use robot::{Data, Model};
use stdlib_tasks::expression::Evaluation;
use stdlib_tasks::task::State;

use super::measures::Measures;
use crate::expect::{MAX_KEPT, Monitor, Outcome};
use crate::program::Unit;
use crate::program::{Measure, PredicateTable, Program, ProgramError, ScenarioProgram, error};
use crate::tick::{Recorder, Tick};

/// Recorder that returns the outcome of each expectation at the end.
pub struct ExpectationMonitors {
    model: Model,
    data: Data,
    measures: Measures,
    predicates: Vec<(Evaluation, Unit)>,
    /// Values at the start of the run, each with its index in the table; empty once they are known.
    starts: Vec<(usize, Evaluation)>,
    monitors: Vec<Monitor>,
    layout: PredicateTable,
    /// Numbers that predicates read, and their rates, which are zero.
    table: Vec<f64>,
    rates: Vec<f64>,
    /// One number for each predicate.
    row: Vec<f64>,
}

impl ExpectationMonitors {
    /// Prepares a scenario of a checked program, for a run of so many ticks.
    ///
    /// # Errors
    /// A formula would need too much memory, which the compiler excludes.
    pub fn new(
        program: &Program,
        scenario: &ScenarioProgram,
        ticks: usize,
    ) -> Result<ExpectationMonitors, ProgramError> {
        let model = program.robot.model.clone();
        let units = scenario.units();
        let ticks = u32::try_from(ticks).unwrap_or(u32::MAX);
        let layout = scenario.table(program);
        let (mut monitors, mut kept) = (Vec::with_capacity(scenario.expectations.len()), 0_usize);
        for e in &scenario.expectations {
            let monitor = Monitor::new(&e.formula, &units, ticks)?;
            kept = kept.saturating_add(monitor.kept());
            if kept > MAX_KEPT {
                return Err(error("expectations", "their windows have too many ticks to be watched together"));
            }
            monitors.push(monitor);
        }
        let moved = scenario.true_program(program);
        let truth = moved.as_ref().unwrap_or(program);
        let start = |(k, m): (usize, &Measure)| match m {
            Measure::Initial(e) => Some((layout.measure(k), Evaluation::new(e, &model))),
            _ => None,
        };
        let starts = scenario.measures.iter().enumerate().filter_map(start).collect();
        Ok(ExpectationMonitors {
            starts,
            data: Data::new(&model),
            measures: Measures::new(truth, &scenario.measures)?,
            predicates: scenario.predicates.iter().map(|p| (Evaluation::new(&p.value, &model), p.unit)).collect(),
            monitors,
            table: vec![f64::NAN; layout.width()],
            rates: vec![0.0; layout.width()],
            row: vec![f64::NAN; units.len()],
            layout,
            model,
        })
    }

    /// Outcome of each expectation, in the order written.
    pub fn finish(self) -> Vec<Outcome> {
        self.monitors.into_iter().map(Monitor::finish).collect()
    }
}

impl Recorder for ExpectationMonitors {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let ExpectationMonitors { model, data, measures, predicates, starts, layout, table, rates, row, .. } = self;
        table[PredicateTable::T] = tick.time - tick.controller.stack_entered();
        table[PredicateTable::TIME] = tick.time;
        table[layout.signal(0)..layout.measure(0)].copy_from_slice(tick.signals);
        measures.tick(tick, &mut table[layout.measure(0)..]);
        model.forward(tick.q, data);
        let velocity = tick.command;
        for (place, mut value) in starts.drain(..) {
            let state = State { model, data, q: tick.q, values: table, rates, velocity, stack_velocity: velocity };
            table[place] = if value.forward(&state).is_ok() { value.value(0) } else { f64::NAN };
        }
        let state = State { model, data, q: tick.q, values: table, rates, velocity, stack_velocity: velocity };
        for ((value, unit), out) in predicates.iter_mut().zip(row.iter_mut()) {
            let number = if value.forward(&state).is_ok() { value.value(0) } else { f64::NAN };
            *out = match unit {
                // Only the sign of a truth value counts.
                Unit::Truth if number > 0.0 => f64::INFINITY,
                Unit::Truth if number <= 0.0 => f64::NEG_INFINITY,
                _ => number,
            };
        }
        for monitor in &mut self.monitors {
            monitor.push(&self.row).map_err(std::io::Error::other)?;
        }
        Ok(())
    }
}
