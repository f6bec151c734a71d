//! A server that ends, in whatever way, and one that goes on where it was.

use std::path::PathBuf;

use hierarq::serve::Options;
use serde_json::{Value as Json, json};

use crate::Running;

fn path(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("serve");
    std::fs::create_dir_all(&folder).expect("writable");
    let path = folder.join(name);
    let _ = std::fs::remove_file(&path);
    path
}

fn options(journal: &std::path::Path, begin: bool) -> Options {
    Options { speed: 10.0, begin, journal: Some(journal.into()), ..Options::default() }
}

/// What must be the same after a crash: everything but when a page was opened.
fn lasting(state: &Json) -> Json {
    json!([state["events"], state["status"], state["numbers"], state["robots"]])
}

#[test]
fn a_mission_goes_on_where_its_journal_ends() {
    let path = path("goes_on.journal");
    let on = Running::with(&options(&path, true));
    assert_eq!(on.server().resumed(), None);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    anna.until(|state| state["person"]["may"]["done"] == true);
    anna.press("done", 0);
    supervisor.tell(json!({ "what": "lost", "robot": 1 }));
    anna.until(|state| state["person"]["may"]["serve"] == true);
    assert_eq!(anna.press("serve", 0).status, 200);
    anna.until(|state| !state["person"]["ask"].is_null());
    assert_eq!(
        anna.tell(json!({ "what": "feedback", "operation": 0, "wait": 2, "approach": 0, "distance": 0 })).status,
        200
    );
    supervisor.tell(json!({ "what": "stop" }));
    let before = supervisor.state();
    // What is on the disk at this moment is what a crash leaves, with half a line at its end.
    let crashed = self::path("crashed.journal");
    let mut bytes = std::fs::read(&path).expect("readable");
    bytes.extend(b"{\"time\":99");
    std::fs::write(&crashed, bytes).expect("writable");
    on.end();
    for journal in [path, crashed] {
        let again = Running::with(&options(&journal, false));
        let (time, same) = again.server().resumed().expect("a journal");
        assert!(same);
        assert!(time > 0.0 && time <= before["time"].as_f64().expect("a time"), "{time}");
        let (anna, supervisor) = (again.anna(), again.supervisor());
        let events = supervisor.state()["events"].to_string();
        assert!(events.contains("the wait was too long") && events.contains("m2 is lost"), "{events}");
        let page = anna.state();
        assert!(page["person"]["ask"].is_null(), "she has answered: {page:#}");
        assert_eq!(page["person"]["measured"][1]["name"], "Service 1");
        assert_eq!(supervisor.state()["robots"][1]["lost"], true);
        supervisor.tell(json!({ "what": "run" }));
        anna.until(|state| state["person"]["may"]["done"] == true);
    }
}

#[test]
fn the_same_journal_gives_the_same_state() {
    let path = path("same.journal");
    let on = Running::with(&options(&path, true));
    let (anna, ben) = (on.anna(), on.ben());
    for client in [&anna, &ben] {
        client.until(|state| state["person"]["may"]["done"] == true);
        client.press("done", 0);
    }
    on.end();
    let states: Vec<Json> = (0..2)
        .map(|_| {
            let again = Running::with(&options(&path, false));
            lasting(&again.supervisor().state())
        })
        .collect();
    assert_eq!(states[0], states[1]);
    assert!(states[0].to_string().contains("anna is done"));
}

#[test]
fn a_journal_of_another_mission_is_refused() {
    let path = path("other.journal");
    Running::with(&options(&path, false)).end();
    let mut other = crate::mission();
    other.problem.agents[0].operations = 3;
    let Err(refused) = hierarq::serve::Server::start(other, &options(&path, false)) else { panic!("it runs") };
    assert!(refused.to_string().contains("before the spec or an option changed"), "{refused}");
}
