//! A mission whose worker runs a controller performs no allocation from tick to tick: checked by a counting allocator.

#[path = "common/allocations.rs"]
mod allocations;
mod common;

use runtime::program::{MissionProgram, MissionScenarioProgram};

const CONTROLLER: &str = "
signal go : flag
task limits = joint_velocity_limits
task sway = frame_position(tool) { position initial(position) + [0, 0.1, 0] m * sin(t/(1 s)) }
stack swaying { level limits hard { limits }  level motion { sway } }
machine work {
  initial idle
  blend 0.1 s
  on fault(any) -> idle
  state idle { stack swaying  when go -> busy }
  state busy { stack swaying  after 1 h -> idle }
}
";

/// The mission, and a scenario of this duration (s) in which the only operation does not end.
fn mission(seconds: u32) -> (MissionProgram, MissionScenarioProgram) {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("worker_allocation");
    std::fs::create_dir_all(&folder).expect("a folder");
    let urdf = common::example("robots/arm7.urdf").canonicalize().expect("a file");
    let robot = format!(
        "robot arm {{ urdf \"{}\"  rate 100 Hz  home {{ joint_2 0.4 rad  joint_4 1.6 rad }} }}",
        urdf.display()
    );
    std::fs::write(folder.join("own.hq"), format!("hierarq 1\n{robot}{CONTROLLER}")).expect("a file");
    let text = format!(
        "hierarq 1
mission day : schedule {{
  robot m1 {{ depot [0, 0] m  speed 0.5 m/s  serve 5 s }}
  worker w1 {{ place [5, 4] m  duration 1000 s  runs {{ spec \"own.hq\"  go go  done idle }} }}
}}
scenario s {{ mission day  duration {seconds} s  step 10 s  expect always in(w1.busy) or time < 1 s }}
"
    );
    let (name, syntax) = ("day.hq", dsl::Syntax::Native);
    let input = compiler::Input { name, text: &text, syntax, folder: &folder, set: &[], package_paths: &[] };
    let compiled = compiler::compile(&input);
    assert_eq!(compiled.report.errors(), 0, "{}", compiled.report.to_json());
    let mission = compiled.missions[0].clone();
    let scenario = mission.scenarios[0].clone();
    (mission, scenario)
}

/// Returns the number of allocations of a run, and the number of ticks of its controller.
fn run(seconds: u32) -> (usize, u64) {
    let (mission, scenario) = mission(seconds);
    let before = allocations::of_all_threads();
    let run = runtime::missions::run(&mission, &scenario, &mut runtime::missions::NullRecorder, &mut |_| true)
        .expect("a run");
    let allocations = allocations::of_all_threads() - before;
    assert!(run.summary.ok, "{:?}", run.summary.expectations);
    (allocations, run.summary.workers[0].ticks)
}

// A single test: the allocations of a second one in this process would be counted too.
#[test]
fn a_tick_of_a_worker_allocates_nothing() {
    allocations::are_counted();
    let ((short, few), (long, many)) = (run(100), run(300));
    assert_eq!((few, many), (10_001, 30_001));
    // Measurements at the additional instants of the mission may allocate; there are twenty times as many.
    let instants = (run(110).0.saturating_sub(short)) * 20;
    assert!(
        long - short <= instants + 20,
        "{} allocations in {} ticks, {instants} at instants",
        long - short,
        many - few
    );
    assert!(instants < 2_000, "{instants}");
}
