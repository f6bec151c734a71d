//! A mission of layers with pages: a person who reports her tasks, two simulated arms, a supervisor.

use std::collections::BTreeMap;
use std::path::PathBuf;

use hierarq::serve::{LayersMission, Options, Server};
use mission::engine::Budget;
use mission::kinds::layers::choose;
use mission::kinds::layers::execution::Settings;
use mission::kinds::layers::problem::{Agent, Body, Object, Problem, Skill, Task, Weights};
use mission::numbers::{Energy, Range};
use serde_json::{Value as Json, json};

use super::Running;

fn arm(name: &str, x: f64) -> Agent {
    Agent {
        name: name.into(),
        place: [x, -0.5, 0.0],
        body: Body::Robot { speed: Range::new(0.2, 0.4), energy: Energy { standby: 4.0, friction: 0.0, drag: 100.0 } },
        skills: vec![Skill { action: "pick".into(), duration: 2.0, pace: 1.0 }],
        reach: None,
        payload: None,
        cannot: Default::default(),
        spread: 0.0,
        lost: false,
    }
}

/// She opens, all fill, she closes.
pub fn mission() -> LayersMission {
    let skill = |action: &str| Skill { action: action.into(), duration: 3.0, pace: 1.0 };
    let anna = Agent {
        place: [0.0, 0.5, 0.0],
        body: Body::Human { speed: 0.5, slowing: 0.0 },
        skills: vec![skill("open"), skill("close")],
        ..arm("<b>anna</b>", 0.0)
    };
    let object = |number: usize| Object {
        name: format!("block_{number}"),
        place: [0.1 * number as f64, 0.0, 0.0],
        mass: 0.1,
        features: ["block".to_string()].into(),
    };
    let task = |name: &str, layer: usize, action: &str, features: &[&str]| Task {
        name: name.into(),
        layer,
        action: action.into(),
        features: features.iter().map(|f| (*f).to_string()).collect(),
        path: vec![[0.0, 0.2, 0.1]],
        object: None,
        agent: None,
    };
    let problem = Problem {
        agents: vec![arm("left", -0.4), anna, arm("right", 0.4)],
        objects: (0..4).map(object).collect(),
        layers: ["opened", "filled", "closed"].map(String::from).to_vec(),
        tasks: vec![
            task("lid", 0, "open", &[]),
            task("one", 1, "pick", &["block"]),
            task("two", 1, "pick", &["block"]),
            task("shut", 2, "close", &[]),
        ],
        weights: Weights { workload: 1.0, energy: 1.0, makespan: 10.0 },
        returns: true,
        start: 0.0,
        begun: vec![],
        places: BTreeMap::from([("box".into(), [0.0, 0.2, 0.1])]),
        labels: Default::default(),
    };
    let budget = Budget { nodes: 50, ..Budget::default() };
    let planning = choose::Options { budget, ..choose::Options::default() };
    LayersMission { name: "box".into(), problem, settings: Settings { planning, ..Settings::default() } }
}

fn running(options: &Options) -> Running {
    Running { server: Some(Server::start(mission(), options).expect("a server")) }
}

fn at_speed(speed: f64) -> Running {
    running(&Options { speed, begin: true, ..Options::default() })
}

fn may(what: &'static str) -> impl Fn(&Json) -> bool {
    move |state| state["person"]["may"][what] == true
}

const ANNA: Option<&str> = Some("<b>anna</b>");

#[test]
fn a_person_tells_what_she_does_and_the_others_follow() {
    let on = at_speed(20.0);
    assert_eq!(on.server().links().len(), 2, "arms have no pages");
    let (anna, supervisor) = (on.open(ANNA), on.supervisor());
    let state = anna.until(may("begin"));
    assert_eq!(state["person"]["doing"], "Your turn: lid: open, to box.");
    assert!(state["person"]["next"].as_str().expect("text").starts_with("shut: close"));
    assert_eq!((&state["person"]["at"], &state["person"]["service"]), (&json!(0), &Json::Null));
    // Her task never begins by itself, however late it is.
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert_eq!(anna.state()["person"]["may"]["begin"], true);
    assert_eq!(supervisor.state()["robots"][0]["doing"], "waits for the layer before");
    let early = anna.press("done", 0);
    assert_eq!((early.status, early.said().contains("not yours now")), (409, true));
    assert!(anna.press("begin", 0).said().starts_with("Noted: lid began at"));
    assert_eq!(anna.press("begin", 0).said(), "lid has begun already.");
    assert_eq!(anna.state()["person"]["doing"], "You do lid: open, to box.");
    assert!(anna.press("failed", 0).said().starts_with("Noted: lid failed."));
    assert_eq!(anna.press("failed", 0).status, 409);
    assert_eq!(anna.press("begin", 0).status, 200);
    let until = || anna.state()["person"]["until"].as_f64().expect("she works");
    let later = until() + 45.0;
    let longer = json!({ "what": "longer", "operation": 0, "until": later });
    assert!(anna.tell(longer.clone()).said().starts_with("Noted: lid takes 45 s longer, until"));
    assert!(anna.tell(longer).said().starts_with("That was noted before"));
    assert!(
        supervisor.tell(json!({ "what": "longer", "agent": 0, "until": later + 30.0 })).said().starts_with("Noted")
    );
    assert!((until() - later - 30.0).abs() < 1e-6);
    let row = supervisor.state()["agents"][0].clone();
    assert_eq!((row["until"].as_f64(), &row["fails"]), (Some(until()), &json!(true)));
    let failed = json!({ "what": "failed", "agent": 0, "until": until() });
    assert!(supervisor.tell(failed.clone()).said().starts_with("Noted"));
    assert!(supervisor.tell(failed).said().starts_with("That was noted before"));
    assert_eq!(anna.press("begin", 0).status, 200);
    assert!(anna.press("done", 0).said().starts_with("Noted: lid was done at"));
    assert_eq!(anna.press("done", 0).said(), "lid is done already.");
    assert!(anna.press("serve", 0).said().contains("nobody is served"));
    let state = anna.until(may("begin"));
    assert_eq!(state["person"]["at"], 3);
    assert!(state["person"]["messages"].to_string().contains("Layer filled is done."));
    anna.press("begin", 3);
    anna.press("done", 3);
    let over = supervisor.until(|state| !state["over"].is_null());
    assert_eq!(over["over"], "The mission is done: every task is done.");
    assert!(over["numbers"].as_str().expect("text").starts_with("4 of 4 tasks done"));
    assert_eq!(anna.state()["person"]["note"], "The mission is done. Thank you.");
    let steps = anna.state()["person"]["steps"].clone();
    assert!(steps.as_array().expect("a list").iter().all(|step| step["state"] == "done"), "{steps}");
}

#[test]
fn somebody_leaves_and_an_arm_breaks_down() {
    let on = at_speed(5.0);
    let (anna, supervisor) = (on.open(ANNA), on.supervisor());
    anna.until(may("begin"));
    // The second arm, and not the second agent.
    assert!(supervisor.tell(json!({ "what": "lost", "robot": 1 })).said().starts_with("Noted"));
    let state = supervisor.state();
    assert_eq!(state["robots"][1]["name"], "right");
    assert_eq!((&state["robots"][1]["lost"], &state["agents"][0]["lost"]), (&json!(true), &json!(false)));
    assert!(anna.state()["person"]["messages"].to_string().contains("right takes no part any more."));
    supervisor.tell(json!({ "what": "lost", "agent": 0 }));
    let state = supervisor.state();
    assert!(state["note"].as_str().expect("a note").starts_with("There is no plan for everything"), "{state:#}");
    assert!(state["over"].is_null());
    assert!(anna.state()["person"]["note"].as_str().expect("a note").contains("you left"));
    assert_eq!(supervisor.tell(json!({ "what": "back", "agent": 0 })).said(), "Noted; planned anew.");
    assert_eq!(supervisor.tell(json!({ "what": "back", "robot": 1 })).said(), "Noted; planned anew.");
    assert_eq!(supervisor.tell(json!({ "what": "replan" })).said(), "Noted; planned anew.");
    assert!(supervisor.state()["note"].is_null());
    for (body, why) in [
        (json!({ "what": "back", "robot": 0 }), "is not lost"),
        (json!({ "what": "lost", "robot": 2 }), "nobody of that number"),
        (json!({ "what": "lost" }), "not both"),
        (json!({ "what": "moved", "agent": 0, "place": [1, 1] }), "stay where they are"),
    ] {
        let refused = supervisor.tell(body);
        assert!(refused.status == 409 && refused.said().contains(why), "{refused:?}");
    }
    let chart = supervisor.get("/supervisor/gantt.svg").body;
    assert!(chart.starts_with("<svg") && chart.contains("right"), "{chart}");
    assert!(!chart.contains("<b>") && supervisor.state()["moves"] == false);
    // The map shows the hands of robots at their positions.
    let map = supervisor.get("/supervisor/map.svg").body;
    assert!(map.starts_with("<svg") && map.contains("class=\"carries"), "{map}");
    let state = supervisor.state();
    assert_eq!(state["robots"].as_array().map(Vec::len), Some(2));
    assert!(state["robots"][0]["at"].as_array().is_some_and(|at| at.len() == 2));
}

fn path(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("serve_layers");
    std::fs::create_dir_all(&folder).expect("writable");
    let path = folder.join(name);
    for old in [path.clone(), folder.join(format!("{name}.key"))] {
        let _ = std::fs::remove_file(old);
    }
    path
}

#[test]
fn a_mission_goes_on_where_its_journal_ends() {
    let path = path("goes_on.journal");
    let options = |begin| Options { speed: 10.0, begin, journal: Some(path.clone()), ..Options::default() };
    let on = running(&options(true));
    let (anna, supervisor) = (on.open(ANNA), on.supervisor());
    anna.until(may("begin"));
    anna.press("begin", 0);
    supervisor.tell(json!({ "what": "lost", "robot": 0 }));
    anna.press("done", 0);
    supervisor.tell(json!({ "what": "stop" }));
    let lasting = |state: &Json| json!([state["events"], state["status"], state["numbers"], state["robots"]]);
    let before = lasting(&supervisor.state());
    on.end();
    let again = running(&options(false));
    let (time, same) = again.server().resumed().expect("a journal");
    assert!(same && time > 0.0);
    assert_eq!(lasting(&again.supervisor().state()), before);
    assert!(before.to_string().contains("left is lost"));
    again.end();
    // A mission of the other kind rejects the journal.
    let Err(refused) = Server::start(super::mission(), &options(false)) else { panic!("it runs") };
    assert!(refused.to_string().contains("of another mission"), "{refused}");
}

#[test]
fn people_without_a_page_are_simulated() {
    let simulate = vec!["<b>anna</b>".to_string()];
    let on = running(&Options { speed: 40.0, begin: true, simulate, ..Options::default() });
    assert_eq!(on.server().links().len(), 1);
    on.supervisor().until(|state| !state["over"].is_null());
    let nobody = Options { simulate: vec!["left".into()], ..Options::default() };
    let Err(refused) = Server::start(mission(), &nobody) else { panic!("it runs") };
    assert!(refused.to_string().contains("no person of that name; it has <b>anna</b>"), "{refused}");
}
