//! Trajectories against their definition: integrals and derivatives of what they say, limits, arrival, and a brute-force
//! search for something faster.

use hierarq_runtime::program::{Motion as Profiled, Shape, TrajectoryProgram};
use hierarq_runtime::trajectory::{
    Follower, Limits, Motion, Path, Profile, Route, RouteOptions, State, Turn, Turning, s_curve, trapezoid,
};
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;

/// Relative rounding error by which a limit may be exceeded.
const SLIP: f64 = 1e-9;

fn motion(position: f64, velocity: f64, acceleration: f64) -> Motion {
    Motion { position, velocity, acceleration }
}

/// Samples of a profile, among them the instants around its ends.
fn instants(duration: f64) -> impl Iterator<Item = f64> {
    (0..=400).map(move |i| duration * f64::from(i) / 400.0)
}

/// Position, velocity and acceleration belong together: each step is what the next derivative, which is piecewise linear,
/// allows within `most` of the one behind it.
fn hangs_together(duration: f64, at: impl Fn(f64) -> Motion, most: f64) -> Result<(), TestCaseError> {
    let mut before: Option<(f64, Motion)> = None;
    for t in instants(duration) {
        let now = at(t);
        if let Some((s, last)) = before {
            let dt = t - s;
            // Trapezoidal rule; its error is at most dt² / 8 of the bound of what is behind the rate, twice.
            let way = 0.5 * (last.velocity + now.velocity) * dt;
            let size = 1.0 + now.position.abs() + duration * now.velocity.abs();
            prop_assert!((now.position - last.position - way).abs() <= most * dt * dt + 1e-11 * size);
            prop_assert!((now.velocity - last.velocity).abs() <= most * dt * (1.0 + SLIP) + 1e-11 * size);
        }
        before = Some((t, now));
    }
    Ok(())
}

fn ends_at(profile: &Profile, goal: f64) -> Result<(), TestCaseError> {
    let end = profile.at(profile.duration());
    prop_assert_eq!(end, Motion::rest(goal));
    let before = profile.at(profile.duration() * (1.0 - 1e-12));
    let size = 1.0 + goal.abs() + profile.duration();
    prop_assert!((before.position - goal).abs() <= 1e-8 * size, "{:?} is not {}", before, goal);
    prop_assert!(before.velocity.abs() <= 1e-5 * size);
    Ok(())
}

/// The shortest way in time to `goal` of an acceleration that is switched from `a` to `-a` once, with a cruise between at
/// any speed up to `speed`, by search over the speed and both signs.
fn searched(from: f64, velocity: f64, goal: f64, speed: f64, a: f64) -> f64 {
    let mut best = f64::INFINITY;
    for i in -20000..=20000 {
        let u = speed * f64::from(i) / 20000.0;
        let ramps = (u * u - velocity * velocity) / (2.0 * a) * if u >= velocity { 1.0 } else { -1.0 };
        let way = ramps + u * u.abs() / (2.0 * a);
        let left = goal - from - way;
        let cruise = if u == 0.0 { f64::INFINITY } else { left / u };
        if cruise >= 0.0 {
            best = f64::min(best, (u - velocity).abs() / a + cruise + u.abs() / a);
        }
    }
    best
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_trapezoid_keeps_its_limits_and_arrives(
        from in -5.0..5.0, v in -2.0..2.0, goal in -5.0..5.0, speed in 0.05..2.0, a in 0.05..5.0,
    ) {
        let p = trapezoid(motion(from, v, 0.0), goal, speed, a);
        prop_assert_eq!(p.at(0.0).position, from);
        prop_assert_eq!(p.at(0.0).velocity, v);
        let most = speed.max(f64::abs(v));
        for t in instants(p.duration()) {
            let now = p.at(t);
            prop_assert!(now.velocity.abs() <= most * (1.0 + SLIP));
            prop_assert!(now.acceleration.abs() <= a * (1.0 + SLIP));
        }
        hangs_together(p.duration(), |t| p.at(t), a)?;
        ends_at(&p, goal)?;
    }

    #[test]
    fn nothing_is_faster_than_a_trapezoid(
        from in -1.0..1.0, share in -1.0..1.0, goal in -1.0..1.0, speed in 0.1..2.0, a in 0.2..5.0,
    ) {
        let v = share * speed;
        let (p, best) = (trapezoid(motion(from, v, 0.0), goal, speed, a), searched(from, v, goal, speed, a));
        prop_assert!(p.duration() <= best * (1.0 + SLIP) + 1e-12, "{} instead of {}", p.duration(), best);
        prop_assert!(p.duration() >= best - 0.02 * (1.0 + best), "{} instead of {}", p.duration(), best);
    }

    #[test]
    fn an_s_curve_keeps_its_limits_and_arrives(
        from in -5.0..5.0, share in -1.0..1.0, push in -1.0..1.0, goal in -5.0..5.0,
        speed in 0.05..2.0, a in 0.05..5.0, jerk in 0.5..50.0,
    ) {
        // A state from which the speed can be kept: what the acceleration still adds counts.
        let a0 = push * f64::min(a, f64::sqrt(speed * jerk));
        let v0 = share * f64::max(0.0, speed - a0 * a0 / (2.0 * jerk));
        let p = s_curve(motion(from, v0, a0), goal, speed, a, jerk);
        for t in instants(p.duration()) {
            let now = p.at(t);
            prop_assert!(now.velocity.abs() <= speed * (1.0 + SLIP) + 1e-12, "speed {}", now.velocity);
            prop_assert!(now.acceleration.abs() <= a * (1.0 + SLIP));
        }
        // The acceleration itself is continuous.
        let mut before = p.at(0.0);
        prop_assert!((before.velocity - v0).abs() <= 1e-12 && (before.acceleration - a0).abs() <= 1e-12);
        let dt = p.duration() / 400.0;
        for t in instants(p.duration()) {
            let now = p.at(t);
            prop_assert!((now.acceleration - before.acceleration).abs() <= jerk * dt * (1.0 + SLIP) + 1e-7);
            before = now;
        }
        hangs_together(p.duration(), |t| p.at(t), a.max(a0.abs()))?;
        ends_at(&p, goal)?;
    }

    #[test]
    fn s_curves_go_on_from_where_they_are(
        first in -1.0..1.0_f64, second in -1.0..1.0_f64, when in 0.0..1.0_f64, speed in 0.1..1.0, a in 0.2..3.0, jerk in 1.0..30.0,
    ) {
        let p = s_curve(Motion::rest(0.0), first, speed, a, jerk);
        let now = p.at(when * p.duration());
        let q = s_curve(now, second, speed, a, jerk);
        for t in instants(q.duration()) {
            let now = q.at(t);
            prop_assert!(now.velocity.abs() <= speed * (1.0 + SLIP) + 1e-12);
            prop_assert!(now.acceleration.abs() <= a * (1.0 + SLIP) + 1e-12);
        }
        // The same goal again is the rest of the same way.
        let again = s_curve(now, first, speed, a, jerk);
        let left = p.duration() * (1.0 - when);
        prop_assert!((again.duration() - left).abs() <= 1e-4 * (1.0 + left), "{} instead of {}", again.duration(), left);
        ends_at(&q, second)?;
    }
}

fn vector(range: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-range..range).prop_map(Vector3::from)
}

/// Norms within limits, and a chain of derivatives.
fn bounded(duration: f64, at: impl Fn(f64) -> State, l: &Limits, faster: f64) -> Result<(), TestCaseError> {
    let mut before: Option<(f64, State)> = None;
    for t in instants(duration) {
        let now = at(t);
        prop_assert!(
            now.velocity.norm() <= l.speed.max(faster) * (1.0 + SLIP) + 1e-12,
            "speed {} at {}",
            now.velocity.norm(),
            t
        );
        prop_assert!(
            now.acceleration.norm() <= l.acceleration * (1.0 + SLIP) + 1e-12,
            "acceleration {}",
            now.acceleration.norm()
        );
        if let Some((s, last)) = before {
            let dt = t - s;
            let way = (last.velocity + now.velocity) * (0.5 * dt);
            let slip = l.acceleration * dt * dt + 1e-11 * (1.0 + duration);
            prop_assert!((now.position - last.position - way).norm() <= slip);
            prop_assert!(
                (now.velocity - last.velocity).norm() <= l.acceleration * dt * (1.0 + SLIP) + 1e-11 * (1.0 + duration)
            );
            if let Some(jerk) = l.jerk {
                let jump = (now.acceleration - last.acceleration).norm();
                prop_assert!(jump <= jerk * dt * (1.0 + SLIP) + 1e-7, "{} within {} s", jump, dt);
            }
        }
        before = Some((t, now));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_vector_goes_straight_from_rest_and_turns_within_its_limits(
        from in vector(1.0), goals in prop::collection::vec((vector(1.0), 0.0..1.2), 1..6),
        speed in 0.05..1.0, a in 0.2..3.0, jerk in prop::option::of(1.0..30.0),
    ) {
        let l = Limits { speed, acceleration: a, jerk };
        let mut now = State::rest(from);
        for (i, (goal, when)) in goals.iter().enumerate() {
            let path = Path::plan(&now, *goal, &l).expect("a plan");
            prop_assert!((path.at(0.0).position - now.position).norm() <= 1e-12);
            prop_assert!((path.at(0.0).velocity - now.velocity).norm() <= 1e-8 * speed);
            if jerk.is_some() {
                prop_assert!((path.at(0.0).acceleration - now.acceleration).norm() <= 1e-8 * a);
            }
            bounded(path.duration(), |t| path.at(t), &l, 0.0)?;
            prop_assert_eq!(path.at(path.duration()), State::rest(*goal));
            let close = path.at(path.duration() * (1.0 - 1e-12));
            prop_assert!((close.position - goal).norm() <= 1e-8 * (1.0 + path.duration()));
            if i == 0 {
                let e = (goal - from).normalize();
                for t in instants(path.duration()) {
                    let p = path.at(t).position - from;
                    prop_assert!((p - e * p.dot(&e)).norm() <= 1e-12, "off the line");
                }
            }
            now = path.at(when * path.duration());
        }
    }

    #[test]
    fn too_fast_a_start_is_braked(from in vector(1.0), v in vector(3.0), goal in vector(1.0), jerk in prop::option::of(2.0..30.0)) {
        let l = Limits { speed: 0.5, acceleration: 1.0, jerk };
        let path = Path::plan(&State { velocity: v, ..State::rest(from) }, goal, &l).expect("a plan");
        bounded(path.duration(), |t| path.at(t), &l, v.norm())?;
        prop_assert_eq!(path.at(path.duration()), State::rest(goal));
    }

    #[test]
    fn a_way_can_take_longer(from in vector(1.0), goal in vector(1.0), factor in 1.0..5.0_f64, jerk in prop::option::of(2.0..30.0)) {
        let l = Limits { speed: 0.5, acceleration: 1.0, jerk };
        let shortest = Path::plan(&State::rest(from), goal, &l).expect("a plan");
        let path = Path::within(&State::rest(from), goal, &l, factor * shortest.duration()).expect("a plan");
        prop_assert!((path.duration() - factor * shortest.duration()).abs() <= 1e-6 * path.duration());
        bounded(path.duration(), |t| path.at(t), &l, 0.0)?;
        let now = shortest.at(0.4 * shortest.duration());
        let again = Path::plan(&now, from, &l).expect("a plan").duration() * factor;
        let back = Path::within(&now, from, &l, again).expect("a plan");
        prop_assert!((back.duration() - again).abs() <= 1e-2 * again, "{} instead of {}", back.duration(), again);
    }

    #[test]
    fn an_orientation_turns_within_its_speed(
        from in vector(2.0), goals in prop::collection::vec((vector(2.0), 0.05..1.1), 1..5),
        speed in 0.1..2.0, a in 0.3..5.0, jerk in prop::option::of(2.0..40.0),
    ) {
        let l = Limits { speed, acceleration: a, jerk };
        let rest = Vector3::zeros();
        let mut now = Turning { orientation: UnitQuaternion::from_scaled_axis(from), velocity: rest, acceleration: rest };
        for (i, (goal, when)) in goals.iter().enumerate() {
            let goal = UnitQuaternion::from_scaled_axis(*goal);
            let turn = Turn::plan(&now, goal, &l).expect("a plan");
            prop_assert!((turn.at(0.0).1 - now.velocity).norm() <= 1e-8);
            prop_assert!(turn.at(0.0).0.angle_to(&now.orientation) <= 1e-7);
            let dt = turn.duration() / 400.0;
            for t in instants(turn.duration() * 0.9975) {
                let (q, omega) = turn.at(t);
                prop_assert!(omega.norm() <= speed * (1.0 + SLIP) + 1e-12, "{} rad/s", omega.norm());
                // The orientation moves as its angular velocity says.
                let next = turn.at(t + dt).0;
                let way = (next * q.inverse()).scaled_axis();
                let (_, middle) = turn.at(t + dt / 2.0);
                let slip = dt * dt * (2.0 * a + 4.0 * speed * speed) + 1e-9;
                prop_assert!((way - middle * dt).norm() <= slip, "{} off", (way - middle * dt).norm());
            }
            prop_assert!(turn.at(turn.duration()).0.angle_to(&goal) <= 1e-7);
            prop_assert_eq!(turn.at(turn.duration()).1, rest);
            if i == 0 {
                let axis = (goal * now.orientation.inverse()).scaled_axis();
                let halfway = turn.at(turn.duration() / 2.0).0 * now.orientation.inverse();
                prop_assert!((halfway.scaled_axis() - axis / 2.0).norm() <= 1e-7, "not the geodesic");
            }
            now = turn.state(when * turn.duration());
        }
    }

    #[test]
    fn a_route_passes_its_corners_as_closely_as_said(
        from in vector(1.0), points in prop::collection::vec(vector(1.0), 1..6), corner in 0.0..0.2, a in 0.2..3.0, speed in 0.05..1.0,
    ) {
        let l = Limits { speed, acceleration: a, jerk: None };
        let options = RouteOptions { limits: l, corner, halt: 0.0 };
        let mut route = Route::new(points.len());
        prop_assert!(route.plan(&State::rest(from), &points, 0, &options));
        bounded(route.duration(), |t| route.at(t), &l, 0.0)?;
        prop_assert_eq!(route.at(route.duration()), State::rest(points[points.len() - 1]));
        let near = |p: &Vector3<f64>| instants(route.duration()).map(|t| (route.at(t).position - p).norm()).fold(f64::INFINITY, f64::min);
        for p in &points {
            let between = speed * route.duration() / 400.0;
            prop_assert!(near(p) <= corner + between, "{} from a corner", near(p));
        }
        // So does one that is slow at the beginning.
        let slow = State { velocity: Vector3::new(0.02, 0.03, -0.02) * speed, ..State::rest(from) };
        let mut drifting = Route::new(points.len());
        prop_assert!(drifting.plan(&slow, &points, 0, &options));
        bounded(drifting.duration(), |t| drifting.at(t), &l, 0.0)?;
        prop_assert!((drifting.at(0.0).position - from).norm() <= 1e-12);
        prop_assert!((drifting.at(0.0).velocity - slow.velocity).norm() <= 1e-12);
        // Moving, it turns to the point that it was on the way to.
        let t = 0.4 * route.duration();
        let (now, next) = (route.at(t), route.toward(t).expect("a point"));
        let mut again = Route::new(points.len());
        let moving = State { acceleration: Vector3::zeros(), ..now };
        prop_assert!(again.plan(&moving, &points[next..], next, &options));
        bounded(again.duration(), |t| again.at(t), &l, 0.0)?;
        prop_assert!((again.at(0.0).velocity - now.velocity).norm() <= 1e-8);
    }

    #[test]
    fn no_number_makes_a_plan_panic(
        all in prop::array::uniform12(prop::sample::select(vec![
            0.0, 1.0, -1.0, 1e-300, 1e-12, 1e12, 1e300, -1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX,
        ])),
        jerk in prop::option::of(prop::sample::select(vec![0.0, 1e-300, 1.0, 1e300, f64::NAN])),
    ) {
        let [a, b, c, d, e, f, g, h, i, j, k, l] = all;
        let limits = Limits { speed: j, acceleration: k, jerk };
        let from = State { position: Vector3::new(a, b, c), velocity: Vector3::new(d, e, f), acceleration: Vector3::new(l, 0.0, 0.0) };
        let goal = Vector3::new(g, h, i);
        if let Some(path) = Path::plan(&from, goal, &limits) {
            let now = path.at(0.3 * path.duration());
            prop_assert!(path.duration() >= 0.0 && path.duration().is_finite());
            prop_assert!(now.position.iter().chain(&now.velocity).all(|x| !x.is_nan()), "{:?}", now);
        }
        let mut route = Route::new(2);
        route.plan(&from, &[goal, from.position], 0, &RouteOptions { limits, corner: l, halt: 0.0 });
        route.at(0.1);
        trapezoid(motion(a, b, c), d, j, k).at(1.0);
        s_curve(motion(a, b, c), d, j, k, l).at(1.0);
    }
}

/// Biagiotti & Melchiorri 2008, example 3.9 and equations (3.31) to (3.33): times of the seven pieces.
#[test]
fn times_are_those_of_the_textbook() {
    let trapezoidal = |h: f64, v: f64, a: f64| if h >= v * v / a { h / v + v / a } else { 2.0 * (h / a).sqrt() };
    for (h, v, a) in [(10.0, 5.0, 10.0), (0.3, 0.2, 0.5), (0.01, 0.2, 0.5), (50.0, 10.0, 20.0)] {
        let p = trapezoid(Motion::rest(0.0), h, v, a);
        assert!((p.duration() - trapezoidal(h, v, a)).abs() < 1e-12, "{h} {v} {a}");
    }
    // All limits reached: T = h/v + v/a + a/j. Acceleration not reached: T = h/v + 2 sqrt(v/j). Neither: 4 (h/2j)^(1/3).
    for (h, v, a, j, t) in [
        (10.0, 5.0, 10.0, 30.0, 10.0 / 5.0 + 5.0 / 10.0 + 10.0 / 30.0),
        (0.3, 0.2, 0.5, 5.0, 0.3 / 0.2 + 0.2 / 0.5 + 0.5 / 5.0),
        (10.0, 1.0, 10.0, 30.0, 10.0 + 2.0 * (1.0_f64 / 30.0).sqrt()),
        (0.001, 1.0, 10.0, 30.0, 4.0 * (0.001_f64 / 60.0).cbrt()),
    ] {
        let p = s_curve(Motion::rest(0.0), h, v, a, j);
        assert!((p.duration() - t).abs() < 1e-7, "{h} {v} {a} {j}: {} instead of {t}", p.duration());
    }
}

/// A goal that changes at every tick does not keep it from getting there.
#[test]
fn a_plan_that_is_made_anew_at_every_tick_arrives() {
    let l = Limits { speed: 0.3, acceleration: 0.6, jerk: None };
    let mut now = State::rest(Vector3::zeros());
    let mut time = 0.0_f64;
    while time < 5.0 {
        // Jitter of a tenth of a millimetre.
        let noise = Vector3::new((700.0 * time).sin(), (900.0 * time).cos(), (800.0 * time).sin()) * 1e-4;
        let goal = Vector3::new(0.4, 0.2, 0.1) + noise;
        now = Path::plan(&now, goal, &l).expect("a plan").at(1e-3);
        time += 1e-3;
        assert!(now.velocity.norm() <= l.speed * (1.0 + SLIP));
    }
    assert!((now.position - Vector3::new(0.4, 0.2, 0.1)).norm() < 2e-3, "{:?}", now);
}

/// Motions and shapes of trajectories.
const KINDS: [(Profiled, Shape); 9] = [
    (Profiled::Trapezoid, Shape::Number),
    (Profiled::Trapezoid, Shape::Vector),
    (Profiled::Trapezoid, Shape::Orientation),
    (Profiled::Trapezoid, Shape::Pose),
    (Profiled::SCurve, Shape::Number),
    (Profiled::SCurve, Shape::Vector),
    (Profiled::SCurve, Shape::Orientation),
    (Profiled::SCurve, Shape::Pose),
    (Profiled::Waypoints, Shape::Vector),
];

/// Speed, acceleration and jerk of the trajectories, per s, s^2 and s^3.
const LIMITS: [f64; 3] = [0.4, 0.8, 5.0];

/// A trajectory with the numbers that it reads: those of its goals, limits and start, in this order.
struct Driven {
    program: TrajectoryProgram,
    numbers: Vec<f64>,
    follower: Follower,
}

impl Driven {
    fn new(motion: Profiled, shape: Shape) -> Driven {
        let turned = UnitQuaternion::from_euler_angles(0.3, -0.5, 0.9);
        let (start, goal): (Vec<f64>, Vec<f64>) = match shape {
            Shape::Number => (vec![0.2], vec![1.1]),
            Shape::Vector if motion == Profiled::Waypoints => {
                (vec![0.0; 3], vec![0.5, 0.0, 0.0, 0.5, 0.4, 0.0, 0.6, 0.8, 0.2])
            }
            Shape::Vector => (vec![0.0; 3], vec![0.6, -0.4, 0.5]),
            Shape::Orientation => (vec![1.0, 0.0, 0.0, 0.0], vec![turned.w, turned.i, turned.j, turned.k]),
            Shape::Pose => {
                (vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], vec![0.6, -0.4, 0.5, turned.w, turned.i, turned.j, turned.k])
            }
        };
        let of = match motion {
            Profiled::Trapezoid => LIMITS[..2].to_vec(),
            Profiled::SCurve => LIMITS.to_vec(),
            Profiled::Waypoints => vec![LIMITS[0], LIMITS[1], 0.05, 0.0],
        };
        let limits = if shape == Shape::Pose { [of.clone(), of].concat() } else { of };
        let (g, l, s) = (goal.len(), limits.len(), start.len());
        let program = TrajectoryProgram {
            motion,
            shape,
            at: 0,
            goals: (0..g).collect(),
            limits: (g..g + l).collect(),
            start: (g + l..g + l + s).collect(),
            velocity: Vec::new(),
            turn: false,
        };
        assert_eq!(l, program.limit_count());
        Driven { follower: Follower::new(&program), program, numbers: [goal, limits, start].concat() }
    }

    /// Value and rates at a time, with a share of the speeds.
    fn at(&mut self, time: f64, share: f64) -> (Vec<f64>, Vec<f64>) {
        let first = self.program.goals.len();
        let of_pose = self.program.limits.len() / 2;
        let mut numbers = self.numbers.clone();
        numbers[first] *= share;
        if self.program.shape == Shape::Pose {
            numbers[first + of_pose] *= share;
        }
        let width = self.program.shape.width();
        let mut out = vec![0.0; 2 * width];
        self.follower.at(time, &self.program, |op| numbers[op], &mut out);
        let rates = out.split_off(width);
        (out, rates)
    }

    /// The goal, of a route its last point.
    fn goal(&self) -> &[f64] {
        let end = self.program.goals.len();
        &self.numbers[end - self.program.shape.width()..end]
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Norms of a position and of a rotation: the rate of a quaternion is half the angular velocity.
fn parts(shape: Shape, rates: &[f64]) -> Vec<f64> {
    match shape {
        Shape::Number | Shape::Vector => vec![norm(rates)],
        Shape::Orientation => vec![2.0 * norm(rates)],
        Shape::Pose => vec![norm(&rates[..3]), 2.0 * norm(&rates[3..])],
    }
}

/// A feed override that goes down to zero, slowly or at once, and up again.
#[test]
fn a_speed_of_zero_is_a_pause() {
    let slowly = |t: f64| if t < 2.0 { (2.0 * (1.5 - t)).clamp(0.0, 1.0) } else { (2.0 * (t - 4.0)).clamp(0.0, 1.0) };
    let at_once = |t: f64| if (1.0..4.0).contains(&t) { 0.0 } else { 1.0 };
    let from_the_start = |t: f64| if t < 4.0 { 0.0 } else { 0.7 };
    let shares: [(&str, &dyn Fn(f64) -> f64); 3] =
        [("slowly", &slowly), ("at once", &at_once), ("from the start", &from_the_start)];
    let dt = 2e-3;
    for (motion, shape) in KINDS {
        for (name, share) in shares {
            let text = format!("{motion:?} of {shape:?}, {name}");
            let mut driven = Driven::new(motion, shape);
            let mut before: Option<(Vec<f64>, Vec<f64>)> = None;
            let mut stood = None;
            for k in 0..10_000 {
                let time = f64::from(k) * dt;
                let (value, rates) = driven.at(time, share(time));
                assert!(value.iter().chain(&rates).all(|x| x.is_finite()), "{text}: {time}");
                // From full speed it comes to rest in 0.4/0.8 s, with the jerk 0.4/0.8 + 0.8/5 s, and 0.16 s more to release
                // an acceleration.
                if (2.0..=4.0).contains(&time) {
                    assert!(rates.iter().all(|v| *v == 0.0), "{text}: {rates:?} at {time}");
                    assert!(!driven.follower.is_done(), "{text}: {time}");
                    assert_eq!(*stood.get_or_insert(value.clone()), value, "{text}: {time}");
                }
                if let Some((x, v)) = &before {
                    let way: Vec<f64> = value.iter().zip(x).map(|(a, b)| (a - b) / dt).collect();
                    let mean: Vec<f64> = rates.iter().zip(v).map(|(a, b)| (a + b) / 2.0).collect();
                    let slip: Vec<f64> = way.iter().zip(&mean).map(|(a, b)| a - b).collect();
                    assert!(
                        parts(shape, &slip).iter().all(|x| *x < 2.0 * LIMITS[1] * dt),
                        "{text}: {slip:?} at {time}"
                    );
                    let change: Vec<f64> = rates.iter().zip(v).map(|(a, b)| (a - b) / dt).collect();
                    // The rate of a quaternion also changes because it turns: by at most half the square of the speed.
                    let most = LIMITS[1] * (1.0 + 1e-6) + if shape.width() > 3 { LIMITS[0] * LIMITS[0] } else { 0.0 };
                    assert!(parts(shape, &change).iter().all(|a| *a <= most + 1e-9), "{text}: {change:?} at {time}");
                }
                assert!(parts(shape, &rates).iter().all(|v| *v <= LIMITS[0] * (1.0 + 1e-6)), "{text}: {rates:?}");
                before = Some((value, rates));
            }
            assert!(driven.follower.is_done(), "{text}");
            let end = before.expect("it ran").0;
            let alike = |sign: f64| end.iter().zip(driven.goal()).all(|(a, b)| (sign * a - b).abs() < 1e-9);
            assert!(alike(1.0) || alike(-1.0), "{text}: {end:?}");
        }
    }
}

/// A trajectory at its goal stays done while its speed is zero, and a new goal waits for the speed.
#[test]
fn a_speed_of_zero_at_the_goal_changes_nothing() {
    for (motion, shape) in KINDS {
        let mut driven = Driven::new(motion, shape);
        for k in 0..4000 {
            driven.at(f64::from(k) * 2e-3, 1.0);
        }
        assert!(driven.follower.is_done());
        let there = driven.at(8.0, 0.0).0;
        assert!(driven.follower.is_done(), "{motion:?} of {shape:?}");
        driven.numbers[0] += 0.1;
        assert_eq!(driven.at(8.002, 0.0).0, there, "{motion:?} of {shape:?}");
        assert!(!driven.follower.is_done(), "{motion:?} of {shape:?}");
    }
}

#[test]
fn a_speed_that_is_none_has_no_value() {
    for (motion, shape) in KINDS {
        for bad in [-1.0, -1e-300, f64::NAN, f64::INFINITY] {
            for before in [None, Some(1.0), Some(0.0)] {
                let mut driven = Driven::new(motion, shape);
                if let Some(share) = before {
                    assert!(driven.at(0.0, share).0.iter().all(|x| x.is_finite()));
                }
                for time in [0.002, 0.004] {
                    assert!(driven.at(time, bad).0.iter().all(|x| x.is_nan()), "{motion:?} of {shape:?}: {bad}");
                }
            }
        }
    }
}

proptest! {
    /// Braking along the velocity, in the time and over the distance of the textbook.
    #[test]
    fn a_stop_keeps_its_limits(from in vector(1.0), v in vector(1.0), a in 0.2..3.0, jerk in prop::option::of(1.0..30.0)) {
        let l = Limits { speed: 0.0, acceleration: a, jerk };
        let start = State { velocity: v, ..State::rest(from) };
        let path = Path::stop(&start, &l).expect("a plan");
        bounded(path.duration(), |t| path.at(t), &l, v.norm())?;
        let speed = v.norm();
        let time = match jerk {
            None => speed / a,
            Some(j) if speed * j < a * a => 2.0 * (speed / j).sqrt(),
            Some(j) => speed / a + a / j,
        };
        // The profile of a stop is point symmetric.
        let end = from + v * (time / 2.0);
        prop_assert!((path.duration() - time).abs() <= 1e-9 * (1.0 + time), "{} and {time}", path.duration());
        prop_assert!((path.at(time + 1.0).position - end).norm() <= 1e-9);
        prop_assert_eq!(path.at(time + 1.0), State::rest(path.goal()));
    }
}
