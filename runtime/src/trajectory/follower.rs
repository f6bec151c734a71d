//! Trajectory at run time. It starts from a given state when its stack is entered, and is planned again from its
//! present state, including its velocity, whenever its goal or a limit changes.
//!
//! Between two plans it is a function of time: a second evaluation at the same time changes nothing. A moving S-curve
//! whose new goal does not lie ahead must first reduce its acceleration to zero. Such a goal is accepted at most once
//! in `2 A/J` seconds, so that a goal that changes at every tick does not keep the trajectory from gaining speed.
//!
//! While its speed is zero, it brakes along its velocity, stands still, and goes on to its goal from there as soon as the
//! speed is positive. A pose does so while one of its two speeds is zero.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use robot::nearest_turn;

use super::limits::Limits;
use super::path::{Path, State};
use super::rotation::{Turn, Turning, quaternion_rate};
use super::route::{Route, RouteOptions};
use crate::program::{Motion, Shape, TrajectoryProgram};

/// Present plan.
#[expect(clippy::large_enum_variant, reason = "planned anew inside the loop, where nothing may be boxed")]
enum Plan {
    Vector(Path),
    Orientation(Turn),
    Pose(Path, Turn),
    /// The route, and storage for the next one.
    Route(Box<(Route, Route)>),
}

/// A trajectory at run time.
pub struct Follower {
    motion: Motion,
    shape: Shape,
    /// True for an angle that moves to its goal by the nearest turn.
    turn: bool,
    /// Number of numbers of the goal, or of all points one after the other.
    goals: usize,
    /// Present goal and limits, and those at the time of planning.
    now: Vec<f64>,
    planned: Vec<f64>,
    /// Points of the route, from the numbers.
    points: Vec<Vector3<f64>>,
    plan: Plan,
    /// Time of planning, in s; `None` before the start.
    since: Option<f64>,
    /// Time of the last evaluation, in s.
    last: f64,
    /// True if there was no plan for the last inputs.
    lost: bool,
    /// Stop because of a speed of zero; `None` while it moves to its goal.
    stop: Option<Stop>,
}

/// Result of planning anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Replanned {
    Yes,
    /// The former plan is kept for now.
    Later,
    /// There is no plan.
    No,
}

/// Stop because of a speed of zero.
#[derive(Clone, Copy, Debug)]
struct Stop {
    /// True if it was at rest at its goal already.
    at_goal: bool,
}

fn vector(x: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|i, _| x.get(i).copied().unwrap_or(0.0))
}

/// Orientation of the numbers `w x y z`; `None` if their length is zero.
fn orientation(x: &[f64]) -> Option<UnitQuaternion<f64>> {
    let [w, i, j, k] = *x else { return None };
    UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-9).filter(|q| q.coords.iter().all(|c| c.is_finite()))
}

impl Follower {
    /// Prepares a trajectory of a checked program. All its memory is allocated here.
    pub fn new(program: &TrajectoryProgram) -> Follower {
        let width = program.goals.len() + program.limits.len();
        let points = program.goals.len() / program.shape.width();
        let still = Path::rest(Vector3::zeros());
        let turn = Turn::rest(UnitQuaternion::identity());
        Follower {
            motion: program.motion,
            shape: program.shape,
            turn: program.turn,
            goals: program.goals.len(),
            now: vec![0.0; width],
            planned: vec![0.0; width],
            points: Vec::with_capacity(points),
            plan: match (program.motion, program.shape) {
                (Motion::Waypoints, _) => Plan::Route(Box::new((Route::new(points), Route::new(points)))),
                (_, Shape::Number | Shape::Vector) => Plan::Vector(still),
                (_, Shape::Orientation) => Plan::Orientation(turn),
                (_, Shape::Pose) => Plan::Pose(still, turn),
            },
            since: None,
            last: 0.0,
            lost: false,
            stop: None,
        }
    }

    /// Resets the trajectory: it starts again at the next evaluation.
    pub fn restart(&mut self) {
        (self.since, self.lost, self.stop) = (None, false, None);
    }

    /// Lets it stand for a time (s): it is later by as much from then on.
    pub fn wait(&mut self, time: f64) {
        self.since.iter_mut().for_each(|since| *since += time);
    }

    /// Returns true if it is at rest at its present goal.
    pub fn is_done(&self) -> bool {
        self.has_ended() && !self.lost && self.now == self.planned && self.stop.is_none_or(|stop| stop.at_goal)
    }

    /// Returns true if the present plan has ended.
    fn has_ended(&self) -> bool {
        let t = self.last - self.since.unwrap_or(f64::NAN);
        let duration = match &self.plan {
            Plan::Vector(path) => path.duration(),
            Plan::Orientation(turn) => turn.duration(),
            Plan::Pose(path, turn) => path.duration().max(turn.duration()),
            Plan::Route(routes) => routes.0.duration(),
        };
        t >= duration
    }

    /// Evaluates the trajectory at a time. `read` returns results of the tape's operations. `out` receives the value
    /// and its time derivative, NaN if there is no plan. Never allocates.
    pub fn at(&mut self, time: f64, program: &TrajectoryProgram, read: impl Fn(usize) -> f64, out: &mut [f64]) {
        for (x, &op) in self.now.iter_mut().zip(program.goals.iter().chain(&program.limits)) {
            *x = read(op);
        }
        self.last = time;
        self.lost = match self.since {
            None => {
                let mut numbers = [0.0; 13];
                for (x, &op) in numbers.iter_mut().zip(program.start.iter().chain(&program.velocity)) {
                    *x = read(op);
                }
                !numbers.iter().all(|x| x.is_finite()) || !self.begin(time, numbers)
            }
            Some(since) if self.now != self.planned => !self.change(time, (time - since).max(0.0)),
            Some(_) => false,
        };
        match self.since {
            Some(since) if !self.lost => self.write((time - since).max(0.0), out),
            _ => out.fill(f64::NAN),
        }
    }

    fn limits(&self, first: usize) -> Limits {
        let l = self.now.get(self.goals + first..).unwrap_or_default();
        let number = |i: usize| l.get(i).copied().unwrap_or(f64::NAN);
        Limits { speed: number(0), acceleration: number(1), jerk: (self.motion == Motion::SCurve).then(|| number(2)) }
    }

    /// Limits of the orientation of a pose.
    fn angular(&self) -> Limits {
        self.limits(if self.motion == Motion::SCurve { 3 } else { 2 })
    }

    /// Returns true if a speed of zero stops it.
    fn stands(&self) -> bool {
        self.limits(0).stop() || (self.shape == Shape::Pose && self.angular().stop())
    }

    /// Returns true if the goal, or a point of the route, differs from that of the last plan.
    fn has_new_goal(&self) -> bool {
        self.now[..self.goals] != self.planned[..self.goals]
    }

    /// Starts from the value at the front of `numbers`, with the velocity that follows it. `false` if there is no plan.
    fn begin(&mut self, time: f64, numbers: [f64; 13]) -> bool {
        let width = self.shape.width();
        let (value, velocity) = numbers.split_at(width);
        let state =
            |p: &[f64], v: &[f64]| State { position: vector(p), velocity: vector(v), acceleration: Vector3::zeros() };
        let turning = |q: &[f64], w: &[f64]| {
            let acceleration = Vector3::zeros();
            orientation(q).map(|orientation| Turning { orientation, velocity: vector(w), acceleration })
        };
        self.stop = self.stands().then_some(Stop { at_goal: false });
        let good = match self.shape {
            Shape::Number => self.vector(&state(&value[..1], &velocity[..1])),
            Shape::Vector if self.motion == Motion::Waypoints => self.route(&state(value, &velocity[..3]), 0),
            Shape::Vector => self.vector(&state(value, &velocity[..3])),
            Shape::Orientation => turning(value, &velocity[..3]).is_some_and(|from| self.turn(&from)),
            Shape::Pose => turning(&value[3..], &velocity[3..6])
                .is_some_and(|from| self.pose(&state(&value[..3], &velocity[..3]), &from)),
        };
        self.keep(good, time)
    }

    /// Plans again after a change of the goal or a limit, `t` seconds after the last plan. `false` if there is no plan.
    fn change(&mut self, time: f64, t: f64) -> bool {
        let (stands, new_goal, before) = (self.stands(), self.has_new_goal(), self.stop);
        if let (Some(stop), true) = (&mut self.stop, stands) {
            // A stop goes on as planned: planned anew at every tick, it would release the brake each time.
            stop.at_goal &= !new_goal;
            self.planned.copy_from_slice(&self.now);
            return self.now.iter().all(|x| x.is_finite());
        }
        let at_goal = before.is_none() && self.has_ended() && !new_goal;
        self.stop = stands.then_some(Stop { at_goal });
        // A stop does not wait, nor does the motion after it.
        let replanned = self.replan(t, stands || before.is_some());
        if replanned != Replanned::Yes {
            self.stop = before;
            return replanned == Replanned::Later;
        }
        self.keep(true, time)
    }

    /// Plans again from the state `t` seconds after the last plan.
    fn replan(&mut self, t: f64, at_once: bool) -> Replanned {
        let wait = |limits: &Limits| !at_once && limits.jerk.is_some_and(|j| t < 2.0 * limits.acceleration / j);
        let good = match &self.plan {
            Plan::Vector(path) => {
                let (from, limits) = (path.at(t), self.limits(0));
                if wait(&limits) && Path::must_release(&from, &self.goal(&from), &limits) {
                    return Replanned::Later;
                }
                self.vector(&from)
            }
            Plan::Orientation(turn) => {
                let (from, limits) = (turn.state(t), self.limits(0));
                let Some(goal) = orientation(&self.now[..self.goals]) else { return Replanned::No };
                if wait(&limits) && Turn::must_release(&from, &goal, &limits) {
                    return Replanned::Later;
                }
                self.turn(&from)
            }
            Plan::Pose(path, turn) => {
                let (from, turning) = (path.at(t), turn.state(t));
                let (limits, angular) = (self.limits(0), self.angular());
                let Some(goal) = orientation(&self.now[3..7]) else { return Replanned::No };
                let release = (wait(&limits) && Path::must_release(&from, &vector(&self.now[..3]), &limits))
                    || (wait(&angular) && Turn::must_release(&turning, &goal, &angular));
                if release {
                    return Replanned::Later;
                }
                self.pose(&from, &turning)
            }
            Plan::Route(routes) => {
                let (from, next) = (routes.0.at(t), routes.0.toward(t).unwrap_or(0));
                self.route(&from, next)
            }
        };
        if good { Replanned::Yes } else { Replanned::No }
    }

    fn keep(&mut self, good: bool, time: f64) -> bool {
        if good {
            self.since = Some(time);
            self.planned.copy_from_slice(&self.now);
        }
        good
    }

    /// Goal of a number or a vector, seen from a state of the trajectory.
    fn goal(&self, from: &State) -> Vector3<f64> {
        let mut goal = vector(&self.now[..self.goals]);
        if self.turn {
            goal.x = from.position.x + nearest_turn(goal.x - from.position.x);
        }
        goal
    }

    fn vector(&mut self, from: &State) -> bool {
        let limits = self.limits(0);
        let planned =
            if self.stop.is_some() { Path::stop(from, &limits) } else { Path::plan(from, self.goal(from), &limits) };
        planned.map(|path| self.plan = Plan::Vector(path)).is_some()
    }

    fn turn(&mut self, from: &Turning) -> bool {
        let (goal, limits) = (orientation(&self.now[..self.goals]), self.limits(0));
        let planned = goal.and_then(|goal| {
            if self.stop.is_some() { Turn::stop(from, &limits) } else { Turn::plan(from, goal, &limits) }
        });
        planned.map(|turn| self.plan = Plan::Orientation(turn)).is_some()
    }

    /// Plans both parts of a pose, so that they arrive together.
    fn pose(&mut self, from: &State, turning: &Turning) -> bool {
        let (limits, angular) = (self.limits(0), self.angular());
        let both = || {
            let (place, facing) = (vector(&self.now[..3]), orientation(&self.now[3..7])?);
            if self.stop.is_some() {
                let still =
                    |limits: &Limits| Limits { speed: if limits.are_sound() { 0.0 } else { limits.speed }, ..*limits };
                return Some((Path::stop(from, &still(&limits))?, Turn::stop(turning, &still(&angular))?));
            }
            let (path, turn) = (Path::plan(from, place, &limits)?, Turn::plan(turning, facing, &angular)?);
            Some(if path.duration() < turn.duration() {
                (Path::within(from, place, &limits, turn.duration())?, turn)
            } else {
                (path, Turn::within(turning, facing, &angular, path.duration())?)
            })
        };
        both().map(|(path, turn)| self.plan = Plan::Pose(path, turn)).is_some()
    }

    /// Plans a route over the points from number `first` on.
    fn route(&mut self, from: &State, first: usize) -> bool {
        let limits = self.limits(0);
        let number = |i: usize| self.now.get(self.goals + i).copied().unwrap_or(f64::NAN);
        let (corner, halt) = (number(2), number(3));
        self.points.clear();
        self.points.extend(self.now[..self.goals].chunks_exact(3).map(vector));
        let Plan::Route(routes) = &mut self.plan else { return false };
        let points = self.points.get(first..).unwrap_or_default();
        let good = match self.stop {
            Some(_) => routes.1.stop(from, points, first, &limits),
            None => routes.1.plan(from, points, first, &RouteOptions { limits, corner, halt }),
        };
        if good {
            let (now, next) = &mut **routes;
            std::mem::swap(now, next);
        }
        good
    }

    /// Writes the value and its rate `t` seconds after the time of planning.
    fn write(&self, t: f64, out: &mut [f64]) {
        let Some((value, rate)) = out.split_at_mut_checked(self.shape.width()) else { return };
        let place = |now: &State, value: &mut [f64], rate: &mut [f64]| {
            value.iter_mut().zip(&now.position).for_each(|(x, p)| *x = *p);
            rate.iter_mut().zip(&now.velocity).for_each(|(x, v)| *x = *v);
        };
        let facing = |turn: &Turn, value: &mut [f64], rate: &mut [f64]| {
            let (q, omega) = turn.at(t);
            let d = quaternion_rate(&q, &omega);
            value.iter_mut().zip([q.w, q.i, q.j, q.k]).for_each(|(x, c)| *x = c);
            rate.iter_mut().zip([d.w, d.i, d.j, d.k]).for_each(|(x, c)| *x = c);
        };
        match &self.plan {
            Plan::Vector(path) => place(&path.at(t), value, rate),
            Plan::Orientation(turn) => facing(turn, value, rate),
            Plan::Pose(path, turn) => {
                let ((p, q), (dp, dq)) = (value.split_at_mut(3), rate.split_at_mut(3));
                place(&path.at(t), p, dp);
                facing(turn, q, dq);
            }
            Plan::Route(routes) => place(&routes.0.at(t), value, rate),
        }
    }
}
