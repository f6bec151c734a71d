//! Formulas whose outcome can be checked by hand.

use hierarq_runtime::expect::{Formula, MAX_NODES, Monitor, Node, Outcome, PushError, Unit, Verdict, Window, offline};
use stdlib_tasks::dimension::{LENGTH, TIME};

const UNITS: [Unit; 3] = [Unit::Truth, Unit::Truth, Unit::Quantity(LENGTH)];
/// In the first state, in the second, and a distance in m.
const ASK: Node = Node::Predicate(0);
const GRASP: Node = Node::Predicate(1);
const GAP: Node = Node::Predicate(2);

fn truth(text: &str) -> Vec<f64> {
    text.chars().map(|c| if c == '#' { f64::INFINITY } else { f64::NEG_INFINITY }).collect()
}

/// Both evaluations, at a period of 0.5 s.
fn judge(build: impl FnOnce(&mut Formula), log: [Vec<f64>; 3]) -> Outcome {
    let mut f = Formula::new(0.5);
    build(&mut f);
    let outcome = offline::evaluate(&f, &UNITS, &log).unwrap();
    let mut monitor = Monitor::new(&f, &UNITS, log[0].len() as u32).unwrap();
    let [ask, grasp, gap] = &log;
    for ((ask, grasp), gap) in ask.iter().zip(grasp).zip(gap) {
        monitor.push(&[*ask, *grasp, *gap]).unwrap();
    }
    assert_eq!(monitor.finish(), outcome);
    outcome
}

/// `after in(ask) : within 2 s in(grasp)`.
fn after_ask_grasp(f: &mut Formula) {
    let ask = f.add(ASK);
    let grasp = f.add(GRASP);
    let soon = f.within(4, grasp, &UNITS);
    f.after(ask, soon);
}

fn states(ask: &str, grasp: &str) -> [Vec<f64>; 3] {
    [truth(ask), truth(grasp), vec![0.0; ask.len()]]
}

#[test]
fn a_deadline_has_a_slack_in_seconds() {
    let o = judge(after_ask_grasp, states(".##...##......", "....#....#...."));
    assert_eq!((o.verdict, o.margin(), o.unit), (Verdict::Holds, Some(0.5), Unit::Quantity(TIME)));
    assert_eq!(o.worst, Some(9), "4 is 3 ticks after the first rise, 9 after the second: of equals the later");
    assert_eq!(o.decided, Some(13), "another rise could have come until the end");

    let late = judge(after_ask_grasp, states(".##...##......", "............#."));
    assert_eq!((late.verdict, late.margin()), (Verdict::Fails, Some(-3.5)), "due at 5, there at 12");
    assert_eq!((late.worst, late.decided), (Some(12), Some(5)));

    let never = judge(after_ask_grasp, states(".##...........", ".............."));
    assert_eq!(
        (never.verdict, never.lower, never.upper),
        (Verdict::Fails, f64::NEG_INFINITY, -4.5),
        "at least 9 ticks"
    );
    assert_eq!((never.worst, never.decided), (Some(13), Some(5)));

    let cut = judge(after_ask_grasp, states("..........#...", ".............."));
    assert_eq!((cut.verdict, cut.margin(), cut.worst), (Verdict::Undecided, None, None));
    assert_eq!(cut.upper, 0.0, "the first tick after the end is just in time");

    let none = judge(after_ask_grasp, states("..............", ".............."));
    assert_eq!((none.verdict, none.margin()), (Verdict::Holds, None), "it was never asked");

    let at_the_start = judge(after_ask_grasp, states("#.............", "....#........."));
    assert_eq!((at_the_start.verdict, at_the_start.margin()), (Verdict::Holds, Some(0.0)));
}

/// `always margin(arms_apart) >= 0 m`.
fn always_apart(f: &mut Formula) {
    let gap = f.add(GAP);
    f.add(Node::Always(Window::ALWAYS, gap));
}

#[test]
fn a_margin_is_the_worst_of_the_run() {
    let log = |gap: &[f64]| [vec![0.0; gap.len()], vec![0.0; gap.len()], gap.to_vec()];
    let o = judge(always_apart, log(&[0.3, 0.1, 0.2]));
    assert_eq!((o.verdict, o.margin(), o.unit, o.worst), (Verdict::Holds, Some(0.1), Unit::Quantity(LENGTH), Some(1)));
    let o = judge(always_apart, log(&[0.3, -0.1, 0.2, -0.2, -0.2, 0.1]));
    assert_eq!((o.verdict, o.margin(), o.worst, o.decided), (Verdict::Fails, Some(-0.2), Some(3), Some(1)));
    let o = judge(always_apart, log(&[0.3, 0.0, -0.0]));
    assert_eq!((o.verdict, o.margin()), (Verdict::Holds, Some(0.0)));
    let o = judge(always_apart, log(&[0.3, f64::NAN, 0.1]));
    assert_eq!((o.verdict, o.margin(), o.worst, o.undefined), (Verdict::Fails, None, Some(1), Some(1)));
    let o = judge(always_apart, log(&[]));
    assert_eq!((o.verdict, o.worst, o.decided), (Verdict::Undecided, None, None));
}

#[test]
fn truth_values_choose_the_instants_that_count() {
    // always (in(grasp) implies gap >= 0 m)
    let grasping_is_clear = |f: &mut Formula| {
        let grasp = f.add(GRASP);
        let gap = f.add(GAP);
        let clear = f.add(Node::Implies([grasp, gap]));
        f.add(Node::Always(Window::ALWAYS, clear));
    };
    let o = judge(grasping_is_clear, [truth("......"), truth("..##.."), vec![-1.0, 0.1, 0.4, 0.3, 0.2, -1.0]]);
    assert_eq!((o.verdict, o.margin(), o.worst), (Verdict::Holds, Some(0.3), Some(3)));
}

#[test]
fn a_window_that_is_cut_off_decides_only_what_it_must() {
    // always [0 s, 2 s] gap >= 0 m
    let two_seconds = |f: &mut Formula| {
        let gap = f.add(GAP);
        f.add(Node::Always(Window { first: 0, last: Some(4) }, gap));
    };
    let log = |gap: &[f64]| [vec![0.0; gap.len()], vec![0.0; gap.len()], gap.to_vec()];
    let o = judge(two_seconds, log(&[0.3, 0.2, 0.3]));
    assert_eq!((o.verdict, o.lower, o.upper), (Verdict::Undecided, f64::NEG_INFINITY, 0.2));
    let o = judge(two_seconds, log(&[0.3, -0.1, 0.3]));
    assert_eq!((o.verdict, o.lower, o.margin()), (Verdict::Fails, f64::NEG_INFINITY, Some(-0.1)));
    let o = judge(two_seconds, log(&[0.3, 0.2, 0.3, 0.4, 0.5, -1.0]));
    assert_eq!((o.verdict, o.margin(), o.decided), (Verdict::Holds, Some(0.2), Some(4)));
}

#[test]
fn a_violation_shows_at_once() {
    let mut f = Formula::new(0.5);
    always_apart(&mut f);
    let mut monitor = Monitor::new(&f, &UNITS, 3).unwrap();
    assert_eq!(monitor.verdict(), Verdict::Undecided);
    monitor.push(&[0.0, 0.0, 0.1]).unwrap();
    assert_eq!(monitor.verdict(), Verdict::Undecided);
    monitor.push(&[0.0, 0.0, -0.1]).unwrap();
    assert_eq!(monitor.verdict(), Verdict::Fails);
    assert_eq!(monitor.push(&[0.0]), Err(PushError::Signals));
    monitor.push(&[0.0, 0.0, 0.1]).unwrap();
    assert_eq!(monitor.push(&[0.0, 0.0, -9.0]), Err(PushError::TooLong));
    assert_eq!(monitor.finish().margin(), Some(-0.1));
}

#[test]
fn what_cannot_be_watched_is_refused() {
    let nested = |window: Window| {
        let mut f = Formula::new(0.001);
        let gap = f.add(GAP);
        let inner = f.add(Node::Eventually(window, gap));
        f.add(Node::Always(Window::ALWAYS, inner));
        f
    };
    let refused = |f: &Formula, ticks| Monitor::new(f, &UNITS, ticks).map(|_| ()).map_err(|e| e.place);
    let most = Window { first: 0, last: Some(u32::MAX) };
    assert_eq!(refused(&nested(Window::ALWAYS), 1_000_000_000), Err("nodes".to_string()));
    assert_eq!(refused(&nested(most), 1_000_000_000), Err("nodes".to_string()));
    assert_eq!(refused(&nested(most), 100_000), Ok(()));
    let mut f = Formula::new(0.001);
    always_apart(&mut f);
    assert_eq!(refused(&f, u32::MAX), Ok(()), "nothing of a run is kept for it");

    // The deepest and longest formula.
    let mut deep = Formula::new(0.001);
    let mut place = deep.add(GAP);
    for k in 1..MAX_NODES {
        place = deep.add(if k % 2 == 0 { Node::Not(place) } else { Node::Eventually(most, place) });
    }
    assert_eq!(deep.check(3), Ok(()));
    assert_eq!(refused(&deep, 1_000_000), Err("nodes".to_string()));
    assert_eq!(refused(&deep, 100), Ok(()));
    deep.add(Node::Not(place));
    assert!(deep.check(3).is_err());

    assert!(offline::evaluate(&f, &UNITS, &[vec![0.0], vec![0.0]]).is_err(), "a series is missing");
    assert!(offline::evaluate(&f, &UNITS, &[vec![0.0], vec![0.0], vec![]]).is_err(), "a series is shorter");
}
