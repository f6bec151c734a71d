//! Trajectories in the loop: they begin at the robot's position and velocity, keep their limits, end before a task
//! counts as reached, and cause a fault if a limit becomes invalid.

use crate::common;

use nalgebra::Vector3;
use robot::Data;
use runtime::program::{Op, Program};
use runtime::{Controller, Fault, FaultKind, Observation};

const ARM: &str = "hierarq 1\nrobot arm { urdf \"robots/arm7.urdf\"  rate 500 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }\n";

const LIMITS: &str = "level limits hard { joint_velocity_limits }";

/// Returns the position of the tool and the state of the machine at each tick, until the end of the run or a fault.
fn ways(program: &Program) -> (Vec<(Vector3<f64>, String)>, Option<Fault>) {
    let model = &program.robot.model;
    let tool = model.link("tool").expect("a tool");
    let mut controller = Controller::new(program).expect("it can be executed");
    let (mut q, mut data, period) = (program.robot.home.clone(), Data::new(model), program.robot.period);
    let mut way = Vec::new();
    for k in 0..(program.run.duration / period).round() as usize {
        let command = controller.step(&Observation { time: k as f64 * period, q: &q });
        if let Some(fault) = command.fault {
            return (way, Some(fault));
        }
        let velocity = command.velocity.to_vec();
        model.forward(&q, &mut data);
        way.push((data.pose(tool).translation.vector, controller.state().to_string()));
        model.integrate(&mut q, &velocity, period);
    }
    (way, None)
}

fn velocities(way: &[(Vector3<f64>, String)], period: f64) -> Vec<Vector3<f64>> {
    way.windows(2).map(|w| (w[1].0 - w[0].0) / period).collect()
}

/// From rest the tool keeps the limits and takes the time of the trapezoid, and the task is reached only then.
#[test]
fn a_task_is_reached_when_its_trajectory_has_ended() {
    let text = format!(
        "{ARM}task go = frame_position(tool) {{
           position trapezoid(initial(position) + [0.1, 0.1, 0.05] m, speed: 0.2 m/s, acceleration: 0.5 m/s^2)  gain 20 /s
         }}
         stack s {{ {LIMITS}  level motion {{ go }} }}
         machine m {{ initial a  blend 0 s  on fault(any) -> b  state a {{ stack s  on reached(go, 20 cm) -> b }}  final state b {{ stack s }} }}
         run {{ machine m  duration 2 s }}"
    );
    let program = common::program_of(&text);
    let (way, fault) = ways(&program);
    assert_eq!(fault, None);
    let h = Vector3::new(0.1_f64, 0.1, 0.05).norm();
    let duration = h / 0.2 + 0.2 / 0.5;
    // The tolerance is larger than the whole path: the trajectory alone decides.
    let reached = way.iter().position(|w| w.1 == "b").expect("it is reached") as f64 * 0.002;
    assert!((reached - duration).abs() < 0.02, "{reached} instead of {duration}");
    let v = velocities(&way, 0.002);
    let fastest = v.iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!((0.19..0.201).contains(&fastest), "{fastest} m/s");
    let until = (reached / 0.002) as usize - 2;
    let hardest = v[..until].windows(2).map(|w| (w[1] - w[0]).norm() / 0.002).fold(0.0, f64::max);
    assert!(hardest < 0.55, "{hardest} m/s^2");
}

/// A stack that is entered in motion continues the motion without a jump.
#[test]
fn what_moves_when_a_stack_is_entered_moves_on() {
    for (goal, kind) in [("[0.0, 0.15, 0.0] m", "trapezoid"), ("[0.1, 0.1, 0.0] m", "waypoints")] {
        let text = format!(
            "{ARM}task drift = frame_position(tool) {{ position initial(position) + [0.0, 0.08, 0.06] m/s * t * smoothstep(t/(0.3 s))  gain 20 /s }}
             task go = frame_position(tool) {{ position {kind}(initial(position) + {goal}, speed: 0.2 m/s, acceleration: 0.5 m/s^2)  gain 20 /s }}
             stack first {{ {LIMITS}  level motion {{ drift }} }}
             stack second {{ {LIMITS}  level motion {{ go }} }}
             machine m {{ initial a  blend 0 s  on fault(any) -> b  state a {{ stack first  after 0.5 s -> b }}  state b {{ stack second  after 3 s -> c }}  final state c }}
             run {{ machine m  duration 3 s }}"
        );
        let (way, fault) = ways(&common::program_of(&text));
        assert_eq!(fault, None);
        let v = velocities(&way, 0.002);
        let at = way.iter().position(|w| w.1 == "b").expect("it is entered");
        assert!(v[at - 1].norm() > 0.09, "it moves: {}", v[at - 1].norm());
        // The maximum that the limit permits within a tick, plus the integration error.
        for w in v[at - 2..].windows(2) {
            assert!((w[1] - w[0]).norm() < 0.5 * 0.002 * 1.3 + 2e-4, "{kind}: {} m/s", (w[1] - w[0]).norm());
        }
        assert!(v.last().is_some_and(|v| v.norm() < 1e-4), "it comes to rest");
    }
}

#[test]
fn a_limit_that_is_none_any_more_is_a_fault() {
    for (speed, at) in [("0.2 m/s * (1 - t/(0.5 s))", 0.5), ("0.1 m/s / (0.6 - t/(1 s))", 0.6)] {
        let text = format!(
            "{ARM}task go = frame_position(tool) {{ position trapezoid(initial(position) + [0.3, 0, 0] m, speed: {speed}, acceleration: 0.5 m/s^2) }}
             stack s {{ level motion {{ go }} }}
             run {{ stack s  duration 2 s }}"
        );
        let (way, fault) = ways(&common::program_of(&text));
        assert_eq!(fault.map(|f| f.kind()), Some(FaultKind::Value));
        assert!((way.len() as f64 * 0.002 - at).abs() < 0.01, "{}", way.len());
    }
}

/// Values that no compiler writes, but a person may.
#[test]
fn absurd_trajectories_are_refused() {
    let good = common::program("trajectories.hq");
    good.check().expect("it is good");
    let json = serde_json::to_string(&good).expect("it can be written");
    assert_eq!(serde_json::from_str::<Program>(&json).expect("it can be read"), good);
    let refused = |spoil: &dyn Fn(&mut Program)| {
        let mut program = good.clone();
        spoil(&mut program);
        assert!(program.check().is_err() && Controller::new(&program).is_err());
    };
    refused(&|p| p.values.tape.trajectories[0].at = usize::MAX);
    refused(&|p| p.values.tape.trajectories[1].at += 1);
    refused(&|p| p.values.tape.trajectories[0].goals.clear());
    refused(&|p| p.values.tape.trajectories[0].limits.truncate(1));
    refused(&|p| p.values.tape.trajectories[0].start[0] = usize::MAX);
    refused(&|p| p.values.tape.trajectories[0].velocity = vec![0]);
    refused(&|p| p.values.tape.trajectories[0].goals = vec![0; 3 * 65]);
    refused(&|p| p.values.tape.ops[0] = Op::Trajectory(0));
    refused(&|p| p.values.tape.ops.push(Op::Trajectory(1_000_000)));
    let last = good.values.tape.ops.len() - 1;
    refused(&|p| p.values.tape.trajectories[0].start[0] = last);
}
