//! Targets that still move when their state is left, so that `reached` never holds there.

use dsl::Diagnostic;
use runtime::program::{Op, Times, Trigger};
use runtime::text::number;
use runtime::{Evaluator, RestInputs};

use super::Checked;

/// Largest number of instants at which a target is evaluated.
const SAMPLES: usize = 400;

/// Time (s) for which a target is followed in a state that no time leaves.
const LONG: f64 = 3600.0;

impl Checked<'_> {
    /// Warns of `reached` for a target that depends on the time and does not come to rest in the state.
    pub(super) fn restless(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            let transitions = &self.machine.states[s].transitions;
            let end = transitions.iter().enumerate().filter(|(i, _)| !self.is_dead(s, *i)).filter_map(|(i, t)| {
                if let Trigger::After(time) = t.trigger { Some((time, i)) } else { None }
            });
            let end = end.min_by(|a, b| a.0.total_cmp(&b.0));
            for (i, t) in transitions.iter().enumerate() {
                let Trigger::Reached { task, .. } = t.trigger else { continue };
                let leaves: Vec<usize> = self.leaves(s).collect();
                let until = end.map_or(LONG, |e| e.0);
                let rests = |&l: &usize| self.machine.stack(l).is_none_or(|stack| self.comes_to_rest(stack, task, until));
                if leaves.is_empty() || leaves.iter().any(rests) {
                    continue;
                }
                let name = &self.program.tasks[task].name;
                let place = &self.places.transitions[s];
                let (text, label) = match end {
                    Some((time, k)) => (
                        format!("the target of `{name}` still moves when `{}` is left", self.name(s)),
                        Some((place[k].trigger, format!("left after {} s", number(time)))),
                    ),
                    None => (format!("the target of `{name}` never comes to rest"), None),
                };
                let mut d = Diagnostic::warning("HQ0706", place[i].trigger, "this transition is never taken").here(text);
                if let Some((at, label)) = label {
                    d = d.label(at, label);
                }
                diagnostics.push(d.note("a target is reached when it is at rest").help(match end {
                    Some(_) => "write a longer time, or a faster motion",
                    None => "wait for a time or an event, or let the target come to rest",
                }));
            }
        }
    }

    /// False if a target depends on the time since the entry and moves at all times until `until` (s). Nothing is claimed of
    /// targets that signals or trajectories move.
    fn comes_to_rest(&self, stack: usize, task: usize, until: f64) -> bool {
        let Ok((mut evaluator, mut problem)) = Evaluator::new(self.program, stack) else { return true };
        let Some(slots) = evaluator.members().iter().find(|m| m.program_index == task).map(|m| m.slots.clone()) else {
            return true;
        };
        let tape = self.program.values.tape.only(&slots.iter().copied().collect());
        let follows = !tape.signals().is_empty() || !tape.trajectories.is_empty();
        if follows || !tape.ops.iter().any(|op| matches!(op, Op::T | Op::Time)) {
            return true;
        }
        let (home, rest) = (&self.program.robot.home, RestInputs::present(self.program));
        evaluator.enter(home, rest.at(Times::default()));
        let period = self.program.robot.period;
        // The first tick does not count, because a target may begin at rest. Times grow towards the end.
        let first = 2.0 * period;
        let steps = SAMPLES.min(((until - first) / period) as usize).max(1);
        let growth = (until / first).max(1.0).powf(1.0 / steps as f64);
        let even = (until - first) / steps as f64;
        (0..=steps).any(|k| {
            let t = if until < LONG { first + even * k as f64 } else { first * growth.powi(k as i32) };
            let failed = evaluator.update(home, rest.at(Times { t, time: t }), &mut problem).is_err();
            failed || slots.iter().all(|&at| evaluator.is_settled(at))
        })
    }
}
