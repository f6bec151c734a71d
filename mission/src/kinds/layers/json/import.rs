//! Conversion of JSON to a problem: layers or precedences, their tasks, and the plan of a schedule.

use std::collections::BTreeMap;

use crate::kinds::layers::check::{Item, Key, MAX_TASKS, Mistake};
use crate::kinds::layers::plan::Plan;
use crate::kinds::layers::problem::Problem;
use crate::labels::Labels;

use super::nearest::{listed, suggest};
use super::order::layers;
use super::scheduled_plan;
use super::task::{ReadTask, Reader, join};
use super::text::{Node, read};
use super::{Fault, FaultKind, Mode, Position};

/// Result of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The problem with the layers and tasks of the text. No task of it has begun.
    pub problem: Problem,
    /// With [`Mode::Scheduled`] the plan of the text, with its cost:
    /// [`validate`](crate::kinds::layers::validate::validate) has found no violation. A robot moves as slowly as its
    /// time allows.
    pub plan: Option<Plan>,
}

/// Reads layers for the agents, objects and weights of a problem; the problem's own layers, tasks and begun tasks are
/// replaced. Names of the problem's places are valid as positions.
///
/// # Errors
///
/// All mistakes in the text, by position. If the text is invalid JSON from some position on, the mistakes before it are
/// reported too.
pub fn import(text: &str, problem: &Problem, mode: Mode) -> Result<Imported, Vec<Fault>> {
    let (root, fault) = read(text);
    let mut reader = Reader { problem, mode, faults: fault.into_iter().collect() };
    let tree = root.map(|root| tree(&mut reader, &root)).unwrap_or_default();
    if reader.faults.is_empty() {
        let problem = Problem {
            layers: tree.layers.iter().map(|(name, ..)| name.clone()).collect(),
            tasks: tree.tasks.iter().map(|read| read.task.clone()).collect(),
            // Labels of tasks are dropped: the tasks of the text have other names, in any script.
            labels: Labels { members: problem.labels.members.clone(), ..Labels::default() },
            begun: Vec::new(),
            ..problem.clone()
        };
        let mistakes = problem.check();
        if mistakes.is_empty() {
            match (mode == Mode::Scheduled).then(|| scheduled_plan::plan(&problem, &tree.tasks)).transpose() {
                Ok(plan) => return Ok(Imported { problem, plan }),
                Err(faults) => reader.faults.extend(faults),
            }
        }
        for mistake in mistakes {
            reader.faults.push(fault_of(&problem, &tree, &mistake));
        }
    }
    reader.faults.sort_by(|a, b| a.at.cmp(&b.at).then_with(|| a.path.cmp(&b.path)));
    Err(reader.faults)
}

/// Layers with name, position and path, and tasks.
#[derive(Default)]
struct Tree {
    layers: Vec<(String, Position, String)>,
    tasks: Vec<ReadTask>,
}

fn tree(reader: &mut Reader<'_>, root: &Node) -> Tree {
    let mut tree = Tree::default();
    const FORM: &str = "give {\"layers\": [{\"name\": .., \"tasks\": [..]}]}";
    let Some(entries) = reader.entries(root, "", &["layers", "tasks"]) else {
        reader.faults.iter_mut().filter(|fault| fault.path.is_empty()).for_each(|fault| fault.fix = FORM.into());
        return tree;
    };
    match (entries.get("layers"), entries.get("tasks")) {
        (Some(layers), None) => layered(reader, layers, &mut tree),
        (None, Some(tasks)) => {
            read_tasks(reader, tasks, "tasks", 0, false, &mut tree);
            ordered(reader, &mut tree);
        }
        (Some(_), Some(tasks)) => {
            let fix = "put each task into its layer".into();
            let what = "there are both `layers` and `tasks`".into();
            reader.fault(tasks.at, "tasks", FaultKind::UnknownKey, what, fix);
        }
        (None, None) if root.broken => {}
        (None, None) => {
            reader.fault(root.at, "", FaultKind::Missing, "`layers` is missing".into(), FORM.into());
        }
    }
    twice(reader, &tree);
    tree
}

fn layered(reader: &mut Reader<'_>, layers: &Node, tree: &mut Tree) {
    for (number, node) in reader.list(layers, "layers", MAX_TASKS).iter().enumerate() {
        let path = format!("layers[{number}]");
        let Some(entries) = reader.entries(node, &path, &["name", "tasks"]) else { continue };
        let name = match entries.get("name") {
            Some(name) => reader.text(name, &join(&path, "name")).unwrap_or_default(),
            None => format!("layer_{}", number + 1),
        };
        tree.layers.push((name, node.at, path.clone()));
        if let Some(tasks) = reader.needed(node, &entries, &path, "tasks") {
            let layer = tree.layers.len() - 1;
            read_tasks(reader, tasks, &join(&path, "tasks"), layer, true, tree);
        }
    }
}

fn read_tasks(reader: &mut Reader<'_>, node: &Node, path: &str, layer: usize, ordered: bool, tree: &mut Tree) {
    for (number, task) in reader.list(node, path, MAX_TASKS).iter().enumerate() {
        if reader.is_full() {
            return;
        }
        if tree.tasks.len() >= MAX_TASKS {
            let what = format!("there are more than {MAX_TASKS} tasks");
            reader.fault(task.at, path, FaultKind::TooMuch, what, "give fewer".into());
            return;
        }
        tree.tasks.extend(reader.task(task, &format!("{path}[{number}]"), layer, ordered));
    }
}

/// Computes layers from the precedences of the tasks.
fn ordered(reader: &mut Reader<'_>, tree: &mut Tree) {
    // In a truncated text, tasks may be missing.
    let whole = reader.faults.iter().all(|fault| !matches!(fault.kind, FaultKind::Syntax | FaultKind::Truncated));
    let names: Vec<String> = tree.tasks.iter().map(|read| read.task.name.clone()).collect();
    let mut after: Vec<Vec<usize>> = Vec::new();
    for read in &tree.tasks {
        let mut before = Vec::new();
        for (name, at, path) in &read.after {
            match names.iter().position(|other| other == name) {
                Some(index) => before.push(index),
                None if !whole => {}
                None => {
                    let fix = suggest(name, names.iter().map(String::as_str));
                    reader.fault(*at, path, FaultKind::UnknownName, format!("there is no task `{name}`"), fix);
                }
            }
        }
        after.push(before);
    }
    match layers(&after) {
        Ok(found) => {
            for (read, layer) in tree.tasks.iter_mut().zip(&found) {
                read.task.layer = *layer;
            }
            let count = found.iter().max().map_or(0, |most| most + 1);
            let at = Position { line: 1, column: 1 };
            tree.layers = (1..=count).map(|number| (format!("layer_{number}"), at, "tasks".into())).collect();
        }
        Err(circle) => {
            let first = &tree.tasks[circle[0]];
            let in_circle: Vec<&str> = circle.iter().map(|task| names[*task].as_str()).collect();
            let what = format!("the tasks {} are in a cycle of `after`", listed(&in_circle));
            let fix = "remove one of them from the other's `after`".into();
            let at = first.keys.get("after").copied().unwrap_or(first.at);
            reader.fault(at, &join(&first.path, "after"), FaultKind::Cycle, what, fix);
        }
    }
}

/// Reports duplicate names.
fn twice(reader: &mut Reader<'_>, tree: &Tree) {
    let mut seen: BTreeMap<&str, &str> = BTreeMap::new();
    for (name, at, path) in &tree.layers {
        if let Some(first) = seen.insert(name, path).filter(|_| !name.is_empty()) {
            let what = format!("two layers are called `{name}`, the first at {first}");
            reader.fault(*at, path, FaultKind::Twice, what, "give each a name of its own".into());
        }
    }
    let mut seen: BTreeMap<&str, &str> = BTreeMap::new();
    for read in &tree.tasks {
        if let Some(first) = seen.insert(&read.task.name, &read.path) {
            let at = read.keys.get("name").copied().unwrap_or(read.at);
            let what = format!("two tasks are called `{}`, the first at {first}", read.task.name);
            let fix = "give each a name of its own".into();
            reader.fault(at, &join(&read.path, "name"), FaultKind::Twice, what, fix);
        }
    }
}

/// Returns a mistake of the problem at its position in the text.
fn fault_of(problem: &Problem, tree: &Tree, mistake: &Mistake) -> Fault {
    let start = (Position { line: 1, column: 1 }, String::new());
    let (at, path) = match mistake.at.item {
        Item::Task(task) => tree.tasks.get(task).map_or(start, |read| {
            let key = mistake.at.key.and_then(|key| match key {
                Key::Action => Some("action"),
                Key::Features => Some("features"),
                Key::Path => Some("to"),
                Key::Object => Some("object"),
                Key::Agent => Some("agent"),
                _ => None,
            });
            match key.and_then(|key| Some((key, *read.keys.get(key)?))) {
                Some((key, at)) => (at, join(&read.path, key)),
                None => (read.at, read.path.clone()),
            }
        }),
        Item::Layer(layer) => tree.layers.get(layer).map_or(start, |(_, at, path)| (*at, path.clone())),
        _ => start,
    };
    let (what, fix) = mistake.describe(problem);
    Fault { at, path, kind: FaultKind::Impossible, what, fix }
}
