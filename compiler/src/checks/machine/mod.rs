//! Static checks of a machine.

mod counts;
mod exits;
mod fault_answers;
mod finals;
mod flips;
mod hysteresis;
mod lost_events;
mod never;
mod one_target;
mod outcomes;
mod presence;
mod properties;
mod recoveries;
mod restless;
mod scope_events;
mod separation_stops;
mod stacks;
mod stop_events;
mod task_outputs;

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{MachineProgram, Program, ReachedProgram, TransitionProgram, Trigger};
use stdlib_tasks::expression::Expression;

use crate::analysis::conditions::Conditions;
use crate::analysis::exploration::{Exploration, Way};
use crate::analysis::regions::{self, Elsewhere};
use crate::analysis::stacks::Stacks;
use crate::source_map::MachinePlaces;

/// The machine of a program, with its source places.
pub(crate) struct Checked<'c> {
    program: &'c Program,
    stacks: &'c Stacks<'c>,
    machine: &'c MachineProgram,
    places: &'c MachinePlaces,
    /// Conditions of the transitions.
    conditions: &'c Conditions,
    /// All that the machine can do; `None` if that is too much to be explored.
    exploration: Option<&'c Exploration<'c>>,
    /// Effects that regions that the machine leaves out may have.
    elsewhere: &'c Elsewhere,
    /// For each transition of each state, the value of its condition if it never changes.
    constants: Vec<Vec<Option<bool>>>,
    /// Reachable states.
    reached: BTreeSet<usize>,
}

/// Runs all checks of the machine.
pub(super) fn checks(c: &super::Checked, diagnostics: &mut Vec<Diagnostic>) {
    let (Some(machine), Some(places)) = (&c.program.machine, &c.places.machine) else { return };
    if !machine.has_regions() {
        return checks_of(c, machine, places, &Elsewhere::default(), diagnostics);
    }
    let views = regions::views(machine, places);
    let found = views.iter().map(|view| {
        let mut found = Vec::new();
        checks_of(c, &view.machine, &view.places, &view.elsewhere, &mut found);
        found
    });
    diagnostics.extend(regions::agreed(&views, found.collect()));
}

/// Runs all checks of a machine without regions.
fn checks_of(
    c: &super::Checked,
    machine: &MachineProgram,
    places: &MachinePlaces,
    elsewhere: &Elsewhere,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let (program, context, stacks) = (c.program, c.context, &c.stacks);
    let conditions = &Conditions::new(context.graph, &program.interface, machine, places);
    let constants = never::constants(conditions, machine, places);
    let events = (places.declared_events, elsewhere);
    let mut exploration = Exploration::new(program, stacks, machine, context.graph, conditions, events);
    let cycles = exploration.cycles(&flips::ranges(conditions, context));
    let verdicts = properties::judge(&mut exploration, places, context.graph, (program.interface.width(), elsewhere));
    let exploration = Some(&exploration).filter(|e| e.is_complete());
    let reached = BTreeSet::new();
    let mut c = Checked { program, stacks, machine, places, conditions, exploration, elsewhere, constants, reached };
    c.reached = c.reachable();
    c.unreachable(diagnostics);
    c.traps(diagnostics);
    c.no_exit_possible(diagnostics);
    c.flips(&cycles, context.graph, diagnostics);
    c.properties(&verdicts, context.graph, diagnostics);
    c.hysteresis(&cycles, diagnostics);
    c.never(diagnostics);
    c.counts(diagnostics);
    c.restless(diagnostics);
    c.faults(diagnostics);
    c.fault_answers(diagnostics);
    c.waiting(diagnostics);
    c.task_outputs(diagnostics);
    c.lost_events(diagnostics);
    c.scope_events(diagnostics);
    c.stop_events(diagnostics);
    c.recoveries(diagnostics);
    c.separation_stops(context.graph, diagnostics);
    c.outcomes(diagnostics);
    c.one_target(diagnostics);
    c.finals(diagnostics);
    c.region_finals(diagnostics);
    c.stacks(diagnostics);
    c.absent(diagnostics);
}

impl Checked<'_> {
    /// True if the condition of a transition never holds.
    fn is_dead(&self, state: usize, transition: usize) -> bool {
        self.constants[state][transition] == Some(false)
    }

    /// Reachable states, with their enclosing states.
    fn reachable(&self) -> BTreeSet<usize> {
        match self.exploration {
            Some(explored) => explored.leaves().into_iter().flat_map(|l| self.machine.path(l)).collect(),
            None => self.connected(),
        }
    }

    /// States to which transitions lead whose own conditions can hold, with their enclosing states.
    fn connected(&self) -> BTreeSet<usize> {
        self.connected_by(|_| true)
    }

    /// States to which transitions lead whose own conditions can hold and whose triggers count, with their enclosing states.
    fn connected_by(&self, counts: impl Fn(&Trigger) -> bool) -> BTreeSet<usize> {
        let m = self.machine;
        let mut reached = BTreeSet::new();
        let mut open = vec![m.leaf(0)];
        while let Some(leaf) = open.pop() {
            if !reached.insert(leaf) {
                continue;
            }
            for s in m.path(leaf) {
                reached.insert(s);
                let all = m.states[s].transitions.iter().enumerate();
                let alive = all.filter(|(i, t)| counts(&t.trigger) && !self.is_dead(s, *i) && m.permits(leaf, s, t));
                open.extend(alive.map(|(_, t)| m.leaf(t.target)));
            }
        }
        reached
    }

    /// Reachable states without states inside that are `state` itself or inside it.
    fn leaves(&self, state: usize) -> impl Iterator<Item = usize> + '_ {
        let innermost = self.reached.iter().copied().filter(|&l| self.machine.states[l].initial.is_none());
        innermost.filter(move |&l| l == state || self.machine.is_around(state, l))
    }

    fn name(&self, state: usize) -> &str {
        &self.machine.states[state].name
    }

    fn unreachable(&self, diagnostics: &mut Vec<Diagnostic>) {
        let connected = self.connected();
        let told = |s: usize| connected.contains(&s) && self.follows(s);
        for s in (1..self.machine.states.len()).filter(|s| !self.reached.contains(s) && !told(*s)) {
            // One message covers a state and all states inside it.
            if self.machine.states[s].parent.is_some_and(|p| p != 0 && !self.reached.contains(&p)) {
                continue;
            }
            let text = format!("state `{}` is never entered", self.name(s));
            let named = self.machine.states.iter().flat_map(|o| &o.transitions).any(|t| t.target == s);
            let d = Diagnostic::warning("HQ0704", self.places.states[s], text);
            diagnostics.push(if named {
                d.note("no transition to it can be taken").help("add a transition from a reachable state, or remove it")
            } else {
                d.help(Help::with(
                    "add a transition to it, {}, or remove it",
                    [Snippet::transition("EVENT", self.name(s))],
                ))
            });
        }
    }

    /// True if it follows from other diagnostics that a state is never entered: each transition to it is one that earlier
    /// ones always precede, or one of a state that is never entered or never left.
    fn follows(&self, state: usize) -> bool {
        let m = self.machine;
        let inside = |t: usize| m.path(m.leaf(t)).any(|p| p == state);
        let left = |s: usize| {
            self.leaves(s).any(|l| self.exploration.is_none_or(|e| e.nodes_of(l).any(|n| !e.steps[n].is_empty())))
        };
        self.reached.iter().filter(|&&s| left(s)).all(|&s| {
            let all = m.states[s].transitions.iter().enumerate().filter(|(_, t)| inside(t.target));
            all.into_iter().all(|(i, _)| {
                let excluded = || self.excluded(Way { state: s, index: i }).is_some();
                self.preceded(s, i).is_some() || self.outlasted(s, i).is_some() || excluded()
            })
        })
    }

    /// Warns of states that are entered and never left, although they are not final.
    fn traps(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            let own = &self.machine.states[s];
            if s == 0 || own.initial.is_some() || self.ends(s) || self.has_exit(s) {
                continue;
            }
            let text = format!("state `{}` has no exit", self.name(s));
            let d = Diagnostic::warning("HQ0705", self.places.states[s], text);
            diagnostics.push(d.help(Help::with(
                "add a transition, or declare it as final, {}, if the machine ends here",
                [Snippet::each("final state NAME", "NAME: { final: true }")],
            )));
        }
    }

    /// True if a transition may lead out of an innermost state, as far as its own condition and its target tell.
    fn has_exit(&self, leaf: usize) -> bool {
        // A fault transition does not count as an exit, because it is not taken in normal operation.
        self.machine.path(leaf).any(|p| {
            let all = self.machine.states[p].transitions.iter().enumerate();
            // A condition that leads to the current state is not taken.
            let stays =
                |t: &TransitionProgram| self.machine.keeps(p, t) && self.machine.path(leaf).any(|o| o == t.target);
            let alive = |i, t: &TransitionProgram| !is_fault(&t.trigger) && !self.is_dead(p, i);
            all.into_iter().any(|(i, t)| alive(i, t) && !stays(t))
        })
    }

    fn faults(&self, diagnostics: &mut Vec<Diagnostic>) {
        let answers = |s: usize| self.machine.states[s].transitions.iter().any(|t| is_fault(&t.trigger));
        if (0..self.machine.states.len()).any(answers) {
            return;
        }
        let text = format!("machine `{}` answers no fault", self.name(0));
        diagnostics.push(
            Diagnostic::warning("HQ0707", self.places.states[0], text)
                .note("at a fault the robot comes to rest, and stays there until the controller is restarted")
                .help(Help::with("add a transition: {}", [Snippet::transition("fault(any)", "STATE")])),
        );
    }

    /// Reports transitions that wait for the completion of a task that does not run there.
    fn waiting(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                let tasks: Vec<usize> = match &t.trigger {
                    Trigger::Reached(criterion) => vec![criterion.task],
                    Trigger::When { condition, .. } => {
                        self.targets_of(condition).iter().map(|r| r.criterion.task).collect()
                    }
                    _ => continue,
                };
                let leaves = self.reached.iter().copied().filter(|&l| self.machine.states[l].initial.is_none());
                let inside: Vec<usize> = leaves.filter(|&l| self.machine.path(l).any(|p| p == s)).collect();
                let runs = |task: usize| inside.iter().any(|l| self.runs(*l, task));
                let Some(task) = tasks.into_iter().find(|task| !runs(*task)).filter(|_| !inside.is_empty()) else {
                    continue;
                };
                let name = &self.program.tasks[task].name;
                let text = format!("`{name}` does not run in state `{}`, so it is never reached there", self.name(s));
                let mut d = Diagnostic::error("HQ0703", self.places.transitions[s][i].trigger, text);
                if let Some(at) = self.places.stacks[s] {
                    d = d.label(at, format!("this stack does not contain `{name}`"));
                }
                diagnostics.push(d.help("name a task of the state's own stack, or add this one to it"));
            }
        }
    }

    /// Targets that a condition asks to be reached.
    fn targets_of(&self, condition: &Expression) -> Vec<&ReachedProgram> {
        let read: BTreeSet<usize> = condition.inputs.iter().copied().collect();
        let signals = self.program.values.tape.only(&read).signals();
        let signals: Vec<usize> = signals.into_iter().filter_map(|at| self.program.interface.signal_of(at)).collect();
        self.machine.reached.iter().filter(|r| signals.contains(&r.signal)).collect()
    }

    /// True if a task runs in an innermost state, or may run in a region beside it.
    fn runs(&self, leaf: usize, task: usize) -> bool {
        let stacks = self.machine.stack(leaf).into_iter().chain(self.elsewhere.beside(self.machine, leaf));
        stacks.into_iter().any(|stack| self.holds(stack, task))
    }

    /// True if the machine, or the region of the state, has ended in a state.
    fn ends(&self, state: usize) -> bool {
        self.machine.ends(state) || self.machine.path(state).any(|s| self.elsewhere.ends.contains(&s))
    }

    fn holds(&self, stack: usize, task: usize) -> bool {
        self.program.stacks[stack].levels.iter().flat_map(|l| &l.members).any(|m| m.task == task)
    }
}

fn is_fault(trigger: &Trigger) -> bool {
    matches!(trigger, Trigger::Fault(_))
}
