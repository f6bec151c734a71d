//! A kind of mission that no list names: a person walks to a place. Its folder is all that it adds, and it is planned,
//! validated, executed, judged, logged, reported, drawn, written as data and served by what all kinds share.

pub mod walk;

use blocks::{Bound, BoundBlock, Located, Origin};
use mission::any_mission::AnyMission;
use mission::declare::{DeclaredMember, DeclaredMission, Remarks};
use mission::kind::{Detail, Event, Mission, MissionData};
use mission::plan::Status;
use mission::plan_data;
use mission::planned::{PlanOptions, Refusal};
use runtime::expect::Verdict;
use runtime::missions::End;
use runtime::program::{MissionProgram, MissionScenarioProgram, TimedEvent};

use crate::common::played::{self, logged as run, numbers, table};
use crate::mission_driven;
use hierarq::{gantt, report};
use walk::Walk;
use walk::blocks::{WALK, WALKER, build};

/// Five metres in ten seconds.
pub fn walk() -> Walk {
    Walk { person: "anna".into(), from: [0.0, 0.0], to: [3.0, 4.0], speed: 0.5, labels: Default::default() }
}

/// A mission of the kind, with a scenario whose expectations were written for another kind: they read measures by name.
fn scenario(expectations: &str) -> (MissionProgram, MissionScenarioProgram) {
    let text = format!(
        "hierarq 1
mission day : schedule {{
  robot m {{ depot [0, 0] m  speed 0.2 m/s  proximity_speed 0.2 m/s  serve 20 s  deposit 10 s }}
  worker w {{ place [10, 3] m  duration 100 s }}
}}
scenario s {{ mission day  duration 30 s  step 1 s  operations planned  {expectations} }}\n"
    );
    let (mission, scenario) = played::scenario(&text);
    (MissionProgram { kind: AnyMission::new(walk()), ..mission }, scenario)
}

/// Late by these seconds.
pub fn late(by: f64) -> Event {
    Event { event: "late".into(), member: Some(0), with: [("by".to_string(), Detail::Number(by))].into() }
}

#[test]
fn it_is_planned_and_validated() {
    let walk = walk();
    assert!(walk.check().is_ok());
    let planned = walk.plan(&PlanOptions::default()).expect("a plan");
    assert_eq!((planned.summary.as_str(), planned.method.formulation), ("1 way", "straight"));
    assert_eq!(planned.status, Status::Proven { bound: 10.0 });
    assert!((planned.chart.end().expect("an end") - 10.0).abs() < 1e-9);
    let asked = PlanOptions { formulation: Some("orders"), ..PlanOptions::default() };
    let Err(Refusal::NoFormulation { known, .. }) = walk.plan(&asked) else { panic!("a formulation of another kind") };
    assert_eq!(known, ["straight"]);
    let mut slow = walk::plan::plan(&walk);
    slow.activities[0].end += 1.0;
    assert_eq!(walk::plan::validate(&walk, &slow), ["the way takes its length divided by the speed"]);
}

#[test]
fn its_plan_is_data_with_a_schema() {
    let walk = walk();
    let planned = walk.plan(&PlanOptions::default()).expect("a plan");
    let json = planned.to_json("walk.hq", "day", walk.kind().name).expect("JSON");
    let plan: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let schema = plan_data::schema(&[walk.kind().plan_form()]);
    let judge = jsonschema::draft202012::new(&schema).expect("a schema");
    let faults: Vec<String> = judge.iter_errors(&plan).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(faults.is_empty(), "{faults:?}");
    assert_eq!((&plan["kind"], &plan["activities"][0]["metres"]), (&"walk".into(), &5.0.into()));
    let mut less = plan.clone();
    less["activities"][0].as_object_mut().expect("an object").remove("metres");
    assert!(!judge.is_valid(&less));
    let again = (walk.kind().read)(walk.to_value()).expect("a mission");
    assert_eq!(again.downcast::<Walk>(), Some(&walk));
}

#[test]
fn it_is_drawn() {
    let planned = walk().plan(&PlanOptions::default()).expect("a plan");
    let text = gantt::text(&planned.chart, 60, false);
    assert!(text.contains("anna") && text.contains("> walking") && text.contains("to the place"), "{text}");
    let map = gantt::map(&planned.map, &gantt::Standing::default());
    for drawn in [gantt::svg(&planned.chart), map] {
        roxmltree::Document::parse(&drawn).expect("XML");
        assert!(drawn.contains("anna"), "{drawn}");
    }
}

#[test]
fn it_is_executed_judged_logged_and_reported() {
    let (mission, mut scenario) = scenario("expect eventually done  expect always day.makespan < 13 s");
    let (good, bytes) = run(&mission, &scenario);
    assert!(good.summary.ok, "{:?}", good.summary);
    assert_eq!(good.summary.end, End::Done { at_s: 10.0 });
    let (header, rows) = table(bytes);
    assert_eq!(numbers(&header, &rows, "anna.y")[5], 2.0);
    scenario.happens = vec![TimedEvent { at: 4.0, what: late(5.0) }];
    let (bad, _) = run(&mission, &scenario);
    assert_eq!(bad.summary.end, End::Done { at_s: 15.0 });
    let verdicts: Vec<Verdict> = bad.summary.expectations.iter().map(|e| e.verdict).collect();
    assert_eq!(verdicts, [Verdict::Holds, Verdict::Fails]);
    assert!(bad.summary.log.iter().any(|happened| happened.what == "anna is late by 5 s"));
    let page = report::mission("walk.hq", &bad);
    assert!(page.contains("anna arrives") && page.contains("Places and ways"));
    assert!(runtime::text::mission(&mission).starts_with("mission day : walk\n"));
}

/// A controller that was bound for a search drives a member of this kind, by the interface that all kinds have.
#[test]
fn a_controller_drives_it() {
    let folder = mission_driven::folder("toy", &mission_driven::without_people());
    let text = mission_driven::room(mission_driven::RUNS, "");
    let text = format!("{text}scenario s {{ mission day  duration 30 s  step 100 ms  expect eventually done }}\n");
    let (mission, scenario) = played::found(&played::compiled_in(&folder, &text));
    // From the start of the robot that was lowered: 4 m in 8 s.
    let walk = Walk { from: [1.0, 3.0], to: [5.0, 3.0], ..walk() };
    let mission = MissionProgram { kind: AnyMission::new(walk), ..mission };
    let (run, bytes) = played::logged(&mission, &scenario);
    assert!(run.summary.ok, "{:?}", run.summary);
    let End::Done { at_s } = run.summary.end else { panic!("{:?}", run.summary.end) };
    assert!((7.0..9.5).contains(&at_s), "{at_s}");
    let (header, rows) = table(bytes);
    let (x, y) = (numbers(&header, &rows, "anna.x"), numbers(&header, &rows, "anna.y"));
    assert!(y.iter().all(|y| (y - 3.0).abs() < 1e-6) && x.windows(2).all(|w| w[0] <= w[1] + 1e-9), "{x:?}");
    assert!(x.last().is_some_and(|x| (x - 5.0).abs() < 0.3), "{:?}", x.last());
    let drive = run.summary.workers[0].drive.as_ref().expect("a base");
    assert!((drive.travelled_m - (x[x.len() - 1] - 1.0)).abs() < 0.02 && drive.off_way_m < 0.02, "{drive:?}");
}

/// A value of a declaration.
fn located(value: Bound) -> Option<Located<Bound>> {
    Some(Located { at: Origin::default(), value })
}

#[test]
fn its_declaration_is_read_by_its_tables() {
    let at = Origin::default();
    let mut settings = BoundBlock::new(&WALK, at);
    settings.put("to", at, located(Bound::Pair([3.0, 4.0])));
    let mut own = BoundBlock::new(&WALKER, at);
    own.put("from", at, located(Bound::Pair([0.0, 0.0])));
    own.put("speed", at, located(Bound::Number(0.5)));
    let anna =
        DeclaredMember { role: "human", name: "anna".into(), at, action: None, settings: own, members: Vec::new() };
    let declared = |members: Vec<DeclaredMember>| DeclaredMission {
        name: "day".into(),
        at,
        settings: settings.clone(),
        members,
        incomplete: false,
    };
    let mut remarks = Remarks::default();
    assert_eq!(build(&declared(vec![anna.clone()]), &mut remarks), walk());
    assert!(!remarks.has_error());
    build(&declared(Vec::new()), &mut remarks);
    assert!(remarks.has_error(), "nobody walks");
    let mut remarks = Remarks::default();
    build(&declared(vec![anna.clone(), DeclaredMember { name: "ben".into(), ..anna }]), &mut remarks);
    assert!(remarks.has_error(), "two people walk");
}
