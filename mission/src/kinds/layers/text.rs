//! Layers as text, for people to review: the team, the objects, the layers, and the planning method.

use std::fmt::Write;

use names::wrapped;
use quantities::number;

use super::choose::{Options, choose};
use super::mission::Layers;
use super::problem::{Agent, Body, Problem, Task};
use super::scales::Scales;

/// The text of a mission with this name.
pub(super) fn text(name: &str, of: &Layers) -> String {
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(name, of, &mut out);
    out
}

fn write(name: &str, of: &Layers, out: &mut String) -> std::fmt::Result {
    let p = &of.problem;
    writeln!(out, "mission {name} : layers")?;
    writeln!(out, "  {} tasks in {} layers, {} objects", p.tasks.len(), p.layers.len(), p.objects.len())?;
    writeln!(out, "\n  {:<16} {:<6} {:>20} {:>14}  power, W", "agent", "", "base, m", "speed, m/s")?;
    p.agents.iter().try_for_each(|agent| one(agent, out))?;
    if !p.objects.is_empty() {
        writeln!(out, "\n  {:<16} {:>20} {:>8}  features", "object", "place, m", "mass, kg")?;
    }
    for o in &p.objects {
        let features: Vec<&str> = o.features.iter().map(String::as_str).collect();
        writeln!(out, "  {:<16} {:>20} {:>8}  {}", o.name, point(&o.place), number(o.mass), features.join(", "))?;
    }
    for (i, layer) in p.layers.iter().enumerate() {
        writeln!(out, "\n  layer {layer}")?;
        p.tasks.iter().filter(|t| t.layer == i).try_for_each(|t| task(p, t, out))?;
    }
    let w = p.weights;
    writeln!(
        out,
        "\n  cost: workload x {}, energy x {}, makespan x {}",
        number(w.workload),
        number(w.energy),
        number(w.makespan)
    )?;
    if p.tasks.is_empty() {
        return writeln!(out, "\n  a language model is asked for its layers");
    }
    writeln!(out, "    a makespan of {} s counts as 1", number(Scales::of(p).makespan))?;
    if !p.returns {
        writeln!(out, "    the way back to the base is no part of a task")?;
    }
    let options = Options { batch: of.batch, ..Options::default() };
    if let Ok(choice) = choose(p, &options) {
        writeln!(out, "\n  planned by {}: {}", choice.formulation.name(), choice.why)?;
    }
    writeln!(out, "  planned anew above a change of cost of {}", number(of.reallocate_above))
}

fn point(p: &[f64; 3]) -> String {
    p.map(number).join(", ")
}

fn one(a: &Agent, out: &mut String) -> std::fmt::Result {
    let (kind, speed, power) = match a.body {
        Body::Robot { speed, energy } => ("robot", speed.to_string(), energy.to_string()),
        Body::Human { speed, .. } => ("human", format!("up to {}", number(speed)), String::new()),
    };
    let line = format!("  {:<16} {kind:<6} {:>20} {speed:>14}  {power}", a.name, point(&a.place));
    writeln!(out, "{}", line.trim_end())?;
    let mut said: Vec<String> = a.skills.iter().map(|s| format!("{} {} s", s.action, number(s.duration))).collect();
    said.extend(
        a.skills.iter().filter(|s| s.pace < 1.0).map(|s| format!("{} at {} of the speed", s.action, number(s.pace))),
    );
    if let Body::Human { slowing, .. } = a.body
        && slowing > 0.0
    {
        said.push(format!("slower by {} for each kg", number(slowing)));
    }
    said.extend(a.reach.map(|r| format!("reaches {} m", number(r))));
    said.extend(a.payload.map(|m| format!("carries {} kg", number(m))));
    said.extend(a.cannot.iter().map(|f| format!("nothing {f}")));
    said.extend((a.spread > 0.0).then(|| format!("times spread by {}", number(a.spread))));
    wrapped("", &said.iter().map(String::as_str).collect::<Vec<_>>(), out)
}

fn task(p: &Problem, t: &Task, out: &mut String) -> std::fmt::Result {
    let mut line = format!("    {} = {}", t.name, t.action);
    let features: Vec<&str> = t.features.iter().map(String::as_str).collect();
    if !features.is_empty() {
        let _ = write!(line, "  {}", features.join(", "));
    }
    if let Some(o) = t.object.and_then(|o| p.objects.get(o)) {
        let _ = write!(line, "  with {}", o.name);
    }
    for place in &t.path {
        let _ = write!(line, "  to ({})", point(place));
    }
    if let Some(a) = t.agent.and_then(|a| p.agents.get(a)) {
        let _ = write!(line, "  by {}", a.name);
    }
    writeln!(out, "{line}")
}
