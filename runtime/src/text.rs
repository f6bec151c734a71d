//! A program as text: stable, for people to review and for snapshots to hold.

mod fields;
mod leaves;
mod machine;
mod missions;
mod operations;
mod scenarios;
mod stacks;

use std::fmt::Write;

use robot::DofUnit;
use stdlib_tasks::bound::{Bound, ExceptedPair, Exception, Slot};
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::expression::Expression;
use stdlib_tasks::kinds::keep;

use crate::program::{AllowedWarning, CaptureSource, Op, Program, Simulator, Subject, TaskProgram};
use leaves::{leaf, whole_leaf};
pub use missions::{mission, running};
use operations::operation;
pub use quantities::number;

/// Text of a program. `None` if the program cannot be executed.
pub fn text(program: &Program) -> Option<String> {
    program.check().ok()?;
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(program, &mut out);
    Some(out)
}

fn write(p: &Program, out: &mut String) -> std::fmt::Result {
    writeln!(out, "program {}  \"{}\"", p.name, p.title)?;
    robot(p, out)?;
    for (i, stack) in p.stacks.iter().enumerate() {
        stacks::stack(p, i, stack, out)?;
    }
    values(p, out)?;
    fields::fields(p, out)?;
    machine::signals(p, out)?;
    machine::machine(p, out)?;
    let ticks = (p.run.duration / p.robot.period).round();
    let subject = subject(p, p.run.subject);
    writeln!(out, "\nrun {subject} for {} s, {ticks} ticks, solver {}", p.run.duration, p.run.solver.name())?;
    simulator(&p.run.simulator, out)?;
    p.scenarios.iter().try_for_each(|s| scenarios::scenario(p, s, out))?;
    allowed(&p.allowed, out)
}

/// Warnings of the compiler that the spec allows.
fn allowed(all: &[AllowedWarning], out: &mut String) -> std::fmt::Result {
    if !all.is_empty() {
        writeln!(
            out,
            "\nallowed {}",
            if all.len() == 1 { "1 warning".into() } else { format!("{} warnings", all.len()) }
        )?;
    }
    all.iter().try_for_each(|a| writeln!(out, "  {} {}\n    \"{}\"", a.code, a.message, a.reason))
}

fn simulator(s: &Simulator, out: &mut String) -> std::fmt::Result {
    if s.lag > 0.0 || s.noise > 0.0 {
        writeln!(out, "  simulator lag {} s, noise {} rad or m, seed {}", s.lag, s.noise, s.seed)?;
    }
    if let Some(speed) = s.speed {
        writeln!(out, "  simulator speed at most {speed} rad/s or m/s")?;
    }
    if let Some(acceleration) = s.acceleration {
        writeln!(out, "  simulator acceleration at most {acceleration} rad/s^2 or m/s^2")?;
    }
    Ok(())
}

fn subject(p: &Program, subject: Subject) -> String {
    match subject {
        Subject::Stack(stack) => format!("stack {}", p.stacks[stack].name),
        Subject::Machine => format!("machine {}", p.machine.as_ref().map_or("", |m| m.states[0].name.as_str())),
    }
}

fn robot(p: &Program, out: &mut String) -> std::fmt::Result {
    let r = &p.robot;
    writeln!(out, "\nrobot {}  urdf {}  base {}  period {} s", r.name, r.urdf, r.base_words(), r.period)?;
    if r.tracking_gain > 0.0 {
        writeln!(out, "  tracking gain {} /s", r.tracking_gain)?;
    }
    if r.behind() > 0.0 {
        writeln!(out, "  drives: lag {} s, dead time {} s", r.lag, r.dead_time)?;
    }
    if r.stops_at_once {
        writeln!(out, "  stops in one tick")?;
    }
    if !r.enabling.is_empty() {
        writeln!(out, "  takes commands while {}", p.enabling_names().join(" and "))?;
    }
    if r.resumes_itself {
        writeln!(out, "  goes on by itself when it takes commands again")?;
    }
    writeln!(out, "  {} degrees of freedom, {} configuration numbers", r.model.nv(), r.model.nq())?;
    writeln!(out, "    {:<16} {:>9} {:>9} {:>9} {:>9}", "joint", "home", "lower", "upper", "speed")?;
    for d in &r.model.dofs {
        let home = d.q_index.map_or_else(|| "-".to_string(), |i| number(r.home[i]));
        let unit = if d.unit == DofUnit::Radian { "rad" } else { "m" };
        writeln!(
            out,
            "    {:<16} {home:>9} {:>9} {:>9} {:>9} {unit}",
            d.name,
            number(d.lower),
            number(d.upper),
            number(d.velocity)
        )?;
    }
    Ok(())
}

fn parameters(p: &Program, task: &TaskProgram, gain_is_said: bool, out: &mut String) -> std::fmt::Result {
    for (name, bound) in task.params.iter().filter(|(name, _)| !(gain_is_said && *name == "gain")) {
        if let Some(text) = bound_text(p, bound) {
            writeln!(out, "      {name} {text}")?;
        }
        if let Bound::Expression(e) = bound {
            expression(p, e, out)?;
        }
    }
    Ok(())
}

fn bound_text(p: &Program, bound: &Bound) -> Option<String> {
    match bound {
        Bound::Value(s) => Some(slot(p, s)),
        Bound::Frame(name, _) => Some(name.clone()),
        Bound::Frames(list) => Some(list.iter().map(|f| f.0.as_str()).collect::<Vec<_>>().join(", ")),
        Bound::Arm(a) => Some(format!("{} (tip {})", a.name, p.robot.model.link_ref(a.tip).name)),
        // The names of the rows contain them.
        Bound::Geometries(_) => None,
        Bound::Obstacles(list) => Some(list.iter().map(|o| o.name.as_str()).collect::<Vec<_>>().join(", ")),
        Bound::Pairs(list) => excepted(p, list),
        Bound::Joints(list) => {
            Some(list.iter().map(|&d| p.robot.model.dofs[d].name.as_str()).collect::<Vec<_>>().join(", "))
        }
        Bound::PerJoint(list) => {
            let joints = list.iter().map(|(dof, s)| (slot(p, s), p.robot.model.dofs[*dof].name.as_str()));
            Some(runs(joints).join(", "))
        }
        Bound::PerArm(list) => {
            Some(list.iter().map(|(a, s)| format!("{} {}", a.name, slot(p, s))).collect::<Vec<_>>().join(", "))
        }
        Bound::Choice(word) => Some(word.clone()),
        Bound::Axes(chosen) => Some(stdlib_tasks::axis_rows::Axes(*chosen).names().collect::<Vec<_>>().join(", ")),
        Bound::Task(task) => p.tasks.get(*task).map(|t| t.name.clone()),
        Bound::Field(field) => p.fields.get(*field).map(|f| f.name.clone()),
        Bound::Expression(e) => {
            let parts: Vec<String> = e.outputs.iter().map(|o| format!("${o}")).collect();
            let value = if parts.len() == 1 { parts[0].clone() } else { format!("[{}]", parts.join(", ")) };
            let unit = if e.dimension == NONE { String::new() } else { format!(" in {}", e.dimension) };
            Some(format!("{value}{unit}, by {} operations on the robot's state", e.ops.len()))
        }
        Bound::Group(map) => {
            let inner: Vec<String> =
                map.iter().filter_map(|(k, b)| Some(format!("{k} {}", bound_text(p, b)?))).collect();
            Some(format!("{{ {} }}", inner.join("  ")))
        }
    }
}

/// Pairs of links that a task leaves out, by their reasons; none without any.
fn excepted(p: &Program, list: &[ExceptedPair]) -> Option<String> {
    let mut by_reason: Vec<(String, Vec<String>)> = Vec::new();
    for ExceptedPair { links: [a, b], why } in list {
        let why = match why {
            Exception::Written => "by the spec".to_string(),
            Exception::Disabled(reason) if reason.is_empty() => "by the SRDF".to_string(),
            Exception::Disabled(reason) => format!("by the SRDF, {reason}"),
            Exception::Touching => "touching at every sampled posture".to_string(),
        };
        let name = |l: &robot::LinkId| p.robot.model.link_ref(*l).name.as_str();
        let pair = format!("{} to {}", name(a), name(b));
        match by_reason.iter_mut().find(|(reason, _)| *reason == why) {
            Some((_, pairs)) => pairs.push(pair),
            None => by_reason.push((why, vec![pair])),
        }
    }
    let lines = by_reason.iter().map(|(why, pairs)| format!("\n        {why}: {}", pairs.join(", ")));
    (!by_reason.is_empty()).then(|| format!("{} pairs of links{}", list.len(), lines.collect::<String>()))
}

/// Runs of names that share a value: `torso_yaw..head_tilt 0`.
fn runs<'a>(values: impl Iterator<Item = (String, &'a str)>) -> Vec<String> {
    let mut runs: Vec<(String, Vec<&str>)> = Vec::new();
    for (value, name) in values {
        match runs.last_mut() {
            Some(run) if run.0 == value => run.1.push(name),
            _ => runs.push((value, vec![name])),
        }
    }
    let one = |(value, names): &(String, Vec<&str>)| match names.as_slice() {
        [only] => format!("{only} {value}"),
        [first, .., last] => format!("{first}..{last} {value}"),
        [] => String::new(),
    };
    runs.iter().map(one).collect()
}

/// Numbers of a slot; moving ones as the result of the tape that they read.
fn slot(p: &Program, s: &Slot) -> String {
    let one = |at: usize| match p.values.tape.outputs.iter().find(|o| o.at == at) {
        Some(o) => format!("%{}", o.value),
        // A limit with an open side.
        None if p.values.initial[at].abs() >= keep::OPEN => "none".to_string(),
        None => number(p.values.initial[at]),
    };
    let parts: Vec<String> = (s.at..s.at + s.len).map(one).collect();
    if parts.len() == 1 { parts[0].clone() } else { format!("[{}]", parts.join(", ")) }
}

fn values(p: &Program, out: &mut String) -> std::fmt::Result {
    let v = &p.values;
    writeln!(
        out,
        "\nvalues {} constant, {} moving by {} operations",
        v.initial.len() - v.tape.outputs.len(),
        v.tape.outputs.len(),
        v.tape.ops.len()
    )?;
    for c in &v.captures {
        let source = match &c.source {
            CaptureSource::Task(t, name) => format!("{name} of {}", p.tasks[*t].name),
            CaptureSource::Velocity(t, name, _) => format!("velocity of {name} of {}", p.tasks[*t].name),
            CaptureSource::State(e) => {
                let outputs: Vec<String> = e.outputs.iter().map(|o| format!("${o}")).collect();
                whole_leaf(p, e).unwrap_or_else(|| format!("[{}]", outputs.join(", ")))
            }
        };
        writeln!(out, "  captured {}..{}: {source}", c.at, c.at + c.len)?;
        if let CaptureSource::State(e) = &c.source
            && whole_leaf(p, e).is_none()
        {
            expression(p, e, out)?;
        }
    }
    for t in &v.tape.trajectories {
        writeln!(out, "  {}", operations::trajectory(t))?;
    }
    for (i, op) in v.tape.ops.iter().enumerate() {
        writeln!(out, "  %{i} = {}", operation(op, '%'))?;
    }
    let mut said = Vec::new();
    for o in &v.tape.outputs {
        if !said.contains(&o.value) {
            said.push(o.value);
            writeln!(out, "  value %{} with rate %{}", o.value, o.rate)?;
        }
    }
    Ok(())
}

/// Operations of an expression of the state; `$` numbers these operations, `%` are values of the tape.
fn expression(p: &Program, e: &Expression, out: &mut String) -> std::fmt::Result {
    let states: Vec<String> = e.leaves.iter().flat_map(|l| leaf(p, l)).collect();
    for (i, op) in e.ops.iter().enumerate() {
        let text = match *op {
            Op::Input(k) => e.inputs.get(k).map_or_else(String::new, |&at| slot(p, &Slot { at, len: 1 })),
            Op::State(k) => states.get(k).cloned().unwrap_or_default(),
            _ => operation(op, '$'),
        };
        writeln!(out, "        ${i} = {text}")?;
    }
    Ok(())
}
