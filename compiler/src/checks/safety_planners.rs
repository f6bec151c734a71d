//! Checks of safety planners: the position of the protected task in the stack, and its deviations.

use dsl::{Diagnostic, Span};
use runtime::program::{Program, StackProgram};
use runtime::{Evaluator, build_tasks, deviates};
use stdlib_tasks::bound::{Bound, BoundParams, Slot};
use stdlib_tasks::dimension::LENGTH;
use stdlib_tasks::field::Chi;
use stdlib_tasks::kinds::safety_planner::DeviationParams;

use crate::source_map::SourceMap;
use crate::units::shown;

/// The task that a planner protects; `None` for other tasks.
fn protected(program: &Program, task: usize) -> Option<usize> {
    let t = program.tasks.get(task).filter(|t| t.kind == "safety_planner")?;
    match t.params.get("task") {
        Some(Bound::Task(protected)) => Some(*protected),
        _ => None,
    }
}

fn level_of(stack: &StackProgram, task: usize) -> Option<usize> {
    stack.levels.iter().position(|l| l.members.iter().any(|m| m.task == task))
}

/// Collects the parameters of the protected task that deviate, with their paths.
fn deviating(target: &BoundParams, deviate: &BoundParams, path: &str, out: &mut Vec<(String, Slot)>) {
    for (name, bound) in deviate {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        match (bound, target.get(name)) {
            (Bound::Group(group), Some(Bound::Group(inner))) if !DeviationParams::is_one(group) => {
                deviating(inner, group, &path, out);
            }
            (_, Some(Bound::Value(slot))) => out.push((path, *slot)),
            _ => {}
        }
    }
}

/// Checks the planners of all stacks.
pub(crate) fn check(program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    let mut told: Vec<usize> = Vec::new();
    for (stack, (name, levels)) in program.stacks.iter().zip(&places.stacks) {
        let before = diagnostics.len();
        let mut guarded: Vec<(usize, usize)> = Vec::new();
        for (level, l) in stack.levels.iter().enumerate() {
            for guard in l.members.iter().map(|m| m.task) {
                let Some(task) = protected(program, guard) else { continue };
                let at = place(places, guard, "task");
                let (own, other) = (&program.tasks[guard].name, &program.tasks[task].name);
                let first = guarded.iter().find(|g| g.0 == task).map(|g| g.1);
                guarded.push((task, guard));
                let d = |text: String| Diagnostic::error("HQ0608", at, text).label(*name, "in this stack");
                diagnostics.push(match level_of(stack, task) {
                    None => d(format!("`{own}` protects `{other}`, which is not in stack `{}`", stack.name))
                        .help(format!("add `{other}` to a level above that of `{own}`, or take `{own}` out")),
                    Some(there) if there >= level => d(format!("`{own}` is not below `{other}`, which it protects"))
                        .label(levels.get(there).copied().unwrap_or(*name), format!("`{other}` is here"))
                        .note("a planner decides about the null-space motion of its task")
                        .help(format!("put `{own}` on a level of its own below that of `{other}`")),
                    Some(_) => match first {
                        Some(first) => {
                            d(format!("`{other}` is protected twice, by `{}` and `{own}`", program.tasks[first].name))
                                .help("keep one planner for each task")
                        }
                        None => {
                            if !told.contains(&guard) {
                                told.push(guard);
                                target(program, stack, (guard, task), places, diagnostics);
                            }
                            continue;
                        }
                    },
                });
            }
        }
        if guarded.is_empty() || diagnostics.len() > before {
            continue;
        }
        if let Err(e) = Evaluator::new(program, program.stacks.iter().position(|s| s.name == stack.name).unwrap_or(0)) {
            let at = guarded.first().map_or(*name, |g| place(places, g.1, ""));
            diagnostics.push(Diagnostic::error("HQ0503", at, e.message).help("change the setting that it names"));
        }
    }
}

fn place(places: &SourceMap, task: usize, param: &str) -> Span {
    places.tasks.get(task).map_or_else(Span::default, |t| t.spans.get(param).copied().unwrap_or(t.span))
}

/// Reports a constant threshold beyond the range in which the field's distance saturates.
fn out_of_reach(program: &Program, guard: usize, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    let params = &program.tasks[guard].params;
    let (Some(Bound::Field(field)), Some(Bound::Value(min))) = (params.get("field"), params.get("min")) else { return };
    let Some((f, name)) = program.fields.get(*field).and_then(|f| Some((f.field(&program.robot.model).ok()?, &f.name)))
    else {
        return;
    };
    let (Chi::Clamped { reach } | Chi::Saturating { reach }) = *f.chi() else { return };
    let moves = program.values.tape.outputs.iter().any(|o| o.at == min.at);
    let Some(threshold) = program.values.initial.get(min.at).copied().filter(|t| !moves && *t >= reach) else { return };
    let (threshold, reach) = (shown(threshold, LENGTH), shown(reach, LENGTH));
    let text = format!("no configuration meets `min`: it requires {threshold} of a field that is below {reach}");
    diagnostics.push(
        Diagnostic::error("HQ0520", place(places, guard, "min"), text)
            .note(format!("the field `{name}` is at most {reach}, at any distance"))
            .help("choose a smaller `min`, or a larger range of the field"),
    );
}

/// Checks the target of a protected task.
fn target(
    program: &Program,
    stack: &StackProgram,
    (guard, task): (usize, usize),
    places: &SourceMap,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let t = &program.tasks[task];
    let slots = t.params.values().flat_map(|b| b.slots()).flat_map(|s| s.at..s.at + s.len).collect();
    let signals = &program.interface;
    let moving = program.values.tape.only(&slots).signals().into_iter().filter_map(|at| signals.signal_of(at));
    let moving = moving.filter_map(|s| signals.signals.get(s)).find(|s| s.motion.is_some());
    if let Some(person) = moving {
        let text = format!("the target of `{}` follows `{}`, so it cannot be delayed", t.name, person.name);
        let d = Diagnostic::error("HQ0608", place(places, guard, "task"), text);
        diagnostics.push(d.help("let a task without a planner follow it"));
    }
    out_of_reach(program, guard, places, diagnostics);
    let Some(Bound::Group(deviate)) = program.tasks[guard].params.get("deviate") else { return };
    let mut all = Vec::new();
    deviating(&t.params, deviate, "", &mut all);
    let model = &program.robot.model;
    let built = build_tasks(program, stack);
    let members = stack.levels.iter().flat_map(|l| &l.members);
    let Some(Ok(mut own)) = members.zip(built).find(|(m, _)| m.task == task).map(|(_, b)| b.task) else { return };
    for (path, slot) in all {
        if deviates(model, &program.robot.home, &program.values.initial, own.as_mut(), slot).is_none() {
            let text = match own.remembers_target() {
                true => format!("the target of `{}` moves a simulated mass, and cannot deviate", t.name),
                false => {
                    format!(
                        "`{path}` of `{}` is not a target that three of its rows follow, and cannot deviate",
                        t.name
                    )
                }
            };
            let d = Diagnostic::error("HQ0609", place(places, guard, "deviate"), text);
            diagnostics.push(match own.remembers_target() {
                true => d
                    .note("its rows depend on the previous velocity of the target, which does not include a deviation")
                    .help("remove `deviate`: then only the clock and the null-space motion are adapted; or protect a `frame_pose`"),
                false => d.help("name a target position or orientation"),
            });
        }
    }
}
