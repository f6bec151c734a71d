//! Time from a message with positions of joints to the command that answers it: `cargo bench -p hierarq-ros`.
//!
//! A driver in this process sends joint states and waits for commands on loopback, so that both ways through DDS are in the time: from
//! the call that publishes to the call that returns the command. Its messages go in turn to an echo, which answers with the library
//! alone, and to a node, which ticks when a message arrives. The echo and the node are participants of their own. Before, two threads
//! wake each other, as those of the library do.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use hierarq_ros as ros;
use ros::messages::{Float64MultiArray, JointState};
use ros::names::{absolute, message_type};
use ros::{Remark, ServiceMapping, Settings};
use ros2_client::dds::rustdds::Topic;
use ros2_client::dds::rustdds::mio1::{Events, Interest, Poll, Token, Waker};
use ros2_client::{Context, ContextOptions, Node, NodeName, NodeOptions, Publisher, QosProfile, Subscription};
use runs::project::{Settings as Files, load};
use runtime::record::All;
use runtime::{Program, Recorder, Tick};

const MESSAGES: usize = 2000;
const PERIOD: Duration = Duration::from_millis(2);
const PATIENCE: Duration = Duration::from_millis(100);
const DOMAIN: u16 = 97;

#[derive(Default)]
struct Steps(Vec<f64>);

impl Recorder for Steps {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.0.push(tick.elapsed);
        Ok(())
    }
}

/// Prints a distribution, without its first values, and these.
fn shown(name: &str, all: &[f64]) {
    let (first, later) = all.split_at(all.len().min(3));
    let mut later = later.to_vec();
    later.sort_by(f64::total_cmp);
    let at =
        |share: f64| later.get((later.len().saturating_sub(1) as f64 * share) as usize).map_or(f64::NAN, |s| 1e6 * s);
    let first: Vec<String> = first.iter().map(|s| format!("{:.0}", 1e6 * s)).collect();
    println!(
        "{name:<28} median {:>6.1}  p90 {:>6.1}  p99 {:>6.1}  worst {:>8.1} us of {}; the first {} us",
        at(0.5),
        at(0.9),
        at(0.99),
        at(1.0),
        later.len(),
        first.join(", ")
    );
}

fn participant(name: &str) -> (Context, Node) {
    let context = Context::with_options(ContextOptions::new().domain_id(DOMAIN)).expect("a network");
    let options = NodeOptions::new().enable_rosout(false);
    let node = context.new_node(NodeName::new("/", name).expect("a name"), options).expect("a node");
    (context, node)
}

/// Names of the topics of an echo or of a node.
#[derive(Clone, Copy)]
struct Names {
    states: &'static str,
    commands: &'static str,
}

const ECHO: Names = Names { states: "/echo/joint_states", commands: "/echo/commands" };
const NODE: Names = Names { states: "/joint_states", commands: "/hierarq/commands" };

fn states(node: &mut Node, names: Names) -> Topic {
    let sensor = QosProfile::subscription_default();
    node.create_topic(&absolute(names.states).expect("a name"), message_type("sensor_msgs/JointState"), &sensor)
        .expect("a topic")
}

fn commands(node: &mut Node, names: Names) -> Topic {
    let sensor = QosProfile::subscription_default();
    node.create_topic(&absolute(names.commands).expect("a name"), message_type("std_msgs/Float64MultiArray"), &sensor)
        .expect("a topic")
}

/// Waits for messages of a subscription.
struct Waiter {
    poll: Poll,
    events: Events,
}

impl Waiter {
    fn new<M: serde::de::DeserializeOwned + 'static>(of: &mut Subscription<M>) -> Waiter {
        let poll = Poll::new().expect("a poll");
        poll.registry().register(of, Token(0), Interest::READABLE).expect("it is registered");
        Waiter { poll, events: Events::with_capacity(8) }
    }

    fn wait(&mut self) {
        let _ = self.poll.poll(&mut self.events, Some(PATIENCE));
    }
}

/// The side of the driver.
struct Driver {
    to: Publisher<JointState>,
    from: Subscription<Float64MultiArray>,
    waiter: Waiter,
    times: Vec<f64>,
}

impl Driver {
    fn new(node: &mut Node, names: Names) -> Driver {
        let sensor = QosProfile::subscription_default();
        let (states, commands) = (states(node, names), commands(node, names));
        let to = node.create_publisher(&states, Some(sensor.clone())).expect("a publisher");
        let mut from = node.create_subscription(&commands, Some(sensor)).expect("a subscription");
        let waiter = Waiter::new(&mut from);
        Driver { to, from, waiter, times: Vec::new() }
    }

    fn ask(&mut self, message: JointState) {
        while let Ok(Some(_)) = self.from.take() {}
        let sent = Instant::now();
        let _ = self.to.publish(message);
        self.waiter.wait();
        if let Ok(Some(_)) = self.from.take() {
            self.times.push(sent.elapsed().as_secs_f64());
        }
        std::thread::sleep(PERIOD.saturating_sub(sent.elapsed()));
    }
}

/// Answers each message with as many numbers.
fn echo(end: &AtomicBool) {
    let (_context, mut node) = participant("echo");
    let (states, commands) = (states(&mut node, ECHO), commands(&mut node, ECHO));
    let mut from = node
        .create_subscription::<JointState>(&states, Some(QosProfile::subscription_default()))
        .expect("a subscription");
    // The quality of commands of a node.
    let to = node.create_publisher(&commands, Some(QosProfile::publisher_default())).expect("a publisher");
    let mut waiter = Waiter::new(&mut from);
    while !end.load(Ordering::Relaxed) {
        waiter.wait();
        while let Ok(Some((message, _))) = from.take() {
            let _ = to.publish(Float64MultiArray { data: message.position, ..Float64MultiArray::default() });
        }
    }
}

/// Times in which a thread wakes another one and is woken by it.
fn wakes() -> Vec<f64> {
    let waiting = || {
        let poll = Poll::new().expect("a poll");
        let waker = Waker::new(poll.registry(), Token(0)).expect("a waker");
        (poll, waker)
    };
    let ((mut here, wake_here), (mut there, wake_there)) = (waiting(), waiting());
    let end = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut events = Events::with_capacity(8);
            while !end.load(Ordering::Relaxed) {
                let _ = there.poll(&mut events, Some(PATIENCE));
                if !events.is_empty() {
                    let _ = wake_here.wake();
                }
            }
        });
        let mut events = Events::with_capacity(8);
        let mut times = Vec::new();
        for _ in 0..MESSAGES {
            let before = Instant::now();
            let _ = wake_there.wake();
            let _ = here.poll(&mut events, Some(PATIENCE));
            times.push(before.elapsed().as_secs_f64());
            std::thread::sleep(PERIOD);
        }
        end.store(true, Ordering::Relaxed);
        times
    })
}

/// A program whose period is that of the messages that the node gets: one of two.
fn program() -> Program {
    let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/robots/ur5.urdf");
    let text = format!(
        "hierarq 1\nrobot arm {{ urdf \"{urdf}\"  rate 250 Hz  deadline 1 s }}\n\
         task still = joint_velocity {{ velocity 0 rad/s }}\n\
         stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level rest {{ still }} }}\n\
         run {{ stack s  duration 1 s  ros {{ tick joint_states  stale_after 1 s }} }}\n"
    );
    let file = std::env::temp_dir().join(format!("hierarq-latency-{}.hq", std::process::id()));
    std::fs::write(&file, text).expect("the folder for temporary files can be written");
    let compiled = load(&file, &Files::default());
    let _ = std::fs::remove_file(&file);
    compiled.program.expect("it compiles")
}

fn main() {
    shown("two wakes of threads", &wakes());
    let program = program();
    let names: Vec<String> = program.robot.model.dofs.iter().map(|d| d.name.clone()).collect();
    let home = program.robot.home.clone();
    let (_context, mut node) = participant("driver");
    let mut drivers = [Driver::new(&mut node, ECHO), Driver::new(&mut node, NODE)];
    let end = AtomicBool::new(false);
    let steps = std::thread::scope(|scope| {
        scope.spawn(|| echo(&end));
        let running = scope.spawn(|| {
            let settings = Settings {
                domain: DOMAIN,
                mapping: ServiceMapping::Enhanced,
                parameters: BTreeMap::new(),
                duration: None,
            };
            let tell: ros::Tell = Arc::new(|remark: &Remark| eprintln!("{remark}"));
            let mut steps = Steps::default();
            let mut all = All(vec![&mut steps as &mut dyn Recorder]);
            ros::run(&program, &settings, &mut all, &mut || !end.load(Ordering::Relaxed), &tell).expect("it runs");
            steps.0
        });
        let begun = Instant::now();
        let done = |drivers: &[Driver; 2]| drivers.iter().all(|d| d.times.len() >= MESSAGES);
        while !done(&drivers) && begun.elapsed() < Duration::from_secs(60) {
            for driver in &mut drivers {
                driver.ask(JointState { name: names.clone(), position: home.clone(), ..JointState::default() });
            }
        }
        end.store(true, Ordering::Relaxed);
        running.join().expect("the node ends")
    });
    let [echo, node] = drivers;
    shown("echo of the library", &echo.times);
    shown("message to command", &node.times);
    shown("of this, the step", &steps);
}
