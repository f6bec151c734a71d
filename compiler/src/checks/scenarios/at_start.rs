//! Expectations that the start of the run decides: those that are true at the first tick, and those that ask for an error to decay
//! faster than its gain permits.

use dsl::{Diagnostic, Help, Snippet};
use runtime::expect::{Node, Window};
use runtime::program::{Measure, Op, Subject, Times};
use runtime::text::number;
use runtime::{Member, TickInputs};
use stdlib_tasks::expression::Expression;

use super::Scene;
use crate::analysis::stacks::Prepared;
use crate::checks::scenario_start::{first_stack, signals_at_start};
use crate::units::shown;

/// Factor by which an error may decay faster than its gain says, by the motion of other tasks.
const SLACK: f64 = 1.2;

/// Part of the standard deviation of an error below which it does not stay at all ticks.
const DEVIATION: f64 = 0.5;

/// Part of the standard deviation that a single deviation is rarely smaller than.
const RARELY: f64 = 0.02;

/// Number of ticks from which on an error that fluctuates does not stay small.
const TICKS: f64 = 100.0;

/// A predicate of one measure of a task that decides an expectation.
struct Asked<'a> {
    value: &'a Expression,
    task: usize,
    part: Option<usize>,
    is_margin: bool,
    window: Window,
    always: bool,
}

/// The first stack of a scenario at its first tick.
struct FirstTick {
    stack: usize,
    prepared: Prepared,
}

impl Scene<'_> {
    /// Warns of expectations that are decided by the start.
    pub(super) fn decided_at_start(&self, out: &mut Vec<Diagnostic>) {
        let asked: Vec<(usize, Asked)> =
            (0..self.scenario.expectations.len()).filter_map(|e| Some((e, self.asked(e)?))).collect();
        if asked.is_empty() {
            return;
        }
        let Some(first) = self.first_tick() else { return };
        for (e, asked) in asked {
            let members = first.prepared.evaluator.members();
            let Some(member) = members.iter().find(|m| m.program_index == asked.task) else { continue };
            let at = self.written.expects[e].formula.span;
            if Self::is_reported(out, &["HQ0811", "HQ0812"], at) {
                continue;
            }
            let found = self.at_once(&first, member, &asked).or_else(|| self.too_fast(&first, member, &asked));
            let found = found.or_else(|| self.below_the_noise(&first, member, &asked));
            out.extend(found.map(|d| {
                let mut d = d;
                d.primary.span = at;
                d
            }));
        }
    }

    /// The expectation of a measure in a window; `None` for others.
    fn asked(&self, expectation: usize) -> Option<Asked<'_>> {
        let formula = &self.scenario.expectations[expectation].formula;
        let (always, window, inner) = match formula.nodes.last()? {
            Node::Always(window, a) => (true, *window, *a),
            Node::Eventually(window, a) => (false, *window, *a),
            Node::Within(ticks, a) => (false, Window { first: 0, last: Some(*ticks) }, *a),
            _ => return None,
        };
        let Node::Predicate(p) = formula.nodes.get(inner)? else { return None };
        let value = &self.scenario.predicates.get(*p)?.value;
        let mut measures = self.played.measures(*p);
        let measure = measures.next().filter(|_| measures.next().is_none() && value.inputs.len() == 1)?;
        let (task, part, is_margin) = match measure {
            Measure::Margin(task) => (*task, None, true),
            Measure::Error { task, part } => (*task, *part, false),
            _ => return None,
        };
        value.leaves.is_empty().then_some(Asked { value, task, part, is_margin, window, always })
    }

    fn first_tick(&self) -> Option<FirstTick> {
        let (program, scenario) = (self.program, self.scenario);
        let stack = first_stack(program, scenario)?;
        let signals = signals_at_start(program, scenario, &self.stacks.needs(stack))?;
        let mut prepared = self.stacks.take(stack)?;
        let Prepared { evaluator, problem } = &mut prepared;
        let velocity = vec![0.0; program.robot.model.nv()];
        let inputs =
            TickInputs { times: Times::default(), signals: &signals, velocity: &velocity, stack_velocity: &velocity };
        evaluator.enter(&scenario.start, inputs);
        evaluator.update(&scenario.start, inputs, problem).ok()?;
        Some(FirstTick { stack, prepared })
    }

    /// Warning of an `eventually` that is true at the first tick.
    fn at_once(&self, first: &FirstTick, member: &Member, asked: &Asked) -> Option<Diagnostic> {
        // An error is often small at the start of a motion that leaves and comes back.
        if asked.always || asked.window.first > 0 || !asked.is_margin {
            return None;
        }
        let x = measured(first, member, asked)?;
        let true_now = holds(asked.value, x)?;
        let name = &member.name;
        true_now.then(|| {
            let d = Diagnostic::warning("HQ0819", self.written.name.span, "this is true at the first tick already");
            let d = d.note(format!("`{name}` is kept at the start, and what follows does not matter"));
            d.help(Help::with(
                "write {} if it is meant of the whole run, or a window that begins later, {}",
                [Snippet::same("always"), Snippet::same("eventually from 5 s : ..")],
            ))
        })
    }

    /// Warning of an error that must always be smaller than what the noise of the encoders makes of it. The reference begins at the
    /// first reading, so that a joint deviates by the noise `s` of that reading; with a tracking gain `k` the controller follows
    /// each reading, and a joint deviates by `s sqrt(kT / (2 - kT))`.
    fn below_the_noise(&self, first: &FirstTick, member: &Member, asked: &Asked) -> Option<Diagnostic> {
        let (noise, duration) = (self.scenario.run.simulator.noise, self.scenario.run.duration);
        let period = self.program.robot.period;
        let follows = self.program.robot.tracking_gain * period;
        let last = asked.window.last.map_or(f64::INFINITY, f64::from).min(duration / period);
        let enough = last - f64::from(asked.window.first) >= TICKS;
        if asked.is_margin || !asked.always || noise <= 0.0 || !(0.0..1.0).contains(&follows) || !enough {
            return None;
        }
        let dimension = member.measure_info.get(asked.part.unwrap_or(0))?.dimension;
        let level = first.prepared.problem.levels.get(member.level)?;
        let rows = member.rows.clone().zip(&member.row_info).filter(|(_, info)| info.dimension == dimension);
        let norm = |r: usize| level.row(r).iter().map(|a| a * a).sum::<f64>().sqrt();
        let lever = rows.map(|(r, _)| norm(r)).reduce(f64::max)?;
        let (of_joint, least) = match follows > 0.0 {
            true => (noise * (follows / (2.0 - follows)).sqrt(), DEVIATION),
            false => (noise, RARELY),
        };
        let deviation = of_joint * lever;
        if deviation <= 0.0 || !holds(asked.value, 0.0)? || holds(asked.value, least * deviation)? {
            return None;
        }
        let size = |x: f64| shown(format!("{x:.2e}").parse().unwrap_or(x), dimension);
        let text = format!("the noise of the encoders moves `{}` by more than this", member.name);
        Some(
            Diagnostic::warning("HQ0820", self.written.name.span, text)
                .note(format!(
                    "the reference begins at a reading: a noise of {} mrad gives a standard deviation of {}",
                    number(1e3 * noise),
                    size(deviation)
                ))
                .help("write a larger tolerance, or a smaller `noise` of the simulator"),
        )
    }

    /// Warning of an error that must be small before it can decay, for a target at rest.
    fn too_fast(&self, first: &FirstTick, member: &Member, asked: &Asked) -> Option<Diagnostic> {
        let (program, period) = (self.program, self.program.robot.period);
        let tape = program.values.tape.only(&member.slots.iter().copied().collect());
        let moves = |op: &Op| matches!(op, Op::T | Op::Time | Op::Trajectory(_) | Op::Signal(_));
        if asked.is_margin || self.scenario.run.subject == Subject::Machine || tape.ops.iter().any(moves) {
            return None;
        }
        let stack = &program.stacks[first.stack];
        let place = stack.levels.iter().flat_map(|l| &l.members).position(|m| m.task == asked.task)?;
        let built = self.stacks.tasks(first.stack).get(place)?.task.as_ref().ok()?;
        let gain = built.gains(&program.values.initial).into_iter().reduce(f64::max).filter(|g| *g > 0.0)?;
        let ticks = (self.scenario.run.duration / period).round();
        let last = match (asked.always, asked.window.last) {
            (true, _) => f64::from(asked.window.first),
            (false, Some(last)) => f64::from(last).min(ticks),
            (false, None) => ticks,
        };
        let factor = 1.0 - gain * period;
        let start = measured(first, member, asked)?;
        if factor <= 0.0 || last < 1.0 {
            return None;
        }
        let after = |n: f64| start * factor.powf(n);
        // True at an error of zero, and false at one that is smaller than any that the gain permits.
        if !holds(asked.value, 0.0)? || holds(asked.value, after(last) / SLACK)? {
            return None;
        }
        // The error that is permitted lies between zero and that one.
        let (mut small, mut large) = (0.0, after(last));
        for _ in 0..60 {
            let middle = 0.5 * (small + large);
            if holds(asked.value, middle)? { small = middle } else { large = middle }
        }
        let needed = (small / start).ln() / factor.ln() * period;
        let dimension = member.measure_info.get(asked.part.unwrap_or(0))?.dimension;
        let length = |x: f64| shown(format!("{x:.4}").parse().unwrap_or(x), dimension);
        let (name, time) = (&member.name, number(last * period));
        let text = format!("`{name}` needs {needed:.1} s for this, and has {time} s");
        Some(
            Diagnostic::warning("HQ0818", self.written.name.span, text)
                .note(format!(
                    "with a gain of {} /s its error decays from {} to {} in {time} s",
                    number(gain),
                    length(start),
                    length(after(last))
                ))
                .help("write a later time, a larger tolerance, or a larger `gain` of the task"),
        )
    }
}

/// The measure at the first tick.
fn measured(first: &FirstTick, member: &Member, asked: &Asked) -> Option<f64> {
    if asked.is_margin {
        return first.prepared.evaluator.margins().get(member.margins.clone())?.iter().copied().reduce(f64::min);
    }
    let errors = first.prepared.evaluator.measures().get(member.measures.clone())?;
    let size = match asked.part {
        Some(part) => errors.get(part)?.abs(),
        None => errors.iter().map(|e| e * e).sum::<f64>().sqrt(),
    };
    size.is_finite().then_some(size)
}

/// True if a predicate holds for a value of its measure.
fn holds(value: &Expression, x: f64) -> Option<bool> {
    let mut results: Vec<f64> = Vec::with_capacity(value.ops.len());
    for op in &value.ops {
        let leaf = |op| if matches!(op, Op::Input(0)) { x } else { f64::NAN };
        results.push(op.value(|a| results[a], leaf));
    }
    let result = results.get(*value.outputs.first()?)?;
    (!result.is_nan()).then_some(*result >= 0.0)
}
