//! Trajectories of a tape: values that move to a goal within limits, starting from their values at the entry of the
//! stack.
//!
//! A trajectory reads operations of the tape that come before all its users. It produces numbers, which the tape reads
//! as [`Op::Trajectory`]: first those of its value, then their time derivatives.

use serde::{Deserialize, Serialize};

use super::check::ensure;
use super::{Op, ProgramError, Tape};

/// Kind of value that moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// One number.
    Number,
    /// Three numbers.
    Vector,
    /// A quaternion `w x y z`.
    Orientation,
    /// A position and a quaternion.
    Pose,
}

impl Shape {
    /// Number of numbers in its value.
    pub fn width(self) -> usize {
        match self {
            Shape::Number => 1,
            Shape::Vector => 3,
            Shape::Orientation => 4,
            Shape::Pose => 7,
        }
    }

    /// Number of numbers in its velocity.
    pub fn velocity_width(self) -> usize {
        match self {
            Shape::Number => 1,
            Shape::Vector | Shape::Orientation => 3,
            Shape::Pose => 6,
        }
    }
}

/// Profile of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// With limited speed and acceleration.
    Trapezoid,
    /// With limited jerk too.
    SCurve,
    /// Over several points.
    Waypoints,
}

/// Largest number of points of one trajectory.
pub const MAX_POINTS: usize = 64;

/// A trajectory; operations are indices into [`Tape::ops`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrajectoryProgram {
    /// Profile of the motion.
    pub motion: Motion,
    /// Kind of value that moves.
    pub shape: Shape,
    /// Index of its first number in the table of trajectories.
    pub at: usize,
    /// Operations that compute the goal, or one point after the other.
    pub goals: Vec<usize>,
    /// Operations that compute speed and acceleration; for S-curves then jerk; for waypoints then corner and hold. For
    /// a pose, those of the position are followed by those of the orientation.
    pub limits: Vec<usize>,
    /// Operations that compute the value at the start.
    pub start: Vec<usize>,
    /// Operations that compute the velocity at the start, the angular one of orientations; empty for rest.
    pub velocity: Vec<usize>,
    /// True for an angle on the circle: it moves to its goal by the nearest turn.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub turn: bool,
}

impl TrajectoryProgram {
    /// Operations that it reads.
    pub fn inputs(&self) -> impl Iterator<Item = usize> {
        self.goals.iter().chain(&self.limits).chain(&self.start).chain(&self.velocity).copied()
    }

    /// Copy with renumbered operations.
    pub fn renumber(&self, f: impl Fn(usize) -> usize) -> TrajectoryProgram {
        let all = |list: &[usize]| list.iter().map(|&i| f(i)).collect();
        TrajectoryProgram {
            goals: all(&self.goals),
            limits: all(&self.limits),
            start: all(&self.start),
            velocity: all(&self.velocity),
            ..*self
        }
    }

    /// Range of the numbers that it produces.
    pub fn numbers(&self) -> std::ops::Range<usize> {
        self.at..self.at.saturating_add(2 * self.shape.width())
    }

    /// Number of its limits.
    pub fn limit_count(&self) -> usize {
        let one = match self.motion {
            Motion::Trapezoid => 2,
            Motion::SCurve => 3,
            Motion::Waypoints => 4,
        };
        if self.shape == Shape::Pose { 2 * one } else { one }
    }
}

impl Tape {
    /// Trajectory that produces a number of the table of trajectories.
    pub fn trajectory_of(&self, number: usize) -> Option<usize> {
        self.trajectories.iter().position(|t| t.numbers().contains(&number))
    }

    /// Length of the table of trajectories, including numbers of trajectories that were left out.
    pub fn trajectory_numbers(&self) -> usize {
        self.trajectories.iter().map(|t| t.numbers().end).max().unwrap_or(0)
    }

    /// Checks that trajectories read existing operations, and that these come before the users of the trajectory.
    pub(super) fn check_trajectories(&self) -> Result<(), ProgramError> {
        let mut end = 0_usize;
        for (i, t) in self.trajectories.iter().enumerate() {
            let place = format!("values.tape.trajectories[{i}]");
            ensure(t.at == end, &place, "its numbers do not follow those of the one before")?;
            end = t.numbers().end;
            let width = t.shape.width();
            let points = t.goals.len() / width;
            ensure(points * width == t.goals.len() && points >= 1, &place, "a goal has another number of numbers")?;
            ensure(points <= MAX_POINTS, &place, "too many points")?;
            let over = t.motion == Motion::Waypoints;
            ensure(over || points == 1, &place, "more than one goal")?;
            ensure(!over || t.shape == Shape::Vector, &place, "waypoints are points")?;
            ensure(!t.turn || t.shape == Shape::Number, &place, "only a number is an angle on the circle")?;
            ensure(t.limits.len() == t.limit_count(), &place, "more or fewer limits than it has")?;
            ensure(t.start.len() == width, &place, "a start has another number of numbers")?;
            let velocity = t.velocity.is_empty() || t.velocity.len() == t.shape.velocity_width();
            ensure(velocity, &place, "a velocity has another number of numbers")?;
            ensure(t.inputs().all(|o| o < self.ops.len()), &place, "reads an operation that does not exist")?;
        }
        for (i, op) in self.ops.iter().enumerate() {
            let Op::Trajectory(k) = *op else { continue };
            let place = format!("values.tape.ops[{i}]");
            let read = self.trajectory_of(k).and_then(|t| self.trajectories.get(t));
            ensure(read.is_some_and(|t| t.inputs().all(|o| o < i)), &place, "reads a trajectory before what it needs")?;
        }
        Ok(())
    }
}
