//! Web pages of all kinds: the requests of their buttons are valid, and recorded requests restore the same pages.

use serde_json::{Value, json};

use crate::common::{Random, vineyard};
use crate::layered;
use crate::searched::{hidden, light_and_panel};
use hierarq_mission::kind::Mission;
use hierarq_mission::kind::pages::{
    Button, Client, JournalSink, MissionSession, Refusal, Request, ServeSettings, Session,
};
use hierarq_mission::kinds::layers::Layers;
use hierarq_mission::kinds::schedule::Schedule;
use hierarq_mission::kinds::search::Search;
use hierarq_mission::kinds::search::problem::Detection;

/// A mission with the requests that had an effect.
struct Recorded {
    session: MissionSession,
    journal: Vec<(f64, Request)>,
}

impl Recorded {
    fn press(&mut self, request: Request) -> Result<String, Refusal> {
        let (time, mut recorded) = (self.session.time(), 0);
        let mut write = || {
            recorded += 1;
            Ok(())
        };
        let reply = self.session.handle(&request, true, &mut JournalSink::new(&mut write));
        assert!(recorded <= 1, "a request is recorded once: {request:?}");
        if recorded == 1 {
            self.journal.push((time, request));
        }
        reply
    }
}

/// Returns the requests of all enabled buttons and of all forms.
fn requests(session: &MissionSession, random: &mut Random) -> Vec<Request> {
    let data = session.data(true);
    let mut point = || json!([random.within(-3.0, 6.0), random.within(-9.0, 4.0)]);
    let mut all = Vec::new();
    let mut add = |from: Client, button: &Button| {
        let mut body = button.request.clone();
        if let Some(input) = &button.point {
            body[input.key] = point();
        }
        if button.enabled {
            all.push(Request { from, body });
        }
    };
    let rows = data.supervisor.members.iter().flat_map(|row| &row.buttons);
    data.supervisor.buttons.iter().chain(rows).for_each(|button| add(Client::Supervisor, button));
    for (member, page) in &data.people {
        page.content.groups.iter().flat_map(|group| &group.buttons).for_each(|of| add(Client::Person(*member), of));
    }
    for (member, form) in data.people.iter().filter_map(|(member, page)| Some((member, page.content.form.as_ref()?))) {
        let mut body = form.request.clone();
        for question in &form.questions {
            let answer = random.below(question.answers.len());
            body[question.key] = Value::from(question.answers[answer].value);
        }
        all.push(Request { from: Client::Person(*member), body });
    }
    all
}

/// Advances as the server does: several requests may come at the same time.
fn advance(session: &mut MissionSession, to: f64) {
    if to > session.time() {
        session.advance(to);
    }
}

fn people_press(mission: &dyn Mission, nodes: u64, seed: u64) {
    let reporting: Vec<usize> = (0..).zip(mission.members()).filter(|of| of.1.role == "human").map(|of| of.0).collect();
    let settings = ServeSettings { sampled: Some(seed), reporting: reporting.clone(), nodes: Some(nodes) };
    let begin = || MissionSession::new(mission, &settings).unwrap();
    let mut on = Recorded { session: begin(), journal: Vec::new() };
    let mut random = Random(seed.wrapping_mul(7919).wrapping_add(3));
    assert!(on.session.data(true).people.keys().eq(&reporting));
    for _ in 0..60 {
        if random.unit() < 0.5 {
            on.session.advance(on.session.time() + random.within(0.0, 40.0));
            continue;
        }
        let mut all = requests(&on.session, &mut random);
        if all.is_empty() {
            continue;
        }
        let request = all.swap_remove(random.below(all.len()));
        let reply = on.press(request.clone());
        assert!(!matches!(reply, Err(Refusal::Invalid(_))), "{request:?} {reply:?}");
    }
    assert!(on.journal.len() > 10, "{:?}", on.journal);
    let mut again = begin();
    for (time, request) in &on.journal {
        advance(&mut again, *time);
        let reply = again.handle(request, true, &mut JournalSink::replay());
        assert!(!matches!(reply, Err(Refusal::Invalid(_))), "{request:?} {reply:?}");
    }
    advance(&mut again, on.session.time());
    let (was, is) = (on.session.data(true), again.data(true));
    assert_eq!(was.people, is.people);
    assert_eq!(was.supervisor, is.supervisor);
    // While the clock is stopped, people can press no button.
    let stopped = on.session.data(false);
    let mut buttons = stopped.people.values().flat_map(|page| &page.content.groups).flat_map(|group| &group.buttons);
    assert!(buttons.all(|button| !button.enabled));
}

#[test]
fn people_of_a_schedule_press_buttons() {
    for seed in 0..4 {
        let (problem, adaptation) = (vineyard(2), Default::default());
        people_press(&Schedule { problem, adaptation, reallocate_above: 0.1, batch: 4 }, 0, seed);
    }
}

#[test]
fn people_of_layers_press_buttons() {
    for seed in 0..8 {
        let (problem, instruction, directives) = (layered::letter_d(1), None, Vec::new());
        people_press(&Layers { problem, batch: None, reallocate_above: 0.1, instruction, directives }, 5, seed);
    }
}

#[test]
fn people_of_a_search_press_buttons() {
    for seed in 0..8 {
        let mut problem = light_and_panel(true);
        problem.horizon = 600.0;
        people_press(&Search { problem }, 500, seed);
    }
}

/// Requests that can never succeed are rejected as invalid, and not recorded.
#[test]
fn invalid_requests_are_not_recorded() {
    let (problem, adaptation) = (vineyard(2), Default::default());
    let mission = Schedule { problem, adaptation, reallocate_above: 0.1, batch: 4 };
    let settings = ServeSettings { sampled: None, reporting: vec![2, 3, 4], nodes: Some(0) };
    let mut on = Recorded { session: MissionSession::new(&mission, &settings).unwrap(), journal: Vec::new() };
    let person = |body: Value| Request { from: Client::Person(2), body };
    let supervisor = |body: Value| Request { from: Client::Supervisor, body };
    for request in [
        person(json!(null)),
        person(json!({ "what": "done" })),
        person(json!({ "what": "done", "operation": 2 })),
        person(json!({ "what": "feedback", "operation": 0, "wait": 3, "approach": 0, "distance": 0 })),
        Request { from: Client::Person(5), body: json!({ "what": "done", "operation": 0 }) },
        supervisor(json!({ "what": "lost" })),
        supervisor(json!({ "what": "lost", "member": 6 })),
        supervisor(json!({ "what": "late", "member": 2 })),
        supervisor(json!({ "what": "late", "member": 2, "by": 1e300 })),
        supervisor(json!({ "what": "late", "member": 2, "by": 5, "to": [0, 0] })),
        supervisor(json!({ "what": "begun", "member": 0 })),
        supervisor(json!({ "what": "replan", "by": 5 })),
    ] {
        let reply = on.press(request.clone());
        assert!(matches!(reply, Err(Refusal::Invalid(_))), "{request:?} {reply:?}");
    }
    assert!(on.journal.is_empty(), "{:?}", on.journal);
}

/// A request about an activity that is over, a position that is not free and one outside the map change nothing.
#[test]
fn requests_of_a_search_that_come_too_late_are_told_so() {
    let settings = ServeSettings { sampled: None, reporting: vec![1], nodes: Some(500) };
    let mission = Search { problem: light_and_panel(true) };
    let mut on = Recorded { session: MissionSession::new(&mission, &settings).unwrap(), journal: Vec::new() };
    on.session.advance(1.0);
    let anna = |body: Value| Request { from: Client::Person(1), body };
    let done = |activity: usize| anna(json!({ "what": "done", "activity": activity }));
    for request in [
        anna(json!({ "what": "my_pose" })),
        anna(json!({ "what": "my_pose", "number": 0 })),
        anna(json!({ "what": "my_pose", "number": 0, "to": [1e300, 0] })),
        anna(json!({ "what": "my_pose", "number": 0, "to": [4, 4], "at": [4, 4] })),
        anna(json!({ "what": "robot_goal", "number": 0, "to": [4, 4] })),
        anna(json!({ "what": "robot_goal", "number": 0, "agent": 9, "to": [4, 4] })),
        anna(json!({ "what": "done" })),
        anna(json!({ "what": "failed", "activity": 0 })),
        Request { from: Client::Supervisor, body: json!({ "what": "lost", "member": 2 }) },
        Request { from: Client::Person(0), body: json!({ "what": "done", "activity": 0 }) },
    ] {
        let reply = on.press(request.clone());
        assert!(matches!(reply, Err(Refusal::Invalid(_))), "{request:?} {reply:?}");
    }
    for request in [
        done(1),
        anna(json!({ "what": "my_pose", "number": 0, "to": [-1, 3] })),
        anna(json!({ "what": "my_pose", "number": 0, "to": [0.1, 3] })),
        anna(json!({ "what": "my_goal", "number": 0, "to": [0.1, 3] })),
        anna(json!({ "what": "robot_goal", "number": 0, "agent": 1, "to": [4, 4] })),
        anna(json!({ "what": "my_pose", "number": 0, "to": [4, 4], "time": 30 })),
        anna(json!({ "what": "my_pose", "number": 3, "to": [4, 4] })),
        anna(json!({ "what": "free", "number": 0, "agent": 1 })),
    ] {
        let reply = on.press(request.clone());
        assert!(matches!(reply, Err(Refusal::NotNow(_))), "{request:?} {reply:?}");
    }
    assert!(on.journal.is_empty(), "{:?}", on.journal);
    assert!(on.press(done(0)).unwrap().starts_with("Noted: done at"));
    assert_eq!(on.press(done(0)).unwrap(), "This activity is done already.");
    assert_eq!(on.journal.len(), 1);
}

/// A find is reported by the button of the page, once, however often it is pressed; the page shows the count.
#[test]
fn a_find_is_reported_once() {
    let mut problem = light_and_panel(true);
    problem.agents[1].sees = Some(Detection { within: 4.0, rate: 0.1 });
    problem.objects.push(hidden("token", 2, 5.0));
    let settings = ServeSettings { sampled: None, reporting: vec![1], nodes: Some(500) };
    let mission = Search { problem };
    let mut on = Recorded { session: MissionSession::new(&mission, &settings).unwrap(), journal: Vec::new() };
    on.session.advance(1.0);
    let button = |on: &Recorded| {
        let groups = on.session.data(true).people[&1].content.groups.clone();
        let group = groups.into_iter().find(|group| group.heading.starts_with("Hidden objects"))?;
        let request = Request { from: Client::Person(1), body: group.buttons[0].request.clone() };
        Some((group.heading, group.buttons[0].text.to_string(), request))
    };
    let (heading, text, first) = button(&on).unwrap();
    assert_eq!((heading.as_str(), text.as_str()), ("Hidden objects, 0 of 2 found", "Found: token"));
    assert!(on.press(first.clone()).unwrap().starts_with("Noted: found at"));
    assert_eq!(on.press(first.clone()).unwrap(), "This find is noted already.");
    let (heading, _, second) = button(&on).unwrap();
    assert_eq!(heading, "Hidden objects, 1 of 2 found");
    on.press(second).unwrap();
    assert!(button(&on).is_none(), "nothing is hidden any more");
    assert_eq!(on.press(first).unwrap(), "This find is noted already.");
    let third = Request { from: Client::Person(1), body: json!({ "what": "found", "object": 0, "found": 2 }) };
    assert!(matches!(on.press(third), Err(Refusal::NotNow(_))));
    let nobody = Request { from: Client::Person(1), body: json!({ "what": "found", "object": 1, "found": 0 }) };
    assert!(matches!(on.press(nobody), Err(Refusal::Invalid(_))));
    assert_eq!(on.journal.len(), 2);
}

/// Each message has its effect once: one that comes twice is noted already, one that is older than the last is refused, and so
/// is one from the future. The roles follow from the goals that are told.
#[test]
fn messages_of_a_person_count_once() {
    let settings = ServeSettings { sampled: None, reporting: vec![1], nodes: Some(500) };
    let mission = Search { problem: light_and_panel(true) };
    let mut on = Recorded { session: MissionSession::new(&mission, &settings).unwrap(), journal: Vec::new() };
    on.session.advance(2.0);
    let anna = |body: Value| Request { from: Client::Person(1), body };
    let detail = |on: &Recorded| on.session.data(true).people[&1].content.detail.clone().unwrap();
    assert!(detail(&on).contains("leader-follower"));
    let goal = anna(json!({ "what": "my_goal", "number": 0, "to": [4, 4], "time": 1.5 }));
    assert_eq!(on.press(goal.clone()).unwrap(), "Noted: you go to (4.0, 4.0) m. There is a new plan.");
    assert_eq!(on.press(goal).unwrap(), "This message is noted already.");
    assert!(detail(&on).contains("peer-to-peer"));
    let robot = anna(json!({ "what": "robot_goal", "number": 1, "agent": 0, "to": [2, 7] }));
    assert_eq!(on.press(robot).unwrap(), "Noted: robot goes to (2.0, 7.0) m. There is a new plan.");
    assert!(detail(&on).contains("master-slave"));
    let late = on.press(anna(json!({ "what": "my_pose", "number": 2, "to": [5, 2], "time": 1 })));
    assert!(matches!(&late, Err(Refusal::NotNow(why)) if why.contains("later message")), "{late:?}");
    let future = on.press(anna(json!({ "what": "my_pose", "number": 2, "to": [5, 2], "time": 90 })));
    assert!(matches!(&future, Err(Refusal::NotNow(why)) if why.contains("future: it says 1:30")), "{future:?}");
    assert!(on.press(anna(json!({ "what": "free", "number": 2, "agent": 1 }))).is_ok());
    assert!(detail(&on).contains("leader-leader"));
    assert_eq!(on.journal.len(), 3);
    let page = &on.session.data(true).people[&1].content;
    assert!(
        page.groups.iter().any(|group| group.heading == "Messages, sent: 1 goal, 1 robot goal"),
        "{:?}",
        page.groups
    );
    let buttons = page.groups.iter().flat_map(|group| &group.buttons);
    let buttons: Vec<&str> = buttons.map(|button| button.text.as_ref()).collect();
    for text in ["My pose", "My goal", "Robot goal", "Robot pose", "Replan"] {
        assert_eq!(buttons.iter().filter(|button| **button == text).count(), 1, "{buttons:?}");
    }
    assert_eq!(page.map.as_ref().map(|map| map.marks.len()), Some(2));
}
