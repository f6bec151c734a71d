//! Robots that stand, and that come to rest, behind real drives: nothing moves before it is told to, and an arm that sags stays where it is.

use crate::common;

use robot::Data;
use runtime::{Controller, FaultKind, Observation, Program};

const FLOOR: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
task floor = keep(frame(tool).position.z) { min 20 cm }
stack work {
  level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits { max 5 rad/s^2 } }
  level f hard { floor }
  level m { frame_position(tool) { position initial(position) + [0, 0, -0.5] m  gain 2 /s } }
}
stack spin {
  level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits { max 5 rad/s^2 } }
  level m { joint_velocity { velocity { joint_1 1 rad/s } } }
}
";

fn program(rest: &str) -> Program {
    common::program_of(&format!("{FLOOR}{rest}"))
}

fn both(rest: &str) -> [Program; 2] {
    let (spec, _) = dsl::parse(dsl::SourceId(0), &format!("{FLOOR}{rest}"), dsl::Syntax::Native);
    let yaml = dsl::print(&spec, dsl::Syntax::Yaml);
    [program(rest), common::program_in(&yaml, dsl::Syntax::Yaml)]
}

/// How a robot is driven.
#[derive(Clone, Copy)]
enum Drive {
    /// By velocities, with a lag (s).
    Velocity(f64),
    /// By positions, with a lag (s), and a sag (rad) of the second joint.
    Position(f64, f64),
}

/// A host with a robot behind drives.
struct Host {
    controller: Controller,
    drive: Drive,
    dt: f64,
    time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Last command, and the last set point.
    u: Vec<f64>,
    set: Vec<f64>,
    /// Largest change of the command (rad/s^2), and of the set point (rad).
    push: f64,
    step: f64,
}

impl Host {
    fn new(program: &Program, drive: Drive, rate: f64) -> Host {
        let mut controller = Controller::new(program).expect("a compiled program can be executed");
        controller.called_every(Some(1.0 / rate));
        let q = program.robot.home.clone();
        let v = vec![0.0; q.len()];
        let (u, set) = (v.clone(), q.clone());
        Host { controller, drive, dt: 1.0 / rate, time: 0.0, q, v, u, set, push: 0.0, step: 0.0 }
    }

    /// A call with what is measured.
    fn call_with(&mut self, measured: &[f64]) -> Option<FaultKind> {
        let command = self.controller.step(&Observation { time: self.time, q: measured });
        let fault = command.fault.map(|f| f.kind());
        let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        self.push = self.push.max(largest(command.velocity, &self.u) / self.dt);
        self.step = self.step.max(largest(command.position, &self.set));
        self.u.copy_from_slice(command.velocity);
        self.set.copy_from_slice(command.position);
        assert!(!command.at_rest || self.u.iter().all(|u| *u == 0.0), "told to be at rest with {:?}", self.u);
        for i in 0..self.q.len() {
            match self.drive {
                Drive::Velocity(lag) => {
                    self.v[i] += (1.0 - (-self.dt / lag.max(1e-9)).exp()) * (self.u[i] - self.v[i]);
                    self.q[i] += self.v[i] * self.dt;
                }
                Drive::Position(lag, sag) => {
                    let aim = self.set[i] + if i == 1 { sag } else { 0.0 };
                    self.q[i] += (1.0 - (-self.dt / lag).exp()) * (aim - self.q[i]);
                }
            }
        }
        self.time += self.dt;
        fault
    }

    fn run(&mut self, seconds: f64) -> Vec<FaultKind> {
        let calls = (seconds / self.dt).round() as usize;
        (0..calls).filter_map(|_| self.call_with(&self.q.clone())).collect()
    }

    /// Height of the tool above the floor (m).
    fn height(&self) -> f64 {
        let model = self.controller.evaluator().model();
        let mut data = Data::new(model);
        model.forward(&self.q, &mut data);
        data.pose(model.link("tool").expect("a tool")).translation.vector.z - 0.2
    }
}

/// A host that tells a robot to stop while it stands anyway: before the first call, and in a state without a stack.
#[test]
fn a_stop_at_rest_holds_until_it_is_resumed() {
    let machine = "machine m { initial wait  on fault(any) -> wait  state wait { after 0.5 s -> go }  state go { stack spin  after 100 s -> wait } }";
    for program in both(machine) {
        for begin in [0.0, 0.2] {
            let mut host = Host::new(&program, Drive::Velocity(0.0), 100.0);
            host.run(begin);
            host.controller.stop();
            assert_eq!(host.run(2.0), []);
            assert!(host.q == program.robot.home && host.controller.waits_for_resume());
            host.controller.resume();
            host.run(1.5);
            assert!((host.u[0] - 1.0).abs() < 1e-9 && host.push <= 5.0 * (1.0 + 1e-6));
        }
    }
}

/// A host that resumes a robot while it brakes: it comes to rest first, and goes on.
#[test]
fn a_robot_that_is_resumed_in_a_stop_goes_on_from_rest() {
    let mut host = Host::new(&program("run { stack spin  duration 9 s }"), Drive::Velocity(0.0), 100.0);
    host.run(1.0);
    host.controller.stop();
    host.run(0.1);
    host.controller.resume();
    host.run(0.1);
    assert!(host.u[0] < 0.06, "{:?}", host.u);
    host.run(1.0);
    assert!((host.u[0] - 1.0).abs() < 1e-9 && host.push <= 5.0 * (1.0 + 1e-6));
}

/// A protective stop of an arm that sags: it waits to be resumed where it is, and does not sink.
#[test]
fn an_arm_that_sags_does_not_sink_while_it_waits() {
    for sag in [0.005, 0.015, 0.04] {
        let mut host = Host::new(&program("run { stack spin  duration 60 s }"), Drive::Position(0.02, sag), 100.0);
        host.run(0.5);
        host.controller.set_enabled(false);
        // Brakes hold it.
        for _ in 0..20 {
            let at = host.q.clone();
            host.call_with(&at);
            host.q = at;
        }
        host.controller.set_enabled(true);
        let before = host.q[1];
        assert_eq!(host.run(10.0), [], "{sag}");
        assert!((host.q[1] - before).abs() < 2.0 * sag + 1e-9, "sank by {} rad of {sag}", host.q[1] - before);
        assert!(host.controller.waits_for_resume() && host.controller.is_at_rest());
    }
}

/// The floor holds at rest too, in a final state and after a fault, for an arm that hangs below its set point.
#[test]
fn an_arm_that_sags_stays_above_the_floor_at_rest() {
    let machine = "machine m { initial go  state go { stack work  after 4 s -> done }  final state done }";
    for (rest, late) in [(machine, false), ("run { stack work  duration 60 s }", true)] {
        let mut host = Host::new(&program(rest), Drive::Position(0.02, 0.008), 100.0);
        host.run(4.5);
        host.time += if late { 0.5 } else { 0.0 };
        host.run(10.0);
        assert_eq!(host.controller.is_halted(), late);
        assert!(host.height() > -1.1e-3, "{} mm", 1e3 * host.height());
    }
}

/// A reading that no joint can have reached, for one call: it is told, and is no set point, whatever the robot does.
#[test]
fn a_reading_that_cannot_be_is_never_sent() {
    let machine = "machine m { initial wait  state wait { after 1 s -> go }  state go { stack spin  after 1 s -> done }  final state done }";
    for bad in [0.5, 20.0, 1e300] {
        for (at, stop) in [(0.5, false), (0.5, true), (1.5, false), (2.6, false)] {
            let mut host = Host::new(&program(machine), Drive::Position(0.005, 0.0), 100.0);
            host.run(at);
            if stop {
                host.controller.stop();
                host.run(0.2);
            }
            host.step = 0.0;
            let mut measured = host.q.clone();
            measured[2] += bad;
            assert_eq!(host.call_with(&measured), Some(FaultKind::Jump), "{bad} at {at} s");
            host.run(1.0);
            assert!(host.step < 0.02, "{bad} at {at} s: a set point {} rad away", host.step);
            assert!((host.q[2] - host.controller.reference()[2]).abs() < 1e-3);
        }
    }
}

/// A fault of a robot that is observed is a motion to rest for a position servo too: its set point goes on and slows down.
#[test]
fn the_set_point_of_a_position_servo_brakes_at_a_fault() {
    let spec = "signal goal : point  timeout 50 ms
stack go { level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits { max 5 rad/s^2 } }
  level m { joint_velocity { velocity { joint_1 1 rad/s } } }  level g { frame_position(tool) { position goal  gain 1 /s } } }
machine m { initial go  on fault(any) -> stopped  state go { stack go  after 100 s -> stopped }  final state stopped }";
    for (lag, rate) in [(0.025, 100.0), (0.025, 1000.0), (0.002, 1000.0)] {
        let mut host = Host::new(&program(spec), Drive::Position(lag, 0.0), rate);
        let goal = host.controller.signals().interface().signal("goal").expect("a signal");
        let mut before = f64::NEG_INFINITY;
        for _ in 0..(0.8 * rate) as usize {
            host.controller.signals().set(goal, &[0.4, 0.1, 0.5], host.time);
            host.call_with(&host.q.clone());
        }
        for _ in 0..rate as usize {
            host.call_with(&host.q.clone());
            assert!(host.set[0] >= before - 1e-6, "the set point goes back by {}", before - host.set[0]);
            before = host.set[0];
        }
        assert!(host.controller.is_at_rest() && host.push <= 5.0 * (1.0 + 1e-6), "{} rad/s^2", host.push);
    }
}

/// Drives with a lag that nobody declared, and a host that is faster than the spec: the end of a motion to rest is no jump of the command.
#[test]
fn a_robot_that_lags_comes_to_rest_within_its_limits() {
    let machine = "machine m { initial go  state go { stack spin  after 1 s -> done }  final state done }";
    for (rest, ends) in
        [(machine, "final"), ("run { stack spin  duration 9 s }", "lost"), ("run { stack spin  duration 9 s }", "told")]
    {
        for (lag, rate) in [(0.05, 100.0), (0.05, 1000.0), (0.1, 1000.0)] {
            let mut host = Host::new(&program(rest), Drive::Velocity(lag), rate);
            host.run(1.0);
            match ends {
                "lost" => _ = host.call_with(&vec![f64::NAN; host.q.len()]),
                "told" => host.controller.stop(),
                _ => {}
            }
            host.run(4.0);
            assert!(host.push <= 5.0 * (1.0 + 1e-6), "{ends}, {lag} s, {rate} Hz: {} rad/s^2", host.push);
            assert!(host.controller.is_at_rest(), "{ends}, {lag} s, {rate} Hz: {:?}", host.u);
        }
    }
}

/// A robot that was told to stop, and runs on.
#[test]
fn a_drive_that_ignores_a_stop_is_told() {
    let mut host = Host::new(&program("run { stack spin  duration 9 s }"), Drive::Velocity(0.0), 100.0);
    host.run(1.0);
    host.controller.stop();
    let mut told = Vec::new();
    for _ in 0..150 {
        host.q[0] += 0.01;
        let measured = host.q.clone();
        told.extend(host.call_with(&measured));
        host.q = measured;
    }
    assert!(told.contains(&FaultKind::Tracking), "{told:?}");
    let mut host = Host::new(&program("run { stack spin  duration 9 s }"), Drive::Velocity(0.0), 100.0);
    host.run(1.0);
    host.controller.stop();
    host.run(1.0);
    assert_eq!(host.call_with(&vec![f64::NAN; host.q.len()]), Some(FaultKind::NotFinite));
}

/// Joints that stand, that turn round, and that move twice as far, in the middle of a motion. One that moves twice as far is pulled back, and told once
/// it is well ahead of its reference.
#[test]
fn a_joint_that_stops_following_in_motion_is_named_at_once() {
    for speed in [0.2, 0.5, 1.0, 1.9] {
        for (factor, within) in [(0.0, 0.5), (-1.0, 0.7), (2.0, 1.6)] {
            if factor == 2.0 && speed < 0.3 {
                continue;
            }
            let spec = format!(
                "stack turn {{ level limits hard {{ joint_velocity_limits }}  level m {{ joint_velocity {{ velocity {{ joint_1 {speed} rad/s }} }} }} }}
                 run {{ stack turn  duration 9 s }}"
            );
            let mut host = Host::new(&program(&spec), Drive::Velocity(0.0), 100.0);
            assert_eq!(host.run(0.7), []);
            let mut after = None;
            for k in 0..200 {
                let before = host.q[0];
                let fault = host.call_with(&host.q.clone());
                if fault.is_some() && after.is_none() {
                    assert_eq!(fault, Some(FaultKind::Tracking));
                    after = Some(f64::from(k) * 0.01);
                }
                host.q[0] = before + factor * (host.q[0] - before);
            }
            let after = after.unwrap_or(f64::INFINITY);
            assert!(after < within, "{factor} times at {speed} rad/s: after {after} s");
        }
    }
}

/// An ideal robot that drives into a limit, and a host that is faster than the spec: the command of each call keeps the limit of accelerations.
#[test]
fn a_fast_host_keeps_the_limit_of_accelerations_at_a_bound() {
    let spec = "stack turn { level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits { max 20 rad/s^2 } }
  level m { joint_velocity { allow HQ0535 \"into the limit\"  velocity { joint_2 2 rad/s } } } }
run { stack turn  duration 9 s }";
    for rate in [100.0, 200.0, 500.0, 1000.0, 2000.0] {
        let mut host = Host::new(&program(spec), Drive::Velocity(0.0), rate);
        assert_eq!(host.run(2.0), []);
        assert!(host.push <= 20.0 * (1.0 + 1e-6), "{rate} Hz: {} rad/s^2", host.push);
    }
}
