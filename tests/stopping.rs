//! Bounds of the time and of the way to rest, against robots that are stopped at full speed and integrated here.

use crate::common;

use std::collections::VecDeque;

use common::cli::{hierarq, text};
use robot::Data;
use runtime::program::CompiledFile;
use runtime::stopping::{Stopping, of_stack, of_stacks};
use runtime::{Controller, Observation, Program};
use serde_json::Value;

/// Step of the plants (s).
const STEP: f64 = 5e-4;

/// An arm that turns joints at full speed.
fn arm(settings: &str, limits: &str, velocity: &str, rest: &str) -> [Program; 2] {
    let text = format!(
        "hierarq 1
         robot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  {settings}  arms {{ right {{ tip tool }} }}  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
         task spin = joint_velocity {{ velocity {velocity} }}
         stack work {{ level limits hard {{ joint_position_limits  {limits} }}  level motion {{ spin }} }}
         {rest}\n"
    );
    let (spec, _) = dsl::parse(dsl::SourceId(0), &text, dsl::Syntax::Native);
    let yaml = dsl::print(&spec, dsl::Syntax::Yaml);
    [common::program_of(&text), common::program_in(&yaml, dsl::Syntax::Yaml)]
}

fn bound(program: &Program) -> Stopping {
    of_stack(program, 0).expect("a stack that can be built")
}

/// A stop of a robot whose drives have the lag and the dead time that it declares.
struct Stop {
    /// Time until no joint has more than a hundredth of the speed that it had (s).
    time: f64,
    /// Way of each joint (rad).
    ways: Vec<f64>,
    /// Furthest that the tool was from its place when the robot was told to stop (m).
    tool: f64,
}

/// Runs for `calls` calls of a host with this interval (s), and then until the robot is at rest. `told` stops it; otherwise its machine does.
fn stop(program: &Program, interval: f64, calls: usize, told: bool) -> Stop {
    let robot = &program.robot;
    let (n, steps) = (robot.model.nv(), (interval / STEP).round() as usize);
    let tool = robot.model.link("tool").expect("the arm has a tool");
    let mut data = Data::new(&robot.model);
    let mut controller = Controller::new(program).expect("a compiled program can be executed");
    controller.called_every(Some(interval));
    let (mut q, mut v) = (robot.home.clone(), vec![0.0; n]);
    let mut queue: VecDeque<Vec<f64>> = vec![vec![0.0; n]; (robot.dead_time / STEP).round() as usize].into();
    let decay = if robot.lag > 0.0 { (-STEP / robot.lag).exp() } else { 0.0 };
    let (mut begin, mut found) = (None, Stop { time: 0.0, ways: vec![0.0; n], tool: 0.0 });
    for k in 0..calls + (3.0 / interval) as usize {
        let time = k as f64 * interval;
        if told && k == calls {
            controller.stop();
        }
        let command = controller.step(&Observation { time, q: &q });
        assert_eq!(command.fault, None, "at {time} s");
        let u = command.velocity.to_vec();
        let stops = if told { k == calls } else { begin.is_none() && controller.state() == "done" };
        if stops {
            robot.model.forward(&q, &mut data);
            begin = Some((q.clone(), v.clone(), *data.position(tool), time));
        }
        for step in 0..steps {
            queue.push_back(u.clone());
            let acts = queue.pop_front().unwrap_or_default();
            for i in 0..n {
                let before = v[i];
                v[i] = acts[i] + (before - acts[i]) * decay;
                q[i] += acts[i] * STEP + (before - acts[i]) * robot.lag * (1.0 - decay);
            }
            let Some((q_0, v_0, tool_0, t_0)) = &begin else { continue };
            robot.model.forward(&q, &mut data);
            found.tool = found.tool.max((data.position(tool) - tool_0).norm());
            found.ways.iter_mut().zip(&q).zip(q_0).for_each(|((way, q), q_0)| *way = way.max((q - q_0).abs()));
            if v.iter().zip(v_0).any(|(v, v_0)| v.abs() > 0.01 * v_0.abs()) {
                found.time = time + (step + 1) as f64 * STEP - t_0;
            }
        }
    }
    assert!(begin.is_some() && controller.is_at_rest());
    found
}

const LIMITS: &str = "joint_velocity_limits { max 1 rad/s }  joint_acceleration_limits { max 5 rad/s^2 }";
const RUN: &str = "run { stack work  duration 3 s }";

/// Drives, rates of the host and phases of the call for a stop; a joint at full speed.
#[test]
fn a_robot_at_full_speed_is_at_rest_within_the_bound_and_not_far_within_it() {
    for (settings, delay) in
        [("", 0.0), ("lag 60 ms", 0.06), ("dead_time 50 ms", 0.05), ("lag 0.1 s  dead_time 40 ms", 0.14)]
    {
        for program in arm(settings, LIMITS, "{ joint_1 1 rad/s }", RUN) {
            let bound = bound(&program);
            for (interval, calls) in [(0.01, 100), (0.002, 500), (0.002, 501), (0.002, 503), (0.001, 1007)] {
                let stop = stop(&program, interval, calls, true);
                let (joint, case) = (&bound.joints[0], format!("{settings}, {calls} calls"));
                assert!(
                    stop.time <= joint.time_s && joint.time_s <= 1.7 * stop.time,
                    "{case}: {} {joint:?}",
                    stop.time
                );
                assert!(
                    stop.ways[0] <= joint.way && joint.way <= 1.4 * stop.ways[0],
                    "{case}: {:?} {joint:?}",
                    stop.ways
                );
                assert!(stop.ways[0] >= 0.09 + delay, "{case}: {:?}", stop.ways);
                assert!(stop.tool <= bound.links[0].way_m, "{case}: {} m", stop.tool);
                assert!(stop.time <= bound.time_s);
            }
        }
    }
}

/// A state without a stack brings the robot to rest too.
#[test]
fn a_final_state_is_a_stop() {
    let machine = "machine m { initial go  on fault(any) -> stopped  state go { stack work  after 1 s -> done }  final state done  final state stopped }";
    for program in arm("lag 30 ms", LIMITS, "{ joint_1 -1 rad/s }", machine) {
        let (bound, stop) = (bound(&program), stop(&program, 0.005, 0, false));
        let joint = &bound.joints[0];
        assert!(stop.time <= joint.time_s && joint.time_s <= 3.0 * stop.time, "{} {joint:?}", stop.time);
        assert!(stop.ways[0] <= joint.way && joint.way <= 3.0 * stop.ways[0], "{:?} {joint:?}", stop.ways);
        assert_eq!(bound.states, ["go"]);
    }
}

/// All joints at their full speeds: the bound of the tool counts all of them.
#[test]
fn the_tool_stays_within_its_way() {
    for program in arm("", LIMITS, "1 rad/s", RUN) {
        let (bound, stop) = (bound(&program), stop(&program, 0.01, 40, true));
        for (joint, way) in bound.joints.iter().zip(&stop.ways) {
            assert!(*way <= joint.way, "{way} {joint:?}");
        }
        assert_eq!(bound.links.len(), 1);
        let (tool, most) = (stop.tool, bound.links[0].way_m);
        assert!(tool <= most && most <= 12.0 * tool, "{tool} m of {most} m");
    }
}

/// Speeds and decelerations that count: hard limits of the stack, then those of the URDF.
#[test]
fn the_limits_of_the_stack_count_then_those_of_the_robot() {
    let joint = |limits: &str, settings: &str| {
        let [program, yaml] = arm(settings, limits, "{ joint_1 1 rad/s }", RUN);
        assert_eq!(bound(&program), bound(&yaml));
        bound(&program).joints.swap_remove(0)
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} and {b}");
    let own = joint(LIMITS, "");
    near(own.time_s, 0.01 + 0.2 + 0.01);
    near(own.way, 0.01 + 0.5 * (0.2 + 0.01));
    // Nothing limits the acceleration: two periods.
    let free = joint("joint_velocity_limits { max 1 rad/s }", "");
    assert_eq!(free.deceleration, f64::INFINITY);
    near(free.time_s, 0.02);
    near(free.way, 0.015);
    // A host that stops the robot itself.
    near(joint(LIMITS, "stop now").time_s, 0.02);
    let robot = joint("", "limits { joint_1 { velocity 2 rad/s } }");
    assert_eq!(robot.speed, 2.0);
    let locked = "stack work2 { lock [joint_1]  level limits hard { joint_velocity_limits } }";
    let [program, _] = arm("", LIMITS, "{ joint_1 1 rad/s }", &format!("{RUN} {locked}"));
    let names: Vec<String> = of_stack(&program, 1).expect("a stack").joints.into_iter().map(|j| j.joint).collect();
    assert!(!names.contains(&"joint_1".to_string()), "{names:?}");
}

#[test]
fn a_base_without_a_limit_has_no_bound() {
    let program = common::program_of(
        "hierarq 1
         robot cart { urdf \"robots/arm7.urdf\"  rate 100 Hz  base planar  home { joint_4 1.6 rad } }
         stack s { level limits hard { joint_position_limits  joint_acceleration_limits { max { base_x 1 m/s^2 } } } level m { hold(tool) } }\n",
    );
    assert!(!bound(&program).time_s.is_finite() && !bound(&program).links[0].way_m.is_finite());
    let text = runtime::text::text(&program).expect("a program");
    assert!(text.contains("to rest from full speed: time no bound, ways"), "{text}");
}

/// `compile` in both formats, and `check`.
#[test]
fn the_command_line_shows_it() {
    let out = text(&hierarq(&["compile", "examples/on_ros.hq"]).stdout);
    assert!(out.contains("  to rest from full speed: time 0.12 s, ways"), "{out}");
    let out = text(&hierarq(&["compile", "--format", "json", "examples/on_ros.hq"]).stdout);
    let program = CompiledFile::read(&out).expect("a compiled program").program.expect("a robot");
    let written: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(written["stopping"], serde_json::to_value(of_stacks(&program)).expect("JSON"));
    assert_eq!(written["stopping"][1]["states"], serde_json::json!(["go"]));
    let out = text(&hierarq(&["check", "--json", "examples/on_ros.hq"]).stdout);
    let report: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(report["stopping"], written["stopping"]);
}
