//! Problems that cannot be planned are rejected with the declaration and the reason.
use crate::common;

use std::path::Path;

use hierarq_mission::engine::cp::Program;
use hierarq_mission::engine::{EngineError, Highs, Microlp, Milp, Model};
use hierarq_mission::kinds::schedule::check::{Declaration, Item, Key, Mistake, Reason};
use hierarq_mission::kinds::schedule::choose::{Formulation, Options, Refusal, plan};
use hierarq_mission::kinds::schedule::problem::{Absence, Approach, Begun, Distances, Problem, ServiceTimes};
use hierarq_mission::numbers::Range;

/// The first mistake of the vineyard after a change.
fn mistake(change: impl Fn(&mut Problem)) -> Mistake {
    let mut problem = common::vineyard(2);
    assert_eq!(problem.check(), []);
    change(&mut problem);
    let mistakes = problem.check();
    assert_eq!(plan(&problem, &Options::default()).unwrap_err(), Refusal::Problem(mistakes.clone()));
    mistakes.into_iter().next().unwrap()
}

fn at(item: Item, key: Key) -> Declaration {
    Declaration { item, key: Some(key) }
}

#[test]
fn mistakes_name_the_declaration() {
    let robot = Item::Robot(1);
    let agent = Item::Agent(2);
    let found = mistake(|p| p.robots[1].speed = Range::new(0.3, 0.2));
    assert_eq!((found.at, found.reason), (at(robot, Key::Speed), Reason::Reversed { low: 0.3, high: 0.2 }));
    let found = mistake(|p| p.robots[1].speed.low = 0.0);
    assert_eq!(found.at, at(robot, Key::Speed));
    let found = mistake(|p| p.robots[1].proximity = Some(Range::new(0.3, 0.4)));
    assert_eq!(found.reason, Reason::OutsideCruise { low: 0.3, high: 0.4 });
    assert_eq!((found.at, found.against), (at(robot, Key::Proximity), Some(at(robot, Key::Speed))));
    assert_eq!(mistake(|p| p.robots[1].serve = -1.0).reason, Reason::TooSmall { value: -1.0, least: 0.0 });
    assert_eq!(mistake(|p| p.robots[1].factor = 0.0).reason, Reason::NotPositive { value: 0.0 });
    assert_eq!(mistake(|p| p.robots[1].depot[0] = f64::INFINITY).at, at(robot, Key::Depot));
    assert_eq!(mistake(|p| p.confidence = 1.0).at, at(Item::Mission, Key::Confidence));
    assert_eq!(mistake(|p| p.weights.energy = f64::INFINITY).at, at(Item::Mission, Key::Weights));
    assert_eq!(mistake(|p| p.agents[2].duration.mean = 1e9).reason, Reason::TooLarge { value: 1e9 });
    let found = mistake(|p| {
        p.agents[2].duration.sigma = 300.0;
        p.confidence = 0.1;
    });
    assert!(matches!(found.reason, Reason::NoTime { seconds } if seconds < 0.0), "{found:?}");
    assert_eq!(mistake(|p| p.agents[2].severity = 1.5).at, at(agent, Key::Severity));
    let found = mistake(|p| p.agents[2].wait_weights = vec![1.0]);
    assert_eq!((found.at, found.reason), (at(agent, Key::WaitWeights), Reason::Count { found: 1, expected: 2 }));
    let twice = |p: &mut Problem| {
        p.agents[2].approaches = vec![Approach { robot: 1, speed: None, wait_distance: None }; 2];
    };
    assert_eq!(mistake(twice).reason, Reason::Twice);
    assert_eq!(mistake(|p| p.robots.clear()).reason, Reason::NoRobot);
    assert_eq!(mistake(|p| p.agents.iter_mut().for_each(|a| a.operations = 0)).reason, Reason::NoOperation);
    let found = mistake(|p| p.agents[0].operations = usize::MAX);
    assert!(matches!(found.reason, Reason::TooMany { .. }), "{found:?}");
    let found = mistake(|p| p.distances = Distances::Table(vec![vec![1.0; 4]]));
    assert_eq!(found.reason, Reason::Count { found: 1, expected: 2 });
    let nowhere = |p: &mut Problem| p.distances = Distances::Table(vec![vec![0.0; 4]; 2]);
    assert_eq!(mistake(nowhere).reason, Reason::NoWay);
}

#[test]
fn what_has_begun_must_be_possible() {
    let begun = |agent, operation, service| Begun { agent, operation, start: 0.0, end: 200.0, service };
    let times =
        ServiceTimes { going: 0.0, waiting: 100.0, proximity: 190.0, serving: 200.0, depositing: 210.0, end: 400.0 };
    let first = |change: &dyn Fn(&mut Problem)| {
        mistake(|p| {
            p.start = 50.0;
            change(p);
        })
        .reason
    };
    assert_eq!(first(&|p| p.begun = vec![begun(9, 0, None)]), Reason::Unknown { index: 9 });
    assert_eq!(first(&|p| p.begun = vec![begun(0, 1, None)]), Reason::NotServed);
    assert_eq!(first(&|p| p.begun = vec![begun(0, 0, None); 2]), Reason::Twice);
    assert_eq!(first(&|p| p.begun = vec![begun(0, 0, Some((7, times)))]), Reason::Unknown { index: 7 });
    let soon = ServiceTimes { serving: 195.0, ..times };
    assert_eq!(first(&|p| p.begun = vec![begun(0, 0, Some((0, soon)))]), Reason::BeforeEnd);
    let both = |p: &mut Problem| p.begun = vec![begun(0, 0, Some((0, times))), begun(1, 0, Some((0, times)))];
    assert_eq!(first(&both), Reason::Overlap);
    let still = ServiceTimes { proximity: 200.0, ..times };
    assert!(matches!(first(&|p| p.begun = vec![begun(0, 0, Some((0, still)))]), Reason::NoDuration { .. }));
    let late = |p: &mut Problem| p.begun = vec![Begun { start: 60.0, ..begun(0, 0, None) }];
    assert_eq!(first(&late), Reason::Later { begins: 60.0 });
    let away = |robot, until| Absence { robot, until };
    assert_eq!(first(&|p| p.absent = vec![away(7, None)]), Reason::Unknown { index: 7 });
    assert_eq!(first(&|p| p.absent = vec![away(1, None), away(1, Some(3.0))]), Reason::Twice);
    assert_eq!(first(&|p| p.absent = vec![away(0, None), away(1, None)]), Reason::NoRobot);
    let never = |p: &mut Problem| p.absent = vec![away(0, Some(f64::INFINITY))];
    assert_eq!(first(&never), Reason::TooLarge { value: f64::INFINITY });
}

#[test]
fn a_formulation_that_does_not_fit_is_refused() {
    let asked = |formulation| Options { formulation: Some(formulation), ..Options::default() };
    let refusal = plan(&common::vineyard(1), &asked(Formulation::Constraint)).unwrap_err();
    assert_eq!(refusal, Refusal::Speeds { robot: "m1".into() });
    let refusal = plan(&common::fixed(0, 2, 2, 2), &asked(Formulation::Subsets)).unwrap_err();
    assert_eq!(refusal, Refusal::NotSubsets);
}

#[test]
fn a_missing_engine_says_how_to_install_it() {
    let Err(error) = Highs::load(Path::new("/nowhere/libhighs.so")) else { panic!("there is nothing to load") };
    assert!(matches!(error, EngineError::Missing { .. }));
    assert!(error.to_string().contains("pip install highsbox"), "{error}");
}

#[test]
fn numbers_beyond_the_constraint_program_are_refused() {
    let mut program = Program::default();
    assert!(program.number(0, 1 << 31).is_err());
    let number = program.number(0, 1 << 20).unwrap();
    let term = hierarq_mission::engine::cp::Term::Number(number);
    assert!(matches!(program.at_most(&[(term, 1 << 11)], 0, None), Err(EngineError::Overflow { .. })));
    // A coefficient of zero is omitted, and an empty sum holds or does not.
    assert!(program.at_most(&[(term, 0)], 0, None).is_ok());
}

#[test]
fn a_program_without_a_point_is_told_apart() {
    let mut model = Model::default();
    let x = model.real(1.0, 0.0, 1.0);
    model.at_least(2.0, [(x, 1.0)]);
    assert!(matches!(Microlp.solve(&model, &[], &Default::default()), Err(EngineError::Infeasible { .. })));
}
