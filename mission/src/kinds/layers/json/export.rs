//! Conversion of a problem, or of its plan, to JSON that [`import`](super::import) reads.

use std::fmt::Write;

use crate::kinds::layers::plan::Plan;
use crate::kinds::layers::problem::{Problem, Task};
use crate::kinds::layers::steps::{Step, from_plan};

/// Writes the layers of a problem with their tasks.
pub fn export(problem: &Problem) -> String {
    written(problem, &[])
}

/// Writes the layers with agent, object, start and end (s) of each task of a plan.
pub fn export_plan(problem: &Problem, plan: &Plan) -> String {
    written(problem, &from_plan(plan))
}

fn written(problem: &Problem, steps: &[Step]) -> String {
    let layers = problem.layers.iter().enumerate().map(|(layer, name)| {
        let tasks = problem.tasks.iter().enumerate().filter(|(_, task)| task.layer == layer);
        let lines = tasks.map(|(index, task)| {
            let step = steps.iter().find(|step| step.task == index);
            format!("        {{ {} }}", fields(problem, task, step).join(", "))
        });
        let lines: Vec<String> = lines.collect();
        format!("    {{\n      \"name\": {},\n      \"tasks\": [\n{}\n      ]\n    }}", quoted(name), lines.join(",\n"))
    });
    let layers: Vec<String> = layers.collect();
    format!("{{\n  \"layers\": [\n{}\n  ]\n}}\n", layers.join(",\n"))
}

fn fields(problem: &Problem, task: &Task, step: Option<&Step>) -> Vec<String> {
    let mut fields = vec![format!("\"name\": {}", quoted(&task.name)), format!("\"action\": {}", quoted(&task.action))];
    if !task.features.is_empty() {
        let features: Vec<String> = task.features.iter().map(|feature| quoted(feature)).collect();
        fields.push(format!("\"features\": [{}]", features.join(", ")));
    }
    if let Some((last, motion)) = task.path.split_last() {
        if !motion.is_empty() {
            let motion: Vec<String> = motion.iter().map(position).collect();
            fields.push(format!("\"motion\": [{}]", motion.join(", ")));
        }
        fields.push(format!("\"to\": {}", position(last)));
    }
    let agent = step.map(|step| step.agent).or(task.agent).and_then(|agent| problem.agents.get(agent));
    fields.extend(agent.map(|who| format!("\"agent\": {}", quoted(&who.name))));
    let object = step.map_or(task.object, |step| step.object).and_then(|object| problem.objects.get(object));
    fields.extend(object.map(|thing| format!("\"object\": {}", quoted(&thing.name))));
    fields.extend(step.map(|step| format!("\"start\": {}, \"end\": {}", step.start, step.end)));
    fields
}

fn position([x, y, z]: &[f64; 3]) -> String {
    format!("[{x}, {y}, {z}]")
}

/// Quotes a text and escapes it for JSON.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            control if control < ' ' => drop(write!(quoted, "\\u{:04x}", u32::from(control))),
            other => quoted.push(other),
        }
    }
    quoted.push('"');
    quoted
}
