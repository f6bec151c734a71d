//! Motion of a vector over several points: straight lines, with rounded corners or halts between, and rest at the end.
//!
//! A corner with the directions `e` before and `g` behind it is rounded by a parabola, that is by constant acceleration
//! from `u e` to `u g` (Biagiotti & Melchiorri 2008, 3.6: linear segments with parabolic blends). With the full
//! acceleration it takes `u k / A` seconds, with `k = |g - e|`. It begins and ends `u² k / 2A` from the corner, and
//! passes it at the distance `u² k² / 8A`. The speed `u` is the largest that keeps the distance within `corner`, keeps
//! the rounding within half of each line beside it, and can be reached and left on the lines before and behind.
//!
//! An initial motion that is slower than a twentieth of the speed is added to the route and braked meanwhile. It takes
//! its own speed and a twentieth of the acceleration from the limits, and the route uses the rest of both. A faster
//! initial motion is brought to rest at the first point.

use nalgebra::Vector3;

use super::limits::Limits;
use super::path::{Path, State};
use super::profile::Profile;
use super::trapezoid::along;

/// Share of the limits that an initial motion may take.
const SLOW: f64 = 0.05;

/// Motion that is braked to rest: its initial velocity and its duration.
#[derive(Clone, Copy, Debug, Default)]
struct Drift {
    velocity: Vector3<f64>,
    duration: f64,
}

impl Drift {
    /// State relative to its end.
    fn at(&self, t: f64) -> State {
        if t >= self.duration {
            return State::default();
        }
        let left = 1.0 - t / self.duration;
        State {
            position: self.velocity * (-0.5 * self.duration * left * left),
            velocity: self.velocity * left,
            acceleration: self.velocity / -self.duration,
        }
    }
}

/// Part of a route.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "planned anew inside the loop, where nothing may be boxed")]
enum Way {
    /// Motion along a straight line.
    Line { origin: Vector3<f64>, direction: Vector3<f64>, profile: Profile },
    /// Motion with constant acceleration.
    Corner(State),
    /// Rest at a point.
    Halt(Vector3<f64>),
    /// Motion from the initial state to the first point.
    Free(Path),
}

#[derive(Clone, Copy, Debug)]
struct Leg {
    start: f64,
    /// Index of the point that it leads to.
    to: usize,
    way: Way,
}

/// Corner between two lines: its speed, and its sharpness `k`.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    speed: f64,
    sharpness: f64,
}

/// Motion over several points to rest at the last one.
#[derive(Clone, Debug)]
pub struct Route {
    legs: Vec<Leg>,
    corners: Vec<Corner>,
    nodes: Vec<Vector3<f64>>,
    duration: f64,
    goal: Vector3<f64>,
    drift: Drift,
}

/// Options of a route.
#[derive(Clone, Copy, Debug)]
pub struct RouteOptions {
    /// Limits of the motion.
    pub limits: Limits,
    /// Largest distance between a corner and its rounding.
    pub corner: f64,
    /// Time of rest at each inner point, in s; 0 for none.
    pub halt: f64,
}

impl Route {
    /// Creates a route with room for so many points.
    pub fn new(points: usize) -> Route {
        Route {
            legs: Vec::with_capacity(3 * points + 2),
            corners: Vec::with_capacity(points + 1),
            nodes: Vec::with_capacity(points + 1),
            duration: 0.0,
            goal: Vector3::zeros(),
            drift: Drift::default(),
        }
    }

    /// Plans a route from a state over `points`, the first of which is number `first`. Corners are rounded, or
    /// the motion rests at each inner point if `halt` is positive. From a state in
    /// motion that is not slow, it comes to rest at the first point. `false` if there is no plan, as for
    /// [`Path::plan`]; the former plan is then lost. Never allocates for as many points as there is room for.
    pub fn plan(&mut self, from: &State, points: &[Vector3<f64>], first: usize, options: &RouteOptions) -> bool {
        let RouteOptions { limits, corner, halt } = *options;
        self.legs.clear();
        self.nodes.clear();
        self.corners.clear();
        self.duration = 0.0;
        self.drift = Drift::default();
        let Some(&goal) = points.last() else { return false };
        let numbers = points.iter().flatten().chain(from.position.iter()).chain(from.velocity.iter());
        let sound = numbers.copied().chain([corner, halt]).all(f64::is_finite) && corner >= 0.0 && halt >= 0.0;
        if !sound || !limits.are_sound() || points.len() > self.nodes.capacity() {
            return false;
        }
        self.goal = goal;
        let mut index = first;
        let (mut here, mut rest) = (from.position, points);
        let (speed, mut limits) = (from.velocity.norm(), limits);
        if speed <= SLOW * limits.speed {
            if speed > 0.0 {
                self.drift = Drift { velocity: from.velocity, duration: speed / (SLOW * limits.acceleration) };
                here += from.velocity * (0.5 * self.drift.duration);
                limits.acceleration *= 1.0 - SLOW;
                limits.speed -= speed;
            }
        } else {
            let Some(path) = Path::plan(from, points[0], &limits) else { return false };
            self.push(index, path.duration(), Way::Free(path));
            (here, rest, index) = (points[0], &points[1..], index + 1);
            if halt > 0.0 && !rest.is_empty() {
                self.push(index, halt, Way::Halt(here));
            }
        }
        self.nodes.push(here);
        self.nodes.extend_from_slice(rest);
        self.round(&limits, corner, halt);
        self.walk(index, &limits, halt);
        self.duration().is_finite()
    }

    /// Plans to come to rest at once on the way to `points`, the first of which is number `first`. `false` as for
    /// [`Path::stop`]; the former plan is then lost. Never allocates.
    pub fn stop(&mut self, from: &State, points: &[Vector3<f64>], first: usize, limits: &Limits) -> bool {
        self.legs.clear();
        (self.duration, self.drift) = (0.0, Drift::default());
        let Some(path) = Path::stop(from, limits) else { return false };
        // Braking before a flat corner may end behind the point: the motion then goes on to the next one.
        let passed = |point: &Vector3<f64>| (point - path.goal()).dot(&from.velocity) < 0.0;
        let to = if points.len() > 1 && passed(&points[0]) { first + 1 } else { first };
        self.push(to, path.duration(), Way::Free(path));
        self.goal = path.goal();
        true
    }

    /// Computes the speed at each corner.
    fn round(&mut self, limits: &Limits, size: f64, halt: f64) {
        let (nodes, a) = (&self.nodes, limits.acceleration);
        let lines = nodes.len() - 1;
        let length = |i: usize| (nodes[i + 1] - nodes[i]).norm();
        let direction = |i: usize| (nodes[i + 1] - nodes[i]).try_normalize(0.0);
        for i in 0..=lines {
            let ends = i == 0 || i == lines || halt > 0.0 || size <= 0.0;
            let corner = match (!ends).then(|| direction(i - 1).zip(direction(i))).flatten() {
                Some((e, g)) => {
                    let k = (g - e).norm();
                    let near = length(i - 1).min(length(i));
                    let most =
                        if k > 0.0 { ((8.0 * size * a).sqrt() / k).min((a * near / k).sqrt()) } else { f64::INFINITY };
                    Corner { speed: most.min(limits.speed), sharpness: k }
                }
                None => Corner::default(),
            };
            self.corners.push(corner);
        }
        // Condition of a line of length L: u² - 2 A (L - u² k/2A - l) is at most the square of the speed at its other
        // end.
        let room = |c: &Corner| c.speed * c.speed * c.sharpness / (2.0 * a);
        for i in 0..lines {
            let before = self.corners[i];
            let most = before.speed.powi(2) + 2.0 * a * (length(i) - room(&before));
            let next = &mut self.corners[i + 1];
            next.speed = next.speed.min((most / (1.0 + next.sharpness)).max(0.0).sqrt());
        }
        for i in (0..lines).rev() {
            let next = self.corners[i + 1];
            let most = next.speed.powi(2) + 2.0 * a * (length(i) - room(&next));
            let before = &mut self.corners[i];
            before.speed = before.speed.min((most / (1.0 + before.sharpness)).max(0.0).sqrt());
        }
    }

    /// Adds the legs over all nodes, at rest at the first and last.
    fn walk(&mut self, first: usize, limits: &Limits, halt: f64) {
        let a = limits.acceleration;
        for i in 0..self.nodes.len() - 1 {
            let (from, to) = (self.nodes[i], self.nodes[i + 1]);
            let (before, next) = (self.corners[i], self.corners[i + 1]);
            let room = |c: &Corner| c.speed * c.speed * c.sharpness / (2.0 * a);
            let Some(e) = (to - from).try_normalize(0.0) else { continue };
            let length = ((to - from).norm() - room(&before) - room(&next)).max(0.0);
            let profile = along(length, before.speed, next.speed, limits.speed, a);
            let line = Way::Line { origin: from + e * room(&before), direction: e, profile };
            self.push(first + i, profile.duration(), line);
            let last = i + 2 >= self.nodes.len();
            if last {
                continue;
            }
            if next.speed > 0.0 && next.sharpness > 0.0 {
                let g = (self.nodes[i + 2] - to).try_normalize(0.0).unwrap_or(e);
                let start = State {
                    position: to - e * room(&next),
                    velocity: e * next.speed,
                    acceleration: (g - e) * (a / next.sharpness),
                };
                self.push(first + i + 1, next.speed * next.sharpness / a, Way::Corner(start));
            } else if halt > 0.0 {
                self.push(first + i + 1, halt, Way::Halt(to));
            }
        }
    }

    fn push(&mut self, to: usize, duration: f64, way: Way) {
        if self.legs.len() < self.legs.capacity() {
            self.legs.push(Leg { start: self.duration, to, way });
            self.duration += duration;
        }
    }

    /// Duration, in s.
    pub fn duration(&self) -> f64 {
        self.duration.max(self.drift.duration)
    }

    fn leg(&self, t: f64) -> Option<&Leg> {
        self.legs[..self.legs.partition_point(|l| l.start <= t)].last().or(self.legs.first())
    }

    /// Number of the point that it moves to at a time since the beginning, in s.
    pub fn toward(&self, t: f64) -> Option<usize> {
        self.leg(t).map(|l| l.to)
    }

    /// State at a time since the beginning, in s.
    pub fn at(&self, t: f64) -> State {
        let (on, drift) = (self.on(t), self.drift.at(t));
        State {
            position: on.position + drift.position,
            velocity: on.velocity + drift.velocity,
            acceleration: on.acceleration + drift.acceleration,
        }
    }

    /// State on the legs, without the drift.
    fn on(&self, t: f64) -> State {
        let Some(leg) = self.leg(t).filter(|_| t < self.duration) else { return State::rest(self.goal) };
        let t = t - leg.start;
        match &leg.way {
            Way::Line { origin, direction, profile } => {
                let now = profile.at(t);
                State {
                    position: origin + direction * now.position,
                    velocity: direction * now.velocity,
                    acceleration: direction * now.acceleration,
                }
            }
            Way::Corner(State { position, velocity, acceleration }) => State {
                position: position + (velocity + acceleration * (t / 2.0)) * t,
                velocity: velocity + acceleration * t,
                acceleration: *acceleration,
            },
            Way::Halt(point) => State::rest(*point),
            Way::Free(path) => path.at(t),
        }
    }
}
