//! Expectations that no run satisfies together.

use dsl::Diagnostic;
use runtime::expect::{Formula as Timed, Node, Unit, Window};
use runtime::program::{Measure, Op};

use super::Scene;
use crate::analysis::conditions::{Claim, Conditions, Formula, Key, PredicateNode};

/// A condition at all ticks of a window, or at one of them.
struct Demand {
    /// Index of the expectation.
    of: usize,
    always: bool,
    window: Window,
    formula: Formula,
}

impl Demand {
    /// True if the windows have ticks in common at which both conditions must hold.
    fn meets(&self, other: &Demand, ticks: u32) -> bool {
        let last = |w: &Window| w.last.unwrap_or(ticks).min(ticks);
        let contains = |outer: &Window, inner: &Window| outer.first <= inner.first && last(inner) <= last(outer);
        match (self.always, other.always) {
            (true, true) => self.window.first.max(other.window.first) <= last(&self.window).min(last(&other.window)),
            (true, false) => contains(&self.window, &other.window),
            (false, true) => contains(&other.window, &self.window),
            (false, false) => false,
        }
    }
}

impl Scene<'_> {
    /// Warns of pairs of expectations whose conditions contradict each other.
    pub(super) fn exclusive(&self, out: &mut Vec<Diagnostic>) {
        let nodes = self.played.places.nodes.iter().zip(&self.scenario.predicates);
        let nodes: Vec<PredicateNode> =
            nodes.map(|(&node, p)| PredicateNode { node, is_truth: p.unit == Unit::Truth }).collect();
        let conditions = Conditions::of_predicates(self.graph, &self.program.interface, &nodes);
        let mut demands = Vec::new();
        for (of, expectation) in self.scenario.expectations.iter().enumerate() {
            let timed = &expectation.formula;
            collect(of, timed, timed.nodes.len().saturating_sub(1), &conditions, &mut demands);
        }
        let apart = self.states_apart(&conditions);
        let impossible = |formulas: &[&Formula]| {
            let claims = formulas.iter().map(|f| Claim::Holds(f)).chain(apart.iter().map(Claim::Fails));
            conditions.search(&claims.collect::<Vec<_>>()).is_impossible()
        };
        let ticks = (self.scenario.run.duration / self.program.robot.period).round() as u32;
        let mut told = Vec::new();
        for (j, later) in demands.iter().enumerate() {
            for earlier in &demands[..j] {
                if earlier.of == later.of || told.contains(&later.of) || !earlier.meets(later, ticks) {
                    continue;
                }
                let alone = impossible(&[&earlier.formula]) || impossible(&[&later.formula]);
                if alone || !impossible(&[&earlier.formula, &later.formula]) {
                    continue;
                }
                told.push(later.of);
                let at = |of: usize| self.written.expects[of].formula.span;
                out.push(
                    Diagnostic::warning("HQ0816", at(later.of), "no run satisfies this and another expectation")
                        .label(at(earlier.of), "both cannot hold at the same tick")
                        .note("one of the two fails in every run of this scenario")
                        .help("correct one of them, limit it to a window, or write two scenarios"),
                );
            }
        }
    }

    /// Pairs of states that the machine is never in at once.
    fn states_apart(&self, conditions: &Conditions) -> Vec<Formula> {
        let Some(m) = &self.program.machine else { return Vec::new() };
        let width = self.program.interface.width();
        let state = |key: &Key| {
            let Key::Flag(term) = key else { return None };
            let Op::Signal(k) = *self.graph.ops().get(term.node)? else { return None };
            match self.places.scenario_measures.get(k.checked_sub(width)?)? {
                Measure::In(state) => Some(*state),
                _ => None,
            }
        };
        let states: Vec<(usize, usize)> =
            conditions.variables.iter().enumerate().filter_map(|(v, of)| Some((v, state(&of.key)?))).collect();
        let mut out = Vec::new();
        for (i, (v, a)) in states.iter().enumerate() {
            for (w, b) in &states[..i] {
                if a != b && !m.is_around(*a, *b) && !m.is_around(*b, *a) && !m.are_beside(*a, *b) {
                    out.push(Formula::And(Box::new([Formula::Flag(*v), Formula::Flag(*w)])));
                }
            }
        }
        out
    }
}

/// Adds the demands of a part of an expectation.
fn collect(of: usize, timed: &Timed, at: usize, conditions: &Conditions, out: &mut Vec<Demand>) {
    let (always, window, inner) = match timed.nodes.get(at) {
        Some(Node::Always(window, a)) => (true, *window, *a),
        Some(Node::Eventually(window, a)) => (false, *window, *a),
        Some(Node::Within(ticks, a)) => (false, Window { first: 0, last: Some(*ticks) }, *a),
        Some(Node::And(all)) => {
            all.iter().for_each(|&a| collect(of, timed, a, conditions, out));
            return;
        }
        _ => (true, Window { first: 0, last: Some(0) }, at),
    };
    let formula = plain(timed, inner, conditions);
    out.extend(formula.map(|formula| Demand { of, always, window, formula }));
}

/// A part of an expectation that speaks of one tick.
fn plain(timed: &Timed, at: usize, conditions: &Conditions) -> Option<Formula> {
    let part = |a: usize| plain(timed, a, conditions);
    let not = |f: Formula| Formula::Not(Box::new(f));
    let join = |all: &[usize], with: fn(Box<[Formula; 2]>) -> Formula| {
        let parts: Vec<Formula> = all.iter().map(|&a| part(a)).collect::<Option<_>>()?;
        parts.into_iter().reduce(|a, b| with(Box::new([a, b])))
    };
    match timed.nodes.get(at)? {
        Node::Predicate(p) => conditions.properties.get(*p)?.clone(),
        Node::Not(a) => part(*a).map(not),
        Node::And(all) => join(all, Formula::And),
        Node::Or(all) => join(all, Formula::Or),
        Node::Implies([a, b]) => Some(Formula::Or(Box::new([not(part(*a)?), part(*b)?]))),
        Node::Rise(_) | Node::Always(..) | Node::Eventually(..) | Node::Until(..) | Node::Within(..) => None,
    }
}
