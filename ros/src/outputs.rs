//! Topics of commands and of requests.

use robot::Model;
use ros2_client::{Node, Publisher};
use runtime::program::{ActionProgram, CommandForm, RosProgram};

use crate::RosError;
use crate::commands::{Commander, Motion};
use crate::messages::{Float64MultiArray, JointTrajectory, Text, Twist};
use crate::names::{absolute, message_type, resolved};
use crate::quality;
use crate::remark::Remark;

/// Name of the topic of requests.
const ACTIONS: &str = "~/actions";

enum Channel {
    Numbers(Publisher<Float64MultiArray>),
    Trajectory(Publisher<JointTrajectory>),
    Twist(Publisher<Twist>),
}

struct Output {
    topic: String,
    commander: Commander,
    channel: Channel,
}

/// Sends commands and requests.
pub struct Outputs {
    all: Vec<Output>,
    actions: Publisher<Text>,
    /// Velocities of a robot that stands, and the time between two commands (s).
    still: Vec<f64>,
    period: f64,
}

impl Outputs {
    /// Publishes the topics of a connection.
    ///
    /// # Errors
    /// The client library refuses one.
    pub fn new(node: &mut Node, ros: &RosProgram, model: &Model, period: f64) -> Result<Outputs, RosError> {
        let mut all = Vec::new();
        for command in &ros.commands {
            let topic = resolved(ros, &command.topic);
            let quality = quality::command();
            let made = node.create_topic(&absolute(&topic)?, message_type(command.form.message()), &quality)?;
            let channel = match command.form {
                CommandForm::Velocity | CommandForm::Position => {
                    Channel::Numbers(node.create_publisher(&made, Some(quality))?)
                }
                CommandForm::Trajectory => Channel::Trajectory(node.create_publisher(&made, Some(quality))?),
                CommandForm::Twist => Channel::Twist(node.create_publisher(&made, Some(quality))?),
            };
            all.push(Output { topic, commander: Commander::new(command, model), channel });
        }
        let quality = quality::request();
        let made = node.create_topic(&absolute(&resolved(ros, ACTIONS))?, message_type("std_msgs/String"), &quality)?;
        let actions = node.create_publisher(&made, Some(quality))?;
        Ok(Outputs { all, actions, still: vec![0.0; model.nv()], period })
    }

    /// Sends a motion. A command that the network does not take is told.
    pub fn send(&self, motion: Motion, remarks: &mut dyn FnMut(Remark)) {
        for output in &self.all {
            let commander = &output.commander;
            let sent = match &output.channel {
                Channel::Numbers(to) => to.publish(commander.numbers(motion)).map_err(|e| e.to_string()),
                Channel::Trajectory(to) => to.publish(commander.trajectory(motion)).map_err(|e| e.to_string()),
                Channel::Twist(to) => to.publish(commander.twist(motion)).map_err(|e| e.to_string()),
            };
            if let Err(why) = sent {
                remarks(Remark::NotSent { topic: output.topic.clone(), why });
            }
        }
    }

    /// Topics of commands that nobody reads.
    pub fn unread(&self, node: &Node) -> Vec<String> {
        let readers = |output: &Output| match &output.channel {
            Channel::Numbers(to) => to.get_subscription_count(node),
            Channel::Trajectory(to) => to.get_subscription_count(node),
            Channel::Twist(to) => to.get_subscription_count(node),
        };
        self.all.iter().filter(|output| readers(output) == 0).map(|output| output.topic.clone()).collect()
    }

    /// Commands the robot to stand where it is.
    pub fn stand(&self, position: &[f64]) {
        self.send(Motion { velocity: &self.still, position, lasts: self.period }, &mut |_| ());
    }

    /// Asks for an action: `begin gripper close`, `cancel gripper close`.
    pub fn request(&self, action: &ActionProgram, begin: bool, remarks: &mut dyn FnMut(Remark)) {
        let words = [if begin { "begin" } else { "cancel" }, &action.verb];
        let words = words.into_iter().chain(action.arguments.iter().map(String::as_str));
        let data = words.collect::<Vec<_>>().join(" ");
        if let Err(e) = self.actions.publish(Text { data }) {
            remarks(Remark::NotSent { topic: ACTIONS.to_string(), why: e.to_string() });
        }
    }
}
