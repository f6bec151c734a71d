//! Hidden objects of a search (srs section 5): beliefs against a naive computation, plans against the validator, executions
//! against the probabilities of the detection model.

use std::collections::BTreeMap;

use hierarq_mission::execution::{DiscreteEvents, Replan};
use hierarq_mission::kind::Run;
use hierarq_mission::kinds::search::Search;
use hierarq_mission::kinds::search::belief::{Undetected, posterior, prior};
use hierarq_mission::kinds::search::check::check;
use hierarq_mission::kinds::search::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::search::execution::{Event, LogEntry, SearchExecution};
use hierarq_mission::kinds::search::geometry::{Point, cross, distance, inside};
use hierarq_mission::kinds::search::plan::Phase;
use hierarq_mission::kinds::search::problem::{Detection, Hidden, Problem, Wall};
use hierarq_mission::kinds::search::validate::validate;

use crate::common::Random;
use crate::searched::{agent, grid, hidden, on_grid, problem, random, square, wall};

const SEES: Detection = Detection { within: 4.0, rate: 0.3 };

/// Two rooms with a door between them; the agents begin in the left one.
fn rooms(count: usize) -> Problem {
    let team = vec![agent("r", false, [1.0, 1.0], 1.0), agent("anna", true, [1.0, 5.0], 1.0)];
    let mut p = problem(vec![[0.0, 0.0], [12.0, 0.0], [12.0, 6.0], [0.0, 6.0]], team, Vec::new(), 120.0);
    p.walls.push(wall("low", &[[6.0, 0.0], [6.0, 2.4]]));
    p.walls.push(wall("high", &[[6.0, 3.6], [6.0, 6.0]]));
    p.agents.iter_mut().for_each(|who| who.sees = Some(SEES));
    p.objects.push(hidden("token", count, 10.0));
    p.planner.window = Some(40.0);
    p.planner.states = 1_500;
    p
}

/// A random world in which something is hidden.
fn hiding(seed: u64) -> Problem {
    let mut p = random(seed, 2, 2);
    let mut random = Random(seed.wrapping_mul(7_919).wrapping_add(3));
    random.unit();
    p.agents[0].sees = Some(Detection { within: random.within(1.5, 6.0), rate: random.within(0.05, 1.0) });
    if random.unit() < 0.7 {
        p.agents[1].sees = Some(Detection { within: random.within(1.5, 6.0), rate: random.within(0.05, 1.0) });
    }
    p.objects.push(hidden("cup", 1 + random.below(3), random.within(1.0, 20.0)));
    if random.unit() < 0.5 {
        let region = square(random.within(3.0, 5.0));
        p.objects.push(Hidden { region, ..hidden("key", 1, 5.0) });
    }
    p.cell = random.within(0.6, 1.2);
    if random.unit() < 0.5 {
        p.planner.window = Some(random.within(4.0, 12.0));
    }
    if let Some(wall) = p.walls.first_mut() {
        wall.transparent = random.unit() < 0.4;
    }
    (p.planner.states, p.planner.tree_nodes) = (800, 100);
    p
}

/// Cells of a naive grid with their middles, and whether two of them see one another.
fn naive(p: &Problem) -> (Vec<Point>, Vec<Vec<bool>>) {
    let [low, high] = p.bounds();
    let count = |axis: usize| ((high[axis] - low[axis]) / p.cell - 1e-9).ceil() as usize;
    let mut middles = Vec::new();
    for row in 0..count(1) {
        for column in 0..count(0) {
            let at = [low[0] + (column as f64 + 0.5) * p.cell, low[1] + (row as f64 + 0.5) * p.cell];
            if inside(at, &p.area) {
                middles.push(at);
            }
        }
    }
    let lines: Vec<[Point; 2]> = p
        .walls
        .iter()
        .filter(|wall| !wall.transparent)
        .flat_map(|wall| wall.points.windows(2).map(|two| [two[0], two[1]]).collect::<Vec<_>>())
        .collect();
    let sees = |a: &Point, b: &Point| !lines.iter().any(|[c, d]| cross(*a, *b, *c, *d));
    let rows = middles.iter().map(|a| middles.iter().map(|b| sees(a, b)).collect()).collect();
    (middles, rows)
}

#[test]
fn cells_see_one_another_unless_a_wall_is_between() {
    for seed in 0..40 {
        let p = hiding(seed);
        let (middles, rows) = naive(&p);
        let sight = p.sight();
        assert_eq!(sight.middles(), middles, "seed {seed}");
        let most = p.agents.iter().filter_map(|who| who.sees).map(|sees| sees.within).fold(0.0, f64::max);
        for (one, row) in rows.iter().enumerate() {
            for within in [0.5 * most, most] {
                let mut seen: Vec<u32> = sight.seen(one as u32, within).iter().map(|(_, cell)| *cell).collect();
                seen.sort_unstable();
                let near = |other: &usize| row[*other] && distance(middles[one], middles[*other]) <= within;
                let should: Vec<u32> = (0..middles.len()).filter(near).map(|other| other as u32).collect();
                assert_eq!(seen, should, "seed {seed}, cell {one}");
            }
        }
    }
}

/// (26) and (27) by hand: three cells in a row of four are looked at.
#[test]
fn the_belief_follows_bayes() {
    let mut p = problem(vec![[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]], vec![], vec![], 60.0);
    let token = hidden("token", 1, 10.0);
    p.objects.push(token.clone());
    let sight = p.sight();
    assert_eq!(prior(&sight, &token), [0.25; 4]);
    let exposure = [f64::ln(2.0), f64::ln(4.0), 0.0, f64::ln(2.0)];
    // Left are 1/2, 1/4, 1 and 1/2 of a quarter each.
    let sum = 0.5 + 0.25 + 1.0 + 0.5;
    let belief = posterior(&sight, &token, &exposure);
    for (is, should) in belief.iter().zip([0.5 / sum, 0.25 / sum, 1.0 / sum, 0.5 / sum]) {
        assert!((is - should).abs() < 1e-12, "{belief:?}");
    }
    // In a region the prior is zero elsewhere, and looking elsewhere changes nothing.
    let left = Hidden { region: vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], ..token };
    let belief = posterior(&sight, &left, &[0.0, 0.0, 3.0, 3.0]);
    assert_eq!(belief, [0.5, 0.5, 0.0, 0.0]);
}

/// The undetected weights do not depend on the order of looks, and weights that are detected and weights that are left add up.
#[test]
fn looks_take_what_they_detect() {
    for seed in 0..20 {
        let p = hiding(seed);
        let sight = p.sight();
        let mut random = Random(seed + 11);
        random.unit();
        let looks: Vec<(u32, f64)> =
            (0..12).map(|_| (random.below(sight.len()) as u32, random.within(0.0, 1.5))).collect();
        let within = p.agents[0].sees.unwrap().within;
        let run = |order: &mut dyn Iterator<Item = &(u32, f64)>| {
            let mut left = Undetected::of(&p);
            let all = left.sum;
            let got: f64 = order.map(|(seat, exposure)| left.look(&sight, *seat, within, *exposure)).sum();
            assert!(
                (got + left.sum - all).abs() < 1e-9 * all && (left.weights.iter().sum::<f64>() - left.sum).abs() < 1e-9
            );
            left.weights
        };
        let (one, other) = (run(&mut looks.iter()), run(&mut looks.iter().rev()));
        assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-12));
        // The naive update of each cell.
        let (middles, rows) = naive(&p);
        let mut exposed: BTreeMap<usize, f64> = BTreeMap::new();
        for (seat, exposure) in &looks {
            for cell in 0..middles.len() {
                if rows[*seat as usize][cell] && distance(middles[*seat as usize], middles[cell]) <= within {
                    *exposed.entry(cell).or_default() += exposure;
                }
            }
        }
        let exposure: Vec<f64> =
            (0..middles.len()).map(|cell| exposed.get(&cell).copied().unwrap_or_default()).collect();
        let all = Undetected::of(&p).weights;
        for cell in 0..middles.len() {
            assert!((one[cell] - all[cell] * (-exposure[cell]).exp()).abs() < 1e-12, "seed {seed}, cell {cell}");
        }
    }
}

#[test]
fn plans_are_valid_and_better_than_the_baselines() {
    let mut sums = [0.0; 3];
    let mut planned = 0;
    for seed in 0..60 {
        let p = hiding(seed);
        if !check(&p).is_empty() {
            continue;
        }
        planned += 1;
        for (formulation, sum) in Formulation::ALL.into_iter().zip(&mut sums) {
            let found = plan(&p, &Options { formulation, ..Options::of(&p) }).expect("a plan").plan;
            assert_eq!(validate(&p, &found), [], "seed {seed}, {formulation:?}");
            *sum -= found.cost;
        }
    }
    assert!(planned > 30, "{planned} worlds");
    assert!(sums[0] >= sums[1] && sums[0] >= sums[2], "tree search, greedy, independent: {sums:?}");
}

/// Each corruption of a plan is noticed.
#[test]
fn wrong_rewards_of_looking_are_refused() {
    let p = rooms(2);
    let found = plan(&p, &Options::of(&p)).expect("a plan").plan;
    assert!(found.activities.iter().any(|activity| activity.phase == Phase::Going));
    assert_eq!(validate(&p, &found), []);
    let mut dearer = found.clone();
    dearer.cost -= 1e-3;
    assert_ne!(validate(&p, &dearer), []);
    let mut blind = p.clone();
    blind.agents[0].sees = None;
    assert_ne!(validate(&blind, &found), []);
    let mut known = p.clone();
    known.exposure = vec![1.0; known.sight().len()];
    // If everything was looked at for as long, the belief is the same.
    assert_eq!(validate(&known, &found), []);
    known.exposure[40] = 9.0;
    assert_ne!(validate(&known, &found), []);
    let mut over = p.clone();
    over.objects[0].found = 2;
    assert_ne!(validate(&over, &found), []);
}

fn begun(problem: &Problem, seed: u64, replan: Replan) -> SearchExecution {
    let run = Run { replan, sampled: Some(seed), ..Run::default() };
    let settings = Search { problem: problem.clone() }.settings(&run);
    SearchExecution::new(problem.clone(), settings).expect("an execution")
}

/// An object in sight of an agent that stands still is found by the time `t` with the probability `1 - exp(-rate t)`.
#[test]
fn objects_are_found_as_the_detection_model_says() {
    let mut p = problem(square(3.0), vec![agent("r", false, [1.5, 1.5], 1.0)], Vec::new(), 60.0);
    p.agents[0].sees = Some(Detection { within: 9.0, rate: 0.1 });
    p.objects.push(hidden("token", 100, 1.0));
    (p.planner.states, p.planner.lookouts) = (100, 1);
    let mut counts = [0.0; 3];
    let times = [5.0, 10.0, 20.0];
    for seed in 0..10 {
        let mut run = begun(&p, seed, Replan::None);
        for (time, count) in times.into_iter().zip(&mut counts) {
            run.run_until(time);
            let found = run.secrets().iter().filter(|secret| secret.found.is_some()).count();
            assert_eq!(found, run.problem().objects[0].found);
            *count += found as f64;
        }
        assert!((run.explored(None) - (1.0 - f64::exp(-2.0))).abs() < 1e-9);
        assert_eq!(run.explored(None), run.explored(Some(0)));
    }
    for (time, count) in times.into_iter().zip(counts) {
        let share = 1.0 - f64::exp(-0.1 * time);
        let sigma = (1000.0 * share * (1.0 - share)).sqrt();
        assert!((count - 1000.0 * share).abs() < 4.0 * sigma, "after {time} s {count} of 1000");
    }
}

/// However time is cut, the same is found at the same times, and plans stay valid.
#[test]
fn steps_of_time_do_not_matter() {
    for seed in 0..4 {
        let p = rooms(3);
        let mut whole = begun(&p, seed, Replan::Both);
        whole.run_until(120.0);
        let mut cut = begun(&p, seed, Replan::Both);
        let mut random = Random(seed + 5);
        random.unit();
        let mut time = 0.0;
        while time < 120.0 {
            time = f64::min(120.0, time + random.within(0.01, 3.0));
            cut.run_until(time);
        }
        assert_eq!(whole.records(), cut.records(), "seed {seed}");
        assert_eq!(whole.secrets(), cut.secrets());
        assert!(whole.problem().objects[0].found > 0, "seed {seed}: nothing was found");
    }
}

/// The plan is extended behind its window, and is valid at each of its changes; the search is over when all is found.
#[test]
fn the_search_goes_on_until_everything_is_found() {
    let mut ends = Vec::new();
    for seed in 0..6 {
        let mut p = rooms(2);
        p.horizon = 400.0;
        for replan in [Replan::None, Replan::Both] {
            let mut run = begun(&p, seed, replan);
            let mut time = 0.0;
            while time < 400.0 && run.problem().is_searching() {
                time += 5.0;
                run.run_until(time);
                let now = run.present();
                if run.records().last().is_some_and(|last| last.time == time) {
                    assert_eq!(validate(&now, run.plan()), [], "seed {seed} at {time} s");
                }
            }
            assert_eq!(run.problem().objects[0].found, 2, "seed {seed}, {replan:?}");
            assert!(run.done(), "seed {seed}: nothing is left to do");
            let worth: f64 = run.secrets().iter().map(|of| 10.0 * (1.0 - of.found.unwrap() / 400.0)).sum();
            assert!((run.rewards().total - worth).abs() < 0.03, "{} instead of {worth}", run.rewards().total);
            assert_eq!(run.finds(0) + run.finds(1), 2);
            ends.push(time);
        }
    }
    assert!(ends.iter().sum::<f64>() / (ends.len() as f64) < 120.0, "it takes {ends:?} s");
}

/// A person who strays looks where the person truly is; the belief is that of the plan until the person is seen or finds
/// something.
#[test]
fn a_stray_looks_elsewhere_than_believed() {
    let mut p = rooms(1);
    p.objects[0].places = vec![[10.5, 5.5]];
    p.agents[1].sees = Some(Detection { within: 4.0, rate: 5.0 });
    p.agents[0].sees = None;
    let mut run = begun(&p, 1, Replan::Both);
    run.run_until(1.0);
    run.handle_event(Event::Strays { agent: 1, to: [9.0, 5.0] }).expect("a way");
    let before = run.problem().exposure.clone();
    run.run_until(4.0);
    let sight = p.sight();
    let believed = run.agent(1).expect("an agent").believed.at;
    let cell = sight.seat(believed).expect("a cell") as usize;
    assert!(run.problem().exposure[cell] > before.get(cell).copied().unwrap_or_default());
    run.run_until(20.0);
    assert_eq!(run.problem().objects[0].found, 1, "the person has found it");
    let found = run.records().iter().find(|r| matches!(r.what, LogEntry::Found { agent: 1, .. })).expect("a find");
    let view = run.agent(1).expect("an agent");
    assert!(found.time > 4.0 && distance(view.pose.at, view.believed.at) < 1e-9, "the others know where the person is");
}

#[test]
fn a_report_of_a_find_counts_once() {
    let p = rooms(2);
    let mut run = begun(&p, 3, Replan::Both);
    run.handle_event(Event::Found { object: 0 }).expect("a report");
    assert_eq!(run.problem().objects[0].found, 1);
    run.handle_event(Event::Found { object: 0 }).expect("a report");
    assert!(run.done() && !run.problem().is_searching());
    let again = run.handle_event(Event::Found { object: 0 }).map(|_| ());
    assert_eq!(again.unwrap_err().to_string(), "every token is found already");
    assert!(run.handle_event(Event::Found { object: 1 }).is_err());
}

/// Somebody who reports finds nothing by dice, and explores and changes the belief as everybody does.
#[test]
fn those_who_report_say_themselves_what_they_find() {
    let mut p = problem(square(3.0), vec![agent("anna", true, [1.5, 1.5], 1.0)], Vec::new(), 60.0);
    p.agents[0].sees = Some(Detection { within: 9.0, rate: 1.0 });
    p.objects.push(hidden("token", 5, 1.0));
    (p.planner.states, p.planner.lookouts) = (100, 1);
    let how = Run { reporting: vec![0], sampled: Some(1), ..Run::default() };
    let settings = Search { problem: p.clone() }.settings(&how);
    let mut run = SearchExecution::new(p, settings).expect("an execution");
    run.run_until(50.0);
    assert_eq!(run.problem().objects[0].found, 0);
    assert!(run.explored(None) > 0.99 && run.problem().exposure.iter().all(|x| *x > 40.0));
    run.handle_event(Event::Found { object: 0 }).expect("a report");
    assert_eq!(run.problem().objects[0].found, 1);
}

/// On occupancy grids the belief has free cells alone, sight ends at blocked ones, and plans are valid.
#[test]
fn blocked_cells_block_the_sight() {
    let mut planned = 0;
    for seed in 0..30 {
        let mut p = on_grid(grid(seed, 16, 12), seed);
        let map = p.occupancy.clone().unwrap();
        p.cell = 1.5 * map.resolution;
        p.agents.iter_mut().for_each(|who| who.sees = Some(Detection { within: 8.0 * map.resolution, rate: 0.4 }));
        p.objects.push(hidden("token", 1, 10.0));
        (p.planner.states, p.planner.lookouts) = (500, 8);
        let sight = p.sight();
        for (one, at) in sight.middles().iter().enumerate() {
            assert!(!map.is_blocked(map.index(*at)), "seed {seed}");
            for (_, other) in sight.seen(one as u32, 8.0 * map.resolution) {
                let to = sight.middles()[*other as usize];
                let point = |k: usize| {
                    let share = f64::from(k as u32) / 200.0;
                    [at[0] + share * (to[0] - at[0]), at[1] + share * (to[1] - at[1])]
                };
                // A line may touch the corner of a blocked cell.
                let inside = |p: &Point| map.to_cells(*p).iter().all(|x| (x - x.round()).abs() > 1e-6);
                let mut points = (0..=200).map(point).filter(inside);
                assert!(points.all(|p| !map.is_blocked(map.index(p))), "seed {seed}: {at:?} to {to:?}");
            }
        }
        if check(&p).is_empty() {
            planned += 1;
            let found = plan(&p, &Options::of(&p)).expect("a plan").plan;
            assert_eq!(validate(&p, &found), [], "seed {seed}");
        }
    }
    assert!(planned > 10, "{planned} maps");
}

#[test]
fn glass_hides_nothing() {
    let pane = |transparent: bool| Wall { transparent, ..wall("pane", &[[2.0, 0.0], [2.0, 4.0]]) };
    for transparent in [true, false] {
        let mut p = problem(square(4.0), vec![agent("r", false, [1.0, 1.0], 1.0)], Vec::new(), 60.0);
        p.agents[0].sees = Some(Detection { within: 9.0, rate: 1.0 });
        p.objects.push(hidden("token", 1, 10.0));
        p.walls.push(pane(transparent));
        let sight = p.sight();
        let count = sight.seen(sight.seat([1.0, 1.0]).unwrap(), 9.0).len();
        assert_eq!(count, if transparent { 16 } else { 8 });
        // A copy with other walls does not see through the old ones.
        p.walls[0].transparent = !transparent;
        assert_eq!(p.sight().seen(0, 9.0).len(), if transparent { 8 } else { 16 });
    }
}
