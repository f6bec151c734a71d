//! Signals and the machine of a program as text.

use std::fmt::Write;

use super::number;
use crate::program::{
    ActionProgram, Between, Conditioning, Lost, MachineProgram, Program, SignalProgram, StateProgram, Tracking,
    Velocity,
};

/// Writes the interface: signals with their types and indices, events with their sources.
pub(super) fn signals(p: &Program, out: &mut String) -> std::fmt::Result {
    let interface = &p.interface;
    if !interface.signals.is_empty() {
        writeln!(out, "\nsignals  {} numbers", interface.width())?;
    }
    for s in &interface.signals {
        let mark = if s.optional { "?" } else { "" };
        write!(out, "  {} : {}{mark}", s.name, s.kind)?;
        conditioning(p, &s.conditioning, out)?;
        match s.timeout {
            _ if s.age_of.is_some() => write!(out, "  set by the controller")?,
            _ if is_measured(p, s) => write!(out, "  measured by the controller")?,
            _ if s.is_variable() => initial(s.variable.as_ref().and_then(|v| v.value.as_deref()), out)?,
            Some(timeout) => write!(out, "  timeout {} s", number(timeout))?,
            None => write!(out, "  no timeout")?,
        }
        match s.len {
            1 => writeln!(out, "  present {}, value {}", s.at, s.at + 1)?,
            _ => writeln!(out, "  present {}, value {}..{}", s.at, s.at + 1, s.at + s.len)?,
        }
        if let Some(motion) = &s.motion {
            moving(s, motion, out)?;
        }
    }
    for h in &interface.humans {
        let name = |i: &usize| interface.signals.get(*i).map_or("?", |s| s.name.as_str());
        let points: Vec<&str> = h.points.iter().map(name).collect();
        writeln!(out, "  human {}: {} points, {} links: {}", h.name, points.len(), h.links.len(), points.join(", "))?;
    }
    if interface.events.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nevents")?;
    let actions = p.machine.as_ref().map_or(&[][..], |m| &m.actions);
    for (i, event) in interface.events.iter().enumerate() {
        let mut from: Vec<&str> = Vec::new();
        for a in actions {
            if (a.event == Some(i) || a.outcomes.iter().any(|o| o.1 == i)) && !from.contains(&a.verb.as_str()) {
                from.push(&a.verb);
            }
        }
        let from = if from.is_empty() { "the host".to_string() } else { format!("{} or the host", from.join(", ")) };
        writeln!(out, "  {event}  from {from}")?;
    }
    Ok(())
}

/// Returns true if a signal is a measure of the motion, or the flag of a target that is reached.
fn is_measured(p: &Program, s: &SignalProgram) -> bool {
    let measured = p.machine.iter().flat_map(|m| m.measured.iter().map(|m| m.signal));
    let reached = p.machine.iter().flat_map(|m| m.reached.iter().map(|r| r.signal));
    measured.chain(reached).filter_map(|signal| p.interface.signals.get(signal)).any(|of| of.at == s.at)
}

/// Writes the motion of a tracked signal, and the indices of its numbers.
fn moving(s: &SignalProgram, motion: &Tracking, out: &mut String) -> std::fmt::Result {
    let (v, u) = (s.velocity_at(), s.uncertainty_at());
    let last = v + s.len - 1;
    match motion.velocity {
        Velocity::Estimated(cutoff) => {
            write!(out, "    velocity {v}..{}, estimated below {} Hz", last, number(cutoff))?
        }
        Velocity::Measured => write!(out, "    velocity {v}..{}, measured", last)?,
        Velocity::None => write!(out, "    no velocity")?,
    }
    if let Some(most) = motion.max_speed {
        write!(out, ", at most {} m/s", number(most))?;
    }
    if let Some(most) = motion.max_angular_speed {
        write!(out, ", at most {} rad/s", number(most))?;
    }
    if motion.between == Between::Extrapolate {
        write!(out, ", goes on between readings")?;
    }
    match motion.lost {
        Lost::Fault => writeln!(out, "; lost: a fault"),
        Lost::Hold(growth) => writeln!(out, "; lost: held, uncertainty {u} grows by {} m/s", number(growth)),
    }
}

/// Writes the initial value of a variable.
fn initial(value: Option<&[f64]>, out: &mut String) -> std::fmt::Result {
    match value {
        Some([one]) => write!(out, "  variable, {} at the start", number(*one)),
        Some(all) => {
            let all: Vec<String> = all.iter().map(|x| number(*x)).collect();
            write!(out, "  variable, [{}] at the start", all.join(", "))
        }
        None => write!(out, "  variable, absent at the start"),
    }
}

fn conditioning(p: &Program, c: &Conditioning, out: &mut String) -> std::fmt::Result {
    if let Some(link) = c.frame.and_then(|l| p.robot.model.links.get(l.index())) {
        write!(out, "  frame {}", link.name)?;
    }
    if let Some(bias) = &c.bias {
        let all: Vec<String> = bias.iter().map(|x| number(*x)).collect();
        write!(out, "  bias [{}]", all.join(", "))?;
    }
    match c.low_pass {
        Some(cutoff) => write!(out, "  low_pass {} Hz", number(cutoff)),
        None => Ok(()),
    }
}

/// Writes the machine: nested states, with stacks, actions and transitions.
pub(super) fn machine(p: &Program, out: &mut String) -> std::fmt::Result {
    let Some(m) = &p.machine else { return Ok(()) };
    let Some(root) = m.states.first() else { return Ok(()) };
    writeln!(out, "\nmachine {}  {} states, {} actions", root.name, m.states.len() - 1, m.actions.len())?;
    for (i, state) in m.states.iter().enumerate() {
        let depth = m.path(i).count() - 1;
        if i > 0 {
            let word = match m.region(i) {
                _ if state.is_final => "final state",
                Some(region) if region == i => "region",
                _ => "state",
            };
            writeln!(out, "{:indent$}{word} {}", "", state.name, indent = 2 * depth)?;
        }
        body(p, m, i, state, 2 * depth + 2, out)?;
    }
    Ok(())
}

fn body(
    p: &Program,
    m: &MachineProgram,
    index: usize,
    state: &StateProgram,
    indent: usize,
    out: &mut String,
) -> std::fmt::Result {
    let stack = |k: usize| p.stacks.get(k).map_or("?", |s| s.name.as_str());
    // While a region names no stack, those of the others run.
    let owner = m.path(index).find(|&s| m.states[s].stack.is_some());
    match (state.stack, owner) {
        (Some(own), _) => writeln!(out, "{:indent$}stack {}", "", stack(own))?,
        (None, Some(owner)) if state.initial.is_none() => {
            let outer = &m.states[owner];
            let name = outer.stack.map_or("?", stack);
            writeln!(out, "{:indent$}stack {name}, that of {}", "", outer.name)?;
        }
        (None, None) if state.initial.is_none() && m.region(index).is_none() => {
            writeln!(out, "{:indent$}no stack: the robot stands", "")?
        }
        _ => {}
    }
    if !state.regions.is_empty() {
        let names: Vec<&str> = state.regions.iter().filter_map(|r| m.states.get(*r)).map(|s| s.name.as_str()).collect();
        writeln!(out, "{:indent$}regions {}", "", names.join(", "))?;
    } else if let Some(initial) = state.initial.and_then(|i| m.states.get(i)) {
        writeln!(out, "{:indent$}initial {}", "", initial.name)?;
    }
    for (moment, all) in [("enter", &state.enter), ("do", &state.activities), ("exit", &state.exit)] {
        for action in all.iter().filter_map(|&a| m.actions.get(a)) {
            writeln!(out, "{:indent$}{moment} {}", "", asked(p, action))?;
        }
    }
    for t in &state.transitions {
        let target = m.states.get(t.target).map_or("?", |s| s.name.as_str());
        write!(out, "{:indent$}{} -> {target}", "", t.text)?;
        if t.blend > 0.0 {
            write!(out, "  blend {} s", number(t.blend))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// `capture(head_camera): found, not_found`
fn asked(p: &Program, a: &ActionProgram) -> String {
    let words: Vec<String> =
        a.arguments.iter().map(|w| if is_word(w) { w.clone() } else { format!("{w:?}") }).collect();
    let mut text = format!("{}({})", a.verb, words.join(", "));
    let outcomes: Vec<&str> =
        a.outcomes.iter().filter_map(|o| p.interface.events.get(o.1)).map(String::as_str).collect();
    if !outcomes.is_empty() {
        let _ = write!(text, ": {}", outcomes.join(", "));
    }
    text
}

fn is_word(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '.' | '-'))
}
