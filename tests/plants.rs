//! Robots that are not their reference: drives with lag and dead time, encoders with noise and steps, joints that drift, stand, turn the other way.
//!
//! Each is a model of its own, integrated here; the laws of the book are tested where the robot truly is.

use crate::common;

use std::collections::VecDeque;

use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use robot::Data;
use runtime::{Controller, FaultKind, Observation, Program};

/// An arm that is told to go half a metre down, and a hard floor on the way.
const FLOOR: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
task floor = keep(frame(tool).position.z) { min 20 cm }
stack s {
  level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits { max 15 rad/s^2 } }
  level f hard { floor }
  level m { frame_position(tool) { position initial(position) + [0, 0.1, -0.5] m  gain 2 /s } }
}
run { duration 12 s }";

/// A drive with its encoder.
#[derive(Clone, Debug)]
struct Plant {
    lag: f64,
    dead_ticks: usize,
    noise: f64,
    step: f64,
    /// Velocity that comes on top (rad/s), of each joint.
    drift: Vec<f64>,
    /// Factor of each joint.
    factor: Vec<f64>,
    /// Time from which joints stand (s).
    stands_from: f64,
}

impl Plant {
    fn ideal(n: usize) -> Plant {
        Plant {
            lag: 0.0,
            dead_ticks: 0,
            noise: 0.0,
            step: 0.0,
            drift: vec![0.0; n],
            factor: vec![1.0; n],
            stands_from: f64::INFINITY,
        }
    }
}

struct Ran {
    /// Deepest place of the tool below the floor (m).
    below: f64,
    fault: Option<(f64, FaultKind, String)>,
    /// Distance from the floor at the end (m).
    end: f64,
    /// Largest change of the command (rad/s^2).
    push: f64,
    /// Largest difference between what a host is told of the floor's margin, and the true one (m).
    told: f64,
}

fn run(program: &Program, plant: &Plant, seconds: f64) -> Ran {
    let model = &program.robot.model;
    let (n, dt) = (model.nv(), program.robot.period);
    let tool = model.link("tool").expect("the arm has a tool");
    let mut data = Data::new(model);
    let mut controller = Controller::new(program).expect("a compiled program can be executed");
    let mut q = program.robot.home.clone();
    let mut v = vec![0.0; n];
    let mut queue: VecDeque<Vec<f64>> = std::iter::repeat_n(vec![0.0; n], plant.dead_ticks).collect();
    let (normal, mut rng) = (Normal::new(0.0, plant.noise).expect("a deviation"), Pcg64::seed_from_u64(1));
    let mut ran = Ran { below: f64::NEG_INFINITY, fault: None, end: 0.0, push: 0.0, told: 0.0 };
    let mut last = vec![0.0; n];
    for k in 0..(seconds / dt) as usize {
        let time = k as f64 * dt;
        let mut measured = q.clone();
        for x in &mut measured {
            *x += normal.sample(&mut rng);
            if plant.step > 0.0 {
                *x = (*x / plant.step).round() * plant.step;
            }
        }
        let command = controller.step(&Observation { time, q: &measured });
        let u = command.velocity.to_vec();
        if let Some(fault) = command.fault {
            ran.fault.get_or_insert((time, fault.kind(), controller.describe(&fault)));
        }
        let push = u.iter().zip(&last).map(|(a, b)| (a - b).abs() / dt).fold(0.0, f64::max);
        ran.push = ran.push.max(push);
        last.clone_from(&u);
        let z = |data: &Data| data.pose(tool).translation.vector.z - 0.2;
        if ran.fault.is_none() {
            let e = controller.measured();
            let floor = e.members().iter().find(|m| m.name == "floor").expect("the floor");
            model.forward(&measured, &mut data);
            ran.told = ran.told.max((e.margins()[floor.margins.start] - z(&data)).abs());
        }
        queue.push_back(u);
        let u = queue.pop_front().unwrap_or_default();
        for i in 0..n {
            let wanted = if time >= plant.stands_from { 0.0 } else { plant.factor[i] * u[i] + plant.drift[i] };
            let decay = if plant.lag > 0.0 { (-dt / plant.lag).exp() } else { 0.0 };
            let before = v[i];
            v[i] = wanted + (before - wanted) * decay;
            q[i] += wanted * dt + (before - wanted) * plant.lag * (1.0 - decay);
        }
        model.forward(&q, &mut data);
        ran.end = z(&data);
        ran.below = ran.below.max(-ran.end);
    }
    ran
}

fn program() -> Program {
    common::program_of(FLOOR)
}

/// Drives and encoders as they are: no fault, the floor is reached and held, and accelerations stay within their limits.
#[test]
fn ordinary_drives_hold_the_floor_without_a_fault() {
    let program = program();
    let ideal = Plant::ideal(program.robot.model.nv());
    let plants = [
        ideal.clone(),
        Plant { lag: 0.02, ..ideal.clone() },
        Plant { lag: 0.05, ..ideal.clone() },
        Plant { dead_ticks: 2, ..ideal.clone() },
        Plant { noise: 2e-4, ..ideal.clone() },
        Plant { step: 1e-3, ..ideal.clone() },
        Plant { lag: 0.02, dead_ticks: 1, noise: 1e-4, step: 1e-4, ..ideal },
    ];
    for plant in plants {
        let ran = run(&program, &plant, 6.0);
        assert_eq!(ran.fault, None, "{plant:?}");
        assert!(ran.below < 1e-3, "{plant:?}: {} mm below", 1e3 * ran.below);
        assert!(ran.end < 5e-3, "{plant:?}: it stops {} mm above", 1e3 * ran.end);
        assert!(ran.push <= 15.0 * (1.0 + 1e-6), "{plant:?}: {} rad/s^2", ran.push);
        assert!(ran.told < 1e-9, "{plant:?}: margins are not those of the robot by {}", ran.told);
    }
}

/// Drives that are slow, as declared: the floor holds as with ideal ones, without a fault.
#[test]
fn declared_drives_hold_the_floor() {
    for (lag, dead_ticks, noise) in [(0.1, 0, 0.0), (0.0, 10, 0.0), (0.1, 5, 0.0), (0.2, 0, 0.0), (0.1, 5, 2e-4)] {
        let declared = format!("rate 100 Hz  lag {lag} s  dead_time {} s", 0.01 * dead_ticks as f64);
        let program = common::program_of(&FLOOR.replace("rate 100 Hz", &declared));
        let plant = Plant { lag, dead_ticks, noise, ..Plant::ideal(program.robot.model.nv()) };
        let ran = run(&program, &plant, 6.0);
        assert_eq!(ran.fault, None, "{plant:?}");
        assert!(ran.below < 1e-6 + 5.0 * noise, "{plant:?}: {} mm below", 1e3 * ran.below);
        assert!(ran.end < 5e-3, "{plant:?}: it stops {} mm above", 1e3 * ran.end);
    }
}

/// A position servo that sags by 2 mm at the tool is led back above the floor by an offset of its set point.
#[test]
fn a_servo_that_sags_is_lifted_above_the_floor() {
    let program = program();
    let model = &program.robot.model;
    let (mut controller, mut data) =
        (Controller::new(&program).expect("a compiled program can be executed"), Data::new(model));
    let mut q = program.robot.home.clone();
    let (mut below, mut z) = (f64::NEG_INFINITY, 0.0);
    for k in 0..800 {
        let command = controller.step(&Observation { time: f64::from(k) * 0.01, q: &q });
        assert_eq!(command.fault, None, "tick {k}");
        q.copy_from_slice(command.position);
        // It begins to sag when it is loaded, within half a second.
        q[1] += 4e-3 * (f64::from(k) / 50.0).min(1.0);
        model.forward(&q, &mut data);
        z = data.pose(model.link("tool").expect("a tool")).translation.vector.z - 0.2;
        below = below.max(-z);
    }
    assert!(below < 1e-3, "{} mm below", 1e3 * below);
    assert!(z < 5e-3, "{} mm above", 1e3 * z);
}

/// Joints that drift, or go twice as far: the floor holds, or a fault says that it does not, before it is passed by much.
#[test]
fn a_robot_beyond_its_reference_holds_the_floor_or_says_so() {
    let program = program();
    let n = program.robot.model.nv();
    for (joint, drift) in [(1, 0.005), (1, 0.02), (3, 0.05), (1, 0.2)] {
        let mut plant = Plant::ideal(n);
        plant.drift[joint] = drift;
        let ran = run(&program, &plant, 12.0);
        assert!(ran.below < 1.2e-3 || ran.fault.is_some(), "{joint} {drift}: {} mm below in silence", 1e3 * ran.below);
        if let Some((_, kind, text)) = &ran.fault {
            assert!(matches!(kind, FaultKind::Beyond | FaultKind::Tracking), "{text}");
        }
    }
    let plant = Plant { factor: vec![2.0; n], ..Plant::ideal(n) };
    let ran = run(&program, &plant, 12.0);
    assert!(ran.below < 1.2e-3, "{} mm below", 1e3 * ran.below);
    assert_eq!(ran.fault.map(|f| f.1), Some(FaultKind::Tracking));
}

/// Joints that stand, or turn the other way: named, within a second of the first motion.
#[test]
fn a_joint_that_does_not_follow_is_named() {
    let program = program();
    let n = program.robot.model.nv();
    let mut reversed = Plant::ideal(n);
    reversed.factor[3] = -1.0;
    let mut frozen = Plant::ideal(n);
    frozen.factor[3] = 0.0;
    let all = Plant { stands_from: 0.0, ..Plant::ideal(n) };
    for (plant, name) in [(reversed, "joint_4"), (frozen, "joint_4"), (all, "joint_")] {
        let ran = run(&program, &plant, 3.0);
        let (time, kind, text) = ran.fault.expect("a fault");
        assert!(kind == FaultKind::Tracking && text.contains(name), "{plant:?}: {text}");
        assert!(time < 1.0, "{plant:?}: after {time} s");
    }
}

/// A motion that is smaller than any threshold of a distance is watched too.
#[test]
fn a_robot_that_stands_in_a_small_motion_is_told() {
    for example in ["hello.hq", "smooth.hq"] {
        let program = common::program(example);
        let mut controller = Controller::new(&program).expect("a compiled program can be executed");
        let q = program.robot.home.clone();
        let kinds = (0..800)
            .filter_map(|k| controller.step(&Observation { time: f64::from(k) * program.robot.period, q: &q }).fault);
        assert_eq!(kinds.map(|f| f.kind()).next(), Some(FaultKind::Tracking), "{example}");
    }
}

/// Joints that stop short of a reference that rests, and that a high gain tells to go on for ever.
#[test]
fn a_robot_that_stands_short_of_its_goal_is_told() {
    let program = common::program_of(
        "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 125 Hz  tracking_gain 19 /s  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
stack s {
  level l hard { joint_position_limits  joint_velocity_limits }
  level m { joint_position { target { joint_6 0.84 rad }  gain 3 /s } }
}
run { duration 5 s }",
    );
    let n = program.robot.model.nv();
    let mut controller = Controller::new(&program).expect("a compiled program can be executed");
    let mut q = program.robot.home.clone();
    let mut told = None;
    for k in 0..500 {
        let time = f64::from(k) * 8e-3;
        let command = controller.step(&Observation { time, q: &q });
        let (u, fault) = (command.velocity.to_vec(), command.fault);
        if let Some(fault) = fault {
            told.get_or_insert((time, fault.kind(), controller.describe(&fault)));
        }
        // 35 mrad short of it.
        if q[5] > 0.875 {
            (0..n).for_each(|i| q[i] += u[i] * 8e-3);
        }
    }
    let (time, kind, text) = told.expect("a fault");
    assert!(kind == FaultKind::Tracking && text.contains("joint_6") && time < 3.0, "{time} s: {text}");
}

/// A robot that stands for a moment is waited for, and arrives; nothing is as fast as without the stop.
#[test]
fn a_robot_that_was_held_for_a_moment_arrives_without_a_lunge() {
    let program = program();
    let model = &program.robot.model;
    let mut controller = Controller::new(&program).expect("a compiled program can be executed");
    let mut q = program.robot.home.clone();
    let (mut before, mut after) = (0.0_f64, 0.0_f64);
    for k in 0..800 {
        let time = f64::from(k) * 0.01;
        let command = controller.step(&Observation { time, q: &q });
        assert_eq!(command.fault, None, "{time}");
        let fastest = command.velocity.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        if time < 0.3 {
            before = before.max(fastest)
        } else {
            after = after.max(fastest)
        }
        let held = (0.3..0.5).contains(&time);
        let velocity = command.velocity.to_vec();
        if !held {
            model.integrate(&mut q, &velocity, 0.01);
        }
    }
    assert!(after < 1.2 * before, "{after} rad/s after {before} rad/s");
    let mut data = Data::new(model);
    model.forward(&q, &mut data);
    let z = data.pose(model.link("tool").expect("a tool")).translation.vector.z;
    assert!((z - 0.2).abs() < 2e-3, "{z}");
}

/// A robot that is slowed down for one and a half seconds: targets that run by the clock, of a trajectory and of an expression of time, wait with the reference, and nothing
/// is made up for afterwards: the reference is no faster than before.
#[test]
fn targets_that_run_by_the_clock_wait_for_a_robot_that_is_slow() {
    let trajectory = "trapezoid(initial(position) + [0, 0.6, 0] m, speed: 0.2 m/s, acceleration: 0.6 m/s^2)";
    let expression = "initial(position) + [0, 0.25, 0] m * (1 - cos(2*pi*t/(9 s)))";
    for target in [trajectory, expression] {
        let spec = format!(
            "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
stack s {{ level l hard {{ joint_velocity_limits }}  level m {{ frame_position(tool) {{ position {target}  gain 10 /s }} }} }}
run {{ duration 12 s }}"
        );
        let program = common::program_of(&spec);
        let (model, dt) = (&program.robot.model, program.robot.period);
        let tool = model.link("tool").expect("the arm has a tool");
        let mut data = Data::new(model);
        let mut controller = Controller::new(&program).expect("a compiled program can be executed");
        let mut q = program.robot.home.clone();
        let (mut before, mut after, mut last) = (0.0_f64, 0.0_f64, None);
        for k in 0..700 {
            let time = f64::from(k) * dt;
            let command = controller.step(&Observation { time, q: &q });
            assert_eq!(command.fault, None, "{time}");
            let share = if (1.5..3.0).contains(&time) { 0.25 } else { 1.0 };
            q.iter_mut().zip(command.velocity).for_each(|(q, u)| *q += share * u * dt);
            model.forward(controller.reference(), &mut data);
            let place = data.pose(tool).translation.vector;
            let speed = last.replace(place).map_or(0.0, |last| (place - last).norm() / dt);
            let most = if time < 1.5 { &mut before } else { &mut after };
            *most = most.max(speed);
        }
        let waited = controller.stack_entered();
        assert!((0.2..1.2).contains(&waited), "{target}: {waited} s");
        assert!(after < 1.2 * before, "{target}: {after} m/s, {before} m/s before");
    }
}

/// A ball that comes at the tool, and a robot behind its commands: declared, the distance that the spec asks for is kept where both truly are.
#[test]
fn an_obstacle_that_moves_is_foreseen_by_declared_drives() {
    let arm =
        "urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }  points { tip tool }";
    let spec = |declared: &str, [x, y, z]: [f64; 3]| {
        format!(
            "hierarq 1
robot arm {{ {arm}  {declared} }}
obstacle ball {{ sphere 5 cm  position [{x}, {y}, {z}] m + [0, -0.15, 0] m/s * time }}
stack s {{
  level l hard {{ joint_position_limits  joint_velocity_limits }}
  level c hard {{ keep_clear(tip) {{ of ball  d_min 10 cm  gain 10 /s }} }}
  level m {{ frame_position(tool) {{ position initial(position)  gain 2 /s }} }}
}}
run {{ duration 4 s }}"
        )
    };
    let home = common::program_of(&spec("", [9.0; 3]));
    let tool = home.robot.model.link("tool").expect("the arm has a tool");
    let mut data = Data::new(&home.robot.model);
    home.robot.model.forward(&home.robot.home, &mut data);
    let at = data.pose(tool).translation.vector;
    let from = [at.x, at.y + 0.5, at.z];
    // Smallest distance between a robot that is 0.1 s behind and the ball (m), and the fault.
    let room = |declared: &str| {
        let program = common::program_of(&spec(declared, from));
        let (model, dt) = (&program.robot.model, program.robot.period);
        let mut data = Data::new(model);
        let mut controller = Controller::new(&program).expect("a compiled program can be executed");
        let (mut q, mut v) = (program.robot.home.clone(), vec![0.0; model.nv()]);
        let mut least = f64::INFINITY;
        for k in 0..350 {
            let time = f64::from(k) * dt;
            let command = controller.step(&Observation { time, q: &q });
            if let Some(fault) = command.fault {
                return (least, Some(fault.kind()));
            }
            v.iter_mut().zip(command.velocity).for_each(|(v, u)| *v += (1.0 - (-dt / 0.1_f64).exp()) * (u - *v));
            model.integrate(&mut q, &v, dt);
            model.forward(&q, &mut data);
            let ball = nalgebra::Vector3::new(from[0], from[1] - 0.15 * (time + dt), from[2]);
            least = least.min((data.pose(tool).translation.vector - ball).norm() - 0.05);
        }
        (least, None)
    };
    let (undeclared, fault) = room("");
    assert!(undeclared < 0.1 - 2e-3 && fault == Some(FaultKind::Beyond), "{undeclared} m, {fault:?}");
    let (declared, fault) = room("lag 100 ms");
    assert!(declared > 0.1 - 1e-3 && fault.is_none(), "{declared} m, {fault:?}");
}
