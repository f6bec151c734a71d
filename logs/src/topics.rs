//! The channels of a log, with the quality of service under which a player publishes them again.

use crate::definitions::{DIAGNOSTICS, Definition, JOINT_STATE, MARKERS, NUMBERS, STRING, TRANSFORMS};

/// A channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// The URDF of the model.
    RobotDescription,
    /// Poses of links that no joint moves.
    FixedTransforms,
    /// Walls.
    Walls,
    /// Volumes that other parts of the robot keep out of.
    KeepOut,
    /// Positions and velocities of the joints.
    JointStates,
    /// Commanded velocities.
    Command,
    /// The numbers of a row of `log.csv`.
    Columns,
    /// The state of the machine.
    State,
    /// The fault that keeps the robot still.
    Fault,
    /// Poses of links that joints move.
    Transforms,
    /// Obstacles.
    Obstacles,
    /// People.
    People,
    /// Lines between closest points.
    ClosestPoints,
    /// Margins, errors and levels.
    Diagnostics,
}

impl Topic {
    /// All channels, in the order in which a log declares them.
    pub const ALL: [Topic; 14] = [
        Topic::RobotDescription,
        Topic::FixedTransforms,
        Topic::Walls,
        Topic::KeepOut,
        Topic::JointStates,
        Topic::Command,
        Topic::Columns,
        Topic::State,
        Topic::Fault,
        Topic::Transforms,
        Topic::Obstacles,
        Topic::People,
        Topic::ClosestPoints,
        Topic::Diagnostics,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Topic::RobotDescription => "/robot_description",
            Topic::FixedTransforms => "/tf_static",
            Topic::Walls => "/walls",
            Topic::KeepOut => "/keep_out",
            Topic::JointStates => "/joint_states",
            Topic::Command => "/command",
            Topic::Columns => "/hierarq/columns",
            Topic::State => "/state",
            Topic::Fault => "/fault",
            Topic::Transforms => "/tf",
            Topic::Obstacles => "/obstacles",
            Topic::People => "/people",
            Topic::ClosestPoints => "/closest_points",
            Topic::Diagnostics => "/diagnostics",
        }
    }

    /// Its messages.
    pub fn definition(self) -> &'static Definition {
        match self {
            Topic::RobotDescription | Topic::State | Topic::Fault => &STRING,
            Topic::FixedTransforms | Topic::Transforms => &TRANSFORMS,
            Topic::JointStates => &JOINT_STATE,
            Topic::Command | Topic::Columns => &NUMBERS,
            Topic::Walls | Topic::KeepOut | Topic::Obstacles | Topic::People | Topic::ClosestPoints => &MARKERS,
            Topic::Diagnostics => &DIAGNOSTICS,
        }
    }

    /// True if the last message is kept for whoever comes later.
    pub fn is_latched(self) -> bool {
        use Topic::{Fault, FixedTransforms, KeepOut, RobotDescription, State, Walls};
        matches!(self, RobotDescription | FixedTransforms | Walls | KeepOut | State | Fault)
    }

    /// The quality of service in the words of rosbag2, complete: some readers refuse a part of it.
    pub fn quality_of_service(self) -> String {
        let durability = if self.is_latched() { 1 } else { 2 };
        let depth = if self.is_latched() { 1 } else { 10 };
        let forever = "    sec: 9223372036\n    nsec: 854775807\n";
        format!(
            "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n  deadline:\n{forever}  \
             lifespan:\n{forever}  liveliness: 1\n  liveliness_lease_duration:\n{forever}  \
             avoid_ros_namespace_conventions: false\n"
        )
    }
}
