//! Time of a tick of twenty expectations, of the end of a run, and of a whole log.

use divan::{Bencher, black_box};
use hierarq_runtime::expect::{Formula, Monitor, Node, Unit, Window, offline};
use stdlib_tasks::dimension::LENGTH;

fn main() {
    divan::main();
}

const PERIOD: f64 = 0.005;
/// 140 s.
const TICKS: u32 = 28_000;
/// Two states and three margins.
const UNITS: [Unit; 5] =
    [Unit::Truth, Unit::Truth, Unit::Quantity(LENGTH), Unit::Quantity(LENGTH), Unit::Quantity(LENGTH)];

fn row(t: u32) -> [f64; 5] {
    let x = f64::from(t) * PERIOD;
    let state = |holds: bool| if holds { f64::INFINITY } else { f64::NEG_INFINITY };
    [state(t % 7000 < 900), state(t % 7000 > 3000), x.sin() + 1.1, (0.3 * x).cos(), (-x).exp() - 0.005]
}

fn window(from: f64, to: Option<f64>) -> Window {
    Window::seconds(from, to, PERIOD).unwrap_or(Window::ALWAYS)
}

/// Typical formulas, with the number of each.
fn typical() -> Vec<(&'static str, usize, Formula)> {
    let build = |make: &dyn Fn(&mut Formula)| {
        let mut f = Formula::new(PERIOD);
        make(&mut f);
        f
    };
    let p = Node::Predicate;
    vec![
        (
            "always m >= 0",
            9,
            build(&|f| {
                let m = f.add(p(2));
                f.add(Node::Always(Window::ALWAYS, m));
            }),
        ),
        (
            "always from 2 s to 5 s m >= 0",
            2,
            build(&|f| {
                let m = f.add(p(3));
                f.add(Node::Always(window(2.0, Some(5.0)), m));
            }),
        ),
        (
            "eventually within 140 s : in(a)",
            2,
            build(&|f| {
                let a = f.add(p(1));
                f.within(TICKS, a, &UNITS);
            }),
        ),
        (
            "in(a) until m >= 0",
            2,
            build(&|f| {
                let (a, m) = (f.add(p(0)), f.add(p(3)));
                f.add(Node::Until(Window::ALWAYS, [a, m]));
            }),
        ),
        (
            "always (in(a) implies m >= 0 and n >= 0)",
            1,
            build(&|f| {
                let (a, m, n) = (f.add(p(0)), f.add(p(2)), f.add(p(3)));
                let both = f.add(Node::And(vec![m, n]));
                let clear = f.add(Node::Implies([a, both]));
                f.add(Node::Always(Window::ALWAYS, clear));
            }),
        ),
        (
            "after in(a) : within 25 s in(b)",
            2,
            build(&|f| {
                let (a, b) = (f.add(p(0)), f.add(p(1)));
                let soon = f.within(5000, b, &UNITS);
                f.after(a, soon);
            }),
        ),
        (
            "after in(a) : always[0 s, 2 s] m >= 0",
            1,
            build(&|f| {
                let (a, m) = (f.add(p(0)), f.add(p(2)));
                let calm = f.add(Node::Always(window(0.0, Some(2.0)), m));
                f.after(a, calm);
            }),
        ),
        (
            "eventually always n >= 0",
            1,
            build(&|f| {
                let n = f.add(p(4));
                let stays = f.add(Node::Always(Window::ALWAYS, n));
                f.add(Node::Eventually(Window::ALWAYS, stays));
            }),
        ),
    ]
}

fn twenty() -> Vec<Formula> {
    let all: Vec<Formula> = typical().into_iter().flat_map(|(_, n, f)| vec![f; n]).collect();
    assert_eq!(all.len(), 20);
    all
}

fn monitor(formula: &Formula, ticks: u32) -> Monitor {
    let Ok(monitor) = Monitor::new(formula, &UNITS, ticks) else { panic!("it is refused") };
    monitor
}

fn names() -> Vec<&'static str> {
    typical().into_iter().map(|(name, ..)| name).collect()
}

/// The mean over a whole run, so that the dear ticks count.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn twenty_expectations_28000_ticks(bencher: Bencher) {
    let rows: Vec<[f64; 5]> = (0..TICKS).map(row).collect();
    let fresh = || twenty().iter().map(|f| monitor(f, TICKS)).collect::<Vec<_>>();
    bencher.counter(divan::counter::ItemsCount::new(TICKS)).with_inputs(fresh).bench_local_refs(|monitors| {
        for row in &rows {
            for m in monitors.iter_mut() {
                let _ = black_box(m.push(black_box(row)));
            }
        }
    });
}

/// One expectation over a whole run.
#[divan::bench(args = names(), sample_count = 20, sample_size = 1)]
fn one_expectation_28000_ticks(bencher: Bencher, name: &str) {
    let rows: Vec<[f64; 5]> = (0..TICKS).map(row).collect();
    let Some((_, _, f)) = typical().into_iter().find(|t| t.0 == name) else { return };
    bencher.counter(divan::counter::ItemsCount::new(TICKS)).with_inputs(|| monitor(&f, TICKS)).bench_local_refs(|m| {
        for row in &rows {
            let _ = black_box(m.push(black_box(row)));
        }
    });
}

/// The end of a run of twenty.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn twenty_ends(bencher: Bencher) {
    let ended = || {
        let mut monitors: Vec<Monitor> = twenty().iter().map(|f| monitor(f, TICKS)).collect();
        for m in &mut monitors {
            for t in 0..TICKS {
                let _ = m.push(&row(t));
            }
        }
        monitors
    };
    bencher.with_inputs(ended).bench_local_values(|monitors| {
        for m in monitors {
            black_box(m.finish());
        }
    });
}

/// The same twenty over the log.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn twenty_logs(bencher: Bencher) {
    let log: Vec<Vec<f64>> = (0..5).map(|k| (0..TICKS).map(|t| row(t)[k]).collect()).collect();
    let formulas = twenty();
    bencher.bench_local(|| {
        for f in &formulas {
            let _ = black_box(offline::evaluate(f, &UNITS, black_box(&log)));
        }
    });
}
