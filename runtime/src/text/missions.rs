//! Missions as text: the text of the kind, the controllers that members run, and the scenarios.

use std::fmt::Write;

use super::number;
use crate::program::{MissionProgram, MissionScenarioProgram};

/// The text of a mission, for people to review and for snapshots to hold.
pub fn mission(mission: &MissionProgram) -> String {
    let mut out = mission.kind.text(&mission.name);
    // Writing to a String does not fail.
    let _ = running(mission).iter().try_for_each(|line| writeln!(out, "  {line}"));
    let _ = mission.scenarios.iter().try_for_each(|s| scenario(s, mission, &mut out));
    out
}

/// The members that run controllers, a sentence each.
pub fn running(of: &MissionProgram) -> Vec<String> {
    let (members, labels) = (of.kind.members(), of.kind.labels());
    let mut all = Vec::new();
    for w in &of.running.workers {
        let (Some(who), Some(c)) = (members.get(w.member), of.running.controller(w)) else { continue };
        let go = c.program.interface.signals.get(w.go).map_or("?", |s| &s.name);
        let machine = c.program.machine.as_ref();
        let done = machine.and_then(|m| m.states.get(w.done)).map_or("?", |s| &s.name);
        let world =
            if w.world.name.is_empty() { String::new() } else { format!(", in the world of \"{}\"", w.world.name) };
        all.push(format!(
            "{} runs {} at {} Hz in scenarios{world}: go is `{go}`, done is `{done}`",
            match labels.members.get(who.name) {
                Some(label) => format!("{label} ({})", who.name),
                None => who.name.to_string(),
            },
            c.spec,
            number(1.0 / c.program.robot.period)
        ));
    }
    all
}

/// A scenario: how the mission is executed, the events, and the expectations.
fn scenario(s: &MissionScenarioProgram, of: &MissionProgram, out: &mut String) -> std::fmt::Result {
    let (duration, step) = (number(s.duration), number(s.step));
    let durations = of.kind.describe_run(&s.run(of));
    writeln!(out, "\nscenario \"{}\": for {duration} s in steps of {step} s, seed {}, {durations}", s.name, s.seed)?;
    for happens in &s.happens {
        writeln!(out, "  at {} s: {}", number(happens.at), of.kind.describe(&happens.what))?;
    }
    for replies in &s.replies {
        for (i, reply) in replies.services.iter().enumerate() {
            if let Some(reply) = reply {
                writeln!(out, "  after service {}: {}", i + 1, of.kind.describe(reply))?;
            }
        }
    }
    expectations(s, out)
}

fn expectations(s: &MissionScenarioProgram, out: &mut String) -> std::fmt::Result {
    for e in &s.expectations {
        let label = e.label.as_ref().map(|l| format!("\"{l}\" ")).unwrap_or_default();
        writeln!(out, "  expect {label}{}", e.text)?;
    }
    Ok(())
}
