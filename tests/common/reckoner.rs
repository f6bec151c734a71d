//! A stand-in for a language model that allocates and schedules: it reads only the prompt, and computes its plan from
//! it. The checks accept its answer if the prompt is sufficient.
//!
//! The decomposition into layers is given, since the composition of an H is known. The choice of agents and objects is
//! a rough guess with noise, like that of a model; with `forgets` its times omit the return to the base.

use std::collections::BTreeMap;

use context::endpoint::{AskError, Chat, Message};
use serde_json::{Value, json};

/// The stand-in.
pub struct Reckoner {
    /// The layers, in the format of the answer.
    pub layers: Value,
    /// State of its random numbers.
    pub noise: u64,
    /// True if it omits the return to the base.
    pub forgets: bool,
}

type Place = [f64; 3];

fn place(value: &Value) -> Place {
    let number = |i: usize| value[i].as_f64().expect("a coordinate");
    [number(0), number(1), number(2)]
}

fn apart(a: &Place, b: &Place) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// An object of the prompt.
struct Thing {
    name: String,
    place: Place,
    mass: f64,
    features: Vec<Value>,
}

impl Reckoner {
    /// Returns a number from 0 to 1 (Knuth's MMIX generator).
    fn chance(&mut self) -> f64 {
        self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.noise >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Computes the duration of a task for an agent by the directives of the prompt (s).
    fn takes(&self, who: &Value, action: &str, thing: Option<&Thing>, path: &[Place], least: f64) -> Option<f64> {
        let fixed = who["time_of_action"].get(action)?.as_f64()?;
        let base = place(&who["place"]);
        let (mut at, mut way) = (base, 0.0);
        for next in thing.map(|thing| thing.place).into_iter().chain(path.iter().copied()) {
            way += apart(&at, &next);
            at = next;
        }
        if !self.forgets {
            way += apart(&at, &base);
        }
        let speed = match who["kind"].as_str()? {
            "robot" => number(&who["speed"][1]),
            _ => {
                let heavier = thing.map_or(0.0, |thing| thing.mass - least);
                number(&who["speed"]) * number(&who["pace"][action]) / (1.0 + number(&who["slowing"]) * heavier)
            }
        };
        Some(fixed + way / speed)
    }

    fn answer(&mut self, told: &Value) -> Value {
        let Some(agents) = told["scene"]["agents"].as_array() else { return self.layers.clone() };
        let times =
            told["answer"]["keys"].as_array().expect("keys").iter().any(|key| key.to_string().contains("start"));
        let mut things: Vec<Thing> = told["scene"]["objects"]
            .as_array()
            .expect("objects")
            .iter()
            .map(|thing| Thing {
                name: thing["name"].as_str().expect("a name").to_string(),
                place: place(&thing["place"]),
                mass: number(&thing["mass"]),
                features: thing["features"].as_array().expect("features").clone(),
            })
            .collect();
        let least = things.iter().map(|thing| thing.mass).fold(f64::INFINITY, f64::min);
        let mut free: BTreeMap<String, f64> = BTreeMap::new();
        let mut begins = 0.0_f64;
        let mut layers = self.layers.clone();
        for layer in layers["layers"].as_array_mut().expect("layers") {
            let mut ends = begins;
            for task in layer["tasks"].as_array_mut().expect("tasks") {
                let action = task["action"].as_str().expect("an action").to_string();
                let to = match &task["to"] {
                    Value::String(name) => place(&told["scene"]["places"][name.as_str()]),
                    at => place(at),
                };
                let wanted = task["features"].as_array().cloned().unwrap_or_default();
                let mut best: Option<(f64, String, Option<usize>, f64, f64)> = None;
                for who in agents {
                    let fits = |thing: &Thing| wanted.iter().all(|feature| thing.features.contains(feature));
                    let all: Vec<Option<usize>> = match wanted.is_empty() {
                        true => vec![None],
                        false => (0..things.len()).filter(|i| fits(&things[*i])).map(Some).collect(),
                    };
                    for object in all {
                        let thing = object.map(|i| &things[i]);
                        let Some(takes) = self.takes(who, &action, thing, &[to], least) else { continue };
                        let name = who["name"].as_str().expect("a name").to_string();
                        let start = free.get(&name).copied().unwrap_or(0.0).max(begins);
                        // A rough guess: heavy objects are better for robots.
                        let heavy =
                            if who["kind"] == "human" { 60.0 * thing.map_or(0.0, |thing| thing.mass) } else { 0.0 };
                        let price = start + takes + heavy + 12.0 * self.chance();
                        if best.as_ref().is_none_or(|best| price < best.0) {
                            best = Some((price, name, object, start, start + takes));
                        }
                    }
                }
                let (_, name, object, start, end) = best.expect("somebody is able to");
                let end = (end * 1e3).ceil() / 1e3;
                task["agent"] = json!(name);
                if let Some(object) = object {
                    task["object"] = json!(things.remove(object).name);
                }
                if times {
                    task["start"] = json!(start);
                    task["end"] = json!(end);
                }
                free.insert(name, end);
                ends = ends.max(end);
            }
            begins = ends;
        }
        layers
    }
}

impl Chat for Reckoner {
    fn model(&self) -> &str {
        "stand-in: reckons from the prompt"
    }

    fn ask(&mut self, messages: &[Message]) -> Result<String, AskError> {
        let told: Value = serde_json::from_str(&messages[0].content).expect("JSON");
        Ok(self.answer(&told).to_string())
    }
}
