//! Measures that expectations read at each tick, at the robot's true configuration.
//!
//! A task is evaluated by itself, whether its stack runs or not. A task whose parameters depend on the time or the
//! configuration at which its stack was entered has a value only while such a stack runs.

use crate::evaluator::{Evaluator, TickInputs};
use crate::motion::Motion;
use crate::program::{LevelProgram, Measure, MemberProgram, Program, ProgramError, StackProgram, Times};
use crate::tick::MARGIN_TOLERANCE;
use crate::tick::Tick;
use nalgebra::Vector3;
use robot::Data;
use solver::Problem;

/// Returns true if a parameter of a task depends on the time or the configuration at which its stack was entered. Such
/// a task has no value while no such stack runs.
pub fn is_bound_to_its_stack(program: &Program, task: usize) -> bool {
    program.depends_on_entry(task)
}

/// First stack that contains a task.
pub fn stack_of(program: &Program, task: usize) -> Option<&StackProgram> {
    program.stacks.iter().find(|s| s.levels.iter().flat_map(|l| &l.members).any(|m| m.task == task))
}

/// Evaluation of a single task.
struct Probe {
    /// Its index in the program.
    task: usize,
    evaluator: Evaluator,
    problem: Problem,
    /// True if it has a value only while its stack runs.
    bound: bool,
    /// Visit to a stack for which it was entered.
    visit: Option<u64>,
    /// True if it has a value at this tick.
    known: bool,
}

impl Probe {
    fn new(program: &Program, task: usize) -> Result<Probe, ProgramError> {
        let member = MemberProgram { task, weight: 1.0, parts: Vec::new(), idle: Vec::new() };
        let level =
            LevelProgram { name: String::new(), hard: false, damping: 0.0, exact: false, members: vec![member] };
        let own = StackProgram { name: String::new(), locked: Vec::new(), levels: vec![level], parts: Vec::new() };
        // A task is built for the stack that contains it.
        let stack = stack_of(program, task).unwrap_or(&own);
        let (evaluator, problem) = Evaluator::alone(program, stack, task)?;
        let bound = evaluator.remembers_entry(0) || is_bound_to_its_stack(program, task);
        Ok(Probe { task, evaluator, problem, bound, visit: None, known: false })
    }

    /// Evaluates the task. `last` is the command of the previous tick, `stack_velocity` the velocity of the stack that
    /// ran then.
    fn tick(&mut self, tick: &Tick, last: &[f64], stack_velocity: &[f64]) {
        let c = tick.controller;
        let runs = c.evaluator().members().iter().any(|m| m.program_index == self.task);
        self.known = runs || !self.bound;
        if !self.known {
            return;
        }
        let times = Times { t: tick.time - c.stack_entered(), time: tick.time };
        // A task of a region goes on when another region changes the stack.
        let goes_on = self.visit.is_some() && c.evaluator().task_goes_on(self.task);
        let entered = runs && self.visit != Some(c.visit());
        let anew = if runs { entered && !goes_on } else { self.visit.is_none() };
        let stack_velocity = if anew || entered { last } else { stack_velocity };
        let inputs = TickInputs { times, signals: tick.signals, velocity: last, stack_velocity };
        if runs {
            self.evaluator.follow(c.evaluator());
        }
        if anew {
            self.evaluator.enter(tick.q, inputs);
        }
        if anew || entered {
            self.visit = Some(c.visit());
            if c.is_blending() {
                self.evaluator.hand_over();
            }
        }
        if runs {
            self.evaluator.follow_clock(c.evaluator(), self.task);
        }
        self.known = self.evaluator.update(tick.q, inputs, &mut self.problem).is_ok();
        self.evaluator.observe(tick.q, tick.command);
    }

    fn margin(&self) -> f64 {
        let margins = self.evaluator.margins();
        if !self.known || margins.is_empty() || margins.iter().any(|h| h.is_nan()) {
            return f64::NAN;
        }
        let least = margins.iter().copied().fold(f64::INFINITY, f64::min);
        if least.abs() < MARGIN_TOLERANCE { 0.0 } else { least }
    }

    fn error(&self, part: Option<usize>) -> f64 {
        let all = self.evaluator.measures();
        match part {
            _ if !self.known || all.is_empty() => f64::NAN,
            Some(part) => all.get(part).map_or(f64::NAN, |x| x.abs()),
            None => all.iter().map(|x| x * x).sum::<f64>().sqrt(),
        }
    }
}

/// All measures of a scenario.
pub(super) struct Measures {
    list: Vec<Measure>,
    probes: Vec<Probe>,
    /// For each measure, its probe.
    probe_of: Vec<Option<usize>>,
    /// Configuration of the previous tick, and its time.
    before: Option<(Vec<f64>, f64)>,
    /// Displacement since then, `nv` numbers.
    way: Vec<f64>,
    /// Command of the previous tick.
    last: Vec<f64>,
    /// Velocity of the controller's stack at the previous tick.
    stack_velocity: Vec<f64>,
    /// Kinematics for the speeds of links.
    data: Data,
    /// For each measure, the position of its link at the previous tick.
    places: Vec<Option<Vector3<f64>>>,
    /// Motion that the hierarchy chooses, independent of its execution.
    chosen: Motion,
}

impl Measures {
    /// # Errors
    /// A task cannot be built, which a compiled program excludes.
    pub fn new(program: &Program, list: &[Measure]) -> Result<Measures, ProgramError> {
        let mut tasks: Vec<usize> = list.iter().filter_map(Measure::task).collect();
        tasks.sort_unstable();
        tasks.dedup();
        Ok(Measures {
            probe_of: list.iter().map(|m| tasks.iter().position(|t| m.task() == Some(*t))).collect(),
            probes: tasks.iter().map(|&t| Probe::new(program, t)).collect::<Result<_, _>>()?,
            list: list.to_vec(),
            before: None,
            way: vec![0.0; program.robot.model.nv()],
            last: vec![0.0; program.robot.model.nv()],
            stack_velocity: vec![0.0; program.robot.model.nv()],
            data: Data::new(&program.robot.model),
            places: vec![None; list.len()],
            chosen: Motion::new(&program.robot.model, program.robot.period, list.iter()),
        })
    }

    /// Writes one number for each measure.
    pub fn tick(&mut self, tick: &Tick, out: &mut [f64]) {
        for probe in &mut self.probes {
            probe.tick(tick, &self.last, &self.stack_velocity);
        }
        self.last.copy_from_slice(tick.command);
        self.stack_velocity.copy_from_slice(tick.controller.stack_velocity());
        let model = tick.controller.evaluator().model();
        let mut elapsed = 0.0;
        if let Some((q, time)) = &self.before {
            model.difference(q, tick.q, &mut self.way);
            elapsed = tick.time - time;
        }
        if self.chosen.needs_kinematics() {
            model.forward(tick.q, &mut self.data);
        }
        self.chosen.tick(model, &self.data, tick.v, tick.time);
        let truth = |yes: bool| if yes { 1.0 } else { -1.0 };
        let measures = out.iter_mut().zip(&self.list).zip(&self.probe_of).zip(&mut self.places);
        for (((x, measure), probe), place) in measures {
            let probe = probe.and_then(|i| self.probes.get(i));
            *x = match measure {
                Measure::Margin(_) => probe.map_or(f64::NAN, Probe::margin),
                Measure::Error { part, .. } => probe.map_or(f64::NAN, |p| p.error(*part)),
                Measure::In(s) => truth(tick.controller.is_in(*s)),
                Measure::Fault(None) => truth(tick.fault.is_some()),
                Measure::Fault(Some(kind)) => truth(tick.fault.is_some_and(|f| f.kind() == *kind)),
                Measure::Speed(dof) if elapsed > 0.0 => self.way[*dof].abs() / elapsed,
                Measure::LargestSpeed(dofs) if elapsed > 0.0 => {
                    dofs.iter().fold(0.0, |most: f64, dof| most.max(self.way[*dof].abs())) / elapsed
                }
                Measure::Speed(_) | Measure::LargestSpeed(_) => 0.0,
                Measure::PointSpeed(link) => {
                    let now = self.data.pose(*link).translation.vector;
                    let way = place.replace(now).map_or(0.0, |before| (now - before).norm());
                    if elapsed > 0.0 { way / elapsed } else { 0.0 }
                }
                Measure::Acceleration(_)
                | Measure::LargestAcceleration(_)
                | Measure::PointAcceleration(_)
                | Measure::Reversals(_) => self.chosen.measure(measure).unwrap_or(f64::NAN),
                // The judge wrote it at the first tick.
                Measure::Initial(_) => *x,
            };
        }
        match &mut self.before {
            Some((q, time)) => {
                q.copy_from_slice(tick.q);
                *time = tick.time;
            }
            before => *before = Some((tick.q.to_vec(), tick.time)),
        }
    }
}
