//! What the planners of layers share: the tasks to be planned with every way in which each may be performed, the agents'
//! releases, and the cost as a function of both.
//!
//! What is fixed (begun, or planned in an earlier batch) is a constant of the cost and occupies its agent until it ends.
//! Layers follow one another, so that the makespan is when the first open layer may begin plus the lengths of all layers.

use super::cost::{self, scaled};
use super::problem::{Body, Energy, Problem, Range};
use super::scales::Scales;
use super::steps::Step;

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
    /// By object and agent, `objects.len() * agents`; none: that agent is not able to.
    modes: Vec<Option<Mode>>,
    agents: usize,
}

impl Job {
    /// The way with the object of this place in `objects` and this agent.
    pub fn mode(&self, object: usize, agent: usize) -> Option<&Mode> {
        self.modes[object * self.agents + agent].as_ref()
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
}

impl<'a> Instance<'a> {
    /// `tasks` are planned around `fixed`; what is neither only keeps an object free if `rest`. All layers before the
    /// first one of `tasks` are fixed.
    pub fn new(problem: &'a Problem, fixed: &[Step], tasks: &[usize], rest: bool) -> Instance<'a> {
        let scales = Scales::of(problem);
        let weights = problem.weights;
        let movers = problem.agents.iter().zip(&scales.of_agent).map(|(who, scale)| match who.body {
            Body::Robot { speed, energy } => Mover::Robot { speed, energy, joule: scaled(weights.energy, *scale) },
            Body::Human { .. } => Mover::Human,
        });
        let movers: Vec<Mover> = movers.collect();
        let mut open: Vec<usize> = tasks.iter().map(|task| problem.tasks[*task].layer).collect();
        open.sort_unstable();
        open.dedup();
        let planned = |task: &usize| tasks.contains(task);
        let is_fixed = |task: &usize| fixed.iter().any(|step| step.task == *task);
        let later = |task: &usize| rest && !planned(task) && !is_fixed(task) && problem.tasks[*task].needs_object();
        let free = |object: usize| fixed.iter().all(|step| step.object != Some(object));
        let mut jobs: Vec<Job> = Vec::new();
        for task in (0..problem.tasks.len()).filter(|task| planned(task) || later(task)) {
            let layer = if planned(&task) { open.binary_search(&problem.tasks[task].layer).ok() } else { None };
            jobs.push(job(problem, &scales, task, layer, &free));
        }
        let first = open.first().copied().unwrap_or(problem.layers.len());
        let before = fixed.iter().filter(|step| problem.tasks[step.task].layer < first);
        let begin = before.map(|step| step.end).fold(problem.start, f64::max);
        let busy = |agent: usize| {
            let own = fixed.iter().filter(|step| step.agent == agent).map(|step| step.end);
            own.fold(begin, f64::max) - begin
        };
        let layers = (0..open.len()).map(|layer| Layer {
            jobs: (0..jobs.len()).filter(|job| jobs[*job].layer == Some(layer)).collect(),
            release: (0..movers.len()).map(|agent| if layer == 0 { busy(agent) } else { 0.0 }).collect(),
            floor: if layer == 0 { (0..movers.len()).map(busy).fold(0.0, f64::max) } else { 0.0 },
        });
        let layers: Vec<Layer> = layers.collect();
        let second = scaled(weights.makespan, scales.makespan);
        let until = if layers.is_empty() { fixed.iter().map(|step| step.end).fold(0.0, f64::max) } else { begin };
        let done = cost::cost(problem, fixed);
        let offset = weights.workload * done.workload + weights.energy * done.energy + second * until;
        Instance { problem, movers, jobs, layers, begin, second, offset, fixed: fixed.to_vec() }
    }

    /// All tasks that have not begun, around those that have.
    pub fn whole(problem: &'a Problem) -> Instance<'a> {
        let fixed: Vec<Step> = problem.begun.iter().map(|begun| begun.step()).collect();
        let tasks: Vec<usize> = (0..problem.tasks.len()).filter(|task| problem.begun_of(*task).is_none()).collect();
        Instance::new(problem, &fixed, &tasks, false)
    }
}

fn job(problem: &Problem, scales: &Scales, task: usize, layer: Option<usize>, free: &impl Fn(usize) -> bool) -> Job {
    let agents = problem.agents.len();
    let what = &problem.tasks[task];
    let mut job = Job { task, layer, objects: Vec::new(), modes: Vec::new(), agents };
    let suitable = (0..problem.objects.len()).filter(|object| problem.suits(task, *object) && free(*object)).map(Some);
    for object in suitable.chain((!what.needs_object()).then_some(None)) {
        let modes = (0..agents).map(|agent| {
            problem.able(agent, task, object).then(|| mode(problem, scales, agent, task, object)).flatten()
        });
        let before = job.modes.len();
        job.modes.extend(modes);
        if job.modes[before..].iter().any(Option::is_some) {
            job.objects.push(object);
        } else {
            job.modes.truncate(before);
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
