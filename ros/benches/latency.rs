//! Time from a message with positions of joints to the command that answers it: `cargo bench -p hierarq-ros`.
//!
//! A driver in this process sends joint states and waits for commands on loopback, so that both ways through DDS are in the time: from
//! the call that publishes to the call that returns the command. The node ticks when a message arrives.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use hierarq_ros as ros;
use ros::messages::{Float64MultiArray, JointState};
use ros::names::{absolute, message_type};
use ros::{Remark, ServiceMapping, Settings};
use ros2_client::dds::rustdds::mio1::{Events, Interest, Poll, Token};
use ros2_client::{Context, ContextOptions, NodeName, NodeOptions, QosProfile};
use runs::project::{Settings as Files, load};
use runtime::record::All;
use runtime::{Recorder, Tick};

const MESSAGES: usize = 2000;
const PERIOD: Duration = Duration::from_millis(2);
const DOMAIN: u16 = 97;

#[derive(Default)]
struct Steps(Vec<f64>);

impl Recorder for Steps {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.0.push(tick.elapsed);
        Ok(())
    }
}

fn shown(name: &str, mut all: Vec<f64>) {
    all.sort_by(f64::total_cmp);
    let at = |share: f64| all.get(((all.len() - 1) as f64 * share) as usize).map_or(f64::NAN, |s| 1e6 * s);
    println!(
        "{name:<28} {:>5} values: median {:>7.1} us, p99 {:>7.1} us, worst {:>8.1} us",
        all.len(),
        at(0.5),
        at(0.99),
        at(1.0)
    );
}

fn main() {
    let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/robots/ur5.urdf");
    let text = format!(
        "hierarq 1\nrobot arm {{ urdf \"{urdf}\"  rate 500 Hz  deadline 1 s }}\n\
         task still = joint_velocity {{ velocity 0 rad/s }}\n\
         stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level rest {{ still }} }}\n\
         run {{ stack s  duration 1 s  ros {{ tick joint_states  stale_after 1 s }} }}\n"
    );
    let file = std::env::temp_dir().join(format!("hierarq-latency-{}.hq", std::process::id()));
    std::fs::write(&file, text).expect("the folder for temporary files can be written");
    let compiled = load(&file, &Files::default());
    let _ = std::fs::remove_file(&file);
    let program = compiled.program.expect("it compiles");
    let names: Vec<String> = program.robot.model.dofs.iter().map(|d| d.name.clone()).collect();

    let context = Context::with_options(ContextOptions::new().domain_id(DOMAIN)).expect("a network");
    let mut node = context
        .new_node(NodeName::new("/", "driver").expect("a name"), NodeOptions::new().enable_rosout(false))
        .expect("a node");
    let sensor = QosProfile::subscription_default();
    let topic = |node: &ros2_client::Node, name: &str, kind: &str, quality: &QosProfile| {
        node.create_topic(&absolute(name).expect("a name"), message_type(kind), quality).expect("a topic")
    };
    let states = topic(&node, "/joint_states", "sensor_msgs/JointState", &sensor);
    let states = node.create_publisher::<JointState>(&states, Some(sensor.clone())).expect("a publisher");
    let commands = topic(&node, "/hierarq/commands", "std_msgs/Float64MultiArray", &sensor);
    let mut commands = node.create_subscription::<Float64MultiArray>(&commands, Some(sensor)).expect("a subscription");
    let mut poll = Poll::new().expect("a poll");
    poll.registry().register(&mut commands, Token(0), Interest::READABLE).expect("it is registered");
    let mut events = Events::with_capacity(8);

    let end = Arc::new(AtomicBool::new(false));
    let ending = Arc::clone(&end);
    let home = program.robot.home.clone();
    let running = std::thread::spawn(move || {
        let settings = Settings {
            domain: DOMAIN,
            mapping: ServiceMapping::Enhanced,
            parameters: Default::default(),
            duration: None,
        };
        let tell: ros::Tell = Arc::new(|remark: &Remark| eprintln!("{remark}"));
        let mut steps = Steps::default();
        let mut all = All(vec![&mut steps as &mut dyn Recorder]);
        ros::run(&program, &settings, &mut all, &mut || !ending.load(Ordering::Relaxed), &tell).expect("it runs");
        steps.0
    });
    let message = || JointState { name: names.clone(), position: home.clone(), ..JointState::default() };
    let mut times = Vec::new();
    let begun = Instant::now();
    while times.len() < MESSAGES && begun.elapsed() < Duration::from_secs(60) {
        while let Ok(Some(_)) = commands.take() {}
        let sent = Instant::now();
        let _ = states.publish(message());
        let _ = poll.poll(&mut events, Some(Duration::from_millis(100)));
        if let Ok(Some(_)) = commands.take() {
            times.push(sent.elapsed().as_secs_f64());
        }
        std::thread::sleep(PERIOD.saturating_sub(sent.elapsed()));
    }
    end.store(true, Ordering::Relaxed);
    let steps = running.join().expect("the node ends");
    shown("message to command", times);
    shown("of this, the step", steps);
}
