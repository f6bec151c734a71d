//! Layers from a server: broken answers of every kind, and what the model is told of each.
use crate::common;

use std::collections::BTreeMap;
use std::time::Duration;

use common::{Reply, Server};
use hierarq_context::endpoint::Endpoint;
use hierarq_context::generate::{Bounds, GenerateError, Wish, prompt, tasks};
use hierarq_context::transcript::Exchange;
use mission::kind::generation::{Decides, Generated, Generation};
use mission::kinds::layers::Layers;
use mission::kinds::layers::json::{Mode, import};
use mission::kinds::layers::problem::{Agent, Body, Object, Problem, Skill, Weights};
use mission::numbers::{Energy, Range};

fn skill() -> Skill {
    Skill { action: "pick_and_place".into(), duration: 2.0, pace: 1.0 }
}

fn agent(name: &str, body: Body) -> Agent {
    Agent {
        name: name.into(),
        place: [0.0, 0.0, 0.0],
        body,
        skills: vec![skill()],
        reach: None,
        payload: None,
        cannot: Default::default(),
        spread: 0.0,
        lost: false,
    }
}

/// A person, an arm, two red cubes and a blue one.
fn problem() -> Problem {
    let cube = |name: &str, colour: &str| Object {
        name: name.into(),
        place: [0.3, 0.1, 0.0],
        mass: 0.2,
        features: ["cube", colour].map(String::from).into(),
    };
    let arm = Body::Robot { speed: Range::new(0.05, 0.1), energy: Energy::of_factor(1.0) };
    Problem {
        agents: vec![agent("anna", Body::Human { speed: 0.1, slowing: 0.5 }), agent("arm", arm)],
        objects: vec![cube("red_1", "red"), cube("red_2", "red"), cube("blue_1", "blue")],
        layers: Vec::new(),
        tasks: Vec::new(),
        weights: Weights { workload: 4.0, energy: 1.0, makespan: 10.0 },
        returns: true,
        start: 0.0,
        begun: Vec::new(),
        labels: Default::default(),
        places: BTreeMap::from([("corner".to_string(), [0.0, 0.1, 0.0])]),
    }
}

const GOOD: &str = r#"{"layers": [
  {"name": "base", "tasks": [{"name": "left", "action": "pick_and_place", "features": ["red"], "to": "corner"}]},
  {"name": "top", "tasks": [{"name": "roof", "action": "pick_and_place", "features": ["blue"], "to": [0.1, 0.0, 0.1]}]}]}"#;

fn mission(directives: &[&str]) -> Layers {
    Layers {
        problem: problem(),
        batch: None,
        reallocate_above: 0.1,
        instruction: None,
        directives: directives.iter().map(ToString::to_string).collect(),
    }
}

/// The problem of a generated mission.
fn generated(of: &Generated) -> &Problem {
    &of.mission.downcast::<Layers>().unwrap().problem
}

/// Result of a conversation with these answers, its exchanges with their refusals, and the server.
fn talk(answers: &[&str], decides: Decides) -> (Result<Generated, GenerateError>, Vec<Exchange>, Server) {
    let server = Server::new(answers.iter().map(|text| Reply::Says((*text).to_string())).collect());
    let mut endpoint = Endpoint::new(&server.address, "tiny", None, Duration::from_secs(2)).unwrap();
    let mission = mission(&["Objects must not overlap."]);
    let wish = Wish { mission: &mission, instruction: "Build a house.", decides };
    let mut kept = Vec::new();
    let outcome = tasks(&mut endpoint, &wish, &Bounds::default(), |exchange| {
        kept.push(exchange.clone());
        Ok(())
    });
    (outcome, kept, server)
}

#[test]
fn every_kind_of_broken_answer_goes_back_with_its_reason() {
    let truncated = &GOOD[..GOOD.len() - 40];
    let unknown = GOOD.replace("\"blue\"", "\"green\"").replace("corner", "cornr");
    let cyclic = r#"{"tasks": [
      {"name": "a", "action": "pick_and_place", "features": ["red"], "to": [0, 0, 0], "after": ["b"]},
      {"name": "b", "action": "pick_and_place", "features": ["blue"], "to": [0, 0, 0], "after": ["a"]}]}"#;
    let too_many = GOOD.replace(
        r#"{"name": "left""#,
        r#"{"name": "l2", "action": "pick_and_place", "features": ["red"], "to": [0, 0, 0]},
           {"name": "l3", "action": "pick_and_place", "features": ["red"], "to": [0, 0, 0]}, {"name": "left""#,
    );
    let (outcome, kept, server) = talk(&[truncated, &unknown, cyclic, &too_many, GOOD], Decides::Tasks);
    let answer = outcome.unwrap();
    assert_eq!(generated(&answer).layers, ["base", "top"]);
    assert_eq!(generated(&answer).tasks[0].path, [[0.0, 0.1, 0.0]]);
    assert!(answer.planned.is_none());
    let words: [&[&str]; 4] =
        [&["line 3"], &["`green`", "`cornr`", "`corner`", "line 2", "line 3"], &["`a`", "`b`"], &["red"]];
    for (exchange, words) in kept.iter().zip(words) {
        let said = exchange.refused.join("\n");
        assert!(words.iter().all(|word| said.contains(word)), "{words:?} in {said}");
        let told = server.asked()[exchange.attempt].1["messages"].to_string();
        assert!(exchange.refused.iter().all(|reason| told.contains(&serde_json::to_string(reason).unwrap()[1..20])));
    }
    assert!(kept[4].refused.is_empty());
}

#[test]
fn a_model_may_decide_more() {
    let with = |more: [&str; 2]| {
        let [red, blue] = more;
        GOOD.replace(r#""features": ["red"]"#, red).replace(r#""features": ["blue"]"#, blue)
    };
    let allocated = with([r#""agent": "arm", "object": "red_2""#, r#""agent": "anna", "object": "blue_1""#]);
    let (outcome, kept, _) = talk(&[GOOD, &allocated], Decides::Allocation);
    let answer = outcome.unwrap();
    assert!(kept[0].refused.join("\n").contains("`agent` is missing"), "{:?}", kept[0].refused);
    let first = &generated(&answer).tasks[0];
    assert_eq!((first.agent, first.object), (Some(1), Some(1)));
    let scheduled = with([
        r#""agent": "arm", "object": "red_2", "start": 0, "end": 20"#,
        r#""agent": "anna", "object": "blue_1", "start": 20, "end": 40"#,
    ]);
    let (outcome, ..) = talk(&[&scheduled], Decides::Everything);
    assert_eq!(outcome.unwrap().planned.unwrap().chart.end(), Some(40.0));
    // A plan that cannot be goes back like any other mistake.
    let early = scheduled.replace("\"start\": 20", "\"start\": 4");
    let (outcome, kept, _) = talk(&[&early, &scheduled], Decides::Everything);
    assert_eq!(outcome.unwrap().planned.unwrap().chart.end(), Some(40.0));
    assert!(kept[0].refused.join("\n").contains("begins at 4 s, before"), "{:?}", kept[0].refused);
    let (outcome, ..) = talk(&[&early, &early, &early, &early, &early], Decides::Everything);
    assert!(matches!(outcome, Err(GenerateError::Refused { .. })), "{outcome:?}");
}

/// Only the answer of a model that writes its reasoning is read; a mistake is located in the whole text.
#[test]
fn thoughts_are_not_the_answer() {
    let thinks = |text: &str| format!("<think>maybe {{\"layers\": []}}\nor so</think>\n{text}");
    let wrong = thinks(&GOOD.replacen("pick", "lick", 1));
    let list = "[{\"name\": \"left\", \"action\": \"pick_and_place\"}]";
    let (outcome, kept, server) = talk(&[&wrong, list, &thinks(GOOD)], Decides::Tasks);
    assert!(outcome.is_ok(), "{outcome:?}");
    let column = GOOD.lines().nth(1).unwrap().find("\"pick").unwrap() + 1;
    let place = format!("line 4, column {column}, ");
    assert!(kept[0].refused[0].starts_with(&place), "{place}: {:?}", kept[0].refused);
    assert!(server.asked()[1].1["messages"][3]["content"].as_str().unwrap().contains("in lines 3 to 5"));
    assert!(
        kept[1].refused[0].contains("an object is expected, and this is a list; give {\"layers\":"),
        "{:?}",
        kept[1]
    );
}

/// The form that the model is shown, with words of the mission, is one that is read.
#[test]
fn the_form_in_the_prompt_is_what_is_read() {
    let mission = mission(&[]);
    for (decides, mode) in [
        (Decides::Tasks, Mode::Context),
        (Decides::Allocation, Mode::Allocated),
        (Decides::Everything, Mode::Scheduled),
    ] {
        let wish = Wish { mission: &mission, instruction: "Build.", decides };
        let messages = prompt(&wish);
        assert!(messages[1].content.starts_with("Build."));
        assert_eq!(messages[1].content == "Build.", mode == Mode::Context);
        let system: serde_json::Value = serde_json::from_str(&messages[0].content).unwrap();
        assert_eq!(system["actions"], serde_json::json!(["pick_and_place"]));
        assert_eq!(system["scene"]["agents"].is_array(), mode != Mode::Context);
        let form = system["answer"]["form"].to_string();
        let answer = form
            .replace("one of the actions", "pick_and_place")
            .replace("name of an agent", "arm")
            .replace("name of an object", "red_1");
        let read = import(&answer, &mission.problem, mode);
        assert!(mission.read(&answer, decides).is_ok());
        assert!(read.is_ok(), "{answer}: {read:?}");
    }
}
