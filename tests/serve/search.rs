//! A search with pages: a person who reports where she is and what is done, a simulated robot, a supervisor.

use std::path::PathBuf;

use hierarq::serve::{Options, Server};
use mission::kinds::search::Search;
use mission::kinds::search::problem::{Agent, Boundary, Planner, Problem, Rate, Source, SourceKind};
use serde_json::{Value as Json, json};

use super::Running;
use super::client::{button, may, row};

fn agent(name: &str, human: bool, start: [f64; 2]) -> Agent {
    Agent {
        name: name.into(),
        human,
        start,
        heading: 0.0,
        speed: 1.0,
        radius: 0.3,
        passes: Vec::new(),
        unaware: Vec::new(),
        sees: None,
        spread: 0.0,
        lost: false,
        told: None,
        habits: None,
    }
}

fn source(name: &str, centre: [f64; 2], targets: Vec<usize>, after: Vec<usize>) -> Source {
    Source {
        name: name.into(),
        kind: SourceKind::Task,
        boundary: Boundary::Circle { centre, radius: 0.5 },
        inside: Rate::constant(5.0),
        outside: Rate::ZERO,
        pool: Some(10.0),
        targets,
        after,
        until: Vec::new(),
        of: None,
    }
}

/// She switches on a light, in which the robot reads a panel.
fn mission() -> Search {
    let mut labels = mission::labels::Labels::default();
    labels.members.insert("anna".into(), "Anna & Co".into());
    let problem = Problem {
        area: vec![[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]],
        occupancy: None,
        walls: Vec::new(),
        agents: vec![agent("robot", false, [1.0, 1.0]), agent("anna", true, [7.0, 1.0])],
        sources: vec![
            source("light", [7.0, 5.0], vec![0, 1], Vec::new()),
            source("panel", [1.0, 5.0], vec![0], vec![0]),
        ],
        codependent: Vec::new(),
        objects: Vec::new(),
        cell: 1.0,
        exposure: Vec::new(),
        horizon: 3600.0,
        start: 0.0,
        reminder: None,
        planner: Planner { states: 500, tree_nodes: 100, ..Planner::default() },
        sight: Default::default(),
        labels,
    };
    Search { problem }
}

const ROBOT: usize = 0;
const SHE: usize = 1;
const LIGHT: usize = 2;

fn running(options: &Options) -> Running {
    let options = Options { nodes: Some(500), ..options.clone() };
    Running { server: Some(Server::start("find", &mission(), &options).expect("a server")) }
}

const ANNA: Option<&str> = Some("Anna & Co");

#[test]
fn a_person_reports_and_the_robot_follows() {
    let on = running(&Options { speed: 20.0, begin: true, ..Options::default() });
    assert_eq!(on.server().links().len(), 2, "a robot and sources have no pages");
    let (anna, supervisor) = (on.open(ANNA), on.supervisor());
    let state = anna.until(may("done"));
    assert_eq!(state["person"]["doing"], "Go to light.");
    assert!(state["person"]["next"].as_str().expect("text").starts_with("Stay at light"), "{state:#}");
    assert_eq!(button(&state, "done")["request"], json!({ "what": "done", "activity": 0 }));
    // Her way does not end by itself, and the robot waits for the light.
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert_eq!(anna.state()["person"]["doing"], "Go to light.");
    // The last half metre of her way is in the light's circle.
    assert_eq!(row(&supervisor.state(), LIGHT)["doing"], "7.50 left");
    let until = anna.state()["person"]["until"].as_f64().expect("she moves");
    let longer = json!({ "what": "longer", "activity": 0, "until": until + 30.0 });
    assert!(anna.tell(longer.clone()).said().starts_with("Noted: 30 s longer, until"));
    assert!(anna.tell(longer).said().starts_with("Already noted"));
    assert!(anna.tell(json!({ "what": "done", "activity": 0 })).said().starts_with("Noted: done at"));
    assert_eq!(anna.tell(json!({ "what": "done", "activity": 0 })).said(), "This activity is done already.");
    let early = anna.tell(json!({ "what": "done", "activity": 7 }));
    assert_eq!((early.status, early.said().contains("not yours now")), (409, true));
    let state = anna.until(|state| state["person"]["doing"] == "Stay at light.");
    assert_eq!(button(&state, "done")["request"]["activity"], 1);
    supervisor.until(|state| row(state, LIGHT)["doing"] == "is consumed");
    anna.tell(json!({ "what": "done", "activity": 1 }));
    let over = supervisor.until(|state| !state["over"].is_null());
    assert_eq!(over["over"], "The search is over: every activity is done.");
    assert_eq!(row(&over, LIGHT)["doing"], "is consumed");
    assert!(over["numbers"].as_str().expect("text").starts_with("reward 20.00"), "{over:#}");
    assert!(anna.state()["person"]["messages"].to_string().contains("panel is consumed."));
}

#[test]
fn positions_are_reported_and_impossible_ones_rejected() {
    let on = running(&Options { speed: 1.0, begin: true, ..Options::default() });
    let (anna, supervisor) = (on.open(ANNA), on.supervisor());
    let state = anna.until(may("my_pose"));
    assert_eq!(button(&state, "my_pose")["point"]["key"], "to");
    assert_eq!(state["person"]["map"]["marks"].as_array().map(Vec::len), Some(2));
    let map = anna.get("/person/1/map.svg").body;
    assert!(map.starts_with("<svg") && map.contains("light"), "{map}");
    assert_eq!(anna.get("/supervisor/map.svg").status, 401);
    let events = |state: &Json| state["events"].clone();
    let before = events(&supervisor.until(|state| state["events"].as_array().is_some_and(|all| all.len() > 1)));
    for (at, status, why) in [
        (json!([-3, 2]), 409, "outside the area"),
        (json!([7.9, 2]), 409, "in a wall"),
        (json!([1e300, 2]), 400, "`to`"),
        (json!("here"), 400, ""),
    ] {
        let refused = anna.tell(json!({ "what": "my_pose", "number": 0, "to": at }));
        assert!(refused.status == status && refused.said().contains(why), "{refused:?}");
    }
    assert_eq!(events(&supervisor.state()), before, "a rejected position changes nothing");
    let noted = anna.tell(json!({ "what": "my_pose", "number": 0, "to": [4, 4] })).said();
    assert_eq!(noted, "Noted: you are at (4.0, 4.0) m. There is a new plan.");
    assert!(supervisor.state()["events"].to_string().contains("Anna & Co says to be at (4.0, 4.0) m"));
    let state = supervisor.state();
    let at = &row(&state, SHE)["at"];
    assert!(at[0].as_f64().is_some_and(|x| (3.9..8.0).contains(&x)), "{at}");
    assert!(anna.tell(json!({ "what": "replan", "number": 1 })).said().starts_with("Noted. "));
}

#[test]
fn somebody_leaves_and_is_back() {
    let on = running(&Options { speed: 1.0, begin: true, ..Options::default() });
    let (anna, supervisor) = (on.open(ANNA), on.supervisor());
    anna.until(may("done"));
    for member in [ROBOT, SHE] {
        assert!(supervisor.tell(json!({ "what": "lost", "member": member })).said().starts_with("Noted"));
    }
    let state = supervisor.state();
    assert_eq!(state["note"], "The search has stopped: everybody is lost.");
    assert_eq!(row(&state, SHE)["doing"], "has left");
    assert!(anna.state()["person"]["messages"].to_string().contains("You have left the search."));
    assert_eq!(supervisor.tell(json!({ "what": "back", "member": SHE })).said(), "Noted; there is a new plan.");
    assert!(supervisor.state()["note"].is_null());
    for (body, status, why) in [
        (json!({ "what": "back", "member": SHE }), 409, "is not lost"),
        (json!({ "what": "lost", "member": LIGHT }), 400, "a source"),
        (json!({ "what": "lost", "member": 9 }), 400, "no member with this number"),
        (json!({ "what": "failed", "member": SHE }), 400, "`moved` reports its position"),
    ] {
        let refused = supervisor.tell(body);
        assert!(refused.status == status && refused.said().contains(why), "{refused:?}");
    }
    let chart = supervisor.get("/supervisor/gantt.svg").body;
    assert!(chart.starts_with("<svg") && chart.contains("Anna &amp; Co"), "{chart}");
    let map = supervisor.get("/supervisor/map.svg").body;
    assert!(map.starts_with("<svg") && map.contains("light") && map.contains("Anna &amp; Co"), "{map}");
}

#[test]
fn a_search_goes_on_where_its_journal_ends() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("serve_search");
    std::fs::create_dir_all(&folder).expect("writable");
    let path = folder.join("goes_on.journal");
    for old in [path.clone(), folder.join("goes_on.journal.key")] {
        let _ = std::fs::remove_file(old);
    }
    let options = |begin| Options { speed: 10.0, begin, journal: Some(path.clone()), ..Options::default() };
    let on = running(&options(true));
    let (anna, supervisor) = (on.open(ANNA), on.supervisor());
    anna.until(may("done"));
    anna.tell(json!({ "what": "my_pose", "number": 0, "to": [6, 3] }));
    anna.tell(json!({ "what": "replan", "number": 1 }));
    supervisor.tell(json!({ "what": "stop" }));
    let lasting = |state: &Json| json!([state["events"], state["status"], state["numbers"], state["members"]]);
    let before = lasting(&supervisor.state());
    on.end();
    let again = running(&options(false));
    let (time, same) = again.server().resumed().expect("a journal");
    assert!(same && time > 0.0);
    assert_eq!(lasting(&again.supervisor().state()), before);
    again.end();
}

/// Reminders of each kind on the page of the person: numbered, until the pose is sent; counters show uses instead.
#[test]
fn people_are_reminded_to_send_their_pose() {
    use mission::kinds::search::habits::{Reminder, ReminderKind};
    for kind in ReminderKind::ALL {
        let mut of = mission();
        of.problem.reminder = Some(Reminder { kind, after: 5.0, shorten: 0.8, least: 4.0 });
        let options = Options { nodes: Some(500), speed: 40.0, begin: true, ..Options::default() };
        let on = Running { server: Some(Server::start("find", &of, &options).expect("a server")) };
        let anna = on.open(ANNA);
        let state = anna.until(may("my_pose"));
        assert!(
            button(&state, "my_goal")["uses"] == if kind == ReminderKind::Counters { json!(0) } else { Json::Null }
        );
        let send = |number: usize| anna.tell(json!({ "what": "my_pose", "number": number, "to": [7.0, 2.0] }));
        if kind == ReminderKind::Counters {
            assert!(send(0).said().starts_with("Noted"));
            let state = anna.until(|state| button(state, "my_pose")["uses"] == 1);
            assert!(button(&state, "my_goal")["uses"] == 0 && button(&state, "replan")["uses"].is_null());
            assert!(button(&state, "robot_goal_0")["uses"] == 0 && state["person"]["reminder"].is_null());
            continue;
        }
        let state = anna.until(|state| state["person"]["reminder"]["number"].as_u64() >= Some(2));
        let reminder = &state["person"]["reminder"];
        assert_eq!((&reminder["kind"], &reminder["button"]), (&json!(kind.name()), &json!("my_pose")));
        let number = reminder["number"].as_u64().expect("a number");
        assert!(state["person"]["messages"].to_string().contains("reminded to send your pose"));
        assert!(send(0).said().starts_with("Noted"));
        // The next one comes after the whole time again, with the next number.
        let state = anna.until(|state| state["person"]["reminder"]["number"].as_u64() > Some(number));
        assert_eq!(state["person"]["reminder"]["kind"], kind.name());
        assert!(on.supervisor().state()["person"].is_null(), "a supervisor is not reminded");
    }
}
