//! All runs of a machine: every situation that it can be in, for all values of its signals at every tick.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::random_machines::{Action, Condition, Machine, When};

/// Values of the signals at a tick, and the events of the host.
#[derive(Clone, Copy, Debug)]
pub(super) struct Values {
    pub x: Option<f64>,
    pub ready: Option<bool>,
    pub go: bool,
    pub done: bool,
}

/// A situation: everything that the future depends on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Situation {
    leaf: usize,
    /// Ticks since the entry of each active state, up to 9.
    clocks: BTreeMap<usize, u32>,
    /// Ticks for which each condition has held, up to 5; `None` while it does not.
    held: BTreeMap<(usize, usize), Option<u32>>,
    /// Transitions that are blocked.
    waits: BTreeSet<(usize, usize)>,
    n: u32,
    pulse: bool,
    /// True if an action has begun that can be done.
    gripper: bool,
}

impl Machine {
    fn start(&self) -> Situation {
        let (clocks, held, waits) = (BTreeMap::new(), BTreeMap::new(), BTreeSet::new());
        let mut s = Situation { leaf: 0, clocks, held, waits, n: 0, pulse: false, gripper: false };
        s.leaf = self.leaf(0);
        for state in self.path(s.leaf).into_iter().rev() {
            self.enter(state, &mut s);
        }
        s
    }

    fn act(&self, actions: &[Action], s: &mut Situation) {
        for a in actions {
            match a {
                Action::Set(n) => s.n = *n,
                // All larger numbers are alike.
                Action::Count => s.n = (s.n + 1).min(3),
                Action::Emit => s.pulse = true,
                Action::Gripper => s.gripper = true,
            }
        }
    }

    fn enter(&self, state: usize, s: &mut Situation) {
        s.clocks.insert(state, 0);
        for (i, t) in self.states[state].transitions.iter().enumerate() {
            s.held.insert((state, i), None);
            s.waits.remove(&(state, i));
            // A condition of a state that re-enters this state must first be false.
            let again = self.path(state).contains(&t.to) && self.path(self.leaf(t.to)).contains(&state);
            if again && matches!(t.when, When::Condition(..)) {
                s.waits.insert((state, i));
            }
        }
        self.act(&self.states[state].enter, s);
    }

    /// The transition for faults leads to the last state, unless the machine is there.
    fn fault(&self, before: &Situation) -> Option<Situation> {
        let last = self.states.len() - 1;
        let mut s = Situation { pulse: false, ..before.clone() };
        s.clocks.values_mut().for_each(|c| *c = (*c + 1).min(9));
        (s.leaf != last).then(|| self.go(&mut s, 0, last))?;
        Some(s)
    }

    /// Goes from the current states to others; `state` has the transition.
    fn go(&self, s: &mut Situation, state: usize, to: usize) {
        // Innermost state that contains the transition and its target.
        let target = self.path(to);
        let stays = self.path(state).into_iter().find(|p| *p != to && target.contains(p)).unwrap_or(0);
        for left in self.path(s.leaf).into_iter().take_while(|&p| p != stays) {
            self.act(&self.states[left].exit, s);
            s.clocks.remove(&left);
            s.held.retain(|w, _| w.0 != left);
            s.waits.retain(|w| w.0 != left);
        }
        s.leaf = self.leaf(to);
        let mut entered: Vec<usize> = self.path(s.leaf).into_iter().take_while(|&p| p != stays).collect();
        entered.reverse();
        for state in entered {
            self.enter(state, s);
        }
    }

    /// One tick: the situation after it, and the transition that was taken.
    fn tick(&self, before: &Situation, v: &Values) -> (Situation, Option<(usize, usize)>) {
        let mut s = before.clone();
        s.pulse = false;
        s.clocks.values_mut().for_each(|c| *c = (*c + 1).min(9));
        let active = self.path(s.leaf);
        let mut taken = None;
        for &state in &active {
            let mut holds = Vec::new();
            for (i, t) in self.states[state].transitions.iter().enumerate() {
                holds.push(match &t.when {
                    When::Condition(c, hold) => {
                        let held = s.held.entry((state, i)).or_default();
                        *held = match (c.holds(v, before.n) == Some(true), *held) {
                            (false, _) => None,
                            (true, None) => Some(0),
                            (true, Some(ticks)) => Some((ticks + 1).min(5)),
                        };
                        held.is_some_and(|ticks| ticks >= *hold)
                    }
                    When::After(time) => s.clocks[&state] >= *time,
                    When::Event("go") => v.go,
                    When::Event("done") => v.done,
                    When::Event(_) => before.pulse,
                });
            }
            let mut kept = false;
            let mut own = None;
            for (i, t) in self.states[state].transitions.iter().enumerate() {
                let event = matches!(t.when, When::Event(_));
                let inside = t.to != state && self.path(t.to).contains(&state);
                let there = active.contains(&t.to) && inside && !event;
                let passes = there && matches!(t.when, When::After(_));
                if (s.waits.contains(&(state, i)) || passes) && !holds[i] {
                    s.waits.remove(&(state, i));
                } else if passes {
                    s.waits.insert((state, i));
                }
                // The last state is final: nothing leads out of it.
                let last = self.states.len() - 1;
                let ended = s.leaf == last && t.to != last;
                let blocked = ended || s.waits.contains(&(state, i)) || (kept && !event);
                if blocked || !holds[i] || own.is_some() {
                    continue;
                }
                match there {
                    true => kept = true,
                    false => own = Some(i),
                }
            }
            taken = taken.or(own.map(|i| (state, i)));
        }
        if let Some((state, i)) = taken {
            let t = &self.states[state].transitions[i];
            if matches!(t.when, When::After(_)) {
                s.waits.insert((state, i));
            }
            self.go(&mut s, state, t.to);
        }
        (s, taken)
    }
}

/// All that a machine can do.
pub(super) struct Brute {
    /// Innermost states that it can be in.
    pub leaves: BTreeSet<usize>,
    /// Innermost states that a transition leaves.
    pub left: BTreeSet<usize>,
    /// Sets of states between which it goes at every tick while nothing changes.
    pub flips: BTreeSet<Vec<usize>>,
    /// True if a state is active while a condition holds.
    pub violated: bool,
}

pub(super) fn brute(m: &Machine, (within, condition): &(usize, Condition)) -> Option<Brute> {
    let xs = [Some(0.0), Some(1.0), Some(2.0), None];
    let flags = [Some(true), Some(false), None];
    let text = format!("{} ({})", m.spec(""), condition.text());
    let reads = |part: &str| text.contains(part);
    let mut all = vec![];
    for x in xs.iter().take(if reads("x <") || reads("x >") || reads("present") { 4 } else { 1 }) {
        for ready in flags.iter().take(if reads("when ready") || reads("(ready") || reads("ready)") { 3 } else { 1 }) {
            for (go, done) in [(false, false), (true, false), (false, true), (true, true)] {
                if (!go || reads("on go")) && (!done || reads("on done")) {
                    all.push(Values { x: *x, ready: *ready, go, done });
                }
            }
        }
    }
    let mut seen = BTreeSet::from([m.start()]);
    let mut open = VecDeque::from([m.start()]);
    let mut out = Brute { leaves: BTreeSet::new(), left: BTreeSet::new(), flips: BTreeSet::new(), violated: false };
    let violates = |s: &Situation, v: &Values| m.path(s.leaf).contains(within) && condition.holds(v, s.n) == Some(true);
    out.violated |= all.iter().any(|v| violates(&m.start(), v));
    while let Some(s) = open.pop_front() {
        if seen.len() > 5_000 {
            return None;
        }
        out.leaves.insert(s.leaf);
        if let Some(next) = m.fault(&s) {
            out.violated |= all.iter().any(|v| violates(&next, v));
            if seen.insert(next.clone()) {
                open.push_back(next);
            }
        }
        for v in &all {
            if v.done && !s.gripper {
                continue;
            }
            let (next, taken) = m.tick(&s, v);
            out.violated |= violates(&next, v);
            if taken.is_some() {
                out.left.insert(s.leaf);
            }
            if taken.is_some() && !v.go && !v.done {
                out.flips.extend(flip(m, &next, v));
            }
            if seen.insert(next.clone()) {
                open.push_back(next);
            }
        }
    }
    Some(out)
}

/// The states between which the machine goes from a situation on, one at each tick, at values that do not change.
fn flip(m: &Machine, from: &Situation, v: &Values) -> Option<Vec<usize>> {
    let mut s = from.clone();
    let mut leaves = Vec::new();
    for _ in 0..60 {
        let (next, taken) = m.tick(&s, v);
        taken?;
        leaves.push(next.leaf);
        s = next;
    }
    let end: BTreeSet<usize> = leaves[30..].iter().copied().collect();
    Some(end.into_iter().collect())
}
