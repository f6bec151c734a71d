//! Times the planner of layers: letters H and D and sorting of thesis 6.4 at once and in batches of 4, the first plan
//! and bound of larger missions, validation, and import of JSON.

#[path = "../tests/layered/mod.rs"]
mod layered;

use divan::{Bencher, black_box};
use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::layers::choose::{Options, plan};
use hierarq_mission::kinds::layers::json::{Mode, export, import};
use hierarq_mission::kinds::layers::problem::Problem;
use hierarq_mission::kinds::layers::validate::validate;

fn main() {
    divan::main();
}

fn time(bencher: Bencher, problem: Problem, options: Options) {
    bencher.bench_local(|| plan(black_box(&problem), &options));
}

#[divan::bench(args = [1, 2, 3], sample_count = 10)]
fn letter_h(bencher: Bencher, set: u64) {
    time(bencher, layered::letter_h(set), Options::default());
}

#[divan::bench(args = [1, 2, 3], sample_count = 10)]
fn letter_d(bencher: Bencher, set: u64) {
    time(bencher, layered::letter_d(set), Options::default());
}

#[divan::bench(args = [1, 2, 3], sample_count = 10)]
fn sorting(bencher: Bencher, set: u64) {
    time(bencher, layered::sorting(set), Options::default());
}

#[divan::bench(args = [1, 2, 3])]
fn letter_h_in_batches(bencher: Bencher, set: u64) {
    time(bencher, layered::letter_h(set), Options { batch: Some(4), ..Options::default() });
}

#[divan::bench(args = [32, 64], sample_count = 3)]
fn first_plan_and_bound(bencher: Bencher, tasks: usize) {
    let options = Options { budget: Budget { nodes: 1, ..Budget::default() }, ..Options::default() };
    time(bencher, layered::random(0, tasks, 2 * tasks, 6, 2), options);
}

#[divan::bench]
fn validation(bencher: Bencher) {
    let problem = layered::letter_h(1);
    if let Ok(plan) = plan(&problem, &Options::default()) {
        bencher.bench_local(|| validate(black_box(&problem), &plan));
    }
}

#[divan::bench]
fn reading(bencher: Bencher) {
    let problem = layered::sorting(1);
    let text = export(&problem);
    bencher.bench_local(|| import(black_box(&text), &problem, Mode::Context));
}
