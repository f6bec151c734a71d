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

/// Configurations that a controller sees of a robot whose velocities follow its commands with a lag (s), 0 for one that does what it is told.
fn observations(program: &Program, lag: f64) -> Vec<Vec<f64>> {
    let mut controller = Controller::new(program).expect("it can be executed");
    let (model, period) = (&program.robot.model, program.robot.period);
    let (mut q, mut v) = (program.robot.home.clone(), vec![0.0; model.nv()]);
    let follows = if lag > 0.0 { 1.0 - (-period / lag).exp() } else { 1.0 };
    let mut seen = Vec::new();
    for k in 0..5000 {
        seen.push(q.clone());
        let command = controller.step(&Observation { time: f64::from(k) * period, q: &q });
        assert!(command.fault.is_none(), "{:?}", command.fault);
        v.iter_mut().zip(command.velocity).for_each(|(v, u)| *v += follows * (u - *v));
        if lag == 0.0 {
            q.copy_from_slice(controller.reference());
        } else {
            model.integrate(&mut q, &v, period);
        }
    }
    seen
}

/// Ticks of a controller in a row, of a robot that was recorded.
fn ticks(bencher: Bencher, name: &str, lag: f64) {
    let mut program = example(name);
    program.robot.lag = lag;
    let seen = observations(&program, lag);
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut k = 0;
    bencher.bench_local(|| {
        if k == seen.len() {
            controller.restart();
            k = 0;
        }
        let fault = controller.step(&Observation { time: k as f64 * program.robot.period, q: &seen[k] }).fault;
        k += 1;
        fault
    });
}

/// A tick of the controller of a robot that is where its reference is: kinematics, rows, cascade, low-level layer.
#[divan::bench(args = ["hello.hq", "safety_tasks.hq", "cooperative_motion.hq"], sample_count = 5000)]
fn tick(bencher: Bencher, name: &str) {
    ticks(bencher, name, 0.0);
}

/// The same of a robot with a lag of 50 ms, which the spec tells: its limits are kept where it is too.
#[divan::bench(args = ["hello.hq", "safety_tasks.hq", "cooperative_motion.hq"], sample_count = 5000)]
fn tick_of_a_robot_that_lags(bencher: Bencher, name: &str) {
    ticks(bencher, name, 0.05);
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
