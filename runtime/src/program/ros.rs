//! Connection of a controller to ROS 2: the topics that it reads and writes.

use robot::MobileBase;
use serde::{Deserialize, Serialize};

use super::{Program, SignalProgram};

/// Connection to ROS 2. Names of topics are as written: absolute, relative to the namespace of the node, or with `~/` relative to
/// the node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RosProgram {
    /// Name of the node.
    pub node: String,
    /// Namespace of the node: `/`, `/cell`.
    pub namespace: String,
    /// Event that begins a tick.
    pub tick: TickSource,
    /// Time for which a reading of a joint is valid, in s.
    pub stale_after: f64,
    /// Frame of quantities in the world.
    pub world: String,
    /// True if poses of links and the URDF are published.
    pub transforms: bool,
    /// Topics with positions of joints.
    pub joint_states: Vec<JointStates>,
    /// Topics with the poses of bases that move, `nav_msgs/Odometry`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub odometry: Vec<BaseOdometry>,
    /// Topics of commands.
    pub commands: Vec<CommandTopic>,
    /// Topics of signals. Other signals are read from topics with their names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub signals: Vec<SignalTopic>,
}

/// Event that begins a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TickSource {
    /// The clock of the controller.
    #[default]
    Timer,
    /// A message of the first topic with positions of joints.
    JointStates,
}

/// A topic with messages of the type `sensor_msgs/JointState`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JointStates {
    /// The topic.
    pub topic: String,
    /// Beginning of the joints' names in the model that messages leave out: `left_` for one of several robots.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub prefix: String,
}

/// A topic with the pose of a base in the world, of the type `nav_msgs/Odometry`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BaseOdometry {
    /// The topic.
    pub topic: String,
    /// Index of the base in the model.
    pub base: usize,
}

/// A topic of commands.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CommandTopic {
    /// Its name in the spec.
    pub name: String,
    /// The topic.
    pub topic: String,
    /// Content of its messages.
    pub form: CommandForm,
    /// Degrees of freedom, in the order of the message.
    pub dofs: Vec<usize>,
    /// Beginning of the joints' names in the model that messages leave out.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub prefix: String,
}

/// Content of the messages of commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CommandForm {
    /// `std_msgs/Float64MultiArray` with velocities in rad/s or m/s.
    Velocity,
    /// `std_msgs/Float64MultiArray` with positions in rad or m.
    Position,
    /// `trajectory_msgs/JointTrajectory` with one point: positions after the next tick, and velocities.
    Trajectory,
    /// `geometry_msgs/Twist` of a base, in its own frame.
    Twist,
}

/// A topic that a signal is read from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SignalTopic {
    /// Index of the signal.
    pub signal: usize,
    /// The topic.
    pub topic: String,
    /// Type of the messages.
    pub message: String,
    /// Frame that messages are in; `None` for the one that the signal is declared in, or the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// True if the publisher keeps its last message for those who come later, and sends it when it changes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub latched: bool,
}

impl Default for RosProgram {
    fn default() -> Self {
        RosProgram {
            node: "hierarq".to_string(),
            namespace: "/".to_string(),
            tick: TickSource::Timer,
            stale_after: 0.1,
            world: "world".to_string(),
            transforms: false,
            joint_states: Vec::new(),
            odometry: Vec::new(),
            commands: Vec::new(),
            signals: Vec::new(),
        }
    }
}

impl RosProgram {
    /// The connection of a program, with the usual topics for what it leaves out.
    pub fn of(program: &Program) -> RosProgram {
        let mut ros = program.run.ros.clone().unwrap_or_default();
        let model = &program.robot.model;
        let of_base = |base: &MobileBase, name: &str| match base.prefix(model).trim_end_matches('_') {
            "" => format!("/{name}"),
            robot => format!("/{robot}/{name}"),
        };
        if ros.joint_states.is_empty() {
            ros.joint_states.push(JointStates { topic: "/joint_states".to_string(), prefix: String::new() });
        }
        if ros.odometry.is_empty() {
            let odometry = |(i, base)| BaseOdometry { topic: of_base(base, "odom"), base: i };
            ros.odometry.extend(model.bases.iter().enumerate().map(odometry));
        }
        if ros.commands.is_empty() {
            let topic =
                |name: String, topic, form, dofs| CommandTopic { name, topic, form, dofs, prefix: String::new() };
            let joints: Vec<usize> = (0..model.nv()).filter(|dof| model.base_of_dof(*dof).is_none()).collect();
            if !joints.is_empty() {
                let commands = "~/commands".to_string();
                ros.commands.push(topic("joints".to_string(), commands, CommandForm::Velocity, joints));
            }
            ros.commands.extend(model.bases.iter().map(|base| {
                let name = format!("{}base", base.prefix(model));
                topic(name, of_base(base, "cmd_vel"), CommandForm::Twist, base.dofs().collect())
            }));
        }
        for (i, s) in program.interface.signals.iter().enumerate().filter(|(_, s)| !s.is_variable()) {
            if ros.signals.iter().all(|t| t.signal != i) {
                let topic = format!("~/{}", s.name.replace('.', "/"));
                let message = s.ros_messages()[0].to_string();
                ros.signals.push(SignalTopic { signal: i, topic, message, frame: None, latched: false });
            }
        }
        ros
    }

    /// Returns the first thing that does not fit the program.
    pub(super) fn check(&self, program: &Program) -> Result<(), &'static str> {
        let model = &program.robot.model;
        let known = |dof: &usize| *dof < model.nv();
        let moves_base = |c: &CommandTopic| {
            c.form != CommandForm::Twist || model.bases.iter().any(|base| base.dofs().eq(c.dofs.iter().copied()))
        };
        let signal = |s: &SignalTopic| program.interface.signals.get(s.signal);
        let read = |s: &SignalTopic| signal(s).is_some_and(|of| of.ros_messages().contains(&s.message.as_str()));
        let topics = self.joint_states.iter().map(|j| &j.topic).chain(self.odometry.iter().map(|o| &o.topic));
        let topics = topics.chain(self.commands.iter().map(|c| &c.topic)).chain(self.signals.iter().map(|s| &s.topic));
        match () {
            () if !(self.stale_after.is_finite() && self.stale_after > 0.0) => {
                Err("`stale_after` is not a positive time")
            }
            () if !self.commands.iter().flat_map(|c| &c.dofs).all(known) => Err("a joint does not exist"),
            () if self.odometry.iter().any(|o| o.base >= model.bases.len()) => Err("a base does not exist"),
            () if !self.commands.iter().all(moves_base) => Err("a twist does not move exactly one base"),
            () if !self.signals.iter().all(read) => Err("a signal does not exist, or is not read from this message"),
            () if topics.into_iter().any(|topic| wrong_topic(topic).is_some()) => Err("a topic has no name of ROS 2"),
            () => Ok(()),
        }
    }
}

impl CommandForm {
    /// Type of the messages.
    pub fn message(self) -> &'static str {
        match self {
            CommandForm::Velocity | CommandForm::Position => "std_msgs/Float64MultiArray",
            CommandForm::Trajectory => "trajectory_msgs/JointTrajectory",
            CommandForm::Twist => "geometry_msgs/Twist",
        }
    }
}

impl SignalProgram {
    /// Types of ROS 2 messages that a value of the signal can be read from. The first is the usual one.
    pub fn ros_messages(&self) -> &'static [&'static str] {
        match (self.kind.as_str(), self.sent()) {
            ("flag", _) => &["std_msgs/Bool"],
            ("wrench", _) => &["geometry_msgs/WrenchStamped", "geometry_msgs/Wrench"],
            ("orientation", _) => &["geometry_msgs/QuaternionStamped", "geometry_msgs/PoseStamped", "sensor_msgs/Imu"],
            ("pose", 7) => &["geometry_msgs/PoseStamped", "geometry_msgs/Pose", "nav_msgs/Odometry"],
            ("pose" | "point", 6 | 13) => &["nav_msgs/Odometry"],
            ("point", _) => &[
                "geometry_msgs/PointStamped",
                "geometry_msgs/Point",
                "geometry_msgs/PoseStamped",
                "geometry_msgs/Pose",
                "nav_msgs/Odometry",
            ],
            (_, 3) => &["geometry_msgs/Vector3Stamped", "geometry_msgs/Vector3"],
            _ => &["std_msgs/Float64", "std_msgs/Float32"],
        }
    }
}

/// Reason for which a text is no name of a topic in ROS 2; `None` if it is one. Names are relative, absolute, or begin with `~/`.
pub fn wrong_topic(name: &str) -> Option<&'static str> {
    let rest = name.strip_prefix("~/").or_else(|| name.strip_prefix('/')).unwrap_or(name);
    if rest.is_empty() {
        // The root is a namespace.
        return (name != "/").then_some("it is empty");
    }
    for part in rest.split('/') {
        if part.is_empty() {
            return Some("two slashes follow each other, or one stands at the end");
        }
        if part.starts_with(|c: char| c.is_ascii_digit()) {
            return Some("a part begins with a digit");
        }
        if part.contains(|c: char| !(c.is_ascii_alphanumeric() || c == '_')) {
            return Some("other characters than letters, digits and `_` are in it");
        }
        if part.contains("__") {
            return Some("two `_` follow each other");
        }
    }
    None
}
