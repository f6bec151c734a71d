//! Accelerations, jumps and reversals of joints in the summary, the verdict and expectations, compared with known
//! series and with differences of positions.

use crate::common;
use crate::common::cli;

use cli::{folder, hierarq, text};
use common::{program_of as program, velocity_by_differences};
use nalgebra::Vector3;
use runtime::expect::{Outcome, Verdict};
use runtime::program::Program;
use runtime::record::All;
use runtime::record::joint_motion::JointMotion;
use runtime::record::summary::Summary;
use runtime::{Recorder, Tick};

/// A square wave of 10 Hz: five ticks in each direction, from tick 0 on, 39 reversals in 2 s.
const WAVE: &str = "if(sin(2*pi*t/(0.1 s) + 0.1) > 0, 0.5 rad/s, -0.5 rad/s)";

/// An arm whose second joint has the given velocity.
fn arm(velocity: &str, limits: &str, rest: &str) -> String {
    format!(
        "hierarq 1
robot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  home {{ all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }} }}
task swing = joint_velocity {{ velocity {{ joint_2 {velocity} }} }}
task calm = joint_acceleration_limits {{ max 5 rad/s^2 }}
stack work {{ level limits hard {{ joint_position_limits  joint_velocity_limits }} {limits} }}
run {{ duration 2 s }}
{rest}\n"
    )
}

fn run(program: &Program, with: &mut dyn Recorder) -> (Summary, Vec<Outcome>) {
    common::judged(program, &program.scenarios[0], with)
}

/// Returns the motion of joint 2 in a run of the first scenario.
fn second(text: &str) -> JointMotion {
    run(&program(text), &mut All(Vec::new())).0.joints["joint_2"].clone()
}

const EMPTY: &str = "scenario s { expect always time >= 0 s }";

#[test]
fn a_joint_that_swings_is_told_by_the_command_and_by_its_files() {
    let folder = folder("smoothness");
    let spec = folder.join("wave.hq");
    let robots = common::example("robots/arm7.urdf");
    let wave = arm(WAVE, "level motion { swing }", "").replace("robots/arm7.urdf", robots.to_str().expect("UTF-8"));
    std::fs::write(&spec, &wave).expect("writable");
    let (spec, out) = (spec.to_str().expect("UTF-8"), folder.join("out"));
    let done = hierarq(&["run", spec, "--out", out.to_str().expect("UTF-8")]);
    let said = text(&done.stdout);
    assert_eq!(done.status.code(), Some(0), "a swing alone is no failure\n{said}");
    let verdict = "But `joint_2` reversed 38 times (first at 0.10 s); `joint_2` jumped 39 times (first at 0.05 s).";
    assert!(said.contains("held: No limit was passed. ") && said.contains(verdict), "{said}");
    assert!(said.contains("warning: velocities that turn round") && said.contains("largest acceleration"), "{said}");
    let summary = std::fs::read_to_string(out.join("summary.json")).expect("written");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let joint = &summary["joints"]["joint_2"];
    assert_eq!((&joint["reversals"], &joint["jumps"], &joint["unit"]), (&38.into(), &39.into(), &"rad/s^2".into()));
    let number = |key: &str| joint[key].as_f64().expect("a number");
    assert!((number("max_acceleration") - 100.0).abs() < 1e-6, "1 rad/s in 10 ms: {joint}");
    assert!((number("first_reversal_s") - 0.1).abs() < 1e-9 && (number("first_jump_s") - 0.05).abs() < 1e-9, "{joint}");
    assert_eq!(summary["joints"]["joint_1"]["reversals"], 0);
    let report = std::fs::read_to_string(out.join("report.html")).expect("written");
    assert!(report.contains(verdict));
    // A test without an expectation on it does not fail.
    std::fs::write(spec, format!("{wave}{EMPTY}\n")).expect("writable");
    let tested = hierarq(&["test", spec]);
    let said = text(&tested.stdout);
    assert!(tested.status.success() && said.contains(", s: `joint_2` reversed 38 times (first at 0.10 s)"), "{said}");
    // A smooth motion is not reported.
    std::fs::write(folder.join("wave.hq"), wave.replace(WAVE, "0.5*sin(2*pi*t/(1 s)) rad/s")).expect("writable");
    let said = text(&hierarq(&["run", spec, "--out", out.to_str().expect("UTF-8")]).stdout);
    assert!(said.contains("held: No limit was passed.\n") && !said.contains("warning"), "{said}");
    assert!(!said.contains("largest acceleration"), "{said}");
}

#[test]
fn a_limit_of_the_acceleration_says_what_a_jump_is() {
    let of = |levels: &str| second(&arm(WAVE, levels, EMPTY));
    // Satisfied: no jump at all, and the rest of the wave is reported unchanged.
    let calm = of("level smooth hard { calm }  level motion { swing }");
    assert_eq!((calm.jumps, calm.first_jump_s), (0, None), "{calm:?}");
    assert!(calm.max_acceleration < 5.0 + 1e-6, "{calm:?}");
    // On a level below the motion: every reversal violates it.
    let late = of("level motion { swing }  level smooth { calm }");
    assert_eq!(late.jumps, 39, "{late:?}");
}

#[test]
fn faults_and_other_stacks_explain_a_jump() {
    let machine = |blend: &str, world: &str| {
        let rest = format!(
            "stack still {{ level limits hard {{ joint_position_limits  joint_velocity_limits }} level stop {{ joint_velocity {{ velocity {{ all 0 rad/s }} }} }} }}
machine m {{ initial go  on fault(any) -> done  state go {{ stack work  after 0.5 s -> rest {blend} }}  state rest {{ stack still  after 0.5 s -> go {blend} }}  final state done {{ stack still }} }}
scenario s {{ machine m  duration 2 s  {world} expect always time >= 0 s }}"
        );
        second(
            &arm("1.5 rad/s", "level motion { swing }", &rest)
                .replace("run { duration 2 s }", "run { machine m  duration 2 s }"),
        )
    };
    let switched = machine("", "");
    assert_eq!(switched.jumps, 0, "{switched:?}");
    assert!((switched.max_acceleration - 150.0).abs() < 1e-6, "but it is an acceleration: {switched:?}");
    let blended = machine("blend 0.2 s", "");
    assert_eq!(blended.jumps, 0, "{blended:?}");
    let fault = machine("", "lost { joint_2 { from 0.2 s  to 0.21 s } } ");
    assert_eq!(fault.jumps, 0, "{fault:?}");
    // In the middle of a stack there is no explanation for it.
    let jump = second(&arm("if(t > 0.302 s, -1.5 rad/s, 1 rad/s)", "level motion { swing }", EMPTY));
    assert_eq!((jump.jumps, jump.reversals), (1, 0), "{jump:?}");
    assert!((jump.first_jump_s.expect("one") - 0.31).abs() < 1e-9, "{jump:?}");
}

/// Acceleration of the tool by differences of positions: from the robot's true position along the velocity.
#[derive(Default)]
struct Differences {
    before: Vector3<f64>,
    most: f64,
}

impl Recorder for Differences {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let velocity = velocity_by_differences(tick, "tool");
        self.most = self.most.max((velocity - self.before).norm() / 0.01);
        self.before = velocity;
        Ok(())
    }
}

#[test]
fn expectations_speak_of_accelerations_and_reversals() {
    let scenario = "scenario s {
  simulator { lag 20 ms  noise 1 mrad }
  expect always reversals(joint_2) < 100
  expect always reversals(all) < 100
  expect always reversals(\"joint_1*\") < 1
  expect \"calm\" always reversals(all) <= 0
  expect always acceleration(joint_2) < 200 rad/s^2
  expect always acceleration(tool) < 1000 m/s^2
  expect eventually from 1 s : (speed(joint_2) > 0.1 rad/s and reversals(joint_2) > 10)
}";
    let mut seen = Differences::default();
    let (summary, outcomes) = run(&program(&arm(WAVE, "level motion { swing }", scenario)), &mut seen);
    let margin = |k: usize| outcomes[k].margin().expect("a margin");
    assert_eq!(summary.joints["joint_2"].reversals, 38);
    assert_eq!((margin(0), margin(1), margin(2)), (62.0, 62.0, 1.0));
    assert_eq!((outcomes[3].verdict, outcomes[3].decided), (Verdict::Fails, Some(10)), "the first one, at 0.1 s");
    assert!((margin(4) - 100.0).abs() < 1e-6, "{}", margin(4));
    assert!((margin(4) - (200.0 - summary.joints["joint_2"].max_acceleration)).abs() < 1e-9);
    assert!(seen.most > 10.0 && (margin(5) - (1000.0 - seen.most)).abs() < 1e-5, "{} {}", margin(5), seen.most);
    assert_eq!(outcomes[6].verdict, Verdict::Holds);
}
