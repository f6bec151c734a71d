//! The rate at which the host calls: the motion of a spec is the same at any, and its hard limits hold for the drive that gets the commands.
//!
//! The robot of these tests is integrated in steps of a tenth of a millisecond, with the commands held between calls, by code of their own.

use crate::common;

use proptest::prelude::*;
use runtime::{Controller, Observation, Program};

const ARM: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  deadline 60 ms  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
";

/// Limits, and a way there and back that brakes and turns round.
const SWAY: &str = "stack s {
  level limits hard { joint_position_limits  joint_velocity_limits { max 0.8 rad/s }  joint_acceleration_limits { max 4 rad/s^2 } }
  level motion { frame_position(tool) { position initial(position) + [0, 0.15, 0.05] m * sin(pi*t/(1 s))  gain 5 /s } }
}
run { stack s  duration 3 s }";

/// What a run at some times of calls gave.
struct Ran {
    /// Configuration at the end.
    end: Vec<f64>,
    /// Largest speed and acceleration of the commands between two calls.
    speed: f64,
    acceleration: f64,
    fault: Option<String>,
}

/// Calls a controller at these times, and holds each command until the next one.
fn run(program: &Program, times: &[f64], interval: Option<f64>) -> Ran {
    let mut controller = Controller::new(program).expect("a compiled program can be executed");
    controller.called_every(interval);
    let model = &program.robot.model;
    let mut q = program.robot.home.clone();
    let mut last = vec![0.0; model.nv()];
    let mut ran = Ran { end: Vec::new(), speed: 0.0, acceleration: 0.0, fault: None };
    for (k, &time) in times.iter().enumerate() {
        let command = controller.step(&Observation { time, q: &q });
        let v = command.velocity.to_vec();
        if let Some(fault) = command.fault {
            ran.fault = Some(controller.describe(&fault));
            break;
        }
        if k > 0 {
            let dt = time - times[k - 1];
            for (now, before) in v.iter().zip(&last) {
                ran.acceleration = ran.acceleration.max((now - before).abs() / dt);
            }
        }
        ran.speed = v.iter().fold(ran.speed, |a, v| a.max(v.abs()));
        let hold = times.get(k + 1).map_or(0.0, |next| next - time);
        for (q, v) in q.iter_mut().zip(&v) {
            *q += hold * v;
        }
        last = v;
    }
    ran.end = q;
    ran
}

fn regular(rate: f64, seconds: f64) -> Vec<f64> {
    (0..=(rate * seconds).round() as usize).map(|k| k as f64 / rate).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

/// The rates that drivers have, and some that fit no grid.
#[test]
fn the_motion_is_the_same_at_any_rate() {
    let program = common::program_of(&format!("{ARM}{SWAY}"));
    let way = 0.4; // the joints move by about as much
    let same = run(&program, &regular(100.0, 1.25), Some(0.01));
    assert_eq!(same.fault, None);
    for rate in [20.0, 40.0, 50.0, 80.0, 125.0, 200.0, 333.0, 500.0, 1000.0, 2000.0] {
        let times = regular(rate, 1.25);
        for interval in [Some(1.0 / rate), None] {
            // A host that does not tell its rate begins to move with the second call.
            let shifted: Vec<f64> = match interval {
                Some(_) => times.clone(),
                None => std::iter::once(-1.0 / rate).chain(times.iter().copied()).collect(),
            };
            let other = run(&program, &shifted, interval);
            assert_eq!(other.fault, None, "{rate} Hz");
            let d = apart(&same.end, &other.end);
            assert!(d < 0.01 * way, "{rate} Hz, {interval:?}: {d} rad apart");
            assert!(other.speed <= 0.8 + 1e-9, "{rate} Hz: {} rad/s", other.speed);
            assert!(
                other.acceleration <= 4.0 * (1.0 + 1e-6),
                "{rate} Hz, {interval:?}: {} rad/s^2",
                other.acceleration
            );
        }
    }
}

/// The same from the YAML spelling.
#[test]
fn the_rate_of_calls_is_free_in_yaml_too() {
    let (spec, _) = dsl::parse(dsl::SourceId(0), &format!("{ARM}{SWAY}"), dsl::Syntax::Native);
    let yaml = dsl::print(&spec, dsl::Syntax::Yaml);
    let program = common::program_in(&yaml, dsl::Syntax::Yaml);
    let [slow, fast] = [100.0, 500.0].map(|rate| run(&program, &regular(rate, 1.0), Some(1.0 / rate)));
    assert!(apart(&slow.end, &fast.end) < 4e-3);
}

/// One joint at a constant speed: what is asked for, at every rate.
#[test]
fn a_speed_is_a_way_per_second() {
    let text = format!(
        "{ARM}stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits }} \
         level motion {{ joint_velocity {{ velocity {{ joint_1 1 rad/s }} }} }} }} run {{ stack s  duration 3 s }}"
    );
    let program = common::program_of(&text);
    for rate in [50.0, 80.0, 100.0, 500.0, 1000.0] {
        let ran = run(&program, &regular(rate, 1.0), Some(1.0 / rate));
        assert!((ran.end[0] - 1.0).abs() < 0.01 && ran.speed <= 1.0 + 1e-9, "{rate} Hz: {} rad", ran.end[0]);
    }
}

/// The ticks of a host that calls once a period are those of the hierarchy itself, to the bit.
#[test]
fn a_host_on_the_grid_is_sent_the_decisions() {
    let program = common::program_of(&format!("{ARM}{SWAY}"));
    let mut controller = Controller::new(&program).expect("a compiled program can be executed");
    let mut q = program.robot.home.clone();
    for k in 0..200 {
        let command = controller.step(&Observation { time: f64::from(k) * 0.01, q: &q });
        let (v, position) = (command.velocity.to_vec(), command.position.to_vec());
        assert_eq!(v, controller.velocity());
        assert_eq!(position, controller.reference());
        q = position;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Calls with jitter, lost calls, and a rate that changes: never faster, never a harder push, and the same place in the end.
    #[test]
    fn jitter_neither_pushes_nor_leads_astray(
        rate in 60.0..2000.0_f64,
        jitter in 0.0..0.45_f64,
        seed in any::<u64>(),
    ) {
        let program = common::program_of(&format!("{ARM}{SWAY}"));
        let same = run(&program, &regular(100.0, 1.0), Some(0.01));
        let mut state = seed | 1;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let count = rate as usize;
        let mut times: Vec<f64> = (0..count).map(|k| (k as f64 + jitter * random()) / rate).collect();
        times[0] = 0.0;
        times.push(1.0);
        let ran = run(&program, &times, Some(1.0 / rate));
        prop_assert_eq!(ran.fault, None);
        prop_assert!(ran.speed <= 0.8 + 1e-9);
        prop_assert!(ran.acceleration <= 4.0 * (1.0 + 1e-6), "{} rad/s^2", ran.acceleration);
        // Half a decision early or late at 0.8 rad/s.
        prop_assert!(apart(&same.end, &ran.end) < 8e-3, "{} rad", apart(&same.end, &ran.end));
    }
}
