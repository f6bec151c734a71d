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
//! The regions of a state are active beside each other, each with a state of its own. They are stepped in the order
//! written, each like a machine of its own: the transitions of its innermost state first, then those of the states around
//! it, out to the machine. A transition that leads out of its region, or that is defined around the regions, leaves them
//! all, and ends the tick of the machine.
//!
//! In a final state, only transitions to final states are tested: a machine that has ended does not begin again. In
//! a region, this concerns the transitions of the region.
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
use crate::program::{
    BESIDE, FaultPattern, MachineProgram, Program, ReachedProgram, Times, TransitionProgram, Trigger,
};
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

/// Part of the running stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// State that names its stack.
    pub owner: usize,
    /// Number of entries into this state.
    pub entries: u64,
    /// Time since which the part has run (s).
    pub entered: f64,
}

/// Result of a transition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StateChange {
    /// Duration of the blend to the new command (s).
    pub blend: f64,
    /// True if the stack of the new state is entered.
    pub stack: bool,
    /// True if no part of it goes on from the stack before, because the robot stood.
    pub anew: bool,
}

impl StateChange {
    /// This change and another one at the same tick.
    fn then(self, next: StateChange) -> StateChange {
        StateChange {
            blend: if next.stack { next.blend } else { self.blend },
            stack: self.stack || next.stack,
            anew: self.anew || next.anew,
        }
    }
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
    pub(super) program: MachineProgram,
    pub(super) guards: Vec<Guards>,
    model: Model,
    data: Data,
    /// The innermost active state that is not in a region.
    pub(super) current: usize,
    /// For each of its regions, the innermost active state.
    pub(super) inner: Vec<usize>,
    /// Text of the active states, if there are regions.
    pub(super) text: String,
    /// Time at which each state was entered (s).
    pub(super) entered: Vec<f64>,
    /// Number of entries into each state.
    pub(super) entries: Vec<u64>,
    /// States whose stacks run, in the order of their regions; the machine itself if there are none.
    pub(super) owners: Vec<usize>,
    /// Those before a transition.
    pub(super) before: Vec<usize>,
    /// Time at which the running stack was entered (s).
    pub(super) stack_since: f64,
    /// True if a state has regions.
    has_regions: bool,
    /// True if a condition is about targets, or a transition about limits.
    looks_at_tasks: bool,
    /// Active state that the transition for a fault leads to; the robot stands still until the machine leaves it.
    pub(super) standing: Option<usize>,
    /// Time at which the stack last began anew after such a stop, without an entry of its state (s).
    pub(super) resumed: f64,
    /// For each state, the time for which the targets of its stack have waited since then (s).
    pub(super) waited: Vec<f64>,
    /// Requests of this tick.
    pub requests: Vec<Request>,
    /// Events that the machine raised at the previous tick, and those of this one.
    pub(super) raised: [Vec<bool>; 2],
    /// For each action, the part that the controller performs itself.
    own: Vec<Option<ReadyAction>>,
    /// Own actions due at this tick, each with the time at which its state was entered (s).
    pub(super) pending: Vec<(usize, f64)>,
}

impl Machine {
    /// Prepares a checked machine.
    pub fn new(program: &Program, machine: &MachineProgram) -> Machine {
        let states = machine.states.len();
        let events = program.interface.events.len();
        let regions = machine.states.iter().map(|s| s.regions.len()).max().unwrap_or(0);
        let mut owners = Vec::with_capacity(regions.max(1));
        owners.push(0);
        // Each state is left and entered at most once at a tick; one in a region once more, if another region is left.
        let most = if machine.has_regions() { 4 } else { 2 };
        let triggers = || machine.states.iter().flat_map(|s| &s.transitions).map(|t| &t.trigger);
        let is_about_tasks = |trigger: &Trigger| match trigger {
            Trigger::Reached(_) | Trigger::Fault(FaultPattern::Limit(_)) => true,
            Trigger::Fault(FaultPattern::Kind(kind)) => *kind == crate::fault::FaultKind::Limit,
            _ => false,
        };
        Machine {
            guards: (0..states).map(|s| Guards::new(program, machine, s)).collect(),
            data: Data::new(&program.robot.model),
            model: program.robot.model.clone(),
            current: machine.spine(machine.leaf(0)),
            inner: Vec::with_capacity(regions),
            text: String::with_capacity(longest_text(machine)),
            entered: vec![0.0; states],
            entries: vec![0; states],
            owners,
            before: Vec::with_capacity(regions.max(1)),
            stack_since: 0.0,
            has_regions: machine.has_regions(),
            looks_at_tasks: !machine.reached.is_empty() || triggers().any(is_about_tasks),
            standing: None,
            resumed: f64::NEG_INFINITY,
            waited: vec![0.0; states],
            requests: Vec::with_capacity((most * machine.actions.len() + 2) * super::clock::MOST_DECISIONS),
            raised: [vec![false; events], vec![false; events]],
            own: machine.actions.iter().map(|a| a.own.as_ref().map(|own| ReadyAction::new(program, own))).collect(),
            pending: Vec::with_capacity(most * machine.actions.len()),
            program: machine.clone(),
        }
    }

    /// The innermost state that the machine is in; of regions, the state around them.
    pub fn state(&self) -> usize {
        self.current
    }

    /// The innermost active states: one, or one for each region.
    pub fn leaves(&self) -> &[usize] {
        if self.inner.is_empty() { std::slice::from_ref(&self.current) } else { &self.inner }
    }

    /// The active states: those of each region from the inside out, then those around them.
    fn active(&self) -> impl Iterator<Item = usize> + '_ {
        let regions = self.inner.iter().flat_map(|&leaf| self.program.path(leaf).take_while(|&s| s != self.current));
        regions.chain(self.program.path(self.current))
    }

    /// Returns true if a state is active.
    pub fn is_in(&self, state: usize) -> bool {
        self.active().any(|s| s == state)
    }

    /// Largest length of this text while regions are active.
    pub fn longest_text(&self) -> usize {
        longest_text(&self.program)
    }

    /// Path of the innermost active state, or those of the regions, joined.
    pub fn text(&self) -> &str {
        if self.inner.is_empty() { &self.program.states[self.current].name } else { &self.text }
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
        self.program.stack_of(&self.owners)
    }

    /// Returns true if the robot stands still because a fault occurred in the target of its own transition.
    pub fn stands(&self) -> bool {
        self.standing.is_some()
    }

    /// Time at which the state whose stack runs was entered, or at which the stack began anew there (s), later by what its targets have waited. With
    /// regions, the time of the last change of the stack.
    pub fn stack_entered(&self) -> f64 {
        if self.has_regions { self.stack_since.max(self.resumed) } else { self.targets_since(self.owners[0]) }
    }

    /// Time since which the targets of the stack of a state have moved, without those for which they waited (s).
    fn targets_since(&self, owner: usize) -> f64 {
        self.entered[owner].max(self.resumed) + self.waited[owner]
    }

    /// Lets the time of the targets stand for a while (s). The times of its states go on.
    pub fn wait(&mut self, time: f64) {
        self.stack_since += time;
        for &owner in &self.owners {
            self.waited[owner] += time;
        }
    }

    /// Returns true if a state has regions, so that a part of a stack may go on in another one.
    pub fn has_regions(&self) -> bool {
        self.has_regions
    }

    /// Parts of the running stack: the states that name their stacks.
    pub fn parts(&self) -> impl Iterator<Item = Part> + '_ {
        let part = |&owner: &usize| Part { owner, entries: self.entries[owner], entered: self.targets_since(owner) };
        self.owners.iter().map(part)
    }

    /// Restarts the machine in its initial state.
    pub fn start(&mut self, time: f64) {
        self.pending.clear();
        self.raised.iter_mut().for_each(|r| r.fill(false));
        self.entries.fill(0);
        self.current = 0;
        self.inner.clear();
        self.stack_since = time;
        (self.standing, self.resumed) = (None, f64::NEG_INFINITY);
        self.enter(0, time);
    }

    /// Lets the running stack begin at a time (s), after it was waited for.
    pub fn begin_stack(&mut self, time: f64) {
        (self.stack_since, self.resumed) = (time, time);
        self.waited.fill(0.0);
    }

    /// Begins a tick: makes the events raised at the previous one visible.
    pub fn begin(&mut self) {
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
        let needs = self.active().flat_map(|s| self.guards[s].values.needs());
        needs.copied().find(|&s| is_stale(s)).map(|signal| Fault::Stale { signal })
    }

    /// Sets the flags of targets that conditions ask to be reached, by the last tick of `stack`; none is reached at the
    /// first tick of a run. Never allocates.
    pub fn observe_targets(&self, signals: &mut Signals, stack: &StackController, first: bool) {
        let runs = |task: usize| !first && self.runs(stack, task);
        for ReachedProgram { signal, criterion } in &self.program.reached {
            let truth = if runs(criterion.task) && stack.has_reached(criterion) { 1.0 } else { -1.0 };
            signals.assign(*signal, &[truth]);
        }
    }

    /// Responds to a fault of `stack`.
    pub fn fault(&mut self, fault: &Fault, stack: &StackController, time: f64) -> FaultResponse {
        let Some((level, target, blend)) = self.answer(fault, stack) else { return FaultResponse::Unhandled };
        if self.is_in(target) {
            // Without a target the robot stands in this state anyway, or moves back inside a limit: there is no
            // motion to be resumed.
            if self.stack() == Some(stack.index()) && stack.has_targets() {
                self.standing = Some(target);
            }
            return FaultResponse::AlreadyInTarget;
        }
        FaultResponse::Transition(self.go(level, target, blend, time).change)
    }

    /// First transition for a fault: its state, its target and its blend (s).
    fn answer(&self, fault: &Fault, stack: &StackController) -> Option<(usize, usize, f64)> {
        self.active().find_map(|level| {
            self.program.states[level].transitions.iter().find_map(|t| {
                let Trigger::Fault(pattern) = &t.trigger else { return None };
                let answers = self.permits(level, t) && matches_fault(pattern, fault, stack);
                answers.then_some((level, t.target, t.blend))
            })
        })
    }

    /// Returns true if a condition is about targets, or a transition about limits.
    pub fn looks_at_tasks(&self) -> bool {
        self.looks_at_tasks
    }

    /// Returns true if a transition of an active state is triggered by the violation of this limit task.
    pub fn watches(&self, task: usize) -> bool {
        let of = |s: usize| self.program.states[s].transitions.iter().filter(move |t| self.permits(s, t));
        self.active().flat_map(of).any(|t| match &t.trigger {
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
        if self.active().any(|s| self.guards[s].state) {
            self.model.forward(q, &mut self.data);
        }
        // Conditions of outer states are evaluated in any case, because they may have to hold for a while.
        for region in 0..self.inner.len() {
            self.look_from(self.inner[region], Some(self.current), q, inputs, stack);
        }
        self.look_from(self.current, None, q, inputs, stack);
        let mut change: Option<StateChange> = None;
        for region in 0..self.inner.len().max(1) {
            let from = self.leaves()[region];
            let found = self.program.path(from).find_map(|s| Some((s, self.first(s, events, time, stack)?)));
            let Some((s, i)) = found else { continue };
            let t = &self.program.states[s].transitions[i];
            let (target, blend) = (t.target, t.blend);
            self.guards[s].ways[i].waits = matches!(t.trigger, Trigger::After(_));
            let moved = self.go(s, target, blend, time);
            change = Some(change.map_or(moved.change, |before| before.then(moved.change)));
            if moved.left_regions {
                break;
            }
        }
        change
    }

    /// Evaluates the conditions of a state and those around it, up to `until`.
    fn look_from(&mut self, from: usize, until: Option<usize>, q: &[f64], inputs: TickInputs, stack: &StackController) {
        let mut level = Some(from);
        while let Some(s) = level.filter(|s| Some(*s) != until) {
            self.look(s, q, inputs);
            self.arm(s, inputs.times.time, stack);
            level = self.program.states[s].parent;
        }
    }

    /// Unblocks transitions that restart a state and whose trigger does not hold now, and blocks times that have
    /// elapsed while the machine is already in their target.
    fn arm(&mut self, state: usize, time: f64, stack: &StackController) {
        for i in 0..self.guards[state].ways.len() {
            let t = &self.program.states[state].transitions[i];
            let known = match &t.trigger {
                Trigger::Reached(criterion) => self.runs(stack, criterion.task),
                _ => true,
            };
            let passes = matches!(t.trigger, Trigger::After(_)) && self.stays(state, t);
            if self.guards[state].ways[i].waits || passes {
                self.guards[state].ways[i].waits = !known || self.holds(state, i, &[], time, stack);
            }
        }
    }

    /// Returns true if a transition of an active state can be taken.
    fn permits(&self, state: usize, t: &TransitionProgram) -> bool {
        let region = self.inner.iter().find(|&&leaf| self.program.path(leaf).any(|s| s == state));
        self.program.permits(region.copied().unwrap_or(self.current), state, t)
    }

    /// Returns true if a transition keeps the machine in its target, which is already active.
    fn stays(&self, state: usize, t: &TransitionProgram) -> bool {
        self.program.keeps(state, t) && self.is_in(t.target)
    }

    /// Returns the first transition of a state that is taken at this tick.
    fn first(&self, state: usize, events: &[bool], time: f64, stack: &StackController) -> Option<usize> {
        let mut kept = false;
        for (i, t) in self.program.states[state].transitions.iter().enumerate() {
            let event = matches!(t.trigger, Trigger::Event(_));
            if !self.permits(state, t)
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
            Trigger::Reached(criterion) => self.runs(stack, criterion.task) && stack.has_reached(criterion),
            Trigger::Ended(regions) => regions.iter().all(|r| self.has_ended(*r)),
            Trigger::Fault(_) => false,
        }
    }

    /// Returns true if a region is active and has ended.
    fn has_ended(&self, region: usize) -> bool {
        let leaf = self.inner.iter().find(|&&leaf| self.program.region(leaf) == Some(region));
        leaf.is_some_and(|&leaf| self.program.region_ends(leaf))
    }

    /// Returns true if the measures of a task of the current state's stack are valid: it runs, and for more than one
    /// tick. A target that starts slowly does not move at its first tick. While the robot stands after a fault, nothing
    /// is reached.
    fn runs(&self, stack: &StackController, task: usize) -> bool {
        self.stack() == Some(stack.index()) && stack.ticks_of(task) > 1 && !self.stands()
    }
}

/// Largest length of the text of the active states.
fn longest_text(machine: &MachineProgram) -> usize {
    let longest = |r: usize| {
        let inside = (0..machine.states.len()).filter(|&s| machine.region(s) == Some(r));
        inside.map(|s| machine.states[s].name.len() + BESIDE.len()).max().unwrap_or(0)
    };
    machine.states.iter().map(|s| s.regions.iter().map(|r| longest(*r)).sum()).max().unwrap_or(0)
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
