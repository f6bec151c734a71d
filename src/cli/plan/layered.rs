//! Planning of layers of tasks, and the output of the plan as text and as data.

use std::fmt::Write;

use hierarq::gantt;
use hierarq::plan_data::{Found, PlanData};
use hierarq::planned::{self, PlannedLayers};
use mission::kinds::layers::Layers;
use mission::kinds::layers::choose::{Formulation, Options};
use mission::kinds::layers::cost::Cost;
use mission::kinds::layers::problem::Problem;
use runtime::program::MissionProgram;

use super::super::output;
use super::{Arguments, Pictures, aligned, asked, batch, budget, coloured, data, refused, status};

/// Plans layers; returns the output.
pub(super) fn plan(a: &Arguments, mission: &MissionProgram, of: &Layers, pictures: Pictures) -> Result<String, String> {
    if of.problem.tasks.is_empty() {
        let name = &mission.name;
        return Err(format!(
            "mission `{name}` has no layers yet: let a model write them, `hierarq context {} {name} --out {name}.json`, and name \
             the file in the mission, `layers_from \"{name}.json\"`",
            a.spec.display()
        ));
    }
    let formulation = asked(a, "layers", Formulation::ALL, Formulation::name)?;
    let mut options = Options { formulation, engine: a.engine, ..Options::default() };
    options.batch = batch(a).or(of.batch);
    if a.budget.is_some() {
        options.budget = budget(a)?;
    }
    let planned = planned::layers(&of.problem, &options).map_err(|why| refused(&why))?;
    pictures.draw(&planned.plan, &mission.kind)?;
    Ok(match a.json {
        true => {
            let found = Found { formulation: planned.choice.formulation.name(), why: &planned.choice.why.to_string() };
            let of_spec = (a.spec.display().to_string(), &mission.name);
            data(&PlanData::of_layers((&of_spec.0, of_spec.1), &of.problem, (&planned.plan, &planned.cost), found))
        }
        false => text(mission, &of.problem, &planned),
    })
}

/// Returns the plan of layers as text.
fn text(mission: &MissionProgram, problem: &Problem, p: &PlannedLayers) -> String {
    let end = p.plan.end().unwrap_or(0.0);
    let mut out = format!("mission {}: {} tasks, all done after {end:.1} s\n", mission.name, p.steps.len());
    let _ = writeln!(out, "planned by {} ({}): {}", p.choice.formulation.name(), p.plan.engine, p.choice.why);
    let _ = writeln!(out, "{}", status(&p.plan.status));
    let _ = writeln!(out, "checked: it keeps to everything that the mission says\n");
    let mut out = output::plain(&out) + &gantt::text(&p.plan, output::width(), coloured());
    let chart = out.len();
    let header = ["layer", "task", "who", "does", "with", "begins", "ends", "speed"];
    let mut rows = Vec::new();
    let mut last = "";
    for step in &p.steps {
        let Some(task) = problem.tasks.get(step.task) else { continue };
        let layer = problem.layer_label(task.layer).unwrap_or_default();
        let who = problem.agent_label(step.agent).unwrap_or_default();
        let object = step.object.and_then(|o| problem.object_label(o)).unwrap_or("-");
        let shown = if layer == last { "" } else { layer };
        last = layer;
        rows.push(vec![
            shown.to_string(),
            problem.labels.task(&task.name).to_string(),
            who.to_string(),
            task.action.clone(),
            object.to_string(),
            format!("{:.1}", step.start),
            format!("{:.1}", step.end),
            if problem.distance(step.agent, step.task, step.object) > 0.0 {
                format!("{:.3}", step.speed)
            } else {
                "-".to_string()
            },
        ]);
    }
    let _ = writeln!(out, "\n{}(times in s, speeds in m/s)", aligned(&header, &rows, 5));
    let _ = writeln!(out, "{}", cost(&p.cost));
    let below = output::plain(&out.split_off(chart));
    out + &below
}

/// Returns the cost of a plan of layers, term by term.
pub fn cost(c: &Cost) -> String {
    format!(
        "cost {:.4}, from workload {:.4}, energy {:.4} and makespan {:.4}, each before its weight",
        c.total(),
        c.workload,
        c.energy,
        c.makespan
    )
}
