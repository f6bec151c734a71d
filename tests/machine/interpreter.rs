//! Random machines against an independent interpreter that uses names only.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::host::Host;

/// Trigger of a transition: an event, a number of ticks, or the variable `n` above a number.
#[derive(Clone, Copy, Debug)]
enum Trigger {
    Event(usize),
    After(usize),
    Above(u8),
}

/// Action of a state on the variables `n`, a number, and `w`, an optional one.
#[derive(Clone, Copy, Debug)]
enum Change {
    Nothing,
    Increment,
    Copy,
    Add,
    Double,
    Clear,
}

const CHANGES: [(Change, &str); 6] = [
    (Change::Nothing, ""),
    (Change::Increment, "set(n, n + 1)"),
    (Change::Copy, "set(w, n)"),
    (Change::Add, "set(n, min(n + if(present(w), w, 0), 20))"),
    (Change::Double, "set(w, 2*w - 1)"),
    (Change::Clear, "clear(w)"),
];

/// State of the variables in the interpreter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Held {
    n: f64,
    w: Option<f64>,
}

impl Held {
    fn change(&mut self, change: usize) {
        match CHANGES[change].0 {
            Change::Nothing => {}
            Change::Increment => self.n += 1.0,
            Change::Copy => self.w = Some(self.n),
            Change::Add => self.n = (self.n + self.w.unwrap_or(0.0)).min(20.0),
            Change::Double => self.w = self.w.map(|w| 2.0 * w - 1.0),
            Change::Clear => self.w = None,
        }
    }
}

#[derive(Clone, Debug)]
struct State {
    /// `s0.s2`
    path: String,
    transitions: Vec<(Trigger, usize)>,
    /// Actions on entry and on exit, as indices into [`CHANGES`].
    changes: [usize; 2],
    is_final: bool,
}

/// A machine: states with their paths, in the order of the text; the first child of each is its initial state.
#[derive(Clone, Debug)]
struct Random {
    states: Vec<State>,
    root: Vec<(Trigger, usize)>,
}

const EVENTS: usize = 3;

fn shape() -> impl Strategy<Value = Vec<usize>> {
    // For each state a choice of its parent among the earlier states, or none.
    prop::collection::vec(0..5_usize, 2..8)
}

fn trigger() -> impl Strategy<Value = Trigger> {
    prop_oneof![
        3 => (0..EVENTS).prop_map(Trigger::Event),
        1 => (1..6_usize).prop_map(Trigger::After),
        1 => (1..12_u8).prop_map(Trigger::Above),
    ]
}

fn random() -> impl Strategy<Value = Random> {
    shape().prop_flat_map(|shape| {
        let n = shape.len();
        let ways = || prop::collection::vec((trigger(), 0..n), 0..3);
        let changes = prop::collection::vec(prop::array::uniform2(0..CHANGES.len()), n);
        let finals = prop::collection::vec(prop::bool::weighted(0.2), n);
        let all = (Just(shape), prop::collection::vec(ways(), n), ways(), changes, finals);
        all.prop_map(|(shape, ways, root, changes, finals)| {
            let mut paths: Vec<String> = Vec::new();
            for (i, pick) in shape.iter().enumerate() {
                let parent = if *pick == 0 || i == 0 { None } else { Some(&paths[(pick - 1) % i]) };
                let deep = parent.is_some_and(|p| p.matches('.').count() >= 2);
                let path = match parent.filter(|_| !deep) {
                    Some(p) => format!("{p}.s{i}"),
                    None => format!("s{i}"),
                };
                paths.push(path);
            }
            let all = paths.into_iter().zip(ways).zip(changes).zip(finals);
            let states =
                all.map(|(((path, transitions), changes), is_final)| State { path, transitions, changes, is_final });
            let states = states.collect();
            Random { states, root }
        })
    })
}

impl Random {
    fn children<'r>(&'r self, parent: &'r str) -> impl Iterator<Item = &'r State> {
        self.states.iter().filter(move |s| s.path.rsplit_once('.').map_or("", |p| p.0) == parent)
    }

    fn written(&self, ways: &[(Trigger, usize)], out: &mut String) {
        for (trigger, target) in ways {
            let target = &self.states[*target].path;
            match trigger {
                Trigger::Event(k) => out.push_str(&format!("on e{k} -> {target}\n")),
                Trigger::Above(x) => out.push_str(&format!("when n > {x} -> {target}\n")),
                Trigger::After(n) => out.push_str(&format!("after {} ms -> {target}\n", 10 * n)),
            }
        }
    }

    fn state(&self, s: &State, out: &mut String) {
        let name = s.path.rsplit('.').next().unwrap_or(&s.path);
        let word = if s.is_final { "final state" } else { "state" };
        out.push_str(&format!("{word} {name} {{ enter log \"in {0}\"  exit log \"out {0}\"\n", s.path));
        for (word, change) in ["enter", "exit"].iter().zip(s.changes) {
            if change > 0 {
                out.push_str(&format!("{word} {}\n", CHANGES[change].1));
            }
        }
        if let Some(first) = self.children(&s.path).next() {
            out.push_str(&format!("initial {}\n", first.path.rsplit('.').next().unwrap_or("")));
        }
        self.written(&s.transitions, out);
        self.children(&s.path).for_each(|c| self.state(c, out));
        out.push_str("}\n");
    }

    fn text(&self) -> String {
        let mut out: String = (0..EVENTS).map(|k| format!("signal e{k} : event\n")).collect();
        out.push_str("variable n : number = 0\nvariable w : number?\n");
        out.push_str("machine m { stack still\n");
        out.push_str(&format!("initial {}\n", self.children("").next().map_or("", |s| &s.path)));
        self.written(&self.root, &mut out);
        self.children("").for_each(|s| self.state(s, &mut out));
        out.push_str("}\n");
        out
    }
}

/// The interpreter: a path, and the tick of the entry of each of its parts.
struct Naive<'r> {
    machine: &'r Random,
    /// `["s0", "s0.s2"]`
    path: Vec<String>,
    entered: Vec<usize>,
    /// States with the index of a transition to themselves whose condition has been false since the entry.
    been_false: BTreeSet<(String, usize)>,
    /// States with the index of a time-triggered transition that has been taken.
    taken: BTreeSet<(String, usize)>,
    log: Vec<String>,
    held: Held,
}

fn prefixes(path: &str) -> Vec<String> {
    let parts: Vec<&str> = path.split('.').collect();
    (1..=parts.len()).map(|n| parts[..n].join(".")).collect()
}

impl<'r> Naive<'r> {
    fn change(&mut self, path: &str, which: usize) {
        let state = self.machine.states.iter().find(|s| s.path == path).expect("a state");
        self.held.change(state.changes[which]);
    }

    fn enter(&mut self, target: &str, tick: usize) {
        for p in prefixes(target).into_iter().skip(self.path.len()) {
            self.change(&p, 0);
            self.log.push(format!("+log in {p}"));
            self.been_false.retain(|(state, _)| *state != p);
            self.taken.retain(|(state, _)| *state != p);
            self.path.push(p);
            self.entered.push(tick);
        }
        if let Some(first) = self.machine.children(target).next() {
            self.enter(&first.path, tick);
        }
    }

    fn ways(&self, state: &str) -> &'r [(Trigger, usize)] {
        let machine: &'r Random = self.machine;
        machine.states.iter().find(|s| s.path == state).map_or(&machine.root, |s| &s.transitions)
    }

    /// Returns true if the machine is in this state.
    fn within(&self, state: &str) -> bool {
        self.path.iter().any(|p| p == state)
    }

    /// Returns true if a target is inside a state.
    fn leads_in(&self, state: &str, target: usize) -> bool {
        state.is_empty() || self.machine.states[target].path.starts_with(&format!("{state}."))
    }

    /// Returns the tick at which the state at a depth of the path was entered.
    fn since(&self, depth: usize) -> usize {
        depth.checked_sub(1).map_or(0, |i| self.entered[i])
    }

    /// Returns true if the machine has ended at a path: a state along it is final.
    fn ends(&self, path: &str) -> bool {
        self.machine.states.iter().any(|s| s.is_final && prefixes(path).contains(&s.path))
    }

    fn first_leaf(&self, path: &str) -> String {
        self.machine.children(path).next().map_or(path.to_string(), |first| self.first_leaf(&first.path))
    }

    /// Executes a tick. The first `depth` parts of the path lead to the transition's state; 0 for the machine.
    fn step(&mut self, events: &[bool], tick: usize) {
        self.log.clear();
        for depth in 0..=self.path.len() {
            let state = depth.checked_sub(1).map_or(String::new(), |i| self.path[i].clone());
            for (place, (trigger, target)) in self.ways(&state).iter().enumerate() {
                let here = self.within(&self.machine.states[*target].path);
                let passed = match trigger {
                    Trigger::Above(x) if self.held.n <= f64::from(*x) => &mut self.been_false,
                    // The machine is in the target already: the transition is used up.
                    Trigger::After(n) if here && self.leads_in(&state, *target) && tick - self.since(depth) >= *n => {
                        &mut self.taken
                    }
                    _ => continue,
                };
                passed.insert((state.clone(), place));
            }
        }
        for depth in (0..=self.path.len()).rev() {
            let own = depth.checked_sub(1);
            let since = self.since(depth);
            let state = own.map_or(String::new(), |i| self.path[i].clone());
            let ways = self.ways(&state);
            let (mut taken, mut kept) = (None, false);
            for (place, way) in ways.iter().enumerate() {
                let target = &self.machine.states[way.1].path;
                let (here, inside) = (self.within(target), self.leads_in(&state, way.1));
                // Nothing leads out of an end, except to another one.
                if self.path.last().is_some_and(|p| self.ends(p)) && !self.ends(&self.first_leaf(target)) {
                    continue;
                }
                let (holds, event) = match &way.0 {
                    Trigger::Event(k) => (events[*k], true),
                    Trigger::After(n) => (tick - since >= *n, false),
                    Trigger::Above(x) => (self.held.n > f64::from(*x), false),
                };
                // A condition that enters its own state again must have been false before.
                let back = here && !inside && prefixes(&self.first_leaf(target)).contains(&state);
                let waits = !self.been_false.contains(&(state.clone(), place));
                if back && waits && matches!(way.0, Trigger::Above(_)) {
                    continue;
                }
                let spent = self.taken.contains(&(state.clone(), place));
                if !holds || spent || taken.is_some() || (kept && !event) {
                    continue;
                }
                if here && inside && !event {
                    kept = true;
                } else {
                    taken = Some((place, way));
                }
            }
            let Some((place, (trigger, target))) = taken else { continue };
            if matches!(trigger, Trigger::After(_)) {
                self.taken.insert((state.clone(), place));
            }
            let target = self.machine.states[*target].path.clone();
            // Parts of the path that are not left: those down to the transition's state that are proper ancestors of
            // the target.
            let above = prefixes(&target);
            let stays = (0..depth).take_while(|&i| i + 1 < above.len() && self.path[i] == above[i]).count();
            while self.path.len() > stays {
                let Some(p) = self.path.pop() else { break };
                self.change(&p, 1);
                self.log.push(format!("+log out {p}"));
                self.entered.pop();
            }
            self.enter(&target, tick);
            return;
        }
    }
}

fn held(host: &mut Host) -> Held {
    let signals = host.controller.signals();
    let of =
        |name: &str| signals.interface().signal(name).filter(|s| signals.is_present(*s)).map(|s| signals.value(s)[0]);
    Held { n: of("n").expect("it is never absent"), w: of("w") }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn it_does_what_the_interpreter_does(
        machine in random(),
        events in prop::collection::vec(prop::collection::vec(prop::bool::weighted(0.25), EVENTS), 1..40),
    ) {
        let mut host = Host::new(&machine.text());
        let mut naive = Naive { machine: &machine, path: vec![], entered: vec![], been_false: BTreeSet::new(), taken: BTreeSet::new(), log: vec![], held: Held::default() };
        let first = machine.children("").next().expect("a state").path.clone();
        naive.enter(&first, 0);
        let seen = host.step();
        prop_assert_eq!(&seen.asked, &naive.log);
        prop_assert_eq!(held(&mut host), naive.held);
        for (i, events) in events.iter().enumerate() {
            (0..EVENTS).filter(|k| events[*k]).for_each(|k| host.raise(&format!("e{k}")));
            let seen = host.step();
            naive.step(events, i + 1);
            prop_assert_eq!(&seen.asked, &naive.log, "tick {} of\n{}", i + 1, machine.text());
            prop_assert_eq!(Some(&seen.state), naive.path.last());
            prop_assert_eq!(host.controller.is_final(), naive.ends(&seen.state));
            prop_assert_eq!(held(&mut host), naive.held, "tick {} of\n{}", i + 1, machine.text());
        }
    }
}
