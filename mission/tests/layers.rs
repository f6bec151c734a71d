//! Layered plans: tiny problems against enumeration, the formulations against each other, random problems and their
//! plans after events against the validator.

use crate::layered;

use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::layers::choose::{Formulation, Options, Refusal, plan};
use hierarq_mission::kinds::layers::cost::cost;
use hierarq_mission::kinds::layers::plan::Plan;
use hierarq_mission::kinds::layers::problem::{Begun, Body, Problem};
use hierarq_mission::kinds::layers::steps::{Step, from_plan};
use hierarq_mission::kinds::layers::validate::{Rule, validate};
use hierarq_mission::plan::Status;
use proptest::prelude::*;

fn options(formulation: Formulation) -> Options {
    let budget = Budget { time: Duration::from_secs(60), nodes: 20_000, gap: 1e-6 };
    Options { formulation: Some(formulation), batch: Some(2), budget, ..Options::default() }
}

/// Minimum cost by enumeration of agents and objects for all tasks, with a ternary search over the length of each
/// layer. Shares the data types and the cost of steps with the planners, but no algorithm.
fn brute(problem: &Problem) -> f64 {
    let mut steps: Vec<Step> = problem.begun.iter().map(Begun::step).collect();
    let open: Vec<usize> = (0..problem.tasks.len()).filter(|task| problem.begun_of(*task).is_none()).collect();
    let mut best = f64::INFINITY;
    every(problem, &open, &mut steps, &mut best);
    best
}

fn every(problem: &Problem, open: &[usize], steps: &mut Vec<Step>, best: &mut f64) {
    let Some((&task, rest)) = open.split_first() else {
        let timed = timed(problem, steps);
        *best = best.min(cost(problem, &timed).total());
        return;
    };
    let objects: Vec<Option<usize>> = match problem.tasks[task].needs_object() {
        true => (0..problem.objects.len()).filter(|object| problem.suits(task, *object)).map(Some).collect(),
        false => vec![None],
    };
    for object in objects {
        if object.is_some() && steps.iter().any(|step| step.object == object) {
            continue;
        }
        for agent in 0..problem.agents.len() {
            if problem.able(agent, task, object) {
                steps.push(Step { task, agent, object, speed: 1.0, start: 0.0, end: 0.0, begun: false });
                every(problem, rest, steps, best);
                steps.pop();
            }
        }
    }
}

/// Returns the steps with optimal times: layer by layer, the length of minimum cost.
fn timed(problem: &Problem, steps: &[Step]) -> Vec<Step> {
    let mut steps = steps.to_vec();
    let mut begin = problem.start;
    for layer in 0..problem.layers.len() {
        let here: Vec<usize> = (0..steps.len()).filter(|s| problem.tasks[steps[*s].task].layer == layer).collect();
        if here.iter().any(|s| !steps[*s].begun) {
            let fill = |length: f64| filled(problem, &steps, &here, begin, length);
            let shortest = fill(0.0).iter().map(|step| step.end).fold(begin, f64::max) - begin;
            // Cost of a length: this layer ends the mission, so that the makespan counts.
            let price = |length: f64| {
                let done: Vec<Step> =
                    fill(length).into_iter().filter(|step| problem.tasks[step.task].layer <= layer).collect();
                cost(problem, &done).total()
            };
            let (mut low, mut high) = (shortest, shortest + 500.0);
            for _ in 0..100 {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if price(a) <= price(b) { high = b } else { low = a }
            }
            steps = fill(low);
        }
        begin = here.iter().map(|s| steps[*s].end).fold(begin, f64::max);
    }
    steps
}

/// Times a layer of this length, or the minimum longer one that its greatest speeds need: each robot uses the lowest
/// useful speed.
fn filled(problem: &Problem, steps: &[Step], here: &[usize], begin: f64, length: f64) -> Vec<Step> {
    let mut steps = steps.to_vec();
    for (agent, who) in problem.agents.iter().enumerate() {
        let busy = steps.iter().filter(|step| step.begun && step.agent == agent).map(|step| step.end);
        let mut at = busy.fold(begin, f64::max);
        let own: Vec<usize> = here.iter().copied().filter(|s| steps[*s].agent == agent && !steps[*s].begun).collect();
        let skill = |s: &usize| who.skill(&problem.tasks[steps[*s].task].action).unwrap();
        let way = |s: &usize| problem.distance(agent, steps[*s].task, steps[*s].object);
        let constant: f64 = own.iter().map(|s| skill(s).duration).sum();
        let ways: f64 = own.iter().map(way).sum();
        let speed_of = |s: &usize| match who.body {
            Body::Human { .. } => problem.pace(who, skill(s), problem.mass(steps[*s].object)).unwrap(),
            Body::Robot { speed, energy } => {
                let least = if energy.drag > 0.0 { (energy.standby / energy.drag).sqrt() } else { f64::INFINITY };
                let left = begin + length - at - constant;
                let needed = if left > 0.0 { ways / left } else { f64::INFINITY };
                let weighted = problem.weights.energy > 0.0;
                if weighted { least.max(needed).clamp(speed.low, speed.high) } else { speed.high }
            }
        };
        let times: Vec<(f64, f64)> =
            own.iter().map(|s| (speed_of(s), skill(s).duration + way(s) / speed_of(s))).collect();
        for (s, (speed, time)) in own.iter().zip(times) {
            let step = &mut steps[*s];
            (step.speed, step.start, step.end) = (speed, at, at + time);
            at += time;
        }
    }
    steps
}

/// Returns the problem if it can be planned.
fn possible(problem: Problem) -> Option<Problem> {
    problem.check().is_empty().then_some(problem)
}

/// Returns the problem at this time: the steps of a plan that have begun by then are fixed.
fn later(problem: &Problem, plan: &Plan, time: f64) -> Problem {
    let mut rest = Problem { start: time, begun: vec![], ..problem.clone() };
    for step in from_plan(plan).iter().filter(|step| step.start <= time) {
        let Step { task, agent, object, speed, start, end, .. } = *step;
        rest.begun.push(Begun { task, agent, object, speed, start, end });
    }
    rest
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 3e-6 * (1.0 + b.abs())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn without_time_there_is_a_plan_still(seed in 0_u64..100_000, tasks in 1_usize..9, objects in 3_usize..9) {
        let Some(problem) = possible(layered::random(seed, tasks, objects, 3, 1)) else { return Ok(()) };
        let least = plan(&problem, &Options::default()).unwrap().cost;
        for formulation in [None, Some(Formulation::Batches), Some(Formulation::Mixed)] {
            let budget = Budget { time: std::time::Duration::ZERO, ..Budget::default() };
            let found = plan(&problem, &Options { formulation, budget, ..Options::default() }).unwrap();
            prop_assert_eq!(validate(&problem, &found), vec![]);
            prop_assert!(found.status.bound().is_none_or(|bound| bound <= least * (1.0 + 1e-9)), "{:?}", found.status);
        }
    }

    #[test]
    fn the_best_of_all_is_found(seed in 0_u64..100_000, tasks in 1_usize..4, objects in 3_usize..6, humans in 0_usize..2) {
        let Some(problem) = possible(layered::random(seed, tasks, objects, 2, humans)) else { return Ok(()) };
        let best = brute(&problem);
        for formulation in [Formulation::Branch, Formulation::Mixed] {
            let found = plan(&problem, &options(formulation)).unwrap();
            prop_assert_eq!(validate(&problem, &found), vec![]);
            prop_assert!(near(found.cost, best), "{:?}: {} and {}", formulation, found.cost, best);
            prop_assert!(matches!(found.status, Status::Proven { bound } if bound <= found.cost), "{:?}", found.status);
        }
    }

    #[test]
    fn the_best_rest_is_found(seed in 0_u64..100_000, share in 0.0_f64..1.0, late in 0.0_f64..10.0) {
        let Some(problem) = possible(layered::random(seed, 4, 6, 2, 1)) else { return Ok(()) };
        let whole = plan(&problem, &options(Formulation::Branch)).unwrap();
        let mut rest = later(&problem, &whole, share * whole.end().unwrap());
        // Current tasks take longer than planned.
        let now = rest.start;
        for begun in rest.begun.iter_mut().filter(|begun| begun.end > now) {
            begun.end += late;
        }
        prop_assert_eq!(rest.check(), vec![]);
        let best = brute(&rest);
        let found = plan(&rest, &options(Formulation::Branch)).unwrap();
        prop_assert_eq!(validate(&rest, &found), vec![]);
        prop_assert!(near(found.cost, best), "{} and {}", found.cost, best);
    }

    #[test]
    fn batches_are_plans_and_bounds_are_below(seed in 0_u64..100_000, tasks in 4_usize..12, robots in 1_usize..4) {
        let Some(problem) = possible(layered::random(seed, tasks, 14, robots, 1)) else { return Ok(()) };
        let parts = plan(&problem, &options(Formulation::Batches)).unwrap();
        prop_assert_eq!(validate(&problem, &parts), vec![]);
        let some = Options { budget: Budget { nodes: 300, ..Budget::default() }, ..options(Formulation::Branch) };
        let best = plan(&problem, &some).unwrap();
        prop_assert_eq!(validate(&problem, &best), vec![]);
        prop_assert_eq!(&plan(&problem, &some).unwrap(), &best, "not the same plan");
        for (bound, above) in [(&parts, &best), (&best, &parts), (&best, &best)] {
            prop_assert!(bound.status.bound().unwrap() <= above.cost * (1.0 + 1e-9));
        }
        let text = serde_json::to_string(&best).unwrap();
        prop_assert_eq!(serde_json::from_str::<Plan>(&text).unwrap(), best);
    }

    #[test]
    fn what_has_begun_stays_when_an_agent_is_lost(seed in 0_u64..100_000, share in 0.0_f64..1.0, lost in 0_usize..4) {
        let Some(problem) = possible(layered::random(seed, 8, 12, 3, 1)) else { return Ok(()) };
        let whole = plan(&problem, &options(Formulation::Batches)).unwrap();
        let mut rest = later(&problem, &whole, share * whole.end().unwrap());
        rest.agents[lost].lost = true;
        let some = Options { budget: Budget { nodes: 200, ..Budget::default() }, ..options(Formulation::Branch) };
        match plan(&rest, &some) {
            Ok(found) => {
                prop_assert_eq!(validate(&rest, &found), vec![]);
                let new = from_plan(&found).into_iter().filter(|step| !step.begun);
                prop_assert!(new.into_iter().all(|step| step.agent != lost && step.start >= rest.start));
            }
            Err(Refusal::Problem(mistakes)) => prop_assert!(!mistakes.is_empty()),
            Err(other) => prop_assert!(false, "{}", other),
        }
    }

    #[test]
    fn damage_is_caught(seed in 0_u64..100_000, which in 0_usize..1000, kind in 0_usize..8, by in 0.01_f64..50.0) {
        let Some(problem) = possible(layered::random(seed, 6, 9, 2, 1)) else { return Ok(()) };
        let mut broken = plan(&problem, &options(Formulation::Batches)).unwrap();
        let at = which % broken.activities.len();
        let activity = &mut broken.activities[at];
        match kind {
            0 => activity.end -= by,
            1 => activity.start += by,
            2 => activity.start = -by,
            3 => activity.speed = activity.speed.map_or(Some(1.0), |speed| Some(speed + by)),
            4 => activity.agent = 7,
            5 => broken.cost += by,
            6 => drop(broken.activities.remove(at)),
            _ => {
                let again = broken.activities[at].clone();
                broken.activities.push(again);
            }
        }
        prop_assert!(!validate(&problem, &broken).is_empty());
    }
}

#[test]
fn each_rule_is_told() {
    let problem = layered::letter_h(1);
    let good = plan(&problem, &options(Formulation::Batches)).unwrap();
    assert_eq!(validate(&problem, &good), vec![]);
    let told = |change: &dyn Fn(&mut Plan)| {
        let mut broken = good.clone();
        change(&mut broken);
        validate(&problem, &broken).into_iter().map(|violation| violation.rule).collect::<Vec<_>>()
    };
    let first =
        |plan: &Plan, layer: usize| plan.activities.iter().position(|a| problem.tasks[a.task].layer == layer).unwrap();
    let earlier = |plan: &mut Plan| {
        let at = first(plan, 4);
        let activity = &mut plan.activities[at];
        let length = activity.end - activity.start;
        (activity.start, activity.end) = (0.0, length);
    };
    assert!(told(&earlier).contains(&Rule::Layers));
    let same = |plan: &mut Plan| {
        let (a, b) = (first(plan, 0), first(plan, 1));
        plan.activities[b].object = plan.activities[a].object;
    };
    assert!(told(&same).contains(&Rule::ObjectOnce));
    let long = problem.objects.iter().position(|thing| thing.features.contains("parallelepiped"));
    let other = |plan: &mut Plan| {
        let at = first(plan, 0);
        plan.activities[at].object = long;
    };
    assert!(told(&other).contains(&Rule::Object));
    let none = |plan: &mut Plan| {
        let at = first(plan, 0);
        plan.activities[at].object = None;
    };
    assert!(told(&none).contains(&Rule::Object));
    assert!(told(&|plan| plan.cost *= 1.01).contains(&Rule::Cost));
    assert!(told(&|plan| plan.members[0].push('x')).contains(&Rule::Form));
    assert!(told(&|plan| plan.activities.truncate(3)).contains(&Rule::Once));
    let mut weak = problem.clone();
    weak.agents[0].payload = Some(0.0);
    weak.agents[1].payload = Some(0.0);
    assert!(validate(&weak, &good).iter().any(|violation| violation.rule == Rule::Able));
}

/// The weights of the thesis assign light blocks to people and heavy ones to robots (6.4.5).
#[test]
fn letter_h_is_proven_and_people_take_the_light_blocks() {
    let problem = layered::letter_h(1);
    let best = plan(&problem, &Options::default()).unwrap();
    assert_eq!(validate(&problem, &best), vec![]);
    assert!(matches!(best.status, Status::Proven { .. }), "{:?}", best.status);
    let mass = |human: bool| {
        let of = from_plan(&best).into_iter().filter(|s| problem.agents[s.agent].is_human() == human);
        let masses: Vec<f64> = of.filter_map(|step| problem.mass(step.object)).collect();
        masses.iter().sum::<f64>() / masses.len() as f64
    };
    assert!(mass(true) < mass(false), "{} and {}", mass(true), mass(false));
    let parts = plan(&problem, &Options { formulation: Some(Formulation::Batches), ..Options::default() }).unwrap();
    assert!(parts.cost >= best.cost * (1.0 - 1e-4) && parts.cost <= 1.1 * best.cost);
}
