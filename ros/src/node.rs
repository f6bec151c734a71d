//! The node: begins when all joints are known and its commands are read, and ticks until it is ended.

use std::collections::BTreeMap;
use std::io;
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use ros2_client::dds::rustdds::mio1::{Events, Interest, Poll, Token};
use ros2_client::{Context, ContextOptions, Node, NodeOptions, ParameterValue, ServiceMapping};
use runtime::program::{Program, RobotProgram, RosProgram, TickSource};
use runtime::{Controller, Intervals, Observation, Recorder, Request, Tick};

use crate::RosError;
use crate::commands::Motion;
use crate::inputs::{At, Inputs, Once};
use crate::joints::Configuration;
use crate::names::{node_name, resolved};
use crate::neighbours::{Neighbours, Used};
use crate::outputs::Outputs;
use crate::remark::{Remark, Tell};
use crate::telemetry::Telemetry;

/// Time between two remarks of a node that waits.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time for which a node that ends repeats the command to stand, since the last message may be lost.
const FAREWELL: Duration = Duration::from_millis(60);
/// Pause of a node that waits for joints.
const PAUSE: Duration = Duration::from_millis(2);
/// Longest time in which a node that ends brings its robot to rest (s).
const TO_REST: f64 = 5.0;
/// Time between two looks at who reads the commands (s).
const LOOK: f64 = 0.1;
/// Intervals between messages without one after which a tick that messages begin begins all the same.
const OVERDUE: f64 = 2.0;
/// Part of the deadline after which it begins in any case: a message that is lost is no fault.
const IN_TIME: f64 = 0.9;
/// Weight of the last interval in the mean interval between messages.
const NEWEST: f64 = 0.1;

/// Settings of a node that are not in the spec.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Domain: `ROS_DOMAIN_ID`.
    pub domain: u16,
    /// Mapping of services, which depends on the middleware of the others.
    pub mapping: ServiceMapping,
    /// Parameters that others may read, by name.
    pub parameters: BTreeMap<String, f64>,
    /// Duration of the run (s); `None` for ever.
    pub duration: Option<f64>,
}

/// Result of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ended {
    /// Number of ticks.
    pub ticks: usize,
    /// Ticks that began later than half a period after their time.
    pub late: usize,
    /// Greatest lateness of a tick (s).
    pub latest: f64,
    /// Longest computing time of a tick (s).
    pub longest: f64,
    /// Ticks that were not shown to others.
    pub not_shown: u64,
    /// Intervals between the ticks.
    pub intervals: Intervals,
    /// True if the machine has ended.
    pub is_final: bool,
    /// True if a fault keeps the robot still.
    pub is_halted: bool,
}

/// Wakes a loop at its time, or when a message arrives.
struct Waiting {
    poll: Option<Poll>,
    events: Events,
    period: Duration,
    deadline: Duration,
    next: Instant,
    /// The last message that began a tick, and the mean interval between them: a driver may be slower than the controller.
    message: Instant,
    interval: Duration,
}

impl Waiting {
    fn new(source: TickSource, inputs: &mut Inputs, robot: &RobotProgram) -> Result<Waiting, io::Error> {
        let poll = match (source, inputs.first()) {
            (TickSource::JointStates, Some(first)) => {
                let poll = Poll::new()?;
                poll.registry().register(first, Token(0), Interest::READABLE)?;
                Some(poll)
            }
            _ => None,
        };
        let [period, deadline] = [robot.period, robot.deadline].map(Duration::from_secs_f64);
        let (events, message) = (Events::with_capacity(8), Instant::now());
        Ok(Waiting { poll, events, period, deadline, next: message + period, message, interval: period })
    }

    /// Waits for the next tick, and returns how late it is (s).
    fn wait(&mut self) -> Result<f64, io::Error> {
        let now = Instant::now();
        if let Some(poll) = &mut self.poll {
            let expected = self.period.max(self.interval);
            let patience = expected.mul_f64(OVERDUE).min(self.deadline.mul_f64(IN_TIME));
            match poll.poll(&mut self.events, Some(patience)) {
                Err(e) if e.kind() != io::ErrorKind::Interrupted => return Err(e),
                _ => {}
            }
            if !self.events.is_empty() {
                let last = std::mem::replace(&mut self.message, Instant::now());
                // A driver that was silent is no slower for it.
                let newest = (self.message - last).min(patience);
                self.interval = self.interval.mul_f64(1.0 - NEWEST) + newest.mul_f64(NEWEST);
            }
            return Ok(now.elapsed().saturating_sub(expected).as_secs_f64());
        }
        std::thread::sleep(self.next.saturating_duration_since(now));
        let late = self.next.elapsed();
        // Ticks that were missed are not made up for: the next one is on the grid of the first.
        let missed = late.as_nanos() / self.period.as_nanos().max(1);
        self.next += self.period * (1 + u32::try_from(missed).unwrap_or(u32::MAX - 1));
        Ok(late.as_secs_f64())
    }
}

/// Repeats the last position and the velocity zero, also if the loop ends by an error.
struct Farewell<'a> {
    outputs: &'a Outputs,
    position: Vec<f64>,
}

impl Drop for Farewell<'_> {
    fn drop(&mut self) {
        let until = Instant::now() + FAREWELL;
        while Instant::now() < until {
            self.outputs.stand(&self.position);
            std::thread::sleep(FAREWELL / 6);
        }
    }
}

/// Topics of a connection, by resolved name.
fn topics(ros: &RosProgram) -> BTreeMap<String, Used> {
    let joints = ros.joint_states.iter().map(|j| (&j.topic, "sensor_msgs/JointState", None));
    let odometry = ros.odometry.iter().map(|o| (&o.topic, "nav_msgs/Odometry", None));
    let signals = ros.signals.iter().map(|s| (&s.topic, s.message.as_str(), Some(s.latched)));
    let commands = ros.commands.iter().map(|c| (&c.topic, c.form.message(), None));
    let all = joints.chain(odometry).chain(signals).chain(commands);
    all.map(|(topic, kind, latched)| (resolved(ros, topic), Used { kind: kind.to_string(), latched })).collect()
}

/// A node that has begun: what it reads and writes, and the threads that serve it.
struct Connection {
    inputs: Inputs,
    outputs: Outputs,
    // Dropped in this order: the watcher, then the node, which ends its spinner.
    _neighbours: Neighbours,
    node: Node,
    spinning: JoinHandle<()>,
}

impl Connection {
    fn new(program: &Program, ros: &RosProgram, settings: &Settings, tell: &Tell) -> Result<Connection, RosError> {
        let context = Context::with_options(ContextOptions::new().domain_id(settings.domain))?;
        // Parameters are declared by setting them to their own values.
        let own = settings.parameters.clone();
        let fixed = move |name: &str, value: &ParameterValue| match (own.get(name), value) {
            (Some(own), ParameterValue::Double(value)) if own == value => Ok(()),
            _ => Err(format!("`{name}` is a part of the compiled spec: start the node again with `--set {name}=..`")),
        };
        let mut options = NodeOptions::new().enable_rosout(true).parameter_validator(Box::new(fixed));
        for (name, value) in &settings.parameters {
            options = options.declare_parameter(name, ParameterValue::Double(*value));
        }
        let mut node = context.new_node(node_name(ros)?, options)?;
        let spinner = node.spinner()?;
        let spin = move || drop(futures_executor::block_on(spinner.spin()));
        let spinning = std::thread::Builder::new().name("spinner".to_string()).spawn(spin)?;
        Ok(Connection {
            inputs: Inputs::new(&mut node, ros, program, settings.mapping)?,
            outputs: Outputs::new(&mut node, ros, &program.robot.model, program.robot.period)?,
            _neighbours: Neighbours::watch(context, topics(ros), Tell::clone(tell))?,
            node,
            spinning,
        })
    }

    /// Waits until all joints are known and the commands are read, since a reference that moves alone would leave the robot behind;
    /// false if it was told to end before.
    fn wait_for_robot(&mut self, q: &mut Configuration, clock: Instant, once: &mut Once, go_on: GoOn) -> bool {
        let mut next = PATIENCE;
        loop {
            if !go_on() {
                return false;
            }
            self.inputs.configuration(q, clock.elapsed().as_secs_f64(), once);
            let unread = self.outputs.unread(&self.node);
            if q.is_known() && unread.is_empty() {
                return true;
            }
            if clock.elapsed() > next {
                next += PATIENCE;
                once.tell(if q.is_known() {
                    Remark::NobodyReads { topics: unread }
                } else {
                    let (joints, topics) = (q.unknown(), self.inputs.topics.clone());
                    Remark::WaitingFor { joints, topics, strangers: q.strangers() }
                });
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn end(self) {
        let Connection { inputs, outputs, _neighbours, node, spinning } = self;
        drop((_neighbours, inputs, outputs));
        drop(node);
        // A spinner that panicked has said so.
        let _ = spinning.join();
    }
}

/// Asks whether to go on.
type GoOn<'a> = &'a mut dyn FnMut() -> bool;

/// Runs a program as a node, until `go_on` returns false, the duration has passed, or the machine has ended.
///
/// # Errors
/// The node cannot begin, or the recorder has failed; the robot has been commanded to stand.
pub fn run(
    program: &Program,
    settings: &Settings,
    recorder: &mut dyn Recorder,
    go_on: GoOn,
    tell: &Tell,
) -> Result<Ended, RosError> {
    let ros = RosProgram::of(program);
    let mut controller = Controller::new(program)?;
    if ros.tick == TickSource::JointStates {
        // The driver calls, at a rate of its own.
        controller.called_every(None);
    }
    let mut connection = Connection::new(program, &ros, settings, tell)?;
    let mut q = Configuration::new(&program.robot.model, ros.stale_after);
    let mut once = Once::new(Tell::clone(tell));
    let mut telemetry = Telemetry::prepare(&mut connection.node, &ros, program, &controller, Tell::clone(tell))?;
    let clock = Instant::now();
    if !connection.wait_for_robot(&mut q, clock, &mut once, go_on) {
        drop(telemetry);
        connection.end();
        return Ok(Ended::default());
    }
    tell(&Remark::Running);
    let epoch = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_nanos() as u64;
    telemetry.start(epoch);
    let waiting = Waiting::new(ros.tick, &mut connection.inputs, &program.robot)?;
    let mut driven = Driven {
        zero: clock.elapsed().as_secs_f64(),
        clock,
        velocity: vec![0.0; program.robot.model.nv()],
        position: program.robot.home.clone(),
        requests: Vec::with_capacity(64),
        ended: Ended::default(),
        waiting,
        q,
        once,
    };
    let result = driven.ticks(settings.duration, &mut controller, &mut connection, &mut telemetry, recorder, go_on);
    driven.ended.not_shown = telemetry.dropped;
    driven.ended.intervals = controller.intervals();
    (driven.ended.is_final, driven.ended.is_halted) = (controller.is_final(), controller.is_halted());
    drop(telemetry);
    connection.end();
    result.map(|()| driven.ended)
}

/// A robot that is driven.
struct Driven {
    clock: Instant,
    /// Time of the first tick by the clock (s).
    zero: f64,
    velocity: Vec<f64>,
    position: Vec<f64>,
    requests: Vec<Request>,
    ended: Ended,
    waiting: Waiting,
    q: Configuration,
    once: Once,
}

impl Driven {
    fn ticks(
        &mut self,
        duration: Option<f64>,
        controller: &mut Controller,
        connection: &mut Connection,
        telemetry: &mut Telemetry,
        recorder: &mut dyn Recorder,
        go_on: GoOn,
    ) -> Result<(), RosError> {
        let Connection { inputs, outputs, node, .. } = connection;
        // The last positions are finite: nothing has been read since all joints were known.
        let mut farewell = Farewell { outputs, position: self.q.last().to_vec() };
        let (mut ending, mut looked) = (None, f64::NEG_INFINITY);
        loop {
            let now = self.clock.elapsed().as_secs_f64();
            let time = now - self.zero;
            // The end of a node is a motion to rest.
            if ending.is_none() && (!go_on() || duration.is_some_and(|d| time >= d) || controller.is_final()) {
                controller.stop();
                ending = Some(time);
            }
            if ending.is_some_and(|since| controller.is_at_rest() || time - since > TO_REST) {
                break;
            }
            if now - looked > LOOK {
                looked = now;
                // A robot whose commands nobody reads stands, and stays where it is until somebody resumes.
                let unread = outputs.unread(node);
                controller.set_enabled(unread.is_empty());
                inputs.look(node, controller);
                if !unread.is_empty() {
                    self.once.tell(Remark::ReaderGone { topics: unread });
                }
            }
            inputs.read(&mut self.q, controller, At { clock: now, time }, &mut self.once);
            let q = self.q.at(now);
            // Before the controller knows where the robot is, its reference is nowhere, and must not be commanded.
            if self.ended.ticks == 0 && !q.iter().all(|x| x.is_finite()) {
                self.waiting.wait()?;
                continue;
            }
            let began = Instant::now();
            let command = controller.step(&Observation { time, q });
            let elapsed = began.elapsed().as_secs_f64();
            let (fault, lasts) = (command.fault, command.lasts);
            self.velocity.copy_from_slice(command.velocity);
            self.requests.clear();
            self.requests.extend_from_slice(command.requests);
            self.position.copy_from_slice(command.position);
            // A first command, whose duration is not known, stands.
            let lasts = if lasts > 0.0 { lasts } else { controller.period() };
            let motion = Motion { velocity: &self.velocity, position: &self.position, lasts };
            let once = &mut self.once;
            outputs.send(motion, &mut |remark| once.tell(remark));
            for request in &self.requests {
                if let Some(action) = controller.action(request) {
                    outputs.request(action, request.begin, &mut |remark| once.tell(remark));
                }
            }
            farewell.position.copy_from_slice(&self.position);
            let tick = Tick {
                index: self.ended.ticks,
                time,
                q: self.q.last(),
                v: controller.velocity(),
                command: &self.velocity,
                stack: controller.active_stack(),
                state: controller.state(),
                state_index: controller.state_index(),
                controller,
                evaluator: controller.evaluator(),
                signals: controller.signal_table(),
                problem: controller.problem(),
                solution: controller.solution(),
                fault,
                elapsed,
            };
            telemetry.take(&tick);
            recorder.tick(&tick)?;
            self.ended.ticks += 1;
            self.ended.longest = self.ended.longest.max(elapsed);
            let late = self.waiting.wait()?;
            self.ended.latest = self.ended.latest.max(late);
            self.ended.late += usize::from(late > 0.5 * controller.period());
        }
        Ok(())
    }
}
