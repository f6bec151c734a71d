//! Catalogue: every task type, one file each.
//!
//! A new type needs its file, its line in `mod` and its line in [`KINDS`]. Tests walk the list.

pub mod admittance;
pub mod cooperative_motion;
pub mod frame_orientation;
pub mod frame_pose;
pub mod frame_position;
pub mod hand_guiding;
pub mod hold;
pub mod joint_acceleration_limits;
pub mod joint_position;
pub mod joint_position_limits;
pub mod joint_velocity;
pub mod joint_velocity_limits;
pub mod keep;
pub mod keep_clear;
pub mod least_motion;
pub mod look_at;
pub mod safety_planner;
pub mod self_collision;
pub mod speed_separation;
pub mod stance;
pub mod swivel_angle;
pub mod track;
pub mod uncooperative_motion;
pub mod virtual_wall;

use crate::task::TaskKind;

/// All task types, in the order of the docs: limits, targets, posture.
pub static KINDS: &[&TaskKind] = &[
    &joint_position_limits::KIND,
    &joint_velocity_limits::KIND,
    &joint_acceleration_limits::KIND,
    &virtual_wall::KIND,
    &self_collision::KIND,
    &keep_clear::KIND,
    &speed_separation::KIND,
    &keep::KIND,
    &stance::KIND,
    &frame_pose::KIND,
    &frame_position::KIND,
    &frame_orientation::KIND,
    &look_at::KIND,
    &cooperative_motion::KIND,
    &uncooperative_motion::KIND,
    &admittance::KIND,
    &hand_guiding::KIND,
    &hold::KIND,
    &joint_position::KIND,
    &joint_velocity::KIND,
    &least_motion::KIND,
    &swivel_angle::KIND,
    &track::KIND,
    &safety_planner::KIND,
];

/// Finds the type of this name.
pub fn find(name: &str) -> Option<&'static TaskKind> {
    KINDS.iter().copied().find(|k| k.name == name)
}
