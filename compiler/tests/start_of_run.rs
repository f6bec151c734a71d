//! `initial(..)` in expectations: the value at the start of the run, online and offline, compared with numbers computed
//! from the recorded joints alone.

use crate::common;

use common::compile_both;
use hierarq_compiler::Style;
use robot::Data;
use runtime::expect::{Outcome, Verdict, offline};
use runtime::program::{Program, ScenarioProgram};
use runtime::record::All;
use runtime::{ExpectationMonitors, Recorder, Simulation, Tick};

const SPEC: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad } }
signal load : number
task turn = joint_velocity { velocity { joint_1 0.2 rad/s } }
stack s { level limits hard { joint_position_limits  joint_velocity_limits }  level motion { turn } }
stack rest { level limits hard { joint_position_limits  joint_velocity_limits } }
machine m {
  initial turning
  blend 0.2 s
  on fault(any) -> stopped
  state turning { stack s  after 1 s -> resting }
  state resting { stack rest  after 1 s -> again }
  state again { stack s  after 10 s -> stopped }
  final state stopped { stack rest }
}
run { machine m  duration 3 s }
scenario \"elsewhere\" {
  start { joint_1 0.3 rad }
  seed 3
  simulator { noise 1 mrad  lag 20 ms }
  signals { load { path [{ at 0 s  value 2 }, { at 3 s  value 5 }] } }
  expect \"angle\" always joint(joint_1) - initial(joint(joint_1)) < 0.5 rad
  expect \"place\" always norm(frame(tool).position - initial(frame(tool).position)) < 10 cm
  expect \"turn\" always norm(frame(tool).orientation*[1, 0, 0] - initial(frame(tool).orientation)*[1, 0, 0]) < 2
  expect \"sum\" always joint(joint_1) + joint(joint_2) - initial(joint(joint_1) + joint(joint_2)) < 0.5 rad
  expect \"speed\" always speed(joint_1) - initial(speed(joint_1)) < 0.5 rad/s
  expect \"signal\" always load - initial(load) < 4
  expect \"state\" always initial(joint(joint_1) > 0.2 rad)
}
";

/// Recorder of the robot's state at each tick.
struct Seen {
    q: Vec<Vec<f64>>,
    load: Vec<f64>,
}

impl Recorder for Seen {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.q.push(tick.q.to_vec());
        // The value follows the flag of its presence.
        self.load.push(tick.signals[1]);
        Ok(())
    }
}

fn run(program: &Program, scenario: &ScenarioProgram) -> (Seen, Vec<Outcome>) {
    let program = scenario.program(program);
    let mut simulation = Simulation::in_world(&program, scenario).expect("it can be executed");
    let mut monitors = ExpectationMonitors::new(&program, scenario, simulation.ticks()).expect("it can be judged");
    let mut seen = Seen { q: Vec::new(), load: Vec::new() };
    simulation.run(&mut All(vec![&mut seen, &mut monitors]), &mut || 0.0, &mut |_| true).expect("memory does not fail");
    (seen, monitors.finish())
}

#[test]
fn it_is_the_value_at_the_start_of_the_run() {
    for compiled in compile_both(SPEC) {
        let report = compiled.report.render(Style::Plain, 100);
        let program = compiled.program.unwrap_or_else(|| panic!("{report}"));
        let scenario = &program.scenarios[0];
        let (seen, outcomes) = run(&program, scenario);
        let mut data = Data::new(&program.robot.model);
        let tool = program.robot.model.link("tool").expect("a link");
        let mut poses = Vec::new();
        for q in &seen.q {
            program.robot.model.forward(q, &mut data);
            poses.push(*data.pose(tool));
        }
        assert!((seen.q[0][0] - 0.3).abs() < 1e-12, "the run starts elsewhere than at home");
        let ticks = 0..seen.q.len();
        let (q, x) = (&seen.q, nalgebra::Vector3::x());
        let series: Vec<Vec<f64>> = vec![
            ticks.clone().map(|k| 0.5 - (q[k][0] - q[0][0])).collect(),
            ticks.clone().map(|k| 0.1 - (poses[k].translation.vector - poses[0].translation.vector).norm()).collect(),
            ticks.clone().map(|k| 2.0 - (poses[k].rotation * x - poses[0].rotation * x).norm()).collect(),
            ticks.clone().map(|k| 0.5 - (q[k][0] + q[k][1] - q[0][0] - q[0][1])).collect(),
            ticks.clone().map(|k| 0.5 - if k == 0 { 0.0 } else { (q[k][0] - q[k - 1][0]).abs() / 0.01 }).collect(),
            ticks.clone().map(|k| 4.0 - (seen.load[k] - seen.load[0])).collect(),
        ];
        let units = scenario.units();
        for (i, numbers) in series.iter().enumerate() {
            let (expected, found) = (numbers.iter().copied().fold(f64::INFINITY, f64::min), outcomes[i]);
            let title = scenario.expectations[i].title();
            assert!((found.lower - expected).abs() < 1e-9, "{title}: {} and not {expected}", found.lower);
            // The evaluation of the whole log agrees.
            let mut log = vec![vec![0.0; numbers.len()]; units.len()];
            for at in scenario.expectations[i].formula.signals() {
                log[at].clone_from(numbers);
            }
            let whole = offline::evaluate(&scenario.expectations[i].formula, &units, &log).expect("a log");
            assert_eq!((whole.verdict, whole.unit), (found.verdict, found.unit), "{title}");
            assert!((whole.lower - found.lower).abs() < 1e-9, "{title}: {} and not {}", whole.lower, found.lower);
        }
        // The arm moved 10 cm away, whatever the stack.
        let verdicts: Vec<Verdict> = outcomes.iter().map(|o| o.verdict).collect();
        use Verdict::{Fails, Holds};
        assert_eq!(verdicts, [Holds, Fails, Holds, Holds, Holds, Holds, Holds]);
    }
}

#[test]
fn a_program_with_it_is_read_again_from_its_data() {
    let [compiled, _] = compile_both(SPEC);
    let report = compiled.report.render(Style::Plain, 100);
    let program = compiled.program.unwrap_or_else(|| panic!("{report}"));
    let text = serde_json::to_string(&program).expect("data");
    let again: Program = serde_json::from_str(&text).expect("the same data");
    again.check().expect("it can be executed");
    assert_eq!(run(&program, &program.scenarios[0]).1, run(&again, &again.scenarios[0]).1);
}
