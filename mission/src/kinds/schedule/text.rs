//! A schedule as text, for people to review: the team, the ways, the weights of the cost, and the planning method.

use std::fmt::Write;

use names::wrapped;
use quantities::number;

use super::choose::{Options, choose};
use super::duration_quantile::nominal;
use super::mission::Schedule;
use super::problem::{AgentKind, Distances, Problem, Scales, WAIT_LIMIT};

/// The text of a mission with this name.
pub(super) fn text(name: &str, of: &Schedule) -> String {
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(name, of, &mut out);
    out
}

fn write(name: &str, of: &Schedule, out: &mut String) -> std::fmt::Result {
    let p = &of.problem;
    writeln!(out, "mission {name} : schedule")?;
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
    )
}

fn point([x, y]: [f64; 2]) -> String {
    format!("{}, {}", number(x), number(y))
}

fn robots(p: &Problem, out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "\n  {:<16} {:>16} {:>14} {:>9} {:>9} {:>7}  power, W",
        "robot", "depot, m", "speed, m/s", "serve, s", "then, s", "factor"
    )?;
    for m in &p.robots {
        writeln!(
            out,
            "  {:<16} {:>16} {:>14} {:>9} {:>9} {:>7}  {}",
            m.name,
            point(m.depot),
            m.speed,
            number(m.serve),
            number(m.deposit),
            number(m.factor),
            m.energy
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
                format!("{} {whole} ({near} at {speed})", agent.name)
            })
            .collect();
        wrapped(&format!("{}:", robot.name), &all.iter().map(String::as_str).collect::<Vec<_>>(), out)?;
    }
    Ok(())
}
