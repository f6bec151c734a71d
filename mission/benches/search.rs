//! Times the planner of searches: plans on a floor of 750 m^2, states of the tree search on one thread and on two, trees of
//! 2,000 nodes, the check of a map, with walls and as an occupancy grid of 75,000 cells.

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/searched/mod.rs"]
mod searched;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::search::check::check;
use hierarq_mission::kinds::search::choose::{Options, plan};
use hierarq_mission::kinds::search::problem::Problem;
use hierarq_mission::kinds::search::validate::validate;
use hierarq_mission::kinds::search::ways::ActionSets;
use hierarq_mission::occupancy::{Cell, Image, MapFile, OccupancyGrid};
use hierarq_mission::parallel::threads;

fn main() {
    divan::main();
}

fn floor(agents: usize, states: u64) -> Problem {
    let mut problem = searched::floor(agents, 10);
    problem.planner.states = states;
    problem
}

#[divan::bench(args = [2, 3], sample_count = 10)]
fn plan_of_a_floor(bencher: Bencher, agents: usize) {
    let problem = floor(agents, 20_000);
    bencher.bench_local(|| plan(black_box(&problem), &Options::of(&problem)));
}

/// Trees are grown too: compare with `action_sets_of_a_floor`.
#[divan::bench(args = [1, 2], sample_count = 5)]
fn states_by_threads(bencher: Bencher, threads: usize) {
    let problem = floor(2, 200_000);
    let options = Options { threads: Some(threads), ..Options::of(&problem) };
    bencher.counter(ItemsCount::new(200_000_u64)).bench_local(|| plan(black_box(&problem), &options));
}

#[divan::bench(sample_count = 10)]
fn action_sets_of_a_floor(bencher: Bencher) {
    let problem = floor(2, 20_000);
    bencher.bench_local(|| ActionSets::new(black_box(&problem), threads()));
}

/// One agent and one source behind walls: one tree.
#[divan::bench(args = [400, 2_000])]
fn tree(bencher: Bencher, nodes: usize) {
    let mut problem = searched::floor(1, 1);
    problem.planner.tree_nodes = nodes;
    bencher.bench_local(|| ActionSets::new(black_box(&problem), threads()));
}

#[divan::bench]
fn check_of_a_floor(bencher: Bencher) {
    let problem = floor(2, 20_000);
    bencher.bench_local(|| check(black_box(&problem)));
}

#[divan::bench]
fn first_plan(bencher: Bencher) {
    let mut problem = floor(2, 20_000);
    let budget = Budget { nodes: 500, ..Budget::default() };
    problem.start = 10.0;
    bencher.bench_local(|| plan(black_box(&problem), &Options { budget, ..Options::of(&problem) }));
}

/// Hidden objects: the mission of `examples/tokens.hq`.
#[divan::bench(sample_count = 20)]
fn plan_for_hidden_objects(bencher: Bencher) {
    let problem = searched::yard();
    bencher.bench_local(|| plan(black_box(&problem), &Options::of(&problem)));
}

#[divan::bench(sample_count = 20)]
fn action_sets_for_hidden_objects(bencher: Bencher) {
    let problem = searched::yard();
    bencher.bench_local(|| ActionSets::new(black_box(&problem), threads()));
}

#[divan::bench(sample_count = 20)]
fn sight_of_a_yard(bencher: Bencher) {
    bencher.bench_local(|| searched::yard().sight());
}

#[divan::bench(sample_count = 20)]
fn validation_of_looks(bencher: Bencher) {
    let problem = searched::yard();
    if let Ok(found) = plan(&problem, &Options::of(&problem)) {
        bencher.bench_local(|| validate(black_box(&problem), &found.plan));
    }
}

#[divan::bench]
fn validation(bencher: Bencher) {
    let problem = floor(2, 2_000);
    if let Ok(found) = plan(&problem, &Options::of(&problem)) {
        bencher.bench_local(|| validate(black_box(&problem), &found.plan));
    }
}

/// The floor as an occupancy grid, with cells of 0.1 m.
fn mapped(agents: usize) -> Problem {
    let mut problem = searched::mapped_floor(agents, 10);
    problem.planner.states = 20_000;
    problem
}

#[divan::bench]
fn check_of_a_grid(bencher: Bencher) {
    let problem = mapped(2);
    bencher.bench_local(|| check(black_box(&problem)));
}

#[divan::bench(sample_count = 10)]
fn plan_on_a_grid(bencher: Bencher) {
    let problem = mapped(2);
    bencher.bench_local(|| plan(black_box(&problem), &Options::of(&problem)));
}

#[divan::bench]
fn validation_on_a_grid(bencher: Bencher) {
    let problem = mapped(2);
    if let Ok(found) = plan(&problem, &Options::of(&problem)) {
        bencher.bench_local(|| validate(black_box(&problem), &found.plan));
    }
}

/// The YAML and a PGM of 75,000 pixels.
#[divan::bench]
fn reading_of_a_grid(bencher: Bencher) {
    let yaml =
        "image: a.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n";
    let pixels: Vec<u8> = mapped(1)
        .occupancy
        .map_or(Vec::new(), |map| map.cells().iter().map(|cell| if *cell == Cell::Free { 254 } else { 0 }).collect());
    let image = [&b"P5 300 250 255\n"[..], &pixels].concat();
    bencher.bench_local(|| {
        let (file, image) = (MapFile::read(black_box(yaml)), Image::read(black_box(&image)));
        file.ok().zip(image.ok()).map(|(file, image)| OccupancyGrid::read(&file, &image))
    });
}
