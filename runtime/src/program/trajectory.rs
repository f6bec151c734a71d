//! Trajectories of a tape: values that move to a goal within limits, from where they are when the stack is entered.
//!
//! A trajectory reads operations of the tape that come before all that reads it, and gives numbers, which the tape reads as
//! [`Op::Trajectory`]: first those of its value, then their time derivatives.

use serde::{Deserialize, Serialize};

use super::check::ensure;
use super::{Op, ProgramError, Tape};

/// What moves.
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
    /// How many numbers its value has.
    pub fn width(self) -> usize {
        match self {
            Shape::Number => 1,
            Shape::Vector => 3,
            Shape::Orientation => 4,
            Shape::Pose => 7,
        }
    }

    /// How many numbers its velocity has.
    pub fn velocity_width(self) -> usize {
        match self {
            Shape::Number => 1,
            Shape::Vector | Shape::Orientation => 3,
            Shape::Pose => 6,
        }
    }
}

/// How it moves.
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

/// Most points of one trajectory.
pub const MAX_POINTS: usize = 64;

/// A trajectory; operations are indices into [`Tape::ops`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrajectoryProgram {
    /// How it moves.
    pub motion: Motion,
    /// What moves.
    pub shape: Shape,
    /// Its first number in the table of trajectories.
    pub at: usize,
    /// Operations that give the goal, or one point after the other.
    pub goals: Vec<usize>,
    /// Operations that give speed and acceleration; for S-curves then jerk; for waypoints then corner and hold. Of a pose
    /// those of the position, then those of the orientation.
    pub limits: Vec<usize>,
    /// Operations that give the value at the start.
    pub start: Vec<usize>,
    /// Operations that give the velocity at the start, the angular one of orientations; none for rest.
    pub velocity: Vec<usize>,
}

impl TrajectoryProgram {
    /// The operations that it reads.
    pub fn inputs(&self) -> impl Iterator<Item = usize> {
        self.goals.iter().chain(&self.limits).chain(&self.start).chain(&self.velocity).copied()
    }

    /// The same with the operations renumbered.
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

    /// The numbers that it gives.
    pub fn numbers(&self) -> std::ops::Range<usize> {
        self.at..self.at.saturating_add(2 * self.shape.width())
    }

    /// How many limits it has.
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
    /// The trajectory that gives a number of the table of trajectories.
    pub fn trajectory_of(&self, number: usize) -> Option<usize> {
        self.trajectories.iter().position(|t| t.numbers().contains(&number))
    }

    /// How many numbers trajectories give, with those that are left out between.
    pub fn trajectory_numbers(&self) -> usize {
        self.trajectories.iter().map(|t| t.numbers().end).max().unwrap_or(0)
    }

    /// Makes sure that trajectories read what exists, in time.
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
