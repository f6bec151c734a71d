//! What a model is told: the scene, the actions, the directives and the form of the answer, made from the mission (Fig. 6.2).
//!
//! The system's message is an object of JSON, as the thesis has it; the user's message is what the person wants done, word
//! for word. How much is left to the model is a choice: the layers alone, also who uses what, or the whole plan; the last two
//! are the baselines of thesis 6.4.4, and are told every constraint that they must keep and the cost (`rules`).

use std::collections::BTreeMap;

use mission::layers::json::Mode;
use mission::layers::problem::{Agent, Problem};
use serde_json::{Value, json};

use crate::endpoint::{Message, Speaker};
use crate::rules;

/// The version of the words. It stands in every prompt, and so in transcripts: answers to other words do not compare.
pub const VERSION: u32 = 2;

/// What is wanted of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish<'a> {
    /// The mission: agents, objects, places; its tasks are not looked at.
    pub problem: &'a Problem,
    /// What the person wants done.
    pub instruction: &'a str,
    /// What must be obeyed, each a sentence.
    pub directives: &'a [String],
    /// How much the model decides: the layers alone, `LLM_CG` of the thesis; also who does what with which object,
    /// `LLM_CG,A`; everything, `LLM_CG,A,S`.
    pub mode: Mode,
}

/// Units of the scene; with what a model that reckons needs besides.
const UNITS: [&str; 2] = [
    "lengths in m, masses in kg, times in s, speeds in m/s",
    "lengths in m, masses in kg, times in s, speeds in m/s, slowing in 1/kg, standby in W, friction in N, drag in N s/m",
];

/// The conversation with which a model is asked.
pub fn prompt(wish: &Wish) -> Vec<Message> {
    let problem = wish.problem;
    let alone = wish.mode == Mode::Context;
    let mut scene = json!({
        "units": UNITS[usize::from(!alone)],
        "objects": if alone { kinds_of_objects(problem) } else { objects(problem) },
    });
    if !problem.places.is_empty() {
        scene["places"] = json!(problem.places);
    }
    if !alone {
        scene["agents"] = problem.agents.iter().filter(|agent| !agent.lost).map(agent).collect();
    }
    let called = called(problem, alone);
    if !called.is_empty() {
        // The person writes of others as they are called, and the answer names them.
        scene["called"] = json!(called);
    }
    let mut directives = vec![
        "Decompose the mission into tasks; each task is one action, with one object or none.".to_string(),
        "Put tasks that may be carried out at the same time into one layer; a layer begins when the one before is complete."
            .to_string(),
        "Use the actions and features of this text only.".to_string(),
    ];
    if alone {
        directives.push(
            "Ask for objects by features, not by name; never ask for more objects with the same features than there are."
                .to_string(),
        );
    }
    directives.extend(rules::directives(problem, wish.mode));
    directives.extend(wish.directives.iter().cloned());
    let mut system = json!({
        "prompt": VERSION,
        "role": match wish.mode {
            Mode::Context => "You decompose a mission into layers of tasks. Others decide who does them and when.",
            Mode::Allocated => "You decompose a mission into layers of tasks, and say who does each with which object.",
            Mode::Scheduled => "You plan a mission: its tasks, who does each with which object, and when.",
        },
        "scene": scene,
        "actions": actions(problem),
        "directives": directives,
        "answer": form(wish.mode),
    });
    if !alone {
        system["cost"] = rules::cost(problem);
    }
    let system = serde_json::to_string_pretty(&system).unwrap_or_else(|_| system.to_string());
    let instruction = match rules::wanted(wish.mode) {
        None => wish.instruction.to_string(),
        Some(wanted) => format!("{}\n\n{wanted}", wish.instruction),
    };
    vec![Message::new(Speaker::System, system), Message::new(Speaker::User, instruction)]
}

/// Labels of places, and of agents and objects if these are named, by the name that stands in the answer.
fn called(problem: &Problem, alone: bool) -> BTreeMap<&str, &str> {
    let others = problem.agents.iter().map(|who| &who.name).chain(problem.objects.iter().map(|thing| &thing.name));
    let names = problem.places.keys().chain(others.filter(|_| !alone));
    names.filter_map(|name| Some((name.as_str(), problem.labels.members.get(name)?.as_str()))).collect()
}

/// The form of the answer as an example, with what its keys mean.
fn form(mode: Mode) -> Value {
    let mut task =
        json!({ "name": "a_word", "action": "one of the actions", "features": ["cube", "red"], "to": [0.1, 0.0, 0.0] });
    let mut keys = vec![
        "name: a word that no other task has",
        "features: those that the object must have; left out for a task without an object",
        "to: where it ends, a position [x, y, z] in m or the name of a place; left out where nothing is moved",
        "motion: positions to pass on the way, a list; may be left out",
    ];
    if mode != Mode::Context {
        task["agent"] = json!("name of an agent");
        task["object"] = json!("name of an object");
        keys.push("agent, object: who does it, with what; object is left out for a task without one");
    }
    if mode == Mode::Scheduled {
        task["start"] = json!(0.0);
        task["end"] = json!(12.5);
        keys.push("start, end: in s from the beginning");
    }
    json!({
        "form": { "layers": [{ "name": "a_word", "tasks": [task] }] },
        "keys": keys,
        "rule": "Answer with this JSON object and nothing else.",
    })
}

/// Every action that somebody is able to perform.
fn actions(problem: &Problem) -> Value {
    let mut names: Vec<&str> =
        problem.agents.iter().filter(|a| !a.lost).flat_map(|a| &a.skills).map(|skill| skill.action.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    json!(names)
}

/// Objects of the same features together, with how many there are.
fn kinds_of_objects(problem: &Problem) -> Value {
    let mut kinds: BTreeMap<Vec<&str>, (usize, f64, f64)> = BTreeMap::new();
    for thing in &problem.objects {
        let features: Vec<&str> = thing.features.iter().map(String::as_str).collect();
        let kind = kinds.entry(features).or_insert((0, f64::INFINITY, 0.0));
        *kind = (kind.0 + 1, kind.1.min(thing.mass), kind.2.max(thing.mass));
    }
    let of = |(features, (count, least, most)): (&Vec<&str>, &(usize, f64, f64))| json!({ "features": features, "count": count, "mass": [least, most] });
    kinds.iter().map(of).collect()
}

fn objects(problem: &Problem) -> Value {
    let of = |thing: &mission::layers::problem::Object| json!({ "name": thing.name, "features": thing.features, "mass": thing.mass, "place": thing.place });
    problem.objects.iter().map(of).collect()
}

fn agent(agent: &Agent) -> Value {
    let times: BTreeMap<&str, f64> = agent.skills.iter().map(|skill| (skill.action.as_str(), skill.duration)).collect();
    let mut value = rules::motion(&agent.body);
    value["name"] = json!(agent.name);
    value["place"] = json!(agent.place);
    value["time_of_action"] = json!(times);
    if agent.is_human() {
        let paces: BTreeMap<&str, f64> = agent.skills.iter().map(|skill| (skill.action.as_str(), skill.pace)).collect();
        value["pace"] = json!(paces);
    }
    if let Some(reach) = agent.reach {
        value["reach"] = json!(reach);
    }
    if let Some(payload) = agent.payload {
        value["payload"] = json!(payload);
    }
    if !agent.cannot.is_empty() {
        value["cannot_handle"] = json!(agent.cannot);
    }
    value
}
