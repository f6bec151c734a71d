//! The controller: `step(observation) -> command`, the only thing that is called at rate.
//!
//! Machine: which stack runs; see [`machine`]. High-level layer (thesis 3.3.2): the stack's hierarchy is solved at the
//! reference configuration `q_d`, which is then moved by the chosen velocity for one period. Low-level layer, thesis (3.9):
//! `q' = q_d' + K_q (q_d - q)`, with the measured `q`, limited to the joints' speeds.
//!
//! A fault never passes by: the robot is commanded to stand at the tick at which one is found. A machine that has a
//! transition for it goes on in another state; otherwise the robot stands until [`Controller::restart`].

mod describe;
mod guards;
mod machine;
mod measured;
mod own;
mod stage;
mod tick;

use std::time::{Duration, Instant};

use robot::{Data, Model};
use solver::{Problem, Solution};

use crate::evaluator::Evaluator;
use crate::fault::Fault;
use crate::program::{ActionProgram, MachineProgram, Program, ProgramError, StateProgram, Subject};
use crate::signals::Signals;
use machine::Machine;
pub use machine::Request;
use measured::MeasuredMotion;
pub use stage::Stage;
use stage::{common_levels, standing};

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
    /// The fault that was found at this tick, or that keeps the robot still.
    pub fault: Option<Fault>,
    /// Actions to begin and to call off, in order; see [`Controller::action`].
    pub requests: &'a [Request],
    /// The tick's budget was spent before the stack's hierarchy was solved: the robot makes do with what is known of the answer, within its hard levels.
    pub late: bool,
}

/// A program made ready to run.
pub struct Controller {
    /// Stacks that a run can enter; behind them, for states without a stack, one that holds nothing.
    stages: Vec<Stage>,
    /// Levels that two of them share.
    common: Vec<Vec<usize>>,
    /// For each stack of the program its stage.
    stage_of: Vec<usize>,
    /// The stage that runs.
    active: usize,
    /// It is to be entered, with this blend.
    entering: Option<f64>,
    /// How many times a stack has been entered.
    visits: u64,
    /// The stage whose velocity the robot moves with.
    moving: Option<usize>,
    machine: Machine,
    /// What its conditions measure; none where they measure nothing.
    measured: Option<Box<MeasuredMotion>>,
    signals: Signals,
    /// For the axes of sensors: the robot as it is observed; none where no signal has a frame.
    observed: Option<Box<(Model, Data)>>,
    period: f64,
    deadline: f64,
    /// The time that a tick may take.
    budget: Option<Duration>,
    tracking_gain: f64,
    reference: Vec<f64>,
    tracking: Vec<f64>,
    /// The velocity that the reference moved with at the last tick.
    velocity: Vec<f64>,
    /// The velocity that the stack's hierarchy returned at the last tick; see [`Controller::stack_velocity`].
    stack_velocity: Vec<f64>,
    command: Vec<f64>,
    /// When the first tick was, in s.
    started: Option<f64>,
    /// When the last tick was, in s.
    last: f64,
    /// Whether the tasks of the active stack ran to the end of this tick, and told what they tell.
    told: bool,
    /// Whether the reference stands where the robot does.
    anchored: bool,
    /// A fault of the last tick that the machine has not seen yet.
    raised: Option<Fault>,
    /// The fault that keeps the robot still for good.
    halted: Option<Fault>,
}

/// The machine of a run without one: a single state.
fn single(stack: usize) -> MachineProgram {
    let state = StateProgram {
        name: String::new(),
        parent: None,
        initial: None,
        stack: Some(stack),
        is_final: false,
        enter: Vec::new(),
        activities: Vec::new(),
        exit: Vec::new(),
        transitions: Vec::new(),
    };
    MachineProgram { states: vec![state], actions: Vec::new(), measured: Vec::new() }
}

impl Controller {
    /// Checks a program and makes what it runs ready. All memory of the loop is allocated here.
    ///
    /// # Errors
    /// The program cannot be executed; one that the compiler made always can.
    pub fn new(program: &Program) -> Result<Controller, ProgramError> {
        program.check()?;
        match (program.run.subject, &program.machine) {
            (Subject::Stack(stack), _) => Controller::for_stack(program, stack),
            (Subject::Machine, Some(machine)) => Controller::of(program, machine),
            (Subject::Machine, None) => Err(crate::program::error("machine", "there is none to run")),
        }
    }

    /// The same for any stack of a program that was checked, or that the compiler made.
    ///
    /// # Errors
    /// There is no such stack, or it cannot be executed.
    pub fn for_stack(program: &Program, stack: usize) -> Result<Controller, ProgramError> {
        Controller::of(program, &single(stack))
    }

    fn of(program: &Program, machine: &MachineProgram) -> Result<Controller, ProgramError> {
        let mut stage_of = vec![usize::MAX; program.stacks.len()];
        let mut stages = Vec::new();
        for stack in machine.states.iter().filter_map(|s| s.stack) {
            if stage_of.get(stack).is_none_or(|s| *s == usize::MAX) {
                stages.push(Stage::new(program, stack)?);
                stage_of[stack] = stages.len() - 1;
            }
        }
        if (0..machine.states.len()).any(|s| machine.stack(machine.leaf(s)).is_none()) {
            stages.push(Stage::new(&standing(program), program.stacks.len())?);
        }
        let model = &program.robot.model;
        let (nq, nv) = (model.nq(), model.nv());
        Ok(Controller {
            common: common_levels(program, &stages),
            stages,
            stage_of,
            active: 0,
            entering: None,
            visits: 0,
            moving: None,
            machine: Machine::new(program, machine),
            measured: MeasuredMotion::new(program, machine),
            signals: Signals::new(&program.interface),
            observed: (program.interface.signals.iter().any(|s| s.conditioning.frame.is_some()))
                .then(|| Box::new((model.clone(), Data::new(model)))),
            period: program.robot.period,
            deadline: program.robot.deadline,
            budget: program.run.tick_budget.map(Duration::from_secs_f64),
            tracking_gain: program.robot.tracking_gain,
            reference: vec![0.0; nq],
            tracking: vec![0.0; nv],
            velocity: vec![0.0; nv],
            stack_velocity: vec![0.0; nv],
            command: vec![0.0; nv],
            started: None,
            last: 0.0,
            told: false,
            anchored: false,
            raised: None,
            halted: None,
        })
    }

    /// Forgets the past: the next step begins anew at the configuration that it observes.
    pub fn restart(&mut self) {
        (self.started, self.anchored) = (None, false);
        (self.raised, self.halted) = (None, None);
        self.signals.restart();
        if let Some(measured) = &mut self.measured {
            measured.restart();
        }
    }

    /// One tick. Never panics, never allocates.
    pub fn step(&mut self, observation: &Observation) -> Command<'_> {
        let until = self.budget.map(|budget| Instant::now() + budget);
        let fault = if self.halted.is_some() {
            self.machine.requests.clear();
            self.halted
        } else {
            self.tick(observation, until)
        };
        self.signals.forget_events();
        if fault.is_some() {
            self.stand();
        }
        if let Some(measured) = &mut self.measured {
            measured.tick(&mut self.signals, self.machine.entries(), observation.q, &self.velocity, self.last);
        }
        let late = self.is_late();
        Command { velocity: &self.command, fault, requests: &self.machine.requests, late }
    }

    /// The signals that the host sends, and its events.
    pub fn signals(&mut self) -> &mut Signals {
        &mut self.signals
    }

    /// The action that a request is about.
    pub fn action(&self, request: &Request) -> Option<&ActionProgram> {
        self.machine.program().actions.get(request.action)
    }

    /// The innermost state that the machine is in, by its path; empty where there is no machine.
    pub fn state(&self) -> &str {
        self.machine.program().states.get(self.machine.state()).map_or("", |s| s.name.as_str())
    }

    /// Index of that state.
    pub fn state_index(&self) -> usize {
        self.machine.state()
    }

    /// For each state of the machine how many times it has been entered.
    pub fn entries(&self) -> &[u64] {
        self.machine.entries()
    }

    /// The machine that runs; one of a single state where the program has none.
    pub fn machine(&self) -> &MachineProgram {
        self.machine.program()
    }

    /// Whether the machine has come to its end.
    pub fn is_final(&self) -> bool {
        self.machine.is_final()
    }

    /// The time from a tick to the next, in s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Whether the command is still going over from one stack to another.
    pub fn is_blending(&self) -> bool {
        self.stages[self.active].is_blending()
    }

    /// Stacks that the run can enter, made ready; the last one holds nothing where a state has no stack.
    pub fn stages(&self) -> &[Stage] {
        &self.stages
    }

    /// The place of the stack that ran at the last tick among [`Controller::stages`].
    pub fn stage(&self) -> usize {
        self.active
    }

    /// How many times a stack has been entered.
    pub fn visit(&self) -> u64 {
        self.visits
    }

    /// When the stack that runs was entered, in s.
    pub fn stage_entered(&self) -> f64 {
        self.machine.stack_entered()
    }

    /// The table of signals at the last tick.
    pub fn signal_table(&self) -> &[f64] {
        self.signals.table()
    }

    /// True where the budget of the last tick was spent before the stack's hierarchy was solved.
    pub fn is_late(&self) -> bool {
        self.told && self.stages[self.active].is_late()
    }

    /// Whether a fault keeps the robot still for good.
    pub fn is_halted(&self) -> bool {
        self.halted.is_some()
    }

    /// The stack as it stood at the last tick.
    pub fn evaluator(&self) -> &Evaluator {
        self.stages[self.active].evaluator()
    }

    /// The answer of the last tick for the stack that runs. During a blend [`Controller::velocity`] differs from it.
    pub fn solution(&self) -> &Solution {
        &self.stages[self.active].solution
    }

    /// The problem of the last tick.
    pub fn problem(&self) -> &Problem {
        self.stages[self.active].problem()
    }

    /// The velocity that the reference moved with at the last tick.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// The velocity that the hierarchy of the running stack returned at the last tick. It differs from
    /// [`Controller::velocity`] during a blend, and is zero where a fault lets the robot stand. Tasks that integrate
    /// accelerations go on from it: the offset of a blend is no acceleration of theirs.
    pub fn stack_velocity(&self) -> &[f64] {
        &self.stack_velocity
    }

    /// Name of the solver that finds the velocities.
    pub fn solver_name(&self) -> &'static str {
        self.stages[self.active].solver_name()
    }

    /// Degrees of freedom left after a level at the last tick, without those that the stack locks.
    pub fn freedom(&self, level: usize) -> usize {
        let left = self.solution().levels.get(level).map_or(0, |l| l.freedom);
        left.saturating_sub(self.evaluator().locked().len())
    }

    /// Names of the levels of the stack that runs.
    pub fn level_names(&self) -> &[String] {
        self.stages[self.active].level_names()
    }

    /// The reference configuration for the next tick.
    pub fn reference(&self) -> &[f64] {
        &self.reference
    }
}
