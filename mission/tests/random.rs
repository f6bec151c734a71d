//! Random problems and their plans after events: every plan passes the validator, and every damage to a plan is
//! detected.

use crate::common;

use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::schedule::adapt::{Adaptation, Feedback, adapt};
use hierarq_mission::kinds::schedule::assistance::{Assistance, from_plan, to_plan};
use hierarq_mission::kinds::schedule::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::schedule::plan::{Actor, Phase, Plan};
use hierarq_mission::kinds::schedule::problem::{Absence, AgentKind, Distances, Problem, Scales};
use hierarq_mission::kinds::schedule::reallocate::{optimality_index, reallocate};
use hierarq_mission::kinds::schedule::reschedule::{Observed, reschedule};
use hierarq_mission::kinds::schedule::validate::{Rule, validate};
use hierarq_mission::plan::{Limit, Status};
use proptest::prelude::*;

fn quick(formulation: Option<Formulation>) -> Options {
    let budget = Budget { time: Duration::from_secs(20), nodes: 40, ..Budget::default() };
    Options { formulation, budget, ..Options::default() }
}

/// A random problem of few operations, optionally with uneven weights.
fn small(seed: u64, agents: usize, robots: usize, operations: usize, fixed: bool, uneven: bool) -> Problem {
    let mut problem = if fixed {
        common::fixed(seed, agents, robots, operations)
    } else {
        common::random(seed, agents, robots, operations)
    };
    if uneven {
        let mut random = common::Random(seed ^ 5);
        for agent in &mut problem.agents {
            agent.wait_weights = (0..operations).map(|_| random.within(0.0, 3.0)).collect();
            agent.approach_weights = (0..operations).map(|_| random.within(0.0, 3.0)).collect();
        }
    }
    problem
}

fn valid(problem: &Problem, plan: &Plan) -> Result<(), TestCaseError> {
    prop_assert_eq!(validate(problem, plan), Vec::new());
    prop_assert!(plan.status.bound().is_none_or(|bound| bound <= plan.cost));
    Ok(())
}

fn shown(problem: &Problem, schedule: &[Assistance]) -> Plan {
    let status = Status::Unbounded { stopped: None };
    to_plan(problem, schedule, status, "test".into(), Default::default())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn plans_pass_the_validator(
        seed in 0_u64..100_000, agents in 1_usize..4, robots in 1_usize..4, operations in 1_usize..3,
        fixed in any::<bool>(), uneven in any::<bool>(), parts in any::<bool>(),
    ) {
        let problem = small(seed, agents, robots, operations, fixed, uneven);
        prop_assert_eq!(problem.check(), Vec::new());
        let options = quick(parts.then_some(Formulation::Batches));
        let first = plan(&problem, &options).unwrap();
        valid(&problem, &first)?;
        prop_assert_eq!(&plan(&problem, &options).unwrap(), &first, "not the same plan");
        let text = serde_json::to_string(&first).unwrap();
        prop_assert_eq!(serde_json::from_str::<Plan>(&text).unwrap(), first);
    }

    #[test]
    fn subsets_and_the_position_form_bound_each_other(
        seed in 0_u64..100_000, agents in 1_usize..5, robots in 1_usize..4, share in 0.0_f64..0.6,
    ) {
        let problem = small(seed, agents, robots, 1, false, true);
        let first = plan(&problem, &quick(None)).unwrap();
        prop_assert_eq!(first.engine.as_str(), "subsets");
        // Before the start, and with some services in progress.
        let (later, _) = reschedule(
            &problem, &from_plan(&first).unwrap(), &problem, problem.start + share * first.end().unwrap(), &[],
        );
        for problem in [&problem, &later] {
            let subsets = plan(problem, &quick(Some(Formulation::Subsets))).unwrap();
            let position = plan(problem, &quick(Some(Formulation::Position))).unwrap();
            valid(problem, &subsets)?;
            let eps = 1e-9 * subsets.cost.abs().max(1e-9);
            prop_assert!(position.status.bound().is_none_or(|bound| bound <= subsets.cost + eps), "{position:?}");
            prop_assert!(subsets.status.bound().unwrap() <= position.cost + eps, "{} {}", subsets.cost, position.cost);
            prop_assert!(subsets.cost - subsets.status.bound().unwrap() <= 1.01e-4 * subsets.cost.abs());
        }
    }

    #[test]
    fn orders_and_the_position_form_bound_each_other(
        seed in 0_u64..100_000, agents in 1_usize..4, robots in 1_usize..4, operations in 1_usize..3,
        share in 0.0_f64..0.6, fixed in any::<bool>(), absent in any::<bool>(), makespan in 0.0_f64..2.0,
    ) {
        let mut problem = small(seed, agents, robots, operations, fixed, false);
        let mut random = common::Random(seed ^ 11);
        problem.weights.makespan = (makespan - 0.3).max(0.0);
        // Decreasing weights of waits, so that no wait gains by being long.
        for agent in &mut problem.agents {
            let first = random.within(0.0, 3.0);
            agent.wait_weights = (0..operations).map(|i| first / (1.0 + i as f64)).collect();
            agent.approach_weights = (0..operations).map(|_| random.within(0.0, 3.0)).collect();
        }
        if absent && robots > 1 {
            problem.absent = vec![Absence { robot: 0, until: Some(400.0) }];
        }
        let budget = Budget { time: Duration::from_secs(20), nodes: 4000, ..Budget::default() };
        let with = |formulation| Options { formulation: Some(formulation), budget, ..Options::default() };
        let first = plan(&problem, &with(Formulation::Orders)).unwrap();
        let (later, _) = reschedule(
            &problem, &from_plan(&first).unwrap(), &problem, problem.start + share * first.end().unwrap(), &[],
        );
        for problem in [&problem, &later] {
            let orders = plan(problem, &with(Formulation::Orders)).unwrap();
            let position = plan(problem, &quick(Some(Formulation::Position))).unwrap();
            valid(problem, &orders)?;
            let eps = 1e-7 * orders.cost.abs().max(1e-9);
            prop_assert!(position.status.bound().is_none_or(|bound| bound <= orders.cost + eps), "{position:?}");
            prop_assert!(orders.status.bound().unwrap() <= position.cost + eps, "{} {}", orders.cost, position.cost);
            prop_assert!(orders.cost - orders.status.bound().unwrap() <= 1.01e-4 * orders.cost.abs(), "{:?}", orders.status);
        }
    }

    #[test]
    fn without_time_there_is_a_plan_still(
        seed in 0_u64..100_000, agents in 1_usize..5, robots in 1_usize..4, operations in 1_usize..3, fixed in any::<bool>(),
    ) {
        let problem = small(seed, agents, robots, operations, fixed, false);
        let least = plan(&problem, &quick(None)).unwrap().cost;
        for formulation in [None, Some(Formulation::Position), Some(Formulation::Batches)] {
            let budget = Budget { time: Duration::ZERO, ..Budget::default() };
            let found = plan(&problem, &Options { formulation, budget, ..Options::default() }).unwrap();
            valid(&problem, &found)?;
            prop_assert!(found.status.bound().is_none_or(|bound| bound <= least * (1.0 + 1e-9)), "{formulation:?}");
            let by_time = match found.status {
                Status::Gap { stopped, .. } => stopped == Limit::Time,
                Status::Proven { .. } => true,
                Status::Unbounded { .. } => false,
            };
            prop_assert!(by_time, "{:?}", found.status);
        }
    }

    /// For fixed durations, loose or tight, all exact formulations find the same cost.
    #[test]
    fn fixed_durations_are_proven_alike(
        seed in 0_u64..100_000, agents in 2_usize..4, robots in 1_usize..4, operations in 2_usize..4, loose in 1.0_f64..8.0,
    ) {
        let mut problem = small(seed, agents, robots, operations, true, false);
        problem.agents.iter_mut().for_each(|who| who.duration.mean = (loose * who.duration.mean).round());
        let full = |formulation| Options { formulation, ..Options::default() };
        let chosen = plan(&problem, &full(None)).unwrap();
        valid(&problem, &chosen)?;
        let orders = plan(&problem, &full(Some(Formulation::Orders))).unwrap();
        prop_assert!(matches!(chosen.status, Status::Proven { .. }), "{:?}", chosen.status);
        prop_assert!((chosen.cost - orders.cost).abs() <= 1e-4 * orders.cost, "{} {}", chosen.cost, orders.cost);
    }

    /// At any confidence and any spread a plan is valid.
    #[test]
    fn confidences_near_certainty_are_valid(seed in 0_u64..100_000, tail in -6.0_f64..-0.1, sigma in -2.0_f64..5.5) {
        let mut problem = small(seed, 2, 1, 2, false, false);
        problem.confidence = 1.0 - 10_f64.powf(tail);
        for agent in &mut problem.agents {
            let sigma = 10_f64.powf(sigma);
            agent.duration = hierarq_mission::kinds::schedule::problem::Duration { mean: 1.0 + sigma, sigma };
        }
        if problem.check().is_empty() {
            let found = plan(&problem, &quick(Some(Formulation::Batches))).unwrap();
            valid(&problem, &found)?;
        }
    }

    /// The bound of batches never exceeds a proven cost, and exists even for uneven weights.
    #[test]
    fn batches_are_bounded(
        seed in 0_u64..100_000, agents in 1_usize..5, robots in 1_usize..3, operations in 1_usize..4, fixed in any::<bool>(),
        uneven in any::<bool>(),
    ) {
        let problem = small(seed, agents, robots, operations, fixed, uneven);
        let batches = plan(&problem, &quick(Some(Formulation::Batches))).unwrap();
        let best = plan(&problem, &quick(None)).unwrap();
        let bound = batches.status.bound().unwrap();
        prop_assert!(bound <= best.cost.min(batches.cost) * (1.0 + 1e-9), "{bound} {}", best.cost);
        prop_assert!(bound > 0.0 && bound >= 0.02 * best.cost, "{bound} {}", best.cost);
    }

    #[test]
    fn damage_is_caught(
        seed in 0_u64..100_000, agents in 2_usize..4, which in 0_usize..1000, kind in 0_usize..6, by in 0.01_f64..50.0,
    ) {
        let problem = small(seed, agents, 2, 1, false, false);
        let mut broken = plan(&problem, &quick(None)).unwrap();
        let at = which % broken.activities.len();
        let phase = broken.activities[at].phase;
        match kind {
            // A changed start or end, so that phases do not meet or a duration is wrong.
            0 => broken.activities[at].start += by,
            1 => broken.activities[at].end += by,
            2 => { broken.activities.remove(at); }
            3 => { let copy = broken.activities[at].clone(); broken.activities.push(copy); }
            4 => broken.activities[at].start = f64::NAN,
            _ => match broken.activities[at].actor {
                Actor::Robot(m) => broken.activities[at].actor = Actor::Robot(1 - m),
                Actor::Agent(a) => broken.activities[at].actor = Actor::Agent((a + 1) % agents),
            },
        }
        prop_assert!(!validate(&problem, &broken).is_empty(), "{kind} of {phase:?}");
    }

    #[test]
    fn what_happens_never_gives_a_plan_that_is_none(
        seed in 0_u64..100_000, agents in 1_usize..4, operations in 1_usize..3, fixed in any::<bool>(),
        steps in proptest::collection::vec((0.02_f64..0.5, 0_usize..3, 0.0_f64..400.0, -1.0_f64..1.0), 1..4),
    ) {
        let mut problem = small(seed, agents, 2, operations, fixed, false);
        let mut schedule = from_plan(&plan(&problem, &quick(None)).unwrap()).unwrap();
        let mut satisfied = vec![None; agents];
        for (share, what, delay, feeling) in steps {
            let end = schedule.iter().map(|s| s.times.end).fold(0.0, f64::max);
            let time = problem.start + share * (end - problem.start).max(0.0);
            let mut now = problem.clone();
            let at = &schedule[(delay as usize) % schedule.len()];
            let mut observed = Vec::new();
            match what {
                // A current operation takes longer, or has ended early.
                0 => observed.extend(schedule.iter().filter(|s| s.start < time && s.end > time).map(|s| Observed {
                    agent: s.agent, operation: s.operation, end: (s.end + delay * feeling).max(time),
                })),
                // An agent moves.
                1 if !fixed => {
                    now.agents[at.agent].place[0] += 10.0 * feeling;
                    now.agents[at.agent].place[1] -= delay / 100.0;
                }
                // A person gives feedback.
                _ => {
                    let feedback = Feedback {
                        agent: at.agent, operation: at.operation, robot: at.robot, speed: 0.15 * delay.max(100.0) / 400.0,
                        wait: feeling, approach: -feeling, distance: 0.5 * feeling,
                    };
                    if now.agents[at.agent].kind == AgentKind::Human {
                        let (next, state) =
                            adapt(&now, satisfied[at.agent], &feedback, &Adaptation::default()).unwrap();
                        satisfied[at.agent] = Some(state);
                        now = next;
                    }
                }
            }
            let (after, repaired) = reschedule(&problem, &schedule, &now, time, &observed);
            prop_assert_eq!(after.check(), Vec::new());
            valid(&after, &shown(&after, &repaired))?;
            let index = optimality_index((&problem, &schedule), (&after, &repaired));
            prop_assert!(index >= 0.0);
            if index > 0.1 {
                let fresh = reallocate(&after, &repaired, &quick(None)).unwrap();
                valid(&after, &fresh)?;
                let kept = shown(&after, &repaired).cost;
                prop_assert!(fresh.cost <= kept * (1.0 + 1e-9), "{} {}", fresh.cost, kept);
                schedule = from_plan(&fresh).unwrap();
            } else {
                schedule = repaired;
            }
            problem = after;
        }
    }
}

/// A robot that takes no service has no effect on the plan; one that takes services later leaves no earlier.
#[test]
fn a_robot_that_is_absent_is_done_without() {
    for seed in 0..4 {
        for (fixed, formulation) in [(true, None), (false, None), (true, Some(Formulation::Batches))] {
            let mut problem = small(seed, 3, 3, 1, fixed, false);
            problem.scales = Some(Scales::of(&problem));
            let mut fewer = problem.clone();
            fewer.robots.remove(0);
            if let Distances::Table(table) = &mut fewer.distances {
                table.remove(0);
            }
            let expected = plan(&fewer, &quick(formulation)).unwrap();
            problem.absent = vec![Absence { robot: 0, until: None }];
            let found = plan(&problem, &quick(formulation)).unwrap();
            assert_eq!(validate(&problem, &found), []);
            assert!((found.cost - expected.cost).abs() < 1e-9, "{} {}", found.cost, expected.cost);
            assert_eq!(found.of(Actor::Robot(0)).count(), 0);
            let until = 150.0;
            problem.absent = vec![Absence { robot: 0, until: Some(until) }, Absence { robot: 1, until: None }];
            let found = plan(&problem, &quick(formulation)).unwrap();
            assert_eq!(validate(&problem, &found), []);
            assert!(found.of(Actor::Robot(0)).all(|activity| activity.start >= until));
            problem.absent[0].until = Some(until + 1e5);
            assert!(validate(&problem, &found).iter().all(|broken| broken.rule == Rule::Absent));
        }
    }
}

/// Zero, or a number from tiny to beyond the maximum.
fn extreme() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 8 => (-6.0_f64..6.02).prop_map(|power| 10.0_f64.powf(power))]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn extreme_numbers_give_a_valid_plan_or_a_refusal(
        numbers in proptest::collection::vec(extreme(), 24), operations in 1_usize..3, formulation in 0_usize..6,
    ) {
        let mut problem = small(1, 2, 2, operations, formulation < 3, false);
        let mut next = numbers.iter().copied();
        let mut take = || next.next().unwrap_or(1.0);
        for robot in &mut problem.robots {
            robot.depot = [take(), -take()];
            if formulation >= 3 {
                robot.speed.low = take();
                robot.speed.high = robot.speed.low * (1.0 + take());
                robot.proximity = None;
            }
            (robot.serve, robot.deposit) = (take(), take());
            robot.energy.standby = take();
            robot.energy.drag = take();
        }
        for agent in &mut problem.agents {
            agent.place = [take(), take()];
            agent.duration.mean = take();
            agent.wait_distance = take();
            agent.wait_weights = vec![take(); operations];
        }
        problem.weights.makespan = take();
        let wanted = [
            Formulation::Subsets,
            Formulation::Constraint,
            Formulation::Batches,
            Formulation::Position,
            Formulation::Orders,
        ];
        let options = quick(wanted.get(formulation).copied());
        if let Ok(plan) = plan(&problem, &options) {
            valid(&problem, &plan)?;
        }
    }
}

#[test]
fn each_constraint_has_a_plan_that_breaks_it_alone() {
    let problem = small(3, 3, 2, 1, false, false);
    let good = plan(&problem, &quick(None)).unwrap();
    let rules = |change: &dyn Fn(&mut Vec<Assistance>)| {
        let mut schedule = from_plan(&good).unwrap();
        change(&mut schedule);
        let mut rules: Vec<Rule> =
            validate(&problem, &shown(&problem, &schedule)).iter().map(|violation| violation.rule).collect();
        rules.sort();
        rules.dedup();
        rules
    };
    assert_eq!(rules(&|_| ()), []);
    // One service 30 s before the end of its operation, and before the plan is made.
    let early = |s: &mut Vec<Assistance>| s[0].times = s[0].times.later(-(s[0].times.going + 30.0));
    assert!(rules(&early).contains(&Rule::Past));
    assert!(rules(&early).contains(&Rule::ServiceAfterOperation));
    let stretched = |s: &mut Vec<Assistance>| {
        s[0].end += 20.0;
        s[0].times = s[0].times.later(4000.0);
    };
    assert_eq!(rules(&stretched), [Rule::OperationTime]);
    let late = |s: &mut Vec<Assistance>| {
        s[1].start += 1.0;
        s[1].end += 1.0;
        s[1].times = s[1].times.later(4000.0);
    };
    assert_eq!(rules(&late), [Rule::FirstOperation]);
    let mut swapped = good.clone();
    for activity in swapped.activities.iter_mut().filter(|activity| activity.phase != Phase::Operation) {
        if let Some(speed) = &mut activity.speed {
            *speed *= 1.5;
        }
    }
    assert!(validate(&problem, &swapped).iter().all(|violation| violation.rule == Rule::Speed));
}
