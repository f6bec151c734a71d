//! Tasks that triggers and conditions of a machine name: `reached(reach, ..)`, `fault(limit(deck))`. They get their names
//! in the program.

use dsl::Diagnostic;
use dsl::tree::{Entry, MemberTask, StateBody, TaskDefinition, Trigger, Value, ValueKind};
use names::list;

use super::module::parameters;
use super::substitute::Frame;
use super::{Class, Expander};
use crate::expr::REACHED;
use crate::forms::text_of;

/// Place of a trigger.
struct Place<'p> {
    /// Module of the machine.
    module: usize,
    /// Stacks that run in the state that has the transition, or in states inside it.
    stacks: &'p [String],
    /// Stacks that run in regions beside it.
    beside: &'p [String],
}

/// Task that a trigger names.
enum Named {
    /// Its name in the program.
    Task(String),
    /// No declaration has this name.
    Unknown,
    /// It is wrong, which is reported.
    Failed,
}

impl Expander<'_> {
    /// Renames the tasks in the triggers of a state, or of a machine, once its stacks are those of the program.
    /// `around` is the stack of the enclosing state, and `beside` are those that run in regions of it.
    pub(super) fn triggers_of(&mut self, body: &mut StateBody, around: Option<&str>, beside: &[String], m: usize) {
        let mut stacks = Vec::new();
        running(body, around, &mut stacks);
        let place = Place { module: m, stacks: &stacks, beside };
        for t in &mut body.transitions {
            match &mut t.trigger {
                Trigger::On(value) => self.tasks_of(value, &place),
                Trigger::When { condition, .. } => self.targets_of(condition, &place),
                Trigger::After(_) | Trigger::Missing => {}
            }
        }
        let own = body.stack.as_ref().map(|call| call.name.value.clone());
        let regions = body.inner(true).next().is_some();
        let beside = if regions { &stacks } else { beside };
        for state in &mut body.states {
            self.triggers_of(&mut state.body, own.as_deref().or(around), beside, m);
        }
    }

    /// Renames the tasks in all calls of `reached` in a condition.
    fn targets_of(&mut self, value: &mut Value, place: &Place) {
        match &mut value.kind {
            ValueKind::Call(function, _) if function.value == REACHED => self.tasks_of(value, place),
            ValueKind::Call(_, all) | ValueKind::List(all) => all.iter_mut().for_each(|v| self.targets_of(v, place)),
            ValueKind::Not(inner)
            | ValueKind::Negate(inner)
            | ValueKind::Named(_, inner)
            | ValueKind::Unit(inner, _)
            | ValueKind::Field(inner, _)
            | ValueKind::In(inner, _) => self.targets_of(inner, place),
            ValueKind::Binary(_, left, right) => {
                self.targets_of(left, place);
                self.targets_of(right, place);
            }
            _ => {}
        }
    }

    /// Renames tasks in a trigger, `reached(reach, ..)`, `fault(limit(deck))`, to their names in the program.
    fn tasks_of(&mut self, value: &mut Value, place: &Place) {
        let ValueKind::Call(function, args) = &mut value.kind else { return };
        match (function.value.as_str(), args.first_mut()) {
            (REACHED | "limit", Some(task)) => match self.task_of(task, place) {
                Named::Task(name) => *task = Value { kind: ValueKind::Text(name), span: task.span },
                Named::Unknown => {}
                Named::Failed => value.kind = ValueKind::Missing,
            },
            ("fault", Some(pattern)) => self.tasks_of(pattern, place),
            _ => {}
        }
    }

    /// Name in the program of a task, `reach`, or of a use of a task with parameters, `reach(left, goal)`.
    fn task_of(&mut self, task: &Value, place: &Place) -> Named {
        let made = |name: Option<String>| name.map_or(Named::Failed, Named::Task);
        if let ValueKind::Call(function, args) = &task.kind {
            let Ok(found) = self.find(place.module, Class::Task, &function.value) else { return Named::Unknown };
            let (mut positional, mut named) = (Vec::new(), Vec::new());
            for arg in args {
                match &arg.kind {
                    ValueKind::Named(key, value) => {
                        named.push(Entry { key: key.clone(), value: (**value).clone(), comments: Default::default() });
                    }
                    _ => positional.push(arg.clone()),
                }
            }
            let body = dsl::tree::Block { span: task.span, ..Default::default() };
            let used = TaskDefinition { kind: function.clone(), args: positional, named, body, span: task.span };
            return made(self.instance(found, &used, function, &mut Frame::of(place.module)));
        }
        let Some(name) = text_of(task).map(str::to_string) else { return Named::Unknown };
        let Ok(found) = self.find(place.module, Class::Task, &name) else { return Named::Unknown };
        if parameters(&self.modules[found.0].items[found.1].kind).is_empty() {
            return made(self.emit_task(found));
        }
        let mut instances = self.instances_in(found, place.stacks);
        if instances.is_empty() {
            instances = self.instances_in(found, place.beside);
        }
        if let [one] = instances.as_slice() {
            return Named::Task(one.clone());
        }
        let text = match instances.len() {
            0 => format!("`{name}` has parameters, and no stack that runs here contains it"),
            n => format!("`{name}` has parameters, and {n} tasks that run here are uses of it"),
        };
        let d = Diagnostic::error("HQ0703", task.span, text);
        self.fail(match instances.is_empty() {
            true => d.help(format!("add `{name}(..)` to the stack of the state")),
            false => d.note(format!("they are {}", list(instances.iter().map(String::as_str), 12))).help(format!(
                "write its arguments as in the stack, `{name}(..)`, or declare it with a name, `task NAME = {name}(..)`"
            )),
        });
        Named::Failed
    }

    /// Tasks of some stacks that are uses of a task with parameters.
    fn instances_in(&self, (m, i): (usize, usize), stacks: &[String]) -> Vec<String> {
        let of = self.alike.iter().filter(|(key, _)| (key.0, key.1) == (m, i)).flat_map(|(_, all)| all);
        let uses: Vec<&String> = of.filter_map(|&k| self.instances[k].task.as_ref()).collect();
        let all = self.out.stacks.iter().filter(|stack| stacks.contains(&stack.name.value));
        let mut found: Vec<String> = Vec::new();
        for member in all.flat_map(|stack| &stack.levels).flat_map(|level| &level.members) {
            if let MemberTask::Name(name) = &member.task
                && uses.contains(&&name.value)
                && !found.contains(&name.value)
            {
                found.push(name.value.clone());
            }
        }
        found
    }
}

/// Adds the stacks that run in a state, or in the states inside it.
fn running(body: &StateBody, around: Option<&str>, out: &mut Vec<String>) {
    let own = body.stack.as_ref().map(|call| call.name.value.as_str()).or(around);
    if body.states.is_empty() {
        out.extend(own.map(str::to_string));
    }
    body.states.iter().for_each(|state| running(&state.body, own, out));
}
