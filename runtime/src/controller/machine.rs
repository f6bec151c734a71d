//! State machine at run time: the active states and their transitions.
//!
//! Once a tick, before the cascade, the transitions of the current state are tested in the order written, then those of
//! its parent, and so on up to the machine. The first transition whose trigger holds is taken, and no other at this
//! tick. If there is a fault, only transitions for faults are tested. States are exited from the inside out, up to the
//! innermost state that contains both the transition and its target. States are then entered from there inwards, and on
//! into initial states.
//!
//! A transition that is defined in a state around its target can find the machine in the target already, at every tick.
//! A condition or `reached` is then not taken; it keeps the machine there and has priority over later transitions other
//! than events. A time is taken once. An event enters the target again. A condition or `reached` that re-enters the
//! state that defines it must first have been false there.
//!
//! In a final state, only transitions to final states are tested: a machine that has ended does not begin again.
//!
//! A fault never re-enters the state in which it occurred. If its transition leads to a state that is active already, and
//! the stack that runs has a target, the robot stands still until the machine leaves that state.

use robot::{Data, Model};
use stdlib_tasks::task::State as TaskState;

use super::guards::{Guard, Guards};
use super::machine_actions::{Kinematics, ObservedState, ReadyAction};
use super::stack_controller::StackController;
use crate::evaluator::TickInputs;
use crate::fault::Fault;
use crate::program::{FaultPattern, MachineProgram, Program, ReachedProgram, Times, TransitionProgram, Trigger};
use crate::signals::Signals;
use crate::values::ValueTable;

/// Request to the outside world at a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Index into the machine's actions.
    pub action: usize,
    /// True to begin the action, false to cancel it.
    pub begin: bool,
}

/// Result of a transition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StateChange {
    /// Duration of the blend to the new command (s).
    pub blend: f64,
    /// True if the stack of the new state is entered.
    pub stack: bool,
}

/// Response of the machine to a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FaultResponse {
    /// A transition was taken.
    Transition(StateChange),
    /// The target of the matching transition is already active: the robot stands still until the machine leaves it.
    AlreadyInTarget,
    /// No transition matches the fault.
    Unhandled,
}

/// A machine at run time.
pub(super) struct Machine {
    program: MachineProgram,
    guards: Vec<Guards>,
    model: Model,
    data: Data,
    current: usize,
    /// Time at which each state was entered (s).
    entered: Vec<f64>,
    /// Number of entries into each state.
    entries: Vec<u64>,
    /// State whose stack runs.
    owner: usize,
    /// Active state that the transition for a fault leads to; the robot stands still until the machine leaves it.
    standing: Option<usize>,
    /// Time at which the stack last began anew after such a stop, without an entry of its state (s).
    resumed: f64,
    /// Requests of this tick.
    pub requests: Vec<Request>,
    /// Events that the machine raised at the previous tick, and those of this one.
    raised: [Vec<bool>; 2],
    /// For each action, the part that the controller performs itself.
    own: Vec<Option<ReadyAction>>,
    /// Own actions due at this tick, each with the time at which its state was entered (s).
    pending: Vec<(usize, f64)>,
}

impl Machine {
    /// Prepares a checked machine.
    pub fn new(program: &Program, machine: &MachineProgram) -> Machine {
        let states = machine.states.len();
        let events = program.interface.events.len();
        Machine {
            guards: (0..states).map(|s| Guards::new(program, machine, s)).collect(),
            data: Data::new(&program.robot.model),
            model: program.robot.model.clone(),
            current: machine.leaf(0),
            entered: vec![0.0; states],
            entries: vec![0; states],
            owner: 0,
            standing: None,
            resumed: f64::NEG_INFINITY,
            // Each state is left and entered at most once at a tick.
            requests: Vec::with_capacity(2 * machine.actions.len() + 2),
            raised: [vec![false; events], vec![false; events]],
            own: machine.actions.iter().map(|a| a.own.as_ref().map(|own| ReadyAction::new(program, own))).collect(),
            pending: Vec::with_capacity(2 * machine.actions.len()),
            program: machine.clone(),
        }
    }

    /// The innermost state that the machine is in.
    pub fn state(&self) -> usize {
        self.current
    }

    /// Number of entries into each state since the start.
    pub fn entries(&self) -> &[u64] {
        &self.entries
    }

    /// Program of the machine.
    pub fn program(&self) -> &MachineProgram {
        &self.program
    }

    /// Returns true if the machine is in a final state.
    pub fn is_final(&self) -> bool {
        self.program.ends(self.current)
    }

    /// Index of the stack that runs, or `None` if the robot stands still.
    pub fn stack(&self) -> Option<usize> {
        self.program.states[self.owner].stack
    }

    /// Returns true if the robot stands still because a fault occurred in the target of its own transition.
    pub fn stands(&self) -> bool {
        self.standing.is_some()
    }

    /// Time at which the state whose stack runs was entered, or at which the stack began anew there (s).
    pub fn stack_entered(&self) -> f64 {
        self.entered[self.owner].max(self.resumed)
    }

    /// Restarts the machine in its initial state.
    pub fn start(&mut self, time: f64) {
        self.requests.clear();
        self.pending.clear();
        self.raised.iter_mut().for_each(|r| r.fill(false));
        self.entries.fill(0);
        self.current = 0;
        (self.standing, self.resumed) = (None, f64::NEG_INFINITY);
        self.enter(0, time);
    }

    /// Begins a tick: clears the requests of the previous tick and makes the events raised then visible.
    pub fn begin(&mut self) {
        self.requests.clear();
        self.raised.swap(0, 1);
        self.raised[1].fill(false);
    }

    /// Performs the own actions of this tick in order. Never allocates.
    ///
    /// # Errors
    /// The first fault. The actions after it are still performed.
    pub fn perform(&mut self, signals: &mut Signals, now: ObservedState) -> Result<(), Fault> {
        let Machine { own, pending, model, data, .. } = self;
        let mut first = Ok(());
        for (action, entered) in pending.drain(..) {
            if let Some(own) = &mut own[action] {
                first = first.and(own.act(signals, Kinematics { model, data }, now, entered));
            }
        }
        first
    }

    /// Returns the fault of a stale signal that a condition of an active state needs.
    pub fn stale(&self, is_stale: impl Fn(usize) -> bool) -> Option<Fault> {
        let needs = self.program.path(self.current).flat_map(|s| self.guards[s].values.needs());
        needs.copied().find(|&s| is_stale(s)).map(|signal| Fault::Stale { signal })
    }

    /// Sets the flags of targets that conditions ask to be reached, by the last tick of `stack`; none is reached at the
    /// first tick of a run. Never allocates.
    pub fn observe_targets(&self, signals: &mut Signals, stack: &StackController, first: bool) {
        let runs = !first && self.runs(stack);
        for ReachedProgram { signal, criterion } in &self.program.reached {
            let truth = if runs && stack.has_reached(criterion) { 1.0 } else { -1.0 };
            signals.assign(*signal, &[truth]);
        }
    }

    /// Responds to a fault of `stack`.
    pub fn fault(&mut self, fault: &Fault, stack: &StackController, time: f64) -> FaultResponse {
        let mut level = self.current;
        loop {
            for i in 0..self.program.states[level].transitions.len() {
                let t = &self.program.states[level].transitions[i];
                let Trigger::Fault(pattern) = &t.trigger else { continue };
                if !self.permits(t) || !matches_fault(pattern, fault, stack) {
                    continue;
                }
                let (target, blend) = (t.target, t.blend);
                if self.program.path(self.current).any(|s| s == target) {
                    // Without a target the robot stands in this state anyway, or moves back inside a limit: there is no
                    // motion to be resumed.
                    if self.stack() == Some(stack.index()) && stack.has_targets() {
                        self.standing = Some(target);
                    }
                    return FaultResponse::AlreadyInTarget;
                }
                return FaultResponse::Transition(self.go(level, target, blend, time));
            }
            match self.program.states[level].parent {
                Some(parent) => level = parent,
                None => return FaultResponse::Unhandled,
            }
        }
    }

    /// Returns true if a transition of an active state is triggered by the violation of this limit task.
    pub fn watches(&self, task: usize) -> bool {
        let all = self.program.path(self.current).flat_map(|s| &self.program.states[s].transitions);
        all.filter(|t| self.permits(t)).any(|t| match &t.trigger {
            Trigger::Fault(FaultPattern::Limit(l)) => *l == task,
            Trigger::Fault(FaultPattern::Kind(k)) => *k == crate::fault::FaultKind::Limit,
            _ => false,
        })
    }

    /// Takes the first transition whose trigger holds at this tick. Never allocates.
    pub fn step(
        &mut self,
        q: &[f64],
        events: &[bool],
        inputs: TickInputs,
        stack: &StackController,
    ) -> Option<StateChange> {
        let time = inputs.times.time;
        if self.program.path(self.current).any(|s| self.guards[s].state) {
            self.model.forward(q, &mut self.data);
        }
        let mut taken = None;
        let mut level = Some(self.current);
        while let Some(s) = level {
            self.look(s, q, inputs);
            self.arm(s, time, stack);
            let found = self.first(s, events, time, stack);
            // Conditions of outer states are evaluated in any case, because they may have to hold for a while.
            taken = taken.or(found.map(|i| (s, i)));
            level = self.program.states[s].parent;
        }
        let (s, i) = taken?;
        let t = &self.program.states[s].transitions[i];
        let (target, blend) = (t.target, t.blend);
        self.guards[s].ways[i].waits = matches!(t.trigger, Trigger::After(_));
        Some(self.go(s, target, blend, time))
    }

    /// Unblocks transitions that restart a state and whose trigger does not hold now, and blocks times that have
    /// elapsed while the machine is already in their target.
    fn arm(&mut self, state: usize, time: f64, stack: &StackController) {
        for i in 0..self.guards[state].ways.len() {
            let t = &self.program.states[state].transitions[i];
            let known = !matches!(t.trigger, Trigger::Reached(_)) || self.runs(stack);
            let passes = matches!(t.trigger, Trigger::After(_)) && self.stays(state, t);
            if self.guards[state].ways[i].waits || passes {
                self.guards[state].ways[i].waits = !known || self.holds(state, i, &[], time, stack);
            }
        }
    }

    /// Returns true if a transition can be taken in the current state.
    fn permits(&self, t: &TransitionProgram) -> bool {
        self.program.permits(self.current, t)
    }

    /// Returns true if a transition keeps the machine in its target, which is already active.
    fn stays(&self, state: usize, t: &TransitionProgram) -> bool {
        self.program.keeps(state, t) && self.program.path(self.current).any(|s| s == t.target)
    }

    /// Returns the first transition of a state that is taken at this tick.
    fn first(&self, state: usize, events: &[bool], time: f64, stack: &StackController) -> Option<usize> {
        let mut kept = false;
        for (i, t) in self.program.states[state].transitions.iter().enumerate() {
            let event = matches!(t.trigger, Trigger::Event(_));
            if !self.permits(t)
                || (kept && !event)
                || self.guards[state].ways[i].waits
                || !self.holds(state, i, events, time, stack)
            {
                continue;
            }
            if !self.stays(state, t) {
                return Some(i);
            }
            kept = true;
        }
        None
    }

    /// Evaluates the conditions of a state.
    fn look(&mut self, state: usize, q: &[f64], inputs: TickInputs) {
        let time = inputs.times.time;
        let Machine { guards, model, data, entered, .. } = self;
        let g = &mut guards[state];
        if g.ways.iter().all(|w| w.condition.is_none()) {
            return;
        }
        g.values.evaluate(Times { t: time - entered[state], time }, inputs.signals);
        let ValueTable { current, rates, .. } = &g.values;
        let TickInputs { velocity, stack_velocity, .. } = inputs;
        let now = TaskState { model, data, q, values: current, rates, velocity, stack_velocity };
        for Guard { condition, since, .. } in &mut g.ways {
            let Some(condition) = condition else { continue };
            let holds = condition.forward(&now).is_ok() && condition.value(0) > 0.0;
            if !holds {
                *since = f64::NAN;
            } else if since.is_nan() {
                *since = time;
            }
        }
    }

    fn holds(&self, state: usize, i: usize, events: &[bool], time: f64, stack: &StackController) -> bool {
        match &self.program.states[state].transitions[i].trigger {
            Trigger::Event(e) => events.get(*e) == Some(&true) || self.raised[0].get(*e) == Some(&true),
            // Tolerates half a microsecond, for the rounding error of a sum of periods.
            Trigger::When { hold, .. } => time - self.guards[state].ways[i].since >= hold - 5e-7,
            Trigger::After(d) => time - self.entered[state] >= d - 5e-7,
            Trigger::Reached(criterion) => self.runs(stack) && stack.has_reached(criterion),
            Trigger::Fault(_) => false,
        }
    }

    /// Returns true if the measures of the current state's stack are valid: that stack runs, and for more than one
    /// tick. A target that starts slowly does not move at its first tick. While the robot stands after a fault, nothing
    /// is reached.
    fn runs(&self, stack: &StackController) -> bool {
        self.stack() == Some(stack.index()) && stack.ticks() > 1 && !self.stands()
    }

    /// Moves from the current state to another; `source` is the state that defines the transition.
    fn go(&mut self, source: usize, target: usize, blend: f64, time: f64) -> StateChange {
        // Innermost state that is not exited: it contains both the transition and its target.
        let holds_target = |s: usize| s != target && self.program.path(target).any(|p| p == s);
        let stays = self.program.path(source).find(|&s| holds_target(s)).unwrap_or(0);
        let (owner, mut state) = (self.owner, self.current);
        let stood = self.stands();
        while state != stays {
            if self.standing == Some(state) {
                self.standing = None;
            }
            self.ask(state, |s| &s.activities, false);
            self.ask(state, |s| &s.exit, true);
            state = self.program.states[state].parent.unwrap_or(stays);
        }
        self.current = stays;
        self.enter(target, time);
        let same = self.owner == owner && self.program.path(stays).any(|s| s == owner);
        let resumes = stood && !self.stands();
        if resumes {
            // The stack begins anew, so that its blend starts at rest.
            self.resumed = time;
        }
        StateChange { blend, stack: !same || resumes }
    }

    /// Enters a state inside the current one, with the states between them and its initial states.
    fn enter(&mut self, target: usize, time: f64) {
        let leaf = self.program.leaf(target);
        let inside = |m: &Machine, s: usize| m.program.path(leaf).take_while(|&p| p != s).last();
        let first = self.current == 0 && target == 0;
        if first {
            self.enter_one(0, time);
        }
        while let Some(next) = inside(self, self.current) {
            self.enter_one(next, time);
            self.current = next;
        }
        self.owner = self.program.owner(self.current).unwrap_or(0);
    }

    fn enter_one(&mut self, state: usize, time: f64) {
        self.entered[state] = time;
        self.entries[state] += 1;
        self.guards[state].enter();
        self.ask(state, |s| &s.enter, true);
        self.ask(state, |s| &s.activities, true);
    }

    fn ask(&mut self, state: usize, which: fn(&crate::program::StateProgram) -> &Vec<usize>, begin: bool) {
        let Machine { program, requests, raised, pending, entered, .. } = self;
        for &action in which(&program.states[state]) {
            let asked = &program.actions[action];
            match asked.event {
                _ if asked.own.is_some() && !begin => {}
                _ if asked.own.is_some() && pending.len() < pending.capacity() => {
                    pending.push((action, entered[state]));
                }
                _ if asked.own.is_some() => {}
                Some(event) if begin => raised[1][event] = true,
                Some(_) => {}
                None if requests.len() < requests.capacity() => requests.push(Request { action, begin }),
                None => {}
            }
        }
    }
}

fn matches_fault(pattern: &FaultPattern, fault: &Fault, stack: &StackController) -> bool {
    match (pattern, fault) {
        (FaultPattern::Any, _) => true,
        (FaultPattern::Kind(kind), f) => f.kind() == *kind,
        (FaultPattern::Stale(signal), Fault::Stale { signal: s }) => s == signal,
        (FaultPattern::StaleAmong(all), Fault::Stale { signal }) => all.contains(signal),
        (FaultPattern::Infeasible(name), Fault::Infeasible { level }) => stack.level_names().get(*level) == Some(name),
        (FaultPattern::Limit(task), Fault::Limit { member, .. }) => {
            stack.evaluator.members().get(*member).is_some_and(|m| m.program_index == *task)
        }
        _ => false,
    }
}
