//! Draws the machine of a program: for Mermaid and Graphviz, which do their own layout, and as an SVG with ours.

mod dot;
mod layout;
mod mermaid;
mod svg;

use std::collections::VecDeque;

use runtime::Program;
use runtime::program::{ActionProgram, MachineProgram, Trigger};

/// Format of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Mermaid `stateDiagram-v2`, which many Markdown viewers draw.
    Mermaid,
    /// Directed graph for Graphviz.
    Dot,
    /// SVG picture.
    Svg,
}

/// Draws the machine of a program. Returns `None` if it has none, or if the program is invalid.
pub fn draw(program: &Program, format: Format) -> Option<String> {
    program.check().ok()?;
    let chart = Chart::of(program, program.machine.as_ref()?);
    Some(match format {
        Format::Mermaid => mermaid::draw(&chart),
        Format::Dot => dot::draw(&chart),
        Format::Svg => svg::draw(&chart),
    })
}

/// A transition between two states.
#[derive(Clone, Copy, Debug)]
struct Edge<'p> {
    from: usize,
    to: usize,
    text: &'p str,
    fault: bool,
}

/// A machine with its tree of states.
struct Chart<'p> {
    program: &'p Program,
    machine: &'p MachineProgram,
    /// For each state its direct inner states, in the order in which they can be reached.
    children: Vec<Vec<usize>>,
    /// All transitions, in the order of their states.
    edges: Vec<Edge<'p>>,
}

/// A step of the traversal of the state tree: parents are entered before their children, and left after them.
enum Step {
    Enter(usize),
    Leave(usize),
}

impl<'p> Chart<'p> {
    fn of(program: &'p Program, machine: &'p MachineProgram) -> Self {
        let ways = machine.states.iter().enumerate().flat_map(|(from, s)| {
            s.transitions.iter().map(move |t| Edge {
                from,
                to: t.target,
                text: &t.text,
                fault: matches!(t.trigger, Trigger::Fault(_)),
            })
        });
        let edges: Vec<Edge> = ways.collect();
        let mut children = vec![Vec::new(); machine.states.len()];
        for (i, s) in machine.states.iter().enumerate() {
            if let Some(parent) = s.parent {
                children[parent].push(i);
            }
        }
        let mut chart = Chart { program, machine, children, edges };
        chart.order();
        chart
    }

    /// Orders the inner states of each state: first the initial one, then its successors, breadth first; those that
    /// only faults reach come last.
    fn order(&mut self) {
        let mut next = vec![Vec::new(); self.children.len()];
        for e in self.edges.iter().filter(|e| !e.fault) {
            // Sibling states that contain the two ends.
            let outer: Vec<usize> = self.machine.path(e.from).collect();
            let inner = self.machine.path(e.to).skip(1).zip(self.machine.path(e.to));
            let Some((common, to)) = inner.into_iter().find(|(parent, _)| outer.contains(parent)) else { continue };
            let at = outer.iter().position(|s| *s == common).unwrap_or(0);
            if let Some(from) = at.checked_sub(1).and_then(|i| outer.get(i)) {
                next[*from].push(to);
            }
        }
        let mut seen = vec![false; self.children.len()];
        for i in 0..self.children.len() {
            let mut open: VecDeque<usize> = self.machine.states[i].initial.into_iter().collect();
            let mut ordered = Vec::new();
            while let Some(s) = open.pop_front() {
                if !std::mem::replace(&mut seen[s], true) {
                    ordered.push(s);
                    open.extend(&next[s]);
                }
            }
            ordered.extend(self.children[i].iter().filter(|s| !seen[**s]));
            let regions = &self.machine.states[i].regions;
            self.children[i] = if regions.is_empty() { ordered } else { regions.clone() };
        }
    }

    /// Traversal of the state tree.
    fn steps(&self) -> Vec<Step> {
        let mut out = Vec::new();
        let mut open = vec![Step::Enter(0)];
        while let Some(step) = open.pop() {
            if let Step::Enter(s) = step {
                open.push(Step::Leave(s));
                open.extend(self.children[s].iter().rev().map(|c| Step::Enter(*c)));
            }
            out.push(step);
        }
        out
    }

    /// Last part of a state's name.
    fn short(&self, state: usize) -> &'p str {
        let name = &self.machine.states[state].name;
        name.rsplit('.').next().unwrap_or(name)
    }

    /// True if `state` is `outer`, or inside it.
    fn inside(&self, state: usize, outer: usize) -> bool {
        self.machine.path(state).any(|s| s == outer)
    }

    /// True for a region, which is active beside others.
    fn is_region(&self, state: usize) -> bool {
        self.machine.region(state) == Some(state)
    }

    /// True for the first region of a state.
    fn is_first_region(&self, state: usize) -> bool {
        self.machine.states.iter().any(|s| s.regions.first() == Some(&state))
    }

    /// The state inside a state that is entered with it; none of regions, which all are.
    fn initial(&self, state: usize) -> Option<usize> {
        self.machine.states[state].initial.filter(|_| self.machine.states[state].regions.is_empty())
    }

    fn holds_others(&self, state: usize) -> bool {
        !self.children[state].is_empty()
    }

    /// Stack and actions of a state, line by line.
    fn about(&self, state: usize) -> Vec<String> {
        let s = &self.machine.states[state];
        let stack = s.stack.and_then(|k| self.program.stacks.get(k)).map(|k| format!("stack {}", k.name));
        let moments = [("enter", &s.enter), ("do", &s.activities), ("exit", &s.exit)];
        let actions = moments.into_iter().flat_map(|(moment, all)| {
            let known = all.iter().filter_map(|&a| self.machine.actions.get(a));
            known.map(move |a| format!("{moment} {}", asked(a)))
        });
        stack.into_iter().chain(actions).collect()
    }
}

/// Formats an action: `gripper close right`.
fn asked(a: &ActionProgram) -> String {
    let plain = |w: &str| w.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '.' | '-'));
    let words = a.arguments.iter().map(|w| if plain(w) { w.clone() } else { format!("{w:?}") });
    std::iter::once(a.verb.clone()).chain(words).collect::<Vec<String>>().join(" ")
}
