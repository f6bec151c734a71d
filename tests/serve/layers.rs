//! A mission of layers with pages: a person who reports her tasks, two simulated arms, a supervisor.

use std::collections::BTreeMap;
use std::path::PathBuf;

use hierarq::serve::{Options, Server};
use mission::kinds::layers::Layers;
use mission::kinds::layers::problem::{Agent, Body, Object, Problem, Skill, Task, Weights};
use mission::numbers::{Energy, Range};
use serde_json::{Value as Json, json};

use super::Running;
use super::client::{button, may, row};

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
pub fn mission() -> Layers {
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
    Layers { problem, batch: None, reallocate_above: 0.1, instruction: None, directives: Vec::new() }
}

/// Members: an arm, a person, another arm.
const LEFT: usize = 0;
const SHE: usize = 1;
const RIGHT: usize = 2;

fn running(options: &Options) -> Running {
    let options = Options { nodes: Some(50), ..options.clone() };
    Running { server: Some(Server::start("box", &mission(), &options).expect("a server")) }
}

fn at_speed(speed: f64) -> Running {
    running(&Options { speed, begin: true, ..Options::default() })
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
    assert_eq!(button(&state, "begin")["request"], json!({ "what": "begin", "task": 0 }));
    assert_eq!(button(&state, "serve"), Json::Null, "nobody is served");
    // Her task never begins by itself, however late it is.
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(may("begin")(&anna.state()));
    assert_eq!(row(&supervisor.state(), LEFT)["doing"], "waits for the previous layer");
    let early = anna.press_task("done", 0);
    assert_eq!((early.status, early.said().contains("not yours now")), (409, true));
    assert!(anna.press_task("begin", 0).said().starts_with("Noted: lid began at"));
    assert_eq!(anna.press_task("begin", 0).said(), "lid has begun already.");
    assert_eq!(anna.state()["person"]["doing"], "You do lid: open, to box.");
    assert!(anna.press_task("failed", 0).said().starts_with("Noted: lid failed."));
    assert_eq!(anna.press_task("failed", 0).status, 409);
    assert_eq!(anna.press_task("begin", 0).status, 200);
    let until = || anna.state()["person"]["until"].as_f64().expect("she works");
    let later = until() + 45.0;
    let longer = json!({ "what": "longer", "task": 0, "until": later });
    assert!(anna.tell(longer.clone()).said().starts_with("Noted: lid takes 45 s longer, until"));
    assert!(anna.tell(longer).said().starts_with("Already noted"));
    assert!(
        supervisor
            .tell(json!({ "what": "late", "member": SHE, "by": 30.0, "until": later }))
            .said()
            .starts_with("Noted")
    );
    assert!((until() - later - 30.0).abs() < 1e-6);
    let state = supervisor.state();
    assert_eq!((row(&state, SHE)["until"].as_f64(), &row(&state, SHE)["fails"]), (Some(until()), &json!(true)));
    let failed = json!({ "what": "failed", "member": SHE, "until": until() });
    assert!(supervisor.tell(failed.clone()).said().starts_with("Noted"));
    assert!(supervisor.tell(failed).said().starts_with("Already noted"));
    assert_eq!(anna.press_task("begin", 0).status, 200);
    assert!(anna.press_task("done", 0).said().starts_with("Noted: lid was done at"));
    assert_eq!(anna.press_task("done", 0).said(), "lid is done already.");
    assert_eq!(anna.press_task("serve", 0).status, 400, "nobody is served");
    let state = anna.until(may("begin"));
    assert_eq!(button(&state, "begin")["request"]["task"], 3);
    assert!(state["person"]["messages"].to_string().contains("Layer filled is done."));
    anna.press_task("begin", 3);
    anna.press_task("done", 3);
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
    assert!(supervisor.tell(json!({ "what": "lost", "member": RIGHT })).said().starts_with("Noted"));
    let state = supervisor.state();
    assert_eq!(row(&state, RIGHT)["name"], "right");
    assert_eq!((&row(&state, RIGHT)["lost"], &row(&state, SHE)["lost"]), (&json!(true), &json!(false)));
    assert!(anna.state()["person"]["messages"].to_string().contains("right has left."));
    supervisor.tell(json!({ "what": "lost", "member": SHE }));
    let state = supervisor.state();
    assert!(state["note"].as_str().expect("a note").starts_with("There is no plan for everything"), "{state:#}");
    assert!(state["over"].is_null());
    assert!(anna.state()["person"]["note"].as_str().expect("a note").contains("you left"));
    assert_eq!(supervisor.tell(json!({ "what": "back", "member": SHE })).said(), "Noted; there is a new plan.");
    assert_eq!(supervisor.tell(json!({ "what": "back", "member": RIGHT })).said(), "Noted; there is a new plan.");
    assert_eq!(supervisor.tell(json!({ "what": "replan" })).said(), "Noted; there is a new plan.");
    assert!(supervisor.state()["note"].is_null());
    for (body, why) in [
        (json!({ "what": "back", "member": LEFT }), "is not lost"),
        (json!({ "what": "lost", "member": 3 }), "no member with this number"),
        (json!({ "what": "lost" }), "no member with this number"),
        (json!({ "what": "moved", "member": SHE, "to": [1, 1] }), "does not move"),
        (json!({ "what": "explode", "member": SHE }), "has no event `explode`"),
        (json!({ "what": "lost", "member": SHE, "x": 1 }), "no key `x`"),
        (json!({ "what": "replan", "member": SHE }), "of the whole mission"),
    ] {
        let refused = supervisor.tell(body);
        let status = if why == "is not lost" { 409 } else { 400 };
        assert!(refused.status == status && refused.said().contains(why), "{refused:?}");
    }
    let chart = supervisor.get("/supervisor/gantt.svg").body;
    assert!(chart.starts_with("<svg") && chart.contains("right"), "{chart}");
    assert!(!chart.contains("<b>") && !supervisor.state().to_string().contains("moved"));
    // The map shows the hands of robots at their positions.
    let map = supervisor.get("/supervisor/map.svg").body;
    assert!(map.starts_with("<svg") && map.contains("class=\"carries"), "{map}");
    let state = supervisor.state();
    assert_eq!(state["members"].as_array().map(Vec::len), Some(3));
    assert!(row(&state, LEFT)["at"].as_array().is_some_and(|at| at.len() == 2));
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
    anna.press_task("begin", 0);
    supervisor.tell(json!({ "what": "lost", "member": LEFT }));
    anna.press_task("done", 0);
    supervisor.tell(json!({ "what": "stop" }));
    let lasting = |state: &Json| json!([state["events"], state["status"], state["numbers"], state["members"]]);
    let before = lasting(&supervisor.state());
    on.end();
    let again = running(&options(false));
    let (time, same) = again.server().resumed().expect("a journal");
    assert!(same && time > 0.0);
    assert_eq!(lasting(&again.supervisor().state()), before);
    assert!(before.to_string().contains("left is lost"));
    again.end();
    // A mission of the other kind rejects the journal.
    let Err(refused) = Server::start("field", &super::mission(), &options(false)) else { panic!("it runs") };
    assert!(refused.to_string().contains("of another mission"), "{refused}");
}

#[test]
fn people_without_a_page_are_simulated() {
    let simulate = vec!["<b>anna</b>".to_string()];
    let on = running(&Options { speed: 40.0, begin: true, simulate, ..Options::default() });
    assert_eq!(on.server().links().len(), 1);
    on.supervisor().until(|state| !state["over"].is_null());
    let nobody = Options { simulate: vec!["left".into()], ..Options::default() };
    let Err(refused) = Server::start("box", &mission(), &nobody) else { panic!("it runs") };
    assert!(refused.to_string().contains("no person of that name; it has <b>anna</b>"), "{refused}");
}
