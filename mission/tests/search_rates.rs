//! Reward rates as functions of the vector from a boundary, srs (1).

use expressions::{Function, Op};
use hierarq_mission::kinds::search::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::search::geometry::Point;
use hierarq_mission::kinds::search::problem::{
    Boundary, Extent, Fall, NoValue, Rate, RateFunction, Source, SourceKind, Travel,
};
use hierarq_mission::kinds::search::validate::validate;
use hierarq_mission::kinds::search::ways::Way;

use crate::common::Random;
use crate::searched::{agent, problem, source, square};

/// A rate that is one of the numbers of the function: 0 is the distance, 1 and 2 the vector.
fn number(argument: usize) -> Rate {
    let of = Function { ops: vec![Op::Input(argument)], result: 0, text: String::new() };
    Rate { function: Some(RateFunction { of, extent: Extent::default() }), ..Rate::ZERO }
}

/// `peak exp(-d^2 / (2 l^2))` as operations.
fn gaussian(peak: f64, l: f64) -> Rate {
    let ops = vec![
        Op::Input(0),
        Op::Mul(0, 0),
        Op::Const(-0.5 / (l * l)),
        Op::Mul(1, 2),
        Op::Exp(3),
        Op::Const(peak),
        Op::Mul(4, 5),
    ];
    let of = Function { ops, result: 6, text: String::new() };
    Rate { function: Some(RateFunction { of, extent: Extent::default() }), ..Rate::ZERO }
}

/// The vector from a boundary ends at the point, begins on the boundary, and is as long as the distance.
#[test]
fn the_vector_begins_on_the_boundary() {
    let mut random = Random(4);
    let mut point = || -> Point { [random.within(-3.0, 9.0), random.within(-3.0, 9.0)] };
    for _ in 0..200 {
        let [a, b, c, p] = [point(), point(), point(), point()];
        let boundaries = [
            Boundary::Polygon(vec![a, b, c]),
            Boundary::Circle { centre: a, radius: 1.5 },
            Boundary::Line(vec![a, b, c]),
            Boundary::Points(vec![a, b, c]),
        ];
        for boundary in boundaries {
            let of = |argument: usize| {
                let rate = number(argument);
                let source = source("s", a, 1.0, 0.0, 0.0, 0);
                Source { inside: rate.clone(), outside: rate, boundary: boundary.clone(), ..source }.rate(p)
            };
            let [d, x, y] = [of(0), of(1), of(2)];
            assert!((d - boundary.side(p).distance).abs() < 1e-12);
            assert!((x.hypot(y) - d).abs() < 1e-9, "{boundary:?} {p:?}: ({x}, {y}) and {d}");
            let begin = [p[0] - x, p[1] - y];
            assert!(boundary.side(begin).distance < 1e-9, "{boundary:?} {p:?}");
        }
    }
    let at_the_centre = Source { inside: number(1), ..source("s", [2.0, 2.0], 1.5, 0.0, 0.0, 0) };
    assert_eq!(at_the_centre.rate([2.0, 2.0]), -1.5);
}

/// A function that is written out gives what the form of the same name gives: rates, the plan and its rewards.
#[test]
fn a_written_form_is_the_form() {
    let of = |outside: Rate| {
        let one = Source { outside, ..source("s", [5.0, 5.0], 0.5, 2.0, 6.0, 1) };
        let mut p = problem(square(8.0), vec![agent("a", false, [1.0, 1.0], 0.7)], vec![one], 30.0);
        let bounds = p.bounds();
        p.sources[0].survey(bounds, 1.0).expect("finite values");
        p
    };
    let form = of(Rate { peak: 1.5, fall: Fall::Gaussian, scale: 0.8, ..Rate::ZERO });
    let written = of(gaussian(1.5, 0.8));
    for i in 0..400 {
        let p = [f64::from(i % 20) * 0.4, f64::from(i / 20) * 0.4];
        assert!((form.sources[0].rate(p) - written.sources[0].rate(p)).abs() < 1e-14);
    }
    let extent = written.sources[0].outside.function.as_ref().expect("a function").extent;
    // The greatest value is at the boundary; half of it is at the distance l sqrt(2 ln 2).
    assert!((1.4..=1.5).contains(&extent.greatest) && extent.least >= 0.0, "{extent:?}");
    assert!((extent.reach - 0.8 * (2.0 * 2_f64.ln()).sqrt()).abs() < 0.1, "{extent:?}");
    let plans = [&form, &written].map(|p| {
        let planned =
            plan(p, &Options { formulation: Formulation::TreeSearch, ..Options::of(p) }).expect("a plan").plan;
        assert_eq!(validate(p, &planned), vec![]);
        planned
    });
    assert!((plans[0].cost - plans[1].cost).abs() < 1e-6 * plans[0].cost.abs(), "{} {}", plans[0].cost, plans[1].cost);
}

/// On one side of a line it is worth being, on the other it is not: the agent goes to the good side.
#[test]
fn a_rate_has_a_direction() {
    // 2 away.y, positive above the line.
    let ops = vec![Op::Input(2), Op::Const(2.0), Op::Mul(0, 1)];
    let of = Function { ops, result: 2, text: String::new() };
    let outside = Rate { fall: Fall::Exponential, scale: 0.5, ..Rate { function: None, ..Rate::ZERO } };
    let outside = Rate { function: Some(RateFunction { of, extent: Extent::default() }), ..outside };
    let line = Boundary::Line(vec![[3.0, 4.0], [5.0, 4.0]]);
    let one = Source { boundary: line, inside: Rate::ZERO, outside, ..source("s", [0.0; 2], 1.0, 0.0, 6.0, 1) };
    let mut p = problem(square(8.0), vec![agent("a", false, [4.0, 1.0], 1.0)], vec![one], 30.0);
    p.sources[0].kind = SourceKind::Task;
    p.sources[0].pool = None;
    let bounds = p.bounds();
    p.sources[0].survey(bounds, 1.0).expect("finite values");
    assert!(p.sources[0].repels() && p.sources[0].attracts());
    let planned = plan(&p, &Options { formulation: Formulation::TreeSearch, ..Options::of(&p) }).expect("a plan").plan;
    assert_eq!(validate(&p, &planned), vec![]);
    let end = planned.activities.iter().max_by(|a, b| a.end.total_cmp(&b.end)).and_then(|a| a.way.last());
    assert!(end.is_some_and(|[_, y]| *y > 4.0), "{end:?}");
}

/// A function without a finite value somewhere on the ground is found, with the place.
#[test]
fn values_that_are_not_finite_are_found() {
    // 1 / (d - 2)^0.5 is NaN nearer than 2 m.
    let ops = vec![Op::Input(0), Op::Const(2.0), Op::Sub(0, 1), Op::Sqrt(2), Op::Const(1.0), Op::Div(4, 3)];
    let of = Function { ops, result: 5, text: String::new() };
    let outside = Rate { function: Some(RateFunction { of, extent: Extent::default() }), ..Rate::ZERO };
    let mut one = Source { outside, ..source("s", [4.0, 4.0], 0.5, 2.0, 6.0, 1) };
    let at = one.survey([[0.0, 0.0], [8.0, 8.0]], 1.0).expect_err("a place");
    let NoValue::At(at) = at else { panic!("{at:?}") };
    let d = (at[0] - 4.0).hypot(at[1] - 4.0) - 0.5;
    assert!((0.0..=2.0).contains(&d), "{at:?}");
    assert_eq!(one.rate(at), 0.0, "no reward");
}

/// `factor` times an argument, per unit of it.
fn times(argument: usize, factor: f64) -> Rate {
    let of =
        Function { ops: vec![Op::Input(argument), Op::Const(factor), Op::Mul(0, 1)], result: 2, text: String::new() };
    Rate { function: Some(RateFunction { of, extent: Extent::default() }), ..Rate::ZERO }
}

/// An action source with an interval of directions (deg).
fn directions([low, high]: [f64; 2], inside: Rate, outside: Rate) -> Source {
    let boundary = Boundary::Heading([low.to_radians(), high.to_radians()]);
    let one = source("s", [0.0; 2], 1.0, 0.0, 0.0, 1);
    Source { kind: SourceKind::Action, boundary, inside, outside, pool: None, ..one }
}

/// A way to the east, the north, the west and the south: each direction gives what its length is worth.
#[test]
fn motions_are_rewarded_by_direction_and_speed() {
    let way = vec![[1.0, 1.0], [4.0, 1.0], [4.0, 6.0], [2.0, 6.0], [2.0, 2.0]];
    let lengths = [(0.0, 3.0), (90.0, 5.0), (180.0, 2.0), (-90.0, 4.0)];
    let within = |[low, high]: [f64; 2], heading: f64| {
        [-360.0, 0.0, 360.0, 720.0].iter().any(|turn| low <= heading + turn && heading + turn <= high)
    };
    for interval in [[80.0, 100.0], [170.0, 190.0], [-190.0, -170.0], [-10.0, 95.0], [600.0, 640.0], [0.0, 360.0]] {
        // Twice the speed in the interval, a tenth a second lost outside.
        let one = directions(interval, times(RateFunction::SPEED, 2.0), Rate::constant(-0.1));
        let p = problem(square(8.0), vec![agent("a", false, way[0], 0.5)], vec![one], 60.0);
        let total: f64 = Way::new(&p, 0, way.clone()).rewards.iter().filter_map(|(_, sums)| sums.last()).sum();
        let of = |(heading, length): (f64, f64)| {
            if within(interval, heading) { 2.0 * length } else { -0.1 * length / 0.5 }
        };
        let exact: f64 = lengths.into_iter().map(of).sum();
        // At each of the three corners a step of a tenth of a second may count for either direction.
        assert!((total - exact).abs() < 3.0 * 0.1 * 1.1, "{interval:?}: {total} and {exact}");
        assert_eq!(p.sources[0].rate_of(Travel::REST), 0.0, "who stands has no direction");
    }
    // A function of the direction itself.
    let one = directions([-180.0, 180.0], times(RateFunction::HEADING, 1.0), Rate::ZERO);
    assert_eq!(one.rate_of(Travel { speed: 1.0, heading: -0.5 }), -0.5);
}

/// Of two equal goals an agent takes the one to which the direction costs nothing.
#[test]
fn directions_decide() {
    let goals = [("north", [1.5, 6.5]), ("east", [6.5, 1.5])];
    for (interval, expected) in [([45.0, 135.0], "east"), ([-45.0, 45.0], "north")] {
        let mut sources: Vec<Source> = goals.map(|(name, at)| source(name, at, 0.5, 2.0, 4.0, 1)).into();
        let mut wind = directions(interval, times(RateFunction::SPEED, -0.3), Rate::ZERO);
        wind.survey([[0.0, 0.0], [8.0, 8.0]], 1.0).expect("finite values");
        assert!(wind.repels() && !wind.attracts());
        sources.push(wind);
        let p = problem(square(8.0), vec![agent("a", false, [1.5, 1.5], 1.0)], sources, 9.0);
        let planned = plan(&p, &Options::of(&p)).expect("a plan").plan;
        assert_eq!(validate(&p, &planned), vec![]);
        let reached = planned.activities.iter().find_map(|a| a.source).map(|source| p.sources[source].name.clone());
        assert_eq!(reached.as_deref(), Some(expected));
    }
}

/// A rate without a finite value for some motion is found.
#[test]
fn motions_without_a_value_are_found() {
    let ops = vec![Op::Input(RateFunction::SPEED), Op::Const(0.5), Op::Sub(0, 1), Op::Sqrt(2)];
    let of = Function { ops, result: 3, text: String::new() };
    let inside = Rate { function: Some(RateFunction { of, extent: Extent::default() }), ..Rate::ZERO };
    let mut one = Source { boundary: Boundary::Speed([0.0, 2.0]), ..directions([0.0, 1.0], inside, Rate::ZERO) };
    let NoValue::Of(travel) = one.survey([[0.0, 0.0], [8.0, 8.0]], 1.0).expect_err("a motion") else {
        panic!("a place")
    };
    assert!(travel.speed < 0.5);
    assert_eq!(one.rate_of(travel), 0.0, "no reward");
}
