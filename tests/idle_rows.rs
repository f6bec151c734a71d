//! Rows that the compiler leaves out can never become active: checked at random configurations and in a run.

use crate::common;

use robot::random::SplitMix64;
use runtime::program::Times;
use runtime::{Controller, Evaluator, Observation, Program, RestInputs};
use solver::Structure;

/// The safety tasks with distances that leave space for an elbow.
fn spec() -> Program {
    let text = std::fs::read_to_string(common::example("safety_tasks.hq")).expect("the example is there");
    let text = text.replace("d_min 0.35 m", "d_min 0.1 m").replace("d_min 0.5 m", "d_min 0.1 m");
    let text = text.replace("d_min 0.2 m", "d_min 0.05 m").replace("0.45", "0.1");
    common::program_of(&text)
}

fn proven() -> Program {
    let mut program = spec();
    compiler::mark_idle_rows(&mut program);
    program
}

/// `(member, row)` of every idle row.
fn idle(evaluator: &Evaluator) -> Vec<(usize, usize)> {
    let members = evaluator.members().iter().enumerate();
    members.flat_map(|(k, m)| m.idle.iter().enumerate().filter(|(_, is)| **is).map(move |(r, _)| (k, r))).collect()
}

/// At configurations and velocities within the joints' limits, with many corners, no idle row is violated.
#[test]
fn no_configuration_and_no_speed_touches_an_idle_row() {
    let (program, whole) = (proven(), spec());
    let (evaluator, _) =
        Evaluator::new(&program, program.first_stack().expect("it runs a stack")).expect("it can be executed");
    let idle = idle(&evaluator);
    assert_eq!(idle.len(), 8, "elbows against column, chest, head and deck");
    let (mut all, mut problem) =
        Evaluator::new(&whole, whole.first_stack().expect("it runs a stack")).expect("it can be executed");
    let rest = RestInputs::new(&whole);
    let model = &whole.robot.model;
    let speeds: Vec<f64> =
        (model.dofs.iter()).map(|d| if d.name.starts_with("arm") { 0.5 } else { d.velocity }).collect();
    let mut dice = SplitMix64(7);
    let mut least = f64::INFINITY;
    for _ in 0..20_000 {
        let mut q = whole.robot.home.clone();
        for d in &model.dofs {
            if let Some(i) = d.q_index {
                let share = dice.unit();
                let share = if share < 0.2 {
                    0.0
                } else if share > 0.8 {
                    1.0
                } else {
                    dice.unit()
                };
                q[i] = d.lower + (d.upper - d.lower) * share;
            }
        }
        if all.update(&q, rest.at(Times::default()), &mut problem).is_err() {
            continue;
        }
        for &(k, r) in &idle {
            let m = &all.members()[k];
            let level = &problem.levels[m.level];
            let i = m.rows.start + r;
            let fastest: f64 = level.row(i).iter().zip(&speeds).map(|(a, s)| a.abs() * s).sum();
            least = least.min(-level.lower[i] - fastest);
        }
    }
    assert!(least > 0.0 && least.is_finite(), "the nearest call was {least} m/s");
}

/// The same run with and without the rows gives the same commands and the same margins.
#[test]
fn a_run_is_the_same_without_them() {
    let (with, without) = (spec(), proven());
    let mut all = Controller::new(&with).expect("it can be executed");
    let mut few = Controller::new(&without).expect("it can be executed");
    let mut q = with.robot.home.clone();
    let mut left_out = 0;
    for tick in 0..3000 {
        let time = tick as f64 * with.robot.period;
        let a = all.step(&Observation { time, q: &q });
        let b = few.step(&Observation { time, q: &q });
        assert!(a.fault.is_none() && b.fault.is_none());
        for (x, y) in a.velocity.iter().zip(b.velocity) {
            assert!((x - y).abs() < 1e-9, "{x} and {y} at {time}");
        }
        assert_eq!(all.evaluator().margins(), few.evaluator().margins());
        let levels = few.problem().levels.iter();
        left_out += levels.flat_map(|l| l.structure()).filter(|s| **s == Structure::Absent).count();
        q.copy_from_slice(all.reference());
    }
    assert_eq!(left_out, 8 * 3000);
}

/// Outside of the limits that the proof assumes, all rows are present.
#[test]
fn a_joint_outside_its_limits_brings_all_rows_back() {
    let program = proven();
    let (mut evaluator, mut problem) =
        Evaluator::new(&program, program.first_stack().expect("it runs a stack")).expect("it can be executed");
    let rest = RestInputs::new(&program);
    let absent = |problem: &solver::Problem| {
        problem.levels.iter().flat_map(|l| l.structure()).filter(|s| **s == Structure::Absent).count()
    };
    let mut q = program.robot.home.clone();
    evaluator.update(&q, rest.at(Times::default()), &mut problem).expect("home is a good place");
    assert_eq!(absent(&problem), 8);
    let joint = program.robot.model.dof("arm_left_1").expect("the robot has it");
    let d = &program.robot.model.dofs[joint];
    q[d.q_index.expect("it is a joint")] = d.upper + 1e-3;
    evaluator.update(&q, rest.at(Times::default()), &mut problem).expect("so is this");
    assert_eq!(absent(&problem), 0);
    let (mut whole, mut reference) =
        Evaluator::new(&spec(), program.first_stack().expect("it runs a stack")).expect("it can be executed");
    whole.update(&q, rest.at(Times::default()), &mut reference).expect("and this");
    assert_eq!(problem, reference);
}

/// A variable distance, or a base without limits, is never left out.
#[test]
fn what_moves_stays_in() {
    let text = |wall: &str| {
        format!(
            "hierarq 1
             robot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
             stack s {{
               level limits hard {{ joint_position_limits  joint_velocity_limits }}
               level wall hard {{ virtual_wall(link_4) {{ through [[0, 0, -1], [1, 0, -1], [0, 1, -1]] m  {wall} }} }}
               level still {{ joint_velocity {{ velocity {{ all 0 rad/s }} }} }}
             }}
             run {{ duration 1 s }}"
        )
    };
    let count = |wall: &str| {
        let mut program = common::program_of(&text(wall));
        compiler::mark_idle_rows(&mut program);
        let (evaluator, _) =
            Evaluator::new(&program, program.first_stack().expect("it runs a stack")).expect("it can be executed");
        idle(&evaluator).len()
    };
    assert!(count("d_min 0 m") > 0, "a floor a metre below the arm's base");
    assert_eq!(count("d_min 0.01 m * sin(t/(1 s))"), 0);
    // The wall is within the arm's reach.
    assert_eq!(count("d_min 1.2 m"), 0);
}
