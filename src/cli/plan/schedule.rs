//! Planning of a schedule, and the output of the plan as text and as data.

use std::fmt::Write;

use hierarq::gantt;
use hierarq::plan_data::PlanData;
use hierarq::planned::{self, Planned};
use mission::kinds::schedule::Schedule;
use mission::kinds::schedule::choose::{Formulation, Options};
use mission::kinds::schedule::cost::Cost;
use runtime::program::MissionProgram;

use super::super::output;
use super::{Arguments, Pictures, aligned, asked, batch, budget, coloured, data, refused, status};

/// Plans a schedule; returns the output.
pub(super) fn plan(
    a: &Arguments,
    mission: &MissionProgram,
    of: &Schedule,
    pictures: Pictures,
) -> Result<String, String> {
    let formulation = asked(a, "a schedule", Formulation::ALL, Formulation::name)?;
    let options = Options { formulation, engine: a.engine, batch: batch(a).unwrap_or(of.batch), budget: budget(a)? };
    let planned = planned::schedule(&of.problem, &options).map_err(|why| refused(&why))?;
    pictures.draw(&planned.plan, &mission.kind)?;
    Ok(if a.json {
        data(&PlanData::of_schedule(&a.spec.display().to_string(), &mission.name, &of.problem, &planned))
    } else {
        text(mission, &planned, &runtime::text::running(mission))
    })
}

/// Returns the plan as text.
fn text(mission: &MissionProgram, p: &Planned, runs: &[String]) -> String {
    let mut out = format!("mission {}: {}\n", mission.name, mission_end(p));
    let _ = writeln!(out, "planned by {} ({}): {}", p.choice.formulation.name(), p.plan.engine, p.choice.why);
    let _ = writeln!(out, "{}", status(&p.plan.status));
    let _ = writeln!(out, "checked: it keeps to everything that the mission says\n");
    let mut out = output::plain(&out) + &gantt::text(&p.plan, output::width(), coloured());
    let chart = out.len();
    let _ = writeln!(out, "\n{}\n{}", services(p), cost(&p.cost));
    for line in runs {
        let _ = writeln!(out, "{line}");
    }
    let below = output::plain(&out.split_off(chart));
    out + &below
}

fn mission_end(p: &Planned) -> String {
    let end = p.plan.end().unwrap_or(0.0);
    format!("{} services, all done after {end:.1} s", p.services.len())
}

/// Returns the table of services.
fn services(p: &Planned) -> String {
    let header =
        ["robot", "serves", "leaves", "waits", "comes", "serves", "goes", "done", "speed", "near", "back", "waited"];
    let time = |s: f64| format!("{s:.1}");
    let speed = |v: Option<f64>| v.map_or_else(|| "-".to_string(), |v| format!("{v:.3}"));
    let mut last = "";
    let mut rows = Vec::new();
    for s in &p.services {
        let robot = if s.robot == last { String::new() } else { p.plan.labels.member(&s.robot).to_string() };
        last = &s.robot;
        rows.push(vec![
            robot,
            format!("{}.{}", p.plan.labels.member(&s.agent), s.operation),
            time(s.leaves),
            time(s.waits),
            time(s.approaches),
            time(s.serves),
            time(s.returns),
            time(s.ends),
            speed(s.going_speed),
            speed(s.approach_speed),
            speed(s.return_speed),
            time(s.agent_waits),
        ]);
    }
    aligned(&header, &rows, 2)
        + "(when the robot leaves its depot, waits, comes near, serves, goes back and is done, in s; how fast it is on its way,\n \
           near the agent and back, in m/s; how long the agent waited, in s)\n"
}

/// Returns the cost, term by term.
fn cost(c: &Cost) -> String {
    format!(
        "cost {:.4}: waits of people {:.4}, of workers {:.4}, makespan {:.4},\n  energy of going {:.4}, of approaching \
         {:.4}, of coming back {:.4}",
        c.total(),
        c.human_wait,
        c.worker_wait,
        c.makespan,
        c.going,
        c.proximity,
        c.depositing
    )
}
