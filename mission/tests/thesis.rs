//! Numbers of the thesis and values computed by hand: Table 5.4, Algorithms 2, 3 and 5, (5.16) to (5.19), the scales.

use crate::common;

use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::schedule::adapt::{Adaptation, Feedback, NoFeedback, Satisfaction, adapt, efficiency};
use hierarq_mission::kinds::schedule::adaptation_index::{Quantity, adaptation_index};
use hierarq_mission::kinds::schedule::assistance::{Assistance, from_plan};
use hierarq_mission::kinds::schedule::choose::{Options, choose, plan};
use hierarq_mission::kinds::schedule::cost::{cost, wait};
use hierarq_mission::kinds::schedule::duration_quantile::quantile;
use hierarq_mission::kinds::schedule::problem::{AgentKind, Duration, Problem, Scales};
use hierarq_mission::kinds::schedule::reallocate::optimality_index;
use hierarq_mission::kinds::schedule::reschedule::{Observed, reschedule};
use hierarq_mission::kinds::schedule::validate::validate;
use hierarq_mission::numbers::Range;
use hierarq_mission::plan::Status;
use rand_distr::{Distribution, Normal};

fn near(a: f64, b: f64, by: f64) {
    assert!((a - b).abs() <= by, "{a} is not {b}");
}

/// Table 5.4: fraction of operations within the planned duration, for agents of means 250 + 10 a, against the
/// confidence.
#[test]
fn planned_durations_suffice_as_often_as_wanted() {
    let mut generator = rand_pcg::Pcg64::new(5, 4);
    for confidence in [0.6, 0.7, 0.8, 0.9, 0.95, 0.99] {
        let (mut enough, mut count) = (0, 0);
        for a in 1..=4 {
            let mean = 250.0 + 10.0 * f64::from(a);
            let duration = Duration { mean, sigma: 0.1 * mean };
            let planned = quantile(duration, confidence);
            let normal = Normal::new(mean, 0.1 * mean).unwrap();
            for _ in 0..2000 {
                enough += usize::from(normal.sample(&mut generator) <= planned);
                count += 1;
            }
        }
        near(enough as f64 / count as f64, confidence, 0.03);
    }
}

/// Scales and terms of the cost of one service, computed by hand.
#[test]
fn the_cost_of_one_service_is_what_the_equations_say() {
    let mut problem = Problem::new(
        vec![common::robot("m", [0.0, 0.0], 1.0)],
        vec![common::agent("h", AgentKind::Human, [3.0, 4.0], 1, 100.0)],
    );
    problem.agents[0].duration.sigma = 0.0;
    // l^d = 5, l^p = 1, l^g = 4; speeds 0.05 to 0.2, near 0.05 (clamped from 0.04) to 0.15.
    let scales = Scales::of(&problem);
    near(scales.makespan, 10.0 / 0.05 + 30.0, 1e-9);
    near(scales.wait, 5.0 / 0.05, 1e-9);
    // rho = 1, 20, 400: l / 0.05 + 20 l + 400 * 0.2 l = 120 l.
    for (scale, length) in scales.energy.into_iter().zip([4.0, 1.0, 5.0]) {
        near(scale, 120.0 * length, 1e-9);
    }
    let plan = plan(&problem, &Options::default()).unwrap();
    let schedule = from_plan(&plan).unwrap();
    let parts = cost(&problem, &schedule);
    let times = schedule[0].times;
    // The operation takes longer than the approach to the agent, so that both legs use the speed of least energy: 0.05
    // m/s.
    near(times.waiting - times.going, 80.0, 0.1);
    near(parts.human_wait, (times.serving - 100.0) / 100.0, 1e-9);
    near(parts.makespan, times.end / scales.makespan, 1e-9);
    near(parts.going, (80.0 + 80.0 + 400.0 * 16.0 / 80.0) / 480.0 / 3.0, 1e-5);
    assert_eq!(parts.worker_wait, 0.0);
}

#[test]
fn a_small_mission_is_planned_exactly_and_a_large_one_in_batches() {
    let options = Options::default();
    for (problem, word) in [
        (common::vineyard(1), "Subsets"),
        (common::vineyard(2), "Orders"),
        (common::vineyard(3), "Orders"),
        (common::vineyard(4), "Batches"),
        (common::fixed(0, 10, 2, 1), "Subsets"),
        (common::fixed(0, 3, 2, 2), "Orders"),
        (common::fixed(0, 3, 4, 4), "Constraint"),
        (common::fixed(0, 4, 2, 4), "Batches"),
        (common::random(0, 14, 2, 1), "Subsets"),
        (common::random(0, 15, 2, 1), "Batches"),
    ] {
        let choice = choose(&problem, &options).unwrap();
        assert_eq!(format!("{:?}", choice.formulation), word);
        assert!(!choice.why.is_empty());
    }
}

/// 5.A: four agents with two or three services each, speeds as decisions, are proven.
#[test]
fn the_vineyard_is_proven() {
    for operations in [2, 3] {
        let problem = common::vineyard(operations);
        let budget = Budget { time: std::time::Duration::from_secs(120), ..Budget::default() };
        let plan = plan(&problem, &Options { budget, ..Options::default() }).unwrap();
        assert!(matches!(plan.status, Status::Proven { .. }), "{:?}", plan.status);
        assert_eq!(validate(&problem, &plan), []);
    }
}

/// Table 5.6: batches of four cost at most 2 % more than the optimum.
#[test]
fn batches_are_close_to_the_optimum() {
    for seed in 0..4 {
        for agents in 5..=9 {
            let problem = common::fixed(seed, agents, 2, 1);
            let best = plan(&problem, &Options::default()).unwrap();
            let formulation = Some(hierarq_mission::kinds::schedule::choose::Formulation::Batches);
            let parts = plan(&problem, &Options { formulation, ..Options::default() }).unwrap();
            assert!(best.cost <= parts.cost + 1e-9 && parts.cost <= 1.02 * best.cost, "{} {}", best.cost, parts.cost);
        }
    }
}

fn feedback(robot: usize, speed: f64, approach: f64) -> Feedback {
    Feedback { agent: 0, operation: 0, robot, speed, wait: 0.0, approach, distance: 0.0 }
}

fn speeds(problem: &Problem, robot: usize) -> Range {
    problem.approach(&problem.agents[0], robot).0
}

/// Algorithm 2 on the vineyard: robots of factors 0.75 and 1, near speeds 0.05 (clamped) to 0.15, cruising 0.05 to 0.2.
#[test]
fn speeds_follow_algorithm_2() {
    let problem = common::vineyard(3);
    let constants = Adaptation::default();
    // Faster, served by the lighter robot at the greatest speed: 1.5 * 0.15 is limited to 0.2; the heavier one gets
    // 0.75 of the increase.
    let (faster, _) = adapt(&problem, None, &feedback(0, 0.15, 0.5), &constants).unwrap();
    near(speeds(&faster, 0).high, 0.2, 1e-12);
    near(speeds(&faster, 0).low, 0.075, 1e-12);
    near(speeds(&faster, 1).high, 0.2, 1e-12);
    near(speeds(&faster, 1).low, 0.05 * 1.375, 1e-12);
    let (faster, _) = adapt(&problem, None, &feedback(0, 0.15, 0.2), &constants).unwrap();
    near(speeds(&faster, 0).high, 0.18, 1e-12);
    near(speeds(&faster, 1).high, 0.15 * 1.15, 1e-12);
    // Served below the greatest speed: only the weights change.
    let (weights, _) = adapt(&problem, None, &feedback(0, 0.1, 0.5), &constants).unwrap();
    assert_eq!(speeds(&weights, 0), speeds(&problem, 0));
    // Slower: a larger change for the heavier robot.
    let (slower, _) = adapt(&problem, None, &feedback(0, 0.15, -0.3), &constants).unwrap();
    near(speeds(&slower, 0).high, 0.15 * 0.7, 1e-12);
    near(speeds(&slower, 1).high, 0.15 * 0.6, 1e-12);
    near(speeds(&slower, 0).low, 0.05, 1e-12);
    // So much slower that the range would vanish: c_eps keeps it open.
    let (slowest, _) = adapt(&problem, None, &feedback(1, 0.15, -1.0), &constants).unwrap();
    near(speeds(&slowest, 1).high, 0.05 * 1.01, 1e-12);
    // Neutral feedback changes nothing.
    let (same, _) = adapt(&problem, None, &feedback(0, 0.15, 0.0), &constants).unwrap();
    assert_eq!(same.agents[0].approaches, problem.agents[0].approaches);
}

/// (5.16), (5.17) with the weighted satisfaction, the satisfaction dynamics, (5.18).
#[test]
fn weights_and_distances_follow_the_equations() {
    let problem = common::vineyard(3);
    near(efficiency(&problem, 0), 1.0, 1e-12);
    near(efficiency(&problem, 1), 204.0 / 275.0, 1e-12);
    let said = Feedback { agent: 1, operation: 0, robot: 0, speed: 0.1, wait: -0.5, approach: 0.2, distance: 0.4 };
    let (next, state) = adapt(&problem, None, &said, &Adaptation::default()).unwrap();
    assert_eq!(state, Satisfaction { wait: -0.5, approach: 0.2 });
    let priority = 204.0 / 275.0 + 0.75;
    for k in 1..3 {
        near(next.wait_weight(1, k), 1.0 - 0.5 * priority, 1e-12);
        near(next.approach_weight(1, k), 1.0 - 0.2 * priority, 1e-12);
    }
    assert_eq!((next.wait_weight(1, 0), next.approach_weight(1, 0)), (1.0, 1.0));
    // Robot 2 is 4/3 as massive as robot 1: it keeps 4/3 of the additional distance, and comes closer by 3/4.
    near(next.approach(&next.agents[1], 0).1, 1.4, 1e-12);
    near(next.approach(&next.agents[1], 1).1, 1.0 + 0.4 * 4.0 / 3.0, 1e-12);
    let closer = Feedback { operation: 1, wait: -1.0, approach: 0.0, distance: -0.8, ..said };
    let (last, state) = adapt(&next, Some(state), &closer, &Adaptation::default()).unwrap();
    near(state.wait, -0.75, 1e-12);
    near(state.approach, 0.1, 1e-12);
    near(last.wait_weight(1, 2), 0.0, 1e-12);
    near(last.approach(&last.agents[1], 0).1, 0.6, 1e-12);
    near(last.approach(&last.agents[1], 1).1, 1.0 + 0.4 * 4.0 / 3.0 - 0.8 * 0.75, 1e-12);
    let nobody = Feedback { agent: 3, ..said };
    assert_eq!(adapt(&last, None, &nobody, &Adaptation::default()).unwrap_err(), NoFeedback::NoPerson { agent: 3 });
}

#[test]
fn the_adaptation_index_follows_algorithm_5() {
    // With changes relative to the larger value. The wait was too short (f = -0.5), from 13.7 s to 269.5 s.
    near(adaptation_index(1.0, Quantity::Wait, -0.5, 13.7, 269.5), 1.0 + 2.0 * 255.8 / 269.5, 1e-12);
    // The wait was too long (f = 0.5), from 245.3 s to 20.5 s.
    near(adaptation_index(1.0, Quantity::Wait, 0.5, 245.3, 20.5), 1.0 + 2.0 * 224.8 / 245.3, 1e-12);
    near(adaptation_index(1.0, Quantity::Wait, 0.5, 20.5, 245.3), 1.0 - 2.0 * 224.8 / 245.3, 1e-12);
    near(adaptation_index(2.0, Quantity::Speed, 1.0, 0.1, 0.125), 2.2, 1e-12);
    near(adaptation_index(2.0, Quantity::Speed, -1.0, 0.1, 0.125), 1.8, 1e-12);
    near(adaptation_index(2.0, Quantity::Speed, -1.0, 0.125, 0.1), 2.2, 1e-12);
    // A change to zero counts as much as one from zero.
    near(adaptation_index(1.0, Quantity::Wait, 1.0, 40.0, 0.0), 2.0, 1e-12);
    near(adaptation_index(1.0, Quantity::Wait, 1.0, 0.0, 40.0), 0.0, 1e-12);
    assert_eq!(adaptation_index(1.5, Quantity::Wait, 1.0, 0.0, 0.0), 1.5);
    for (feedback, after) in [(0.0, 5.0), (1.0, 3.0)] {
        assert_eq!(adaptation_index(1.5, Quantity::Wait, feedback, 3.0, after), 1.5);
    }
}

fn planned(problem: &Problem) -> Vec<Assistance> {
    from_plan(&plan(problem, &Options::default()).unwrap()).unwrap()
}

/// Algorithm 3, agent slower than planned: the robot stays at its waiting place, and approaches at the planned speed
/// after the end of the operation.
#[test]
fn a_late_operation_is_waited_for() {
    let problem = common::vineyard(1);
    let schedule = planned(&problem);
    let at = schedule[0];
    let time = at.end - 30.0;
    let late = at.times.serving + 40.0;
    let observed = [Observed { agent: 0, operation: 0, end: late }];
    let (after, repaired) = reschedule(&problem, &schedule, &problem, time, &observed);
    let now = repaired[0];
    assert_eq!(now.end, late);
    assert_eq!(now.robot, at.robot);
    let approach = at.times.serving - at.times.proximity;
    assert!(at.times.proximity > time);
    near(now.times.proximity, late, 1e-9);
    near(now.times.serving, late + approach, 1e-9);
    // Assignment and order stay, and nothing is earlier.
    for (was, is) in schedule.iter().zip(&repaired) {
        assert_eq!(was.robot, is.robot);
        assert!(is.times.serving >= was.times.serving - 1e-9 && is.times.end >= was.times.end - 1e-9);
    }
    let index = optimality_index((&problem, &schedule), (&after, &repaired));
    assert!(index > 0.0 && index.is_finite(), "{index}");
}

/// Without events the schedule does not change, and the index is 0.
#[test]
fn a_plan_that_fits_stays() {
    let problem = common::vineyard(2);
    let schedule = planned(&problem);
    for time in [0.0, 100.0, 400.0, 900.0] {
        let (after, repaired) = reschedule(&problem, &schedule, &problem, time, &[]);
        for (was, is) in schedule.iter().zip(&repaired) {
            for (a, b) in was.times.instants().into_iter().zip(is.times.instants()) {
                let can_leave_later = b >= a - 1e-6;
                assert!(can_leave_later, "{time}: {was:?} {is:?}");
            }
            near(was.times.serving, is.times.serving, 1e-6);
            near(was.times.end, is.times.end, 1e-6);
        }
        near(optimality_index((&problem, &schedule), (&after, &repaired)), 0.0, 1e-6);
    }
}

/// 5.B: a person who found the wait too long waits no longer after the next operation than a person without that
/// feedback.
#[test]
fn a_wait_that_was_too_long_weighs_more() {
    let problem = common::random(4, 2, 1, 2);
    let mut problem = Problem { scales: Some(Scales::of(&problem)), ..problem };
    problem.agents.iter_mut().for_each(|who| who.kind = AgentKind::Human);
    let schedule = planned(&problem);
    let first = schedule.iter().find(|at| at.operation == 0).unwrap();
    let said = Feedback {
        agent: first.agent,
        operation: 0,
        robot: first.robot,
        speed: 0.1,
        wait: 1.0,
        approach: 0.0,
        distance: 0.0,
    };
    let (adapted, _) = adapt(&problem, None, &said, &Adaptation::default()).unwrap();
    assert!(adapted.wait_weight(first.agent, 1) > 2.0);
    let next = planned(&adapted);
    let second = |schedule: &[Assistance]| {
        let at = schedule.iter().find(|at| at.agent == first.agent && at.operation == 1).unwrap();
        wait(schedule, at)
    };
    assert!(second(&next) <= second(&schedule) + 1e-6, "{} {}", second(&next), second(&schedule));
}
