//! Usual sizes of what several tables declare: a value outside of them is accepted, and the compiler asks if another unit
//! was meant.
//!
//! The bounds are ours. They are far from what robots beside people do, and less than a factor of 1000 (milli) above or
//! below it where that is possible: `0.2 s` and `200 ms` are usual time-outs, `200 s` and `0.2 ms` are not.

use crate::Quantity;
use crate::dimension::{
    ACCELERATION, ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, Dimension, FORCE, LENGTH, MASS, MOMENT, RATE, TIME,
    VELOCITY,
};

/// A turn (rad).
const A_TURN: f64 = 2.0 * std::f64::consts::PI;

/// Position of a revolute joint, or another angle. More than four turns is a number in degrees.
pub const JOINT_ANGLE: Quantity = Quantity::any(ANGLE).usually(1e-6, 4.0 * A_TURN);
/// Position of a prismatic joint. A gantry or a rail is longer than an arm.
pub const JOINT_TRAVEL: Quantity = Quantity::any(LENGTH).usually(1e-6, 100.0);
/// Speed of a revolute joint. Joints of arms reach 10 rad/s, and those of wheels a few times that.
pub const JOINT_SPEED: Quantity = Quantity::any(ANGULAR_VELOCITY).usually(1e-5, 80.0);
/// Speed of a prismatic joint.
pub const JOINT_TRAVEL_SPEED: Quantity = Quantity::any(VELOCITY).usually(1e-6, 20.0);
/// Acceleration of a revolute joint.
pub const JOINT_ACCELERATION: Quantity = Quantity::any(ANGULAR_ACCELERATION).usually(1e-3, 5e3);
/// Acceleration of a prismatic joint.
pub const JOINT_TRAVEL_ACCELERATION: Quantity = Quantity::any(ACCELERATION).usually(1e-3, 1e3);
/// Gain of a task, zero or more.
pub const GAIN: Quantity = Quantity::at_least(RATE, 0.0).usually(1e-3, 5e3);
/// Gain of a limit, more than zero.
pub const LIMIT_GAIN: Quantity = Quantity::above(RATE, 0.0).usually(1e-3, 5e3);
/// Distance that a limit keeps.
pub const CLEARANCE: Quantity = Quantity::at_least(LENGTH, 0.0).usually(1e-5, 20.0);
/// Error of a position that counts as reached.
pub const TOLERANCE: Quantity = Quantity::above(LENGTH, 0.0).usually(1e-6, 2.0);
/// Error of an orientation that counts as reached.
pub const ANGLE_TOLERANCE: Quantity = Quantity::above(ANGLE, 0.0).usually(1e-6, 1.6);
/// Time without a reading after which it counts as lost.
pub const TIMEOUT: Quantity = Quantity::above(TIME, 0.0).usually(1e-3, 120.0);
/// Cutoff of a filter.
pub const CUTOFF: Quantity = Quantity::above(RATE, 0.0).usually(1e-2, 1e3);
/// Speed of a person, or of a vehicle beside people.
pub const WALKING_SPEED: Quantity = Quantity::above(VELOCITY, 0.0).usually(0.01, 15.0);
/// Mass that a person or a robot handles.
pub const HANDLED_MASS: Quantity = Quantity::at_least(MASS, 0.0).usually(1e-3, 2e3);
/// Force between a person and a robot.
pub const CONTACT_FORCE: Quantity = Quantity::any(FORCE).usually(1e-3, 2e3);
/// Moment between a person and a robot.
pub const CONTACT_MOMENT: Quantity = Quantity::any(MOMENT).usually(1e-4, 1e3);
/// Coordinates of a place on a robot.
pub const OFFSET: Quantity = Quantity::any(LENGTH).usually(1e-6, 15.0);
/// Time of a person or a robot at a piece of work.
pub const WORK_TIME: Quantity = Quantity::at_least(TIME, 0.0).usually(0.05, 86_400.0);
/// An angle of an orientation. More than a turn is a number in degrees.
pub const TURN: Quantity = Quantity::any(ANGLE).usually(1e-9, A_TURN);

/// Position, speed or acceleration of a joint, by its dimension.
pub fn of_joint(dimension: Dimension) -> Quantity {
    let all =
        [JOINT_ANGLE, JOINT_TRAVEL, JOINT_SPEED, JOINT_TRAVEL_SPEED, JOINT_ACCELERATION, JOINT_TRAVEL_ACCELERATION];
    all.into_iter().find(|q| q.dimension == dimension).unwrap_or(Quantity::any(dimension))
}
