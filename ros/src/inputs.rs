//! All that a node reads, in the order of a tick: transforms, joints, bases, signals, services.

use std::collections::BTreeSet;

use ros2_client::{Node, ServiceMapping, Subscription};
use runtime::Controller;
use runtime::program::{Program, RosProgram};

use crate::RosError;
use crate::frames::Frames;
use crate::joints::{Configuration, Mistake, Publishers};
use crate::messages::{JointState, Odometry, Transforms};
use crate::names::{absolute, message_type, resolved};
use crate::quality;
use crate::remark::{Remark, Tell};
use crate::services::{self, Call, Trigger};
use crate::signals::{self, Poses, Reader};

struct JointTopic {
    subscription: Subscription<JointState>,
    prefix: String,
    publishers: Publishers,
    topic: String,
}

struct OdometryTopic {
    subscription: Subscription<Odometry>,
    topic: String,
    /// Index of the base.
    base: usize,
    /// Frame that poses must be in.
    world: String,
}

/// Time after a call of `~/motion/relocated` in which bases may jump (s): a localiser takes its time, and messages are on their way.
const RELOCATION: f64 = 1.0;

/// All that a node reads.
pub struct Inputs {
    transforms: Subscription<Transforms>,
    frames: Frames,
    joints: Vec<JointTopic>,
    odometry: Vec<OdometryTopic>,
    signals: Vec<Box<dyn Reader>>,
    services: Vec<Trigger>,
    /// Time by the clock of the node until which a jump of a base is a relocalisation (s).
    relocates_until: f64,
    /// Resolved names of topics of the configuration.
    pub topics: Vec<String>,
}

/// A moment.
#[derive(Clone, Copy)]
pub struct At {
    /// By the clock of the node (s).
    pub clock: f64,
    /// Since the first tick (s).
    pub time: f64,
}

/// Remarks, each told once.
pub struct Once {
    tell: Tell,
    told: BTreeSet<Remark>,
}

impl Once {
    /// Tells nothing yet.
    pub fn new(tell: Tell) -> Once {
        Once { tell, told: BTreeSet::new() }
    }

    /// Tells a remark, unless it was told before.
    pub fn tell(&mut self, remark: Remark) {
        if !self.told.contains(&remark) {
            (self.tell)(&remark);
            self.told.insert(remark);
        }
    }
}

impl Inputs {
    /// Subscribes to the topics of a connection, and offers its services.
    ///
    /// # Errors
    /// The client library refuses one.
    pub fn new(
        node: &mut Node,
        ros: &RosProgram,
        program: &Program,
        mapping: ServiceMapping,
    ) -> Result<Inputs, RosError> {
        let quality = quality::sensor();
        let (mut joints, mut topics) = (Vec::new(), Vec::new());
        for states in &ros.joint_states {
            let name = resolved(ros, &states.topic);
            let topic = node.create_topic(&absolute(&name)?, message_type("sensor_msgs/JointState"), &quality)?;
            joints.push(JointTopic {
                subscription: node.create_subscription(&topic, Some(quality.clone()))?,
                prefix: states.prefix.clone(),
                publishers: Publishers::default(),
                topic: name.clone(),
            });
            topics.push(name);
        }
        let mut odometry = Vec::new();
        for of in &ros.odometry {
            let name = resolved(ros, &of.topic);
            let topic = node.create_topic(&absolute(&name)?, message_type("nav_msgs/Odometry"), &quality)?;
            odometry.push(OdometryTopic {
                subscription: node.create_subscription(&topic, Some(quality.clone()))?,
                topic: name.clone(),
                base: of.base,
                world: ros.world.trim_start_matches('/').to_string(),
            });
            topics.push(name);
        }
        let mut signals = Vec::new();
        for topic in &ros.signals {
            signals.push(signals::subscribe(node, ros, topic, program)?);
        }
        let quality = quality::kept();
        let fixed = node.create_topic(&absolute("/tf_static")?, message_type("tf2_msgs/TFMessage"), &quality)?;
        let services = services::offer(node, ros, program, mapping)?;
        let transforms = node.create_subscription(&fixed, Some(quality))?;
        let frames = Frames::new(&program.robot.model, &ros.world);
        let relocates_until = f64::NEG_INFINITY;
        Ok(Inputs { transforms, frames, joints, odometry, signals, services, relocates_until, topics })
    }

    /// Looks whether the publishers of latched signals are still there.
    pub fn look(&mut self, node: &Node, controller: &mut Controller) {
        self.signals.iter_mut().for_each(|reader| reader.look(node, controller.signals()));
    }

    /// Takes the messages that have arrived.
    pub fn read(&mut self, q: &mut Configuration, controller: &mut Controller, at: At, once: &mut Once) {
        for _ in 0..quality::MOST {
            let Ok(Some((message, _))) = self.transforms.take() else { break };
            message.transforms.iter().for_each(|transform| self.frames.place(transform));
        }
        let jumps = self.configuration(q, at.clock, once);
        self.frames.moved();
        let mut poses = Poses { frames: &mut self.frames, q: q.last() };
        for reader in &mut self.signals {
            reader.read(at.time, &mut poses, controller.signals(), &mut |remark| once.tell(remark));
        }
        let until = &mut self.relocates_until;
        for service in &self.services {
            service.serve(|call| match call {
                Call::Raise(_) if controller.is_halted() => Err("a fault keeps the robot still: restart first".into()),
                Call::Raise(event) => {
                    controller.signals().raise(event);
                    Ok(())
                }
                Call::Restart => {
                    controller.restart();
                    Ok(())
                }
                Call::Stop => {
                    controller.stop();
                    Ok(())
                }
                Call::Resume if controller.is_halted() => Err("a fault keeps the robot still: restart first".into()),
                Call::Resume if !controller.is_enabled() => Err("the robot takes no commands".into()),
                Call::Resume => {
                    controller.resume();
                    Ok(())
                }
                Call::Relocated => {
                    *until = at.clock + RELOCATION;
                    Ok(())
                }
            });
        }
        // After the services: the call may have arrived with the pose that it announces.
        if jumps && at.clock <= *until {
            controller.relocated();
        }
    }

    /// Takes the positions of joints and the poses of bases at a time by the clock (s). Returns true if a base has jumped.
    pub fn configuration(&mut self, q: &mut Configuration, time: f64, once: &mut Once) -> bool {
        let mut jumps = false;
        for JointTopic { subscription, prefix, publishers, topic } in &mut self.joints {
            for _ in 0..quality::MOST {
                let taken = match subscription.take() {
                    Ok(None) => break,
                    Ok(Some((message, info))) => {
                        q.joints(&message, prefix, publishers, info.publisher_gid().to_bytes16(), time)
                    }
                    Err(e) => {
                        once.tell(Remark::Unreadable { topic: topic.clone(), why: e.to_string() });
                        continue;
                    }
                };
                match taken {
                    Ok(()) => {}
                    Err(Mistake::TwoSources { joint }) => once.tell(Remark::TwoSources { topic: topic.clone(), joint }),
                    Err(e) => once.tell(Remark::Unreadable { topic: topic.clone(), why: e.to_string() }),
                }
            }
        }
        for OdometryTopic { subscription, topic, base, world } in &self.odometry {
            for _ in 0..quality::MOST {
                match subscription.take() {
                    Ok(None) => break,
                    Ok(Some((message, _))) => match q.odometry(*base, &message, world, time) {
                        Err(Mistake::OtherFrame { frame }) => {
                            once.tell(Remark::OtherFrame { topic: topic.clone(), frame, needed: world.clone() });
                        }
                        taken => jumps |= taken.unwrap_or(false),
                    },
                    Err(e) => once.tell(Remark::Unreadable { topic: topic.clone(), why: e.to_string() }),
                }
            }
        }
        jumps
    }

    /// The first topic of joints.
    pub fn first(&mut self) -> Option<&mut Subscription<JointState>> {
        self.joints.first_mut().map(|joints| &mut joints.subscription)
    }
}
