//! Controller: `step(observation) -> command`, the only function that is called at the control rate.
//!
//! The machine selects the stack that runs; see [`machine`]. In the high-level layer (thesis 3.3.2), the hierarchy of
//! the stack is solved at the reference configuration `q_d`, which then moves with the chosen velocity for one period.
//! The low-level layer is thesis (3.9), `q' = q_d' + K_q (q_d - q)`, with the measured `q`, limited to the joints'
//! speeds.
//!
//! A fault is never ignored: the robot is commanded to stand still at the tick at which it is found. A machine that has
//! a transition for the fault continues in another state. If that transition leads to a state that is active already, the
//! robot stands still until the machine leaves that state, and without a transition until [`Controller::restart`].
//!
//! A stack whose signals are late at the start is entered when all of them are there; see [`Controller::awaited`].

mod blend;
mod describe;
mod guards;
mod hard_limits;
mod look_ahead;
mod machine;
mod machine_actions;
mod machine_moves;
mod measured;
mod reached;
mod stack_controller;
mod tick;

use std::time::{Duration, Instant};

use robot::{Data, Model};
use solver::{Problem, Solution};

use crate::evaluator::Evaluator;
use crate::fault::Fault;
use crate::program::{ActionProgram, MachineProgram, Program, ProgramError, StateProgram, Subject};
use crate::signals::Signals;
pub use machine::Request;
use machine::{Machine, Part};
use measured::MeasuredMotion;
pub use stack_controller::StackController;
use stack_controller::{Carried, common_levels, standing};

/// Largest distance between a joint and its reference, in rad or m. A larger one is the fault `Tracking`.
pub const TRACKING_LIMIT: f64 = 0.5;

/// Observation of the robot at a tick.
#[derive(Clone, Copy, Debug)]
pub struct Observation<'a> {
    /// Time since the controller was started, in s.
    pub time: f64,
    /// Measured configuration, `nq` numbers.
    pub q: &'a [f64],
}

/// Command to the robot until the next tick.
#[derive(Clone, Copy, Debug)]
pub struct Command<'a> {
    /// Velocity, `nv` numbers, always finite.
    pub velocity: &'a [f64],
    /// Fault that was found at this tick, or that keeps the robot standing still or halted.
    pub fault: Option<Fault>,
    /// Actions to begin and to cancel, in order; see [`Controller::action`].
    pub requests: &'a [Request],
    /// True if the tick's budget was spent before the stack's hierarchy was solved. The velocity then uses the part of
    /// the answer that is known, within the hard levels.
    pub late: bool,
}

/// Program prepared for execution.
pub struct Controller {
    /// Stacks that a run can enter, followed by an empty stack if a state has none.
    stacks: Vec<StackController>,
    /// Number of levels that each pair of stacks shares.
    common: Vec<Vec<usize>>,
    /// Index in `stacks` of each stack of the program.
    index_of_stack: Vec<usize>,
    /// Index in `stacks` of the stack that runs.
    active: usize,
    /// Duration of the blend (s) if the stack is to be entered.
    entering: Option<f64>,
    /// Number of times a stack has been entered.
    visits: u64,
    /// Index in `stacks` of the stack that was entered last, with its parts.
    entered: Option<usize>,
    parts: Vec<Part>,
    /// Parts of that stack as they were entered, and the index in `stacks` of the stack before it.
    carried: Vec<Carried>,
    carried_from: Option<usize>,
    /// True if no part of the stack that is to be entered goes on.
    anew: bool,
    /// Index in `stacks` of the stack whose velocity moves the robot.
    moving: Option<usize>,
    machine: Machine,
    /// Measures that the machine's conditions read; `None` if there are none.
    measured: Option<Box<MeasuredMotion>>,
    signals: Signals,
    /// Observed robot, for the axes of sensors; `None` if no signal has a frame.
    observed: Option<Box<(Model, Data)>>,
    period: f64,
    deadline: f64,
    /// Time budget of a tick.
    budget: Option<Duration>,
    tracking_gain: f64,
    reference: Vec<f64>,
    /// Observed configuration, joints on the circle at the turn nearest to the reference.
    unwound: Vec<f64>,
    tracking: Vec<f64>,
    /// Velocity of the reference at the last tick.
    velocity: Vec<f64>,
    /// Velocity that the stack's hierarchy returned at the last tick; see [`Controller::stack_velocity`].
    stack_velocity: Vec<f64>,
    command: Vec<f64>,
    /// Time of the first tick (s).
    started: Option<f64>,
    /// Time of the last tick (s).
    last: f64,
    /// True if the tasks of the active stack ran to the end of this tick and wrote their outputs.
    outputs_written: bool,
    /// True if the reference has been set to the robot's configuration.
    anchored: bool,
    /// Signal that the stack that is to be entered waits for.
    awaited: Option<usize>,
    /// Fault of the last tick that the machine has not handled yet.
    raised: Option<Fault>,
    /// Fault that occurred in the target of its transition; it applies while [`Machine::stands`].
    stopped_by: Option<Fault>,
    /// Fault that halted the robot until a restart.
    halted: Option<Fault>,
}

/// Machine with a single state, for a run without a machine.
fn single(stack: usize) -> MachineProgram {
    let state = StateProgram {
        name: String::new(),
        parent: None,
        initial: None,
        regions: Vec::new(),
        stack: Some(stack),
        is_final: false,
        enter: Vec::new(),
        activities: Vec::new(),
        exit: Vec::new(),
        transitions: Vec::new(),
    };
    let (actions, measured, reached, merged) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    MachineProgram { states: vec![state], actions, measured, reached, merged }
}

impl Controller {
    /// Checks a program and prepares its stacks and its machine. All memory of the loop is allocated here.
    ///
    /// # Errors
    /// The program cannot be executed. A program that the compiler made always can.
    pub fn new(program: &Program) -> Result<Controller, ProgramError> {
        program.check()?;
        match (program.run.subject, &program.machine) {
            (Subject::Stack(stack), _) => Controller::for_stack(program, stack),
            (Subject::Machine, Some(machine)) => Controller::of(program, machine),
            (Subject::Machine, None) => Err(crate::program::error("machine", "there is none to run")),
        }
    }

    /// Prepares a controller for any stack of a program that was checked, or that the compiler made.
    ///
    /// # Errors
    /// There is no such stack, or it cannot be executed.
    pub fn for_stack(program: &Program, stack: usize) -> Result<Controller, ProgramError> {
        Controller::of(program, &single(stack))
    }

    fn of(program: &Program, machine: &MachineProgram) -> Result<Controller, ProgramError> {
        let mut index_of_stack = vec![usize::MAX; program.stacks.len()];
        let mut stacks = Vec::new();
        for stack in machine.stacks() {
            if index_of_stack.get(stack).is_none_or(|s| *s == usize::MAX) {
                stacks.push(StackController::new(program, stack)?);
                index_of_stack[stack] = stacks.len() - 1;
            }
        }
        if machine.may_stand() {
            stacks.push(StackController::new(&standing(program), program.stacks.len())?);
        }
        let model = &program.robot.model;
        let (nq, nv) = (model.nq(), model.nv());
        let most = machine.states.iter().map(|s| s.regions.len()).max().unwrap_or(0).max(1);
        Ok(Controller {
            common: common_levels(program, &stacks),
            stacks,
            index_of_stack,
            active: 0,
            entering: None,
            visits: 0,
            entered: None,
            parts: Vec::with_capacity(most),
            carried: Vec::with_capacity(most),
            carried_from: None,
            anew: true,
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
            unwound: vec![0.0; nq],
            tracking: vec![0.0; nv],
            velocity: vec![0.0; nv],
            stack_velocity: vec![0.0; nv],
            command: vec![0.0; nv],
            started: None,
            last: 0.0,
            outputs_written: false,
            anchored: false,
            awaited: None,
            raised: None,
            stopped_by: None,
            halted: None,
        })
    }

    /// Resets the controller: the next step starts at the configuration that it observes.
    pub fn restart(&mut self) {
        (self.started, self.anchored, self.awaited) = (None, false, None);
        (self.raised, self.stopped_by, self.halted) = (None, None, None);
        self.signals.restart();
        if let Some(measured) = &mut self.measured {
            measured.restart();
        }
    }

    /// Executes one tick. Never panics, never allocates.
    pub fn step(&mut self, observation: &Observation) -> Command<'_> {
        let until = self.budget.map(|budget| Instant::now() + budget);
        // Encoders may wrap where the reference counts turns; everything below reads the turn that the reference is in.
        let mut unwound = std::mem::take(&mut self.unwound);
        let observation = &self.unwind(observation, &mut unwound);
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
        self.unwound = unwound;
        let late = self.is_late();
        Command { velocity: &self.command, fault, requests: &self.machine.requests, late }
    }

    /// Observation with each joint on the circle at the turn nearest to the reference. The first one, and one that has not
    /// the robot's numbers, is returned as it is.
    fn unwind<'a>(&self, observation: &Observation<'a>, unwound: &'a mut [f64]) -> Observation<'a> {
        if self.started.is_none() || observation.q.len() != unwound.len() {
            return *observation;
        }
        unwound.copy_from_slice(observation.q);
        self.stacks[self.active].evaluator.model().unwind(unwound, &self.reference);
        Observation { q: unwound, ..*observation }
    }

    /// Signals and events that the host sends.
    pub fn signals(&mut self) -> &mut Signals {
        &mut self.signals
    }

    /// Action that a request refers to.
    pub fn action(&self, request: &Request) -> Option<&ActionProgram> {
        self.machine.program().actions.get(request.action)
    }

    /// Path of the innermost active state; empty if there is no machine. The states of regions are joined,
    /// `work.left.reach | work.right.wait`.
    pub fn state(&self) -> &str {
        self.machine.text()
    }

    /// Index of the innermost active state; of regions, that of the state around them.
    pub fn state_index(&self) -> usize {
        self.machine.state()
    }

    /// Largest length of [`Controller::state`] while regions are active (bytes).
    pub fn longest_state(&self) -> usize {
        self.machine.longest_text()
    }

    /// Indices of the innermost active states: one, or one for each region.
    pub fn leaves(&self) -> &[usize] {
        self.machine.leaves()
    }

    /// Returns true if a state of the machine is active.
    pub fn is_in(&self, state: usize) -> bool {
        self.machine.is_in(state)
    }

    /// Number of entries into each state of the machine.
    pub fn entries(&self) -> &[u64] {
        self.machine.entries()
    }

    /// Machine that runs; it has a single state if the program has no machine.
    pub fn machine(&self) -> &MachineProgram {
        self.machine.program()
    }

    /// Returns true if the machine is in a final state.
    pub fn is_final(&self) -> bool {
        self.machine.is_final()
    }

    /// Time between two ticks (s).
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns true while the command blends from one stack to another.
    pub fn is_blending(&self) -> bool {
        self.stacks[self.active].is_blending()
    }

    /// Controllers of the stacks that the run can enter; the last one is empty if a state has no stack.
    pub fn stacks(&self) -> &[StackController] {
        &self.stacks
    }

    /// Index into [`Controller::stacks`] of the stack that ran at the last tick.
    pub fn active_stack(&self) -> usize {
        self.active
    }

    /// Number of times a stack has been entered.
    pub fn visit(&self) -> u64 {
        self.visits
    }

    /// Index into [`Controller::stacks`] of the stack before the running one, if parts of it go on.
    pub(crate) fn carried_from(&self) -> Option<usize> {
        self.carried_from
    }

    /// For each part of the running stack, the part of the stack before that it continues.
    pub(crate) fn carried(&self) -> impl Iterator<Item = Option<usize>> + '_ {
        self.carried.iter().map(|c| c.before)
    }

    /// Time at which the running stack was entered (s).
    pub fn stack_entered(&self) -> f64 {
        self.machine.stack_entered()
    }

    /// Table of signals at the last tick.
    pub fn signal_table(&self) -> &[f64] {
        self.signals.table()
    }

    /// Returns true if the budget of the last tick was spent before the stack's hierarchy was solved.
    pub fn is_late(&self) -> bool {
        self.outputs_written && self.stacks[self.active].is_late()
    }

    /// Returns true if a fault has halted the robot until a restart.
    pub fn is_halted(&self) -> bool {
        self.halted.is_some()
    }

    /// Returns true while the robot stands still because a fault occurred in the state that its transition leads to. It
    /// moves again once another transition leaves that state.
    pub fn stands(&self) -> bool {
        self.machine.stands()
    }

    /// Name of a signal; empty if there is none.
    pub fn signal_name(&self, signal: usize) -> &str {
        self.signals.interface().signals.get(signal).map_or("", |s| s.name.as_str())
    }

    /// Signal, by its index, that the stack waits for while the robot stands still: its first value may be late until the
    /// timeout of the signal has passed since the first tick.
    pub fn awaited(&self) -> Option<usize> {
        self.awaited
    }

    /// Evaluator of the active stack, as of the last tick.
    pub fn evaluator(&self) -> &Evaluator {
        self.stacks[self.active].evaluator()
    }

    /// Solution of the last tick for the running stack. It differs from [`Controller::velocity`] during a blend.
    pub fn solution(&self) -> &Solution {
        &self.stacks[self.active].solution
    }

    /// Problem of the last tick.
    pub fn problem(&self) -> &Problem {
        self.stacks[self.active].problem()
    }

    /// Velocity of the reference at the last tick.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// Velocity that the hierarchy of the running stack returned at the last tick. It differs from
    /// [`Controller::velocity`] during a blend, and is zero if a fault stops the robot. Tasks that integrate
    /// accelerations continue from this velocity, because the offset of a blend is not part of their acceleration.
    pub fn stack_velocity(&self) -> &[f64] {
        &self.stack_velocity
    }

    /// Name of the solver that computes the velocities.
    pub fn solver_name(&self) -> &'static str {
        self.stacks[self.active].solver_name()
    }

    /// Degrees of freedom left after a level at the last tick, without those that the stack locks.
    pub fn freedom(&self, level: usize) -> usize {
        let left = self.solution().levels.get(level).map_or(0, |l| l.freedom);
        left.saturating_sub(self.evaluator().locked().len())
    }

    /// Names of the levels of the running stack.
    pub fn level_names(&self) -> &[String] {
        self.stacks[self.active].level_names()
    }

    /// Reference configuration for the next tick.
    pub fn reference(&self) -> &[f64] {
        &self.reference
    }
}
