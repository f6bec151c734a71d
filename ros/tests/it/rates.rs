//! Drivers of several rates: the motion is that of the spec.
//!
//! A driver in this process integrates what it is sent, a thousand times a second, and publishes where its joints are at a rate of its own.
//! It needs no interpreter.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ros::messages::{Float64MultiArray, JointState};
use ros::names::{absolute, message_type};
use ros::{Remark, ServiceMapping, Settings};
use ros2_client::{Context, ContextOptions, NodeName, NodeOptions, QosProfile};
use runtime::record::All;
use runtime::{Controller, Observation, Program};

use crate::peers::domain;
use crate::specs::{arm, program};

/// Length of the motion (rad), its speed (rad/s), and its parts between which time is measured.
const WAY: f64 = 1.0;
const SPEED: f64 = 0.6;
const FROM: f64 = 0.1;
const TO: f64 = 0.9;
/// Time between two steps of the driver.
const STEP: Duration = Duration::from_millis(1);
/// Time after which a motion has failed.
const PATIENCE: Duration = Duration::from_secs(20);

/// A way of sending commands, and of beginning ticks.
#[derive(Clone, Copy, Debug)]
struct Door {
    tick: &'static str,
    form: &'static str,
}

impl Door {
    fn program(self) -> Program {
        let Door { tick, form } = self;
        program(
            &(arm("} ")
                + &format!(
                    "task there = track(joint(shoulder_pan_joint)) {{
                       target trapezoid({WAY} rad, speed: {SPEED} rad/s, acceleration: 2 rad/s^2)  gain 3 /s
                     }}
                     stack s {{ level limits hard {{ joint_velocity_limits  joint_acceleration_limits }}  level move {{ there }} }}
                     run {{ stack s  duration 1 s  ros {{ tick {tick}  stale_after 3 s  commands {{ arm {{ topic \"~/commands\"  form {form} }} }} }} }}"
                )),
        )
    }

    /// Positions of the first joint (rad) with their times (s), beside a driver of this rate (Hz).
    fn motion(self, rate: f64) -> Vec<[f64; 2]> {
        let program = self.program();
        let (domain, end) = (domain(), AtomicBool::new(false));
        std::thread::scope(|scope| {
            let node = scope.spawn(|| {
                let settings = Settings {
                    domain,
                    mapping: ServiceMapping::Cyclone,
                    parameters: Default::default(),
                    duration: None,
                };
                let mut go_on = || !end.load(Ordering::Relaxed);
                let tell: ros::Tell = Arc::new(|_: &Remark| ());
                ros::run(&program, &settings, &mut All(Vec::new()), &mut go_on, &tell).expect("a node that runs")
            });
            let trace = self.driver(&program, rate, domain);
            end.store(true, Ordering::Relaxed);
            let ended = node.join().expect("a node that ends");
            assert!(!ended.is_halted, "{self:?} at {rate} Hz: {ended:?}");
            // Each message of a driver that is slower than the spec begins one tick.
            let measured = ended.intervals.rate().expect("ticks");
            assert!(
                self.tick == "timer" || rate > 200.0 || (measured / rate - 1.0).abs() < 0.1,
                "{self:?}: {measured} Hz"
            );
            trace
        })
    }

    fn driver(self, program: &Program, rate: f64, domain: u16) -> Vec<[f64; 2]> {
        let context = Context::with_options(ContextOptions::new().domain_id(domain)).expect("a network");
        let name = NodeName::new("/", "driver").expect("a name");
        let mut node = context.new_node(name, NodeOptions::new().enable_rosout(false)).expect("a node");
        let sensor = QosProfile::subscription_default();
        let topic = |name: &str, kind: &str| {
            node.create_topic(&absolute(name).expect("a name"), message_type(kind), &sensor).expect("a topic")
        };
        let states = topic("/joint_states", "sensor_msgs/JointState");
        let commands = topic("/hierarq/commands", "std_msgs/Float64MultiArray");
        let states = node.create_publisher::<JointState>(&states, None).expect("a publisher");
        let commands = node.create_subscription::<Float64MultiArray>(&commands, None).expect("a subscription");
        let names: Vec<String> = program.robot.model.dofs.iter().map(|d| d.name.clone()).collect();
        // A servo reaches its set point when the next one is due.
        let interval = if self.tick == "timer" { program.robot.period } else { 1.0 / rate };
        let mut position = program.robot.home.clone();
        let mut velocity = vec![0.0; position.len()];
        let mut trace = Vec::new();
        let start = Instant::now();
        let (mut last, mut published, mut left) = (0.0, 0.0, 0.0);
        let mut next = start + STEP;
        while trace.last().is_none_or(|[_, q]: &[f64; 2]| *q < 0.98 * WAY) {
            assert!(start.elapsed() < PATIENCE, "{self:?} at {rate} Hz: {:?}", trace.last());
            let now = start.elapsed().as_secs_f64();
            // A set point that was reached is kept.
            let moving = if self.form == "position" { f64::min(now - last, left) } else { now - last };
            position.iter_mut().zip(&velocity).for_each(|(q, v)| *q += moving * v);
            (last, left) = (now, left - moving);
            while let Ok(Some((command, _))) = commands.take() {
                velocity = command.data;
                if self.form == "position" {
                    velocity.iter_mut().zip(&position).for_each(|(v, q)| *v = (*v - q) / interval);
                    left = interval;
                }
            }
            trace.push([now, position[0]]);
            if now >= published {
                published = f64::max(published + 1.0 / rate, now);
                let (name, position) = (names.clone(), position.clone());
                states.publish(JointState { name, position, ..JointState::default() }).expect("it is sent");
            }
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
            next = Instant::max(next + STEP, Instant::now());
        }
        trace
    }
}

/// Times at which a motion has gone parts of its way (s), since the first of them.
fn times(trace: &[[f64; 2]]) -> Vec<f64> {
    let at = |part: f64| {
        let after = trace.iter().position(|[_, q]| *q >= part * WAY).expect("it went there");
        let ([t0, q0], [t1, q1]) = (trace[after - 1], trace[after]);
        t0 + (t1 - t0) * (part * WAY - q0) / (q1 - q0)
    };
    (0..9).map(|i| at(FROM + (TO - FROM) * f64::from(i) / 8.0) - at(FROM)).collect()
}

/// Positions of the first joint of a robot that reaches each set point, with their times.
fn ideal(program: &Program) -> Vec<[f64; 2]> {
    let mut controller = Controller::new(program).expect("it can be executed");
    let mut q = program.robot.home.clone();
    let mut step = |k: u32| {
        let time = f64::from(k) * program.robot.period;
        let command = controller.step(&Observation { time, q: &q });
        q.copy_from_slice(command.position);
        [time, q[0]]
    };
    (0..300).map(&mut step).collect()
}

#[test]
fn drivers_of_any_rate_get_the_same_motion() {
    for tick in ["joint_states", "timer"] {
        for form in ["velocity", "position"] {
            let door = Door { tick, form };
            let expected = times(&ideal(&door.program()));
            // Largest difference of time, as one of the place at full speed, in parts of the way.
            let difference = |rate: f64| {
                let found = times(&door.motion(rate));
                let parts = found.iter().zip(&expected).map(|(t, wanted)| SPEED * (t - wanted).abs() / WAY);
                parts.fold(0.0, f64::max)
            };
            // A machine with other work stops everything for some milliseconds now and then, though not each time.
            let best = |rate: f64| {
                let first = difference(rate);
                if first < 0.01 { first } else { first.min(difference(rate)).min(difference(rate)) }
            };
            std::thread::scope(|scope| {
                let best = &best;
                let runs = [50.0, 125.0, 500.0, 1000.0].map(|rate| (rate, scope.spawn(move || best(rate))));
                for (rate, run) in runs {
                    let part = run.join().expect("a run");
                    println!("{door:?} {rate} Hz: {:.2} %", 100.0 * part);
                    assert!(part < 0.01, "{door:?} at {rate} Hz: {part}");
                }
            });
        }
    }
}
