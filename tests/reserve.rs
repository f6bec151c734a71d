//! The reserve against sampling in time counts only on speed limits that hold, and with them a wall is never passed.

mod common;

use compiler::{Compiled, Input, Style};
use runtime::record::summary::{MARGIN_TOLERANCE, SummaryRecorder};
use runtime::{Program, Simulation};

/// An arm under a ceiling that it presses against and slides along, with the given levels and rate.
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

/// What the wall holds back, in m.
fn reserve(levels: &str) -> f64 {
    let program = common::program_of(&spec(100, "sampled_margin auto", levels));
    let evaluator = common::evaluator(&program);
    let wall = evaluator.members().iter().position(|m| m.name == "ceiling").expect("the wall is in the stack");
    evaluator.reserve(wall)[0]
}

fn compiled(levels: &str) -> Compiled {
    let text = spec(100, "sampled_margin auto", levels);
    let (name, folder) = ("test.hq", common::example(""));
    compiler::compile(&Input {
        name,
        text: &text,
        spelling: dsl::Spelling::Hq,
        folder: &folder,
        set: &[],
        package_paths: &[],
    })
}

#[test]
fn only_hard_speed_limits_down_to_the_wall_count() {
    let fast = reserve("level a hard { fast }  level b hard { ceiling }  level c { press }");
    let slow = reserve("level a hard { slow }  level b hard { ceiling }  level c { press }");
    // A T / (2 φ) goes with the square of the speeds: 2 rad/s against 0.5 rad/s on every joint that moves the tip.
    assert!((fast / slow - 16.0).abs() < 1e-9, "{fast} and {slow}");
    // Beside the wall, above a soft wall, on two levels above: they hold.
    assert_eq!(reserve("level a hard { slow  ceiling }  level c { press }"), slow);
    assert_eq!(reserve("level a hard { slow }  level b { ceiling }"), slow);
    assert_eq!(reserve("level a hard { fast }  level b hard { slow }  level c hard { ceiling }"), slow);
    // Soft or lower ones do not, wherever they stand.
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
    let (without, with) = (lowest(""), lowest("sampled_margin auto"));
    assert!(without < -MARGIN_TOLERANCE, "the motion is too gentle to show anything: {without}");
    assert!(with >= -MARGIN_TOLERANCE, "passed by {}", -with);
}

#[test]
fn a_run_that_passes_a_wall_by_what_a_tick_can_lose_says_what_helps() {
    let levels = "level a hard { joint_position_limits  slow }  level b hard { ceiling }  level c { press }";
    for (reserve, hints) in [("", 1), ("sampled_margin auto", 0)] {
        let program = common::program_of(&spec(50, reserve, levels));
        let mut simulation = Simulation::new(&program).expect("it can be executed");
        let mut recorder = SummaryRecorder::new(simulation.controller(), simulation.ticks());
        simulation.run(&mut recorder, &mut || 0.0, &mut |_| true).expect("memory does not fail");
        let summary = recorder.summary(&program, simulation.controller(), Vec::new());
        assert_eq!(summary.ok, hints == 0);
        assert_eq!(summary.hints.len(), hints, "{:?}", summary.hints);
        assert!(summary.hints.iter().all(|h| h.contains("`sampled_margin auto`") && h.contains("`ceiling`")));
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
    // A clock that shows how often it was read: one second a tick.
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
