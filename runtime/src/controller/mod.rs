//! The controller: `step(observation) -> command`, the only thing that is called at rate.
//!
//! Machine: which stack runs; see [`machine`]. High-level layer (thesis 3.3.2): the stack's hierarchy is solved at the
//! reference configuration `q_d`, which is then moved by the chosen velocity for one period. Low-level layer, thesis (3.9):
//! `q' = q_d' + K_q (q_d - q)`, with the measured `q`, limited to the joints' speeds.
//!
//! A fault never passes by: the robot is commanded to stand at the tick at which one is found. A machine that has a
//! transition for it goes on in another state; otherwise the robot stands until [`Controller::restart`].

mod describe;
mod machine;
mod own;
mod stage;

use robot::{Data, Model};
use solver::{Problem, Solution};

use crate::evaluator::{Evaluator, Moment};
use crate::fault::Fault;
use crate::program::{ActionProgram, MachineProgram, Program, ProgramError, StateProgram, Subject, Times};
use crate::signals::Signals;
pub use machine::Request;
use machine::{Answer, Change, Machine};
use own::Present;
pub use stage::Stage;
use stage::{common_levels, standing};

/// Largest distance between a joint and its reference before the controller gives up, in rad or m.
pub const TRACKING_LIMIT: f64 = 0.5;

/// A limit counts as passed below minus this, in the unit of its row: the reference ends a tick on it up to rounding.
const PASSED: f64 = 1e-6;

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
    signals: Signals,
    /// For the axes of sensors: the robot as it is observed; none where no signal has a frame.
    observed: Option<Box<(Model, Data)>>,
    period: f64,
    deadline: f64,
    tracking_gain: f64,
    reference: Vec<f64>,
    tracking: Vec<f64>,
    /// The velocity that the reference moved with at the last tick.
    velocity: Vec<f64>,
    command: Vec<f64>,
    /// When the first tick was, in s.
    started: Option<f64>,
    /// When the last tick was, in s.
    last: f64,
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
    MachineProgram { states: vec![state], actions: Vec::new() }
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
            signals: Signals::new(&program.interface),
            observed: (program.interface.signals.iter().any(|s| s.conditioning.frame.is_some()))
                .then(|| Box::new((model.clone(), Data::new(model)))),
            period: program.robot.period,
            deadline: program.robot.deadline,
            tracking_gain: program.robot.tracking_gain,
            reference: vec![0.0; nq],
            tracking: vec![0.0; nv],
            velocity: vec![0.0; nv],
            command: vec![0.0; nv],
            started: None,
            last: 0.0,
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
    }

    /// One tick. Never panics, never allocates.
    pub fn step(&mut self, observation: &Observation) -> Command<'_> {
        let fault = if self.halted.is_some() {
            self.machine.requests.clear();
            self.halted
        } else {
            self.tick(observation)
        };
        self.signals.forget_events();
        if fault.is_some() {
            self.stand();
        }
        Command { velocity: &self.command, fault, requests: &self.machine.requests }
    }

    fn tick(&mut self, o: &Observation) -> Option<Fault> {
        // A clock that says nothing is taken to go on.
        let time = if o.time.is_finite() { o.time } else { self.last + self.period };
        self.sense(o.q, time);
        self.machine.begin();
        let first = self.started.is_none();
        if first {
            self.started = Some(time);
            self.last = time;
            self.moving = None;
            self.velocity.fill(0.0);
            self.machine.start(time);
            self.enter(Change { blend: 0.0, stack: true });
        }
        let seen = self.look(o);
        self.last = time;
        match seen.or(self.raised.take()) {
            Some(fault) => match self.machine.fault(&fault, &self.stages[self.active], time) {
                Answer::Went(change) => {
                    if matches!(fault, Fault::Tracking { .. }) {
                        self.anchored = false;
                    }
                    self.enter(change);
                }
                Answer::Here => {}
                Answer::None => {
                    self.halted = Some(fault);
                    return self.halted;
                }
            },
            None if !first => {
                let moment =
                    Moment { times: Times { t: 0.0, time }, signals: self.signals.table(), velocity: &self.velocity };
                let stage = &self.stages[self.active];
                if let Some(change) = self.machine.step(o.q, self.signals.events(), moment, stage) {
                    self.enter(change);
                }
            }
            None => {}
        }
        let now = Present { q: o.q, velocity: &self.velocity, time };
        let done = self.machine.perform(&mut self.signals, now);
        if seen.is_some_and(|f| matches!(f, Fault::Observation { .. })) {
            self.raised = done.err();
            return seen;
        }
        self.raised = done.and_then(|()| self.run(o.q, time)).err();
        self.raised.or(seen)
    }

    /// Works out the signals of a tick. A sensor whose axes are not known shows nothing.
    fn sense(&mut self, q: &[f64], time: f64) {
        let usable = q.len() == self.reference.len() && q.iter().all(|x| x.is_finite());
        if let Some(observed) = self.observed.as_deref_mut().filter(|_| usable) {
            observed.0.forward(q, &mut observed.1);
        }
        let data = self.observed.as_deref().filter(|_| usable).map(|o| &o.1);
        self.signals.at(time, |link| data.map(|d| d.pose(link).rotation));
    }

    /// Looks for what is wrong before anything is worked out.
    fn look(&mut self, o: &Observation) -> Option<Fault> {
        let q = o.q;
        if !o.time.is_finite() {
            return Some(Fault::Observation { index: None });
        }
        if q.len() != self.reference.len() {
            return Some(Fault::Observation { index: Some(q.len().min(self.reference.len())) });
        }
        if let Some(i) = q.iter().position(|x| !x.is_finite()) {
            return Some(Fault::Observation { index: Some(i) });
        }
        let gap = o.time - self.last;
        if gap > self.deadline || gap < 0.0 {
            return Some(Fault::Deadline { gap });
        }
        // Nobody has waited for a signal before the timeout of the first value has passed.
        let since = o.time - self.started.unwrap_or(o.time);
        let signals = &self.signals;
        let patience = |s: usize| signals.interface().signals[s].timeout.unwrap_or(f64::INFINITY);
        let is_stale =
            |s: usize| !signals.interface().signals[s].optional && !signals.is_known(s) && since > patience(s);
        self.machine.stale(is_stale)
    }

    /// Lets the stack of the current state be entered.
    fn enter(&mut self, change: Change) {
        if change.stack {
            let stack = self.machine.stack();
            self.active = stack.map_or(self.stages.len() - 1, |s| self.stage_of[s]);
            self.entering = Some(change.blend);
            self.visits += 1;
            // A task that does not run has nothing to tell.
            for signal in self.stages.iter().flat_map(|s| s.evaluator.telling()) {
                self.signals.forget(signal);
            }
        }
    }

    /// Runs the active stack for a tick.
    fn run(&mut self, q: &[f64], time: f64) -> Result<(), Fault> {
        if !self.anchored {
            self.reference.copy_from_slice(q);
            self.anchored = true;
        }
        let stage = &mut self.stages[self.active];
        stage.evaluator.model().difference(q, &self.reference, &mut self.tracking);
        if let Some(dof) = self.tracking.iter().position(|e| e.abs().is_nan() || e.abs() > TRACKING_LIMIT) {
            return Err(Fault::Tracking { dof });
        }
        let times = Times { t: time - self.machine.stack_entered(), time };
        let moment = Moment { times, signals: self.signals.table(), velocity: &self.velocity };
        if let Some(blend) = self.entering.take() {
            let common = self.moving.map_or(0, |from| self.common[from][self.active]);
            stage.enter(&self.reference, moment, blend, common);
        }
        self.moving = Some(self.active);
        stage.solve(&self.reference, moment)?;
        self.velocity.copy_from_slice(stage.velocity());
        stage.evaluator.observe(&self.reference, &self.velocity);
        for (signal, value) in stage.evaluator.told(&self.velocity) {
            if !self.signals.assign(signal, &[value]) {
                self.signals.forget(signal);
            }
        }
        stage.evaluator.advance();
        let dofs = &stage.evaluator.model().dofs;
        for (((c, v), e), d) in self.command.iter_mut().zip(&self.velocity).zip(&self.tracking).zip(dofs) {
            *c = (v + self.tracking_gain * e).clamp(-d.velocity, d.velocity);
        }
        stage.evaluator.model().integrate(&mut self.reference, &self.velocity, self.period);
        passed(stage, &self.machine)
    }

    /// Commands the robot to stand.
    fn stand(&mut self) {
        self.command.fill(0.0);
        self.velocity.fill(0.0);
        self.moving = None;
        // Margins and errors of velocities are those of a robot that stands.
        self.stages[self.active].evaluator.observe(&self.reference, &self.command);
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

    /// The machine that runs; one of a single state where the program has none.
    pub fn machine(&self) -> &MachineProgram {
        self.machine.program()
    }

    /// Whether the machine has come to its end.
    pub fn is_final(&self) -> bool {
        self.machine.is_final()
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

/// Whether a limit is passed that a transition watches.
fn passed(stage: &Stage, machine: &Machine) -> Result<(), Fault> {
    for (member, m) in stage.evaluator.members().iter().enumerate() {
        if m.margins.is_empty() || !machine.watches(m.program_index) {
            continue;
        }
        let margins = &stage.evaluator.margins()[m.margins.clone()];
        if let Some(row) = margins.iter().position(|h| *h < -PASSED) {
            return Err(Fault::Limit { member, row });
        }
    }
    Ok(())
}
