//! Times the planner of explorations in a room of 7 x 7 m with two robots and four targets: a plan on the lattice, a way out, the validator of plans, the
//! mixed-integer program, and a prediction by the policy of the examples. Times of replanning in whole missions:
//! `mission/examples/explore.rs`.

#![allow(clippy::unwrap_used, reason = "the world of the tests is sound")]

#[path = "../tests/explored/mod.rs"]
mod explored;

use std::path::Path;
use std::time::Duration;

use divan::{Bencher, black_box};
use hierarq_mission::kinds::explore::bound::{Ways, lower_bound};
use hierarq_mission::kinds::explore::execution::{ExploreExecution, Settings};
use hierarq_mission::kinds::explore::foresight::Foresight;
use hierarq_mission::kinds::explore::lattice::{Aim, Deadline, Ground, construct, way_out};
use hierarq_mission::kinds::explore::problem::Problem;
use hierarq_mission::kinds::explore::program::{Present, build};
use hierarq_mission::kinds::explore::validate::validate;
use learning::policy::Policy;
use learning::predict::{Learned, Limits, Observation, Predictor};

fn main() {
    divan::main();
}

fn start() -> (Problem, Present, Foresight) {
    let problem = explored::world();
    let (_, foresight) = ExploreExecution::start(&problem, &Settings::default()).expect("a sound mission");
    let present = explored::present(&problem);
    (problem, present, foresight)
}

/// No plan is good enough.
fn thorough(until: &Deadline) -> Aim<'_> {
    Aim { bound: f64::NEG_INFINITY, until }
}

#[divan::bench(sample_count = 20)]
fn lattice(bencher: Bencher) {
    let (problem, present, foresight) = start();
    let ground = Ground::new(&problem).unwrap();
    bencher.bench_local(|| {
        construct(black_box(&problem), &ground, &present, &foresight, None, &thorough(&Deadline::never()))
    });
}

/// Once for an execution: the free ground, and the states from which a robot can always give way.
#[divan::bench(sample_count = 20)]
fn safe_states(bencher: Bencher) {
    let (problem, ..) = start();
    bencher.bench_local(|| Ground::new(black_box(&problem)));
}

#[divan::bench]
fn bound(bencher: Bencher) {
    let (problem, present, foresight) = start();
    let ways = Ways::new(&problem);
    bencher.bench_local(|| lower_bound(black_box(&problem), &ways, &present, &foresight));
}

#[divan::bench(sample_count = 20)]
fn polish(bencher: Bencher) {
    let (problem, present, foresight) = start();
    let ground = Ground::new(&problem).unwrap();
    let plan = construct(&problem, &ground, &present, &foresight, None, &thorough(&Deadline::never())).expect("a plan");
    let program = build(&problem, &present, &foresight, None).expect("a program");
    bencher.bench_local(|| program.polished(black_box(&problem), &present, &plan, Duration::from_secs(60)));
}

#[divan::bench(sample_count = 20)]
fn fallback_way_out(bencher: Bencher) {
    let (problem, present, foresight) = start();
    bencher.bench_local(|| way_out(black_box(&problem), None, &present, &foresight, &Deadline::never()));
}

#[divan::bench]
fn validator(bencher: Bencher) {
    let (problem, present, foresight) = start();
    let ground = Ground::new(&problem).unwrap();
    let plan = construct(&problem, &ground, &present, &foresight, None, &thorough(&Deadline::never())).expect("a plan");
    bencher.bench_local(|| validate(black_box(&problem), &present, &foresight, &plan));
}

#[divan::bench]
fn program(bencher: Bencher) {
    let (problem, present, foresight) = start();
    bencher.bench_local(|| build(black_box(&problem), &present, &foresight, None));
}

/// With ways that are drawn for its spread, and without.
#[divan::bench(args = [0, 100])]
fn prediction_of_twenty_steps(bencher: Bencher, samples: usize) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/policies/recovered.safetensors");
    let policy = Policy::from_bytes(&std::fs::read(file).expect("the policy")).expect("a policy");
    let state = policy.world().state(0, &[]).expect("a state");
    let (predictor, limits) = (Learned::new(policy), Limits { steps: 20, samples, seed: 0 });
    bencher.bench_local(|| predictor.predict(black_box(&Observation { state, heading: None }), &limits));
}
