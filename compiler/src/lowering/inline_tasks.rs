//! Inline tasks of levels: their definitions and names.
//!
//! The name is that of the type. If inline tasks of one type differ, the subject of the task follows:
//! `track.left_tool`, `keep.elbow.chest`. If that name is taken, the level and the stack precede it.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Spanned;
use dsl::tree::{Level, MemberTask, Task, TaskDefinition, Value, ValueKind};

use super::declared::Declared;
use crate::expr::constants::is_word;
use crate::forms::{target, written};

/// Maximum number of names in the subject of a task.
const NAMES: usize = 2;

/// Definitions of all tasks with their names, in program order: declared tasks, then inline tasks.
pub(super) fn definitions(declared: &Declared) -> Vec<(String, TaskDefinition)> {
    let mut all: Vec<(String, TaskDefinition)> =
        declared.tasks.iter().map(|t| (t.name.value.clone(), t.definition.clone())).collect();
    let levels = declared.stacks.iter().flat_map(|s| s.levels.iter().map(move |l| (s, l)));
    let found: Vec<(&str, &Level, TaskDefinition)> = levels
        .flat_map(|(s, l)| l.members.iter().map(move |m| (s, l, m)))
        .filter_map(|(s, l, m)| Some((s.name.value.as_str(), l, in_place(&m.task, &declared.tasks)?)))
        .collect();
    // Types with different inline tasks.
    let mut first: BTreeMap<&str, &TaskDefinition> = BTreeMap::new();
    let mut several: Vec<&str> = Vec::new();
    for (_, _, d) in &found {
        let kind = d.kind.value.as_str();
        if *first.entry(kind).or_insert(d) != d && !several.contains(&kind) {
            several.push(kind);
        }
    }
    let mut names: BTreeMap<String, usize> = all.iter().map(|(name, _)| (name.clone(), 1)).collect();
    let named: Vec<String> = found
        .iter()
        .map(|(stack, level, d)| name(stack, level, d, several.contains(&d.kind.value.as_str()), &mut names))
        .collect();
    all.extend(named.into_iter().zip(found).map(|(name, (_, _, d))| (name, d)));
    all
}

/// Definition of an inline task: with parameters, or the bare name of its type.
pub(super) fn in_place(task: &MemberTask, declared: &[&Task]) -> Option<TaskDefinition> {
    match task {
        MemberTask::Inline(d) => Some(d.clone()),
        MemberTask::For(_) => None,
        MemberTask::Name(n) => {
            // Look up the type first: few names are those of types, and only for these the declared tasks are searched.
            let kind = stdlib_tasks::find(&n.value).filter(|_| !declared.iter().any(|t| t.name == *n))?;
            let kind = Spanned::new(kind.name.to_string(), n.span);
            let body = dsl::tree::Block { span: n.span, ..Default::default() };
            Some(TaskDefinition { kind, args: Vec::new(), named: Vec::new(), body, span: n.span })
        }
    }
}

/// First free name for an inline task; `names` counts the uses of names.
fn name(stack: &str, level: &Level, d: &TaskDefinition, several: bool, names: &mut BTreeMap<String, usize>) -> String {
    let kind = &d.kind.value;
    let about = if several { subject(d) } else { String::new() };
    let own = format!("{kind}{about}");
    let level = format!("{}.{own}", level.name.value);
    let candidates = [own, level.clone(), format!("{stack}.{level}")];
    if let Some(free) = candidates.iter().find(|n| !names.contains_key(*n)) {
        names.insert(free.clone(), 1);
        return free.clone();
    }
    let last = &candidates[candidates.len() - 1];
    let mut count = names.get(last).copied().unwrap_or(1) + 1;
    while names.contains_key(&format!("{last}.{count}")) {
        count += 1;
    }
    names.insert(last.clone(), count);
    names.insert(format!("{last}.{count}"), 1);
    format!("{last}.{count}")
}

/// Subject of a task, each name after a dot: parts of the robot and values that its argument names, and the component.
fn subject(d: &TaskDefinition) -> String {
    let in_body = d.named.iter().chain(&d.body.entries).find(|e| e.key.value == "value").map(|e| &e.value);
    let mut names: Vec<String> = Vec::new();
    let mut field = None;
    for value in d.args.iter().chain(in_body) {
        if let ValueKind::Field(_, last) = &value.kind {
            field = Some(last.value.as_str()).filter(|f| ["x", "y", "z", "orientation"].contains(f));
        }
        mentions(value, &mut |name| {
            let name = written(name).rsplit('.').next().unwrap_or_default();
            if names.len() < NAMES && !name.is_empty() && !is_word(name) && !names.iter().any(|n| n == name) {
                names.push(name.to_string());
            }
        });
    }
    let names = names.iter().map(String::as_str).chain(field);
    names.map(|n| format!(".{n}")).collect()
}

/// Names of values that a definition mentions, as declared.
pub(super) fn names(d: &TaskDefinition) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for value in d.args.iter().chain(d.named.iter().chain(&d.body.entries).map(|e| &e.value)) {
        mentions(value, &mut |name| {
            all.insert(target(name).to_string());
        });
    }
    all
}

/// Visits all names in a value.
fn mentions(value: &Value, visit: &mut dyn FnMut(&str)) {
    if let ValueKind::Name(name) = &value.kind {
        visit(name);
    }
    value.parts().into_iter().for_each(|part| mentions(part, visit));
}
