//! Shared control in complete programs: a hand is displaced by a push by force over stiffness and returns, is guided by
//! hand, and accelerates within its limits. Poses are computed from the recorded joints.

use crate::common;

use nalgebra::{Isometry3, Vector3};
use robot::{Data, Model};
use runtime::Program;
use runtime::program::{MachineProgram, StateProgram, Subject, TransitionProgram, Trigger};
use runtime::record::summary::MARGIN_TOLERANCE;

/// Returns the pose of a link at a configuration.
fn pose(model: &Model, link: &str, q: &[f64]) -> Isometry3<f64> {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    *data.pose(model.link(link).expect("the robot has it"))
}

#[test]
fn a_push_displaces_the_hand_by_force_over_stiffness_and_it_comes_back() {
    let program = common::program("compliance.hq");
    let model = &program.robot.model;
    let home = ["left_tool", "right_tool"].map(|l| pose(model, l, &program.robot.home));
    let run = common::run(&program);
    let mut last = vec![0.0; model.nv()];
    let mut furthest = 0.0_f64;
    for s in &run {
        assert!(s.fault.is_none());
        assert!(s.margins.iter().all(|h| *h >= -MARGIN_TOLERANCE), "at {} s", s.time);
        for (d, (v, before)) in model.dofs.iter().zip(s.command.iter().zip(&last)) {
            if d.unit == robot::DofUnit::Radian {
                assert!((v - before).abs() <= 5.0 * 0.01 + 1e-9, "{} at {} s", d.name, s.time);
            }
        }
        last.clone_from(&s.command);
        let [left, right] = ["left_tool", "right_tool"].map(|l| pose(model, l, &s.q));
        let away = right.translation.vector - home[1].translation.vector;
        furthest = furthest.max(away.x);
        let turned = (right.rotation * home[1].rotation.inverse()).angle();
        assert!(
            turned < 0.1_f64.to_radians() && away.yz().norm() < 1e-4,
            "only pushed along x: {away} at {} s",
            s.time
        );
        assert!((left.translation.vector - home[0].translation.vector).norm() < 1e-5, "the other hand at {} s", s.time);
        // Critically damped, it settles after a second or two.
        let expected = match s.time {
            t if t <= 1.0 || t >= 8.5 => Some(0.0),
            t if (4.5..=5.0).contains(&t) => Some(20.0 / 800.0),
            _ => None,
        };
        if let Some(x) = expected {
            assert!((away - Vector3::new(x, 0.0, 0.0)).norm() < 2e-5, "{away} at {} s", s.time);
        }
    }
    assert!(furthest < 0.02503, "it overshoots: {furthest}");
}

/// A program with the right hand's task of this text, after the header of the examples.
fn canopies(tasks: &str) -> Program {
    common::program_of(&format!("hierarq 1\nimport \"common/canopies.hq\" {{ canopies }}\n{tasks}"))
}

const BODY: &str = "mass { linear 20 kg  angular 3 kg m^2 }  damping { linear 253 N s/m  angular 27 N m s/rad }";

#[test]
fn a_sensor_that_turns_with_the_hand_pushes_along_its_own_axes() {
    let program = canopies(&format!(
        "task lead = hand_guiding(right) {{ {BODY}
           wrench {{ force ([0, 0, 10] N in right_tool) in world  moment ([2, 0, 0] N m in right_tool) in world }} }}
         stack s {{ lock [base]  level motion {{ lead }} }}
         run {{ stack s  duration 3 s }}"
    ));
    let model = &program.robot.model;
    let run = common::run(&program);
    assert!(run.iter().all(|s| s.fault.is_none()));
    let [a, b, c] = [2.97, 2.98, 2.99].map(|t| {
        let s = run.iter().find(|s| (s.time - t).abs() < 1e-6).expect("a tick");
        pose(model, "right_tool", &s.q)
    });
    // It turns about its own x at μ/d, and is pushed along an axis that turns with it: 10 N / 253 N s/m, less the lag
    // of the mass.
    let speed = (c.translation.vector - a.translation.vector).norm() / 0.02;
    let turning = (b.rotation.inverse() * c.rotation).scaled_axis() / 0.01;
    assert!((speed - 10.0 / 253.0).abs() < 1e-4, "{speed}");
    assert!((turning - Vector3::new(2.0 / 27.0, 0.0, 0.0)).norm() < 3e-4, "{turning}");
}

#[test]
fn another_stack_takes_the_hand_over_at_its_speed() {
    let mut program = canopies(&format!(
        "task lead = hand_guiding(right) {{ {BODY}  wrench {{ force [0, 20, 0] N }} }}
         task comply = admittance(right) {{ {BODY}  stiffness {{ linear 800 N/m  angular 30 N m }}  wrench {{ force [0, 0, 0] N }} }}
         stack a {{ lock [base]  level motion {{ lead }} }}
         stack b {{ lock [base]  level motion {{ comply }} }}
         run {{ stack a  duration 4 s }}"
    ));
    let state = |name: &str, inside: Option<usize>, stack: Option<usize>| StateProgram {
        name: name.to_string(),
        parent: inside,
        initial: inside.is_none().then_some(1),
        regions: Vec::new(),
        stack,
        is_final: false,
        enter: Vec::new(),
        activities: Vec::new(),
        exit: Vec::new(),
        transitions: Vec::new(),
    };
    let mut states = vec![state("m", None, None), state("led", Some(0), Some(0)), state("held", Some(0), Some(1))];
    states[1].transitions.push(TransitionProgram {
        trigger: Trigger::After(2.0),
        text: "after 2 s".to_string(),
        target: 2,
        blend: 0.0,
    });
    let (actions, measured, reached, merged) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    program.machine = Some(MachineProgram { states, actions, measured, reached, merged });
    program.run.subject = Subject::Machine;
    let model = &program.robot.model;
    let places: Vec<Vector3<f64>> =
        common::run(&program).iter().map(|s| pose(model, "right_tool", &s.q).translation.vector).collect();
    let speed: Vec<Vector3<f64>> = places.windows(2).map(|w| (w[1] - w[0]) / 0.01).collect();
    let fastest = speed.iter().map(Vector3::norm).fold(0.0, f64::max);
    assert!((fastest - 20.0 / 253.0).abs() < 1e-3, "{fastest}");
    for (k, w) in speed.windows(2).enumerate() {
        // Forces of about 20 N on 20 kg: 1 m/s^2, and slightly more on a curved motion of the arm.
        assert!((w[1] - w[0]).norm() < 0.0125, "at tick {k}: {} and {}", w[0], w[1]);
    }
    // The mass continues to move, and returns to the position at which the second stack began.
    let last = places.last().expect("ticks");
    let began = places[200];
    assert!((last - began).norm() < 2e-4, "{last} and {began}");
    assert!(places[200..].iter().any(|p| (p - began).norm() > 4e-3));
}
