//! The reserve against sampling in time only relies on speed limits that are guaranteed, and with them a wall is never
//! crossed.

use crate::common;

use compiler::{Compiled, Input, Style};
use runtime::record::summary::{MARGIN_TOLERANCE, SummaryRecorder};
use runtime::{Program, Simulation};

/// An arm that presses against a ceiling and slides along it, with the given levels and rate.
fn spec(rate: u32, reserve: &str, levels: &str) -> String {
    format!(
        "hierarq 1
         robot arm {{
           urdf \"robots/arm7.urdf\"
           rate {rate} Hz
           points {{ tip tool }}
           home {{ all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }}
         }}
         task ceiling = virtual_wall(tip) {{ through [[0, 0, 0.42], [0, 1, 0.42], [1, 0, 0.42]] m  d_min 2 cm  {reserve} }}
         task fast = joint_velocity_limits {{ max 2 rad/s }}
         task slow = joint_velocity_limits {{ max 0.5 rad/s }}
         task press = frame_position(tool) {{
           position initial(position) + [-0.15, 0, 0] m * sin(pi*t/(1 s)) + [0, 0, 0.2] m * sin(pi*t/(4 s))
           gain 10 /s
         }}
         stack s {{ {levels} }}
         run {{ duration 8 s }}"
    )
}

/// Returns the reserve of the wall (m).
fn reserve(levels: &str) -> f64 {
    let program = common::program_of(&spec(100, "sampled_margin auto", levels));
    let evaluator = common::evaluator(&program);
    let wall = evaluator.members().iter().position(|m| m.name == "ceiling").expect("the wall is in the stack");
    evaluator.sampled_margin(wall)[0]
}

fn compiled(levels: &str) -> Compiled {
    let text = spec(100, "sampled_margin auto", levels);
    let (name, folder) = ("test.hq", common::example(""));
    compiler::compile(&Input {
        name,
        text: &text,
        syntax: dsl::Syntax::Native,
        folder: &folder,
        set: &[],
        package_paths: &[],
    })
}

#[test]
fn only_hard_speed_limits_down_to_the_wall_count() {
    let fast = reserve("level a hard { fast }  level b hard { ceiling }  level c { press }");
    let slow = reserve("level a hard { slow }  level b hard { ceiling }  level c { press }");
    // A T / (2 φ) is proportional to the square of the speeds: 2 rad/s against 0.5 rad/s for every joint that moves the
    // tip.
    assert!((fast / slow - 16.0).abs() < 1e-9, "{fast} and {slow}");
    // On the wall's level, above a soft wall, on two higher levels: these limits are guaranteed.
    assert_eq!(reserve("level a hard { slow  ceiling }  level c { press }"), slow);
    assert_eq!(reserve("level a hard { slow }  level b { ceiling }"), slow);
    assert_eq!(reserve("level a hard { fast }  level b hard { slow }  level c hard { ceiling }"), slow);
    // Soft or lower limits are not, on any level.
    assert_eq!(reserve("level a hard { fast }  level b { slow }  level c { ceiling }"), fast);
    assert_eq!(reserve("level a hard { fast  ceiling }  level b hard { slow }"), fast);
    assert_eq!(reserve("level a hard { fast }  level b hard { ceiling }  level c { slow }"), fast);
    for loose in [
        "level b hard { ceiling }  level c { press }",
        "level a { slow }  level b { ceiling }  level c { press }",
        "level a hard { ceiling }  level b hard { slow }  level c { press }",
    ] {
        let compiled = compiled(loose);
        let codes: Vec<&str> = compiled.report.diagnostics.iter().map(|d| d.code).collect();
        assert!(codes.contains(&"HQ0503"), "{loose}: {}", compiled.report.render(Style::Plain, 100));
        assert!(compiled.program.is_none());
    }
}

fn margins(program: &Program) -> Vec<f64> {
    let wall = common::evaluator(program).members().iter().find(|m| m.name == "ceiling").expect("there").margins.start;
    common::run(program).iter().map(|s| s.margins[wall]).collect()
}

#[test]
fn a_wall_is_passed_without_a_reserve_and_never_with_it() {
    let levels = "level a hard { joint_position_limits  slow }  level b hard { ceiling }  level c { press }";
    let lowest = |reserve: &str| {
        let program = common::program_of(&spec(50, reserve, levels));
        margins(&program).into_iter().fold(f64::INFINITY, f64::min)
    };
    let without = lowest("sampled_margin 0 m");
    assert!(without < -MARGIN_TOLERANCE, "the motion is too gentle to show anything: {without}");
    for reserve in ["sampled_margin auto", ""] {
        let with = lowest(reserve);
        assert!(with >= -MARGIN_TOLERANCE, "passed by {}", -with);
    }
}

#[test]
fn a_run_that_passes_a_wall_by_what_a_tick_can_lose_says_what_helps() {
    let levels = "level a hard { joint_position_limits  slow }  level b hard { ceiling }  level c { press }";
    for (reserve, hints) in [("sampled_margin 0 m", 1), ("sampled_margin auto", 0), ("", 0)] {
        let program = common::program_of(&spec(50, reserve, levels));
        let mut simulation = Simulation::new(&program).expect("it can be executed");
        let mut recorder = SummaryRecorder::new(simulation.controller(), simulation.ticks());
        simulation.run(&mut recorder, &mut || 0.0, &mut |_| true).expect("memory does not fail");
        let summary = recorder.summary(&program, simulation.controller(), Vec::new());
        assert_eq!(summary.ok, hints == 0);
        assert_eq!(summary.hints.len(), hints, "{:?}", summary.hints);
        assert!(summary.hints.iter().all(|h| h.contains("remove its `sampled_margin`") && h.contains("`ceiling`")));
    }
}

#[test]
fn after_a_fault_speeds_are_those_of_a_robot_that_stands_and_ticks_that_compute_nothing_do_not_count() {
    let program = common::program_of(
        "hierarq 1
         robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
         task floor = virtual_wall(link_7) { through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m  d_min 1 m/s * t }
         task speeds = joint_velocity_limits { max 0.1 rad/s }
         stack s { level limits hard { speeds }  level floor hard { floor } }
         run { duration 5 s }",
    );
    let mut simulation = Simulation::new(&program).expect("it can be executed");
    let mut recorder = SummaryRecorder::new(simulation.controller(), simulation.ticks());
    // A clock that counts its reads: one second per tick.
    let mut now = 0.0;
    let mut clock = || {
        now += 1.0;
        now
    };
    simulation.run(&mut recorder, &mut clock, &mut |_| true).expect("memory does not fail");
    let summary = recorder.summary(&program, simulation.controller(), Vec::new());
    assert_eq!(summary.faults.len(), 1);
    assert_eq!(summary.tasks["speeds"].final_margin, Some(0.1));
    assert_eq!((summary.tick_us.all.median, summary.tick_us.all.max), (1e6, 1e6));
}

const TWO_LINKS: &str = r#"<robot name="two"><link name="base"/><link name="upper"/><link name="fore"/><link name="tip"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="1"/></joint>
  <joint name="end" type="fixed"><parent link="fore"/><child link="tip"/><origin xyz="0.5 0 0"/></joint></robot>"#;

/// Two links in a plane that move, and then are locked and stop over a blend, with a wall whose minimum distance is
/// `wall`; `None` if the start is too close.
fn coming_to_rest(dice: &mut impl FnMut(f64, f64) -> f64) -> Option<Program> {
    let (shoulder, elbow, wall) = (dice(-1.4, 1.4), dice(0.3, 2.2), dice(0.1, 0.6));
    let rate = [20.0, 50.0, 100.0, 250.0][dice(0.0, 3.999) as usize];
    let gain = [2.0, 5.0, 10.0, 20.0][dice(0.0, 3.999) as usize];
    let (v_shoulder, v_elbow, after, blend) = (dice(-2.0, 2.0), dice(-2.0, 2.0), dice(0.1, 1.2), dice(0.3, 4.0));
    // The bound of the acceleration for 2 rad/s is 2² 0.5 + 4² 0.5 m/s².
    let reserve = 10.0 / rate / (2.0 * gain);
    let x = 0.5 * shoulder.cos() + 0.5 * (shoulder + elbow).cos();
    if x < wall + 1.01 * reserve {
        return None;
    }
    let urdf = common::urdf_file(TWO_LINKS, "two_links");
    Some(common::program_of(&format!(
        "hierarq 1
robot arm {{ urdf \"{}\"  rate {rate} Hz  home {{ shoulder {shoulder} rad  elbow {elbow} rad }}  points {{ end tip }} }}
task wall = virtual_wall(end) {{ through [[{wall}, 0, 0], [{wall}, 1, 0], [{wall}, 0, 1]] m  sampled_margin auto  gain {gain} /s }}
task turn = joint_velocity {{ velocity {{ shoulder {v_shoulder} rad/s  elbow {v_elbow} rad/s }} }}
stack moving {{ level limits hard {{ joint_position_limits  joint_velocity_limits  wall }}  level motion {{ turn }} }}
stack standing {{ lock [shoulder, elbow]  level limits hard {{ joint_position_limits  joint_velocity_limits  wall }} }}
machine m {{
  initial go
  state go {{ stack moving  after {after} s -> rest blend {blend} s }}
  state rest {{ stack standing }}
}}
run {{ machine m  duration 6 s }}\n",
        urdf.display()
    )))
}

/// Joints that a stack locks may still move when it is entered: its reserve includes the speed that they may have then.
#[test]
fn a_wall_holds_while_locked_joints_come_to_rest() {
    let mut state = 1_u64;
    let mut dice = |low: f64, high: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (state >> 11) as f64 / (1_u64 << 53) as f64 * (high - low)
    };
    let (mut ran, mut near) = (0, 0);
    while ran < 60 {
        let Some(program) = coming_to_rest(&mut dice) else { continue };
        let mut simulation = Simulation::new(&program).expect("it can be executed");
        let mut recorder = SummaryRecorder::new(simulation.controller(), simulation.ticks());
        simulation.run(&mut recorder, &mut || 0.0, &mut |_| true).expect("memory does not fail");
        let summary = recorder.summary(&program, simulation.controller(), Vec::new());
        let margin = summary.tasks["wall"].min_margin.expect("it is in both stacks");
        assert!(
            margin >= -MARGIN_TOLERANCE && summary.faults.is_empty(),
            "run {ran}: {margin} m, {:?}",
            summary.faults
        );
        ran += 1;
        near += usize::from(margin < 2e-3);
    }
    assert!(near > 5, "the motion is too gentle to show anything: {near} runs come near the wall");
}

/// The same press against a ceiling that is a `keep`.
fn kept(reserve: &str) -> Program {
    let levels = "level a hard { joint_position_limits  slow }  level b hard { ceiling }  level c { press }";
    let text = spec(50, "", levels);
    let wall = text.lines().find(|line| line.contains("task ceiling")).expect("a ceiling");
    common::program_of(
        &text.replace(wall, &format!("task ceiling = keep(frame(tool).position.z) {{ max 0.4 m  {reserve} }}")),
    )
}

#[test]
fn a_height_that_is_kept_has_the_reserve_of_a_wall() {
    let levels = "level a hard { joint_position_limits  slow }  level b hard { ceiling }  level c { press }";
    let wall = common::program_of(&spec(50, "sampled_margin auto", levels).replace(
        "through [[0, 0, 0.42], [0, 1, 0.42], [1, 0, 0.42]] m  d_min 2 cm",
        "through [[0, 0, 0.4], [0, 1, 0.4], [1, 0, 0.4]] m",
    ));
    let reserve = |program: &Program| {
        let evaluator = common::evaluator(program);
        let ceiling = evaluator.members().iter().position(|m| m.name == "ceiling").expect("there");
        evaluator.sampled_margin(ceiling)[0]
    };
    let height = kept("sampled_margin auto");
    assert!((reserve(&height) - reserve(&wall)).abs() < 1e-12, "{} and {}", reserve(&height), reserve(&wall));
    let lowest = |program: &Program| margins(program).into_iter().fold(f64::INFINITY, f64::min);
    assert!(lowest(&height) >= 0.0, "{}", lowest(&height));
    assert!(lowest(&kept("")) < -1e-6, "nothing is lost without a reserve");
}
