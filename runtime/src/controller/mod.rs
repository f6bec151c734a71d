//! Controller: `step(observation) -> command`, the only function that is called while a robot moves.
//!
//! The machine selects the stack that runs; see [`machine`]. In the high-level layer (thesis 3.3.2), the hierarchy of
//! the stack is solved at the reference configuration `q_d`, which then moves with the chosen velocity for one period.
//! This is a decision, and decisions are made at the rate of the spec, at whatever rate the host calls; see [`clock`] and [`set_point`].
//! The low-level layer is thesis (3.9), `q' = q_d' + K_q (q_d - q)`, with the measured `q`, limited to the joints'
//! speeds.
//!
//! A fault is never ignored: the robot comes to rest from the tick at which it is found; see [`rest`]. A machine that has
//! a transition for the fault continues in another state. If that transition leads to a state that is active already, the
//! robot stays at rest until the machine leaves that state, and without a transition until [`Controller::restart`].
//!
//! A stack whose signals are late at the start is entered when all of them are there; see [`Controller::awaited`].

mod blend;
mod clock;
mod describe;
mod drive;
mod follow;
mod guard;
mod guards;
mod hard_limits;
mod look_ahead;
mod machine;
mod machine_actions;
mod machine_moves;
mod measured;
mod phase;
mod place;
mod reached;
mod rest;
mod sag;
mod set_point;
mod stack_controller;
mod stacks;
mod tick;

use std::time::{Duration, Instant};

use robot::{Data, Model};
use solver::{Problem, Solution};

use crate::evaluator::{Evaluator, TickInputs};
use crate::fault::Fault;
use crate::program::{
    ActionProgram, MachineProgram, Program, ProgramError, RobotProgram, StateProgram, Subject, Times,
};
use crate::signals::Signals;
use clock::Clock;
pub use clock::Intervals;
use drive::Drive;
use follow::Following;
use machine::Machine;
pub use machine::Request;
use measured::MeasuredMotion;
use phase::{Phase, Stop, Why};
use sag::Sag;
use set_point::SetPoint;
pub use stack_controller::StackController;
use stacks::Stacks;

/// Observation of the robot at a tick.
#[derive(Clone, Copy, Debug)]
pub struct Observation<'a> {
    /// Time since the controller was started, in s.
    pub time: f64,
    /// Measured configuration, `nq` numbers.
    pub q: &'a [f64],
}

/// Command to the robot until the next call.
#[derive(Clone, Copy, Debug)]
pub struct Command<'a> {
    /// Velocity, `nv` numbers, always finite.
    pub velocity: &'a [f64],
    /// Configuration to be reached at the next call, `nq` numbers, always finite: what a position servo is sent. A joint on the circle is at the
    /// turn nearest to its last reading, so that an encoder may wrap and a servo is never sent elsewhere by a whole turn.
    pub position: &'a [f64],
    /// Time for which the command lasts, as far as is known (s): until the next call.
    pub lasts: f64,
    /// Fault that was found at this tick, or that keeps the robot at rest or halted.
    pub fault: Option<Fault>,
    /// Actions to begin and to cancel, in order; see [`Controller::action`].
    pub requests: &'a [Request],
    /// True if the tick's budget was spent before the stack's hierarchy was solved. The velocity then uses the part of
    /// the answer that is known, within the hard levels.
    pub late: bool,
    /// True if the robot is told to stand: a host that ends may stop calling.
    pub at_rest: bool,
}

/// Program prepared for execution.
pub struct Controller {
    stacks: Stacks,
    machine: Machine,
    phase: Phase,
    clock: Clock,
    /// Measures that the machine's conditions read; `None` if there are none.
    measured: Option<Box<MeasuredMotion>>,
    signals: Signals,
    /// Observed robot, for the axes of sensors; `None` if no signal has a frame.
    observed: Option<Box<(Model, Data)>>,
    model: Model,
    /// Names of the numbers of a configuration.
    q_names: Vec<String>,
    period: f64,
    /// Time budget of a tick.
    budget: Option<Duration>,
    tracking_gain: f64,
    /// True if the robot is stopped in a single tick, because the host stops it itself.
    stops_at_once: bool,
    /// True while the host says that the robot takes commands, and signals that must say so too.
    is_enabled: bool,
    enabling: Vec<usize>,
    /// True if the host has resumed since the last call.
    resumes: bool,
    /// True from a stop by the host until it resumes.
    is_stopped: bool,
    /// True if a robot that takes commands again goes on by itself.
    resumes_itself: bool,
    reference: Vec<f64>,
    /// Observed configuration, joints on the circle at the turn nearest to the reference.
    unwound: Vec<f64>,
    /// True if the reference has been set to the robot's configuration.
    is_anchored: bool,
    /// True if the configuration of this call can be used.
    is_observed: bool,
    tracking: Vec<f64>,
    /// Way of each degree of freedom from where the robot is to its set point, at the last call.
    off: Vec<f64>,
    motion: Motion,
    /// Velocity at which a motion to rest began, that which its next tick aims at, and that which it decides.
    stop_from: Vec<f64>,
    aim: Vec<f64>,
    next: Vec<f64>,
    set_point: SetPoint,
    drive: Drive,
    /// Configuration in which the robot comes to rest by what was sent to it.
    ahead: Vec<f64>,
    following: Following,
    /// True if the host has said that the bases of the next observation are elsewhere than before.
    relocates: bool,
    /// Time since the measured configuration was last evaluated (s).
    elapsed: f64,
    /// Velocity command of the last call.
    sent: Vec<f64>,
    /// Velocity of the set point in the last command, without the correction.
    fed: Vec<f64>,
    /// Degree of freedom that the reference waits for.
    waits_for: Option<usize>,
    /// True while a robot at rest is led back to where it is to stand.
    is_led: bool,
    /// How far a robot at rest hangs below its set point.
    sag: Sag,
    /// Set point at the present time.
    present: Vec<f64>,
    /// Offset of the position command from the set point (rad or m), and the velocity of the set point within the limits of the robot.
    offset: Vec<f64>,
    nudged: Vec<f64>,
    command: Vec<f64>,
    position: Vec<f64>,
    /// Time for which the last command lasts (s).
    lasts: f64,
    /// Last finite readings, in the turns that the robot reports.
    reported: Vec<f64>,
    /// Motion time of the first tick (s).
    started: f64,
    /// True if the tasks of the active stack ran to the end of this tick and wrote their outputs.
    outputs_written: bool,
    /// Fault of an observation since the last tick.
    seen: Option<Fault>,
    /// Fault of the last tick that the machine has not handled yet.
    raised: Option<Fault>,
    /// Fault that occurred in the target of its transition; it applies while [`Machine::stands`].
    stopped_by: Option<Fault>,
    /// Fault of the last tick.
    fault: Option<Fault>,
}

/// Motion that was decided at the last tick.
struct Motion {
    /// Velocity of the reference.
    velocity: Vec<f64>,
    /// Velocity that the stack's hierarchy returned; see [`Controller::stack_velocity`].
    stack_velocity: Vec<f64>,
}

impl Motion {
    /// Inputs of a tick at these times.
    fn inputs<'a>(&'a self, times: Times, signals: &'a Signals) -> TickInputs<'a> {
        let Motion { velocity, stack_velocity } = self;
        TickInputs { times, signals: signals.table(), velocity, stack_velocity }
    }
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
        let model = &program.robot.model;
        let (nq, nv) = (model.nq(), model.nv());
        let RobotProgram { period, deadline, tracking_gain, stops_at_once, resumes_itself, .. } = program.robot;
        // All memory of the ticks is allocated here.
        let drive = Drive::new(program.robot.lag, program.robot.dead_time, period, nv);
        Ok(Controller {
            stacks: Stacks::new(program, machine)?,
            machine: Machine::new(program, machine),
            phase: Phase::Unstarted,
            clock: Clock::new(period, deadline),
            measured: MeasuredMotion::new(program, machine),
            signals: Signals::new(&program.interface).with_foresight(program.robot.behind()),
            observed: (program.interface.signals.iter().any(|s| s.conditioning.frame.is_some()))
                .then(|| Box::new((model.clone(), Data::new(model)))),
            q_names: program.robot.q_names(),
            period,
            budget: program.run.tick_budget.map(Duration::from_secs_f64),
            tracking_gain,
            stops_at_once,
            is_enabled: true,
            enabling: program.robot.enabling.clone(),
            resumes: false,
            is_stopped: false,
            resumes_itself,
            reference: program.robot.home.clone(),
            unwound: vec![0.0; nq],
            is_anchored: false,
            is_observed: false,
            tracking: vec![0.0; nv],
            off: vec![0.0; nv],
            motion: Motion { velocity: vec![0.0; nv], stack_velocity: vec![0.0; nv] },
            stop_from: vec![0.0; nv],
            aim: vec![0.0; nv],
            next: vec![0.0; nv],
            set_point: SetPoint::new(model, period, &program.robot.home),
            drive,
            ahead: program.robot.home.clone(),
            following: Following::new(model),
            relocates: false,
            elapsed: 0.0,
            sent: vec![0.0; nv],
            fed: vec![0.0; nv],
            waits_for: None,
            is_led: false,
            sag: Sag::new(nv),
            present: vec![0.0; nq],
            offset: vec![0.0; nv],
            nudged: vec![0.0; nv],
            command: vec![0.0; nv],
            position: program.robot.home.clone(),
            lasts: 0.0,
            reported: program.robot.home.clone(),
            started: 0.0,
            outputs_written: false,
            seen: None,
            raised: None,
            stopped_by: None,
            fault: None,
            model: model.clone(),
        })
    }

    /// Resets the controller: the next step starts at the configuration that it observes.
    pub fn restart(&mut self) {
        self.phase = Phase::Unstarted;
        self.clock.restart();
        (self.seen, self.raised, self.stopped_by, self.fault) = (None, None, None, None);
        (self.resumes, self.is_stopped, self.relocates) = (false, false, false);
        self.sag.restart(0.0);
        self.drive.rest();
        self.offset.fill(0.0);
        self.following.restart();
        self.signals.restart();
        if let Some(measured) = &mut self.measured {
            measured.restart();
        }
    }

    /// Tells the time between two calls of [`Controller::step`], in s; a period unless told. With `None` it is found from the calls: the robot
    /// then stands still until the second one.
    pub fn called_every(&mut self, interval: Option<f64>) {
        self.clock.declare(interval);
    }

    /// Tells whether the robot takes commands: its program runs, its brakes are open, its commands are read. While it does not, the reference stays with
    /// the robot, and the machine and its clocks stand still. Afterwards the robot stands until [`Controller::resume`]. Signals that the spec names for
    /// it must say so too.
    pub fn set_enabled(&mut self, enabled: bool) {
        self.is_enabled = enabled;
    }

    /// Returns true while the robot takes commands, as the host has said and signals said at the last call.
    pub fn is_enabled(&self) -> bool {
        // The value of a signal that is absent is no number.
        let is_true = |s: &usize| self.signals.value(*s).first().is_some_and(|value| *value > 0.0);
        self.is_enabled && self.enabling.iter().all(is_true)
    }

    /// Takes the robot for one that takes commands whatever signals say: for those who look at a first tick without a world around it.
    pub fn without_enabling(mut self) -> Controller {
        self.enabling.clear();
        self
    }

    /// Returns true if the robot was held still at the last call, because it takes no commands or was told to stand: nothing was decided.
    pub fn is_held(&self) -> bool {
        self.waits_for_resume() || !self.is_enabled()
    }

    /// Returns true while the robot stands until it is told to go on.
    pub fn waits_for_resume(&self) -> bool {
        let is_told = self.is_stopped && matches!(self.phase, Phase::Unstarted | Phase::Standing(_));
        is_told || matches!(self.phase, Phase::Standing(Why::Told | Why::Disabled))
    }

    /// Tells that the bases are elsewhere in the next observation than the last ones said, because they have been localised anew: the reference moves
    /// with them.
    pub fn relocated(&mut self) {
        self.relocates = true;
    }

    /// Brings the robot to rest within its limits, or keeps it there, until [`Controller::resume`].
    pub fn stop(&mut self) {
        (self.resumes, self.is_stopped) = (false, true);
        if let Phase::Running | Phase::Stopping(_) = self.phase
            && self.phase.halted().is_none()
        {
            self.begin_stop(Why::Told);
        }
    }

    /// Begins a motion to rest as fast as the limits allow.
    fn begin_stop(&mut self, why: Why) {
        let times = Times { t: self.clock.now() - self.machine.stack_entered(), time: self.clock.now() };
        self.stop_from.copy_from_slice(&self.motion.velocity);
        self.phase = Phase::Stopping(Stop { why, times, begun: self.clock.now(), fade: 0.0 });
    }

    /// Lets a robot go on that was stopped by [`Controller::stop`], or that takes commands again: from where it is, from rest. A robot that still
    /// brakes comes to rest first.
    pub fn resume(&mut self) {
        self.resumes = true;
    }

    /// Takes an observation and returns the command until the next call. Never panics, never allocates.
    pub fn step(&mut self, observation: &Observation) -> Command<'_> {
        let until = self.budget.map(|budget| Instant::now() + budget);
        // Encoders may wrap where the reference counts turns; everything below reads the turn that the reference is in.
        let mut unwound = std::mem::take(&mut self.unwound);
        let fault = self.call(&self.unwind(observation, &mut unwound), until);
        self.unwound = unwound;
        // The way back: what a servo is sent is in the turn that its encoder reports.
        if observation.q.len() == self.reported.len() {
            let readings = self.reported.iter_mut().zip(observation.q).filter(|(_, q)| q.is_finite());
            readings.for_each(|(reported, q)| *reported = *q);
        }
        self.model.unwind(&mut self.position, &self.reported);
        Command {
            velocity: &self.command,
            position: &self.position,
            lasts: self.lasts,
            fault,
            requests: &self.machine.requests,
            late: self.is_late(),
            at_rest: self.is_at_rest(),
        }
    }

    /// Observation with each joint on the circle at the turn nearest to the reference. The first one, and one that has not
    /// the robot's numbers, is returned as it is.
    fn unwind<'a>(&self, observation: &Observation<'a>, unwound: &'a mut [f64]) -> Observation<'a> {
        if self.phase == Phase::Unstarted || observation.q.len() != unwound.len() {
            return *observation;
        }
        unwound.copy_from_slice(observation.q);
        self.model.unwind(unwound, &self.reference);
        Observation { q: unwound, ..*observation }
    }

    /// Returns true if the robot is told to stand: the last command is zero, and the next ones are.
    pub fn is_at_rest(&self) -> bool {
        self.has_stopped() && self.command.iter().all(|u| *u == 0.0)
    }

    /// Returns true if the set point stands.
    fn has_stopped(&self) -> bool {
        matches!(self.phase, Phase::Unstarted | Phase::Standing(_)) && self.set_point.is_at_rest()
    }

    /// Intervals between the calls of the host.
    pub fn intervals(&self) -> Intervals {
        self.clock.intervals()
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
        self.stacks.active().is_blending()
    }

    /// Controllers of the stacks that the run can enter; the last one is empty if a state has no stack.
    pub fn stacks(&self) -> &[StackController] {
        self.stacks.all()
    }

    /// Index into [`Controller::stacks`] of the stack that ran at the last tick.
    pub fn active_stack(&self) -> usize {
        self.stacks.index()
    }

    /// Number of times a stack has been entered.
    pub fn visit(&self) -> u64 {
        self.stacks.visits()
    }

    /// Index into [`Controller::stacks`] of the stack before the running one, if parts of it go on.
    pub(crate) fn carried_from(&self) -> Option<usize> {
        self.stacks.carried_from()
    }

    /// For each part of the running stack, the part of the stack before that it continues.
    pub(crate) fn carried(&self) -> impl Iterator<Item = Option<usize>> + '_ {
        self.stacks.carried()
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
        self.outputs_written && self.stacks.active().is_late()
    }

    /// Returns true if a fault has halted the robot until a restart.
    pub fn is_halted(&self) -> bool {
        self.phase.halted().is_some()
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

    /// Signal, by its index, that is waited for while the robot stands still: one without which it takes no commands, or one of the stack, whose
    /// first value may be late until its timeout has passed since the first tick.
    pub fn awaited(&self) -> Option<usize> {
        match self.phase.why() {
            Some(Why::Awaiting(signal)) => Some(signal),
            _ => self.enabling.iter().copied().find(|s| !self.signals.is_present(*s)),
        }
    }

    /// Evaluator of the active stack at the measured configuration, as of the last tick. What no hard limit and no condition needed is evaluated now,
    /// with the signals of now.
    pub fn measured(&mut self) -> &Evaluator {
        let stack = self.stacks.active_mut();
        stack.complete(self.signals.table(), &self.motion.velocity);
        stack.measured()
    }

    /// Evaluator of the active stack at the reference, as of the last tick.
    pub fn evaluator(&self) -> &Evaluator {
        self.stacks.active().evaluator()
    }

    /// Solution of the last tick for the running stack. It differs from [`Controller::velocity`] during a blend.
    pub fn solution(&self) -> &Solution {
        &self.stacks.active().solution
    }

    /// Problem of the last tick.
    pub fn problem(&self) -> &Problem {
        self.stacks.active().problem()
    }

    /// Velocity of the reference at the last tick.
    pub fn velocity(&self) -> &[f64] {
        &self.motion.velocity
    }

    /// Velocity that the hierarchy of the running stack returned at the last tick. It differs from
    /// [`Controller::velocity`] during a blend, and is zero if a fault stops the robot. Tasks that integrate
    /// accelerations continue from this velocity, because the offset of a blend is not part of their acceleration.
    pub fn stack_velocity(&self) -> &[f64] {
        &self.motion.stack_velocity
    }

    /// Name of the solver that computes the velocities.
    pub fn solver_name(&self) -> &'static str {
        self.stacks.active().solver_name()
    }

    /// Degrees of freedom left after a level at the last tick, without those that the stack locks.
    pub fn freedom(&self, level: usize) -> usize {
        let left = self.solution().levels.get(level).map_or(0, |l| l.freedom);
        left.saturating_sub(self.evaluator().locked().len())
    }

    /// Names of the levels of the running stack.
    pub fn level_names(&self) -> &[String] {
        self.stacks.active().level_names()
    }

    /// Configuration that the last command asks for at the next call, `nq` numbers.
    pub fn position(&self) -> &[f64] {
        &self.position
    }

    /// Reference configuration for the next tick.
    pub fn reference(&self) -> &[f64] {
        &self.reference
    }
}
