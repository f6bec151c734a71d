//! Limits of a vector with open sides move a robot as limits of its numbers do that leave these sides out.

use runtime::{Controller, Observation};

use crate::common;

/// Configurations of a run in which the tool is drawn along a large circle, within these limits.
fn run(limits: &str) -> Vec<Vec<f64>> {
    let fence = if limits.is_empty() { String::new() } else { format!("level fence hard {{ {limits} }}") };
    let text = format!(
        "hierarq 1\nrobot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  home {{ all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }} }}\n\
         stack s {{\n  level limits hard {{ joint_velocity_limits }}\n  {fence}\n\
         level motion {{ frame_position(tool) {{ position initial(position) + [0.3*sin(t/(1 s)), 0.3*cos(t/(1 s)) - 0.3, 0.2*sin(2*t/(1 s))] m }} }}\n\
         level rest {{ joint_velocity {{ velocity 0 rad/s }} }}\n}}\n"
    );
    let program = common::program_of(&text);
    let mut controller = Controller::for_stack(&program, 0).expect("it can be executed");
    let mut q = program.robot.home.clone();
    let mut all = Vec::new();
    for tick in 0..700 {
        let time = f64::from(tick) * program.robot.period;
        let command = controller.step(&Observation { time, q: &q });
        assert!(command.fault.is_none(), "{limits} at {time} s: {:?}", command.fault);
        let velocity = command.velocity.to_vec();
        program.robot.model.integrate(&mut q, &velocity, program.robot.period);
        all.push(q.clone());
    }
    all
}

#[test]
fn each_side_may_be_open_on_its_own() {
    let free = run("");
    for (vector, numbers) in [
        // One number without a limit, one with a limit on one side only, one with both.
        (
            "keep(frame(tool).position) { min [none, none, 0.25 m]  max [0.65 m, none, 0.45 m] }",
            "keep(frame(tool).position.x) { max 0.65 m }  keep(frame(tool).position.z) { min 0.25 m  max 0.45 m }",
        ),
        ("keep(frame(tool).position) { min [none, -0.15 m, none] }", "keep(frame(tool).position.y) { min -0.15 m }"),
        (
            "keep(frame(tool).position) { min [0.4 m, none, none]  max [none, 0.1 m, none]  sampled_margin auto }",
            "keep(frame(tool).position.x) { min 0.4 m  sampled_margin auto }
             keep(frame(tool).position.y) { max 0.1 m  sampled_margin auto }",
        ),
    ] {
        let (one, other) = (run(vector), run(numbers));
        for (tick, (a, b)) in one.iter().zip(&other).enumerate() {
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9, "{vector}: {apart} at tick {tick}");
        }
        let moved = one.iter().zip(&free).flat_map(|(a, b)| a.iter().zip(b)).any(|(a, b)| (a - b).abs() > 1e-3);
        assert!(moved, "{vector} limits nothing");
    }
}
