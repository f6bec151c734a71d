//! The freedom that a target leaves open, decided by `least_motion`: against projections with a Jacobian from differences.

use nalgebra::{DMatrix, DVector};
use robot::Data;
use runtime::{Controller, Observation, Program};

use crate::common;

/// A tick: the Jacobian of the tool's position by differences, 3×n, and the velocity before and after it.
struct Step {
    jacobian: DMatrix<f64>,
    before: DVector<f64>,
    after: DVector<f64>,
}

fn jacobian(program: &Program, q: &[f64]) -> DMatrix<f64> {
    let model = &program.robot.model;
    let tool = model.link("tool").expect("a tool");
    let mut data = Data::new(model);
    let mut at = |dof: usize, dt: f64| {
        let (mut q, mut v) = (q.to_vec(), vec![0.0; model.nv()]);
        v[dof] = 1.0;
        model.integrate(&mut q, &v, dt);
        model.forward(&q, &mut data);
        *data.position(tool)
    };
    let columns: Vec<_> = (0..model.nv()).map(|dof| (at(dof, 1e-6) - at(dof, -1e-6)) / 2e-6).collect();
    DMatrix::from_fn(3, columns.len(), |i, k| columns[k][i])
}

/// Steps of the example with this last level, and with limits that do not act.
fn steps(last: &str) -> Vec<Step> {
    let text = std::fs::read_to_string(common::example("smooth.hq")).expect("an example");
    let text = text.replace("{ smooth  calm weight 0.01 }", &format!("{{ {last} }}"));
    let text = text.replace("  joint_acceleration_limits }", " }");
    let program = common::program_of(&text);
    let mut controller = Controller::for_stack(&program, 0).expect("it can be executed");
    let mut q = program.robot.home.clone();
    let mut before = DVector::zeros(program.robot.model.nv());
    let mut found = Vec::new();
    for tick in 0..600 {
        let time = tick as f64 * program.robot.period;
        let command = controller.step(&Observation { time, q: &q });
        assert!(command.fault.is_none(), "at {time} s: {:?}", command.fault);
        let after = DVector::from_column_slice(command.velocity);
        found.push(Step { jacobian: jacobian(&program, &q), before: before.clone(), after: after.clone() });
        program.robot.model.integrate(&mut q, after.as_slice(), program.robot.period);
        before = after;
    }
    found
}

/// Part of a velocity that does not move the tool.
fn hidden(step: &Step, v: &DVector<f64>) -> DVector<f64> {
    let inverse = step.jacobian.clone().pseudo_inverse(1e-9).expect("a posture with full rank");
    v - inverse * (&step.jacobian * v)
}

#[test]
fn the_freedom_that_is_left_keeps_its_velocity_or_stands() {
    let steps = steps("smooth");
    let most = steps.iter().map(|s| hidden(s, &(&s.after - &s.before)).norm()).fold(0.0, f64::max);
    assert!(most < 1e-6, "{most}");
    let drift = steps.iter().map(|s| hidden(s, &s.after).norm()).fold(0.0, f64::max);
    assert!(drift > 0.01, "nothing moves by itself: {drift}");
    let calm = self::steps("calm");
    let most = calm.iter().map(|s| hidden(s, &s.after).norm()).fold(0.0, f64::max);
    assert!(most < 1e-6, "{most}");
}

#[test]
fn two_wishes_of_one_level_are_weighted() {
    // The least of |v - v_last|² + w |v|² over what is left is v_last / (1 + w).
    let steps = steps("smooth  calm weight 0.5");
    let off = |s: &Step| hidden(s, &(&s.after - &s.before / 1.5)).norm();
    assert!(steps.iter().map(off).fold(0.0, f64::max) < 1e-6);
}

#[test]
fn joints_may_be_named() {
    // Of all velocities that move the tool alike, the one with the least speed of two joints: they stand.
    let steps = steps("least_motion(velocity) { joints [joint_1, joint_3] }");
    let most = steps.iter().map(|s| s.after[0].abs().max(s.after[2].abs())).fold(0.0, f64::max);
    assert!(most < 1e-6, "{most}");
}
