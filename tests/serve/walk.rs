//! A kind of mission that no list names has pages like all others.

use hierarq::serve::{Options, Server};
use serde_json::json;

use super::Running;
use super::client::{may, row};
use crate::toy_kind::walk;

#[test]
fn a_walk_is_served() {
    let walk = walk::Walk { speed: 0.01, ..crate::toy_kind::walk() };
    let options = Options { begin: true, ..Options::default() };
    let on = Running { server: Some(Server::start("day", &walk, &options).expect("a server")) };
    let (anna, supervisor) = (on.anna(), on.supervisor());
    let state = anna.until(may("arrived"));
    assert_eq!(state["person"]["doing"], "You walk to the place.");
    let late = supervisor.tell(json!({ "what": "late", "member": 0, "by": 5.0 }));
    assert_eq!(late.said(), "Noted; the plan was rescheduled.");
    assert_eq!(supervisor.tell(json!({ "what": "moved", "member": 0 })).status, 400);
    assert_eq!(anna.tell(json!({ "what": "arrived" })).said(), "Noted: you have arrived.");
    let state = supervisor.until(|state| !state["over"].is_null());
    assert_eq!(row(&state, 0)["doing"], "has arrived");
    for picture in ["/supervisor/gantt.svg", "/supervisor/map.svg"] {
        assert!(supervisor.get(picture).body.contains("anna"), "{picture}");
    }
    assert_eq!(anna.state()["person"]["note"], "The mission is done. Thank you.");
}
