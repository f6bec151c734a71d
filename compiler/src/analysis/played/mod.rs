//! All that can happen in a scenario: which signals are sent and their ranges, the states that the machine may enter, and the
//! predicates that may hold.
//!
//! Everything is a bound from outside: what is found to be impossible does not happen in any run of the scenario. Faults may occur
//! at every tick, but for those of the deadline, which only late ticks cause.

mod numbers;
mod states;
mod truths;

use std::collections::BTreeMap;

use runtime::FaultKind;
use runtime::program::{Measure, Op, Program, ScenarioProgram, Subject};

use super::value_ranges::RangeContext;
use crate::expr::Interval;
use crate::source_map::{ScenarioPlaces, SourceMap};
pub(crate) use states::Missing;
pub(crate) use truths::Truths;

/// Time (s) by which sums of periods may be rounded.
const ROUNDING: f64 = 1e-6;

/// All that can happen in a scenario.
pub(crate) struct Played<'p> {
    /// The program.
    pub program: &'p Program,
    /// The scenario.
    pub scenario: &'p ScenarioProgram,
    /// Its places.
    pub places: &'p ScenarioPlaces,
    source_map: &'p SourceMap,
    context: &'p RangeContext<'p>,
    /// For each signal, true if it may be received.
    pub sent: Vec<bool>,
    /// Ranges of nodes of the graph that are signals, measures and times.
    pins: BTreeMap<usize, Interval>,
    /// Innermost states that may be entered, with the earliest time (s); empty for a run of a stack.
    pub entered: BTreeMap<usize, f64>,
}

impl<'p> Played<'p> {
    /// Examines a scenario, the `index`-th of the program.
    pub fn new(
        program: &'p Program,
        index: usize,
        source_map: &'p SourceMap,
        context: &'p RangeContext<'p>,
    ) -> Option<Played<'p>> {
        let (scenario, places) = (program.scenarios.get(index)?, source_map.scenarios.get(index)?);
        let sent = (0..program.interface.signals.len()).map(|s| numbers::is_sent(program, scenario, s)).collect();
        let (pins, entered) = (BTreeMap::new(), BTreeMap::new());
        let mut played = Played { program, scenario, places, source_map, context, sent, pins, entered };
        played.pin_signals();
        played.entered = played.reached();
        played.pin_measures();
        Some(played)
    }

    /// True for a run of the machine.
    pub fn is_of_machine(&self) -> bool {
        self.scenario.run.subject == Subject::Machine
    }

    /// Pins signals and times to their ranges.
    fn pin_signals(&mut self) {
        let numbers = numbers::ranges(self.program, self.scenario, &self.sent);
        let duration = Interval::new(0.0, self.scenario.run.duration);
        for (node, op) in self.context.graph.ops().iter().enumerate() {
            let range = match op {
                Op::Signal(k) => numbers.get(*k).copied(),
                Op::T | Op::Time => Some(duration),
                _ => None,
            };
            self.pins.extend(range.map(|range| (node, range)));
        }
    }

    /// Pins measures of the run to their ranges.
    fn pin_measures(&mut self) {
        let width = self.program.interface.width();
        for (node, op) in self.context.graph.ops().iter().enumerate() {
            let Op::Signal(k) = op else { continue };
            let measure = k.checked_sub(width).and_then(|k| self.source_map.scenario_measures.get(k));
            let range = measure.map(|m| self.measure(m));
            self.pins.extend(range.map(|range| (node, range)));
        }
    }

    /// Range of a measure.
    fn measure(&self, measure: &Measure) -> Interval {
        match measure {
            Measure::In(state) if self.is_of_machine() && !self.enters(*state) => Interval::point(-1.0),
            Measure::Fault(Some(FaultKind::Deadline)) if !self.misses_the_deadline() => Interval::point(-1.0),
            Measure::In(_) | Measure::Fault(_) => Interval::within(1.0),
            Measure::Margin(_) | Measure::Initial(_) => Interval::ALL,
            Measure::Error { .. }
            | Measure::Speed(_)
            | Measure::LargestSpeed(_)
            | Measure::PointSpeed(_)
            | Measure::Acceleration(_)
            | Measure::LargestAcceleration(_)
            | Measure::PointAcceleration(_)
            | Measure::Reversals(_) => Interval::new(0.0, f64::INFINITY),
        }
    }

    /// True if a tick may come later than the robot's deadline permits.
    pub fn misses_the_deadline(&self) -> bool {
        let (period, deadline) = (self.program.robot.period, self.program.robot.deadline);
        // Scripts that touch count as one.
        let all: f64 = self.scenario.world.late.iter().map(|late| self.skipped(late.1) as f64).sum();
        (all + 1.0) * period > deadline + ROUNDING
    }

    /// Largest number of ticks that a delay (s) skips.
    pub fn skipped(&self, by: f64) -> usize {
        (by / self.program.robot.period - ROUNDING).ceil().max(0.0) as usize
    }

    /// The measures that a predicate reads.
    pub fn measures(&self, predicate: usize) -> impl Iterator<Item = &'p Measure> + use<'p> {
        let first = self.scenario.table(self.program).measure(0);
        let inputs = self.scenario.predicates.get(predicate).map_or(&[][..], |p| p.value.inputs.as_slice());
        let measures = &self.scenario.measures;
        inputs.iter().filter_map(move |at| measures.get(at.checked_sub(first)?))
    }
}
