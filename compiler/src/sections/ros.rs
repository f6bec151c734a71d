//! The keys of the connection to ROS 2.

use blocks::{ByName, Located, Unbound, Word, block};
use stdlib_tasks::dimension::TIME;
use stdlib_tasks::params::Quantity;

use super::{Named, ValueType};

block! {
    /// The connection to ROS 2.
    pub struct RosBlock = ROS, "the connection to ROS 2" {
        /// Name of the node.
        node: Option<Located<String>> = optional(ValueType::Text);
        /// Namespace of the node and of topics that do not begin with `/`.
        namespace: Option<Located<String>> = optional(ValueType::Text);
        /// Event that begins a tick: the clock of the controller, `timer`, or a message with positions of joints, `joint_states`.
        tick: Word = or(ValueType::Choice(&["timer", "joint_states"]), "timer");
        /// Time for which a position of a joint is valid. After it the fault `not_finite` occurs. At least a period.
        stale_after: Located<f64> = or(ValueType::Number(Quantity::above(TIME, 0.0).usually(1e-3, 5.0)), "0.1 s");
        /// Frame of quantities in the world; values in other frames are carried over into it.
        world_frame: Option<String> = optional(ValueType::Text);
        /// True if poses of links are published on `/tf`, and the URDF on `/robot_description`, as `robot_state_publisher` does.
        transforms: bool = or(ValueType::Flag, "false");
        /// Topics with positions of joints, `sensor_msgs/JointState`; default: `/joint_states`.
        joint_states: Vec<ByName<JointStatesBlock>> = optional(ValueType::Each(&ValueType::Block(&JOINT_STATES)));
        /// Topic with the pose of a base that moves, `nav_msgs/Odometry`; default: `/odom`, or `/ROBOT/odom` for each of several
        /// robots, for which this key is left out.
        odometry: Option<Located<String>> = optional(ValueType::Text);
        /// Topics of commands, by names that the user chooses; default: `~/commands` with the velocities of all joints, and `/cmd_vel` with
        /// that of a base, `/ROBOT/cmd_vel` for several.
        commands: Vec<ByName<CommandTopicBlock>> = optional(ValueType::Each(&ValueType::Block(&COMMAND_TOPIC)));
        /// Topics of signals, by name; default: `~/NAME`, with the usual type of message.
        signals: Option<Located<Unbound>> = elsewhere(ValueType::Of(Named::Signal, &ValueType::Block(&SIGNAL_TOPIC)));
        /// Topics of the points of people, by human and point; default: `~/HUMAN/POINT`.
        humans: Option<Located<Unbound>> =
            elsewhere(ValueType::Of(Named::Human, &ValueType::Each(&ValueType::Block(&SIGNAL_TOPIC))));
    }
}

block! {
    /// A topic with positions of joints.
    pub struct JointStatesBlock = JOINT_STATES, "a topic with positions of joints" {
        /// The topic.
        topic: Option<Located<String>> = required(ValueType::Text, "\"/joint_states\"");
        /// Beginning of the joints' names that messages leave out: `"left_"` for one of several robots.
        prefix: Option<String> = optional(ValueType::Text);
    }
}

block! {
    /// A topic of commands.
    pub struct CommandTopicBlock = COMMAND_TOPIC, "a topic of commands" {
        /// The topic.
        topic: Option<Located<String>> = required(ValueType::Text, "\"/arm_controller/commands\"");
        /// Content of its messages: a `Float64MultiArray` with velocities or positions, a `JointTrajectory` with one point, or
        /// the `Twist` of a base.
        form: Word = or(ValueType::Choice(&["velocity", "position", "trajectory", "twist"]), "velocity");
        /// Joints, in the order of the message; default: all. For a `twist` the base, if there are several.
        joints: Option<Located<Unbound>> = elsewhere(ValueType::Joints);
        /// Beginning of the joints' names that messages leave out.
        prefix: Option<String> = optional(ValueType::Text);
    }
}

block! {
    /// A topic that a signal is read from.
    pub struct SignalTopicBlock = SIGNAL_TOPIC, "the topic of a signal" {
        /// The topic.
        topic: Option<Located<String>> = required(ValueType::Text, "\"/ft_sensor/wrench\"");
        /// Type of its messages; default: the usual one for the type of the signal.
        message: Option<Located<String>> = optional(ValueType::Text);
        /// Frame that messages are in; default: the link that the signal is declared in, or the world.
        frame_id: Option<String> = optional(ValueType::Text);
        /// True if its publisher keeps the last message for those who come later (transient local), and sends one when the value changes.
        latched: bool = or(ValueType::Flag, "false");
    }
}
