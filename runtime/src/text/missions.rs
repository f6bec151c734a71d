//! Missions as text: the team, the ways, what counts how much, and how they will be planned.

use std::fmt::Write;

use mission::kinds::Mission;
use mission::kinds::schedule::Schedule;
use mission::kinds::schedule::chance::nominal;
use mission::kinds::schedule::choose::{Options, choose};
use mission::kinds::schedule::problem::{AgentKind, Distances, Problem, Scales, WAIT_LIMIT};
use mission::numbers::Range;

use super::{layers, number, wrapped};
use crate::program::{MissionProgram, MissionScenarioProgram};

/// The text of a mission, for people to review and for snapshots to hold.
pub fn mission(mission: &MissionProgram) -> String {
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = match &mission.kind {
        Mission::Schedule(of) => schedule(mission, of, &mut out),
        Mission::Layers(of) => layers::layers(&mission.name, of, &mut out),
    };
    let _ = mission.scenarios.iter().try_for_each(|s| scenario(s, mission, &mut out));
    out
}

fn schedule(mission: &MissionProgram, of: &Schedule, out: &mut String) -> std::fmt::Result {
    let p = &of.problem;
    writeln!(out, "mission {} : schedule", mission.name)?;
    writeln!(
        out,
        "  {} operations, each planned to end in time with probability {}",
        p.operations(),
        number(p.confidence)
    )?;
    robots(p, out)?;
    agents(p, out)?;
    ways(p, out)?;
    let w = p.weights;
    let people = p.agents.iter().any(|a| a.kind == AgentKind::Human);
    writeln!(out, "\n  cost")?;
    if people {
        writeln!(out, "    waits of people, by their own weights")?;
    }
    for (weight, what) in
        [(w.worker_wait, "waits of workers"), (w.energy, "energy"), (w.makespan, "makespan")].into_iter()
    {
        writeln!(out, "    {what} x {}", number(weight))?;
    }
    let s = Scales::of(p);
    let energy: Vec<String> = s.energy.iter().map(|x| number(*x)).collect();
    writeln!(
        out,
        "    in units of: wait {} s, makespan {} s, energy of going, approach and way back {} J",
        number(s.wait),
        number(s.makespan),
        energy.join(", ")
    )?;
    let options = Options { batch: of.batch, ..Options::default() };
    if let Ok(choice) = choose(p, &options) {
        let name = choice.formulation.name();
        writeln!(out, "\n  planned by {name}: {}", choice.why)?;
    }
    let a = of.adaptation;
    writeln!(
        out,
        "  planned anew above a change of cost of {}; feedback: memory {}, gain of waits {}, of approaches {}, margin {}, step of waits {} s",
        number(of.reallocate_above),
        number(a.memory),
        number(a.wait_gain),
        number(a.approach_gain),
        number(a.margin),
        number(a.wait_step)
    )?;
    running(mission).iter().try_for_each(|line| writeln!(out, "  {line}"))
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

fn point([x, y]: [f64; 2]) -> String {
    format!("{}, {}", number(x), number(y))
}

pub(super) fn range(r: Range) -> String {
    if r.low == r.high { number(r.low) } else { format!("{} to {}", number(r.low), number(r.high)) }
}

fn robots(p: &Problem, out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "\n  {:<16} {:>16} {:>14} {:>9} {:>9} {:>7}  power, W",
        "robot", "depot, m", "speed, m/s", "serve, s", "then, s", "factor"
    )?;
    for m in &p.robots {
        let e = m.energy;
        let power = format!("{} + {} v + {} v^2", number(e.standby), number(e.friction), number(e.drag));
        writeln!(
            out,
            "  {:<16} {:>16} {:>14} {:>9} {:>9} {:>7}  {power}",
            m.name,
            point(m.depot),
            range(m.speed),
            number(m.serve),
            number(m.deposit),
            number(m.factor)
        )?;
    }
    Ok(())
}

fn agents(p: &Problem, out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "\n  {:<16} {:<7} {:>16} {:>10} {:>20} {:>9} {:>8}",
        "agent", "", "place, m", "operations", "duration, s", "planned", "severity"
    )?;
    for (i, a) in p.agents.iter().enumerate() {
        let (kind, severity) = match a.kind {
            AgentKind::Human => ("human", number(a.severity)),
            AgentKind::Worker => ("worker", "-".to_string()),
        };
        let d = a.duration;
        let duration =
            if d.sigma == 0.0 { number(d.mean) } else { format!("normal {}, {}", number(d.mean), number(d.sigma)) };
        writeln!(
            out,
            "  {:<16} {kind:<7} {:>16} {:>10} {duration:>20} {:>9} {severity:>8}",
            a.name,
            point(a.place),
            a.operations,
            number(nominal(p, i))
        )?;
        if a.kind == AgentKind::Human && a.wait_limit != WAIT_LIMIT {
            writeln!(out, "    waits by what is said: up to {} s", number(a.wait_limit))?;
        }
        for (what, weights) in [("waits", &a.wait_weights), ("approaches", &a.approach_weights)] {
            if !weights.is_empty() {
                let all: Vec<String> = weights.iter().map(|w| number(*w)).collect();
                wrapped(&format!("weights of {what}"), &all.iter().map(String::as_str).collect::<Vec<_>>(), out)?;
            }
        }
    }
    Ok(())
}

/// Each way from the depot to the place, and what of it is the approach.
fn ways(p: &Problem, out: &mut String) -> std::fmt::Result {
    let how = if p.distances == Distances::Straight { "straight" } else { "given" };
    writeln!(out, "\n  ways, {how}: length in m, of which near the agent, and speeds there in m/s")?;
    for (m, robot) in p.robots.iter().enumerate() {
        let all: Vec<String> = (p.agents.iter().enumerate())
            .map(|(a, agent)| {
                let (lengths, (speed, _)) = (p.lengths(a, m), p.approach(agent, m));
                let (whole, near) = (number(lengths.depositing), number(lengths.proximity));
                format!("{} {whole} ({near} at {})", agent.name, range(speed))
            })
            .collect();
        wrapped(&format!("{}:", robot.name), &all.iter().map(String::as_str).collect::<Vec<_>>(), out)?;
    }
    Ok(())
}
