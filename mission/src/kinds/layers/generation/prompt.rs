//! The prompt for a model: scene, actions, directives and the form of the answer, generated from the mission (Fig.
//! 6.2).
//!
//! The system message is a JSON object, as in the thesis; the user message is the person's instruction, verbatim.
//! [`Mode`] selects how much the model decides: the layers only, also the allocation, or the whole plan. The last two
//! are the baselines of thesis 6.4.4; their prompts list every constraint that they must satisfy and the cost
//! (`rules`).

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::rules;
use crate::kind::generation::Prompt;
use crate::kinds::layers::json::Mode;
use crate::kinds::layers::problem::{Agent, Object, Problem};

/// Version of the wording. It is part of every prompt and so of transcripts: answers to different wordings are not
/// comparable.
pub const VERSION: u32 = 2;

/// Input of a prompt.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish<'a> {
    /// The mission: agents, objects and places. Its tasks are ignored.
    pub problem: &'a Problem,
    /// The person's instruction.
    pub instruction: &'a str,
    /// Additional directives, one sentence each.
    pub directives: &'a [String],
    /// Decisions that are left to the model: the layers only (`LLM_CG` of the thesis), also the allocation of agents
    /// and objects (`LLM_CG,A`), or everything (`LLM_CG,A,S`).
    pub mode: Mode,
}

/// Units of the scene: first for layers only, then for a model that also needs the parameters of speed and energy.
const UNITS: [&str; 2] = [
    "lengths in m, masses in kg, times in s, speeds in m/s",
    "lengths in m, masses in kg, times in s, speeds in m/s, slowing in 1/kg, standby in W, friction in N, drag in N s/m",
];

/// Returns the first messages of the conversation.
pub fn prompt(wish: &Wish<'_>) -> Prompt {
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
        // The person's instruction uses the labels; the answer needs the names.
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
    let user = match rules::wanted(wish.mode) {
        None => wish.instruction.to_string(),
        Some(wanted) => format!("{}\n\n{wanted}", wish.instruction),
    };
    Prompt { system, user }
}

/// Returns the labels of places, keyed by the names that the answer uses; also those of agents and objects, unless
/// `alone`.
fn called(problem: &Problem, alone: bool) -> BTreeMap<&str, &str> {
    let others = problem.agents.iter().map(|who| &who.name).chain(problem.objects.iter().map(|thing| &thing.name));
    let names = problem.places.keys().chain(others.filter(|_| !alone));
    names.filter_map(|name| Some((name.as_str(), problem.labels.members.get(name)?.as_str()))).collect()
}

/// Describes the form of the answer: an example and the meaning of its keys.
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

/// Returns every action that an available agent can perform.
fn actions(problem: &Problem) -> Value {
    let mut names: Vec<&str> =
        problem.agents.iter().filter(|a| !a.lost).flat_map(|a| &a.skills).map(|skill| skill.action.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    json!(names)
}

/// Groups the objects by their features, with the count and the range of masses of each group.
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
    let of = |thing: &Object| json!({ "name": thing.name, "features": thing.features, "mass": thing.mass, "place": thing.place });
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
