//! The keys of a plant: the simulated robot as a body with masses and drives.

use blocks::{Located, Word, block};
use quantities::usual;
use stdlib_tasks::dimension::{LENGTH, MASS, MOMENT, TIME};
use stdlib_tasks::params::Quantity;

use super::ValueType;

block! {
    /// The robot as a body.
    pub struct PlantBlock = PLANT, "a plant" {
        /// The robot in the physics of MuJoCo.
        mujoco: Option<Located<MujocoBlock>> = optional(ValueType::Block(&MUJOCO));
    }
}

block! {
    /// The robot in MuJoCo.
    pub struct MujocoBlock = MUJOCO, "the robot in MuJoCo" {
        /// Quantity that the drives follow: the commanded `velocity`, or the `position` that it leads to.
        actuators: Word = or(ValueType::Choice(&["velocity", "position"]), "velocity");
        /// Time constant of a drive that moves the masses of the home configuration; drives of positions are critically damped. The
        /// torque of a drive is at most the `effort` of its joint in the URDF.
        response: Located<f64> = or(ValueType::Number(Quantity::above(TIME, 0.0).usually(1e-3, 0.5)), "0.01 s");
        /// Gravity acts, and the drives compensate for the masses of the URDF: `compensated`; they do not: `uncompensated`; or
        /// there is none: `none`.
        gravity: Word = or(ValueType::Choice(&["compensated", "uncompensated", "none"]), "compensated");
        /// Dry friction of each joint; for prismatic joints the same number in N.
        friction: f64 = or(ValueType::Number(Quantity::at_least(MOMENT, 0.0)), "0 Nm");
        /// A mass that the robot carries, and that its drives do not know of.
        payload: Option<PayloadBlock> = optional(ValueType::Block(&PAYLOAD));
        /// True if links touch obstacles and people.
        contacts: bool = or(ValueType::Flag, "true");
        /// True if links touch each other, as far as they do not at home.
        self_contact: bool = or(ValueType::Flag, "false");
        /// Radius of the balls at the tracked points of people, and of the rods along their `links`.
        person_radius: f64 = or(ValueType::Number(Quantity::above(LENGTH, 0.0).usually(1e-3, 1.0)), "0.05 m");
        /// Longest time step, at most a period; default: 1 ms, or what is shorter of the period and the `response`.
        step: Option<Located<f64>> = optional(ValueType::Number(Quantity::above(TIME, 0.0).usually(1e-5, 0.01)));
    }
}

block! {
    /// A mass at a link.
    pub struct PayloadBlock = PAYLOAD, "a payload" {
        /// The link that carries it.
        link: Option<Located<String>> = required(ValueType::Link, "tool");
        /// Its mass.
        mass: Option<f64> = required(ValueType::Number(Quantity::above(MASS, 0.0).usually(1e-3, 1e3)), "1 kg");
        /// Its place in the frame of the link.
        at: [f64; 3] = or(ValueType::Vector(usual::OFFSET), "[0, 0, 0] m");
    }
}
