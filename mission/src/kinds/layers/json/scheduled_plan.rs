//! A complete plan in a text: its times are validated, and violations are reported at their tasks.

use crate::kinds::layers::plan::Plan;
use crate::kinds::layers::problem::{Body, Problem};
use crate::kinds::layers::steps::{Step, to_plan};
use crate::kinds::layers::validate::{Rule, Violation, validate};
use crate::plan::{Statistics, Status};
use crate::validate::{Constraint, TOLERANCE};

use super::task::{MAX_FAULTS, ReadTask, join};
use super::{Fault, FaultKind};

/// Returns the plan of tasks that have agents and times.
///
/// # Errors
///
/// All violations that the validator finds, each at its task.
pub(super) fn plan(problem: &Problem, tasks: &[ReadTask]) -> Result<Plan, Vec<Fault>> {
    let backwards: Vec<Fault> = tasks.iter().filter_map(ends_before_it_begins).take(MAX_FAULTS).collect();
    if !backwards.is_empty() {
        return Err(backwards);
    }
    let steps: Vec<Step> = tasks.iter().enumerate().filter_map(|(task, read)| step(problem, task, read)).collect();
    let plan = to_plan(problem, &steps, Status::Unbounded { stopped: None }, "given".into(), Statistics::default());
    let violations = worst(problem, validate(problem, &plan));
    if violations.is_empty() {
        return Ok(plan);
    }
    Err(violations.iter().map(|violation| fault(problem, tasks, violation)).collect())
}

fn step(problem: &Problem, task: usize, read: &ReadTask) -> Option<Step> {
    let (agent, object) = (read.task.agent?, read.task.object);
    let (start, end) = (read.start?, read.end?);
    let who = problem.agents.get(agent)?;
    let skill = who.skill(&read.task.action)?;
    let speed = match who.body {
        Body::Human { .. } => problem.pace(who, skill, problem.mass(object))?,
        Body::Robot { speed, .. } => {
            let left = end - start - skill.duration;
            let way = problem.distance(agent, task, object);
            if left > 0.0 { (way / left).clamp(speed.low, speed.high) } else { speed.high }
        }
    };
    Some(Step { task, agent, object, speed, start, end, begun: false })
}

fn ends_before_it_begins(read: &ReadTask) -> Option<Fault> {
    let (start, end) = (read.start?, read.end?);
    (end < start).then(|| Fault {
        at: read.keys.get("end").copied().unwrap_or(read.at),
        path: join(&read.path, "end"),
        kind: FaultKind::Impossible,
        what: format!("`{}` ends at {end} s, before it begins, at {start} s", read.task.name),
        fix: "give an `end` after its `start`".into(),
    })
}

/// Keeps only the largest violation of each rule and task: a task that begins too early overlaps with many others.
fn worst(problem: &Problem, violations: Vec<Violation>) -> Vec<Violation> {
    let layer = |task: Option<usize>| task.and_then(|task| problem.tasks.get(task)).map(|task| task.layer);
    let mut worst: Vec<Violation> = Vec::new();
    for mut violation in violations {
        // Report the violation at the later task.
        if violation.rule == Rule::Layers && layer(violation.at) < layer(violation.other) {
            (violation.at, violation.other) = (violation.other, violation.at);
        }
        match worst.iter().position(|one| (one.rule, one.at) == (violation.rule, violation.at)) {
            Some(at) if worst[at].by < violation.by => worst[at] = violation,
            None if worst.len() < MAX_FAULTS => worst.push(violation),
            _ => {}
        }
    }
    worst
}

fn fault(problem: &Problem, tasks: &[ReadTask], violation: &Violation) -> Fault {
    let read = violation.at.and_then(|task| tasks.get(task));
    let other = violation.other.and_then(|task| tasks.get(task));
    let (key, what, fix) = match (read, other) {
        (Some(read), Some(other)) => of_two(problem, read, other, violation),
        (Some(read), None) => of_one(problem, read, violation),
        (None, _) => ("", format!("this is not a plan: {}", violation.rule.text()), "give each task once".into()),
    };
    Fault {
        at: read.map_or(super::Position { line: 1, column: 1 }, |read| read.keys.get(key).copied().unwrap_or(read.at)),
        path: read.map_or_else(String::new, |read| join(&read.path, key)),
        kind: FaultKind::Impossible,
        what,
        fix,
    }
}

fn agent<'a>(problem: &'a Problem, read: &ReadTask) -> &'a str {
    read.task.agent.and_then(|agent| problem.agents.get(agent)).map_or("?", |who| &who.name)
}

/// Returns the key at fault, the mistake and the fix for a violation of a single task.
fn of_one(problem: &Problem, read: &ReadTask, violation: &Violation) -> (&'static str, String, String) {
    let (name, who) = (&read.task.name, agent(problem, read));
    let (start, end) = (read.start.unwrap_or_default(), read.end.unwrap_or_default());
    match violation.rule {
        Rule::Duration => {
            let takes = up(end - start + violation.by);
            let what = format!("`{who}` cannot do `{name}` in {} s: it takes {takes} s at least", down(end - start));
            ("end", what, format!("give an `end` of {} s or later", up(start + takes)))
        }
        Rule::Past => {
            let what = format!("`{name}` begins at {start} s, before the mission does");
            ("start", what, format!("give a `start` of {} s or later", up(problem.start)))
        }
        Rule::Able | Rule::Speed => {
            let what = format!("`{who}` is not able to do `{name}`");
            ("agent", what, "give an agent whose skills, reach and payload allow it".into())
        }
        Rule::Object => {
            let what = format!("`{name}` does not have an object with its features");
            ("object", what, "give an object that has all of them".into())
        }
        other => ("", format!("violated by `{name}`: {}", other.text()), "change the task".into()),
    }
}

/// Returns the key at fault, the mistake and the fix for a violation of two tasks.
fn of_two(
    problem: &Problem,
    read: &ReadTask,
    other: &ReadTask,
    violation: &Violation,
) -> (&'static str, String, String) {
    let (name, second) = (&read.task.name, &other.task.name);
    let times = |read: &ReadTask| (read.start.unwrap_or_default(), read.end.unwrap_or_default());
    match violation.rule {
        Rule::Layers => {
            let (start, end) = (times(read).0, times(other).1);
            let what = format!("`{name}` begins at {start} s, before `{second}` of a layer before ends, at {end} s");
            ("start", what, format!("give a `start` of {} s or later", up(end)))
        }
        Rule::Overlap => {
            let who = agent(problem, read);
            let ((from, to), (begin, end)) = (times(read), times(other));
            let what = format!(
                "`{who}` does `{name}` from {from} to {to} s and `{second}` from {begin} to {end} s, two at once"
            );
            ("start", what, "let one of them begin when the other has ended, or give another agent".into())
        }
        Rule::ObjectOnce => {
            let what = format!("`{name}` and `{second}` use the same object");
            ("object", what, "give each an object of its own".into())
        }
        rule => ("", format!("violated by `{name}` and `{second}`: {}", rule.text()), "change one of them".into()),
    }
}

/// Rounds a time (s) up to milliseconds, so that it is valid as an input.
fn up(time: f64) -> f64 {
    // Adding 0 turns -0 into 0.
    ((time - TOLERANCE) * 1e3).ceil() / 1e3 + 0.0
}

fn down(time: f64) -> f64 {
    ((time + TOLERANCE) * 1e3).floor() / 1e3
}
