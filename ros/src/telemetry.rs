//! The pictures that a node shows: markers, transforms, diagnostics, the state of the machine. A thread makes the messages and sends them, so
//! that a tick only copies its numbers.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use logs::topics::Topic;
use logs::{Camera, Messages, Queue, TickSender, queue};
use ros2_client::{Node, Publisher};
use runtime::program::{Program, RosProgram};
use runtime::{Controller, Tick};
use serde::Serialize;
use serde::ser::{SerializeTuple, Serializer};

use crate::RosError;
use crate::names::{absolute, message_type, resolved};
use crate::quality;
use crate::remark::{Remark, Tell};

/// Ticks that can wait.
const WAITING: usize = 64;
/// Time between two looks for ticks.
const LOOK: Duration = Duration::from_millis(5);
/// Least time between two diagnostics, in ns.
const DIAGNOSTICS: u64 = 100_000_000;
/// Length of the header of an encoded message.
const HEADER: usize = logs::cdr::HEADER.len();

/// A message that is encoded already.
struct Encoded(Vec<u8>);

impl Serialize for Encoded {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut bytes = serializer.serialize_tuple(self.0.len())?;
        for byte in &self.0 {
            bytes.serialize_element(byte)?;
        }
        bytes.end()
    }
}

/// Shows a controller to others.
pub struct Telemetry {
    /// Tells the thread the time of the start.
    start: Option<SyncSender<u64>>,
    ticks: Option<TickSender>,
    thread: Option<JoinHandle<Result<(), Infallible>>>,
    /// Ticks that were not shown.
    pub dropped: u64,
}

/// Name of the topic on which a message is shown; `None` for those that are not.
fn shown(topic: Topic, ros: &RosProgram) -> Option<&'static str> {
    match topic {
        // The driver of the robot sends the states of joints, and the topics of the spec have the commands.
        Topic::JointStates | Topic::Command | Topic::Columns => None,
        Topic::RobotDescription | Topic::FixedTransforms | Topic::Transforms if !ros.transforms => None,
        Topic::RobotDescription => Some("/robot_description"),
        Topic::FixedTransforms => Some("/tf_static"),
        Topic::Transforms => Some("/tf"),
        Topic::Diagnostics => Some("/diagnostics"),
        Topic::Walls => Some("~/walls"),
        Topic::KeepOut => Some("~/keep_out"),
        Topic::Obstacles => Some("~/obstacles"),
        Topic::People => Some("~/people"),
        Topic::ClosestPoints => Some("~/closest_points"),
        Topic::State => Some("~/state"),
        Topic::Fault => Some("~/fault"),
    }
}

impl Telemetry {
    /// Offers the topics that show a controller, which takes milliseconds, and waits for the start.
    ///
    /// # Errors
    /// The client library refuses a topic, or the system gives no thread.
    pub fn prepare(
        node: &mut Node,
        ros: &RosProgram,
        program: &Program,
        controller: &Controller,
        tell: Tell,
    ) -> Result<Telemetry, RosError> {
        let mut publishers: BTreeMap<Topic, Publisher<Encoded>> = BTreeMap::new();
        for topic in Topic::ALL {
            if let Some(name) = shown(topic, ros) {
                let quality = if topic.is_latched() { quality::latched() } else { quality::view() };
                let name = absolute(&resolved(ros, name))?;
                let made = node.create_topic(&name, message_type(topic.definition().name), &quality)?;
                publishers.insert(topic, node.create_publisher(&made, Some(quality))?);
            }
        }
        let (messages, world) = (Messages::new(program, controller), ros.world.clone());
        let (start, started) = sync_channel(1);
        let Queue { sender, receiver } = queue(Camera::new(program, controller), WAITING, LOOK);
        let mut last_diagnostics = 0;
        let mut send = move |topic: Topic, time: u64, message: &[u8]| -> std::io::Result<()> {
            if topic == Topic::Diagnostics && time < last_diagnostics + DIAGNOSTICS {
                return Ok(());
            }
            if topic == Topic::Diagnostics {
                last_diagnostics = time;
            }
            if let (Some(publisher), Some(body)) = (publishers.get(&topic), message.get(HEADER..)) {
                // A viewer that is too slow misses a picture.
                drop(publisher.publish(Encoded(body.to_vec())));
            }
            Ok(())
        };
        let show = move || {
            let Ok(epoch) = started.recv() else { return Ok(()) };
            let mut messages = messages.among_others(&world, epoch);
            let _ = messages.begin(&mut send);
            let (mut state, mut fault) = (String::new(), String::new());
            receiver.each(|tick| {
                let _ = messages.tick(tick, &mut send);
                if tick.state != state {
                    state.clone_from(&tick.state);
                    tell(&Remark::State(state.clone()));
                }
                if tick.fault != fault {
                    fault.clone_from(&tick.fault);
                    tell(&Remark::Fault(fault.clone()));
                }
                Ok::<(), Infallible>(())
            })
        };
        let thread = std::thread::Builder::new().name("telemetry".to_string()).spawn(show)?;
        Ok(Telemetry { start: Some(start), ticks: Some(sender), thread: Some(thread), dropped: 0 })
    }

    /// Begins to show the controller. `epoch` is the time of its start in ns since 1970.
    pub fn start(&self, epoch: u64) {
        // There is room for the first one.
        let _ = self.start.as_ref().is_some_and(|start| start.try_send(epoch).is_ok());
    }

    /// Shows a tick, unless the thread is behind.
    pub fn take(&mut self, tick: &Tick) {
        let sent = self.ticks.as_mut().is_some_and(|ticks| ticks.send(tick).is_ok());
        self.dropped += u64::from(!sent);
    }
}

impl Drop for Telemetry {
    fn drop(&mut self) {
        (self.start, self.ticks) = (None, None);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so.
            let _ = thread.join();
        }
    }
}
