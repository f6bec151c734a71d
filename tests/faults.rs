//! Faulty inputs: for any observation the command is finite and within limits, and a fault stops the robot.

use crate::common;

use proptest::prelude::*;
use runtime::{Controller, Fault, FaultKind, Observation, Program};

fn first_step(program: &Program) -> (Controller, Vec<f64>) {
    let mut controller = Controller::new(program).expect("a compiled program can be executed");
    let home = program.robot.home.clone();
    let command = controller.step(&Observation { time: 0.0, q: &home });
    assert_eq!(command.fault, None);
    (controller, home)
}

/// A fault at a call, and the time at which the robot is at rest after it.
struct Stopped {
    fault: Fault,
    time: f64,
}

/// Passes an observation that is a fault, and calls on with it each 10 ms until the robot is told to stand: it never speeds up on the way.
fn stops(controller: &mut Controller, mut time: f64, q: &[f64]) -> Stopped {
    let mut last: Vec<f64> = vec![f64::INFINITY; controller.velocity().len()];
    let mut found = None;
    for _ in 0..200 {
        let command = controller.step(&Observation { time, q });
        let fault = command.fault.expect("a fault");
        assert_eq!(*found.get_or_insert(fault), fault);
        assert!(command.velocity.iter().zip(&last).all(|(v, before)| v.is_finite() && v.abs() <= before.abs()));
        assert!(command.position.iter().all(|x| x.is_finite()));
        last.copy_from_slice(command.velocity);
        if command.at_rest {
            assert!(last.iter().all(|v| *v == 0.0));
            return Stopped { fault, time };
        }
        time = if time.is_finite() { time + 0.01 } else { time };
    }
    panic!("the robot does not come to rest");
}

fn still(controller: &mut Controller, time: f64, q: &[f64]) -> Fault {
    let command = controller.step(&Observation { time, q });
    assert!(command.velocity.iter().all(|v| *v == 0.0), "the robot must be kept still");
    command.fault.expect("a fault")
}

#[test]
fn a_number_that_is_not_finite_keeps_the_robot_still_for_good() {
    let program = common::program("safety_tasks.hq");
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (mut controller, home) = first_step(&program);
        let mut q = home.clone();
        q[7] = bad;
        let Stopped { fault, time } = stops(&mut controller, 0.01, &q);
        assert_eq!(fault, Fault::Observation { index: Some(7) });
        assert_eq!(fault.kind(), FaultKind::NotFinite);
        // Valid observations alone do not resume motion ...
        assert_eq!(still(&mut controller, time + 0.01, &home), fault);
        // ... but a restart does.
        controller.restart();
        assert_eq!(controller.step(&Observation { time: 0.0, q: &home }).fault, None);
    }
    let (mut controller, home) = first_step(&program);
    assert_eq!(stops(&mut controller, f64::NAN, &home).fault, Fault::Observation { index: None });
    let (mut controller, home) = first_step(&program);
    assert!(matches!(stops(&mut controller, 0.01, &home[..3]).fault, Fault::Observation { index: Some(3) }));
}

#[test]
fn a_robot_that_does_not_follow_is_a_fault() {
    let program = common::program("hello.hq");
    let (mut controller, mut q) = first_step(&program);
    // No joint gets so far in 10 ms.
    q[2] += 0.6;
    let Stopped { fault, .. } = stops(&mut controller, 0.01, &q);
    assert!(matches!(fault, Fault::Jump { dof: 2, .. }), "{fault:?}");
    assert!(controller.describe(&fault).contains("joint_3"), "{}", controller.describe(&fault));
}

#[test]
fn a_tick_that_comes_late_keeps_the_robot_still_for_good() {
    let program = common::program("hello.hq");
    // The default deadline at 100 Hz is a period and 20 ms.
    let (mut controller, home) = first_step(&program);
    assert_eq!(controller.step(&Observation { time: 0.0299, q: &home }).fault, None);
    let Stopped { fault, time } = stops(&mut controller, 0.0601, &home);
    assert_eq!(fault.kind(), FaultKind::Deadline);
    assert!(controller.describe(&fault).contains("30.2 ms"), "{}", controller.describe(&fault));
    assert_eq!(still(&mut controller, time + 0.01, &home), fault);
    // A sum of periods is no fault by its rounding.
    let (mut controller, home) = first_step(&program);
    assert_eq!(controller.step(&Observation { time: 0.01, q: &home }).fault, None);
    assert_eq!(controller.step(&Observation { time: 0.04 + 1e-12, q: &home }).fault, None);
    // A clock must not go backwards.
    let (mut controller, home) = first_step(&program);
    assert_eq!(stops(&mut controller, -0.01, &home).fault.kind(), FaultKind::Deadline);
}

const ARM: &str = "hierarq 1\nrobot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }\n";

#[test]
fn a_hard_level_that_becomes_impossible_is_a_fault_with_names() {
    // The floor rises at 1 m/s under an arm that may move at 0.1 rad/s.
    let text = format!(
        "{ARM}stack s {{
           level limits hard {{ joint_velocity_limits {{ max 0.1 rad/s }} }}
           level floor hard {{ virtual_wall(tool) {{ through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m  d_min 1 m/s * t }} }}
         }}
         run {{ duration 5 s }}"
    )
    .replace("virtual_wall(tool)", "virtual_wall(link_7)");
    let program = common::program_of(&text);
    let run = common::run(&program);
    let at = run.iter().position(|s| s.fault.is_some()).expect("the floor wins");
    assert_eq!(run[at].fault, Some(Fault::Infeasible { level: 1 }));
    for s in &run[at..] {
        assert!(s.command.iter().all(|v| *v == 0.0));
        assert_eq!(s.fault, run[at].fault);
    }
    for s in &run[..at] {
        assert!(s.command.iter().all(|v| v.abs() <= 0.1 + 1e-9));
    }
    let mut controller = Controller::new(&program).expect("it can be executed");
    for s in &run[..=at] {
        controller.step(&Observation { time: s.time, q: &s.q });
    }
    let text = controller.describe(&Fault::Infeasible { level: 1 });
    assert!(text.contains("`floor`") && text.contains("virtual_wall"), "{text}");
}

#[test]
fn a_value_that_leaves_its_range_is_a_fault() {
    let text = format!(
        "{ARM}stack s {{
           level limits hard {{ joint_position_limits  joint_velocity_limits }}
           level motion {{ frame_position(tool) {{ position initial(position)  gain 2 /s * (1 - t/(1 s)) }} }}
         }}
         run {{ duration 2 s }}"
    );
    let run = common::run(&common::program_of(&text));
    let first = run.iter().find(|s| s.fault.is_some()).expect("the gain becomes negative after one second");
    assert!((first.time - 1.01).abs() < 0.011, "{}", first.time);
    assert!(matches!(first.fault, Some(Fault::Value { .. })));
}

/// A value that only another stack uses causes no fault, and is not even computed.
#[test]
fn a_value_of_another_stack_is_none_of_its_business() {
    let text = format!(
        "{ARM}task fading = hold(tool) {{ gain (1 - t/(1 s)) * 2 /s }}
         task steady = frame_position(tool) {{ position initial(position) + [0, 0, 0.01] m * sin(t/(1 s)) }}
         stack one {{ level l {{ fading }} }}
         stack two {{ level l {{ steady }} }}
         run {{ stack two  duration 3 s }}"
    );
    let program = common::program_of(&text);
    for (stack, good) in [(1, true), (0, false)] {
        let mut controller = Controller::for_stack(&program, stack).expect("it can be executed");
        let mut q = program.robot.home.clone();
        let fault = (0..200).find_map(|tick| {
            let fault = controller.step(&Observation { time: tick as f64 * 0.01, q: &q }).fault;
            q.copy_from_slice(controller.reference());
            fault
        });
        assert_eq!(fault.is_none(), good, "{fault:?}");
    }
}

#[test]
fn a_division_by_zero_on_the_way_is_a_fault() {
    let text = format!(
        "{ARM}stack s {{ level motion {{ frame_position(tool) {{ position initial(position) + [0, 0, 0.01] m / (1 - t/(1 s)) }} }} }}
         run {{ duration 2 s }}"
    );
    let run = common::run(&common::program_of(&text));
    let at = run.iter().position(|s| s.fault.is_some()).expect("1/0 at one second");
    assert!(run[at].time <= 1.0 + 1e-9);
    assert!(run.iter().all(|s| s.command.iter().all(|v| v.is_finite())));
}

#[test]
fn the_robot_keeps_within_its_limits_with_lag_and_noise() {
    let text = std::fs::read_to_string(common::example("safety_tasks.hq")).expect("readable");
    let text = text.replace("duration 50 s", "duration 5 s  simulator { lag 0.03 s  noise 0.0005 rad  seed 7 }");
    let text = text.replace("stack safety {", "robot tuned from canopies { tracking_gain 5 /s }\n\nstack safety {");
    let program = common::program_of(&text);
    let (a, b) = (common::run(&program), common::run(&program));
    for (x, y) in a.iter().zip(&b) {
        assert_eq!((&x.q, &x.command), (&y.q, &y.command), "a seeded run is the same every time");
        assert!(x.fault.is_none());
        for (d, v) in program.robot.model.dofs.iter().zip(&x.command) {
            assert!(v.abs() <= d.velocity, "{}", d.name);
        }
    }
    let other = common::program_of(&text.replace("seed 7", "seed 8"));
    assert_ne!(common::run(&other)[10].command, a[10].command, "another seed is another run");
}

#[test]
fn the_lag_is_first_order() {
    // A step of the commanded speed: q(t) = v (t - lag (1 - exp(-t/lag))).
    let text = format!(
        "{ARM}stack s {{ level motion {{ joint_velocity {{ velocity {{ joint_1 0.5 rad/s }} }} }} }}
         run {{ duration 1 s  simulator {{ lag 0.2 s }} }}"
    )
    .replace("rate 100 Hz", "rate 100 Hz  tracking_gain 0 /s");
    let run = common::run(&common::program_of(&text));
    for s in &run {
        let expected = 0.5 * (s.time - 0.2 * (1.0 - (-s.time / 0.2).exp()));
        assert!((s.q[0] - expected).abs() < 1e-9, "{} and {expected} at {} s", s.q[0], s.time);
    }
}

fn mutate(json: &mut serde_json::Value, path: &[usize], what: &serde_json::Value) {
    use serde_json::Value::{Array, Object};
    let Some((&first, rest)) = path.split_first() else {
        *json = what.clone();
        return;
    };
    match json {
        Array(a) if !a.is_empty() => {
            let n = a.len();
            mutate(&mut a[first % n], rest, what);
        }
        Object(o) if !o.is_empty() => {
            let n = o.len();
            if let Some(v) = o.values_mut().nth(first % n) {
                mutate(v, rest, what);
            }
        }
        leaf => *leaf = what.clone(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// An edited compiled program is rejected, or runs without a panic and with finite commands.
    #[test]
    fn an_edited_program_never_panics(
        path in prop::collection::vec(0usize..1000, 2..9),
        name in prop_oneof![Just("swivel_angle.hq"), Just("own_tasks.hq")],
        what in prop_oneof![
            Just(serde_json::json!(null)), Just(serde_json::json!(-1)), Just(serde_json::json!(1e300)),
            Just(serde_json::json!(99999)), Just(serde_json::json!("x")), Just(serde_json::json!([])), Just(serde_json::json!({})),
        ],
    ) {
        let mut json = serde_json::to_value(common::program(name)).unwrap();
        mutate(&mut json, &path, &what);
        let Ok(program) = serde_json::from_value::<Program>(json) else { return Ok(()) };
        if program.run.duration > 1e4 || program.robot.period < 1e-5 {
            return Ok(());
        }
        let Ok(mut controller) = Controller::new(&program) else { return Ok(()) };
        for k in 0..3 {
            let home = program.robot.home.clone();
            let command = controller.step(&Observation { time: 0.01 * f64::from(k), q: &home });
            prop_assert!(command.velocity.iter().all(|v| v.is_finite()));
        }
    }

    /// Random observations give finite commands within the robot's speed limits.
    #[test]
    fn random_observations_give_finite_commands(
        noise in prop::collection::vec(-0.4..0.4f64, 21 * 5),
        bad in prop::option::of((0usize..5, 0usize..21)),
    ) {
        let program = common::program("safety_tasks.hq");
        let mut controller = Controller::new(&program).unwrap();
        for k in 0..5 {
            let mut q = program.robot.home.clone();
            for (x, e) in q.iter_mut().zip(&noise[21 * k..]) {
                *x += e;
            }
            if let Some((tick, i)) = bad
                && tick == k
            {
                q[i] = f64::NAN;
            }
            let command = controller.step(&Observation { time: 0.01 * k as f64, q: &q });
            for (d, v) in program.robot.model.dofs.iter().zip(command.velocity) {
                prop_assert!(v.is_finite() && v.abs() <= d.velocity + 1e-9);
            }
        }
    }
}

#[test]
fn a_program_whose_robot_cannot_move_is_refused() {
    let mut program = common::program("hello.hq");
    let urdf = "<robot name=\"still\"><link name=\"a\"/></robot>";
    let (model, _) = robot::Model::from_urdf(urdf, &robot::Options::default()).expect("one link is a tree");
    program.robot.home = model.neutral();
    program.robot.model = model;
    let error = Controller::new(&program).err().expect("nothing moves");
    assert_eq!(error.place, "robot.model");
}

/// HQ0501 checks a constant gain at compile time; a variable one must satisfy the same bound at every tick.
#[test]
fn a_gain_that_grows_beyond_the_control_period_is_a_fault() {
    let text = format!(
        "{ARM}task limits = joint_position_limits {{ gain (10 + 500*t/(1 s)) /s }}\n\
         stack s {{ level l hard {{ limits }} level m {{ joint_velocity {{ velocity 1.9 rad/s }} }} }}\n"
    );
    let program = common::program_of(&text);
    let mut simulation = runtime::Simulation::new(&program).expect("it can be executed");
    let mut all = common::Everything::default();
    simulation.run(&mut all, &mut || 0.0, &mut |_| true).expect("nothing is written");
    let fault = all.0.iter().find_map(|s| s.fault.map(|f| (s.time, f)));
    let Some((time, Fault::Value { .. })) = fault else { panic!("{fault:?}") };
    assert!((time - 0.19).abs() < 1e-9, "10 + 500 t passes 100 /s at 0.18 s, and the fault came at {time} s");
    assert!(all.0.iter().all(|s| s.margins.iter().all(|m| *m >= -1e-9)), "no limit was passed before");
}

/// Returns the first fault of a run of two tasks, with its time and its description.
fn first_fault(tasks: &str) -> (f64, Fault, String) {
    let program = common::program_of(&format!("{ARM}{tasks}stack s {{ level a {{ limit }} level b {{ pull }} }}\n"));
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut q = program.robot.home.clone();
    for k in 0..500 {
        let time = 0.01 * f64::from(k);
        let (velocity, fault) = {
            let command = controller.step(&Observation { time, q: &q });
            (command.velocity.to_vec(), command.fault)
        };
        if let Some(fault) = fault {
            let text = controller.describe(&fault);
            assert!(velocity.iter().all(|v| v.is_finite()));
            assert_eq!(stops(&mut controller, time + 0.01, &q).fault, fault);
            return (time, fault, text);
        }
        program.robot.model.integrate(&mut q, &velocity, program.robot.period);
    }
    panic!("no fault");
}

/// State-dependent values are monitored where they are used: a gain, and two limits that close in on each other.
#[test]
fn gains_and_limits_that_leave_their_sense_are_faults() {
    let pull = "task pull = track(joint(joint_1)) { target 1 rad }\n";
    let (_, fault, words) = first_fault(&format!(
        "task limit = keep(joint(joint_2)) {{ max 1.5 rad  gain 200 /s/rad * joint(joint_1) + 1 /s }}\n{pull}"
    ));
    assert!(matches!(fault, Fault::Gain { member: 0 }) && fault.kind() == FaultKind::Value, "{fault:?}");
    assert!(words.contains("gain of task `limit`"), "{words}");
    let (time, fault, words) = first_fault(&format!(
        "task limit = keep(joint(joint_2)) {{ min 0.2 rad  max 0.5 rad - 0.1 rad/s * t  sampled_margin 0.01 rad }}\n{pull}"
    ));
    assert!(matches!(fault, Fault::Crossed { member: 0, row: 0 }) && fault.kind() == FaultKind::Crossed, "{fault:?}");
    assert!(words.contains("lower limit is above"), "{words}");
    // 0.3 - 0.1 t - 0.02 = 0.1 / (5 /s): the sides, each with its reserve, close at 0.1 rad/s.
    assert!((time - 2.6).abs() < 0.02, "{time}");
}

/// Values that no compiler writes, but a person may: they are rejected before they can cause damage.
#[test]
fn absurd_numbers_in_a_program_are_refused() {
    let refused = |spoil: &dyn Fn(&mut Program)| {
        let mut program = common::program("safety_tasks.hq");
        spoil(&mut program);
        let error = program.check().expect_err("it must be refused");
        assert!(!error.message.is_empty() && Controller::new(&program).is_err());
    };
    refused(&|p| p.robot.model.dofs[4].velocity = -1.0);
    refused(&|p| p.robot.model.dofs[4].velocity = f64::NAN);
    refused(&|p| p.robot.model.dofs[4].upper = -10.0);
    refused(&|p| p.values.tape.inputs = 200_000_000);
    refused(&|p| p.values.tape.inputs = usize::MAX);
    refused(&|p| p.run.duration = 1e-4);
}
