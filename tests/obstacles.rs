//! Obstacles that signals move: the robot gives way as fast as they come, stale and bad readings are faults, and an obstacle
//! that moves takes no fault away from those that stand; the ground under a gripper; and obstacles that are elsewhere than the controller believes.

use crate::common;
use crate::common::least;

use nalgebra::{UnitQuaternion, Vector3};
use runtime::program::Program;
use runtime::record::All;
use runtime::record::series::SeriesRecorder;
use runtime::record::summary::SummaryRecorder;
use runtime::{Controller, Fault, FaultKind, Observation, Recorder, SimulatedRobot, Simulation, Tick};
use views::report;

const ROBOT: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 200 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }
  points { hand tool } }
task limits = joint_velocity_limits
task stay = hold(tool)
";

/// A ball that comes from afar on the line through the tool, at 0.25 m/s, and stops before the robot runs out of space.
fn ball(signal: &str, script: &str) -> Program {
    common::program_of(&format!(
        "{ROBOT}signal at : point {{ timeout 52 ms  {signal} }}
obstacle ball {{ sphere 0.2 m  position at }}
task away = keep_clear(hand) {{ of ball  d_min 0.1 m  gain 10 /s }}
stack work {{ level limits hard {{ limits }}  level room hard {{ away }}  level motion {{ stay }} }}
scenario s {{ duration 4.6 s  signals {{ at {{ path [{{ at 0 s  value [1.7, 0, 0.34] m }}, {{ at 4.4 s  value [0.6, 0, 0.34] m }}]  {script} }} }} }}"
    ))
}

/// Margins, commands and faults of each tick.
#[derive(Default)]
struct Seen {
    margins: Vec<f64>,
    commands: Vec<Vec<f64>>,
    faults: Vec<Option<Fault>>,
}

impl Recorder for Seen {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let member = tick.evaluator.members().iter().find(|m| m.name == "away");
        let margins = member.map_or(&[][..], |m| &tick.evaluator.margins()[m.margins.clone()]);
        self.margins.push(margins.iter().copied().fold(f64::INFINITY, f64::min));
        self.commands.push(tick.command.to_vec());
        self.faults.push(tick.fault);
        Ok(())
    }
}

/// The steady state of `h' = -gain h - v`: an obstacle that comes at `v` without a known velocity is `v / gain` inside.
#[test]
fn a_ball_is_given_way_as_fast_as_it_comes() {
    let of = |signal: &str| least(&common::recorded::<Seen>(&ball(signal, "")).margins);
    let (measured, estimated, none) = (of("velocity measured"), of("velocity estimated"), of(""));
    assert!(measured > -1e-3, "{measured}");
    assert!(estimated > -2e-3, "{estimated}");
    assert!((none + 0.025).abs() < 2e-3, "{none}");
    let cut = of("velocity estimated  max_speed 0.1 m/s");
    assert!((cut + 0.015).abs() < 2e-3, "{cut}");
}

#[test]
fn readings_that_stop_or_make_no_sense_are_stale_and_the_robot_stands() {
    for signal in ["", "velocity estimated", "velocity measured"] {
        for script in ["to 1 s", "nan 1 s"] {
            let seen = common::recorded::<Seen>(&ball(signal, script));
            let at = seen.faults.iter().position(Option::is_some).expect("there is a fault");
            assert!(matches!(seen.faults[at], Some(Fault::Stale { signal: 0 })), "{:?}", seen.faults[at]);
            // The last reading before 1 s is valid for 52 ms; one that is not a number ends it at once.
            assert_eq!(at, if script == "to 1 s" { 210 } else { 200 }, "{signal} {script}");
            assert!(seen.commands[at..].iter().flatten().all(|v| *v == 0.0), "{signal} {script}");
        }
    }
}

/// Smallest margin of a bar that turns about the vertical axis towards the tool, at 0.4 rad/s, and stops.
fn least_beside_a_bar(signal: &str) -> f64 {
    let program = common::program_of(&format!(
        "{ROBOT}signal at : pose {{ timeout 52 ms  {signal} }}
obstacle bar {{ box [1, 0.1, 0.4] m  position at.position  orientation at.orientation }}
task away = keep_clear(hand) {{ of bar  d_min 5 cm  gain 5 /s }}
stack work {{ level limits hard {{ limits }}  level room hard {{ away }}  level motion {{ stay }} }}
run {{ stack work  duration 1 s }}"
    ));
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(&program);
    let (rate, sent) = (-0.4, program.interface.signals[0].sent());
    let mut least = f64::INFINITY;
    for k in 0..800 {
        let time = f64::from(k) * program.robot.period;
        let angle = -0.2 + rate * time.min(2.5);
        // The bar turns about its centre beside the robot, and its side sweeps towards the tool.
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        let moving = if time < 2.5 { rate } else { 0.0 };
        let pose = [0.35, 0.35, 0.34, turn.w, turn.i, turn.j, turn.k, 0.0, 0.0, 0.0, 0.0, 0.0, moving];
        assert!(controller.signals().set(0, &pose[..sent], time));
        let q = robot.measure().to_vec();
        let command = controller.step(&Observation { time, q: &q });
        assert_eq!(command.fault, None, "{time}");
        let velocity = command.velocity.to_vec();
        let member = controller.evaluator().members().iter().find(|m| m.name == "away").expect("it is there");
        least = least.min(controller.evaluator().margins()[member.margins.start]);
        robot.apply(&velocity);
    }
    least
}

/// A pose turns an obstacle: without its angular velocity, the robot gives way with the lag of its gain.
#[test]
fn a_bar_is_given_way_as_fast_as_it_turns() {
    let [measured, estimated, none] = ["velocity measured", "velocity estimated", ""].map(least_beside_a_bar);
    assert!(measured > -1e-3, "{measured}");
    assert!(estimated > -3e-3, "{estimated}");
    assert!(none < -1e-2, "{none}");
}

/// An obstacle that no signal moves jumps into the tool: a limit that was passed. A ball that a signal moves is in the same
/// task, first far away, and then in the place of the other one, where it is given way.
#[test]
fn an_obstacle_that_moves_takes_no_fault_from_those_that_stand() {
    let run = |declared: &str, measured: &str, nearest: &str| {
        let program = common::program_of(&format!(
            "{ROBOT}signal at : point {{ timeout 1 s }}
obstacle measured {{ sphere 5 cm  position at }}
obstacle declared {{ sphere 5 cm  position {declared} }}
task away = keep_clear(hand) {{ of [measured, declared]  gain 5 /s  {nearest} }}
stack work {{ level limits hard {{ limits }}  level room hard {{ away }}  level motion {{ stay }} }}
scenario s {{ duration 1 s  signals {{ at {{ {measured} }} }} }}"
        ));
        let seen = common::recorded::<Seen>(&program);
        let fault = seen.faults.iter().flatten().next().map(|f| f.kind());
        (least(&seen.margins), fault)
    };
    // The tool is at [0.5, 0, 0.34] m.
    let (far, near) = ("[-1.5, 0, 1.5] m", "[0.53, 0, 0.34] m");
    for nearest in ["", "nearest 1"] {
        let jumps = format!("if(time > 0.5 s, {near}, {far})");
        let (margin, fault) = run(&jumps, &format!("value {far}"), nearest);
        assert!(margin < -1e-3 && fault == Some(FaultKind::Limit), "{nearest}: {margin}, {fault:?}");
        let path = format!("path [{{ at 0.5 s  value {far} }}, {{ at 0.501 s  value {near} }}]");
        let (margin, fault) = run(far, &path, nearest);
        assert!(margin < -1e-3 && fault.is_none(), "{nearest}: {margin}, {fault:?}");
    }
}

/// A scenario may put an obstacle elsewhere than the controller takes it to be: the replay has both places of it alone.
#[test]
fn the_replay_has_the_true_place_of_an_obstacle_that_is_elsewhere() {
    let all = common::program("room.hq");
    let scenario = all.scenarios.iter().find(|s| s.name == "a pillar that was moved").expect("it is there");
    let program = scenario.program(&all);
    let truth = |mut scenario: runtime::program::ScenarioProgram, present: Option<bool>| {
        scenario.world.obstacles[0].present = present;
        let mut simulation = Simulation::in_world(&program, &scenario).expect("it can be executed");
        let ticks = simulation.ticks();
        let controller = simulation.controller();
        let mut series = SeriesRecorder::new(controller, ticks, report::drawn_links(&program));
        let mut statistics = SummaryRecorder::new(controller, ticks);
        let mut both = All(vec![&mut series, &mut statistics]);
        simulation.run(&mut both, &mut || 0.0, &mut |tick| tick < 10).expect("no recorder fails");
        let summary = statistics.summary(&program, simulation.controller(), Vec::new());
        let run = report::Run {
            program: &program,
            scenario: Some(&scenario),
            spec: "",
            summary: &summary,
            good: true,
            series: &series,
        };
        let data = report::data(&run);
        let obstacles = data["scene"]["obstacles"].as_array().expect("a list").clone();
        let elsewhere = obstacles.into_iter().filter(|o| o.get("truth").is_some());
        elsewhere.map(|o| (o["name"].clone(), o["data"].clone(), o["truth"].clone())).collect::<Vec<_>>()
    };
    let pose = |y: f64| serde_json::json!([2.2, y, 1.25, 1.0, 0.0, 0.0, 0.0]);
    let absent = truth(scenario.clone(), Some(false));
    assert_eq!(absent, [("pillar".into(), pose(-0.55), "absent".into())]);
    assert_eq!(truth(scenario.clone(), None), [("pillar".into(), pose(-0.55), pose(-0.41))]);
}

/// A gripper slides over uneven ground in contact with its limit. The elements that are the nearest after a tick are others than
/// before it, and are looked at before the velocity is chosen.
#[test]
fn a_gripper_that_slides_over_the_ground_keeps_its_limit() {
    let text = std::fs::read_to_string(common::example("cloud.hq")).expect("an example");
    let (spec, _) = text.split_once("scenario").expect("it has scenarios");
    for (x, from, to) in [(0.35, -0.2, -0.65), (0.3, -0.6, 0.6)] {
        let program = common::program_of(&format!(
            "{spec}scenario press {{ stack work  duration 9 s  signals {{ reach_to {{ path [
               {{ at 0 s  value [0.5, 0, 0.34] m }}, {{ at 3 s  value [{x}, {from}, -0.04] m }},
               {{ at 8 s  value [{x}, {to}, -0.04] m }}] }} }} }}"
        ));
        let seen = common::recorded::<Clear>(&program);
        assert!(seen.least > -2e-9, "{}", seen.least);
        assert!(seen.least < 1e-6, "it is pressed onto the ground: {}", seen.least);
        assert_eq!(seen.fault, None);
    }
}

/// The least margin of the task `clear`, and the first fault.
struct Clear {
    least: f64,
    fault: Option<Fault>,
}

impl Default for Clear {
    fn default() -> Self {
        Clear { least: f64::INFINITY, fault: None }
    }
}

impl Recorder for Clear {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        if let Some(m) = tick.evaluator.members().iter().find(|m| m.name == "clear") {
            self.least = self.least.min(least(&tick.evaluator.margins()[m.margins.clone()]));
        }
        self.fault = self.fault.or(tick.fault);
        Ok(())
    }
}
