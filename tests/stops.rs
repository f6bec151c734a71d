//! Stops: every stop is a motion to rest within the limits of the stack that moved the robot, and what follows begins from rest where the robot is.

use crate::common;

use runtime::{Controller, FaultKind, Observation, Program};

const ARM: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  SETTINGS  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
task spin = joint_velocity { velocity { joint_1 1 rad/s } }
stack work {
  level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits { max 5 rad/s^2 } }
  level motion { spin }
}
";

fn both(settings: &str, text: &str) -> [Program; 2] {
    let text = format!("{ARM}{text}").replace("SETTINGS", settings);
    let (spec, _) = dsl::parse(dsl::SourceId(0), &text, dsl::Syntax::Native);
    let yaml = dsl::print(&spec, dsl::Syntax::Yaml);
    [common::program_of(&text), common::program_in(&yaml, dsl::Syntax::Yaml)]
}

/// A host with an ideal robot.
struct Host {
    controller: Controller,
    q: Vec<f64>,
    time: f64,
    /// Command of the last call.
    v: Vec<f64>,
    /// Largest change of a command since the last look (rad/s^2).
    push: f64,
}

impl Host {
    fn new(program: &Program) -> Host {
        let controller = Controller::new(program).expect("a compiled program can be executed");
        let q = program.robot.home.clone();
        Host { v: vec![0.0; q.len()], controller, q, time: 0.0, push: 0.0 }
    }

    fn call(&mut self) -> Option<FaultKind> {
        let command = self.controller.step(&Observation { time: self.time, q: &self.q });
        let fault = command.fault.map(|f| f.kind());
        let push = command.velocity.iter().zip(&self.v).map(|(a, b)| (a - b).abs() / 0.01);
        self.push = push.fold(self.push, f64::max);
        self.v.copy_from_slice(command.velocity);
        self.q.copy_from_slice(command.position);
        self.time += 0.01;
        fault
    }

    fn calls(&mut self, count: usize) {
        for _ in 0..count {
            self.call();
        }
    }

    fn rests(&self) -> bool {
        self.controller.is_at_rest() && self.v.iter().all(|v| *v == 0.0)
    }
}

/// The machine of the book: a final state without a stack, with and without a blend.
#[test]
fn a_state_without_a_stack_is_come_to_within_the_limits() {
    for (blend, ticks) in [("", 20), ("blend 0.5 s", 50)] {
        let machine = format!(
            "machine m {{ initial go  {blend}  on fault(any) -> stopped  state go {{ stack work  after 1 s -> done }}  final state done  final state stopped }}"
        );
        for program in both("", &machine) {
            let mut host = Host::new(&program);
            host.calls(100);
            assert!((host.v[0] - 1.0).abs() < 1e-9);
            let mut moving = 0;
            while !host.rests() {
                assert_eq!(host.call(), None);
                moving += 1;
            }
            assert!(host.push <= 5.0 * (1.0 + 1e-9), "{} rad/s^2", host.push);
            assert!((ticks..ticks + 4).contains(&moving), "{blend}: {moving} ticks");
            assert_eq!(host.controller.state(), "done");
        }
    }
}

/// A reading that is lost, and a call that is late: the same motion to rest, with finite numbers only.
#[test]
fn faults_brake_within_the_limits() {
    for program in both("", "run { stack work  duration 3 s }") {
        for lost in [true, false] {
            let mut host = Host::new(&program);
            host.calls(60);
            let (q, late) = (host.q.clone(), if lost { 0.0 } else { 0.2 });
            if lost {
                host.q[3] = f64::NAN;
            }
            host.time += late;
            let kind = host.call();
            assert_eq!(kind, Some(if lost { FaultKind::NotFinite } else { FaultKind::Deadline }));
            assert!(host.q.iter().all(|x| x.is_finite()) && host.v[0] > 0.8, "{:?}", host.v);
            host.calls(40);
            assert!(host.rests() && host.push <= 5.0 * (1.0 + 1e-9), "{} rad/s^2", host.push);
            // From 1 rad/s with 5 rad/s^2: a tenth of a radian.
            assert!((host.q[0] - q[0] - 0.1).abs() < 0.02, "{}", host.q[0] - q[0]);
        }
    }
}

/// For hosts that stop the robot themselves.
#[test]
fn stop_now_stops_in_one_tick() {
    for program in both(
        "stop now",
        "machine m { initial go  on fault(any) -> stopped  state go { stack work  after 1 s -> done }  final state done  final state stopped }",
    ) {
        let mut host = Host::new(&program);
        host.calls(100);
        host.call();
        assert!(host.v.iter().all(|v| *v == 0.0), "{:?}", host.v);
        host.call();
        assert!(host.rests());
    }
}

/// The joint that a stack locks comes to rest as fast as the limits allow, however short the blend.
#[test]
fn a_joint_that_is_locked_in_motion_stops_within_its_limit() {
    for blend in ["0 s", "0.05 s", "0.1 s", "0.2 s", "0.3 s", "0.5 s"] {
        let rest = format!(
            "stack standing {{ lock [joint_1]  level limits hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits {{ max 5 rad/s^2 }} }}  level motion {{ hold(tool) }} }}
             machine m {{ initial a  on fault(any) -> stopped  state a {{ stack work  after 0.6 s -> b blend {blend} }}  state b {{ stack standing  after 10 s -> stopped }}  final state stopped }}"
        );
        for program in both("", &rest) {
            let mut host = Host::new(&program);
            for k in 0..200 {
                assert_eq!(host.call(), None, "blend {blend}, tick {k}");
            }
            assert!(host.push <= 5.0 * (1.0 + 1e-6), "{blend}: {} rad/s^2", host.push);
            assert!(host.v[0] == 0.0 && host.controller.state() == "b", "{blend}");
        }
    }
}

/// Stopped by the host, and told to go on: from rest, within the limits, where it left off.
#[test]
fn a_host_stops_and_resumes() {
    for program in both("", "run { stack work  duration 3 s }") {
        let mut host = Host::new(&program);
        host.calls(60);
        host.controller.stop();
        host.calls(30);
        assert!(host.rests() && host.controller.waits_for_resume());
        let at = host.q.clone();
        host.calls(100);
        assert_eq!(host.q, at);
        host.controller.resume();
        host.calls(60);
        assert!((host.v[0] - 1.0).abs() < 1e-9 && host.push <= 5.0 * (1.0 + 1e-9), "{} rad/s^2", host.push);
        assert!(host.q[0] > at[0] + 0.3);
    }
}

/// A protective stop in motion: the robot stands, is moved by hand, takes commands again, and stands until it is told.
#[test]
fn a_robot_that_takes_commands_again_stands_until_it_is_told() {
    for settings in ["", "resume itself"] {
        for program in both(settings, "run { stack work  duration 3 s }") {
            let mut host = Host::new(&program);
            host.calls(60);
            host.controller.set_enabled(false);
            host.call();
            let before = host.push;
            for _ in 0..50 {
                host.q[1] += 0.004;
                let moved = host.q.clone();
                assert_eq!(host.call(), None);
                assert_eq!(host.q, moved, "what a position servo is sent is where the robot is");
            }
            host.push = 0.0;
            assert!(before > 5.0, "the drive has stopped it: {before}");
            host.controller.set_enabled(true);
            host.calls(50);
            if settings.is_empty() {
                assert!(host.rests());
                host.controller.resume();
                host.calls(50);
            }
            assert!((host.v[0] - 1.0).abs() < 1e-9, "{:?}", host.v);
            assert!(host.push <= 5.0 * (1.0 + 1e-9), "from rest, within the limit: {} rad/s^2", host.push);
        }
    }
}

/// A robot that takes commands again at a limit, where encoders see it beyond this by a step, goes on without a fault.
#[test]
fn a_robot_at_its_limit_goes_on_where_encoders_see_it_beyond() {
    let slow = "stack slow {
      level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits { max 5 rad/s^2 } }
      level motion { joint_velocity { velocity { joint_1 0.4 rad/s } } }
    }
    run { stack slow  duration 20 s }";
    for program in both("", slow) {
        let mut host = Host::new(&program);
        host.calls(1000);
        let limit = program.robot.model.dofs[0].upper;
        assert!((host.q[0] - limit).abs() < 1e-3, "{}", host.q[0]);
        host.controller.set_enabled(false);
        for _ in 0..20 {
            host.q[0] = limit + 4e-4;
            assert_eq!(host.call(), None);
        }
        host.controller.set_enabled(true);
        host.controller.resume();
        for k in 0..200 {
            assert_eq!(host.call(), None, "call {k}");
        }
        assert!(host.q[0] <= limit + 1e-6, "{}", host.q[0] - limit);
    }
}

/// A signal of the spec enables the robot: false, too old and absent are no, as that of the host is, and both must say yes.
#[test]
fn a_signal_enables_the_robot_while_it_is_true_and_fresh() {
    for settings in ["enabled ready", "enabled ready  resume itself"] {
        for program in both(settings, "signal ready : flag  timeout 50 ms\nrun { stack work  duration 3 s }") {
            let mut host = Host::new(&program);
            let calls = |host: &mut Host, ready: Option<f64>| {
                for _ in 0..60 {
                    if let Some(value) = ready {
                        assert!(host.controller.signals().set(0, &[value], host.time));
                    }
                    assert_eq!(host.call(), None);
                }
                host.rests()
            };
            assert!(calls(&mut host, None) && !host.controller.is_enabled());
            assert_eq!(host.controller.awaited(), Some(0));
            assert!(!calls(&mut host, Some(1.0)), "nothing was interrupted that would have to be resumed");
            for no in [Some(-1.0), None] {
                assert!(calls(&mut host, no) && !host.controller.is_enabled());
                let stands = calls(&mut host, Some(1.0));
                assert_eq!(stands, settings == "enabled ready");
                if stands {
                    assert!(host.controller.is_enabled() && host.controller.waits_for_resume());
                    host.controller.resume();
                    calls(&mut host, Some(1.0));
                }
                assert!((host.v[0] - 1.0).abs() < 1e-9, "{:?}", host.v);
            }
            host.controller.set_enabled(false);
            assert!(calls(&mut host, Some(1.0)) && !host.controller.is_enabled());
        }
    }
}

/// A halted controller sends the place of the robot, also after it was moved by hand.
#[test]
fn a_halted_controller_sends_no_old_place() {
    for program in both("", "run { stack work  duration 3 s }") {
        let mut host = Host::new(&program);
        host.calls(60);
        host.time += 1.0;
        host.calls(60);
        assert!(host.controller.is_halted() && host.rests());
        for _ in 0..100 {
            let mut hand = host.q.clone();
            hand[2] += 0.01;
            host.q.copy_from_slice(&hand);
            host.call();
            assert!(host.q.iter().zip(&hand).all(|(sent, at)| (sent - at).abs() <= 0.02 + 1e-12));
        }
    }
}
