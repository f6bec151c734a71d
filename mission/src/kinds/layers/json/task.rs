//! Conversion of JSON values with error reports: keys of an object, texts, numbers, positions, and tasks.

use std::collections::{BTreeMap, BTreeSet};

use super::nearest::{listed, suggest};
use super::text::{Node, Value};
use super::{Fault, FaultKind, Mode, Position};
use crate::characters::{commands, plain};
use crate::kinds::layers::check::{MAX_ENTRIES, MAX_TASKS};
use crate::kinds::layers::problem::{Problem, Task};

/// Maximum number of mistakes reported for a text.
pub(super) const MAX_FAULTS: usize = 100;

/// The problem that the text refers to, and the mistakes so far.
pub(super) struct Reader<'a> {
    pub problem: &'a Problem,
    pub mode: Mode,
    pub faults: Vec<Fault>,
}

/// A task as read, with its position in the text.
pub(super) struct ReadTask {
    pub task: Task,
    pub at: Position,
    pub path: String,
    /// Names of predecessors, each with its position and path.
    pub after: Vec<(String, Position, String)>,
    pub start: Option<f64>,
    pub end: Option<f64>,
    /// Position of each key's value.
    pub keys: BTreeMap<String, Position>,
}

/// The entries of an object by key.
pub(super) type Entries<'n> = BTreeMap<&'n str, &'n Node>;

impl Reader<'_> {
    pub fn fault(&mut self, at: Position, path: &str, kind: FaultKind, what: String, fix: String) {
        // Both may quote untrusted keys and texts.
        let [path, what, fix] = [path, &what, &fix].map(plain);
        self.faults.push(Fault { at, path, kind, what, fix });
    }

    /// Returns true if the maximum number of mistakes is reached.
    pub fn is_full(&self) -> bool {
        self.faults.len() >= MAX_FAULTS
    }

    fn wrong_type(&mut self, node: &Node, path: &str, expected: &str) {
        let what = format!("{expected} is expected, and this is {}", node.kind());
        self.fault(node.at, path, FaultKind::Type, what, format!("give {expected}"));
    }

    /// Returns the entries of an object whose keys are among `keys`; `None` if the value is not an object.
    pub fn entries<'n>(&mut self, node: &'n Node, path: &str, keys: &[&str]) -> Option<Entries<'n>> {
        let Value::Object(entries) = &node.value else {
            self.wrong_type(node, path, "an object");
            return None;
        };
        let mut found: Entries<'n> = BTreeMap::new();
        for (key, at, value) in entries {
            let here = join(path, key);
            if !keys.contains(&key.as_str()) && key != "description" {
                let fix = match key.as_str() {
                    "start" | "end" if keys.contains(&"action") => "remove it: times are planned".into(),
                    _ => suggest(key, keys.iter().copied()),
                };
                self.fault(*at, &here, FaultKind::UnknownKey, format!("`{key}` has no meaning here"), fix);
            } else if found.insert(key.as_str(), value).is_some() {
                let fix = "remove one of them".into();
                self.fault(*at, &here, FaultKind::Twice, format!("`{key}` is given twice"), fix);
            }
        }
        Some(found)
    }

    /// Returns the value of a required key; in truncated objects a missing key is no mistake.
    pub fn needed<'n>(&mut self, node: &Node, entries: &Entries<'n>, path: &str, key: &str) -> Option<&'n Node> {
        let found = entries.get(key).copied();
        if found.is_none() && !node.broken {
            let what = format!("`{key}` is missing");
            self.fault(node.at, path, FaultKind::Missing, what, format!("add \"{key}\""));
        }
        found
    }

    pub fn text(&mut self, node: &Node, path: &str) -> Option<String> {
        match &node.value {
            Value::Text(text) if text.chars().any(commands) => {
                let number = text.chars().find(|c| commands(*c)).map_or(0, u32::from);
                let what = format!("this is not a name: it contains the control character U+{number:04X}");
                let fix = "give a name of visible characters".into();
                self.fault(node.at, path, FaultKind::Type, what, fix);
                None
            }
            Value::Text(text) if !text.is_empty() && text.len() <= 200 => Some(text.clone()),
            Value::Text(_) => {
                let fix = "give a name of 1 to 200 characters".into();
                self.fault(node.at, path, FaultKind::Type, "this is no name".into(), fix);
                None
            }
            _ => {
                self.wrong_type(node, path, "a text");
                None
            }
        }
    }

    /// Returns the entries of a list with at most `most` entries.
    pub fn list<'n>(&mut self, node: &'n Node, path: &str, most: usize) -> &'n [Node] {
        match &node.value {
            Value::List(list) if list.len() > most => {
                let what = format!("there are {} entries, more than {most}", list.len());
                self.fault(node.at, path, FaultKind::TooMuch, what, "give fewer".into());
                &list[..most]
            }
            Value::List(list) => list,
            _ => {
                self.wrong_type(node, path, "a list");
                &[]
            }
        }
    }

    fn texts(&mut self, node: &Node, path: &str, most: usize) -> Vec<(String, Position, String)> {
        let mut texts = Vec::new();
        for (number, entry) in self.list(node, path, most).iter().enumerate() {
            let here = format!("{path}[{number}]");
            texts.extend(self.text(entry, &here).map(|text| (text, entry.at, here)));
        }
        texts
    }

    fn number(&mut self, node: &Node, path: &str) -> Option<f64> {
        if let Value::Number(number) = node.value {
            return Some(number);
        }
        self.wrong_type(node, path, "a number of seconds");
        None
    }

    /// Reads a position (m): three numbers, or the name of a place.
    fn position(&mut self, node: &Node, path: &str) -> Option<[f64; 3]> {
        if let Value::Text(name) = &node.value {
            let found = self.problem.places.get(name).copied();
            if found.is_none() {
                let fix = if self.problem.places.is_empty() {
                    "give a position as [x, y, z] in metres".into()
                } else {
                    suggest(name, self.problem.places.keys().map(String::as_str))
                };
                self.fault(node.at, path, FaultKind::UnknownName, format!("there is no place `{name}`"), fix);
            }
            return found;
        }
        if let Value::List(list) = &node.value {
            let numbers: Vec<f64> =
                list.iter().filter_map(|n| if let Value::Number(x) = n.value { Some(x) } else { None }).collect();
            if let (Ok(position), true) = (<[f64; 3]>::try_from(numbers), list.len() == 3) {
                return Some(position);
            }
        }
        if !node.broken {
            self.wrong_type_of_position(node, path);
        }
        None
    }

    fn wrong_type_of_position(&mut self, node: &Node, path: &str) {
        let what = format!("a position is expected, and this is {}", node.kind());
        let what = if node.kind() == "a list" { "a position has three numbers".into() } else { what };
        let fix = "give [x, y, z] in metres".into();
        self.fault(node.at, path, FaultKind::Type, what, fix);
    }

    /// Reads the features of a task: some object must have each of them, and some object must have all.
    fn features(&mut self, node: &Node, path: &str) -> BTreeSet<String> {
        let problem = self.problem;
        let mut features = BTreeSet::new();
        let mut known = true;
        for (feature, at, here) in self.texts(node, path, MAX_ENTRIES) {
            if self.is_full() {
                break;
            }
            let all = || problem.objects.iter().flat_map(|thing| &thing.features);
            if !all().any(|other| *other == feature) {
                known = false;
                let fix = suggest(&feature, all().map(String::as_str));
                self.fault(at, &here, FaultKind::UnknownFeature, format!("no object is `{feature}`"), fix);
            }
            features.insert(feature);
        }
        if known && !node.broken && !problem.objects.iter().any(|thing| features.is_subset(&thing.features)) {
            let common =
                |count: &&crate::kinds::layers::problem::Object| count.features.intersection(&features).count();
            let near = problem.objects.iter().rev().max_by_key(common);
            let wanted: Vec<&String> = features.iter().collect();
            let fix = near.map_or("there is no object".into(), |near| {
                let has: Vec<&String> = near.features.iter().collect();
                format!("require fewer features; the nearest, `{}`, is {}", near.name, listed(&has))
            });
            let what = format!("no object has all features {}", listed(&wanted));
            self.fault(node.at, path, FaultKind::NoObject, what, fix);
        }
        features
    }

    /// Returns the index of a name.
    fn named(&mut self, node: &Node, path: &str, kind: &str, names: &[&str]) -> Option<usize> {
        let name = self.text(node, path)?;
        let found = names.iter().position(|other| *other == name);
        if found.is_none() {
            let fix = suggest(&name, names.iter().copied());
            self.fault(node.at, path, FaultKind::UnknownName, format!("there is no {kind} `{name}`"), fix);
        }
        found
    }

    /// Reads a task; `None` if it has no readable name.
    pub fn task(&mut self, node: &Node, path: &str, layer: usize, ordered: bool) -> Option<ReadTask> {
        let mut keys = vec!["name", "action", "features", "motion", "to", "agent", "object"];
        if !ordered {
            keys.push("after");
        }
        if self.mode == Mode::Scheduled {
            keys.extend(["start", "end"]);
        }
        let entries = self.entries(node, path, &keys)?;
        let name = self.needed(node, &entries, path, "name").and_then(|name| self.text(name, &join(path, "name")));
        let action = self.action(node, &entries, path);
        let features = entries
            .get("features")
            .map(|features| self.features(features, &join(path, "features")))
            .unwrap_or_default();
        let mut way = Vec::new();
        if let Some(motion) = entries.get("motion") {
            for (number, place) in self.list(motion, &join(path, "motion"), MAX_ENTRIES).iter().enumerate() {
                way.extend(self.position(place, &format!("{path}.motion[{number}]")));
            }
        }
        way.extend(entries.get("to").and_then(|to| self.position(to, &join(path, "to"))));
        let (agent, object) = self.allocation(node, &entries, path, !features.is_empty());
        let mut time = |key: &str| {
            let scheduled = self.mode == Mode::Scheduled;
            let value = if scheduled { self.needed(node, &entries, path, key) } else { None };
            value.and_then(|value| self.number(value, &join(path, key)))
        };
        let (start, end) = (time("start"), time("end"));
        let after =
            entries.get("after").map(|after| self.texts(after, &join(path, "after"), MAX_TASKS)).unwrap_or_default();
        let (name, action) = (name?, action.unwrap_or_default());
        let task = Task { name, layer, action, features, path: way, object, agent };
        let keys = entries.iter().map(|(key, value)| ((*key).to_string(), value.at)).collect();
        Some(ReadTask { task, at: node.at, path: path.into(), after, start, end, keys })
    }

    fn action(&mut self, node: &Node, entries: &Entries<'_>, path: &str) -> Option<String> {
        let (value, here) = (self.needed(node, entries, path, "action")?, join(path, "action"));
        let action = self.text(value, &here)?;
        let problem = self.problem;
        let all = || problem.agents.iter().flat_map(|who| &who.skills).map(|skill| skill.action.as_str());
        if !all().any(|other| other == action) {
            let fix = suggest(&action, all());
            self.fault(value.at, &here, FaultKind::UnknownAction, format!("nobody performs `{action}`"), fix);
        }
        Some(action)
    }

    fn allocation(
        &mut self,
        node: &Node,
        entries: &Entries<'_>,
        path: &str,
        wanted: bool,
    ) -> (Option<usize>, Option<usize>) {
        let problem = self.problem;
        let agents: Vec<&str> = problem.agents.iter().map(|who| who.name.as_str()).collect();
        let objects: Vec<&str> = problem.objects.iter().map(|thing| thing.name.as_str()).collect();
        if self.mode != Mode::Context {
            self.needed(node, entries, path, "agent");
            if wanted {
                self.needed(node, entries, path, "object");
            }
        }
        let agent = entries.get("agent").and_then(|name| self.named(name, &join(path, "agent"), "agent", &agents));
        let object = entries.get("object").and_then(|name| self.named(name, &join(path, "object"), "object", &objects));
        (agent, object)
    }
}

/// Returns `path.key`, or the one that is not empty.
pub(super) fn join(path: &str, key: &str) -> String {
    match (path, key) {
        ("", one) | (one, "") => one.into(),
        (path, key) => format!("{path}.{key}"),
    }
}
