//! Axes of the target of a dual-arm task. Values in the axes of the equations are accepted, others are rejected. A
//! simulation in which the hands approach each other confirms the axes, measured from the poses of the links alone.

use crate::common;

use common::compile_both;
use hierarq_compiler::Style;
use robot::{Data, Model};
use runtime::{Recorder, Simulation, Tick};

/// The dual-arm robot, with a home for the joints of its left arm.
fn robot(left: &str) -> String {
    format!(
        "hierarq 1
robot canopies {{
  urdf \"robots/canopies.urdf\"
  base fixed
  rate 100 Hz
  arms {{ left {{ tip left_tool }}  right {{ tip right_tool }} }}
  joints {{ arm_left \"arm_left_*\"  arm_right \"arm_right_*\" }}
  home {{
    torso_lift 0.15 m
    arm_left {left} rad
    arm_right [1.11, 0.91, 0.67, -1.86, -0.77, 0.76, -0.89] rad
  }}
}}
"
    )
}

const LEFT: &str = "[1.11, 0.91, 0.67, -1.86, -0.77, 0.76, -0.89]";

/// A spec in which both arms move together.
fn spec(left: &str, settings: &str, position: &str, orientation: &str) -> String {
    format!(
        "{}task motion = cooperative_motion {{
  {settings}
  absolute {{ position initial(absolute.position)  orientation initial(absolute.orientation) }}
  relative {{ position {position}  orientation {orientation} }}
  gain {{ linear 20 /s  angular 10 /s }}
}}
stack s {{ level limits hard {{ joint_position_limits  joint_velocity_limits }}  level motion {{ motion }} }}
run {{ stack s  duration 4 s }}
",
        robot(left)
    )
}

fn taken(settings: &str, position: &str, orientation: &str) {
    for compiled in compile_both(&spec(LEFT, settings, position, orientation)) {
        let text = compiled.report.render(Style::Plain, 100);
        assert!(compiled.is_good(), "{settings} {position} {orientation}\n{text}");
    }
}

/// Asserts that the spec is rejected with this help.
fn refused(settings: &str, position: &str, orientation: &str, help: &str) {
    for compiled in compile_both(&spec(LEFT, settings, position, orientation)) {
        let text = compiled.report.render(Style::Plain, 100);
        let codes: Vec<&str> = compiled.report.diagnostics.iter().map(|d| d.code).collect();
        assert_eq!(codes, ["HQ0314"], "{settings} {position} {orientation}\n{text}");
        let said = compiled.report.diagnostics[0].help.as_deref().unwrap_or_default();
        assert!(said.replace('"', "").contains(help), "{text}");
    }
}

const P: &str = "initial(relative.position)";
const R: &str = "initial(relative.orientation)";

#[test]
fn the_relative_position_counts_along_the_left_tip() {
    for settings in ["", "relative_to left", "beta 1", "alpha 0.2"] {
        taken(settings, P, R);
        taken(settings, &format!("{P} + [0, 0.05, 0] m"), R);
        taken(settings, &format!("{P} + ([0, 0.05, 0] m in left_tool)"), R);
        taken(settings, &format!("{P} + ([0, 0.05, 0] m in left)"), R);
        taken(settings, "initial((frame(right).position - frame(left).position) in left_tool)", R);
        taken(settings, "initial(frame(right_tool).position in left)", R);
        taken(settings, "trapezoid([0, -0.3, 0] m in left_tool, speed: 0.1 m/s, acceleration: 0.5 m/s^2)", R);
        let fix = "`initial((..) in left_tool)`";
        refused(settings, "[0, -0.3, 0] m in world", R, fix);
        refused(settings, "initial(frame(right).position - frame(left).position)", R, fix);
        refused(settings, "initial(frame(right).position in right)", R, fix);
        let from =
            "from: initial(frame(right).position - frame(left).position), speed: 0.1 m/s, acceleration: 0.5 m/s^2";
        refused(settings, &format!("trapezoid([0, -0.3, 0] m, {from})"), R, fix);
        // The sum itself reports the axes of its parts.
        refused(settings, &format!("{P} + ([0, 0.05, 0] m in world)"), R, fix);
    }
}

#[test]
fn the_relative_position_counts_along_the_world_where_that_is_said() {
    for settings in ["relative_to world", "beta 0", "beta 0  relative_to left"] {
        taken(settings, &format!("{P} + [0, 0.05, 0] m"), R);
        taken(settings, &format!("{P} + ([0, 0.05, 0] m in world)"), R);
        taken(settings, "initial(frame(right).position - frame(left).position)", R);
        refused(settings, "[0, -0.3, 0] m in left_tool", R, "`[x, y, z] m in world`");
        refused(settings, "initial(frame(right).position in left)", R, "`initial((..) in world)`");
    }
}

#[test]
fn the_relative_orientation_turns_into_the_axes_of_the_left_tip() {
    // `relative_to` does not affect orientations.
    for settings in ["", "relative_to left", "relative_to world"] {
        taken(settings, P, &format!("{R}*rpy(0, 0, 0.1 rad)"));
        taken(settings, P, "rpy(0, 0.1 rad, 0) in left_tool");
        taken(settings, P, "initial(frame(right).orientation in left)");
        taken(settings, P, "initial(inverse(frame(left).orientation)*frame(right).orientation)");
        refused(settings, P, "initial(frame(right).orientation)", "`initial((..) in left_tool)`");
        refused(settings, P, "rpy(0, 0.1 rad, 0) in world", "`rpy(..) in left_tool`");
    }
    taken("beta 0", P, "initial(frame(right).orientation)");
    refused("beta 0", P, "initial(frame(right).orientation in left)", "`initial((..) in world)`");
}

/// The arms may have other names, and may be swapped.
#[test]
fn the_axes_are_those_of_the_arm_that_is_named() {
    let settings = "left_arm right  right_arm left";
    taken(settings, &format!("{P} + ([0, 0.05, 0] m in right_tool)"), R);
    refused(settings, "[0, -0.3, 0] m in left_tool", R, "`[x, y, z] m in right_tool`");
}

/// A planner's deviation is expressed in the axes of the target, whatever the order of the two in the text.
#[test]
fn a_deviation_counts_along_the_axes_of_its_parameter() {
    let planned = |along: &str, settings: &str, first: bool| {
        let task = format!(
            "task motion = cooperative_motion {{ {settings}
  absolute {{ position initial(absolute.position)  orientation initial(absolute.orientation) }}
  relative {{ position {P}  orientation {R} }} }}
"
        );
        let planner = format!(
            "task giving = safety_planner(motion) {{ field nearness  min 0.2 m
  deviate {{ relative {{ position {{ along {along}  speed 0.1 m/s }} }} }} }}
"
        );
        let (a, b) = if first { (planner, task) } else { (task, planner) };
        format!(
            "{}human walker {{ points [hand]  velocity measured }}
{a}{b}safety_field nearness {{ of walker  links [left_tool] }}
stack s {{ level motion {{ motion }}  level planner {{ giving }} }}
run {{ stack s  duration 1 s }}
",
            robot(LEFT)
        )
    };
    for first in [false, true] {
        for (along, settings, good) in [
            ("[0, 1, 0] m in left_tool", "", true),
            ("[0, 1, 0] m in world", "", false),
            ("[0, 1, 0] m in world", "relative_to world", true),
            ("[0, 1, 0] m in left_tool", "relative_to world", false),
        ] {
            for compiled in compile_both(&planned(along, settings, first)) {
                let axes = compiled.report.diagnostics.iter().any(|d| d.code == "HQ0314");
                assert_eq!(!axes, good, "{along} {settings}\n{}", compiled.report.render(Style::Plain, 100));
            }
        }
    }
}

/// Recorder that keeps the last configuration.
struct Last(Vec<f64>);

impl Recorder for Last {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.0.clear();
        self.0.extend_from_slice(tick.q);
        Ok(())
    }
}

/// Position of the right tip in the left one, their distance, and the orientation of the left one.
struct Hands {
    seen: [f64; 3],
    apart: f64,
    left: [f64; 4],
}

fn hands(model: &Model, q: &[f64]) -> Hands {
    let mut data = Data::new(model);
    model.forward(q, &mut data);
    let [l, r] = ["left_tool", "right_tool"].map(|n| *data.pose(model.link(n).expect("a link")));
    let between = r.translation.vector - l.translation.vector;
    let seen = l.rotation.inverse() * between;
    Hands { seen: seen.into(), apart: between.norm(), left: l.rotation.coords.into() }
}

#[test]
fn hands_that_are_told_to_come_closer_do_whatever_the_orientation_of_the_left_one() {
    let homes = [LEFT, "[0.9, 0.8, 0.5, -1.7, 0.4, 0.5, 0.6]", "[1.11, 0.91, 0.67, -1.86, -0.77, 0.2, 1.2]"];
    let mut orientations: Vec<[f64; 4]> = Vec::new();
    for home in homes {
        let [compiled, _] = compile_both(&spec(home, "", P, R));
        let program = compiled.program.expect("it compiles");
        let model = &program.robot.model;
        let start = hands(model, &program.robot.home);
        orientations.push(start.left);
        let [x, y, z] = start.seen.map(|x| -x / start.apart * 0.05);
        let closer = format!("{P} + ([{x}, {y}, {z}] m in left_tool)*smoothstep(t/(2 s))");
        for compiled in compile_both(&spec(home, "", &closer, R)) {
            let report = compiled.report.render(Style::Plain, 100);
            let program = compiled.program.unwrap_or_else(|| panic!("{report}"));
            let mut last = Last(Vec::new());
            let mut simulation = Simulation::new(&program).expect("a compiled program can be executed");
            simulation.run(&mut last, &mut || 0.0, &mut |_| true).expect("memory does not fail");
            let apart = hands(model, &last.0).apart;
            assert!((start.apart - apart - 0.05).abs() < 1e-4, "{home}: from {} to {apart}", start.apart);
        }
    }
    let same = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().abs() > 0.99;
    assert!(!same(&orientations[0], &orientations[1]) && !same(&orientations[0], &orientations[2]));
}
