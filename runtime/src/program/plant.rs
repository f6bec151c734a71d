//! The simulated robot as a body with masses and drives.

use robot::LinkId;
use serde::{Deserialize, Serialize};

/// Settings of a physical robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlantProgram {
    /// Quantity that its drives follow.
    pub actuators: Actuators,
    /// Time constant of a drive in the home configuration, in s.
    pub response: f64,
    /// Gravity.
    pub gravity: Gravity,
    /// Dry friction of each joint, in N m or N.
    pub friction: f64,
    /// Mass that the robot carries and its drives do not know of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<Payload>,
    /// True if links touch obstacles.
    pub contacts: bool,
    /// Longest time step, in s.
    pub step: f64,
}

/// Quantity that drives follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Actuators {
    /// The commanded velocity.
    Velocity,
    /// The integral of the commanded velocity.
    Position,
}

/// Gravity of a physical robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gravity {
    /// It acts, and the drives compensate for the masses of the URDF.
    Compensated,
    /// It acts.
    Uncompensated,
    /// There is none.
    None,
}

/// Mass at a link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Payload {
    /// The link.
    pub link: LinkId,
    /// Mass, in kg.
    pub mass: f64,
    /// Its place in the frame of the link, in m.
    pub at: [f64; 3],
}
