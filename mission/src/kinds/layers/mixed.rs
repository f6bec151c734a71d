//! The planning problem as a mixed-integer program: the reference for tests of branch and bound.
//!
//! One binary for each task, agent and object; for each robot and layer the distance `S` and the moving time `T`, with
//! the speed limits `S / v_max <= T <= S / v_min`. The energy `varrho_3 S^2 / T` is convex and homogeneous: its tangent
//! at a speed `v` is `2 v S - v^2 T`. Tangents are added until no solution lies below the energy.

use std::time::Instant;

use crate::engine::{Budget, EngineError, Milp, Model};
use crate::plan::{Limit, Statistics, Status};

use super::branch::{Found, branch};
use super::dual::Choices;
use super::improve::Improver;
use super::instance::{Instance, Mover};

/// Initial number of tangents of each robot and layer, and maximum number of rounds of adding some.
const TANGENTS: usize = 5;
const ROUNDS: usize = 40;

/// Columns of a robot in a layer.
struct Motion {
    agent: usize,
    way: usize,
    time: usize,
    drag: usize,
}

struct Formulation {
    model: Model,
    /// By job: agent, object and column.
    binaries: Vec<Vec<(usize, usize, usize)>>,
    motions: Vec<Motion>,
}

/// Finds the best choices for an instance in which no object is kept free for later tasks.
pub(super) fn mixed(instance: &Instance<'_>, engine: &dyn Milp, budget: &Budget) -> Result<Found, EngineError> {
    let begun = Instant::now();
    let mut formulation = Formulation::new(instance);
    let mut statistics = Statistics::default();
    let mut best: Option<(f64, Choices)> = None;
    let mut bound = f64::NEG_INFINITY;
    let mut stopped = None;
    for round in 0.. {
        let left = Budget { time: budget.time.saturating_sub(begun.elapsed()), ..*budget };
        let start: Vec<(usize, f64)> = best.iter().flat_map(|(_, choices)| formulation.start(choices)).collect();
        let answer = engine.solve(&formulation.model, &start, &left)?;
        statistics.solves += 1;
        statistics.nodes += answer.nodes;
        bound = bound.max(answer.bound);
        let Some(values) = answer.values else {
            stopped = answer.stopped.or(Some(Limit::Work));
            break;
        };
        let choices = formulation.choices(&values);
        let cost = Improver::new(instance, choices.clone()).cost();
        if best.as_ref().is_none_or(|(other, _)| cost < *other) {
            best = Some((cost, choices));
        }
        let least = best.as_ref().map_or(f64::INFINITY, |(cost, _)| *cost);
        if least - bound <= budget.gap * least.abs() {
            break;
        }
        stopped = answer.stopped;
        let fine = 0.1 * budget.gap * least.abs() / formulation.motions.len().max(1) as f64;
        let added = formulation.cut(instance, &values, fine);
        statistics.cuts += added;
        if stopped.is_none() && (added == 0 || round >= ROUNDS) {
            stopped = Some(Limit::Accuracy);
        }
        if stopped.is_some() {
            break;
        }
    }
    let (cost, choices) = match best {
        Some(found) => found,
        // A limit was reached before the first plan: use the root node of branch and bound.
        None => {
            let failed = || EngineError::Failed { engine: engine.name().into(), message: "no plan".into() };
            let first = branch(instance, &Budget { nodes: 1, ..*budget }).ok_or_else(failed)?;
            bound = bound.max(first.status.bound().unwrap_or(bound));
            (Improver::new(instance, first.choices.clone()).cost(), first.choices)
        }
    };
    let bound = bound.min(cost);
    let gap = if cost.abs() > 0.0 { (cost - bound) / cost.abs() } else { 0.0 };
    let status = match stopped {
        Some(stopped) if gap > budget.gap => Status::Gap { bound, gap, stopped },
        _ => Status::Proven { bound },
    };
    Ok(Found { choices, status, statistics })
}

impl Formulation {
    fn new(instance: &Instance<'_>) -> Formulation {
        let mut model = Model { offset: instance.offset, ..Model::default() };
        let mut binaries: Vec<Vec<(usize, usize, usize)>> = Vec::new();
        for job in &instance.jobs {
            let mut own = Vec::new();
            for object in 0..job.objects.len() {
                for agent in 0..instance.movers.len() {
                    if let Some(mode) = job.mode(object, agent) {
                        own.push((agent, object, model.binary(mode.cost)));
                    }
                }
            }
            model.row(1.0, own.iter().map(|(.., column)| (*column, 1.0)), 1.0);
            binaries.push(own);
        }
        for thing in 0..instance.problem.objects.len() {
            let of = |(job, own): (usize, &Vec<(usize, usize, usize)>)| {
                let uses = |object: &usize| instance.jobs[job].objects[*object] == Some(thing);
                own.iter().filter(|(_, object, _)| uses(object)).map(|(.., column)| (*column, 1.0)).collect::<Vec<_>>()
            };
            let terms: Vec<(usize, f64)> = binaries.iter().enumerate().flat_map(of).collect();
            model.at_most(terms, 1.0);
        }
        let mut formulation = Formulation { model, binaries, motions: Vec::new() };
        for layer in 0..instance.layers.len() {
            formulation.layer(instance, layer);
        }
        formulation
    }

    fn layer(&mut self, instance: &Instance<'_>, number: usize) {
        let layer = &instance.layers[number];
        let length = self.model.real(instance.second, layer.floor, f64::INFINITY);
        for (agent, mover) in instance.movers.iter().enumerate() {
            let mut ways = Vec::new();
            let mut times = Vec::new();
            for &index in &layer.jobs {
                let job = &instance.jobs[index];
                for &(_, object, column) in self.binaries[index].iter().filter(|(other, ..)| *other == agent) {
                    let Some(mode) = job.mode(object, agent) else { continue };
                    ways.push((column, mode.way));
                    times.push((column, mode.time));
                }
            }
            if times.is_empty() {
                continue;
            }
            let mut busy = times;
            if let Mover::Robot { speed, energy, joule } = mover {
                let way = self.model.real(0.0, 0.0, f64::INFINITY);
                let time = self.model.real(joule * energy.standby, 0.0, f64::INFINITY);
                let drag = self.model.real(joule * energy.drag, 0.0, f64::INFINITY);
                self.model.row(0.0, ways.into_iter().chain([(way, -1.0)]), 0.0);
                self.model.at_least(0.0, [(time, 1.0), (way, -1.0 / speed.high)]);
                self.model.at_most([(time, 1.0), (way, -1.0 / speed.low)], 0.0);
                for step in 0..TANGENTS {
                    let share = step as f64 / (TANGENTS - 1) as f64;
                    let at = speed.low + share * (speed.high - speed.low);
                    self.model.at_least(0.0, [(drag, 1.0), (way, -2.0 * at), (time, at * at)]);
                }
                self.motions.push(Motion { agent, way, time, drag });
                busy.push((time, 1.0));
            }
            // Load of the agent, with its release even if it has no task (the release never ends after the fixed
            // steps).
            self.model.at_most(busy.into_iter().chain([(length, -1.0)]), -layer.release[agent]);
        }
        // The length of a layer is at least the shortest time of each of its tasks.
        for &index in &layer.jobs {
            let job = &instance.jobs[index];
            let time = |(agent, object, column): &(usize, usize, usize)| {
                let mode = job.mode(*object, *agent)?;
                Some((*column, mode.time + instance.movers[*agent].moving(mode.way, 0.0)))
            };
            let terms: Vec<(usize, f64)> = self.binaries[index].iter().filter_map(time).collect();
            self.model.at_most(terms.into_iter().chain([(length, -1.0)]), 0.0);
        }
    }

    fn choices(&self, values: &[f64]) -> Choices {
        let most = |own: &Vec<(usize, usize, usize)>| {
            let best = own.iter().max_by(|a, b| values[a.2].total_cmp(&values[b.2]));
            best.map_or((0, 0), |(agent, object, _)| (*agent, *object))
        };
        self.binaries.iter().map(most).collect()
    }

    fn start(&self, choices: &Choices) -> Vec<(usize, f64)> {
        let chosen = |own: &Vec<(usize, usize, usize)>, choice: (usize, usize)| {
            own.iter().map(|(a, o, column)| (*column, f64::from(u8::from((*a, *o) == choice)))).collect::<Vec<_>>()
        };
        self.binaries.iter().zip(choices).flat_map(|(own, choice)| chosen(own, *choice)).collect()
    }

    /// Adds tangents at points whose energy exceeds that of the program by more than `fine`; returns their number.
    fn cut(&mut self, instance: &Instance<'_>, values: &[f64], fine: f64) -> u64 {
        let mut added = 0;
        for motion in &self.motions {
            let Mover::Robot { speed, energy, joule } = instance.movers[motion.agent] else { continue };
            let (way, time) = (values[motion.way], values[motion.time]);
            if way <= 1e-9 || time <= 0.0 {
                continue;
            }
            let at = (way / time).clamp(speed.low, speed.high);
            if joule * energy.drag * (way * at - values[motion.drag]) > fine {
                self.model.at_least(0.0, [(motion.drag, 1.0), (motion.way, -2.0 * at), (motion.time, at * at)]);
                added += 1;
            }
        }
        added
    }
}
