//! Motion of a vector of up to three numbers to rest at a goal, with bounded norms of velocity, acceleration and jerk.
//!
//! From rest, and for a motion that is already on the line to the goal, the path is that straight line, with the
//! profile of one number along it. Otherwise the motion is the sum of two, each with the profile of one number: along
//! the direction `e` to the goal, and along the component `f` of the velocity perpendicular to it. They share the
//! acceleration (and jerk) as `A cos c` and `A sin c`, so that the norm is bounded by `A`. Since the perpendicular
//! speed never exceeds its initial value `|w|`, the speed along `e` may reach `sqrt(V² - w²)`. For trapezoids the angle
//! `c` is first the one for which both parts take the same time, which is the shortest for this sum; it is then widened
//! until the part along `e` takes a tenth longer, for a tighter turn. For S-curves `sin² c` is half the ratio of `|w|`
//! to the speed, in closed form.
//!
//! Further segments may come before that: braking along the velocity, if the speed exceeds `V` or its perpendicular
//! component exceeds `V / sqrt 2`; and for S-curves a segment of `|a| / J` seconds that reduces the acceleration to zero
//! along its own direction. To keep the speed bounded in that segment, parts along `e` leave `A²/(8 J)` of the speed
//! unused. Source: ours.

use nalgebra::Vector3;

use super::limits::Limits;
use super::profile::{Motion, Profile};
use super::s_curve::s_curve;
use super::trapezoid::{duration, trapezoid};

/// Relative size of a perpendicular velocity that counts as rounding error.
const STRAIGHT: f64 = 1e-9;

/// Number of halvings in the search for the speed that takes a given time.
const HALVINGS: usize = 24;

/// Number of halvings of the range of angles that share the acceleration; every angle is valid.
const SHARES: usize = 12;

/// Factor on the duration of the part along the direction to the goal, for a tighter turn.
const LONGER: f64 = 1.1;

/// Position and motion of a vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// The vector.
    pub position: Vector3<f64>,
    /// Its velocity, per s.
    pub velocity: Vector3<f64>,
    /// Its acceleration, per s^2.
    pub acceleration: Vector3<f64>,
}

impl State {
    /// State of rest.
    pub fn rest(position: Vector3<f64>) -> State {
        State { position, ..State::default() }
    }
}

/// Motions of two numbers, each along a vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Segment {
    start: f64,
    origin: Vector3<f64>,
    axes: [Vector3<f64>; 2],
    along: [Profile; 2],
}

impl Segment {
    fn duration(&self) -> f64 {
        self.along[0].duration().max(self.along[1].duration())
    }

    fn at(&self, t: f64) -> State {
        let (a, b) = (self.along[0].at(t), self.along[1].at(t));
        let [e, f] = self.axes;
        State {
            position: self.origin + e * a.position + f * b.position,
            velocity: e * a.velocity + f * b.velocity,
            acceleration: e * a.acceleration + f * b.acceleration,
        }
    }
}

/// Motion of a vector to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Path {
    segments: [Segment; 3],
    count: usize,
    duration: f64,
    goal: Vector3<f64>,
}

/// Profile of one number to rest.
fn profile(from: Motion, goal: f64, limits: &Limits) -> Profile {
    match limits.jerk {
        Some(jerk) => s_curve(from, goal, limits.speed, limits.acceleration, jerk),
        None => trapezoid(from, goal, limits.speed, limits.acceleration),
    }
}

/// Direction of a vector; `None` if the vector is almost zero.
fn direction(v: &Vector3<f64>) -> Option<Vector3<f64>> {
    let size = v.amax();
    (size > 1e-150).then(|| (v / size).normalize())
}

/// Returns true if a vector has no component perpendicular to a direction.
fn is_along(v: &Vector3<f64>, e: &Vector3<f64>) -> bool {
    (v - e * v.dot(e)).norm() <= STRAIGHT * v.norm()
}

impl Path {
    /// Path that stays at rest.
    pub fn rest(position: Vector3<f64>) -> Path {
        Path { goal: position, ..Path::default() }
    }

    /// Plans a path from a state to rest at `goal`. `None` for limits that are not positive and finite, and for numbers
    /// that are not finite or whose squares are not.
    pub fn plan(from: &State, goal: Vector3<f64>, limits: &Limits) -> Option<Path> {
        let mut path = Path::rest(goal);
        if !limits.are_sound() || !goal.iter().chain(from.position.iter()).all(|x| x.is_finite()) {
            return None;
        }
        let (mut now, mut start) = (*from, 0.0);
        if limits.jerk.is_none() {
            now.acceleration = Vector3::zeros();
        }
        if let Some(e) = line(&now, &goal) {
            path.push(straight(&now, &goal, e, limits), &mut start);
        } else {
            if let (Some(jerk), Some(e)) = (limits.jerk, direction(&now.acceleration)) {
                now = path.push(release(&now, e, jerk), &mut start);
            }
            if let Some(segment) = brake(&now, &goal, limits) {
                now = path.push(segment, &mut start);
            }
            let last = match line(&now, &goal) {
                Some(e) => straight(&now, &goal, e, limits),
                None => turn(&now, &goal, limits),
            };
            path.push(last, &mut start);
        }
        path.duration = start;
        path.is_finite().then_some(path)
    }

    /// Plans to come to rest at once, by braking along the velocity, which is where the path ends; for S-curves the
    /// acceleration is first reduced to zero. `None` for limits that do not [`Limits::stop`], and for numbers that are not
    /// finite or whose squares are not.
    pub fn stop(from: &State, limits: &Limits) -> Option<Path> {
        if !limits.stop() || !from.position.iter().all(|x| x.is_finite()) {
            return None;
        }
        let (mut path, mut now, mut start) = (Path::default(), *from, 0.0);
        if limits.jerk.is_none() {
            now.acceleration = Vector3::zeros();
        }
        if let (Some(jerk), Some(e)) = (limits.jerk, direction(&now.acceleration)) {
            now = path.push(release(&now, e, jerk), &mut start);
        }
        let position = now.position;
        if let Some(segment) = brake(&now, &position, &Limits { speed: 0.0, ..*limits }) {
            now = path.push(segment, &mut start);
        }
        (path.goal, path.duration) = (now.position, start);
        (path.is_finite() && path.goal.iter().all(|x| x.is_finite())).then_some(path)
    }

    fn is_finite(&self) -> bool {
        self.segments[..self.count].iter().all(|s| {
            s.along.iter().all(Profile::is_finite)
                && s.origin.iter().chain(s.axes.iter().flatten()).all(|x| x.is_finite())
        })
    }

    /// Plans the same motion in a time as close to `duration` as possible without going faster.
    pub fn within(from: &State, goal: Vector3<f64>, limits: &Limits, duration: f64) -> Option<Path> {
        let shortest = Path::plan(from, goal, limits)?;
        if !(duration > shortest.duration && shortest.duration > 0.0) {
            return Some(shortest);
        }
        if from.velocity == Vector3::zeros() && from.acceleration == Vector3::zeros() {
            // From rest, the same path with slower limits takes exactly that time.
            return Path::plan(from, goal, &limits.slower(duration / shortest.duration));
        }
        let (mut slow, mut fast, mut best) = (0.0, 1.0, shortest);
        for _ in 0..HALVINGS {
            let share = 0.5 * (slow + fast);
            let path = Path::plan(from, goal, &Limits { speed: limits.speed * share, ..*limits })?;
            if path.duration > duration {
                slow = share;
            } else {
                (fast, best) = (share, path);
            }
        }
        Some(best)
    }

    /// Returns true if a plan from a state would first have to reduce the acceleration to zero.
    pub fn must_release(from: &State, goal: &Vector3<f64>, limits: &Limits) -> bool {
        limits.jerk.is_some() && from.acceleration != Vector3::zeros() && line(from, goal).is_none()
    }

    fn push(&mut self, segment: Segment, start: &mut f64) -> State {
        let duration = segment.duration();
        if let Some(place) = self.segments.get_mut(self.count) {
            *place = Segment { start: *start, ..segment };
            self.count += 1;
            *start += duration;
        }
        segment.at(duration)
    }

    /// Duration, in s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Goal at which it ends.
    pub fn goal(&self) -> Vector3<f64> {
        self.goal
    }

    /// State at a time since the beginning, in s.
    pub fn at(&self, t: f64) -> State {
        if t >= self.duration {
            return State::rest(self.goal);
        }
        let segments = &self.segments[..self.count];
        let segment = segments.iter().rev().find(|s| t >= s.start).or(segments.first());
        segment.map_or(State::rest(self.goal), |s| s.at(t - s.start))
    }
}

/// Direction of the line that contains both the motion and the goal, if there is one.
fn line(now: &State, goal: &Vector3<f64>) -> Option<Vector3<f64>> {
    let e = direction(&(goal - now.position)).or(direction(&now.velocity)).or(direction(&now.acceleration));
    let e = e.unwrap_or_else(Vector3::x);
    (is_along(&now.velocity, &e) && is_along(&now.acceleration, &e)).then_some(e)
}

/// Motion along a line.
fn straight(now: &State, goal: &Vector3<f64>, e: Vector3<f64>, limits: &Limits) -> Segment {
    let from = Motion { position: 0.0, velocity: now.velocity.dot(&e), acceleration: now.acceleration.dot(&e) };
    let along = profile(from, (goal - now.position).norm(), limits);
    Segment { start: 0.0, origin: now.position, axes: [e, Vector3::zeros()], along: [along, Profile::rest(0.0)] }
}

/// Reduces the acceleration to zero along its own direction `e`.
fn release(now: &State, e: Vector3<f64>, jerk: f64) -> Segment {
    let size = now.acceleration.dot(&e);
    let mut slower = Profile::from(Motion { position: 0.0, velocity: 0.0, acceleration: size });
    slower.jerk(size / jerk, -jerk);
    let end = slower.end();
    let slower = slower.ending(Motion { acceleration: 0.0, ..end });
    let mut on = Profile::from(Motion { position: 0.0, velocity: 1.0, acceleration: 0.0 });
    on.then(slower.duration(), 0.0, 0.0);
    Segment { start: 0.0, origin: now.position, axes: [e, now.velocity], along: [slower, on] }
}

/// Brakes along the velocity if the speed or its component perpendicular to the goal is too large. The acceleration is
/// zero.
fn brake(now: &State, goal: &Vector3<f64>, limits: &Limits) -> Option<Segment> {
    let e = direction(&now.velocity)?;
    let speed = now.velocity.dot(&e);
    let across = direction(&(goal - now.position)).map_or(0.0, |d| (now.velocity - d * now.velocity.dot(&d)).norm());
    let slow = limits.speed * std::f64::consts::FRAC_1_SQRT_2;
    let to = if across > slow * (1.0 + STRAIGHT) { slow } else { limits.speed };
    if speed <= to * (1.0 + STRAIGHT) {
        return None;
    }
    let mut braking = Profile::from(Motion { position: 0.0, velocity: speed, acceleration: 0.0 });
    match limits.jerk {
        None => braking.then((speed - to) / limits.acceleration, -limits.acceleration, 0.0),
        Some(jerk) => {
            let peak = (jerk * (speed - to)).sqrt().min(limits.acceleration);
            braking.jerk(peak / jerk, -jerk);
            braking.jerk(((speed - to) / peak - peak / jerk).max(0.0), 0.0);
            braking.jerk(peak / jerk, jerk);
        }
    }
    let end = braking.end();
    let along = [braking.ending(Motion { velocity: to, acceleration: 0.0, ..end }), Profile::rest(0.0)];
    Some(Segment { start: 0.0, origin: now.position, axes: [e, Vector3::zeros()], along })
}

/// Two motions, along the direction to the goal and perpendicular to it. The acceleration is zero.
fn turn(now: &State, goal: &Vector3<f64>, limits: &Limits) -> Segment {
    let way = goal - now.position;
    let e = direction(&way).or(direction(&now.velocity)).unwrap_or_else(Vector3::x);
    let ahead = now.velocity.dot(&e);
    let across = now.velocity - e * ahead;
    let w = across.norm();
    let f = direction(&across).unwrap_or_else(Vector3::zeros);
    let motion = |velocity: f64| Motion { position: 0.0, velocity, acceleration: 0.0 };
    let free = (limits.speed * limits.speed - w * w).max(0.0).sqrt().max(ahead.abs());
    let both = |speed: f64, angle: f64| {
        let (sin, cos) = angle.sin_cos();
        // The perpendicular speed never exceeds its present value.
        let along = profile(motion(ahead), way.norm(), &limits.share(speed, cos));
        [along, profile(motion(w), 0.0, &limits.share(limits.speed, sin))]
    };
    let along = match limits.jerk {
        Some(jerk) => {
            let peak = limits.acceleration.min((limits.speed * jerk).sqrt());
            let sin = (0.5 * w / now.velocity.norm()).sqrt().min(std::f64::consts::FRAC_1_SQRT_2);
            both(free - peak * peak / (8.0 * jerk), sin.asin())
        }
        None => {
            let distance = way.norm();
            let times = |angle: f64| {
                let (sin, cos) = angle.sin_cos();
                let along = duration(distance, ahead, free, limits.acceleration * cos);
                [along, duration(0.0, w, limits.speed, limits.acceleration * sin)]
            };
            let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
            for _ in 0..SHARES {
                let middle = 0.5 * (low + high);
                let [along, across] = times(middle);
                if along < across { low = middle } else { high = middle }
            }
            let longest = LONGER * times(high)[0];
            let (mut least, mut most) = (high, std::f64::consts::FRAC_PI_2);
            for _ in 0..SHARES / 2 {
                let middle = 0.5 * (least + most);
                if times(middle)[0] <= longest { least = middle } else { most = middle }
            }
            both(free, least)
        }
    };
    Segment { start: 0.0, origin: now.position, axes: [e, f], along }
}
