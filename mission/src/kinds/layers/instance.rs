//! Common data of the planners of layers: the open tasks with all modes of performing them, the agents' releases, and
//! the cost as a function of both.
//!
//! Fixed steps (begun, or planned in an earlier batch) are a constant of the cost and occupy their agents until they
//! end. Layers follow one another, so that the makespan is the begin of the first open layer plus the lengths of all
//! layers.

use std::rc::Rc;

use super::ability::Abilities;
use super::cost::{cost_at, scaled};
use super::problem::{Agent, Body, Problem};
use super::scales::Scales;
use super::steps::Step;
use crate::numbers::{Energy, Range};

/// A robot, whose speed is a decision, or a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mover {
    Robot {
        speed: Range,
        energy: Energy,
        /// Cost of a joule.
        joule: f64,
    },
    Human,
}

/// One mode of performing a task: by an agent, with an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mode {
    /// Time that is independent of the decided speed (s): for a person all of it.
    pub time: f64,
    /// Distance at the decided speed (m): 0 for a person.
    pub way: f64,
    /// Cost that is independent of the speed: a person's workload, a robot's friction.
    pub cost: f64,
}

/// A task to be planned.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Job {
    /// Index of the task.
    pub task: usize,
    /// Index into [`Instance::layers`]; `None`: the task is planned later, and only an object is kept free for it.
    pub layer: Option<usize>,
    /// Objects that it may use; a single `None` if it needs none.
    pub objects: Vec<Option<usize>>,
    /// Modes by object and agent, `objects.len() * agents`; `None`: that agent lacks an ability. Empty for a job that
    /// is planned later.
    modes: Vec<Option<Mode>>,
    agents: usize,
}

impl Job {
    /// Returns the mode with the object of this index in `objects` and this agent.
    pub fn mode(&self, object: usize, agent: usize) -> Option<&Mode> {
        self.modes.get(object * self.agents + agent)?.as_ref()
    }

    /// Returns true if the job needs an object.
    pub fn needs_object(&self) -> bool {
        self.objects.first().is_some_and(Option::is_some)
    }
}

/// A layer with open tasks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    /// Indices of its jobs.
    pub jobs: Vec<usize>,
    /// Time for which each agent is still busy after the layer may begin (s).
    pub release: Vec<f64>,
    /// Lower bound on the length of the layer from its fixed steps (s).
    pub floor: f64,
}

/// A problem prepared for planning.
#[derive(Clone, Debug)]
pub(super) struct Instance<'a> {
    pub problem: &'a Problem,
    pub movers: Vec<Mover>,
    pub jobs: Vec<Job>,
    pub layers: Vec<Layer>,
    /// Earliest begin of the first open layer (s).
    pub begin: f64,
    /// Cost of a second of makespan.
    pub second: f64,
    /// Cost of the fixed steps, with the makespan until `begin`.
    pub offset: f64,
    pub fixed: Vec<Step>,
    pub scales: Rc<Scales>,
}

impl<'a> Instance<'a> {
    /// Returns the instance of all tasks that have not begun; those that have begun are fixed.
    pub fn whole(problem: &'a Problem) -> Instance<'a> {
        Instance::with_scales(problem, Scales::of(problem))
    }

    /// As [`Instance::whole`] with given scales.
    pub fn with_scales(problem: &'a Problem, scales: Scales) -> Instance<'a> {
        let scales = Rc::new(scales);
        let abilities = Abilities::of(problem);
        let weights = problem.weights;
        let mover = |(who, scale): (&Agent, &f64)| match who.body {
            Body::Robot { speed, energy } => Mover::Robot { speed, energy, joule: scaled(weights.energy, *scale) },
            Body::Human { .. } => Mover::Human,
        };
        let tasks = (0..problem.tasks.len()).filter(|task| problem.begun_of(*task).is_none());
        let fixed: Vec<Step> = problem.begun.iter().map(|begun| begun.step()).collect();
        let free = |object: usize| fixed.iter().all(|step| step.object != Some(object));
        let jobs: Vec<Job> = tasks.map(|task| job(problem, &scales, &abilities, task, &free)).collect();
        let mut instance = Instance {
            problem,
            movers: problem.agents.iter().zip(&scales.of_agent).map(mover).collect(),
            jobs,
            layers: Vec::new(),
            begin: problem.start,
            second: scaled(weights.makespan, scales.makespan),
            offset: 0.0,
            fixed,
            scales,
        };
        instance.open();
        instance
    }

    /// Returns the instance of `tasks` with the fixed steps `fixed`; objects are kept free for all other open tasks.
    /// All layers before the first one of `tasks` are fixed. `self` is a whole instance.
    pub fn part(&self, fixed: &[Step], tasks: &[usize]) -> Instance<'a> {
        let is_fixed = |task: usize| fixed.iter().any(|step| step.task == task);
        let free = |object: &Option<usize>| object.is_none_or(|o| fixed.iter().all(|step| step.object != Some(o)));
        let mut jobs: Vec<Job> = Vec::new();
        let mut later: Vec<Job> = Vec::new();
        for job in self.jobs.iter().filter(|job| !is_fixed(job.task)) {
            let places: Vec<usize> = (0..job.objects.len()).filter(|place| free(&job.objects[*place])).collect();
            let objects = places.iter().map(|place| job.objects[*place]).collect();
            let (task, agents) = (job.task, job.agents);
            if tasks.contains(&task) {
                let modes = places.iter().flat_map(|place| &job.modes[place * agents..(place + 1) * agents]);
                jobs.push(Job { task, layer: Some(0), objects, modes: modes.copied().collect(), agents });
            } else if job.needs_object() {
                later.push(Job { task, layer: None, objects, modes: Vec::new(), agents });
            }
        }
        // A job with at least as many possible objects as there are jobs always gets one, and needs no column here.
        let mut count = jobs.len() + later.len();
        later.sort_by_key(|job| std::cmp::Reverse(job.objects.len()));
        for job in later {
            if job.objects.len() >= count {
                count -= 1;
            } else {
                jobs.push(job);
            }
        }
        let mut instance = Instance {
            jobs,
            fixed: fixed.to_vec(),
            movers: self.movers.clone(),
            layers: Vec::new(),
            scales: self.scales.clone(),
            ..*self
        };
        instance.open();
        instance
    }

    /// Computes layers, releases and the constant cost, from jobs (those with a layer) and fixed steps.
    fn open(&mut self) {
        let problem = self.problem;
        let fixed = &self.fixed;
        let planned = self.jobs.iter().filter(|job| job.layer.is_some());
        let mut open: Vec<usize> = planned.map(|job| problem.tasks[job.task].layer).collect();
        open.sort_unstable();
        open.dedup();
        for job in self.jobs.iter_mut().filter(|job| job.layer.is_some()) {
            job.layer = open.binary_search(&problem.tasks[job.task].layer).ok();
        }
        let first = open.first().copied().unwrap_or(problem.layers.len());
        let before = fixed.iter().filter(|step| problem.tasks[step.task].layer < first);
        let begin = before.map(|step| step.end).fold(problem.start, f64::max);
        let busy = |agent: usize| {
            let own = fixed.iter().filter(|step| step.agent == agent).map(|step| step.end);
            own.fold(begin, f64::max) - begin
        };
        let agents = self.movers.len();
        let layers = (0..open.len()).map(|layer| Layer {
            jobs: (0..self.jobs.len()).filter(|job| self.jobs[*job].layer == Some(layer)).collect(),
            release: (0..agents).map(|agent| if layer == 0 { busy(agent) } else { 0.0 }).collect(),
            floor: if layer == 0 { (0..agents).map(busy).fold(0.0, f64::max) } else { 0.0 },
        });
        let layers: Vec<Layer> = layers.collect();
        let until = if layers.is_empty() { fixed.iter().map(|step| step.end).fold(0.0, f64::max) } else { begin };
        let done = cost_at(problem, &self.scales, fixed);
        let weights = problem.weights;
        self.offset = weights.workload * done.workload + weights.energy * done.energy + self.second * until;
        (self.layers, self.begin) = (layers, begin);
    }
}

fn job(problem: &Problem, scales: &Scales, abilities: &Abilities, task: usize, free: &impl Fn(usize) -> bool) -> Job {
    let agents = problem.agents.len();
    let what = &problem.tasks[task];
    let mut job = Job { task, layer: Some(0), objects: Vec::new(), modes: Vec::new(), agents };
    let may = |agent: &usize| !problem.agents[*agent].lost && what.agent.is_none_or(|named| named == *agent);
    let named = |object: &usize| what.object.is_none_or(|named| named == *object);
    let suitable = abilities.objects[task].iter().copied().filter(|object| named(object) && free(*object)).map(Some);
    for object in suitable.chain((!what.needs_object()).then_some(None)) {
        let able = |agent: &usize| may(agent) && abilities.could(*agent, task, object);
        let mode = |agent: usize| Some(agent).filter(able).and_then(|agent| mode(problem, scales, agent, task, object));
        let modes: Vec<Option<Mode>> = (0..agents).map(mode).collect();
        if modes.iter().any(Option::is_some) {
            job.objects.push(object);
            job.modes.extend(modes);
        }
    }
    job
}

fn mode(problem: &Problem, scales: &Scales, agent: usize, task: usize, object: Option<usize>) -> Option<Mode> {
    let who = &problem.agents[agent];
    let skill = who.skill(&problem.tasks[task].action)?;
    let distance = problem.distance(agent, task, object);
    let mass = problem.mass(object);
    let scale = scales.of_agent[agent];
    Some(match (who.body, problem.pace(who, skill, mass)) {
        (Body::Robot { energy, .. }, _) => {
            let cost = problem.weights.energy * scaled(energy.friction * distance, scale);
            Mode { time: skill.duration, way: distance, cost }
        }
        (_, pace) => {
            let time = skill.duration + distance / pace?;
            Mode { time, way: 0.0, cost: problem.weights.workload * scaled(time * mass.unwrap_or(0.0), scale) }
        }
    })
}
