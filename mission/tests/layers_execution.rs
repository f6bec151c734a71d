//! Executed layers: records against the plan, random events against the validator and the rules, and paths against
//! straight lines.

mod executed;

use crate::layered;
use executed::{Performed, check, keeps_the_rules, performed, run, settings};
use hierarq_mission::execution::NoFeasiblePlan;
use hierarq_mission::execution::{Durations, Replan};
use hierarq_mission::kinds::layers::cost::cost;
use hierarq_mission::kinds::layers::execution::{Doing, Event, EventError, LayersExecution, Refusal, Settings};
use hierarq_mission::kinds::layers::problem::{Begun, Body, Problem};
use hierarq_mission::kinds::layers::scales::Scales;
use hierarq_mission::kinds::layers::steps::from_plan;
use proptest::prelude::*;

fn possible(problem: Problem) -> Option<Problem> {
    problem.check().is_empty().then_some(problem)
}

/// An event that may be reported at any time, or passing time (s).
#[derive(Clone, Copy, Debug)]
enum Action {
    Event(Event),
    Wait(f64),
}

fn action() -> impl Strategy<Value = Action> {
    let agent = 0_usize..4;
    prop_oneof![
        6 => (0.0_f64..12.0).prop_map(Action::Wait),
        1 => agent.clone().prop_map(|agent| Action::Event(Event::Begun { agent })),
        2 => agent.clone().prop_map(|agent| Action::Event(Event::Done { agent })),
        2 => (agent.clone(), -10.0_f64..30.0).prop_map(|(agent, by)| Action::Event(Event::Late { agent, by })),
        2 => agent.clone().prop_map(|agent| Action::Event(Event::Failed { agent })),
        1 => agent.clone().prop_map(|agent| Action::Event(Event::Lost { agent })),
        1 => agent.prop_map(|agent| Action::Event(Event::Back { agent })),
        1 => Just(Action::Event(Event::Replan)),
    ]
}

fn replan() -> impl Strategy<Value = Replan> {
    prop::sample::select(vec![Replan::None, Replan::Reschedule, Replan::Both])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    /// For any events the validator accepts all plans, the records satisfy the rules, and every agent continues until
    /// all tasks are done if it can.
    #[test]
    fn whatever_happens_the_rules_are_kept(
        seed in 0_u64..100_000, spread in 0.0_f64..0.8, replan in replan(), events in prop::collection::vec(action(), 1..24),
        told in prop::option::of(0_usize..4),
    ) {
        let Some(mut problem) = possible(layered::random(seed, 8, 12, 3, 1)) else { return Ok(()) };
        problem.agents.iter_mut().for_each(|who| who.spread = spread);
        let durations = Durations::Sampled { seed };
        let told: Vec<usize> = told.into_iter().collect();
        let settings = Settings { durations, replan, reporting: told.clone(), ..settings() };
        let mut execution = LayersExecution::new(problem.clone(), settings).unwrap();
        for event in events {
            match event {
                Action::Wait(time) => {
                    let to = execution.time() + time;
                    prop_assert!(execution.advance(to).iter().all(|record| record.time <= to));
                    prop_assert_eq!(execution.time(), to);
                }
                Action::Event(event) => {
                    let before = execution.records().len();
                    let taken = execution.handle_event(event).is_ok();
                    prop_assert_eq!(taken, execution.records().len() > before);
                }
            }
            check(&problem, &execution);
        }
        keeps_the_rules(&problem, execution.records());
        // All agents come back, and the agents in `told` report their work.
        for agent in 0..problem.agents.len() {
            let _ = execution.handle_event(Event::Back { agent });
        }
        for _ in 0..200 {
            if execution.done() { break }
            for &agent in &told {
                let _ = execution.handle_event(Event::Begun { agent });
                execution.advance(execution.time() + 3.0);
                let _ = execution.handle_event(Event::Done { agent });
            }
            if told.is_empty() { run(&mut execution) } else { execution.advance(execution.time() + 5.0); }
        }
        prop_assert!(execution.done(), "{:?}", execution.stranded());
        check(&problem, &execution);
        keeps_the_rules(&problem, execution.records());
        prop_assert_eq!(performed(execution.records()).iter().filter(|one| one.done).count(), problem.tasks.len());
    }

    /// The same events give the same records, independent of the time steps.
    #[test]
    fn records_do_not_depend_on_steps(seed in 0_u64..100_000, late in 0.0_f64..20.0, step in 0.1_f64..5.0) {
        let Some(mut problem) = possible(layered::random(seed, 7, 11, 2, 1)) else { return Ok(()) };
        problem.agents.iter_mut().for_each(|who| who.spread = 0.3);
        let settings = Settings { durations: Durations::Sampled { seed }, ..settings() };
        let start = LayersExecution::new(problem, settings).unwrap();
        let of = |step: f64| {
            let mut execution = start.clone();
            for until in [3.0, 60.0, 4000.0] {
                while execution.time() < until {
                    execution.advance((execution.time() + step).min(until));
                    if execution.done() { break }
                }
                let _ = execution.handle_event(Event::Late { agent: 0, by: late });
                let _ = execution.handle_event(Event::Failed { agent: 1 });
            }
            execution.records().to_vec()
        };
        prop_assert_eq!(of(step), of(4000.0));
    }

    /// Without disturbances the execution equals the plan: times, energy, workload, cost.
    #[test]
    fn as_planned(seed in 0_u64..100_000) {
        let Some(problem) = possible(layered::random(seed, 8, 12, 3, 1)) else { return Ok(()) };
        let mut execution = LayersExecution::new(problem.clone(), settings()).unwrap();
        let steps = from_plan(execution.plan());
        run(&mut execution);
        prop_assert!(execution.done());
        for one in performed(execution.records()) {
            let step = steps.iter().find(|step| step.task == one.task).unwrap();
            prop_assert_eq!((step.agent, step.object), (one.agent, one.object));
            prop_assert!((step.start - one.start).abs() < 1e-6 && (step.end - one.end).abs() < 1e-6);
        }
        let numbers = execution.statistics();
        prop_assert_eq!((numbers.reschedules, numbers.reallocations, numbers.dropped), (0, 0, 0));
        let (planned, scales) = (cost(&problem, &steps), Scales::of(&problem));
        let scaled = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { 0.0 };
        let sum = |of: fn(&hierarq_mission::kinds::layers::execution::AgentOutcome) -> f64, human: bool| -> f64 {
            let agents = numbers.agents.iter().zip(&scales.of_agent).filter(|(agent, _)| agent.human == human);
            agents.map(|(agent, scale)| scaled(of(agent), *scale)).sum()
        };
        prop_assert!((sum(|a| a.energy, false) - planned.energy).abs() < 1e-6);
        prop_assert!((sum(|a| a.workload, true) - planned.workload).abs() < 1e-6);
        prop_assert!((numbers.makespan / scales.makespan - planned.makespan).abs() < 1e-6);
    }

    /// Hands move continuously, no faster than planned, from the base to the object, along the path, and back.
    #[test]
    fn ways_are_gone(seed in 0_u64..100_000) {
        let Some(problem) = possible(layered::random(seed, 6, 9, 2, 1)) else { return Ok(()) };
        let mut execution = LayersExecution::new(problem.clone(), settings()).unwrap();
        let steps = from_plan(execution.plan());
        let apart = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
        for step in steps {
            let dt = (step.end - step.start) / 400.0;
            // Positions of an agent at 401 instants.
            let mut here = execution.clone();
            let mut track = Vec::new();
            for k in 0..=400 {
                here.advance(if k == 0 { step.start } else { (step.start + f64::from(k) * dt).min(step.end - 1e-9) });
                track.push(here.position(step.agent).unwrap());
            }
            prop_assert!(apart(track[0], problem.agents[step.agent].place) < 1e-6);
            for pair in track.windows(2) {
                prop_assert!(apart(pair[0], pair[1]) <= step.speed * dt * (1.0 + 1e-6) + 1e-9);
            }
            let length: f64 = track.windows(2).map(|pair| apart(pair[0], pair[1])).sum();
            let way = problem.distance(step.agent, step.task, step.object);
            // Sampling cuts corners.
            prop_assert!(length <= way + 1e-6 && length >= way - 10.0 * step.speed * dt - 1e-6, "{} of {}", length, way);
            let object = step.object.map(|object| problem.objects[object].place);
            for place in object.into_iter().chain(problem.tasks[step.task].path.iter().copied()) {
                prop_assert!(track.iter().any(|at| apart(*at, place) <= step.speed * dt + 1e-6));
            }
        }
        run(&mut execution);
        let home = |agent: usize| execution.position(agent) == Some(problem.agents[agent].place);
        prop_assert!((0..problem.agents.len()).all(home));
    }
}

/// The mean of the durations relative to the plan is 1, and their standard deviation is the spread.
#[test]
fn spreads_are_those_that_are_said() {
    let mut problem = layered::letter_h(1);
    problem.agents.iter_mut().for_each(|who| who.spread = 0.2);
    let plan = hierarq_mission::kinds::layers::choose::plan(&problem, &settings().planning).unwrap();
    let steps = from_plan(&plan);
    let mut shares = Vec::new();
    for seed in 0..120 {
        let settings = Settings { durations: Durations::Sampled { seed }, replan: Replan::None, ..settings() };
        let mut execution = LayersExecution::with_plan(problem.clone(), plan.clone(), settings).unwrap();
        run(&mut execution);
        for one in performed(execution.records()) {
            let step = steps.iter().find(|step| step.task == one.task).unwrap();
            shares.push((one.end - one.start) / (step.end - step.start));
        }
    }
    let count = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / count;
    let deviation = (shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / count).sqrt();
    assert!((mean - 1.0).abs() < 0.02 && (deviation - 0.2).abs() < 0.02, "{mean} {deviation}");
}

/// After a delay, a plan with variable speeds ends no later and costs no more than one without; a loss is replanned in
/// any case.
#[test]
fn what_the_plan_does_is_what_the_settings_allow() {
    let problem = layered::letter_h(1);
    let start = LayersExecution::new(problem.clone(), settings()).unwrap();
    let mut at = start.clone();
    at.advance(3.0);
    let agent = (0..3).find(|agent| at.agent(*agent).unwrap().doing == Doing::Working).unwrap();
    let of = |replan: Replan, event: Event| {
        let plan = start.plan().clone();
        let mut execution =
            LayersExecution::with_plan(problem.clone(), plan, Settings { replan, ..settings() }).unwrap();
        let before = from_plan(execution.plan());
        execution.advance(3.0);
        execution.handle_event(event).unwrap();
        run(&mut execution);
        assert!(execution.done());
        let after = from_plan(execution.plan());
        let same = before.iter().zip(&after).all(|(a, b)| (a.agent, a.object) == (b.agent, b.object));
        let speeds = before.iter().zip(&after).all(|(a, b)| a.speed == b.speed);
        (execution.plan().cost, same, speeds, execution.statistics().reallocations)
    };
    let late = Event::Late { agent, by: 40.0 };
    let (none, same, speeds, count) = of(Replan::None, late);
    assert_eq!((same, speeds, count), (true, true, 0));
    let (times, same, _, count) = of(Replan::Reschedule, late);
    assert_eq!((same, count), (true, 0));
    let (both, _, _, count) = of(Replan::Both, late);
    assert_eq!(count, 1);
    assert!(times <= none + 1e-9 && both <= times + 1e-9, "{none} {times} {both}");
    for replan in [Replan::None, Replan::Reschedule, Replan::Both] {
        let (_, same, _, count) = of(replan, Event::Lost { agent });
        assert_eq!((same, count), (false, 1), "{replan:?}");
    }
    let (_, _, _, count) = of(Replan::Reschedule, Event::Replan);
    assert_eq!(count, 0);
    assert_eq!(of(Replan::Both, Event::Replan).3, 1);
}

/// A failed task is repeated with its object; a lost agent's task is done by others, and an agent that comes back works
/// again.
#[test]
fn failures_and_losses() {
    let problem = layered::letter_d(1);
    let settings = || Settings { replan: Replan::Reschedule, ..settings() };
    let mut execution = LayersExecution::new(problem.clone(), settings()).unwrap();
    execution.advance(2.0);
    let at_work = (0..3).find(|agent| execution.agent(*agent).unwrap().work.is_some()).unwrap();
    let work = execution.agent(at_work).unwrap().work.unwrap();
    execution.handle_event(Event::Failed { agent: at_work }).unwrap();
    assert_eq!(execution.position(at_work), Some(problem.agents[at_work].place));
    run(&mut execution);
    let tries: Vec<Performed> =
        performed(execution.records()).into_iter().filter(|one| one.task == work.task).collect();
    assert_eq!(tries.len(), 2);
    assert!(tries.iter().all(|one| (one.agent, one.object) == (at_work, work.object)));
    assert_eq!((tries[0].done, tries[0].end, tries[1].start), (false, 2.0, 2.0));

    let mut execution = LayersExecution::new(problem.clone(), settings()).unwrap();
    execution.advance(2.0);
    execution.handle_event(Event::Lost { agent: at_work }).unwrap();
    let place = execution.position(at_work).unwrap();
    assert_ne!(place, problem.agents[at_work].place);
    assert!(matches!(execution.handle_event(Event::Lost { agent: at_work }), Err(EventError::IsLost { .. })));
    execution.advance(20.0);
    assert_eq!(execution.position(at_work), Some(place));
    execution.handle_event(Event::Back { agent: at_work }).unwrap();
    assert!(matches!(execution.handle_event(Event::Back { agent: at_work }), Err(EventError::NotLost { .. })));
    run(&mut execution);
    let late = performed(execution.records()).iter().any(|one| one.agent == at_work && one.start > 20.0);
    // The assignment stays: its tasks were assigned to others.
    assert!(execution.done() && !late);
    // If replanning is allowed, it gets tasks again.
    let mut execution = LayersExecution::new(problem, Settings { replan: Replan::Both, ..settings() }).unwrap();
    execution.advance(2.0);
    execution.handle_event(Event::Lost { agent: at_work }).unwrap();
    execution.handle_event(Event::Back { agent: at_work }).unwrap();
    run(&mut execution);
    assert!(execution.done() && execution.statistics().agents[at_work].tasks > 0);
}

/// Only one person can close boxes: without her the others continue as far as possible, and after she is back all tasks
/// are done.
#[test]
fn without_a_plan_others_go_on() {
    let problem = layered::sorting(1);
    let mut execution = LayersExecution::new(problem.clone(), settings()).unwrap();
    let filled = |execution: &LayersExecution| execution.statistics().layers == 2;
    let opened = |execution: &LayersExecution| execution.statistics().layers == 1;
    while !opened(&execution) {
        execution.advance(execution.next().unwrap());
    }
    execution.handle_event(Event::Lost { agent: 2 }).unwrap();
    assert!(matches!(execution.stranded(), Some(NoFeasiblePlan::NotFound { .. })), "{:?}", execution.stranded());
    let before = execution.statistics().tasks;
    run(&mut execution);
    assert!(!execution.done() && !filled(&execution) && execution.statistics().tasks > before);
    execution.advance(execution.time() + 100.0);
    execution.handle_event(Event::Back { agent: 2 }).unwrap();
    assert_eq!(execution.stranded(), None);
    run(&mut execution);
    assert!(execution.done());
    check(&problem, &execution);
    keeps_the_rules(&problem, execution.records());

    let mut alone = LayersExecution::new(layered::letter_h(1), settings()).unwrap();
    for agent in 0..3 {
        alone.handle_event(Event::Lost { agent }).unwrap();
    }
    assert_eq!((alone.stranded(), alone.next()), (Some(&NoFeasiblePlan::NobodyLeft { who: "everybody".into() }), None));
}

/// An agent in `told` begins and ends tasks only when reported; dependent tasks wait.
#[test]
fn people_begin_and_end_when_they_say_so() {
    let problem = layered::sorting(1);
    let told = Settings { reporting: vec![2], ..settings() };
    let mut execution = LayersExecution::new(problem.clone(), told).unwrap();
    assert!(matches!(execution.handle_event(Event::Done { agent: 2 }), Err(EventError::NotWorking { .. })));
    execution.advance(50.0);
    let idle = execution.agent(2).unwrap();
    assert_eq!((idle.doing, idle.tasks), (Doing::Idle, 0));
    assert!(idle.next.is_some_and(|next| next.open && next.start >= 50.0));
    for done in 1..=4 {
        execution.handle_event(Event::Begun { agent: 2 }).unwrap();
        assert!(matches!(execution.handle_event(Event::Begun { agent: 2 }), Err(EventError::Working { .. })));
        // Long after the planned end.
        execution.advance(execution.time() + 60.0);
        assert_eq!(execution.agent(2).unwrap().doing, Doing::Working);
        assert!(execution.agent(2).unwrap().work.unwrap().expected > execution.time());
        execution.handle_event(Event::Done { agent: 2 }).unwrap();
        assert_eq!(execution.agent(2).unwrap().tasks, done);
        check(&problem, &execution);
    }
    // The boxes are open: the arms fill them without reports.
    execution.advance(execution.time() + 30.0);
    assert!(execution.statistics().tasks > 4);
    keeps_the_rules(&problem, execution.records());
}

/// Invalid settings and events are rejected.
#[test]
fn wrong_settings_and_events_are_refused() {
    let problem = layered::letter_h(1);
    let refused = |problem: Problem, settings: Settings| LayersExecution::new(problem, settings).unwrap_err();
    assert_eq!(refused(problem.clone(), Settings { reporting: vec![7], ..settings() }), Refusal::Reporting(7));
    let nan = Settings { reallocate_above: f64::NAN, ..settings() };
    assert!(matches!(refused(problem.clone(), nan), Refusal::Threshold(_)));
    let none = Problem { agents: vec![], ..problem.clone() };
    assert!(matches!(refused(none, settings()), Refusal::Plan(_)));
    let mut negative = problem.clone();
    negative.agents[0].spread = -0.1;
    assert!(matches!(refused(negative, settings()), Refusal::Plan(_)));
    let plan = hierarq_mission::kinds::layers::choose::plan(&problem, &settings().planning).unwrap();
    let mut short = plan.clone();
    short.activities.pop();
    let broken = LayersExecution::with_plan(problem.clone(), short, settings()).unwrap_err();
    assert!(matches!(broken, Refusal::Violations(_)));
    let step = from_plan(&plan)[0];
    let begun = Begun { task: step.task, agent: step.agent, object: step.object, speed: 0.2, start: 0.0, end: 9.0 };
    let under_way = Problem { begun: vec![begun], ..problem.clone() };
    assert_eq!(refused(under_way, settings()), Refusal::Begun);

    let mut execution = LayersExecution::new(problem.clone(), settings()).unwrap();
    let records = execution.records().len();
    assert!(matches!(execution.handle_event(Event::Lost { agent: 9 }), Err(EventError::NoAgent { agent: 9 })));
    execution.advance(1.0);
    let at_work = (0..3).find(|agent| execution.agent(*agent).unwrap().doing == Doing::Working).unwrap();
    assert!(matches!(
        execution.handle_event(Event::Late { agent: at_work, by: f64::NAN }),
        Err(EventError::Time { .. })
    ));
    assert!(execution.records().len() > records && execution.agent(3).is_none());
    execution.advance(f64::NAN);
    execution.advance(-5.0);
    assert_eq!(execution.time(), 1.0);
    assert!(matches!(problem.agents[0].body, Body::Robot { .. }));
}

/// Replanning backs off while a task stays late: of `n` expected ends that pass, replanning is considered only at
/// powers of two, with a threshold of zero under which every repair would trigger it.
#[test]
fn around_a_task_that_stays_late_plans_are_made_anew_less_and_less_often() {
    use hierarq_mission::execution::PlanChange;
    use hierarq_mission::kinds::layers::execution::LogEntry;
    let problem = possible(layered::random(3, 8, 12, 3, 1)).expect("a problem");
    // Nobody reports that the task of agent 0 is done.
    let settings = Settings { reporting: vec![0], reallocate_above: 0.0, ..settings() };
    let mut execution = LayersExecution::new(problem, settings).unwrap();
    for _ in 0..600 {
        execution.advance(execution.time() + 1.0);
        let _ = execution.handle_event(Event::Begun { agent: 0 });
    }
    let (mut late, mut anew) = (0_usize, Vec::new());
    for record in execution.records() {
        match record.what {
            LogEntry::TaskLate { agent: 0, .. } => late += 1,
            LogEntry::Begun { agent: 0, .. } => late = 0,
            LogEntry::Plan(PlanChange::Reallocated { .. } | PlanChange::Refused { .. }) if late > 0 => anew.push(late),
            _ => {}
        }
    }
    assert!(late > 20, "{late} times late");
    assert!(!anew.is_empty() && anew.iter().all(|late| late.is_power_of_two()), "{anew:?}");
}
