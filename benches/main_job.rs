//! Times of the main job: reading and compiling the largest example, kinematics and rows of a tick, the whole tick, and
//! the whole of experiment 3.A. `cargo bench`.

use std::path::Path;

use divan::Bencher;
use hierarq::project::{Settings, compile};
use runtime::program::Times;
use runtime::{Controller, Evaluator, Observation, Program, Recorder, RestInputs, Simulation, Tick};

fn main() {
    divan::main();
}

fn example(name: &str) -> Program {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
    compile(&path, &Settings::default()).program.expect("examples compile")
}

/// `check` and `compile` of an example, from reading its files on.
#[divan::bench(args = ["safety_tasks.hq", "safety_tasks.yaml"])]
fn check_and_compile(bencher: Bencher, name: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
    bencher.bench(|| compile(&path, &Settings::default()).program.expect("examples compile"));
}

/// Forward kinematics, parameter values and all rows of a tick.
#[divan::bench(args = ["safety_tasks.hq", "cooperative_motion.hq"])]
fn kinematics_and_rows(bencher: Bencher, name: &str) {
    let program = example(name);
    let (mut evaluator, mut problem) =
        Evaluator::new(&program, program.first_stack().expect("it runs a stack")).expect("it can be executed");
    let rest = RestInputs::new(&program);
    let q = program.robot.home.clone();
    evaluator.enter(&q, rest.at(Times::default()));
    bencher.bench_local(|| evaluator.update(&q, rest.at(Times { t: 1.0, time: 1.0 }), &mut problem));
}

/// A tick of the controller: kinematics, rows, cascade, low-level layer.
#[divan::bench(args = ["safety_tasks.hq", "cooperative_motion.hq"])]
fn tick(bencher: Bencher, name: &str) {
    let program = example(name);
    let mut controller = Controller::new(&program).expect("it can be executed");
    let q = program.robot.home.clone();
    let mut time = 0.0;
    bencher.bench_local(|| {
        let fault = controller.step(&Observation { time, q: &q }).fault;
        time += program.robot.period;
        // The robot of this benchmark never moves: start over before the reference has run away.
        if time > 0.2 || fault.is_some() {
            controller.restart();
            time = 0.0;
        }
    });
}

struct Nothing;

impl Recorder for Nothing {
    fn tick(&mut self, _: &Tick) -> std::io::Result<()> {
        Ok(())
    }
}

/// 50 simulated seconds of 3.A.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn fifty_seconds_of_3a(bencher: Bencher) {
    let program = example("safety_tasks.hq");
    bencher.bench_local(|| {
        let mut simulation = Simulation::new(&program).expect("it can be executed");
        simulation.run(&mut Nothing, &mut || 0.0, &mut |_| true).expect("nothing is written")
    });
}
