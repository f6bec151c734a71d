//! Restarts of a server from its journal, after any kind of end.

use std::path::PathBuf;

use hierarq::serve::Options;
use serde_json::{Value as Json, json};

use super::client::{may, row};
use super::{ANNA, CARRIER, M2, Running};

fn path(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("serve");
    std::fs::create_dir_all(&folder).expect("writable");
    let path = folder.join(name);
    for old in [path.clone(), folder.join(format!("{name}.key"))] {
        let _ = std::fs::remove_file(old);
    }
    path
}

fn options(journal: &std::path::Path, begin: bool) -> Options {
    Options { speed: 10.0, begin, journal: Some(journal.into()), ..Options::default() }
}

/// Returns the part of the state that must be the same after a crash: everything except the state of pages.
fn lasting(state: &Json) -> Json {
    json!([state["events"], state["status"], state["numbers"], state["members"]])
}

#[test]
fn a_mission_goes_on_where_its_journal_ends() {
    let path = path("goes_on.journal");
    let on = Running::with(&options(&path, true));
    assert_eq!(on.server().resumed(), None);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    anna.until(may("done"));
    anna.press("done", 0);
    supervisor.tell(json!({ "what": "lost", "member": M2 }));
    anna.until(may("serve"));
    assert_eq!(anna.press("serve", 0).status, 200);
    anna.until(|state| !state["person"]["form"].is_null());
    assert_eq!(
        anna.tell(json!({ "what": "feedback", "operation": 0, "wait": 2, "approach": 0, "distance": 0 })).status,
        200
    );
    supervisor.tell(json!({ "what": "stop" }));
    let before = supervisor.state();
    // The present file is the journal after a crash, here with an incomplete last line.
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
        assert!(page["person"]["form"].is_null(), "she has answered: {page:#}");
        assert_eq!(page["person"]["measured"][1]["name"], "Service 1");
        assert_eq!(row(&supervisor.state(), M2)["lost"], true);
        supervisor.tell(json!({ "what": "run" }));
        anna.until(may("done"));
    }
}

#[test]
fn the_same_journal_gives_the_same_state() {
    let path = path("same.journal");
    let on = Running::with(&options(&path, true));
    let (anna, ben) = (on.anna(), on.ben());
    for client in [&anna, &ben] {
        client.until(may("done"));
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
    let mut other = super::mission();
    other.problem.agents[0].operations = 3;
    let Err(refused) = hierarq::serve::Server::start("field", &other, &options(&path, false)) else {
        panic!("it runs")
    };
    assert!(refused.to_string().contains("before the spec or an option changed"), "{refused}");
}

/// Unknown members, invalid steps of feedback, and requests of another kind of mission: the line is reported.
#[test]
fn what_could_never_have_been_told_is_refused_with_its_line() {
    let path = path("never.journal");
    Running::with(&options(&path, false)).end();
    let head = std::fs::read_to_string(&path).expect("readable");
    let feedback = json!({ "what": "feedback", "operation": 0, "wait": 127, "approach": 0, "distance": 0 });
    for (entry, words) in [
        (json!({ "from": { "person": 99 }, "body": { "what": "done", "operation": 0 } }), "member 99 has no page"),
        (json!({ "from": "supervisor", "body": { "what": "lost", "member": 99 } }), "no member with this number"),
        (json!({ "from": { "person": ANNA }, "body": feedback }), "127"),
        (json!({ "from": { "person": ANNA }, "body": { "what": "done", "task": 0 } }), "unknown field `task`"),
        (json!({ "from": { "person": ANNA }, "body": { "what": "serve", "operation": usize::MAX } }), "no operation"),
        (json!({ "from": { "person": CARRIER }, "body": { "what": "done", "operation": 0 } }), "has no page"),
    ] {
        let entry = json!({ "request": entry });
        std::fs::write(&path, format!("{head}{}\n", json!({ "time": 0.5, "entry": entry }))).expect("writable");
        let line = head.lines().count() + 1;
        let Err(refused) = hierarq::serve::Server::start("field", &super::mission(), &options(&path, false)) else {
            panic!("{entry} is taken")
        };
        let told = refused.to_string();
        assert!(told.starts_with(&format!("line {line} of the journal")) && told.contains(words), "{told}");
    }
}

/// An hour without reports: replaying it is fast, and its progress is reported.
#[test]
fn an_idle_hour_is_gone_through_quickly() {
    let path = path("idle.journal");
    Running::with(&options(&path, false)).end();
    let head = std::fs::read_to_string(&path).expect("readable");
    std::fs::write(&path, format!("{head}{}\n", json!({ "time": 3600.0, "entry": { "records": 10 } })))
        .expect("writable");
    let mut told = Vec::new();
    let mut tell = |at: hierarq::serve::Resuming| told.push(at);
    let begun = std::time::Instant::now();
    let on = hierarq::serve::Server::start_with_progress("field", &super::mission(), &options(&path, false), &mut tell)
        .expect("served");
    assert!(begun.elapsed() < std::time::Duration::from_secs(30), "{:?}", begun.elapsed());
    assert_eq!(on.resumed(), Some((3600.0, false)));
    assert_eq!((told[0].time, told[0].until), (0.0, 3600.0));
    assert!(told.len() > 10 && told.windows(2).all(|two| two[0].time <= two[1].time), "{told:?}");
    let _ = on.end().send(true);
    on.wait().expect("ended");
}
