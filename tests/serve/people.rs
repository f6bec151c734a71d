//! Two people and a supervisor, each with a page, during a mission.

use hierarq::serve::Options;
use serde_json::{Value as Json, json};

use super::client::{may, row};
use super::{ANNA, M1, M2, Running};

#[test]
fn nothing_happens_before_the_clock_runs() {
    let on = Running::standing();
    let (anna, supervisor) = (on.anna(), on.supervisor());
    let state = anna.state();
    assert_eq!((&state["running"], &state["time"]), (&json!(false), &json!(0.0)));
    assert!(state["person"]["note"].as_str().expect("a note").contains("is stopped"));
    assert!(["begin", "done", "serve", "served"].into_iter().all(|what| !may(what)(&state)));
    let early = anna.press("done", 0);
    assert_eq!(early.status, 409);
    assert!(early.said().contains("is stopped"), "{early:?}");
    assert_eq!(supervisor.tell(json!({ "what": "run" })).said(), "The clock runs from 0:00.");
    let state = anna.until(may("done"));
    assert_eq!(state["person"]["doing"], "You work on operation 1 of 2.");
    assert!(supervisor.tell(json!({ "what": "stop" })).said().starts_with("The clock is stopped at 0:0"));
    let stood = anna.state()["time"].clone();
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(anna.state()["time"], stood);
}

#[test]
fn two_people_work_at_once_and_the_plan_follows_both() {
    let on = Running::at_speed(10.0);
    let (anna, ben, supervisor) = (on.anna(), on.ben(), on.supervisor());
    anna.until(may("done"));
    let planned = anna.state()["person"]["countdown"].as_f64().expect("a robot is planned");
    // Both press at once, much earlier than planned, and each twice.
    let press = |client: &super::client::Client| {
        let client = client.clone();
        std::thread::spawn(move || [client.press("done", 0), client.press("done", 0)])
    };
    for pressed in [press(&anna), press(&ben)] {
        let [first, second] = pressed.join().expect("pressed");
        assert_eq!((first.status, second.status), (200, 200), "{first:?} {second:?}");
        assert!(first.said().starts_with("Noted: operation 1 ended at"), "{first:?}");
        assert_eq!(second.said(), "Operation 1 is finished already.");
    }
    let comes = anna.state()["person"]["countdown"].as_f64().expect("a robot comes");
    assert!(comes < planned, "{comes} {planned}");
    let served =
        anna.until(|state| state["person"]["doing"].as_str().is_some_and(|text| text.ends_with("serves you.")));
    assert!(may("serve")(&served));
    assert_eq!(anna.press("serve", 0).status, 200);
    let ended = anna.press("served", 0);
    assert!(ended.said().contains("You measured"), "{ended:?}");
    let state = anna.until(|state| !state["person"]["form"].is_null());
    assert_eq!(state["person"]["form"]["request"], json!({ "what": "feedback", "operation": 0 }));
    let feedback = json!({ "what": "feedback", "operation": 0, "wait": 2, "approach": -1, "distance": -2 });
    let told = anna.tell(feedback.clone());
    assert!(told.said().starts_with("Thank you."), "{told:?}");
    assert_eq!(anna.tell(feedback).said(), "Thank you. This was noted before, or is about an earlier service.");
    assert!(anna.state()["person"]["form"].is_null());
    let events = supervisor.state()["events"].to_string();
    assert!(
        events.contains("anna says: the wait was too long, the robot came fast, it waited very far away"),
        "{events}"
    );
    assert_eq!(events.matches("anna is done").count(), 1);
}

#[test]
fn a_page_that_comes_back_has_everything() {
    let on = Running::at_speed(20.0);
    let anna = on.anna();
    let mut stream = anna.listen();
    assert_eq!(stream.status, 200);
    stream.until(may("done"));
    drop(stream);
    // An event occurs while no page is listening.
    assert_eq!(anna.press("done", 0).status, 200);
    let mut again = anna.listen();
    let first = again.next().expect("a state");
    let text = first["person"]["messages"].to_string();
    assert!(text.contains("Your operation 1 is finished."), "the first state is whole: {first:#}");
    let latest = anna.state();
    assert_eq!(first["person"]["name"], latest["person"]["name"]);
    // Streams continue by themselves.
    again.until(|state| state["person"]["doing"].as_str().is_some_and(|text| text.ends_with("serves you.")));
}

#[test]
fn a_session_has_three_streams_and_the_newest_stay() {
    let on = Running::standing();
    let anna = on.anna();
    let mut streams: Vec<_> = (0..4).map(|_| anna.listen()).collect();
    for stream in streams.iter_mut().skip(1) {
        assert!(stream.next().is_some());
    }
    let mut oldest = streams.remove(0);
    while oldest.next().is_some() {}
    assert!(streams[2].next().is_some(), "the newest goes on");
}

#[test]
fn a_robot_breaks_down_and_the_other_takes_over() {
    let on = Running::at_speed(20.0);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    anna.until(may("done"));
    let told = supervisor.tell(json!({ "what": "lost", "member": M1 }));
    assert!(told.said().starts_with("Noted"), "{told:?}");
    let state = supervisor.until(|state| row(state, M1)["lost"] == true);
    assert_eq!(row(&state, M1)["doing"], "broken down");
    assert!(anna.state()["person"]["next"].as_str().expect("text").starts_with("m2 comes to you"));
    assert!(anna.state()["person"]["messages"].to_string().contains("m1 has broken down."));
    // The second one too: there is no plan any more, and the pages report it.
    supervisor.tell(json!({ "what": "lost", "member": M2 }));
    let state = supervisor.until(|state| !state["over"].is_null());
    assert_eq!(state["over"], "There is no plan any more: every robot is lost.");
    assert_eq!(state["status"], "no plan");
    assert!(!state["numbers"].as_str().expect("text").contains("ends at"), "{state:#}");
    let page = anna.state();
    assert!(page["person"]["note"].as_str().expect("a note").contains("every robot is lost"));
    assert!(!page["person"]["steps"].to_string().contains("serves at"), "{page:#}");
    supervisor.tell(json!({ "what": "back", "member": M2 }));
    supervisor.until(|state| state["over"].is_null());
    // The page of a person who has left has instructions, and no running activity.
    supervisor.tell(json!({ "what": "lost", "member": ANNA }));
    let page = anna.until(|state| state["person"]["doing"] == "You have left the mission.")["person"].clone();
    assert!(page["note"].as_str().expect("a note").ends_with("tell the supervisor."), "{page:#}");
    assert_eq!((&page["groups"][0]["heading"], &page["measured"]), (&json!("Operation"), &json!([])));
}

/// A failed service is repeated, a longer one keeps its robot, and so does a longer operation; a duplicated press
/// counts once.
#[test]
fn a_service_fails_and_another_takes_longer() {
    let on = Running::at_speed(10.0);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    let until = |state: &Json| state["person"]["until"].as_f64().expect("it goes on");
    let works = anna.until(may("longer"));
    let later = until(&works) + 30.0;
    let longer = json!({ "what": "longer", "operation": 0, "until": later });
    let told = anna.tell(longer.clone());
    assert!(told.said().starts_with("Noted: the operation takes 30 s longer"), "{told:?}");
    assert!(anna.tell(longer).said().starts_with("Already noted"));
    assert!((until(&anna.state()) - later).abs() < 1e-6);
    assert_eq!(anna.press("failed", 0).status, 409, "nobody serves her");
    anna.press("done", 0);
    let served = anna.until(may("failed"));
    let (robot, other) = match row(&supervisor.state(), M1)["fails"] == true {
        true => (0, 1),
        false => (1, 0),
    };
    let failed = json!({ "what": "failed", "operation": 0, "until": until(&served) });
    let told = anna.tell(failed.clone());
    assert!(told.said().starts_with("Noted: the service failed and is repeated, until"), "{told:?}");
    let again = until(&anna.state());
    assert!(again > until(&served), "{again}");
    assert!(anna.tell(failed).said().starts_with("Already noted"));
    assert_eq!(until(&anna.state()), again);
    let state = supervisor.state();
    assert_eq!((row(&state, robot)["until"].as_f64(), &row(&state, robot)["fails"]), (Some(again), &json!(true)));
    let longer = json!({ "what": "late", "member": robot, "by": 60.0, "until": again });
    assert!(supervisor.tell(longer).said().starts_with("Noted"));
    assert!((until(&anna.state()) - again - 60.0).abs() < 1e-6);
    let told = supervisor.tell(json!({ "what": "failed", "member": other }));
    assert!(told.status == 409 || row(&supervisor.state(), other)["fails"] == true, "{told:?}");
    assert!(anna.state()["person"]["messages"].to_string().contains("The service failed and is repeated."));
    let events = supervisor.state()["events"].to_string();
    assert!(events.contains("the service of anna fails") && events.contains("anna is late by 60 s"), "{events}");
    anna.press("served", 0);
    anna.until(|state| !state["person"]["form"].is_null());
}

/// For any number of replans, a page reports it once, and keeps its other messages.
#[test]
fn the_same_news_are_told_once() {
    let on = Running::at_speed(5.0);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    anna.until(may("done"));
    for _ in 0..3 {
        supervisor.tell(json!({ "what": "replan" }));
    }
    let told = anna.state()["person"]["messages"].to_string();
    assert_eq!(told.matches("There is a new plan.").count(), 1, "{told}");
    assert!(told.contains("Your operation 1 begins."), "{told}");
    assert!(supervisor.state()["numbers"].as_str().expect("text").ends_with("replanned 3 times"));
}

#[test]
fn somebody_moves_and_the_supervisor_plans_anew() {
    let on = Running::at_speed(5.0);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    anna.until(may("done"));
    let map = supervisor.get("/supervisor/map.svg").body;
    let told = supervisor.tell(json!({ "what": "moved", "member": ANNA, "to": [-4.0, 9.5] }));
    assert_eq!(told.status, 200, "{told:?}");
    assert!(anna.state()["person"]["messages"].to_string().contains("Robots now come to you at (-4.00, 9.50) m."));
    assert_ne!(map, supervisor.get("/supervisor/map.svg").body);
    let told = supervisor.tell(json!({ "what": "replan" }));
    assert_eq!(told.said(), "Noted; there is a new plan.");
}

#[test]
fn people_without_a_page_are_simulated() {
    let options = Options { speed: 40.0, begin: true, simulate: vec!["<b>ben</b>".into()], ..Options::default() };
    let on = Running::with(&options);
    assert_eq!(on.server().links().len(), 2);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    for operation in 0..2 {
        anna.until(may("done"));
        assert_eq!(anna.press("done", operation).status, 200);
    }
    let over = supervisor.until(|state| !state["over"].is_null());
    assert_eq!(over["over"], "The mission is done: all possible services are finished.");
    assert_eq!(row(&over, super::BEN)["doing"], "finished");
    assert_eq!(anna.state()["person"]["note"], "The mission is done. Thank you.");
}

#[test]
fn mistakes_in_options_are_explained() {
    let start = |options: &Options| match hierarq::serve::Server::start("field", &super::mission(), options) {
        Ok(_) => panic!("it runs"),
        Err(e) => e.to_string(),
    };
    let simulate = |name: &str| Options { simulate: vec![name.into()], ..Options::default() };
    assert_eq!(
        start(&simulate("carrier")),
        "`--simulate carrier`: the mission has no person of that name; it has anna, <b>ben</b>"
    );
    assert!(start(&Options { speed: 0.0, ..Options::default() }).contains("more than 0"));
    assert!(start(&Options { speed: f64::NAN, ..Options::default() }).contains("more than 0"));
    assert!(start(&Options { hosts: vec!["http://x".into()], ..Options::default() }).contains("write a name"));
    let on = Running::standing();
    let taken = Options { port: on.server().address().port(), ..Options::default() };
    assert!(start(&taken).starts_with("cannot listen at 127.0.0.1:"));
}
