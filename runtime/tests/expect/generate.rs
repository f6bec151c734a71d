//! Random formulas and logs.

use hierarq_runtime::expect::{Formula, Node, Outcome, Unit, Window, offline};
use proptest::prelude::*;

/// Number of signals of a tick.
pub const SIGNALS: usize = 3;
/// The period of all formulas here, in s: half a second, so that slacks are exact.
pub const PERIOD: f64 = 0.5;

/// A formula as a tree.
#[derive(Clone, Debug)]
pub enum Tree {
    Predicate(usize),
    Not(Box<Tree>),
    And(Vec<Tree>),
    Or(Vec<Tree>),
    Implies(Box<Tree>, Box<Tree>),
    Rise(Box<Tree>),
    Always(Window, Box<Tree>),
    Eventually(Window, Box<Tree>),
    Until(Window, Box<Tree>, Box<Tree>),
    Within(u32, Box<Tree>),
}

impl Tree {
    pub fn not(self) -> Tree {
        Tree::Not(Box::new(self))
    }

    /// The tree as a list of operations.
    pub fn formula(&self) -> Formula {
        let mut formula = Formula::new(PERIOD);
        self.add(&mut formula);
        assert_eq!(formula.check(SIGNALS), Ok(()));
        formula
    }

    fn add(&self, f: &mut Formula) -> usize {
        let node = match self {
            Tree::Predicate(k) => Node::Predicate(*k),
            Tree::Not(a) => Node::Not(a.add(f)),
            Tree::And(list) => Node::And(list.iter().map(|a| a.add(f)).collect()),
            Tree::Or(list) => Node::Or(list.iter().map(|a| a.add(f)).collect()),
            Tree::Implies(a, b) => Node::Implies([a.add(f), b.add(f)]),
            Tree::Rise(a) => Node::Rise(a.add(f)),
            Tree::Always(w, a) => Node::Always(*w, a.add(f)),
            Tree::Eventually(w, a) => Node::Eventually(*w, a.add(f)),
            Tree::Until(w, a, b) => Node::Until(*w, [a.add(f), b.add(f)]),
            Tree::Within(last, a) => Node::Within(*last, a.add(f)),
        };
        f.add(node)
    }
}

/// Lengths of windows: short, or longer than any run.
fn reach() -> impl Strategy<Value = u32> {
    prop_oneof![12 => 0_u32..6, 1 => Just(u32::MAX)]
}

fn window(bounded: bool) -> impl Strategy<Value = Window> {
    let last = |bounded: bool| {
        if bounded { reach().prop_map(Some).boxed() } else { proptest::option::of(reach()).boxed() }
    };
    (0_u32..4, last(bounded)).prop_map(|(first, more)| Window { first, last: more.map(|m| m.saturating_add(first)) })
}

/// Formulas of depth 4 at most; with bounded windows only, where so wanted.
pub fn tree(bounded: bool) -> impl Strategy<Value = Tree> {
    (0..SIGNALS).prop_map(Tree::Predicate).prop_recursive(4, 24, 3, move |inner| {
        let one = || inner.clone().prop_map(Box::new);
        let list = || proptest::collection::vec(inner.clone(), 1..4);
        prop_oneof![
            one().prop_map(Tree::Not),
            list().prop_map(Tree::And),
            list().prop_map(Tree::Or),
            (one(), one()).prop_map(|(a, b)| Tree::Implies(a, b)),
            one().prop_map(Tree::Rise),
            (window(bounded), one()).prop_map(|(w, a)| Tree::Always(w, a)),
            (window(bounded), one()).prop_map(|(w, a)| Tree::Eventually(w, a)),
            (window(bounded), one(), one()).prop_map(|(w, a, b)| Tree::Until(w, a, b)),
            (reach(), one()).prop_map(|(last, a)| Tree::Within(last, a)),
        ]
    })
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => (-3_i32..=3).prop_map(f64::from),
        2 => -3.0..3.0_f64,
        1 => prop_oneof![Just(-0.0), Just(f64::INFINITY), Just(f64::NEG_INFINITY), Just(f64::NAN)],
    ]
}

/// Logs of up to so many ticks: a row of numbers for each.
pub fn rows(ticks: usize) -> impl Strategy<Value = Vec<[f64; SIGNALS]>> {
    proptest::collection::vec([number(), number(), number()], 0..=ticks)
}

/// The same as a series for each signal.
pub fn log(rows: &[[f64; SIGNALS]]) -> Vec<Vec<f64>> {
    (0..SIGNALS).map(|k| rows.iter().map(|row| row[k]).collect()).collect()
}

pub const UNITS: [Unit; SIGNALS] = [Unit::Truth; SIGNALS];

pub fn judge(tree: &Tree, rows: &[[f64; SIGNALS]]) -> Outcome {
    offline::evaluate(&tree.formula(), &UNITS, &log(rows)).expect("it passes the check")
}
