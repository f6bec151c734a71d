//! Static checks of a machine.

mod fault_answers;
mod presence;
mod stacks;
mod task_outputs;

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::program::{FaultPattern, MachineProgram, Program, Subject, TransitionProgram, Trigger};

use crate::source_map::MachinePlaces;

/// The machine of a program, with its source places.
pub(crate) struct Checked<'c> {
    program: &'c Program,
    machine: &'c MachineProgram,
    places: &'c MachinePlaces,
    /// Reachable states.
    reached: BTreeSet<usize>,
}

/// Runs all checks of the machine.
pub(super) fn checks(program: &Program, places: Option<&MachinePlaces>, diagnostics: &mut Vec<Diagnostic>) {
    let (Some(machine), Some(places)) = (&program.machine, places) else { return };
    let reached = reached(machine, places);
    let c = Checked { program, machine, places, reached };
    c.unreachable(diagnostics);
    c.traps(diagnostics);
    c.never(diagnostics);
    c.faults(diagnostics);
    c.fault_answers(diagnostics);
    c.waiting(diagnostics);
    c.task_outputs(diagnostics);
    c.targets(diagnostics);
    c.stacks(diagnostics);
    c.absent(diagnostics);
}

/// True if the condition of a transition never holds.
fn is_dead(places: &MachinePlaces, state: usize, transition: usize) -> bool {
    places.transitions[state][transition].constant == Some(false)
}

/// Reachable states, with their enclosing states.
fn reached(m: &MachineProgram, places: &MachinePlaces) -> BTreeSet<usize> {
    let mut reached = BTreeSet::new();
    let mut open = vec![m.leaf(0)];
    while let Some(state) = open.pop() {
        for s in m.path(state).collect::<Vec<_>>() {
            if !reached.insert(s) {
                continue;
            }
            let alive = m.states[s].transitions.iter().enumerate().filter(|(i, _)| !is_dead(places, s, *i));
            open.extend(alive.map(|(_, t)| m.leaf(t.target)));
        }
    }
    reached
}

impl Checked<'_> {
    fn name(&self, state: usize) -> &str {
        &self.machine.states[state].name
    }

    fn unreachable(&self, diagnostics: &mut Vec<Diagnostic>) {
        for s in (1..self.machine.states.len()).filter(|s| !self.reached.contains(s)) {
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
                d.help(format!("add a transition to it, `-> {}`, or remove it", self.name(s)))
            });
        }
    }

    /// Warns of states that are entered and never left, although they are not final.
    fn traps(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            let own = &self.machine.states[s];
            let ended = self.machine.path(s).any(|p| self.machine.states[p].is_final);
            // A fault transition does not count as an exit, because it is not taken in normal operation.
            let leads = |p: usize| {
                let all = self.machine.states[p].transitions.iter().enumerate();
                // A condition that leads to the current state is not taken.
                let stays =
                    |t: &TransitionProgram| self.machine.keeps(p, t) && self.machine.path(s).any(|o| o == t.target);
                let alive = |i, t: &TransitionProgram| !is_fault(&t.trigger) && !is_dead(self.places, p, i);
                all.into_iter().any(|(i, t)| alive(i, t) && !stays(t))
            };
            if s == 0 || own.initial.is_some() || ended || self.machine.path(s).any(leads) {
                continue;
            }
            let text = format!("state `{}` has no exit", self.name(s));
            let d = Diagnostic::warning("HQ0705", self.places.states[s], text);
            diagnostics
                .push(d.help("write where it goes from here, or `final state` where the machine has come to its end"));
        }
    }

    /// Warns of transitions that are never taken: an earlier one always precedes them, their condition never holds, or
    /// the machine is already in their target.
    fn never(&self, diagnostics: &mut Vec<Diagnostic>) {
        for (s, state) in self.machine.states.iter().enumerate() {
            for (i, t) in state.transitions.iter().enumerate() {
                let place = &self.places.transitions[s][i];
                if place.constant == Some(false) {
                    let d = Diagnostic::warning("HQ0706", place.trigger, "this condition never holds");
                    diagnostics.push(d.help("remove the transition, or check its comparison"));
                    continue;
                }
                if let Some(d) = self.already_there(s, i) {
                    diagnostics.push(d);
                    continue;
                }
                let before = (0..i).find(|&k| {
                    let first = &state.transitions[k];
                    // A transition that restarts the state is not taken again until its condition has been false. An
                    // `after` transition to an inner state is taken only once.
                    let once = matches!(first.trigger, Trigger::After(_)) && self.machine.keeps(s, first);
                    let covered = covers(&first.trigger, &t.trigger) && !self.machine.restarts(s, first) && !once;
                    let always = self.places.transitions[s][k].constant == Some(true) && immediate(&first.trigger);
                    let kept = self.machine.keeps(s, first) && matches!(t.trigger, Trigger::Event(_));
                    covered || (always && !kept && !is_fault(&t.trigger) && !self.machine.restarts(s, first))
                });
                if let Some(k) = before {
                    let d = Diagnostic::warning("HQ0706", place.trigger, "this transition is never taken");
                    diagnostics.push(
                        d.label(self.places.transitions[s][k].trigger, "this one always takes precedence")
                            .help("remove it, or write it first"),
                    );
                } else if place.constant == Some(true) && immediate(&t.trigger) {
                    let d = Diagnostic::warning("HQ0706", place.trigger, "this condition always holds");
                    let note = match self.machine.keeps(s, t) {
                        true => format!("the machine goes to `{}` at once, and is kept there", self.name(t.target)),
                        false => "the state is left at the tick after it is entered".to_string(),
                    };
                    diagnostics.push(d.note(note).help("check its comparison"));
                }
            }
        }
    }

    /// Warns of a transition whose target is active whenever the transition is examined.
    fn already_there(&self, s: usize, i: usize) -> Option<Diagnostic> {
        let (t, place) = (&self.machine.states[s].transitions[i], &self.places.transitions[s][i]);
        let never = || Diagnostic::warning("HQ0706", place.trigger, "this transition is never taken");
        if self.machine.restarts(s, t) && place.constant == Some(true) && immediate(&t.trigger) {
            let text = format!(
                "it re-enters `{}` when its condition becomes true, and the condition always holds",
                self.name(t.target)
            );
            return Some(never().note(text).help("write for how long it holds before that, `for 1 s`, or `after 1 s`"));
        }
        let leaves = self.reached.iter().copied().filter(|&l| self.machine.states[l].initial.is_none());
        let mut inside = leaves.filter(|&l| l == s || self.machine.is_around(s, l)).peekable();
        let there = |l: usize| self.machine.path(l).any(|o| o == t.target);
        if !self.machine.keeps(s, t) || inside.peek().is_none() || !inside.all(there) {
            return None;
        }
        let text = format!("the machine is already in `{}` whenever this is evaluated", self.name(t.target));
        let d = never().label(place.target, text).note("a condition or a time does not re-enter the current state");
        Some(d.help("remove it; an event, `on NAME`, re-enters the state"))
    }

    fn faults(&self, diagnostics: &mut Vec<Diagnostic>) {
        let answers = |s: usize| self.machine.states[s].transitions.iter().any(|t| is_fault(&t.trigger));
        if (0..self.machine.states.len()).any(answers) {
            return;
        }
        let text = format!("machine `{}` answers no fault", self.name(0));
        diagnostics.push(
            Diagnostic::warning("HQ0707", self.places.states[0], text)
                .note("at a fault the robot stops at once, and stays stopped until the controller is restarted")
                .help("write a transition: `on fault(any) -> STATE`"),
        );
    }

    /// Reports transitions that wait for the completion of a task that does not run there.
    fn waiting(&self, diagnostics: &mut Vec<Diagnostic>) {
        for &s in &self.reached {
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                let Trigger::Reached { task, .. } = t.trigger else { continue };
                let leaves = self.reached.iter().copied().filter(|&l| self.machine.states[l].initial.is_none());
                let inside: Vec<usize> = leaves.filter(|&l| self.machine.path(l).any(|p| p == s)).collect();
                let runs = |l: &usize| self.machine.stack(*l).is_some_and(|k| self.holds(k, task));
                if inside.iter().any(runs) || inside.is_empty() {
                    continue;
                }
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

    fn holds(&self, stack: usize, task: usize) -> bool {
        self.program.stacks[stack].levels.iter().flat_map(|l| &l.members).any(|m| m.task == task)
    }

    /// Warns of transitions out of final states.
    fn targets(&self, diagnostics: &mut Vec<Diagnostic>) {
        if self.program.run.subject != Subject::Machine {
            return;
        }
        for (s, state) in self.machine.states.iter().enumerate().filter(|(_, s)| s.is_final) {
            let all = state.transitions.iter().enumerate().filter(|(_, t)| !is_fault(&t.trigger));
            for (i, _) in all {
                let d = Diagnostic::warning(
                    "HQ0706",
                    self.places.transitions[s][i].trigger,
                    format!("`{}` is final, and has a transition", self.name(s)),
                );
                diagnostics.push(d.help("remove it, or remove `final`"));
            }
        }
    }
}

fn is_fault(trigger: &Trigger) -> bool {
    matches!(trigger, Trigger::Fault(_))
}

/// True for a condition without a hold time.
fn immediate(trigger: &Trigger) -> bool {
    matches!(trigger, Trigger::When { hold, .. } if *hold == 0.0)
}

/// True if `first` fires whenever `second` fires.
fn covers(first: &Trigger, second: &Trigger) -> bool {
    match (first, second) {
        (Trigger::Event(a), Trigger::Event(b)) => a == b,
        (Trigger::After(a), Trigger::After(b)) => a <= b,
        (Trigger::When { condition: a, hold: x }, Trigger::When { condition: b, hold: y }) => a == b && x <= y,
        (Trigger::Reached { task: a, tolerances: x }, Trigger::Reached { task: b, tolerances: y }) => {
            a == b && x.iter().zip(y).all(|(x, y)| x >= y)
        }
        (Trigger::Fault(a), Trigger::Fault(b)) => match (a, b) {
            (FaultPattern::Any, _) => true,
            (FaultPattern::Kind(kind), FaultPattern::Stale(_)) => *kind == runtime::FaultKind::Stale,
            (FaultPattern::Kind(kind), FaultPattern::StaleAmong(_)) => *kind == runtime::FaultKind::Stale,
            (FaultPattern::StaleAmong(all), FaultPattern::Stale(one)) => all.contains(one),
            (FaultPattern::Kind(kind), FaultPattern::Infeasible(_)) => *kind == runtime::FaultKind::Infeasible,
            (FaultPattern::Kind(kind), FaultPattern::Limit(_)) => *kind == runtime::FaultKind::Limit,
            _ => a == b,
        },
        _ => false,
    }
}
