//! Ticks that exceed the time budget: the robot keeps its hard limits and slows down, the log and the summary report
//! it, and the solver reaches its solution over several ticks.

use runtime::record::All;
use runtime::record::csv::CsvRecorder;
use runtime::record::summary::SummaryRecorder;
use runtime::{Controller, Fault, Observation, Program, Recorder, Simulation, Tick};
use solver::Status;

use super::common::{program, program_of};

/// Results of each tick.
struct Kept {
    late: Vec<bool>,
    v: Vec<Vec<f64>>,
    /// Maximum violation of a row of a hard level.
    beyond: f64,
}

impl Recorder for Kept {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        assert!(tick.fault.is_none(), "{:?} at {} s", tick.fault, tick.time);
        self.late.push(tick.controller.is_late());
        assert_eq!(tick.controller.is_late(), matches!(tick.solution.status, Status::OutOfTime { .. }));
        self.v.push(tick.v.to_vec());
        for level in tick.problem.levels.iter().filter(|l| l.hard) {
            for i in 0..level.rows() {
                self.beyond = self.beyond.max(level.slack(i, tick.v).abs());
            }
        }
        Ok(())
    }
}

fn run(program: &Program) -> Kept {
    let mut kept = Kept { late: Vec::new(), v: Vec::new(), beyond: 0.0 };
    let mut simulation = Simulation::new(program).expect("it can be executed");
    simulation.run(&mut kept, &mut || 0.0, &mut |_| true).expect("nothing is written");
    kept
}

/// The budget of each tick is used up at its begin, so that the results are independent of the clock.
fn hurried(program: &Program) -> Program {
    let mut program = program.clone();
    program.run.tick_budget = Some(1e-9);
    program
}

/// The scenario checks the final positions of the hands.
#[test]
fn a_robot_without_time_keeps_its_hard_limits() {
    let program = program("hard/short_of_time.hq");
    let kept = run(&hurried(&program));
    let late = kept.late.iter().filter(|late| **late).count();
    assert!(late > 100 && late < kept.late.len(), "{late} of {} ticks", kept.late.len());
    assert!(kept.beyond < 1e-9, "a hard level was passed by {}", kept.beyond);
    let mut calm = program;
    calm.run.tick_budget = None;
    assert!(run(&calm).late.iter().all(|late| !late));
}

/// Seven joints must jump from 0.1 rad/s to different speeds beyond their limits: the line to the solution meets one
/// limit after the other, and the budget permits one of them per tick.
#[test]
fn a_late_tick_goes_as_far_as_the_next_limit() {
    const SPEC: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad } }
let wish = if(t < 0.095 s, 0 rad/s, 1 rad/s)
task jump = joint_velocity {
  velocity {
    joint_1 0.1 rad/s + wish  joint_2 0.1 rad/s + 2*wish  joint_3 0.1 rad/s + 3*wish  joint_4 0.1 rad/s + 4*wish
    joint_5 0.1 rad/s + 5*wish  joint_6 0.1 rad/s + 6*wish  joint_7 0.1 rad/s + 7*wish
  }
}
task caps = joint_velocity_limits { max 0.5 rad/s }
stack moves {
  level walls hard { joint_velocity_limits }
  level caps { caps }
  level motion damping none { jump }
}
run { duration 0.3 s }
";
    let kept = run(&hurried(&program_of(SPEC)));
    assert!(kept.late[10], "{:?}", kept.late);
    for k in 10..17 {
        // At tick 10 + i joint 7 - i reaches its limit.
        let part = 0.4 / (17 - k) as f64;
        for (joint, v) in kept.v[k].iter().enumerate() {
            let expected = (0.1 + part * (joint + 1) as f64).min(0.5);
            assert!((v - expected).abs() < 1e-9, "tick {k}, joint {}: {v}, not {expected}", joint + 1);
        }
    }
    assert!(kept.late[17..].iter().all(|late| !late), "{:?}", kept.late);
}

/// The first tick of a stack needs many changes and has no previous solution: the robot keeps a part of its velocity.
#[test]
fn a_first_tick_without_time_slows_the_robot_down() {
    const SPEC: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad } }
task caps = joint_velocity_limits { max 0.5 rad/s }
stack slow { level motion damping none { joint_velocity { velocity { all 0.2 rad/s } } } }
stack fast {
  level caps { caps }
  level motion damping none { joint_velocity { velocity { all [1, 2, 3, 4, 5, 6, 7] rad/s } } }
}
machine m {
  initial a
  state a { stack slow  after 0.1 s -> b }
  state b { stack fast }
}
run { machine m  duration 0.5 s }
";
    let kept = run(&hurried(&program_of(SPEC)));
    let first = kept.late.iter().position(|late| *late).expect("a late tick");
    assert_eq!(first, 10);
    let last = kept.late.iter().rposition(|late| *late).expect("a late tick");
    assert!(last > first && last < 20, "{:?}", kept.late);
    for k in first..=last {
        for v in &kept.v[k] {
            let expected = 0.2 * (-0.1 * (k - first) as f64).exp();
            assert!((v - expected).abs() < 1e-12, "tick {k}: {v}, not {expected}");
        }
    }
    assert!(kept.v[last + 1..].iter().flatten().all(|v| (v - 0.5).abs() < 1e-9));
}

/// Contradicting hard levels are a fault at the same tick for any budget: a late tick does not hide it.
#[test]
fn no_time_hides_no_hard_level_that_cannot_be_met() {
    const SPEC: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad } }
task caps = joint_velocity_limits { max 0.5 rad/s }
task must = joint_velocity { velocity { all if(t < 0.095 s, 0.1 rad/s, 1 rad/s) } }
stack moves { level caps hard { caps }  level must hard { must } }
run { duration 0.3 s }
";
    let calm = program_of(SPEC);
    for program in [hurried(&calm), calm] {
        let mut controller = Controller::new(&program).expect("it can be executed");
        let q = program.robot.home.clone();
        for k in 0..12 {
            let command = controller.step(&Observation { time: 0.01 * f64::from(k), q: &q });
            if k < 10 {
                assert_eq!(command.fault, None, "tick {k}");
            } else {
                assert_eq!(command.fault, Some(Fault::Infeasible { level: 1 }), "tick {k}");
                assert!(!command.late && command.velocity.iter().all(|v| *v == 0.0), "tick {k}");
            }
        }
    }
}

#[test]
fn late_ticks_are_told() {
    let program = hurried(&program("hard/short_of_time.hq"));
    let mut simulation = Simulation::new(&program).expect("it can be executed");
    let mut summary = SummaryRecorder::new(simulation.controller(), simulation.ticks());
    let mut log = Vec::new();
    let mut csv = CsvRecorder::new(&mut log, &program, simulation.controller()).expect("memory");
    simulation
        .run(&mut All(vec![&mut summary, &mut csv]), &mut || 0.0, &mut |tick| tick < 100)
        .expect("nothing is written");
    csv.finish().expect("memory");
    let told = summary.summary(&program, simulation.controller(), Vec::new()).late.expect("a budget");
    let text = String::from_utf8(log).expect("text");
    let mut lines = text.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let column = lines.next().expect("a header").iter().position(|c| *c == "late").expect("a column");
    let late: Vec<bool> = lines.map(|l| l[column] == "1").collect();
    assert_eq!(told.ticks, late.iter().filter(|late| **late).count());
    assert!(told.ticks > 0 && told.in_a_row > 1 && told.in_a_row <= told.ticks);
    let first = late.iter().position(|late| *late).expect("a late tick");
    assert!((told.first_s - 0.01 * first as f64).abs() < 1e-9);
}
