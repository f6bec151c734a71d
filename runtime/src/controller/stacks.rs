//! The stacks that a run can enter, and which of them runs.

use super::machine::{Machine, Part, StateChange};
use super::stack_controller::{Carried, StackController, common_levels, standing};
use crate::program::{MachineProgram, Program, ProgramError};

/// Entry of a stack that is due.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    /// Index of the stack.
    stack: usize,
    /// Duration of the blend (s).
    blend: f64,
    /// True if no part of the stack goes on from the one before.
    anew: bool,
}

/// Stacks of a controller.
pub(super) struct Stacks {
    /// Stacks that a run can enter, followed by an empty stack if a state has none.
    all: Vec<StackController>,
    /// Number of levels that each pair of stacks shares.
    common: Vec<Vec<usize>>,
    /// Index in `all` of each stack of the program.
    index_of_stack: Vec<usize>,
    /// Index in `all` of the stack that runs.
    active: usize,
    /// Entry of this stack, if it is due.
    entry: Option<Entry>,
    /// Number of times a stack has been entered.
    visits: u64,
    /// Index of the stack that was entered last, with its parts.
    entered: Option<usize>,
    parts: Vec<Part>,
    /// Parts of that stack as they were entered, and the index of the stack before it.
    carried: Vec<Carried>,
    carried_from: Option<usize>,
    /// Index of the stack whose velocity moves the robot; `None` at rest.
    moving: Option<usize>,
    /// The one that moved the robot before it came to rest.
    moved: Option<usize>,
}

impl Stacks {
    /// Prepares the stacks of a machine.
    ///
    /// # Errors
    /// A stack cannot be executed.
    pub fn new(program: &Program, machine: &MachineProgram) -> Result<Stacks, ProgramError> {
        let mut index_of_stack = vec![usize::MAX; program.stacks.len()];
        let mut all = Vec::new();
        for stack in machine.stacks() {
            if index_of_stack.get(stack).is_none_or(|s| *s == usize::MAX) {
                all.push(StackController::new(program, stack)?);
                index_of_stack[stack] = all.len() - 1;
            }
        }
        if machine.may_stand() {
            all.push(StackController::new(&standing(program), program.stacks.len())?);
        }
        let most = machine.states.iter().map(|s| s.regions.len()).max().unwrap_or(0).max(1);
        Ok(Stacks {
            common: common_levels(program, &all),
            all,
            index_of_stack,
            active: 0,
            entry: None,
            visits: 0,
            entered: None,
            parts: Vec::with_capacity(most),
            carried: Vec::with_capacity(most),
            carried_from: None,
            moving: None,
            moved: None,
        })
    }

    /// Forgets which stack has run.
    pub fn restart(&mut self) {
        (self.entered, self.moving, self.moved, self.entry) = (None, None, None, None);
    }

    /// All stacks.
    pub fn all(&self) -> &[StackController] {
        &self.all
    }

    /// Index of the stack that runs.
    pub fn index(&self) -> usize {
        self.active
    }

    /// Number of times a stack has been entered.
    pub fn visits(&self) -> u64 {
        self.visits
    }

    /// The stack that runs.
    pub fn active(&self) -> &StackController {
        &self.all[self.active]
    }

    /// The stack that runs, to be changed.
    pub fn active_mut(&mut self) -> &mut StackController {
        &mut self.all[self.active]
    }

    /// The stack whose limits hold while the robot comes to rest: the one that moves it.
    pub fn moving_mut(&mut self) -> Option<&mut StackController> {
        self.moving.map(|m| &mut self.all[m])
    }

    /// Notes that the robot is at rest.
    pub fn rest(&mut self) {
        self.moved = self.moving.take().or(self.moved);
    }

    /// The stack that moves the robot, or that moved it last.
    pub fn moved(&self) -> Option<&StackController> {
        self.moving.or(self.moved).map(|m| &self.all[m])
    }

    /// Index of the stack before the running one, if parts of it go on.
    pub fn carried_from(&self) -> Option<usize> {
        self.carried_from
    }

    /// For each part of the running stack, the part of the stack before that it continues.
    pub fn carried(&self) -> impl Iterator<Item = Option<usize>> + '_ {
        self.carried.iter().map(|c| c.before)
    }

    /// Signals that the outputs of the tasks of any stack set.
    pub fn output_signals(&self) -> impl Iterator<Item = usize> + '_ {
        self.all.iter().flat_map(|s| s.evaluator.output_signals())
    }

    /// Selects the stack of the machine's state, to be entered at the next tick in which it runs. A state without a stack has the empty one, which
    /// is entered at rest.
    pub fn select(&mut self, machine: &Machine, change: StateChange) {
        let stack = machine.stack().map_or(self.all.len() - 1, |s| self.index_of_stack[s]);
        let anew = change.anew || self.entry.is_some_and(|e| e.anew);
        self.entry = Some(Entry { stack, blend: change.blend, anew });
    }

    /// Returns true if a stack is yet to be entered.
    pub fn is_entry_due(&self) -> bool {
        self.entry.is_some()
    }

    /// The stack that is to be entered.
    pub fn due(&self) -> Option<&StackController> {
        self.entry.and_then(|entry| self.all.get(entry.stack))
    }

    /// Lets no part of the stack that is to be entered go on from the one before.
    pub fn enter_anew(&mut self) {
        if let Some(entry) = &mut self.entry {
            entry.anew = true;
        }
    }

    /// Duration of the blend of the entry that is due (s).
    pub fn fade(&self) -> f64 {
        self.entry.map_or(0.0, |entry| entry.blend)
    }

    /// Takes the entry that is due: makes its stack the running one and prepares it. Returns the blend.
    pub fn begin_entry(&mut self, machine: &Machine) -> Option<Begun> {
        let entry = self.entry.take()?;
        let met = |from: usize| self.common[from][entry.stack].min(self.all[from].levels_met());
        let common = self.moving.map_or(0, met);
        self.active = entry.stack;
        self.visits += 1;
        self.prepare(machine, entry.anew);
        Some(Begun { blend: entry.blend, common })
    }

    /// Notes that the running stack moves the robot.
    pub fn move_by_active(&mut self) {
        self.moving = Some(self.active);
    }

    /// Prepares the entry of the active stack: parts of the stack before it that its regions have not left go on.
    fn prepare(&mut self, machine: &Machine, anew: bool) {
        let anew = anew || !machine.has_regions();
        let from = self.entered.replace(self.active).filter(|_| !anew);
        self.carried.clear();
        for part in machine.parts() {
            let same = |p: &Part| (p.owner, p.entries) == (part.owner, part.entries);
            let before = from.and_then(|_| self.parts.iter().position(same));
            self.carried.push(Carried { entered: part.entered, before });
        }
        self.parts.clear();
        self.parts.extend(machine.parts());
        self.carried_from = from.filter(|_| self.carried.iter().any(|c| c.before.is_some()));
        if !machine.has_regions() {
            return self.all[self.active].begin_anew();
        }
        let before = self.carried_from.filter(|from| *from != self.active);
        let Some(from) = before else {
            return self.all[self.active].prepare(&self.carried, None);
        };
        let (low, high) = self.all.split_at_mut(from.max(self.active));
        let (Some(last), Some(high)) = (low.get_mut(from.min(self.active)), high.first_mut()) else { return };
        if from < self.active {
            high.prepare(&self.carried, Some(last))
        } else {
            last.prepare(&self.carried, Some(high))
        }
    }
}

/// Entry of a stack that has begun.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begun {
    /// Duration of the blend (s).
    pub blend: f64,
    /// Number of levels, from the top, that the stack shares with the one before.
    pub common: usize,
}
