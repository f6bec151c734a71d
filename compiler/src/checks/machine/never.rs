//! Transitions that are never taken: their condition never holds, transitions before them always take precedence, or the
//! machine is in their target already. What conditions imply follows from [`crate::analysis::conditions`]: `d < 0.1 m`
//! after `d < 0.2 m` in one state is never taken.

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{FaultPattern, MachineProgram, TransitionProgram, Trigger};

use super::{Checked, is_fault};
use crate::analysis::conditions::{Claim, Conditions, Formula, Truth};
use crate::source_map::MachinePlaces;

/// For each transition of each state, the value of its condition if it never changes.
pub(super) fn constants(
    conditions: &Conditions,
    machine: &MachineProgram,
    places: &MachinePlaces,
) -> Vec<Vec<Option<bool>>> {
    let of = |s: usize, i: usize, t: &TransitionProgram| {
        let place = &places.transitions[s][i];
        if place.constant.is_some() || !matches!(t.trigger, Trigger::When { .. }) {
            return place.constant;
        }
        let formula = conditions.triggers[s][i].as_ref()?;
        let is_never = |claim| conditions.search(&[claim]).is_impossible();
        if is_never(Claim::Holds(formula)) { Some(false) } else { is_never(Claim::Fails(formula)).then_some(true) }
    };
    let all = machine.states.iter().enumerate();
    all.map(|(s, state)| state.transitions.iter().enumerate().map(|(i, t)| of(s, i, t)).collect()).collect()
}

impl Checked<'_> {
    /// Warns of transitions that are never taken: earlier ones always precede them, their condition never holds, or
    /// the machine is already in their target.
    pub(super) fn never(&self, diagnostics: &mut Vec<Diagnostic>) {
        for (s, state) in self.machine.states.iter().enumerate() {
            for (i, t) in state.transitions.iter().enumerate() {
                let (place, constant) = (&self.places.transitions[s][i], self.constants[s][i]);
                if constant == Some(false) {
                    let d = Diagnostic::warning("HQ0706", place.trigger, "this condition never holds");
                    let d = match place.constant {
                        Some(_) => d,
                        None => d.note("its parts exclude each other, or no value of a quantity meets it"),
                    };
                    diagnostics.push(d.help("remove the transition, or check its comparison"));
                    continue;
                }
                if let Some(d) = self.already_there(s, i) {
                    diagnostics.push(d);
                    continue;
                }
                if let Some(d) = self.preceded(s, i).or_else(|| self.outlasted(s, i)) {
                    diagnostics.push(d);
                } else if constant == Some(true) && immediate(&t.trigger) {
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

    /// Warning of a transition that earlier ones of its state always precede.
    pub(super) fn preceded(&self, s: usize, i: usize) -> Option<Diagnostic> {
        let before = self.precedents(s, i);
        let (&first, others) = before.split_first()?;
        let place = |k: usize| self.places.transitions[s][k].trigger;
        let mut d = Diagnostic::warning("HQ0706", place(i), "this transition is never taken");
        d = match others {
            [] => d.label(place(first), "this one always takes precedence"),
            _ => before.iter().fold(d, |d, &k| d.label(place(k), "one of these always takes precedence")),
        };
        Some(d.help("remove it, or write it first"))
    }

    /// Warning of a condition that must hold for longer than its state lasts.
    pub(super) fn outlasted(&self, s: usize, i: usize) -> Option<Diagnostic> {
        let transitions = &self.machine.states[s].transitions;
        let needed = hold(&transitions[i].trigger);
        let ends = transitions.iter().enumerate().find_map(|(k, t)| match t.trigger {
            Trigger::After(time) if time < needed && !self.machine.keeps(s, t) && !self.is_dead(s, k) => {
                Some((k, time))
            }
            _ => None,
        });
        let (k, time) = ends?;
        let (needed, time) = (runtime::text::number(needed), runtime::text::number(time));
        let place = |k: usize| self.places.transitions[s][k].trigger;
        Some(
            Diagnostic::warning("HQ0706", place(i), "this transition is never taken")
                .here(format!("its condition must hold for {needed} s"))
                .label(place(k), format!("`{}` is left after {time} s", self.name(s)))
                .help("write a shorter time in the condition, or let the state last longer"),
        )
    }

    /// Earlier transitions of the state, one of which is always taken before transition `i` could be; none if it can be
    /// taken.
    fn precedents(&self, s: usize, i: usize) -> Vec<usize> {
        let transitions = &self.machine.states[s].transitions;
        let t = &transitions[i];
        let eligible = |k: &usize| {
            let first = &transitions[*k];
            // A transition that restarts the state is not taken again until its condition has been false. An `after`
            // transition to an inner state is taken only once. One that keeps the machine in its target does not block
            // events.
            let once = matches!(first.trigger, Trigger::After(_)) && self.machine.keeps(s, first);
            let kept = self.machine.keeps(s, first) && matches!(t.trigger, Trigger::Event(_));
            !self.machine.restarts(s, first) && !once && !kept && !self.is_dead(s, *k)
        };
        let earlier: Vec<usize> = (0..i).filter(eligible).collect();
        if let Some(&k) = earlier.iter().find(|&&k| covers(&transitions[k].trigger, &t.trigger)) {
            return vec![k];
        }
        if is_fault(&t.trigger) {
            return Vec::new();
        }
        let yes = Formula::Constant(Truth::Yes);
        let own = match &t.trigger {
            Trigger::When { .. } | Trigger::After(_) => self.conditions.triggers[s][i].as_ref(),
            _ => Some(&yes),
        };
        let Some(own) = own else { return Vec::new() };
        let formula = |k: usize| self.conditions.triggers[s][k].as_ref();
        // Conditions that imply each other and lead to the same state are redundant, and change nothing.
        let same = |k: &usize| transitions[*k].target == t.target && transitions[*k].blend == t.blend;
        let never = |before: &[usize]| {
            let none = before.iter().filter_map(|&k| Some(Claim::Fails(formula(k)?)));
            let lasting = &self.conditions.lasting[s][i];
            let all: Vec<_> = [Claim::Holds(own), Claim::Holds(lasting)].into_iter().chain(none).collect();
            self.conditions.search(&all).is_impossible()
        };
        let timely = |k: &usize| formula(*k).is_some() && hold(&transitions[*k].trigger) <= hold(&t.trigger);
        if let Some(&k) = earlier.iter().filter(|k| timely(k)).find(|&&k| never(&[k])) {
            return [k].into_iter().filter(|k| !same(k)).collect();
        }
        let mut all: Vec<usize> =
            earlier.into_iter().filter(|&k| formula(k).is_some() && hold(&transitions[k].trigger) == 0.0).collect();
        if all.is_empty() || !never(&all) {
            return Vec::new();
        }
        for k in all.clone() {
            let without: Vec<usize> = all.iter().copied().filter(|&o| o != k).collect();
            if never(&without) {
                all = without;
            }
        }
        if all.iter().all(same) { Vec::new() } else { all }
    }

    /// Warns of a transition whose target is active whenever the transition is examined.
    fn already_there(&self, s: usize, i: usize) -> Option<Diagnostic> {
        let (t, place) = (&self.machine.states[s].transitions[i], &self.places.transitions[s][i]);
        let never = || Diagnostic::warning("HQ0706", place.trigger, "this transition is never taken");
        if self.machine.restarts(s, t) && self.constants[s][i] == Some(true) && immediate(&t.trigger) {
            let text = format!(
                "it re-enters `{}` when its condition becomes true, and the condition always holds",
                self.name(t.target)
            );
            return Some(never().note(text).help(Help::with(
                "write for how long it must hold before that, {}, or {}",
                [Snippet::entry("for", "1 s"), Snippet::entry("after", "1 s")],
            )));
        }
        let mut inside = self.leaves(s).peekable();
        let there = |l: usize| self.machine.path(l).any(|o| o == t.target);
        if !self.machine.keeps(s, t) || inside.peek().is_none() || !inside.all(there) {
            return None;
        }
        let text = format!("the machine is already in `{}` whenever this is evaluated", self.name(t.target));
        let d = never().label(place.target, text).note("a condition or a time does not re-enter the current state");
        Some(d.help(Help::with("remove it; an event, {}, re-enters the state", [Snippet::entry("on", "EVENT")])))
    }
}

/// True for a condition without a hold time.
fn immediate(trigger: &Trigger) -> bool {
    matches!(trigger, Trigger::When { hold, .. } if *hold == 0.0)
}

/// Time for which a condition must have held (s).
fn hold(trigger: &Trigger) -> f64 {
    match trigger {
        Trigger::When { hold, .. } => *hold,
        _ => 0.0,
    }
}

/// True if `first` fires whenever `second` fires.
fn covers(first: &Trigger, second: &Trigger) -> bool {
    match (first, second) {
        (Trigger::Event(a), Trigger::Event(b)) => a == b,
        (Trigger::After(a), Trigger::After(b)) => a <= b,
        (Trigger::When { condition: a, hold: x }, Trigger::When { condition: b, hold: y }) => a == b && x <= y,
        (Trigger::Reached(a), Trigger::Reached(b)) => a.follows_from(b),
        (Trigger::Ended(a), Trigger::Ended(b)) => !a.is_empty() && a.iter().all(|r| b.contains(r)),
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
