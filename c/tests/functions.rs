//! The functions called as a host calls them: the same numbers as the controller of Rust, and a defined answer to each mistake.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes pointers of the library, null, or arrays with the length beside them"
)]

use std::ffi::{CStr, c_char};
use std::ptr::{null, null_mut};

use hierarq_c::*;
use runtime::program::CompiledFile;
use runtime::{Controller as Core, Observation};

use crate::spec;

/// A loaded program with a controller, freed at the end.
struct Host {
    program: *mut Program,
    controller: *mut Controller,
}

impl Host {
    fn new(json: &str) -> Host {
        // SAFETY: the pointers are those of the text and of the library.
        unsafe {
            let program = hierarq_program_load(json.as_ptr().cast(), json.len(), null_mut(), 0);
            assert!(!program.is_null());
            let controller = hierarq_controller_new(program, null(), null_mut(), 0);
            assert!(!controller.is_null());
            hierarq_called_every(controller, 1e-3);
            Host { program, controller }
        }
    }

    fn step(&self, time: f64, q: &[f64], v: &mut [f64]) -> Result {
        // SAFETY: the arrays have the lengths that are passed.
        unsafe { hierarq_step(self.controller, time, q.as_ptr(), q.len(), v.as_mut_ptr(), v.len()) }
    }

    fn state(&self) -> String {
        words(|| unsafe { hierarq_state(self.controller) })
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: both are of the library, and freed once. The program may go first.
        unsafe {
            hierarq_program_free(self.program);
            hierarq_controller_free(self.controller);
        }
    }
}

fn words(of: impl Fn() -> *const c_char) -> String {
    let text = of();
    assert!(!text.is_null());
    // SAFETY: the library ends its texts with a zero.
    unsafe { CStr::from_ptr(text) }.to_str().expect("UTF-8").to_string()
}

fn message(write: impl Fn(*mut c_char, usize)) -> String {
    let mut buffer = [1 as c_char; 200];
    write(buffer.as_mut_ptr(), buffer.len());
    words(|| buffer.as_ptr())
}

#[test]
fn the_numbers_are_those_of_the_controller() {
    let json = spec::json();
    let host = Host::new(&json);
    let program = CompiledFile::read(&json).expect("a program").program.expect("of a robot");
    let mut core = Core::new(&program).expect("it can be executed");
    let goal = unsafe { hierarq_signal_index(host.program, c"goal".as_ptr()) };
    let go = unsafe { hierarq_event_index(host.program, c"go".as_ptr()) };
    assert_eq!((unsafe { hierarq_signal_width(host.program, goal as usize) }, go), (3, 0));
    let mut q = program.robot.home.clone();
    let mut v = vec![f64::NAN; q.len()];
    let mut left = Vec::new();
    for k in 0..1500 {
        let time = k as f64 * program.robot.period;
        let value = [0.45, 0.15 * time.sin(), 0.5];
        // From 1.2 s on the goal is stale, which a transition answers.
        if k < 1200 {
            assert!(unsafe { hierarq_signal_set(host.controller, goal, value.as_ptr(), 3, time) });
            assert!(core.signals().set(goal as usize, &value, time));
        }
        if k == 300 {
            assert!(unsafe { hierarq_event_raise(host.controller, go) });
            core.signals().raise(go as usize);
        }
        let result = host.step(time, &q, &mut v);
        let command = core.step(&Observation { time, q: &q });
        assert_eq!(v, command.velocity, "tick {k}");
        assert_eq!(result, command.fault.map_or(Result::Ok, |f| f.kind().into()), "tick {k}");
        assert_eq!(host.state(), core.state());
        left.push(host.state());
        q.iter_mut().zip(&v).for_each(|(q, v)| *q += v * program.robot.period);
    }
    left.dedup();
    assert_eq!(left, ["wait", "follow", "wait"]);
    let rate = unsafe { hierarq_measured_rate(host.controller) };
    assert!((rate * program.robot.period - 1.0).abs() < 1e-9, "{rate} Hz");
    assert_eq!(unsafe { hierarq_measured_rate(null()) }, 0.0);
    let mut reference = vec![0.0; q.len()];
    assert!(unsafe { hierarq_reference(host.controller, reference.as_mut_ptr(), reference.len()) });
    assert_eq!(reference, core.reference());
    let count = unsafe { hierarq_task_count(host.controller) };
    let named = |i| words(|| unsafe { hierarq_task_name(host.controller, i) });
    let position = (0..count).find(|&i| named(i).contains("joint_position_limits")).expect("a limit");
    assert!(unsafe { hierarq_task_is_limit(host.controller, position) });
    assert!(unsafe { hierarq_task_value(host.controller, position) } > 0.0);
    let target = (0..count).find(|&i| !unsafe { hierarq_task_is_limit(host.controller, i) }).expect("a target");
    assert!(unsafe { hierarq_task_value(host.controller, target) }.is_nan(), "it does not run in `wait`");
}

#[test]
fn faults_are_told_and_answered_by_zero() {
    let host = Host::new(&spec::json());
    let n = unsafe { hierarq_nq(host.program) };
    let mut q = vec![0.0; n];
    assert!(unsafe { hierarq_home(host.program, q.as_mut_ptr(), n) });
    let mut v = vec![1.0; n];
    assert_eq!(host.step(0.0, &q, &mut v), Result::Ok);
    q[2] = f64::NAN;
    assert_eq!(host.step(0.001, &q, &mut v), Result::NotFinite);
    assert!(v.iter().all(|x| *x == 0.0) && unsafe { hierarq_is_halted(host.controller) });
    let text = message(|b, n| unsafe { hierarq_fault_text(host.controller, b, n) });
    assert_eq!(text, "the position of `joint_3` is missing or not finite: its driver is silent, or sends no number");
    unsafe { hierarq_restart(host.controller) };
    q[2] = 0.0;
    assert_eq!(host.step(0.0, &q, &mut v), Result::Ok);
    assert_eq!(host.step(-1.0, &q, &mut v), Result::Deadline);
    assert_eq!(message(|b, n| unsafe { hierarq_fault_text(null(), b, n) }), "");
}

#[test]
fn a_base_that_is_localised_anew_takes_its_reference_along() {
    let json = spec::compiled(
        "hierarq 1
         robot arm { urdf \"../../../examples/robots/arm7.urdf\"  rate 1000 Hz  base planar  home { joint_4 1.6 rad }
           limits { base_x { velocity 1 m/s }  base_y { velocity 1 m/s }  base_yaw { velocity 1 rad/s } } }
         task turn = joint_velocity { velocity { joint_1 0.2 rad/s } }
         stack work { level limits hard { joint_velocity_limits }  level motion { turn } }
         run { stack work  duration 1 s }",
    );
    for is_told in [true, false] {
        let host = Host::new(&json);
        let n = unsafe { hierarq_nq(host.program) };
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        assert!(unsafe { hierarq_home(host.program, q.as_mut_ptr(), n) });
        for k in 0..200 {
            if k == 100 {
                q[0] += 0.5;
                if is_told {
                    unsafe { hierarq_relocated(host.controller) };
                }
            }
            let result = host.step(f64::from(k) * 1e-3, &q, &mut v);
            assert!(result == Result::Ok || (k >= 100 && !is_told), "call {k}");
            assert!(k != 100 || is_told || result == Result::Jump, "{result:?}");
            q.iter_mut().zip(&v).for_each(|(q, v)| *q += 1e-3 * v);
        }
        assert!((v[3] > 0.19) == is_told && v[0].abs() < 1e-9, "{v:?}");
    }
}

#[test]
fn a_signal_of_the_spec_enables_the_robot() {
    let json = spec::compiled(
        "hierarq 1
         signal drives_on : flag  timeout 50 ms
         robot arm { urdf \"../../../examples/robots/arm7.urdf\"  rate 1000 Hz  home { joint_4 1.6 rad }  enabled drives_on }
         task turn = joint_velocity { velocity { joint_1 0.2 rad/s } }
         stack work { level limits hard { joint_velocity_limits  joint_acceleration_limits { max 15 rad/s^2 } }  level motion { turn } }
         run { stack work  duration 1 s }",
    );
    let host = Host::new(&json);
    let n = unsafe { hierarq_nq(host.program) };
    let drives_on = unsafe { hierarq_signal_index(host.program, c"drives_on".as_ptr()) };
    let (mut q, mut v, mut time) = (vec![0.0; n], vec![0.0; n], 0.0);
    assert!(unsafe { hierarq_home(host.program, q.as_mut_ptr(), n) });
    // Velocity of the first joint after some calls, of which the last ones are sent nothing (`None`).
    let mut after = |calls: usize, sent: Option<bool>, moved_by_hand: f64| {
        for _ in 0..calls {
            q[0] += moved_by_hand / calls as f64;
            if let Some(on) = sent {
                let value = if on { 1.0 } else { -1.0 };
                assert!(unsafe { hierarq_signal_set(host.controller, drives_on, &raw const value, 1, time) });
            }
            let before = v[0];
            assert_eq!(host.step(time, &q, &mut v), Result::Ok);
            assert!(v[0] >= 0.0 && v[0] - before < 0.016, "from rest, within 15 rad/s^2: {before} {}", v[0]);
            let mut position = vec![0.0; n];
            assert!(unsafe { hierarq_position(host.controller, position.as_mut_ptr(), n) });
            assert!((position[0] - q[0]).abs() < 1e-3, "from where the robot is: {} {}", position[0], q[0]);
            q.iter_mut().zip(&v).for_each(|(q, v)| *q += 1e-3 * v);
            time += 1e-3;
        }
        v[0]
    };
    assert_eq!(after(100, None, 0.0), 0.0, "not a word yet");
    assert!(after(100, Some(true), 0.0) > 0.19);
    assert_eq!(after(1, Some(false), 0.0), 0.0);
    assert_eq!(after(100, Some(false), 0.3), 0.0);
    assert_eq!(after(100, Some(true), 0.0), 0.0, "what comes back starts nothing");
    unsafe { hierarq_resume(host.controller) };
    assert!(after(100, Some(true), 0.0) > 0.19);
    assert!(after(45, None, 0.0) > 0.19);
    assert_eq!(after(40, None, 0.0), 0.0, "too old: it comes to rest within its limits");
    assert_eq!(after(100, Some(true), 0.0), 0.0);
    unsafe { hierarq_resume(host.controller) };
    unsafe { hierarq_enabled(host.controller, false) };
    assert_eq!(after(100, Some(true), 0.0), 0.0, "the host says no");
    unsafe { hierarq_enabled(host.controller, true) };
    unsafe { hierarq_resume(host.controller) };
    assert!(after(100, Some(true), 0.0) > 0.19);
}

#[test]
fn a_set_point_is_in_the_turn_that_the_encoder_reports() {
    use std::f64::consts::{PI, TAU};
    let urdf = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("spindle.urdf");
    let text = "<robot name=\"spindle\"><link name=\"base\"/><link name=\"disc\"/><joint name=\"spindle\" type=\"continuous\">
        <parent link=\"base\"/><child link=\"disc\"/><axis xyz=\"0 0 1\"/><limit velocity=\"3\" effort=\"1\"/></joint></robot>";
    std::fs::write(&urdf, text).expect("a folder that can be written");
    let json = spec::compiled(&format!(
        "hierarq 1
         robot spindle {{ urdf \"{}\"  rate 1000 Hz  home {{ spindle 3 rad }} }}
         task unscrew = joint_position {{ target {{ spindle 17 rad }}  gain 4 /s  turns exact }}
         stack work {{ level limits hard {{ joint_velocity_limits }}  level motion {{ unscrew }} }}
         run {{ stack work  duration 1 s }}",
        urdf.display()
    ));
    let wrapped = |q: f64| q - TAU * (q / TAU).round();
    for wraps in [true, false] {
        let host = Host::new(&json);
        let (mut place, mut v) = (3.0, [0.0]);
        for k in 0..8000 {
            let reading = if wraps { wrapped(place) } else { place };
            // At the end, the driver has no number.
            let is_lost = k == 7999;
            let result = host.step(f64::from(k) * 1e-3, &[if is_lost { f64::NAN } else { reading }], &mut v);
            assert_eq!(result, if is_lost { Result::NotFinite } else { Result::Ok }, "call {k}");
            let mut position = 0.0;
            assert!(unsafe { hierarq_position(host.controller, &raw mut position, 1) });
            assert!((position - reading).abs() <= PI, "call {k}: {position} at {reading}");
            // The servo goes to its set point by the way that its encoder sees.
            place += position - reading;
        }
        assert!((place - 17.0).abs() < 1e-3, "{place}");
    }
}

#[test]
fn mistakes_of_the_host_are_answered() {
    let host = Host::new(&spec::json());
    let n = unsafe { hierarq_nq(host.program) };
    let (q, mut v) = (vec![0.0; n], vec![1.0; n]);
    assert_eq!(host.step(0.0, &q[1..], &mut v), Result::WrongLength);
    assert!(v.iter().all(|x| *x == 0.0));
    assert_eq!(host.step(0.0, &q, &mut v[1..]), Result::WrongLength);
    unsafe {
        assert_eq!(hierarq_step(host.controller, 0.0, null(), n, v.as_mut_ptr(), n), Result::NullPointer);
        assert_eq!(hierarq_step(host.controller, 0.0, q.as_ptr(), n, null_mut(), n), Result::NullPointer);
        assert_eq!(hierarq_step(null_mut(), 0.0, q.as_ptr(), n, v.as_mut_ptr(), n), Result::NullPointer);
        assert_eq!(hierarq_signal_index(host.program, c"gaol".as_ptr()), -1);
        assert_eq!(hierarq_signal_index(null(), c"goal".as_ptr()), -1);
        assert_eq!(hierarq_event_index(host.program, null()), -1);
        assert!(!hierarq_signal_set(host.controller, 0, q.as_ptr(), 2, 0.0), "another width");
        assert!(!hierarq_signal_set(host.controller, -1, q.as_ptr(), 3, 0.0));
        assert!(!hierarq_signal_set(host.controller, 0, null(), 3, 0.0));
        assert!(!hierarq_signal_clear(host.controller, 99) && hierarq_signal_clear(host.controller, 0));
        assert!(!hierarq_event_raise(host.controller, 7) && !hierarq_event_raise(null_mut(), 0));
        assert!(hierarq_q_name(host.program, n).is_null() && hierarq_v_name(null(), 0).is_null());
        assert!(!hierarq_home(host.program, v.as_mut_ptr(), n + 1) && hierarq_nq(null()) == 0);
        assert!(hierarq_task_value(host.controller, 99).is_nan() && hierarq_task_name(host.controller, 99).is_null());
        hierarq_program_free(null_mut());
        hierarq_controller_free(null_mut());
        hierarq_restart(null_mut());
    }
    assert_eq!(words(|| unsafe { hierarq_q_name(host.program, 0) }), "joint_1");
    assert_eq!(words(|| unsafe { hierarq_program_name(host.program) }), "reach");
}

#[test]
fn programs_that_cannot_run_are_refused_with_a_reason() {
    let load = |text: &str| {
        message(|b, n| {
            // SAFETY: the text has this length.
            assert!(unsafe { hierarq_program_load(text.as_ptr().cast(), text.len(), b, n) }.is_null());
        })
    };
    assert!(load("").contains("no compiled program"));
    assert!(load("{\"format\": 1}").contains("no compiled program"));
    let json = spec::json();
    let other = json.replacen("\"format\": ", "\"format\": 9", 1);
    assert!(load(&other).contains("another version"), "{}", load(&other));
    assert!(message(|b, n| assert!(unsafe { hierarq_program_load(null(), 3, b, n) }.is_null())).contains("null"));
    let host = Host::new(&json);
    let stack = message(|b, n| {
        assert!(unsafe { hierarq_controller_new(host.program, c"raech".as_ptr(), b, n) }.is_null());
    });
    assert!(stack.contains("no stack `raech`"), "{stack}");
    // A buffer that is too short is filled to a character's border, and ended.
    let mut short = [1 as c_char; 5];
    assert!(unsafe { hierarq_program_load(null(), 0, short.as_mut_ptr(), short.len()) }.is_null());
    assert_eq!(words(|| short.as_ptr()), "the ");
}
