//! First readings that arrive later than the first stack waits for them.

use dsl::Diagnostic;
use runtime::FaultKind;
use runtime::program::{FaultPattern, Measure, Trigger};
use stdlib_tasks::dimension::TIME;

use super::Scene;
use crate::checks::scenario_start::first_stack;
use crate::units::shown;

/// Rounding error of a sum of times (s).
const ROUNDING: f64 = 1e-9;

/// First reading of a signal in a scenario.
struct First<'n> {
    /// Index of the signal.
    signal: usize,
    /// Class and name of its script.
    class: &'static str,
    name: &'n str,
    /// Time of its arrival (s).
    arrives: f64,
}

impl Scene<'_> {
    /// Warns of a first reading that the first stack needs and that arrives after the run has given it up, unless that is
    /// what is expected or handled.
    pub(super) fn late_readings(&self, out: &mut Vec<Diagnostic>) {
        let Some(stack) = first_stack(self.program, self.scenario) else { return };
        if self.scenario.measures.contains(&Measure::Fault(Some(FaultKind::Stale))) || self.handles_stale() {
            return;
        }
        let needs = self.stacks.needs(stack);
        let period = self.program.robot.period;
        for first in self.first_readings() {
            let Some(s) = self.program.interface.signals.get(first.signal) else { continue };
            let patience = s.timeout.filter(|_| !s.optional).unwrap_or(0.0);
            let tick = (first.arrives / period - ROUNDING).ceil() * period;
            if !needs.contains(&first.signal) || tick <= patience + ROUNDING {
                continue;
            }
            let at = self.of_script(first.class, first.name, &["delay", "from"]);
            let text = format!("the first reading of `{}` arrives at {}", first.name, shown(first.arrives, TIME));
            let note = match s.timeout {
                _ if s.optional => {
                    "a stack does not wait for a signal that may be absent, written with `?`".to_string()
                }
                None => "a stack does not wait for a signal without a `timeout`".to_string(),
                Some(timeout) => format!("the first stack waits for it until its `timeout`, {}", shown(timeout, TIME)),
            };
            out.push(Diagnostic::warning("HQ0827", at, text).note(note).note("then it is the fault `stale`").help(
                "send it earlier, give the signal a longer `timeout`, or begin in a state that does not need it",
            ));
        }
    }

    /// First readings of signals and people that scripts send, one for each.
    fn first_readings(&self) -> Vec<First<'_>> {
        let (interface, world) = (&self.program.interface, &self.scenario.world);
        let signals = world.signals.iter().filter_map(|s| {
            let name = interface.signals.get(s.signal)?.name.as_str();
            Some(First { signal: s.signal, class: "signals", name, arrives: s.from + s.delay })
        });
        let people = world.humans.iter().filter_map(|h| {
            let human = interface.humans.get(h.human)?;
            let (signal, name) = (*human.points.first()?, human.name.as_str());
            Some(First { signal, class: "humans", name, arrives: h.sending.from + h.sending.delay })
        });
        let mut all: Vec<First> = Vec::new();
        for first in signals.chain(people) {
            match all.iter_mut().find(|known| known.signal == first.signal) {
                Some(known) => known.arrives = known.arrives.min(first.arrives),
                None => all.push(first),
            }
        }
        all
    }

    /// True if the machine has a transition for stale signals.
    fn handles_stale(&self) -> bool {
        let transitions = self.program.machine.iter().flat_map(|m| m.states.iter().flat_map(|s| &s.transitions));
        transitions.into_iter().any(|t| match &t.trigger {
            Trigger::Fault(pattern) => matches!(
                pattern,
                FaultPattern::Stale(_) | FaultPattern::StaleAmong(_) | FaultPattern::Kind(FaultKind::Stale)
            ),
            _ => false,
        })
    }
}
