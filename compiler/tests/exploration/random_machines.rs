//! Random machines: up to four states beside each other, of which one may have states inside, with conditions on a
//! number, a flag and a variable, times, and events of the host, of an action and of the machine itself.

use super::all_runs::Values;

/// Small deterministic generator of random numbers.
pub(super) struct Random(pub u64);

impl Random {
    pub(super) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }

    pub(super) fn of<T: Clone>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())].clone()
    }
}

/// A comparison of a number with a threshold, a flag, or a combination.
#[derive(Clone, Debug)]
pub(super) enum Condition {
    Less(&'static str, f64),
    More(&'static str, f64),
    Ready,
    Present,
    Not(Box<Condition>),
    And(Box<[Condition; 2]>),
    Or(Box<[Condition; 2]>),
}

#[derive(Clone, Debug)]
pub(super) enum When {
    Condition(Condition, u32),
    After(u32),
    Event(&'static str),
}

#[derive(Clone, Debug)]
pub(super) struct Transition {
    pub when: When,
    pub to: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Action {
    Set(u32),
    Count,
    Emit,
    Gripper,
}

#[derive(Clone, Debug, Default)]
pub(super) struct State {
    pub parent: Option<usize>,
    pub initial: Option<usize>,
    pub enter: Vec<Action>,
    pub exit: Vec<Action>,
    pub transitions: Vec<Transition>,
}

/// A machine; state 0 is the machine itself, the last one is final.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    pub states: Vec<State>,
}

impl Condition {
    pub(super) fn random(r: &mut Random, depth: usize) -> Condition {
        let both = |r: &mut Random| Box::new([Condition::random(r, depth - 1), Condition::random(r, depth - 1)]);
        match r.below(if depth == 0 { 5 } else { 9 }) {
            0 | 1 => Condition::Less(r.of(&["x", "x", "n"]), r.of(&[0.5, 1.5])),
            2 => Condition::More(r.of(&["x", "x", "n"]), r.of(&[0.5, 1.5])),
            3 => Condition::Ready,
            4 => Condition::Present,
            5 => Condition::Not(Box::new(Condition::random(r, depth - 1))),
            6 | 7 => Condition::And(both(r)),
            _ => Condition::Or(both(r)),
        }
    }

    pub(super) fn text(&self) -> String {
        match self {
            Condition::Less(name, than) => format!("{name} < {than}"),
            Condition::More(name, than) => format!("{name} >= {than}"),
            Condition::Ready => "ready".to_string(),
            Condition::Present => "present(x)".to_string(),
            Condition::Not(a) => format!("not ({})", a.text()),
            Condition::And(both) => format!("({} and {})", both[0].text(), both[1].text()),
            Condition::Or(both) => format!("({} or {})", both[0].text(), both[1].text()),
        }
    }

    /// Truth value; `None` if a value is absent.
    pub(super) fn holds(&self, v: &Values, n: u32) -> Option<bool> {
        let number = |name: &str| if name == "n" { Some(f64::from(n)) } else { v.x };
        match self {
            Condition::Less(name, than) => number(name).map(|x| x < *than),
            Condition::More(name, than) => number(name).map(|x| x >= *than),
            Condition::Ready => v.ready,
            Condition::Present => Some(v.x.is_some()),
            Condition::Not(a) => a.holds(v, n).map(|h| !h),
            Condition::And(both) => {
                if both[0].holds(v, n)? {
                    both[1].holds(v, n)
                } else {
                    Some(false)
                }
            }
            Condition::Or(both) => {
                if both[0].holds(v, n)? {
                    Some(true)
                } else {
                    both[1].holds(v, n)
                }
            }
        }
    }
}

impl Machine {
    pub(super) fn random(r: &mut Random) -> Machine {
        let mut states = vec![State { initial: Some(1), ..State::default() }];
        let tops = 2 + r.below(3);
        for _ in 0..tops {
            states.push(State { parent: Some(0), ..State::default() });
        }
        // One of them may have states inside.
        if r.below(2) == 0 {
            let outer = 1 + r.below(tops);
            for _ in 0..2 {
                states.push(State { parent: Some(outer), ..State::default() });
            }
            states[outer].initial = Some(states.len() - 2);
        }
        states.push(State { parent: Some(0), ..State::default() });
        let last = states.len() - 1;
        states[1].enter.push(Action::Gripper);
        for (s, state) in states.iter_mut().enumerate().take(last) {
            for _ in 0..if s == 0 { r.below(2) } else { 1 + r.below(2) } {
                let when = match r.below(8) {
                    0..=3 => When::Condition(Condition::random(r, 2), 0),
                    4 => When::Condition(Condition::random(r, 1), 4),
                    5 if s > 0 => When::After(r.of(&[0, 2, 2, 8])),
                    6 => When::Event(r.of(&["go", "done"])),
                    _ => When::Event("pulse"),
                };
                state.transitions.push(Transition { when, to: 1 + r.below(last) });
            }
            if s > 0 {
                match r.below(8) {
                    0 => state.enter.push(Action::Set(r.of(&[0, 1, 2]))),
                    1 => state.exit.push(Action::Set(r.of(&[0, 1, 2]))),
                    2 => state.enter.push(Action::Emit),
                    3 => state.exit.push(Action::Emit),
                    4 => state.enter.push(Action::Count),
                    _ => {}
                }
            }
        }
        // The event that the machine raises must be one that it can raise.
        if !states.iter().any(|s| s.enter.iter().chain(&s.exit).any(|a| *a == Action::Emit)) {
            states[last].enter.push(Action::Emit);
        }
        Machine { states }
    }

    pub(super) fn counts(&self) -> bool {
        self.states.iter().any(|s| s.enter.iter().chain(&s.exit).any(|a| *a == Action::Count))
    }

    /// Name of a state by its path.
    pub(super) fn name(&self, s: usize) -> String {
        match self.states[s].parent {
            Some(p) if p > 0 => format!("{}.s{s}", self.name(p)),
            _ => format!("s{s}"),
        }
    }

    /// The spec, with parts of the machine added.
    pub(super) fn spec(&self, more: &str) -> String {
        let mut out = String::from(
            "hierarq 1\nrobot arm { urdf \"robots/arm7.urdf\"  rate 1 Hz }\nsignal x : number\nsignal ready : flag\n\
             signal go : event\nvariable n : number = 0\nstack still { level all { joint_velocity_limits } }\n",
        );
        let last = self.states.len() - 1;
        out.push_str(&format!("machine m {{ initial s1  stack still  on fault(any) -> s{last}{more}\n"));
        self.body(0, &mut out);
        out.push_str("}\n");
        out
    }

    fn body(&self, s: usize, out: &mut String) {
        let of = &self.states[s];
        let action = |a: &Action| match a {
            Action::Set(n) => format!("set(n, {n})"),
            Action::Count => "set(n, n + 1)".to_string(),
            Action::Emit => "emit pulse".to_string(),
            Action::Gripper => "gripper close".to_string(),
        };
        of.enter.iter().for_each(|a| out.push_str(&format!("  enter {}", action(a))));
        of.exit.iter().for_each(|a| out.push_str(&format!("  exit {}", action(a))));
        for t in &of.transitions {
            let to = self.name(t.to);
            out.push_str(&match &t.when {
                When::Condition(c, 0) => format!("  when {} -> {to}", c.text()),
                When::Condition(c, hold) => format!("  when {} for {hold} s -> {to}", c.text()),
                When::After(time) => format!("  after {time} s -> {to}"),
                When::Event(e) => format!("  on {e} -> {to}"),
            });
        }
        for k in (1..self.states.len()).filter(|&k| self.states[k].parent == Some(s)) {
            let is_final = if k == self.states.len() - 1 { "final " } else { "" };
            out.push_str(&format!("\n  {is_final}state s{k} {{"));
            if let Some(initial) = self.states[k].initial {
                out.push_str(&format!(" initial s{initial}"));
            }
            self.body(k, out);
            out.push_str(" }");
        }
        out.push('\n');
    }

    /// The state and those around it, from the inside out.
    pub(super) fn path(&self, s: usize) -> Vec<usize> {
        std::iter::successors(Some(s), |&s| self.states[s].parent).collect()
    }

    pub(super) fn leaf(&self, s: usize) -> usize {
        self.states[s].initial.map_or(s, |i| self.leaf(i))
    }
}
