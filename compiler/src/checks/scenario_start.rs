//! Warns of scenarios whose start violates the hard limits of the first stack, with people at their true positions, or at
//! whose start these limits contradict each other.

use dsl::{Diagnostic, Span};
use runtime::program::{Op, Program, ScenarioProgram, Subject, Times};
use runtime::record::summary::MARGIN_TOLERANCE;
use runtime::world::World;
use runtime::{Member, TickInputs};
use solver::{Problem, Solution, Status};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::Dimension;
use stdlib_tasks::expression::Leaf;

use super::contradictions::{self, Unmet};
use super::{Checked, entries, first_tick};
use crate::analysis::stacks::Prepared;
use crate::source_map::ScenarioPlaces;
use crate::units::shown;

/// Number of poses searched for the best value of a safety field.
const POSES: usize = 400;

/// Maximum distance (m) to which a better base position is searched.
const FARTHEST: f64 = 5.0;

/// Warns of scenarios that start outside of the limits.
pub(super) fn check(c: &Checked, diagnostics: &mut Vec<Diagnostic>) {
    for (scenario, ScenarioPlaces { start: at, .. }) in c.program.scenarios.iter().zip(&c.places.scenarios) {
        let Some(mut start) = Start::new(c, scenario) else { continue };
        // The search for a better start moves the robot, and comes last.
        let outside = outside(c.program, scenario, &start, *at).or_else(|| start.contradiction(c, scenario, *at));
        diagnostics.extend(start.fields(c.program, scenario, *at).or(outside));
        c.stacks.give(start.stack, start.prepared);
    }
}

/// The first stack of a scenario.
pub(super) fn first_stack(program: &Program, scenario: &ScenarioProgram) -> Option<usize> {
    match scenario.run.subject {
        Subject::Stack(stack) => Some(stack),
        Subject::Machine => program.machine.as_ref().and_then(|m| m.stack(m.leaf(0))),
    }
}

/// The signals at the start of a scenario, with people at their true positions; `None` if the stack needs one that is absent.
pub(super) fn signals_at_start(program: &Program, scenario: &ScenarioProgram, needs: &[usize]) -> Option<Vec<f64>> {
    let mut signals = program.interface.absent();
    World::new(program, scenario).truth(0.0, &mut signals);
    let known = |s: &usize| program.interface.signals.get(*s).is_some_and(|s| signals[s.known_at()] > 0.0);
    needs.iter().all(known).then_some(signals)
}

/// The first stack of a scenario, evaluated at the start with people at their true positions.
struct Start {
    stack: usize,
    prepared: Prepared,
    signals: Vec<f64>,
    velocity: Vec<f64>,
    moved: bool,
}

/// A safety field that a task keeps above a minimum.
struct Kept {
    task: String,
    field: String,
    dimension: Dimension,
    min: f64,
    source: Source,
}

/// Source of the value of a kept field.
enum Source {
    /// The margin of a `keep`, by its index.
    Row(usize),
    /// A safety planner, by its index in the program.
    Planner(usize),
}

impl Start {
    fn new(c: &Checked, scenario: &ScenarioProgram) -> Option<Start> {
        let program = c.program;
        let stack = first_stack(program, scenario)?;
        let needs = c.stacks.needs(stack);
        let moved = scenario.start != program.robot.home;
        // Home was already checked for stacks that are entered there, unless they need signals of people.
        if !moved && needs.is_empty() && entries::at_home(program, stack) {
            return None;
        }
        let signals = signals_at_start(program, scenario, &needs)?;
        let velocity = vec![0.0; program.robot.model.nv()];
        let mut start = Start { stack, prepared: c.stacks.take(stack)?, signals, velocity, moved };
        start.prepared.evaluator.enter(&scenario.start, inputs(&start.signals, &start.velocity));
        start.at(&scenario.start)?;
        Some(start)
    }

    /// Evaluates the stack at a configuration; `None` if a task has no value there.
    fn at(&mut self, q: &[f64]) -> Option<()> {
        let Prepared { evaluator, problem } = &mut self.prepared;
        evaluator.update(q, inputs(&self.signals, &self.velocity), problem).ok().map(drop)
    }

    /// Warns of a hard level that cannot be met at the start, where the robot is inside of its limits.
    fn contradiction(&self, c: &Checked, scenario: &ScenarioProgram, at: Span) -> Option<Diagnostic> {
        let Prepared { evaluator, problem } = &self.prepared;
        let last = problem.levels.iter().rposition(|l| l.hard)?;
        let hard = Problem { levels: problem.levels[..=last].to_vec(), ..problem.clone() };
        let mut solution = Solution::new(&hard);
        c.program.run.solver.solver(&hard).solve(&hard, &mut solution);
        let Status::Infeasible { level } = solution.status else { return None };
        let stack = &c.program.stacks[self.stack];
        let text = format!(
            "scenario `{}` starts where the hard level `{}` of stack `{}` cannot be met",
            scenario.name, stack.levels[level].name, stack.name
        );
        let d = Diagnostic::warning("HQ0504", at, text);
        let unmet = Unmet { problem: &hard, members: evaluator.members(), level, x: &solution.x };
        Some(
            contradictions::blame(c, &unmet, d)
                .note("a hard level has no slack, so the first tick would be a fault")
                .help(format!(
                    "give the scenario another `start`, or {}",
                    first_tick::relaxed(c.program, self.stack, level)
                )),
        )
    }

    /// The safety field that a member of the stack keeps above a constant minimum; `None` for other members.
    fn kept(&self, program: &Program, member: &Member) -> Option<Kept> {
        let task = program.tasks.get(member.program_index)?;
        let Some(Bound::Value(min)) = task.params.get("min") else { return None };
        if program.values.tape.outputs.iter().any(|o| o.at == min.at) {
            return None;
        }
        let (field, source) = match (task.params.get("value"), task.params.get("field")) {
            (Some(Bound::Expression(value)), _) if task.kind == "keep" => {
                let [Leaf::Field(field)] = value.leaves.as_slice() else { return None };
                matches!(value.ops.get(*value.outputs.first()?), Some(Op::State(_)))
                    .then_some((field.as_ref(), Source::Row(member.margins.start)))?
            }
            (_, Some(Bound::Field(field))) => (program.fields.get(*field)?, Source::Planner(member.program_index)),
            _ => return None,
        };
        let min = *program.values.initial.get(min.at)?;
        Some(Kept { task: task.name.clone(), field: field.name.clone(), dimension: field.dimension, min, source })
    }

    /// Value of the field at the last evaluated configuration.
    fn value(&self, kept: &Kept) -> Option<f64> {
        let value = match kept.source {
            Source::Row(row) => kept.min + self.prepared.evaluator.margins().get(row)?,
            Source::Planner(task) => self.prepared.evaluator.field_of(task)?.value(),
        };
        value.is_finite().then_some(value)
    }

    /// Searches the smallest displacement of the base with which the field reaches its minimum: a vector (x, y) and its
    /// length (m). The search follows the field's gradient at the start in steps of 1 cm; `None` beyond [`FARTHEST`].
    fn farther(&mut self, scenario: &ScenarioProgram, kept: &Kept) -> Option<([f64; 2], f64)> {
        let mut at = |[x, y]: [f64; 2]| {
            let mut q = scenario.start.clone();
            *q.get_mut(0)? += x;
            *q.get_mut(1)? += y;
            self.at(&q)?;
            self.value(kept)
        };
        const STEP: f64 = 1e-3;
        let slope = [at([STEP, 0.0])? - at([-STEP, 0.0])?, at([0.0, STEP])? - at([0.0, -STEP])?];
        let length = slope[0].hypot(slope[1]);
        let direction = [slope[0] / length, slope[1] / length];
        if !direction.iter().all(|x| x.is_finite()) {
            return None;
        }
        let steps = 1..=(FARTHEST * 100.0) as usize;
        let way = |k: usize| direction.map(|x| x * k as f64 / 100.0);
        let enough = steps.into_iter().find(|&k| at(way(k)).is_some_and(|value| value >= kept.min))?;
        Some((way(enough), enough as f64 / 100.0))
    }

    /// Warns of a safety field below its minimum, with the best value among the sampled poses.
    fn fields(&mut self, program: &Program, scenario: &ScenarioProgram, at: Span) -> Option<Diagnostic> {
        let below = |m: &Member| {
            let kept = self.kept(program, m)?;
            let value = self.value(&kept)?;
            (value < kept.min - MARGIN_TOLERANCE).then_some((kept, value))
        };
        let (kept, value) = self.prepared.evaluator.members().iter().find_map(below)?;
        let Kept { task, field, dimension, min, .. } = &kept;
        let (dimension, min) = (*dimension, *min);
        let short = |x: f64| shown(format!("{x:.3}").parse().unwrap_or(x), dimension);
        let text = format!(
            "scenario `{}` starts with `{field}` at {}, below the {} of `{task}`",
            scenario.name,
            short(value),
            short(min)
        );
        let d = Diagnostic::warning("HQ0807", at, text);
        let model = &program.robot.model;
        // A mobile base could go anywhere, so it stays at its start in this search.
        let is_mobile = !model.bases.is_empty();
        let mut rng = robot::random::units(0);
        let mut best = value;
        for _ in 0..POSES {
            let mut q = model.random_configuration(&mut rng);
            model.copy_bases(&scenario.start, &mut q);
            if self.at(&q).is_some()
                && let Some(value) = self.value(&kept)
            {
                best = best.max(value);
            }
        }
        let back = if is_mobile { self.farther(scenario, &kept) } else { None };
        let there = if is_mobile { ", the base where it starts," } else { "" };
        let d = d.note(format!("of {POSES} poses within the joints' limits{there} the best one has {}", short(best)));
        Some(d.help(match (best < min, back) {
            (_, Some(([x, y], by))) => format!(
                "start with the base {by:.2} m farther away, {x:+.2} m along x and {y:+.2} m along y; or reduce the demand, or place the people farther away"
            ),
            (true, None) => "no pose was found that meets it with the people there: reduce the demand, or place them farther away".to_string(),
            (false, None) => "start in a pose that is farther away, or place the people farther away".to_string(),
        }))
    }
}

fn inputs<'a>(signals: &'a [f64], velocity: &'a [f64]) -> TickInputs<'a> {
    TickInputs { times: Times::default(), signals, velocity, stack_velocity: velocity }
}

fn outside(program: &Program, scenario: &ScenarioProgram, start: &Start, at: Span) -> Option<Diagnostic> {
    let (evaluator, moved) = (&start.prepared.evaluator, start.moved);
    let hard = program.stacks[start.stack].levels.iter().flat_map(|l| l.members.iter().map(|_| l.hard));
    for (m, _) in evaluator.members().iter().zip(hard).filter(|(_, hard)| *hard) {
        let rows = m.row_info.iter().zip(&evaluator.margins()[m.margins.clone()]);
        let bad: Vec<(&str, String)> = rows
            .filter(|(_, h)| **h < -MARGIN_TOLERANCE)
            .map(|(r, h)| (r.name.as_str(), shown(format!("{:.2e}", -h).parse().unwrap_or(-h), r.dimension)))
            .collect();
        let Some((row, by)) = bad.first() else { continue };
        let more = if bad.len() > 1 { format!(", and {} more", bad.len() - 1) } else { String::new() };
        let text = format!("scenario `{}` starts outside `{}`: {row} by {by}{more}", scenario.name, m.name);
        return Some(
            Diagnostic::warning("HQ0806", at, text)
                .note("a barrier function keeps a limit only from inside; from outside, the robot first has to return")
                .help(match moved {
                    true => "move the start, or the person who is there at the start",
                    false => "let people begin further away, or give the robot another `start`",
                }),
        );
    }
    None
}
