//! Targets that still move when their state is left, or that their gain does not reach by then, so that `reached` never holds
//! there.

use dsl::Diagnostic;
use runtime::program::{Op, Times, Trigger};
use runtime::text::number;
use runtime::{Evaluator, RestInputs};
use solver::Problem;

use super::Checked;
use crate::analysis::stacks::postures;

/// Factor by which an error may decay faster than its gain says, by the motion of other tasks.
const SLACK: f64 = 1.2;

/// Relative difference up to which errors at different entries are the same.
const SAME: f64 = 1e-6;

/// Number of random postures, beside home, at which errors are compared.
const POSTURES: usize = 3;

/// Largest number of instants at which a target is evaluated.
const SAMPLES: usize = 400;

/// Time (s) for which a target is followed in a state that no time leaves.
const LONG: f64 = 3600.0;

impl Checked<'_> {
    /// Warns of `reached` for a target that depends on the time and does not come to rest in the state.
    pub(super) fn restless(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            let transitions = &self.machine.states[s].transitions;
            let end = transitions
                .iter()
                .enumerate()
                .filter(|(i, _)| !self.is_dead(s, *i))
                .filter_map(|(i, t)| if let Trigger::After(time) = t.trigger { Some((time, i)) } else { None });
            let end = end.min_by(|a, b| a.0.total_cmp(&b.0));
            for (i, t) in transitions.iter().enumerate() {
                let Some((task, tolerances)) = self.awaited(s, i, &t.trigger) else { continue };
                let leaves: Vec<usize> = self.leaves(s).collect();
                let until = end.map_or(LONG, |e| e.0);
                let rests =
                    |&l: &usize| self.machine.stack(l).is_none_or(|stack| self.comes_to_rest(stack, task, until));
                if leaves.is_empty() || leaves.iter().any(rests) {
                    if let (Some((time, k)), false) = (end, leaves.is_empty()) {
                        let needed = leaves.iter().map(|&l| self.time_to_reach(l, task, tolerances));
                        let needed = needed.map(|n| n.unwrap_or(0.0)).fold(f64::INFINITY, f64::min);
                        if needed > SLACK * time {
                            diagnostics.push(self.too_slow(s, [i, k], task, [time, needed]));
                        }
                    }
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
                let mut d =
                    Diagnostic::warning("HQ0706", place[i].trigger, "this transition is never taken").here(text);
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

    /// Task, with its tolerances, that must be reached for a transition to be taken, alone or together with others.
    fn awaited<'t>(&'t self, state: usize, index: usize, trigger: &'t Trigger) -> Option<(usize, &'t [f64])> {
        let criterion = match trigger {
            Trigger::Reached(criterion) => criterion,
            Trigger::When { .. } => {
                let demands = &self.places.transitions[state][index].demands;
                &self.machine.reached.iter().find(|r| demands.contains(&r.signal))?.criterion
            }
            _ => return None,
        };
        Some((criterion.task, &criterion.tolerances))
    }

    /// False if a target depends on the time since the entry and moves at all times until `until` (s). Nothing is claimed of
    /// targets that signals or trajectories move.
    fn comes_to_rest(&self, stack: usize, task: usize, until: f64) -> bool {
        let Some(member) = self.stacks.members(stack).iter().find(|m| m.program_index == task) else { return true };
        let slots = &member.slots;
        let tape = self.program.values.tape.only(&slots.iter().copied().collect());
        let follows = !tape.signals().is_empty() || !tape.trajectories.is_empty();
        if follows || !tape.ops.iter().any(|op| matches!(op, Op::T | Op::Time)) {
            return true;
        }
        let (home, rest) = (&self.program.robot.home, RestInputs::present(self.program));
        let period = self.program.robot.period;
        // The first tick does not count, because a target may begin at rest. Times grow towards the end.
        let first = 2.0 * period;
        let steps = SAMPLES.min(((until - first) / period) as usize).max(1);
        let growth = (until / first).max(1.0).powf(1.0 / steps as f64);
        let even = (until - first) / steps as f64;
        let rests = |evaluator: &mut Evaluator, problem: &mut Problem| {
            evaluator.enter(home, rest.at(Times::default()));
            (0..=steps).any(|k| {
                let t = if until < LONG { first + even * k as f64 } else { first * growth.powi(k as i32) };
                let failed = evaluator.update(home, rest.at(Times { t, time: t }), problem).is_err();
                failed || slots.iter().all(|&at| evaluator.is_settled(at))
            })
        };
        self.stacks.with(stack, rests).unwrap_or(true)
    }

    /// Warning of a target that is not reached before its state is left.
    fn too_slow(&self, s: usize, [i, k]: [usize; 2], task: usize, [time, needed]: [f64; 2]) -> Diagnostic {
        let (name, place) = (&self.program.tasks[task].name, &self.places.transitions[s]);
        Diagnostic::warning("HQ0706", place[i].trigger, "this transition is never taken")
            .here(format!("with its gain, `{name}` needs {needed:.1} s"))
            .label(place[k].trigger, format!("`{}` is left after {} s", self.name(s), number(time)))
            .note("an error decays with the gain of its task, from that at the entry")
            .help("write a longer time, a larger tolerance, or a larger `gain`")
    }

    /// Least time (s) in which the errors of a target decay to their tolerances in an innermost state, if they are the same at
    /// every entry.
    fn time_to_reach(&self, leaf: usize, task: usize, tolerances: &[f64]) -> Option<f64> {
        let index = self.machine.stack(leaf)?;
        let stack = self.program.stacks.get(index)?;
        let member = self.stacks.members(index).iter().find(|m| m.program_index == task)?;
        let tape = self.program.values.tape.only(&member.slots.iter().copied().collect());
        if tape.ops.iter().any(|op| matches!(op, Op::T | Op::Time | Op::Signal(_) | Op::Trajectory(_))) {
            return None;
        }
        let place = stack.levels.iter().flat_map(|l| &l.members).position(|m| m.task == task)?;
        let built = self.stacks.tasks(index).get(place)?.task.as_ref().ok()?;
        let gain = built.gains(&self.program.values.initial).into_iter().reduce(f64::max).filter(|g| *g > 0.0)?;
        let rest = RestInputs::present(self.program);
        let same_everywhere = |evaluator: &mut Evaluator, problem: &mut Problem| {
            let mut errors: Option<Vec<f64>> = None;
            for q in postures(self.program, POSTURES) {
                evaluator.enter(&q, rest.at(Times::default()));
                evaluator.update(&q, rest.at(Times::default()), problem).ok()?;
                let all = evaluator.measures().get(member.measures.clone())?;
                let now: Vec<f64> = all.iter().map(|e| e.abs()).collect();
                let same = |known: &Vec<f64>| known.iter().zip(&now).all(|(a, b)| (a - b).abs() <= SAME * a.max(1.0));
                if errors.as_ref().is_some_and(|known| !same(known)) {
                    return None;
                }
                errors = Some(now);
            }
            errors
        };
        let errors = self.stacks.with(index, same_everywhere)?;
        let period = self.program.robot.period;
        let factor = 1.0 - gain * period;
        let times = errors?.into_iter().zip(tolerances).map(|(e, tolerance)| match e > *tolerance && factor > 0.0 {
            true => (tolerance / e).ln() / factor.ln() * period,
            false => 0.0,
        });
        times.reduce(f64::max)
    }
}
