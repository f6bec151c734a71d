//! Angles on the circle, in the closed loop: encoders that wrap, targets by the nearest turn, `atan2` across its seam, filters,
//! and palms that face each other. Each spec is run in both syntaxes.

use std::f64::consts::{PI, TAU};

use crate::common;

use common::compile_both;
use hierarq_compiler::{Compiled, Style};
use runtime::expect::Verdict;
use runtime::program::{Program, ScenarioProgram};
use runtime::record::All;
use runtime::{Controller, ExpectationMonitors, Observation, Simulation};

/// A turntable that turns for ever, on a base that `more` describes.
fn turntable(more: &str) -> String {
    let urdf = "<robot name='rig'><link name='base'/><link name='table'/><link name='lid'/>\
        <joint name='spindle' type='continuous'><parent link='base'/><child link='table'/><origin xyz='0 0 0.3'/>\
        <axis xyz='0 0 1'/><limit velocity='2' effort='1'/></joint>\
        <joint name='hinge' type='revolute'><parent link='table'/><child link='lid'/><origin xyz='0.1 0 0'/>\
        <axis xyz='0 0 1'/><limit lower='-10' upper='10' velocity='2' effort='1'/></joint></robot>";
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("turntable_{}.urdf", std::process::id()));
    let part = path.with_extension(format!("{:?}", std::thread::current().id()));
    std::fs::write(&part, urdf).expect("writable");
    std::fs::rename(&part, &path).expect("writable");
    format!("hierarq 1\nrobot rig {{ urdf \"{}\"  rate 100 Hz  {more} }}\n", path.display())
}

const LIMITS: &str = "level limits hard { joint_velocity_limits  joint_acceleration_limits { max 20 rad/s^2 } }";

/// A level that holds the hinge, beside a task that moves the spindle alone.
fn rest(task: &str) -> &'static str {
    if task.starts_with("track") { "  level rest { joint_velocity { velocity { hinge 0 rad/s } } }" } else { "" }
}

fn good(compiled: Compiled) -> Program {
    let report = compiled.report.render(Style::Plain, 100);
    // Other warnings, of limits that these short specs leave out, are no concern here.
    let told = compiled.report.diagnostics.iter().any(|d| ["HQ0528", "HQ0536"].contains(&d.code));
    assert!(!told, "{report}");
    compiled.program.unwrap_or_else(|| panic!("{report}"))
}

fn verdicts(program: &Program, scenario: &ScenarioProgram) -> Vec<(String, Verdict)> {
    let program = scenario.program(program);
    let mut simulation = Simulation::in_world(&program, scenario).expect("it can be executed");
    let mut monitors = ExpectationMonitors::new(&program, scenario, simulation.ticks()).expect("it can be judged");
    simulation.run(&mut All(vec![&mut monitors]), &mut || 0.0, &mut |_| true).expect("memory does not fail");
    let outcomes = monitors.finish();
    scenario.expectations.iter().zip(outcomes).map(|(e, o)| (e.title().to_string(), o.verdict)).collect()
}

/// Checks that all expectations of all scenarios hold, in both syntaxes.
fn holds(text: &str) {
    for compiled in compile_both(text) {
        let program = good(compiled);
        for scenario in &program.scenarios {
            for (title, verdict) in verdicts(&program, scenario) {
                assert_eq!(verdict, Verdict::Holds, "{}: {title}", scenario.name);
            }
        }
    }
}

/// Warnings of a spec, the same in both syntaxes.
fn codes(text: &str) -> Vec<&'static str> {
    let [hq, yaml] = compile_both(text).map(|c| {
        assert!(c.program.is_some(), "{}", c.report.render(Style::Plain, 100));
        let mut all: Vec<&str> = c.report.diagnostics.iter().map(|d| d.code).collect();
        // The order is that of the text.
        all.sort_unstable();
        all
    });
    assert_eq!(hq, yaml);
    hq
}

/// Drives the turntable with encoders that report the angle in `[low, low + one turn)`. Returns the total angle of the robot,
/// and the state at each tick.
fn with_encoders(program: &Program, low: f64, ticks: usize) -> (f64, Vec<String>) {
    let mut controller = Controller::new(program).expect("it can be executed");
    let (mut q, mut states) = (program.robot.home.clone(), Vec::new());
    for k in 0..ticks {
        let mut seen = q.clone();
        seen[0] = (q[0] - low).rem_euclid(TAU) + low;
        let command = controller.step(&Observation { time: k as f64 * 0.01, q: &seen });
        assert_eq!(command.fault, None, "at tick {k}, measured {}", seen[0]);
        let velocity = command.velocity.to_vec();
        states.push(controller.state().to_string());
        program.robot.model.integrate(&mut q, &velocity, 0.01);
    }
    (q[0], states)
}

#[test]
fn encoders_may_wrap() {
    for sign in [1.0, -1.0] {
        let text = format!(
            "{}task turn = joint_velocity {{ velocity {{ spindle {sign} rad/s  hinge 0 rad/s }} }}
            stack s {{ {LIMITS}  level motion {{ turn }} }}
            machine m {{
              initial turning
              blend 0.2 s
              on fault(any) -> stopped
              state turning {{ stack s  when abs(joint(spindle)) > 720 deg -> done }}
              state done {{ stack s  after 100 s -> stopped }}
              final state stopped
            }}
            run {{ machine m  duration 15 s }}",
            turntable("tracking_gain 5 /s  home { spindle 3 rad }")
        );
        for compiled in compile_both(&text) {
            let program = good(compiled);
            for low in [-PI, 0.0, -TAU] {
                // What is measured first is taken as it is; from there on `joint(J)` counts turns.
                let first = (3.0_f64 - low).rem_euclid(TAU) + low;
                let (total, states) = with_encoders(&program, low, 1700);
                assert!((total - 3.0 - sign * 17.0).abs() < 0.2, "{total}");
                let way = if sign > 0.0 { 4.0 * PI - first } else { 4.0 * PI + first };
                let done = states.iter().position(|s| s == "done").expect("720 degrees are passed") as f64 * 0.01;
                assert!((done - way).abs() < 0.2, "{done} s and not {way}");
            }
        }
    }
}

#[test]
fn a_joint_without_limits_takes_the_nearest_turn() {
    let joint = |target: &str, more: &str| {
        format!("joint_position {{ target {{ spindle {target}  hinge 0 deg }}  gain 4 /s  {more} }}")
    };
    let trapezoid = "trapezoid(-175 deg, from: joint(spindle), speed: 1 rad/s, acceleration: 4 rad/s^2)";
    let s_curve = "0.5 deg + s_curve(-175.5 deg, from: joint(spindle), speed: 1 rad/s, acceleration: 4 rad/s^2, jerk: 40 rad/s^3)";
    for task in [
        joint("-175 deg", ""),
        joint("545 deg", "turns nearest"),
        joint(trapezoid, ""),
        joint(s_curve, ""),
        "track(joint(spindle)) { target -175 deg  gain 4 /s }".to_string(),
        "track(joint(spindle) + joint(hinge)) { target 905 deg  gain 4 /s }".to_string(),
        "track(joint(spindle)) { target trapezoid(-175 deg, speed: 1 rad/s, acceleration: 4 rad/s^2)  gain 4 /s }"
            .to_string(),
    ] {
        let rest = rest(&task);
        holds(&format!(
            "{}task go = {task}
            stack s {{ {LIMITS}  level motion {{ go }}{rest} }}
            machine m {{
              initial a
              blend 0.1 s
              on fault(any) -> stopped
              state a {{ stack s  on reached(go, 0.1 deg) -> b }}
              state b {{ stack s  after 100 s -> stopped }}
              final state stopped
            }}
            run {{ machine m  duration 5 s }}
            scenario near {{
              machine m
              expect \"the near way\" always joint(spindle) > 174 deg and joint(spindle) < 186 deg
              expect \"arrives\" from 4 s : always abs(joint(spindle) + joint(hinge) - 185 deg) < 0.1 deg
              expect \"without an error\" from 4 s : always (in(b) implies error(go) < 0.1 deg)
              expect \"is reached\" eventually in(b)
            }}",
            turntable("home { spindle 175 deg }")
        ));
    }
    // As a number of turns: three turns further, or the far way.
    for (task, end) in [
        (joint("1255 deg", "turns exact"), 1255),
        (joint("-175 deg", "turns exact"), -175),
        ("track(joint(spindle)) { target -175 deg  gain 4 /s  turns exact }".to_string(), -175),
        // A joint with limits is not on the circle.
        ("joint_position { target { spindle 175 deg  hinge 400 deg }  gain 4 /s }".to_string(), 175),
    ] {
        let rest = rest(&task);
        holds(&format!(
            "{}task go = {task}
            stack s {{ {LIMITS}  level motion {{ go }}{rest} }}
            run {{ stack s  duration 14 s }}
            scenario far {{ stack s  expect \"arrives\" from 13 s : always abs(joint(spindle) - ({end} deg)) < 0.1 deg and error(go) < 0.1 deg }}",
            turntable("home { spindle 175 deg }")
        ));
    }
}

#[test]
fn a_goal_that_wraps_is_followed_the_near_way() {
    let text = format!(
        "{}signal heading : angle {{ timeout 1 s }}
        task go = joint_position {{ target {{ spindle trapezoid(heading, from: joint(spindle), speed: 1 rad/s, acceleration: 4 rad/s^2)  hinge 0 deg }}  gain 10 /s }}
        stack s {{ {LIMITS}  level motion {{ go }} }}
        run {{ stack s  duration 8 s }}
        scenario round {{
          stack s
          signals {{ heading [{{ value 100 deg  from 0 s  to 2 s }}, {{ value -130 deg  from 2 s  to 5 s }}, {{ value 10 deg  from 5 s  to 8 s }}] }}
          expect \"never back\" always joint(spindle) > 99 deg
          expect \"one turn\" from 7.8 s : always abs(joint(spindle) - 370 deg) < 0.5 deg
        }}",
        turntable("home { spindle 100 deg }")
    );
    holds(&text);
}

#[test]
fn a_heading_crosses_its_seam() {
    for target in ["goal", "trapezoid(goal, speed: 0.5 rad/s, acceleration: 2 rad/s^2)"] {
        let heading = "atan2(dot(frame(base).orientation*[1, 0, 0], [0, 1, 0]), dot(frame(base).orientation*[1, 0, 0], [1, 0, 0]))";
        for value in [heading.to_string(), format!("joint(hinge) - -1*{heading}")] {
            holds(&format!(
                "{}signal goal : angle {{ timeout 0.5 s }}
                task heading = track({value}) {{ target {target}  gain 3 /s }}
                stack s {{ level limits hard {{ joint_velocity_limits  joint_acceleration_limits }}  level motion {{ heading }}  level rest {{ joint_velocity {{ velocity {{ spindle 0 rad/s  hinge 0 rad/s }} }} }} }}
                run {{ stack s  duration 9 s }}
                scenario turns {{
                  stack s
                  signals {{ goal [{{ value 170 deg  from 0 s  to 2 s }}, {{ value 190 deg  from 2 s  to 5 s }}, {{ value 160 deg  from 5 s  to 9 s }}] }}
                  expect \"never the far way\" always dot(frame(base).orientation*[1, 0, 0], [1, 0, 0]) < -0.9
                  expect \"over the seam\" from 4.5 s to 4.9 s : always error(heading) < 0.5 deg
                  expect \"and back\" from 8 s : always error(heading) < 0.5 deg
                }}",
                turntable("base planar  home { base_yaw 170 deg }  limits { base_x { velocity 1 m/s }  base_y { velocity 1 m/s }  base_yaw { velocity 1 rad/s } }")
            ));
        }
    }
}

#[test]
fn a_filter_of_angles_goes_the_near_way() {
    holds(&format!(
        "{}signal yaw : angle {{ timeout 0.5 s  low_pass 1 Hz }}
        stack s {{ {LIMITS}  level motion {{ frame_orientation(table) {{ orientation rpy(0, 0, yaw)  gain 20 /s }} }} }}
        run {{ stack s  duration 4 s }}
        scenario wrap {{
          stack s
          signals {{ yaw [{{ value 179 deg  from 0 s  to 1 s }}, {{ value -171 deg  from 1 s  to 4 s }}] }}
          expect \"never back\" always joint(spindle) > 178.9 deg and joint(spindle) < 189.1 deg
          expect \"filtered\" from 1.05 s to 1.1 s : always joint(spindle) < 186 deg
          expect \"arrives\" from 3 s : always joint(spindle) > 188.9 deg
        }}",
        turntable("home { spindle 179 deg }")
    ));
}

#[test]
fn an_angle_that_jumps_is_told() {
    let of = |task: &str| {
        codes(&format!(
            "{}task bearing = {task}
            stack s {{ {LIMITS}  level a {{ bearing }} }}
            run {{ stack s  duration 1 s }}",
            turntable(
                "base planar  limits { base_x { velocity 1 m/s }  base_y { velocity 1 m/s }  base_yaw { velocity 1 rad/s } }"
            )
        ))
    };
    let heading =
        "atan2(dot(frame(base).orientation*[1, 0, 0], [0, 1, 0]), dot(frame(base).orientation*[1, 0, 0], [1, 0, 0]))";
    let told = |task: &str| of(task).contains(&"HQ0528");
    assert!(told(&format!("keep({heading}) {{ max 120 deg  gain 2 /s }}")));
    assert!(told(&format!("keep({heading}) {{ min -120 deg  max 190 deg  gain 2 /s }}")));
    assert!(told(&format!("keep({heading} - 90 deg) {{ min -275 deg  max 10 deg  gain 2 /s }}")));
    assert!(told(&format!("keep(0.5*{heading}) {{ min -60 deg  max 60 deg  gain 2 /s }}")));
    assert!(told(&format!("track(0.5*{heading}) {{ target 20 deg }}")));
    for quiet in [
        format!("keep({heading}) {{ min -120 deg  max 120 deg  gain 2 /s }}"),
        format!("keep(30 deg - {heading}) {{ min -120 deg  max 120 deg  gain 2 /s }}"),
        format!("keep({heading} - 90 deg) {{ min -265 deg  max 10 deg  gain 2 /s }}"),
        // Both sides of the seam have the same size.
        format!("keep(abs({heading})) {{ max 120 deg  gain 2 /s }}"),
        format!("keep(sin({heading})) {{ min -0.5  gain 2 /s }}"),
        format!("track({heading}) {{ target 20 deg }}"),
        "keep(angle_between(frame(base).orientation*[1, 0, 0], [1, 0, 0])) { max 120 deg  gain 2 /s }".to_string(),
        "track(0.5*joint(spindle)) { target 20 deg }".to_string(),
    ] {
        assert!(!told(&quiet), "{quiet}");
    }
    // An `atan2` counts no turns.
    let [hq, yaml] = compile_both(&format!(
        "{}task bearing = track({heading}) {{ target 20 deg  turns exact }}
        stack s {{ {LIMITS}  level a {{ bearing }} }}
        run {{ stack s  duration 1 s }}",
        turntable(
            "base planar  limits { base_x { velocity 1 m/s }  base_y { velocity 1 m/s }  base_yaw { velocity 1 rad/s } }"
        )
    ));
    for compiled in [hq, yaml] {
        let report = compiled.report.render(Style::Plain, 100);
        assert!(report.contains("`atan2` counts no turns"), "{report}");
    }
}

/// A machine of two states with a target each.
fn in_turn(first: &str, second: &str, trigger: &str) -> String {
    format!(
        "hierarq 1
        robot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }} }}
        signal go : orientation {{ timeout 1 s }}
        task first = {first}
        task second = {second}
        stack one {{ level limits hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits }}  level motion {{ first }}  level rest {{ joint_position {{ target {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }}  gain 1 /s }} }} }}
        stack two from one {{ replace motion {{ second }} }}
        machine m {{
          initial a
          blend 0.3 s
          on fault(any) -> stopped
          state a {{ stack one  {trigger} -> b }}
          state b {{ stack two  after 20 s -> stopped }}
          final state stopped {{ stack one }}
        }}
        run {{ machine m  duration 30 s }}"
    )
}

#[test]
fn half_a_turn_is_told_in_every_state() {
    let pose = |orientation: &str| {
        format!("frame_pose(tool) {{ position initial(position)  orientation {orientation}  gain 3 /s }}")
    };
    let [down, over] = ["rpy(0 deg, 180 deg, 0 deg)", "rpy(180 deg, 0 deg, 0 deg)"];
    let told = |text: &str| codes(text).contains(&"HQ0536");
    for trigger in ["after 2 s", "on reached(first, 1 mm, 0.1 deg)"] {
        assert!(told(&in_turn(&pose(down), &pose(over), trigger)));
        assert!(!told(&in_turn(&pose(down), &pose("rpy(0 deg, 180 deg, 90 deg)"), trigger)));
        // From the first target it is half a turn, from home less: the machine is followed.
        let tilted = "rpy(0 deg, 150 deg, 0 deg)";
        assert!(told(&in_turn(&pose(tilted), &pose("rpy(0 deg, 150 deg, 0 deg)*rpy(0, 0, 180 deg)"), trigger)));
        assert!(!told(&in_turn(&pose(tilted), &pose("rpy(90 deg, 0 deg, 0 deg)"), trigger)));
    }
    // Where signals lead is not known, so that home counts.
    let led = "frame_orientation(tool) { orientation go  gain 3 /s }";
    assert!(told(&in_turn(
        led,
        "frame_orientation(tool) { orientation initial(orientation)*rpy(0, 0, 180 deg)  gain 3 /s }",
        "after 2 s"
    )));
    // The message names the states.
    let [hq, _] = compile_both(&in_turn(&pose(down), &pose(over), "after 2 s"));
    let report = hq.report.render(Style::Plain, 100);
    assert!(report.contains("in state `b`, the target of `second` is half a turn away"), "{report}");
    assert!(report.contains("the targets of state `a`"), "{report}");
}

#[test]
fn half_a_turn_of_a_joint_or_of_two_arms_is_told() {
    let of = |task: &str, home: &str| {
        codes(&format!(
            "{}task go = {task}
            stack s {{ {LIMITS}  level a {{ go }} }}
            run {{ stack s  duration 5 s }}",
            turntable(home)
        ))
    };
    let joint = "joint_position { target { spindle 200 deg  hinge 10 deg } }";
    assert_eq!(of(joint, "home { spindle 20 deg }"), ["HQ0536"]);
    assert_eq!(of(joint, "home { spindle 25 deg }"), Vec::<&str>::new());
    let exact = "joint_position { target { spindle 200 deg  hinge 10 deg }  turns exact }";
    assert_eq!(of(exact, "home { spindle 20 deg }"), Vec::<&str>::new());
    // A joint with limits has one way.
    let hinge = "joint_position { target { spindle 20 deg  hinge 180 deg } }";
    assert_eq!(of(hinge, "home { spindle 20 deg }"), Vec::<&str>::new());
}

/// Two arms whose palms are brought to face each other, half a turn apart, and then lift something while they squeeze it to both
/// sides of half a turn and encoders are noisy.
#[test]
fn palms_that_face_each_other_keep_the_absolute_orientation() {
    let text = "hierarq 1
        import \"common/canopies.hq\" { canopies  position_limits  velocity_limits }
        task face = cooperative_motion {
          absolute { position initial(absolute.position)  orientation initial(absolute.orientation) }
          relative { position initial(relative.position)  orientation axis_angle([1, 0, 0], 180 deg) }
          gain 4 /s
        }
        task lift = cooperative_motion {
          absolute {
            position trapezoid(initial(absolute.position) + [0, 0, 0.1] m, speed: 0.1 m/s, acceleration: 0.5 m/s^2)
            orientation initial(absolute.orientation)
          }
          relative {
            position initial(relative.position)
            orientation axis_angle([1, 0, 0], 180 deg + 8 deg*sin(2*pi*t/(4 s)))
          }
          gain 10 /s
        }
        stack facing { lock [base]  level limits hard { position_limits  velocity_limits }  level motion { face } }
        stack lifting from facing { replace motion { lift } }
        machine m {
          initial faces
          blend 0.2 s
          on fault(any) -> stopped
          state faces { stack facing  after 5 s -> lifts }
          state lifts { stack lifting  after 60 s -> stopped }
          final state stopped
        }
        run { machine m  duration 10 s }
        scenario lifts {
          machine m
          seed 4
          simulator { noise 0.2 mrad }
          expect \"half a turn\" from 6 s : always (in(lifts) implies error(lift.relative.orientation) < 1 deg)
          expect \"level\" from 5 s : always (in(lifts) implies error(lift.absolute.orientation) < 1 deg)
          expect \"in the hands\" from 5 s : always (in(lifts) implies error(lift.relative.position) < 5 mm)
          expect \"lifted\" from 9 s : always (in(lifts) and error(lift.absolute.position) < 5 mm)
        }";
    for compiled in compile_both(text) {
        let report = compiled.report.render(Style::Plain, 100);
        let program = compiled.program.unwrap_or_else(|| panic!("{report}"));
        for (title, verdict) in verdicts(&program, &program.scenarios[0]) {
            assert_eq!(verdict, Verdict::Holds, "{title}\n{report}");
        }
    }
}
