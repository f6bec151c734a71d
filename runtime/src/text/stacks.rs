//! Stacks: levels, tasks, and the rows that they write.

use std::fmt::Write;

use names::wrapped;
use solver::Structure;
use stdlib_tasks::task::RowKind;

use super::{number, parameters, runs};
use crate::controller::{Controller, Observation};
use crate::evaluator::{Evaluator, Member, build_tasks};
use crate::feasibility::{self, Obstacle};
use crate::program::{IdleRow, Program, StackProgram};
use crate::stopping::{self, Stopping};

/// Writes a stack: its levels and tasks, with the properties of their rows that are known before any tick.
pub(super) fn stack(p: &Program, index: usize, stack: &StackProgram, out: &mut String) -> std::fmt::Result {
    writeln!(out, "\nstack {}", stack.name)?;
    if !stack.locked.is_empty() {
        let names: Vec<&str> = stack.locked.iter().map(|&d| p.robot.model.dofs[d].name.as_str()).collect();
        writeln!(out, "  locked {}", names.join(", "))?;
    }
    let Ok((evaluator, problem)) = Evaluator::new(p, index) else {
        return writeln!(out, "  cannot be built");
    };
    if let Some(found) = feasibility::obstacles(p, index) {
        proof(p, &found, out)?;
    }
    if let Some(stop) = stopping::of_stack(p, index) {
        stopping(&stop, out)?;
    }
    let built = build_tasks(p, stack);
    let freedom = freedom(p, index);
    let mut members = evaluator.members().iter().zip(built);
    for (i, level) in stack.levels.iter().enumerate() {
        let mut flags = String::new();
        if level.hard {
            flags.push_str("  hard");
        }
        if level.exact {
            flags.push_str("  damping none");
        }
        if level.damping > 0.0 {
            let _ = write!(flags, "  damping {}", level.damping);
        }
        let left = freedom.get(i).map_or_else(|| "?".to_string(), usize::to_string);
        writeln!(
            out,
            "  level {} {}{flags}  {} rows, freedom left at home {left}",
            i + 1,
            level.name,
            problem.levels[i].rows()
        )?;
        structure(&problem.levels[i], out)?;
        for member in &level.members {
            let Some((m, task)) = members.next() else { break };
            let kind = if m.row_kind == RowKind::Inequality { "inequalities" } else { "equalities" };
            let weight = if member.weight == 1.0 { String::new() } else { format!("  weight {}", member.weight) };
            writeln!(out, "    {}: {}  {} {kind}{weight}", m.name, m.kind, m.rows.len())?;
            let Ok(task) = task.task else { continue };
            let mut gains = task.gains(&p.values.initial);
            gains.dedup();
            if !gains.is_empty() {
                let products: Vec<String> = gains.iter().map(|g| number(g * p.robot.period)).collect();
                let gains: Vec<String> = gains.iter().map(|g| number(*g)).collect();
                writeln!(out, "      gain {} /s, gain × period {}", gains.join(", "), products.join(", "))?;
            }
            parameters(p, &p.tasks[m.program_index], !gains.is_empty(), out)?;
            let (loss, reserve) = (worst(&task.sampled_loss()), worst(&task.sampled_margin()));
            if let Some(loss) = loss {
                let bound = if loss.is_finite() {
                    format!("{} mm", number(loss * 1e3))
                } else {
                    "unbounded: no hard level limits the speeds".to_string()
                };
                let reserve = if level.hard && task.looks_ahead() {
                    "none held in reserve: each tick looks ahead and loses nothing".to_string()
                } else {
                    format!("held in reserve {} mm", number(reserve.unwrap_or(0.0) * 1e3))
                };
                writeln!(out, "      sampled-time loss at most {bound}, {reserve}")?;
            }
            let names: Vec<&str> = m.row_info.iter().map(|r| r.name.as_str()).collect();
            if m.row_kind == RowKind::Inequality {
                wrapped("rows", &names, out)?;
            }
            idle(m, &member.idle, out)?;
        }
    }
    Ok(())
}

/// Writes whether the hard levels can always be met, or the tasks that break the proof.
fn proof(p: &Program, found: &[Obstacle], out: &mut String) -> std::fmt::Result {
    const SHOWN: usize = 3;
    if found.is_empty() {
        return writeln!(out, "  never infeasible from a safe state: v = 0 meets every hard row");
    }
    writeln!(out, "  not proven that v = 0 meets every hard row:")?;
    for o in found.iter().take(SHOWN) {
        writeln!(out, "    `{}` {}", p.tasks[o.task].name, o.why.text())?;
    }
    match found.len().saturating_sub(SHOWN) {
        0 => Ok(()),
        1 => writeln!(out, "    and one more task"),
        n => writeln!(out, "    and {n} more tasks"),
    }
}

/// Writes the bounds of a stop from the largest speeds.
fn stopping(stop: &Stopping, out: &mut String) -> std::fmt::Result {
    let bounded = |x: f64, unit: &str| match x.is_finite() {
        true => format!("{} {unit}", number(x)),
        false => "no bound".to_string(),
    };
    writeln!(out, "  to rest from full speed: time {}, ways", bounded(stop.time_s, "s"))?;
    let joints = runs(stop.joints.iter().map(|j| (bounded(j.way, j.unit), j.joint.as_str())));
    let links = runs(stop.links.iter().map(|l| (bounded(l.way_m, "m"), l.link.as_str())));
    let listed = [("joints", joints), ("links", links)];
    listed.iter().filter(|(_, all)| !all.is_empty()).try_for_each(|(head, all)| {
        let all: Vec<&str> = all.iter().map(String::as_str).collect();
        wrapped(head, &all, out)
    })
}

/// Degrees of freedom left after each level at the home configuration.
fn freedom(p: &Program, stack: usize) -> Vec<usize> {
    let Ok(mut controller) = Controller::for_stack(p, stack).map(Controller::without_enabling) else {
        return Vec::new();
    };
    let fault = controller.step(&Observation { time: 0.0, q: &p.robot.home }).fault;
    if fault.is_some() || controller.awaited().is_some() {
        return Vec::new();
    }
    (0..controller.solution().levels.len()).map(|level| controller.freedom(level)).collect()
}

fn worst(list: &[f64]) -> Option<f64> {
    list.iter().copied().reduce(f64::max)
}

/// Writes the structure of a level's rows that is known before any tick: the number of bounds of single joints, and a
/// note if joints have more than one.
fn structure(level: &solver::Level, out: &mut String) -> std::fmt::Result {
    let mut bounds = vec![0_usize; level.columns()];
    let (mut constant, mut zero) = (0, 0);
    for s in level.structure() {
        match s {
            Structure::Bound { column, .. } => bounds[*column] += 1,
            Structure::Constant { .. } => zero += 1,
            Structure::Open | Structure::Absent => continue,
        }
        constant += 1;
    }
    if constant == 0 {
        return Ok(());
    }
    let joints = bounds.iter().filter(|n| **n > 0).count();
    write!(out, "    {constant} constant rows: {} bounds on {joints} joints", constant - zero)?;
    if bounds.iter().any(|n| *n > 1) {
        write!(out, ", those on one joint merged while they leave an interval")?;
    }
    if zero > 0 {
        write!(out, "; {zero} rows of locked joints")?;
    }
    writeln!(out)
}

/// Writes the rows that are left out, with the reason.
fn idle(m: &Member, idle: &[IdleRow], out: &mut String) -> std::fmt::Result {
    if idle.is_empty() {
        return Ok(());
    }
    let unit = m.dimension().map_or_else(String::new, |d| format!(" {d}/s"));
    let one = |r: &IdleRow| {
        let name = m.row_info.get(r.row).map_or("?", |i| i.name.as_str());
        format!("{name} (falls by at most {}{unit}, and {} are allowed)", number(r.fastest), number(r.allowed))
    };
    let list: Vec<String> = idle.iter().map(one).collect();
    wrapped(
        "never active inside the joints' limits, left out:",
        &list.iter().map(String::as_str).collect::<Vec<_>>(),
        out,
    )
}
