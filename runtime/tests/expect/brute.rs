//! Both evaluations against the definitions, written out as loops over all ticks.

use hierarq_runtime::expect::{Interval, Monitor, Outcome, Value, Verdict, Window};
use proptest::prelude::*;

use crate::generate::{PERIOD, SIGNALS, Tree, UNITS, judge, rows, tree};

struct Definition<'a> {
    rows: &'a [[f64; SIGNALS]],
    /// Truth values alone.
    truth: bool,
}

impl Definition<'_> {
    fn end(&self) -> u32 {
        self.rows.len() as u32
    }

    /// The ticks of a window, and one of which nothing is known where the end leaves it open.
    fn ticks(&self, w: Window, t: u32) -> (Vec<u32>, bool) {
        let last = w.last.map_or(self.end() - 1, |last| t.saturating_add(last));
        let inside: Vec<u32> = (t..self.end()).filter(|s| *s <= last && *s - t >= w.first).collect();
        let open = if w.last.is_some() { last >= self.end() } else { inside.is_empty() };
        (inside, open)
    }

    fn at(&self, tree: &Tree, t: u32) -> Interval {
        let unknown = Interval::unknown(self.end());
        match tree {
            Tree::Predicate(k) => {
                let x = Interval::exact(Value::of_signal(self.rows[t as usize][*k], t));
                if self.truth { x.truth() } else { x }
            }
            Tree::Not(a) => self.at(a, t).negated(),
            Tree::And(list) => list.iter().map(|a| self.at(a, t)).reduce(Interval::and).unwrap(),
            Tree::Or(list) => list.iter().map(|a| self.at(a, t)).reduce(Interval::or).unwrap(),
            Tree::Implies(a, b) => self.at(a, t).negated().or(self.at(b, t)),
            Tree::Rise(a) if t == 0 => self.at(a, t).truth(),
            Tree::Rise(a) => self.at(a, t).truth().and(self.at(a, t - 1).truth().negated()).known_from(t),
            Tree::Always(w, a) => {
                let (ticks, open) = self.ticks(*w, t);
                ticks.iter().map(|s| self.at(a, *s)).chain(open.then_some(unknown)).reduce(Interval::and).unwrap()
            }
            Tree::Eventually(w, a) => {
                let (ticks, open) = self.ticks(*w, t);
                ticks.iter().map(|s| self.at(a, *s)).chain(open.then_some(unknown)).reduce(Interval::or).unwrap()
            }
            Tree::Until(w, a, b) => {
                let (ticks, open) = self.ticks(*w, t);
                let held = |s: u32| (t..s).map(|k| self.at(a, k)).fold(Interval::TRUE, Interval::and);
                let cut = open.then(|| unknown.and(held(self.end())));
                ticks.iter().map(|s| self.at(b, *s).and(held(*s))).chain(cut).reduce(Interval::or).unwrap()
            }
            Tree::Within(last, a) if self.truth => {
                self.at(&Tree::Eventually(Window { first: 0, last: Some(*last) }, a.clone()), t)
            }
            Tree::Within(last, a) => {
                let first = |holds: fn(Interval) -> bool| (t..self.end()).find(|s| holds(self.at(a, *s)));
                let slack = |s: u32| (i64::from(t) + i64::from(*last) - i64::from(s)) as f64 * PERIOD;
                let met = |s: u32| Value::new(slack(s), s);
                let missed = |robustness| Value::new(robustness, self.end() - 1);
                Interval {
                    lower: first(|x| x.lower.is_true()).map_or(missed(f64::NEG_INFINITY), met),
                    upper: first(|x| x.upper.is_true()).map_or(missed(slack(self.end())), met),
                }
            }
        }
    }
}

/// As `Outcome`, bit for bit.
fn same(a: &Outcome, b: &Outcome) -> bool {
    let bits = |o: &Outcome| (o.lower.to_bits(), o.upper.to_bits());
    bits(a) == bits(b) && a == b
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    #[test]
    fn a_log_is_judged_by_the_definitions(tree in tree(false), rows in rows(9)) {
        prop_assume!(!rows.is_empty());
        let outcome = judge(&tree, &rows);
        let number = Definition { rows: &rows, truth: false }.at(&tree, 0);
        let truth = Definition { rows: &rows, truth: true }.at(&tree, 0);
        prop_assert_eq!(outcome.lower.to_bits(), number.lower.robustness().to_bits());
        prop_assert_eq!(outcome.upper.to_bits(), number.upper.robustness().to_bits());
        prop_assert_eq!(outcome.verdict, Verdict::of(number));
        prop_assert_eq!(outcome.verdict, Verdict::of(truth));
        let (worst, decided) = match outcome.verdict {
            Verdict::Holds => (Some(number.lower.tick()), Some(truth.lower.tick())),
            Verdict::Fails => (Some(number.upper.tick()), Some(truth.upper.tick())),
            Verdict::Undecided => (None, None),
        };
        prop_assert_eq!((outcome.worst, outcome.decided), (worst, decided));
        prop_assert!(worst.max(decided).is_none_or(|t| (t as usize) < rows.len()));
    }

    #[test]
    fn a_monitor_agrees_with_the_log(tree in tree(false), rows in rows(40), spare in 0_u32..20) {
        let formula = tree.formula();
        let mut monitor = Monitor::new(&formula, &UNITS, rows.len() as u32 + spare).unwrap();
        let outcome = judge(&tree, &rows);
        let mut early = Vec::new();
        for row in &rows {
            prop_assert_eq!(monitor.push(row), Ok(()));
            early.push(monitor.verdict());
        }
        let online = monitor.finish();
        prop_assert!(same(&online, &outcome), "{:?}\n{:?}", online, outcome);
        let first = early.iter().position(|v| *v != Verdict::Undecided);
        if let Some(first) = first {
            prop_assert!(early[first..].iter().all(|v| *v == outcome.verdict));
            prop_assert!(outcome.decided.is_some_and(|d| d as usize <= first));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    /// A requirement that holds was put to the test if its condition is true at a tick of its window.
    #[test]
    fn a_requirement_that_never_applied_is_said(a in tree(false), b in tree(false), always in any::<bool>(), rows in rows(9)) {
        prop_assume!(!rows.is_empty());
        let implies = Tree::Implies(Box::new(a.clone()), Box::new(b));
        let whole = if always { Tree::Always(Window::ALWAYS, Box::new(implies)) } else { implies };
        let outcome = judge(&whole, &rows);
        let last = if always { rows.len() } else { 1 };
        let truth = Definition { rows: &rows, truth: true };
        let applied = (0..last).any(|t| truth.at(&a, t as u32).lower.is_true());
        prop_assert_eq!(outcome.untested, outcome.verdict == Verdict::Holds && !applied);
    }
}
