//! The controller: `step(observation) -> command`, the only thing that is called at rate.
//!
//! High-level layer (thesis 3.3.2): the hierarchy is solved at the reference configuration `q_d`, which is then moved by
//! the chosen velocity for one period. Low-level layer, thesis (3.9): `q' = q_d' + K_q (q_d - q)`, with the measured `q`,
//! limited to the joints' speeds.

use solver::Problem;
use solver::{Active, HierarchicalSolver, LevelStatus, Solution, Status};

use crate::evaluator::Evaluator;
use crate::fault::Fault;
use crate::program::{Program, ProgramError, StackProgram, Times};

/// Largest distance between a joint and its reference before the controller gives up, in rad or m.
pub const TRACKING_LIMIT: f64 = 0.5;

/// What the robot reports at a tick.
#[derive(Clone, Copy, Debug)]
pub struct Observation<'a> {
    /// Time since the controller was started, in s.
    pub time: f64,
    /// Measured configuration, `nq` numbers.
    pub q: &'a [f64],
}

/// What the robot is asked to do until the next tick.
#[derive(Clone, Copy, Debug)]
pub struct Command<'a> {
    /// Velocity, `nv` numbers, always finite.
    pub velocity: &'a [f64],
    /// Why the robot is being kept still, if it is.
    pub fault: Option<Fault>,
}

/// A program made ready to run.
pub struct Controller {
    evaluator: Evaluator,
    problem: Problem,
    solution: Solution,
    solver: Box<dyn HierarchicalSolver + Send>,
    level_names: Vec<String>,
    value_names: Vec<(std::ops::Range<usize>, String)>,
    period: f64,
    tracking_gain: f64,
    reference: Vec<f64>,
    tracking: Vec<f64>,
    command: Vec<f64>,
    started: bool,
    fault: Option<Fault>,
}

/// The parameters of a stack's tasks by their places, as `` `gain` of task `reach` ``.
fn value_names(program: &Program, stack: &StackProgram) -> Vec<(std::ops::Range<usize>, String)> {
    let tasks = stack.levels.iter().flat_map(|l| &l.members).filter_map(|m| program.tasks.get(m.task));
    let named = |task: &crate::program::TaskProgram| {
        let one = |(name, bound): (&String, &stdlib_tasks::bound::Bound)| {
            let text = format!("`{name}` of task `{}`", task.name);
            bound.slots().into_iter().map(|s| (s.at..s.at + s.len, text.clone())).collect::<Vec<_>>()
        };
        task.params.iter().flat_map(one).collect::<Vec<_>>()
    };
    tasks.flat_map(named).collect()
}

impl Controller {
    /// Checks a program and makes its run stack ready. All memory of the loop is allocated here.
    ///
    /// # Errors
    /// The program cannot be executed; one that the compiler made always can.
    pub fn new(program: &Program) -> Result<Controller, ProgramError> {
        program.check()?;
        Controller::for_stack(program, program.run.stack)
    }

    /// The same for any stack of a program that was checked, or that the compiler made.
    ///
    /// # Errors
    /// There is no such stack, or it cannot be executed.
    pub fn for_stack(program: &Program, stack: usize) -> Result<Controller, ProgramError> {
        let Some(stack_program) = program.stacks.get(stack) else {
            return Err(crate::program::error("stacks", "there is no such stack"));
        };
        let (evaluator, problem) = Evaluator::new(program, stack)?;
        let (nq, nv) = (evaluator.model().nq(), evaluator.model().nv());
        Ok(Controller {
            solution: Solution::new(&problem),
            solver: program.run.solver.solver(&problem),
            level_names: stack_program.levels.iter().map(|l| l.name.clone()).collect(),
            value_names: value_names(program, stack_program),
            period: program.robot.period,
            tracking_gain: program.robot.tracking_gain,
            reference: vec![0.0; nq],
            tracking: vec![0.0; nv],
            command: vec![0.0; nv],
            started: false,
            fault: None,
            evaluator,
            problem,
        })
    }

    /// Forgets the past: the next step enters the stack anew at the configuration that it observes.
    pub fn restart(&mut self) {
        self.started = false;
        self.fault = None;
    }

    /// One tick. Never panics; a fault keeps the robot still from here on.
    pub fn step(&mut self, observation: &Observation) -> Command<'_> {
        if self.fault.is_none() {
            self.fault = self.tick(observation).err();
        }
        if self.fault.is_some() {
            self.command.fill(0.0);
            // Margins and errors of velocities are those of a robot that stands.
            self.evaluator.observe(&self.reference, &self.command);
        }
        Command { velocity: &self.command, fault: self.fault }
    }

    fn tick(&mut self, observation: &Observation) -> Result<(), Fault> {
        let q = observation.q;
        if !observation.time.is_finite() {
            return Err(Fault::Observation { index: None });
        }
        if q.len() != self.reference.len() {
            return Err(Fault::Observation { index: Some(q.len().min(self.reference.len())) });
        }
        if let Some(i) = q.iter().position(|x| !x.is_finite()) {
            return Err(Fault::Observation { index: Some(i) });
        }
        let times = Times { t: observation.time, time: observation.time };
        if !self.started {
            self.reference.copy_from_slice(q);
            self.evaluator.enter(q, times);
            self.started = true;
        }
        self.evaluator.model().difference(q, &self.reference, &mut self.tracking);
        if let Some(dof) = self.tracking.iter().position(|e| e.abs().is_nan() || e.abs() > TRACKING_LIMIT) {
            return Err(Fault::Tracking { dof });
        }
        self.evaluator.update(&self.reference, times, &mut self.problem)?;
        self.solver.solve(&self.problem, &mut self.solution);
        match self.solution.status {
            Status::Optimal => {}
            Status::Infeasible { level } => return Err(Fault::Infeasible { level }),
            Status::NotFinite { level, row } => return Err(self.not_finite(level, row)),
            Status::Failed { level } => return Err(Fault::Solver { level }),
        }
        if self.solution.x.iter().any(|v| !v.is_finite()) {
            return Err(Fault::Solver { level: 0 });
        }
        let v = &self.solution.x;
        self.evaluator.observe(&self.reference, v);
        let dofs = &self.evaluator.model().dofs;
        for (((c, v), e), d) in self.command.iter_mut().zip(v).zip(&self.tracking).zip(dofs) {
            *c = (v + self.tracking_gain * e).clamp(-d.velocity, d.velocity);
        }
        self.evaluator.model().integrate(&mut self.reference, &self.solution.x, self.period);
        Ok(())
    }

    fn not_finite(&self, level: usize, row: usize) -> Fault {
        let member = self.evaluator.members().iter().position(|m| m.level == level && m.rows.contains(&row));
        match member {
            Some(i) => Fault::NotFinite { member: i, row: row - self.evaluator.members()[i].rows.start },
            None => Fault::Solver { level },
        }
    }

    /// The stack as it stood at the last tick.
    pub fn evaluator(&self) -> &Evaluator {
        &self.evaluator
    }

    /// The answer of the last tick.
    pub fn solution(&self) -> &Solution {
        &self.solution
    }

    /// The problem of the last tick.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Name of the solver that finds the velocities.
    pub fn solver_name(&self) -> &'static str {
        self.solver.name()
    }

    /// Degrees of freedom left after a level at the last tick, without those that the stack locks.
    pub fn freedom(&self, level: usize) -> usize {
        let left = self.solution.levels.get(level).map_or(0, |l| l.freedom);
        left.saturating_sub(self.evaluator.locked().len())
    }

    /// Names of the levels.
    pub fn level_names(&self) -> &[String] {
        &self.level_names
    }

    /// The reference configuration for the next tick.
    pub fn reference(&self) -> &[f64] {
        &self.reference
    }

    /// A fault in words.
    pub fn describe(&self, fault: &Fault) -> String {
        let row = |member: usize, row: usize| {
            let m = &self.evaluator.members()[member];
            format!("task `{}`, {}", m.name, m.row_info.get(row).map_or("a row", |r| r.name.as_str()))
        };
        let level = |i: usize| self.level_names.get(i).map_or("?", String::as_str);
        match *fault {
            Fault::Observation { index: Some(i) } => {
                format!("number {i} of the observed configuration is missing or not finite")
            }
            Fault::Observation { index: None } => "the observed time is not finite".to_string(),
            Fault::NotFinite { member, row: r } => format!("{}: a number is not finite", row(member, r)),
            Fault::Value { at } => {
                let name = self.value_names.iter().find(|n| n.0.contains(&at)).map_or("a parameter", |n| n.1.as_str());
                let value = self.evaluator.value(at).unwrap_or(f64::NAN);
                let rate = self.evaluator.rate(at).unwrap_or(f64::NAN);
                match (value.is_finite(), rate.is_finite()) {
                    (false, _) => format!("{name} has no finite value"),
                    (true, false) => format!("{name} changes infinitely fast"),
                    (true, true) => format!("{name} is {}, outside its range", crate::text::number(value)),
                }
            }
            Fault::Overlap { member, row: r } => {
                format!("{}: the parts overlap so deeply that no direction leads apart", row(member, r))
            }
            Fault::Gain { member } => {
                let name = self.evaluator.members().get(member).map_or("?", |m| m.name.as_str());
                format!("the gain of task `{name}` is negative, or overshoots within one period")
            }
            Fault::Crossed { member, row: r } => {
                format!("{}: its lower limit is above its upper one, or they close too fast", row(member, r))
            }
            Fault::Infeasible { level: l } => {
                let rows = self.unmet(l);
                let list = if rows.is_empty() { String::new() } else { format!(": {}", rows.join(", ")) };
                format!("hard level `{}` cannot be met{list}", level(l))
            }
            Fault::Solver { level: l } => format!("no usable answer for level `{}`", level(l)),
            Fault::Tracking { dof } => {
                let name = self.evaluator.model().dofs.get(dof).map_or("?", |d| d.name.as_str());
                format!("`{name}` is more than {TRACKING_LIMIT} rad or m away from its reference")
            }
        }
    }

    /// Rows of a level that were not met at the last tick, as `task: row`.
    fn unmet(&self, level: usize) -> Vec<String> {
        let Some(l) = self.solution.levels.get(level) else { return Vec::new() };
        if l.status == LevelStatus::NotSolved {
            return Vec::new();
        }
        let members = self.evaluator.members().iter().filter(|m| m.level == level);
        members
            .flat_map(|m| m.rows.clone().zip(&m.row_info).map(move |(r, info)| (r, m, info)))
            .filter(|(r, _, _)| l.active.get(*r) == Some(&Active::Violated))
            .map(|(_, m, info)| format!("`{}`, {}", m.name, info.name))
            .collect()
    }
}
