//! A tick of a monitor allocates nothing, and neither does the end: a counting allocator proves it.

#[path = "../../tests/common/allocations.rs"]
mod allocations;

use hierarq_runtime::expect::{Formula, Monitor, Node, Unit, Window};

/// Every operator, at the first tick alone and below another one, with windows shorter and longer than the run.
fn formulas() -> Vec<Formula> {
    let windows = [(0, Some(0)), (0, Some(7)), (3, Some(40)), (2, Some(900)), (900, Some(901)), (0, None), (5, None)];
    let mut formulas = Vec::new();
    for (first, last) in windows {
        let window = Window { first, last };
        for nested in [false, true] {
            for k in 0..5 {
                let mut f = Formula::new(0.01);
                let a = f.add(Node::Predicate(0));
                let inner = match k {
                    0 => f.add(Node::Always(window, a)),
                    1 => f.add(Node::Eventually(window, a)),
                    2 => f.add(Node::Within(window.last.unwrap_or(window.first), a)),
                    _ => {
                        let b = f.add(Node::Predicate(1));
                        let b =
                            if k == 4 { f.add(Node::Eventually(Window { first: 1, last: Some(20) }, b)) } else { b };
                        f.add(Node::Until(window, [a, b]))
                    }
                };
                let c = f.add(Node::Predicate(1));
                let inner = if nested { f.after(c, inner) } else { f.add(Node::And(vec![c, inner])) };
                f.add(Node::Not(inner));
                formulas.push(f);
            }
        }
    }
    formulas
}

// One test only: another one beside it would be counted too.
#[test]
fn a_tick_allocates_nothing() {
    allocations::are_counted();

    let units = [Unit::Truth; 2];
    for formula in formulas() {
        for ticks in [0, 1, 6, 300] {
            let Ok(mut monitor) = Monitor::new(&formula, &units, ticks) else { panic!("{formula:?} is refused") };
            let before = allocations::so_far();
            let mut taken = true;
            for k in 0..ticks {
                let t = f64::from(k);
                taken &= monitor.push(&[(0.3 * t).sin(), (0.07 * t).cos()]).is_ok();
            }
            let outcome = monitor.finish();
            assert_eq!(allocations::so_far(), before, "{formula:?} allocates");
            assert!(taken, "{outcome:?}");
        }
    }
}
