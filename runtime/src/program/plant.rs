//! The simulated robot as a body with masses and drives.

use robot::LinkId;
use serde::{Deserialize, Serialize};
use stdlib_tasks::obstacle::{Form, Obstacle};
use stdlib_tasks::slot::Slot;

use super::Program;

/// Most elements of a cloud or of a surface that physics takes as a body.
pub const MOST_BODY_ELEMENTS: usize = 5_000;

/// Reason why an obstacle is no body in physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoBody {
    /// It has so many elements, more than [`MOST_BODY_ELEMENTS`].
    Elements(usize),
    /// A link carries it, and it moves on that link.
    MovesOnLink,
}

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
    /// True if links touch obstacles and people.
    pub contacts: bool,
    /// True if links touch each other.
    #[serde(default)]
    pub self_contact: bool,
    /// Radius of the balls at the points of people, and of the rods along their links, in m.
    #[serde(default = "person_radius")]
    pub person_radius: f64,
    /// Longest time step, in s.
    pub step: f64,
}

fn person_radius() -> f64 {
    0.05
}

/// True if a part of the table of values changes during a run.
pub fn varies(program: &Program, slot: Slot) -> bool {
    let outputs = &program.values.tape.outputs;
    outputs.iter().any(|o| (slot.at..slot.at + slot.len).contains(&o.at))
}

/// Reason why an obstacle of a program is no body in physics; `None` for one that is.
pub fn no_body(program: &Program, obstacle: &Obstacle) -> Option<NoBody> {
    let moves = || obstacle.slots().any(|slot| varies(program, slot));
    match &obstacle.form {
        Form::Soup(soup) if soup.len() > MOST_BODY_ELEMENTS => Some(NoBody::Elements(soup.len())),
        _ if obstacle.link.is_some() && moves() => Some(NoBody::MovesOnLink),
        _ => None,
    }
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
