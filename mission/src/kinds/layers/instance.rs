//! What the planners of layers share: the tasks to be planned with every way in which each may be performed, the agents'
//! releases, and the cost as a function of both.
//!
//! What is fixed (begun, or planned in an earlier batch) is a constant of the cost and occupies its agent until it ends.
//! Layers follow one another, so that the makespan is when the first open layer may begin plus the lengths of all layers.

use std::rc::Rc;

use super::ability::Abilities;
use super::cost::{cost_at, scaled};
use super::problem::{Agent, Body, Problem};
use super::scales::Scales;
use super::steps::Step;
use crate::numbers::{Energy, Range};

/// A robot as far as its speed is decided, or a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mover {
    Robot {
        speed: Range,
        energy: Energy,
        /// What a joule costs.
        joule: f64,
    },
    Human,
}

/// One way to perform a task: by an agent, with an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mode {
    /// What does not depend on a speed that is decided (s): of a person all of it.
    pub time: f64,
    /// The way at a speed that is decided (m): 0 of a person.
    pub way: f64,
    /// What it costs at any speed: a person's workload, a robot's friction.
    pub cost: f64,
}

/// A task to be planned.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Job {
    /// Index of the task.
    pub task: usize,
    /// Index into [`Instance::layers`]; none: only its object is kept free, it is planned later.
    pub layer: Option<usize>,
    /// The objects it may use; a single `None` where it needs none.
    pub objects: Vec<Option<usize>>,
    /// By object and agent, `objects.len() * agents`; none: that agent is not able to. Empty for a job that is planned
    /// later.
    modes: Vec<Option<Mode>>,
    agents: usize,
}

impl Job {
    /// The way with the object of this place in `objects` and this agent.
    pub fn mode(&self, object: usize, agent: usize) -> Option<&Mode> {
        self.modes.get(object * self.agents + agent)?.as_ref()
    }

    /// It needs an object.
    pub fn needs_object(&self) -> bool {
        self.objects.first().is_some_and(Option::is_some)
    }
}

/// A layer with tasks to be planned.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    /// Its jobs.
    pub jobs: Vec<usize>,
    /// How long after the layer may begin each agent is still busy (s).
    pub release: Vec<f64>,
    /// What is fixed of the layer takes this long (s).
    pub floor: f64,
}

/// A problem made ready.
#[derive(Clone, Debug)]
pub(super) struct Instance<'a> {
    pub problem: &'a Problem,
    pub movers: Vec<Mover>,
    pub jobs: Vec<Job>,
    pub layers: Vec<Layer>,
    /// When the first open layer may begin (s).
    pub begin: f64,
    /// What a second of makespan costs.
    pub second: f64,
    /// What is fixed costs this, with the makespan until `begin`.
    pub offset: f64,
    pub fixed: Vec<Step>,
    pub scales: Rc<Scales>,
}

impl<'a> Instance<'a> {
    /// All tasks that have not begun, around those that have.
    pub fn whole(problem: &'a Problem) -> Instance<'a> {
        Instance::with_scales(problem, Scales::of(problem))
    }

    /// The same where the scales are known.
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

    /// Of a whole instance, `tasks` around `fixed`; objects are left for all others that are to come. All layers before
    /// the first one of `tasks` are fixed.
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
        // Who has as many objects to choose from as there are tasks finds one in any case.
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

    /// Layers, releases and what is fixed of the cost, from jobs (those with a layer) and fixed steps.
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
