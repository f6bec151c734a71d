//! Stacks of several regions, which run together.

use runtime::{Controller, Observation, Program, SimulatedRobot};

use crate::common::program_of;

/// Two arms side by side, and a stack that limits both. Levels are exact: one that is damped where it cannot be met slows down
/// the tasks of both arms in it.
const ARMS: &str = "hierarq 1
robot l { urdf \"robots/arm7.urdf\"  at [0, 0.5, 0] m  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
robot r { urdf \"robots/arm7.urdf\"  at [0, -0.5, 0] m  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
signal go : event
signal push : point
stack limits { level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits } }
task wave_l = joint_position { target { l_joint_1 0.3 rad * sin(2*pi*t/(1 s)) }  gain 10 /s }
task up_l = frame_position(l_tool) { position initial(position) + [0, 0, 0.1] m * smoothstep(t/(0.5 s))  gain 10 /s }
task keep_l = hold(l_tool)
task wave_r = joint_position { target { r_joint_1 0.2 rad * sin(2*pi*t/(1.5 s)) }  gain 10 /s }
task far_r = frame_position(r_tool) { position trapezoid(initial(position) + [0.1, -0.1, 0] m, speed: 0.2 m/s, acceleration: 0.5 m/s^2)  gain 10 /s }
task keep_r = hold(r_tool)
task soft_r = admittance(r_tool) {
  target { position initial(position)  orientation initial(orientation) }
  mass { linear 5 kg  angular 0.5 kg m^2 }  damping { linear 60 N s/m  angular 6 N m s/rad }
  stiffness { linear 100 N/m  angular 10 N m/rad }
  wrench { force if(present(push), 20 N/m * push, [0, 0, 0] N) } }
stack wave_left from limits { add motion damping none { wave_l } }
stack up_left from limits { add motion damping none { up_l } }
stack keep_left from limits { add motion damping none { keep_l } }
stack wave_right from limits { add motion damping none { wave_r } }
stack far_right from limits { add motion damping none { far_r } }
stack keep_right from limits { add motion damping none { keep_r } }
stack soft_right from limits { add motion damping none { soft_r } }
";

/// A machine with regions, each given by its states; the others add nothing.
fn machine(blend: &str, left: &str, right: &str) -> Program {
    program_of(&format!(
        "{ARMS}machine m {{ initial w  blend {blend}  on fault(any) -> end
           state w {{ region l {{ {left} }}  region r {{ {right} }} }}
           final state end {{ stack limits }} }}"
    ))
}

/// Velocity and state at a tick.
#[derive(Debug, PartialEq)]
struct Moment(Vec<f64>, String);

/// Velocities and states of a run; `go` is raised at some ticks.
fn run(program: &Program, ticks: usize, go: &[usize]) -> Vec<Moment> {
    let mut controller = Controller::new(program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(program);
    (0..ticks)
        .map(|tick| {
            let time = tick as f64 * program.robot.period;
            if go.contains(&tick) {
                controller.signals().raise(0);
            }
            if tick >= 60 {
                let push = controller.signals().interface().signal("push").expect("a signal");
                assert!(controller.signals().set(push, &[0.0, 0.5, 0.0], time));
            }
            let q = robot.measure().to_vec();
            let command = controller.step(&Observation { time, q: &q });
            assert_eq!(command.fault, None, "tick {tick}: {:?}", command.fault.map(|f| controller.describe(&f)));
            let velocity = command.velocity.to_vec();
            robot.apply(&velocity);
            Moment(controller.velocity().to_vec(), controller.state().to_string())
        })
        .collect()
}

const LEFT: &str = "initial a
  state a { stack wave_left  after 0.37 s -> b }
  state b { stack up_left  after 0.61 s -> c  on go -> a }
  state c { stack keep_left  after 0.23 s -> d }
  state d { after 0.31 s -> a }";

const RIGHT: &str = "initial a
  state a { stack wave_right  after 0.53 s -> b }
  state b { stack far_right  on reached(far_r, 3 mm) -> c  after 3 s -> end }
  state c { stack keep_right  after 0.17 s -> d  on go -> d }
  state d { stack soft_right  after 0.8 s -> e }
  state e { after 0.2 s -> a }";

const REST: &str = "initial a  state a { stack limits }";

/// The largest difference of two runs among some joints.
fn difference(a: &[Moment], b: &[Moment], joints: std::ops::Range<usize>) -> f64 {
    let of = |(a, b): (&Moment, &Moment)| joints.clone().map(|j| (a.0[j] - b.0[j]).abs()).fold(0.0, f64::max);
    a.iter().zip(b).map(of).fold(0.0, f64::max)
}

#[test]
fn two_arms_move_as_each_does_alone() {
    let go = [55, 120, 121, 260, 333, 334, 400];
    let together = run(&machine("0 s", LEFT, RIGHT), 700, &go);
    let left = run(&machine("0 s", LEFT, REST), 700, &go);
    let right = run(&machine("0 s", REST, RIGHT), 700, &go);
    for (tick, ((t, l), r)) in together.iter().zip(&left).zip(&right).enumerate() {
        let own = |state: &str, k: usize| state.split(" | ").nth(k).expect("two regions").to_string();
        assert_eq!(t.1, format!("{} | {}", own(&l.1, 0), own(&r.1, 1)), "tick {tick}");
    }
    assert!(difference(&together, &left, 0..7) < 1e-7, "{}", difference(&together, &left, 0..7));
    assert!(difference(&together, &right, 7..14) < 1e-7, "{}", difference(&together, &right, 7..14));
    let states: std::collections::BTreeSet<&String> = together.iter().map(|t| &t.1).collect();
    assert!(states.len() >= 12, "{states:?}");
    let moves = |k: usize| together.iter().filter(|t| t.0[k].abs() > 0.05).count();
    assert!(moves(0) > 50 && moves(7) > 50, "both arms move");
}

#[test]
fn a_blend_of_one_region_hardly_disturbs_the_other() {
    let still = machine("0.2 s", REST, "initial a  state a { stack wave_right }");
    let busy = machine("0.2 s", LEFT, "initial a  state a { stack wave_right }");
    let (still, busy) = (run(&still, 500, &[]), run(&busy, 500, &[]));
    let most = difference(&still, &busy, 7..14);
    // What is blended is at most what the wave changes in a period: 0.2 rad (2 pi / 1.5 s)^2 10 ms.
    assert!(most < 0.04, "{most}");
    let joints = |run: &[Moment]| run.iter().map(|t| 0.01 * t.0[7]).sum::<f64>();
    assert!((joints(&still) - joints(&busy)).abs() < 2e-3, "{} {}", joints(&still), joints(&busy));
}

#[test]
fn what_both_limit_is_limited_once() {
    let program = machine("0 s", LEFT, RIGHT);
    let merged: Vec<_> = program.stacks.iter().filter(|s| !s.parts.is_empty()).collect();
    // Three stacks on the left, four on the right.
    assert_eq!(merged.len(), 12);
    for stack in merged {
        let names: Vec<&str> = stack.levels.iter().map(|l| l.name.as_str()).collect();
        assert_eq!(names, ["limits", "motion"], "{}", stack.name);
        assert_eq!(stack.levels.iter().map(|l| l.members.len()).collect::<Vec<_>>(), [3, 2]);
        assert_eq!(stack.levels[0].members[0].parts, [0, 1]);
        assert_eq!(
            (&stack.levels[1].members[0].parts[..], &stack.levels[1].members[1].parts[..]),
            (&[0][..], &[1][..])
        );
    }
}

#[test]
fn a_program_with_regions_survives_a_file() {
    let program = machine("0.1 s", LEFT, RIGHT);
    let read: Program =
        serde_json::from_str(&serde_json::to_string(&program).expect("it can be written")).expect("JSON");
    assert_eq!(read, program);
    let (a, b) = (run(&program, 300, &[55]), run(&read, 300, &[55]));
    assert!(a == b);
}
