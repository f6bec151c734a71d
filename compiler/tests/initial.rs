//! Captures of `initial(..)` at the entry of a stack, compared with the same expression evaluated there.

use crate::common;

use common::state::{ARM7, Bench, CANOPIES, program, rng, words};
use common::{annotated, compile_text, examples};
use dsl::Syntax;
use hierarq_compiler::Compiled;
use runtime::evaluator::{Evaluator, RestInputs};
use runtime::program::{CaptureSource, Op, Program, Times};
use runtime::{Controller, Fault, Observation};
use stdlib_tasks::bound::Bound;

/// Expressions with their number of components; `@` names frames and joints of each robot.
const CAPTURED: &[(usize, &str)] = &[
    (3, "frame(@A).position"),
    (4, "frame(@A).orientation"),
    (3, "point(@A, [0.1, -0.2, 0.3] m)"),
    (1, "joint(@J)"),
    (1, "distance(finger, [lower, upper])"),
    (1, "distance(upper, plane([0, 0, 0.1] m, [0.3, 1, 0.1]))"),
    (1, "distance(finger, plane([0, 0, 0.1] m in @B, [0.3, 1, 0.1]))"),
    (3, "com"),
    (1, "norm(com - frame(@B).position)"),
    (1, "norm(frame(@A).position - frame(@B).position)"),
    (3, "(frame(@A).position + frame(@B).position)/2"),
    (3, "frame(@A).position in @B"),
    (4, "inverse(frame(@B).orientation)*frame(@A).orientation"),
    (7, "frame(@A).pose"),
    (7, "frame(@A).pose in @B"),
    (4, "frame(@A).pose.orientation"),
    (1, "if(joint(@J) < 0.2 rad, 2*joint(@J), joint(@K))"),
    (3, "[joint(@J), 0.5 rad, 3*joint(@K)]"),
    (3, "point(@A, [0.1, 0, 0] m) in @B"),
];

/// Numbers of the parameter `target` of a task.
fn target(evaluator: &Evaluator, program: &Program, task: usize) -> Vec<f64> {
    let Some(Bound::Value(slot)) = program.tasks[task].params.get("target") else { panic!("no target of time alone") };
    (slot.at..slot.at + slot.len).map(|at| evaluator.value(at).expect("a value")).collect()
}

#[test]
fn it_is_the_value_at_that_moment() {
    let tasks: Vec<String> =
        CAPTURED.iter().map(|(_, v)| format!("track({v}) {{ target initial({v})  gain 1 /s }}")).collect();
    for robot in [ARM7, CANOPIES] {
        let program = program(robot, &tasks);
        let bench = Bench { program: &program, inputs: vec![0.0; program.values.tape.inputs] };
        let (mut evaluator, mut problem) = Evaluator::new(&program, 0).expect("it can be executed");
        let rest = RestInputs::new(&program);
        let mut rng = rng(21);
        for _ in 0..10 {
            let start = bench.model().random_configuration(&mut rng);
            let later = bench.model().random_configuration(&mut rng);
            evaluator.enter(&start, rest.at(Times::default()));
            evaluator.update(&later, rest.at(Times { t: 1.0, time: 1.0 }), &mut problem).expect("rows");
            for (i, (len, text)) in CAPTURED.iter().enumerate() {
                let expected = bench.value(&*bench.task(i), &start, 0.0, *len);
                assert_eq!(target(&evaluator, &program, i), expected, "{text}");
                assert_ne!(bench.value(&*bench.task(i), &later, 0.0, *len), expected, "{text} does not move");
            }
        }
    }
}

#[test]
fn it_may_stand_in_every_task() {
    // The midpoint between the hands, plus 5 cm.
    let task = "frame_position(@A) { position initial((frame(@A).position + frame(@B).position)/2) + [0, 0, 0.05] m }";
    let program = program(CANOPIES, &[task.to_string()]);
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = runtime::SimulatedRobot::new(&program);
    for k in 0..600 {
        let command = controller.step(&Observation { time: f64::from(k) * 0.01, q: robot.measure() });
        assert!(command.fault.is_none());
        let velocity = command.velocity.to_vec();
        robot.apply(&velocity);
    }
    let at = |q: &[f64], name: &str| {
        let model = &program.robot.model;
        let mut data = robot::Data::new(model);
        model.forward(q, &mut data);
        *data.position(model.link(name).expect("a link"))
    };
    let home = &program.robot.home;
    let wanted = (at(home, "left_tool") + at(home, "right_tool")) / 2.0 + nalgebra::Vector3::new(0.0, 0.0, 0.05);
    assert!((at(robot.q(), "left_tool") - wanted).norm() < 1e-4);
}

/// Compiles a body.
fn compiled(body: &str) -> Compiled {
    let text = format!(
        "hierarq 1\n{}{}",
        ARM7.replace("base_point link_1", "base_point link_1  a { link link_4  offset [0, 0, 0.2] m }  b link_5"),
        words(body, ARM7)
    );
    compile_text(&text, Syntax::Native, &examples(), &[])
}

#[test]
fn one_expression_is_captured_once() {
    let text = "task a = track(com) { target initial(com) + initial(com)*0.5 }\n\
        task b = frame_position(@A) { position initial(com) }\n\
        task c = track(norm(com)) { target initial(norm(com)) }\n\
        stack s { level all { a  b  c } }\n";
    let program = compiled(text).program.expect("a program");
    let lengths: Vec<usize> = program.values.captures.iter().map(|c| c.len).collect();
    assert_eq!(lengths, [3, 1]);
}

#[test]
fn what_cannot_be_captured_is_a_fault() {
    // The points coincide at all times, so the distance has no derivative; `min` must not hide that.
    for task in [
        "track(joint(@J)) { target initial(distance(a, b))*0.3 rad/(1 m) }",
        "track(joint(@J)) { target 1 rad * min(0.3, initial(distance(a, b))/(1 m)) }",
        "track(joint(@J)) { target 0.1 rad * t/(1 s) + if(initial(distance(a, b)) < 1 m, 0.1 rad, 0.2 rad) }",
    ] {
        let body = format!("task x = {task}\nstack s {{ level all {{ x }} }}\n");
        let compiled = compiled(&body);
        let found: Vec<&str> = compiled.report.diagnostics.iter().map(|d| d.code).collect();
        assert_eq!(found, ["HQ0502"], "{}", annotated(&compiled));
        assert!(compiled.report.diagnostics[0].message.contains("no finite value"), "{}", annotated(&compiled));
    }
}

#[test]
fn what_is_lost_on_the_robot_is_a_fault() {
    let body = "task x = track(joint(@J)) { target 1 rad * min(2, initial(1/(joint(@K)/(1 rad) - 0.25))) }\nstack s { level all { x } }\n";
    let program = compiled(body).program.expect("a program");
    let mut q = program.robot.home.clone();
    let k = program.robot.model.dof("joint_4").expect("a joint");
    q[k] = 0.25;
    let mut controller = Controller::new(&program).expect("it can be executed");
    let command = controller.step(&Observation { time: 0.0, q: &q });
    assert!(matches!(command.fault, Some(Fault::Value { .. })), "{:?}", command.fault);
    assert!(command.velocity.iter().all(|&v| v == 0.0));
}

#[test]
fn a_value_that_needs_its_capture_is_written_and_read() {
    // Before the capture, this is one over zero.
    let body = "task x = track(joint(@J)) { target 0.4 rad^2/initial(joint(@K)) }\nstack s { level all { x } }\n";
    let good = compiled(body).program.expect("a program");
    let text = serde_json::to_string(&good).expect("JSON");
    let back: Program = serde_json::from_str(&text).expect("a program");
    assert_eq!(back, good);
    let (mut evaluator, mut problem) = Evaluator::new(&back, 0).expect("it can be executed");
    let rest = RestInputs::new(&back);
    let home = &back.robot.home;
    evaluator.enter(home, rest.at(Times::default()));
    evaluator.update(home, rest.at(Times::default()), &mut problem).expect("rows");
    let k = back.robot.model.dof("joint_4").expect("a joint");
    assert_eq!(target(&evaluator, &back, 0), [0.4 / home[k]]);
}

#[test]
fn programs_are_written_and_read() {
    let body = "task x = track(com) { target initial(com + point(@A, [0, 0, 0.1] m)*0 + [0, 0, 0.01] m) }\n\
        task y = keep(distance(finger, plane([0, 0, -1] m, [0, 0, 1]))) { min initial(distance(finger, lower))*0 }\n\
        stack s { level all { x  y } }\n";
    let good = compiled(body).program.expect("a program");
    let text = serde_json::to_string(&good).expect("JSON");
    let back: Program = serde_json::from_str(&text).expect("a program");
    assert_eq!(back, good);
    back.check().expect("a good program");
    // Damaged expressions are rejected.
    type Damage = fn(&mut stdlib_tasks::expression::Expression);
    let damages: [Damage; 6] = [
        |e| e.inputs.push(0),
        |e| e.outputs.truncate(1),
        |e| e.outputs[0] = 1000,
        |e| e.ops.push(Op::State(1000)),
        |e| e.ops.push(Op::T),
        |e| e.leaves.clear(),
    ];
    for (i, damage) in damages.iter().enumerate() {
        let mut bad = good.clone();
        let found = bad.values.captures.iter_mut().find_map(|c| match &mut c.source {
            CaptureSource::State(e) if e.outputs.len() == 3 => Some(e),
            _ => None,
        });
        damage(found.expect("a captured vector"));
        assert!(bad.check().is_err(), "damage {i} goes unnoticed");
    }
}
