//! Laws: of negation, of intervals, of the tick at which a verdict is certain.

use hierarq_runtime::expect::{Outcome, Verdict, Window};
use proptest::prelude::*;

use crate::generate::{Tree, judge, rows, tree};

/// Robustness, bit for bit, and instants.
fn parts(o: &Outcome) -> (Verdict, u64, u64, Option<u32>, Option<u32>) {
    (o.verdict, o.lower.to_bits(), o.upper.to_bits(), o.worst, o.decided)
}

fn negated(o: &Outcome) -> (Verdict, u64, u64, Option<u32>, Option<u32>) {
    let verdict = match o.verdict {
        Verdict::Holds => Verdict::Fails,
        Verdict::Fails => Verdict::Holds,
        Verdict::Undecided => Verdict::Undecided,
    };
    (verdict, (-o.upper).to_bits(), (-o.lower).to_bits(), o.worst, o.decided)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn negation(a in tree(false), rows in rows(20)) {
        let plain = judge(&a, &rows);
        prop_assert_eq!(parts(&judge(&a.clone().not(), &rows)), negated(&plain));
        prop_assert_eq!(parts(&judge(&a.not().not(), &rows)), parts(&plain));
    }

    #[test]
    fn de_morgan(a in tree(false), b in tree(false), first in 0_u32..3, last in proptest::option::of(3_u32..6), rows in rows(20)) {
        let w = Window { first, last };
        let both = judge(&Tree::And(vec![a.clone(), b.clone()]), &rows);
        let neither = judge(&Tree::Or(vec![a.clone().not(), b.clone().not()]).not(), &rows);
        prop_assert_eq!(parts(&both), parts(&neither));
        let always = judge(&Tree::Always(w, Box::new(a.clone())), &rows);
        let not_once = judge(&Tree::Eventually(w, Box::new(a.clone().not())).not(), &rows);
        prop_assert_eq!(parts(&always), parts(&not_once));
        let either = judge(&Tree::Or(vec![a.clone().not(), b.clone()]), &rows);
        prop_assert_eq!(parts(&judge(&Tree::Implies(Box::new(a), Box::new(b)), &rows)), parts(&either));
    }

    // The interval says the truth about any further ticks, and the verdict is certain from `decided` on, not before.
    #[test]
    fn what_comes_later_stays_inside(a in tree(true), rows in rows(24), cut in 0_usize..24) {
        let whole = judge(&a, &rows);
        let part = judge(&a, &rows[..cut.min(rows.len())]);
        prop_assert!(part.lower <= whole.lower && whole.upper <= part.upper, "{:?}\n{:?}", part, whole);
        prop_assert!(part.verdict == Verdict::Undecided || part.verdict == whole.verdict);
        if let Some(decided) = whole.decided {
            prop_assert_eq!(judge(&a, &rows[..decided as usize + 1]).verdict, whole.verdict);
            prop_assert_eq!(judge(&a, &rows[..decided as usize]).verdict, Verdict::Undecided);
        }
    }

    // No change of the signals that is smaller than the margin changes the verdict.
    #[test]
    fn the_margin_protects_the_verdict(a in tree(false), rows in rows(20), share in 0.0..1.0_f64) {
        prop_assume!(!has_slack(&a));
        let o = judge(&a, &rows);
        let margin = match o.verdict {
            Verdict::Holds => o.lower,
            Verdict::Fails => -o.upper,
            Verdict::Undecided => return Ok(()),
        };
        let step = if margin.is_finite() { share * 0.999 * margin } else { 0.0 };
        let mut sign = 1.0;
        let moved: Vec<_> = rows.iter().map(|row| row.map(|x| { sign = -sign; x + sign * step })).collect();
        prop_assert_eq!(judge(&a, &moved).verdict, o.verdict);
    }
}

/// True where numbers are not those of the signals, or truth alone counts.
fn has_slack(tree: &Tree) -> bool {
    match tree {
        Tree::Predicate(_) => false,
        Tree::Within(..) | Tree::Rise(_) => true,
        Tree::Not(a) | Tree::Always(_, a) | Tree::Eventually(_, a) => has_slack(a),
        Tree::And(list) | Tree::Or(list) => list.iter().any(has_slack),
        Tree::Implies(a, b) | Tree::Until(_, a, b) => has_slack(a) || has_slack(b),
    }
}
