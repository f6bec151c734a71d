//! Times the planners of schedules: the rows of thesis Table 5.5 (fixed durations, one operation for each agent),
//! speeds as decisions on the built-in engine, and batches. HiGHS is not always available: `examples/measure.rs` times
//! it.

#[path = "../tests/common/mod.rs"]
mod common;

use divan::{Bencher, black_box};
use hierarq_mission::kinds::schedule::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::schedule::problem::Problem;
use hierarq_mission::kinds::schedule::validate::validate;

fn main() {
    divan::main();
}

fn time(bencher: Bencher, problem: Problem, formulation: Option<Formulation>) {
    let options = Options { formulation, ..Options::default() };
    bencher.bench_local(|| plan(black_box(&problem), &options));
}

#[divan::bench(args = [1, 2, 4, 6, 8, 10, 14])]
fn table_5_5_agents(bencher: Bencher, agents: usize) {
    time(bencher, common::fixed(0, agents, 2, 1), None);
}

#[divan::bench(args = [3, 4, 6, 8, 10])]
fn table_5_5_robots(bencher: Bencher, robots: usize) {
    time(bencher, common::fixed(0, 4, robots, 1), None);
}

#[divan::bench(args = [4, 6, 8], sample_count = 5)]
fn constraint_program(bencher: Bencher, agents: usize) {
    time(bencher, common::fixed(0, agents, 2, 1), Some(Formulation::Constraint));
}

#[divan::bench(args = [2, 3, 4, 5], sample_count = 5)]
fn speeds_built_in(bencher: Bencher, agents: usize) {
    time(bencher, common::random(0, agents, 2, 1), Some(Formulation::Position));
}

#[divan::bench(args = [10, 20, 30], sample_count = 5)]
fn batches_fixed(bencher: Bencher, agents: usize) {
    time(bencher, common::fixed(1, agents, 2, 1), Some(Formulation::Batches));
}

#[divan::bench(args = [10, 20, 30], sample_count = 5)]
fn batches_with_speeds(bencher: Bencher, agents: usize) {
    time(bencher, common::random(1, agents, 2, 1), Some(Formulation::Batches));
}

#[divan::bench(args = [10, 30])]
fn validation(bencher: Bencher, agents: usize) {
    let problem = common::fixed(1, agents, 2, 1);
    let options = Options { formulation: Some(Formulation::Batches), ..Options::default() };
    if let Ok(plan) = plan(&problem, &options) {
        bencher.bench_local(|| validate(black_box(&problem), &plan));
    }
}
