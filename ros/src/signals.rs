//! Signals that are read from topics.

use ros2_client::{Node, Subscription};
use runtime::Signals;
use runtime::program::{Program, RosProgram, SignalTopic};

use crate::RosError;
use crate::frames::Frames;
use crate::messages::{
    Bool, Float32, Float64, Imu, Odometry, Pose, PoseStamped, QuaternionStamped, Vector3, Vector3Stamped, Wrench,
    WrenchStamped,
};
use crate::names::{absolute, message_type, resolved};
use crate::quality;
use crate::readings::{Numbers, Reading, Wanted};
use crate::remark::Remark;

/// Time for which a transform is waited for without a word (s).
const TRANSFORMS: f64 = 1.0;

/// Receiver of remarks of a reader.
pub type Remarks<'a> = dyn FnMut(Remark) + 'a;

/// Poses of frames at a tick.
pub struct Poses<'a> {
    /// The frames.
    pub frames: &'a mut Frames,
    /// Configuration of the robot.
    pub q: &'a [f64],
}

/// Reads a topic.
pub trait Reader: Send {
    /// Takes all messages that have arrived, at a time (s), and sends their values to the controller.
    fn read(&mut self, time: f64, poses: &mut Poses, signals: &mut Signals, remarks: &mut Remarks);

    /// Looks whether a latched value still has a publisher that would send another one. Without one it is absent.
    fn look(&mut self, node: &Node, signals: &mut Signals);
}

struct Topic<M: Reading> {
    subscription: Subscription<M>,
    signal: usize,
    wanted: Wanted,
    topic: String,
    /// Frame that the controller needs.
    frame: String,
    /// Time of the first of the messages that were rejected since the last one that was not (s).
    rejected: Option<f64>,
    is_latched: bool,
    /// True if there was a publisher at the last look. The first message may be here before it.
    is_published: bool,
}

impl<M: Reading + Send> Topic<M> {
    /// The value of a message in the frame that is needed.
    ///
    /// # Errors
    /// No transform leads from its frame there, and this is the frame.
    fn value<'m>(&self, message: &'m M, poses: &mut Poses) -> Result<Option<Numbers>, &'m str> {
        let frame = message.frame().trim_start_matches('/');
        let numbers = message.numbers(self.wanted);
        if frame.is_empty() || frame == self.frame {
            return Ok(numbers);
        }
        let Some(numbers) = numbers else { return Ok(None) };
        // The velocity of a link is not known here.
        let found = poses.frames.find(frame, &self.frame, poses.q);
        let found = found.filter(|found| !(found.moves && self.wanted.has_velocity())).ok_or(frame)?;
        numbers.in_frame(self.wanted, &found.pose).ok_or(frame).map(Some)
    }
}

impl<M: Reading + Send> Reader for Topic<M> {
    fn look(&mut self, node: &Node, signals: &mut Signals) {
        let is_published = self.subscription.get_publisher_count(node) > 0;
        if std::mem::replace(&mut self.is_published, is_published) && !is_published && self.is_latched {
            signals.clear(self.signal);
        }
    }

    fn read(&mut self, time: f64, poses: &mut Poses, signals: &mut Signals, remarks: &mut Remarks) {
        for _ in 0..quality::MOST {
            match self.subscription.take() {
                Ok(None) => return,
                Ok(Some((message, _))) => match self.value(&message, poses) {
                    Ok(Some(numbers)) => {
                        self.rejected = None;
                        signals.set(self.signal, numbers.as_slice(), time);
                    }
                    Ok(None) => {}
                    // A transform may come a little later than the first message.
                    Err(_) if time - *self.rejected.get_or_insert(time) < TRANSFORMS => {}
                    Err(frame) => remarks(Remark::OtherFrame {
                        topic: self.topic.clone(),
                        frame: frame.to_string(),
                        needed: self.frame.clone(),
                    }),
                },
                Err(e) => remarks(Remark::Unreadable { topic: self.topic.clone(), why: e.to_string() }),
            }
        }
    }
}

/// Subscribes to the topic of a signal.
///
/// # Errors
/// The client library refuses the topic, or the type of its messages is not known.
pub fn subscribe(
    node: &mut Node,
    ros: &RosProgram,
    topic: &SignalTopic,
    program: &Program,
) -> Result<Box<dyn Reader>, RosError> {
    let from = Source { node, ros, topic, program };
    match topic.message.as_str() {
        "std_msgs/Bool" => from.reader::<Bool>(),
        "std_msgs/Float64" => from.reader::<Float64>(),
        "std_msgs/Float32" => from.reader::<Float32>(),
        "geometry_msgs/Point" | "geometry_msgs/Vector3" => from.reader::<Vector3>(),
        "geometry_msgs/PointStamped" | "geometry_msgs/Vector3Stamped" => from.reader::<Vector3Stamped>(),
        "geometry_msgs/Pose" => from.reader::<Pose>(),
        "geometry_msgs/PoseStamped" => from.reader::<PoseStamped>(),
        "geometry_msgs/QuaternionStamped" => from.reader::<QuaternionStamped>(),
        "geometry_msgs/Wrench" => from.reader::<Wrench>(),
        "geometry_msgs/WrenchStamped" => from.reader::<WrenchStamped>(),
        "sensor_msgs/Imu" => from.reader::<Imu>(),
        "nav_msgs/Odometry" => from.reader::<Odometry>(),
        other => Err(RosError::Message(other.to_string())),
    }
}

struct Source<'a> {
    node: &'a mut Node,
    ros: &'a RosProgram,
    topic: &'a SignalTopic,
    program: &'a Program,
}

impl Source<'_> {
    fn reader<M: Reading + Send>(self) -> Result<Box<dyn Reader>, RosError> {
        let signal = self.program.interface.signals.get(self.topic.signal);
        let signal = signal.ok_or_else(|| RosError::Message(format!("signal {}", self.topic.signal)))?;
        let name = resolved(self.ros, &self.topic.topic);
        let quality = if self.topic.latched { quality::kept() } else { quality::sensor() };
        let topic = self.node.create_topic(&absolute(&name)?, message_type(&self.topic.message), &quality)?;
        // A sensor's axes are those of its link; everything else is in the world.
        let link = signal.conditioning.frame.map(|l| self.program.robot.model.link_ref(l).name.clone());
        let frame = self.topic.frame.clone().or(link).unwrap_or_else(|| self.ros.world.clone());
        Ok(Box::new(Topic::<M> {
            subscription: self.node.create_subscription(&topic, Some(quality))?,
            signal: self.topic.signal,
            wanted: Wanted::by(signal),
            topic: name,
            frame: frame.trim_start_matches('/').to_string(),
            rejected: None,
            is_latched: self.topic.latched,
            is_published: false,
        }))
    }
}
