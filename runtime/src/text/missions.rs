//! Missions as text: the text of the kind, the controllers that members run, and the scenarios.

use std::fmt::Write;

use super::number;
use crate::program::{Job, MissionProgram, MissionScenarioProgram};

/// The text of a mission, for people to review and for snapshots to hold.
pub fn mission(mission: &MissionProgram) -> String {
    let mut out = mission.kind.text(&mission.name);
    // Writing to a String does not fail.
    let _ = running(mission).iter().try_for_each(|line| writeln!(out, "  {line}"));
    let _ = mission.scenarios.iter().try_for_each(|s| scenario(s, mission, &mut out));
    let _ = super::allowed(&mission.allowed, &mut out);
    out
}

/// The members that run controllers, a sentence each.
pub fn running(of: &MissionProgram) -> Vec<String> {
    let (members, labels) = (of.kind.members(), of.kind.labels());
    let mut all = Vec::new();
    for w in &of.running.workers {
        let (Some(who), Some(c)) = (members.get(w.member), of.running.controller(w)) else { continue };
        let signal = |signal: usize| c.program.interface.signals.get(signal).map_or("?", |s| &s.name);
        let job = match &w.job {
            Job::Operations { go, done } => {
                let done = c.program.machine.as_ref().and_then(|m| m.states.get(*done)).map_or("?", |s| &s.name);
                format!("go is `{}`, done is `{done}`", signal(*go))
            }
            Job::Drive(drive) => {
                let heading = drive.heading.map_or(String::new(), |of| format!(", heading is `{}`", signal(of)));
                let going = drive.going.map_or(String::new(), |of| format!(", going is `{}`", signal(of)));
                let human = |human: usize| c.program.interface.humans.get(human).map_or("?", |h| h.name.as_str());
                let member = |member: usize| members.get(member).map_or("?", |member| labels.member(member.name));
                let people = drive.people.iter().map(|(of, is)| format!(", `{}` is {}", human(*of), member(*is)));
                format!("target is `{}`{heading}{going}{}", signal(drive.target), people.collect::<String>())
            }
        };
        let world =
            if w.world.name.is_empty() { String::new() } else { format!(", in the world of \"{}\"", w.world.name) };
        all.push(format!(
            "{} runs {} at {} Hz in scenarios{world}: {job}",
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
