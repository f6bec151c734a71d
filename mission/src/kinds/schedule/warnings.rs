//! Warnings about a schedule that can be planned and is hardly meant.

use blocks::{Help, Origin, Snippet};
use quantities::number;

use super::check::{Item, Key};
use super::magnitudes;
use super::problem::{AgentKind, Problem};
use super::refusals::approach;
use crate::declare::{DeclaredMission, Origins, Remark, Remarks};
use crate::numbers::Range;

/// A range of speeds, and its place if it is written.
struct Speed {
    range: Range,
    at: Option<Origin>,
}

/// Warns of robots and agents without anything to do, of a cost that is always zero, of speeds that are not as
/// written, and of robots that wait behind their depots.
pub(super) fn add(m: &DeclaredMission, problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    for (i, who) in problem.agents.iter().enumerate().filter(|(_, who)| who.operations == 0) {
        let at = places.written(Item::Agent(i), &[Key::Operations.name()]).unwrap_or(m.at);
        let d = Remark::warning("HQ0907", at, format!("no robot ever serves `{}`", who.name));
        remarks.push(d.help("give it operations, or remove it"));
    }
    let (robots, services) = (problem.robots.len(), problem.operations());
    if robots > services {
        let count = if services == 1 { "one service".to_string() } else { format!("{services} services") };
        let text = format!("{robots} robots for {count}: some never leave their depot");
        let at = places.of(Item::Robot(services), &[]);
        remarks.push(Remark::warning("HQ0907", at, text).help("remove robots, or add operations"));
    }
    if is_free(problem) {
        let at = places.written(Item::Mission, &[Key::Weights.name()]).unwrap_or(m.at);
        let d = Remark::warning("HQ0908", at, "all weights are zero, so all plans have equal cost");
        remarks.push(d.help(Help::with("write a weight above zero, such as {}", [Snippet::entry("makespan", "1")])));
    }
    clamped(problem, places, remarks);
    behind(problem, places, remarks);
    magnitudes::add(problem, places, remarks);
}

/// Warns of robots that wait farther from an agent than their depot is.
fn behind(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    for (k, who) in problem.agents.iter().enumerate().filter(|(_, who)| who.operations > 0) {
        for (i, robot) in problem.robots.iter().enumerate() {
            let (far, near) = (problem.lengths(k, i).depositing, problem.approach(who, i).1);
            if near <= far {
                continue;
            }
            let (depot, agent) = (number(far), &who.name);
            let text =
                format!("`{}` waits {} m from `{agent}`, and its depot is {depot} m away", robot.name, number(near));
            let at = approach(places, k, i).or_else(|| places.written(Item::Agent(k), &[Key::WaitDistance.name()]));
            let at = at
                .or_else(|| places.written(Item::Agent(k), &[Key::Place.name()]))
                .unwrap_or(places.of(Item::Agent(k), &[]));
            let d = Remark::warning("HQ0914", at, text)
                .note("the robot first moves away from the agent")
                .help(format!("wait at most {depot} m away, or move the depot"));
            remarks.push(d);
            break;
        }
    }
}

/// Warns of speeds near an agent that are cut to those of the robot.
fn clamped(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    for (i, robot) in problem.robots.iter().enumerate() {
        let written = |key: Key| places.written(Item::Robot(i), &[key.name()]);
        let cruise = Speed { range: robot.speed, at: written(Key::Speed) };
        if let Some(range) = robot.proximity {
            cut(&Speed { range, at: written(Key::Proximity) }, &cruise, remarks);
        }
        for (k, who) in problem.agents.iter().enumerate() {
            if let Some(range) = who.approaches.iter().find(|a| a.robot == i).and_then(|a| a.speed) {
                cut(&Speed { range, at: approach(places, k, i) }, &cruise, remarks);
            }
        }
    }
}

fn cut(near: &Speed, cruise: &Speed, remarks: &mut Remarks) {
    let Some(at) = near.at.filter(|_| near.range.low < cruise.range.low || near.range.high > cruise.range.high) else {
        return;
    };
    let low = number(near.range.low.max(cruise.range.low));
    let high = number(near.range.high.min(cruise.range.high));
    let remark =
        Remark::warning("HQ0909", at, format!("the robot approaches at {low} to {high} m/s, a part of this range"))
            .note("near an agent a robot must also keep to its own speeds")
            .help(Help::with(
                "write {}, or widen the speeds of the robot",
                [Snippet::value(format!("[{low}, {high}] m/s"))],
            ));
    remarks.push(match cruise.at {
        Some(at) => remark.label(at, "speeds of the robot"),
        None => remark,
    });
}

/// True where the cost of every plan is zero.
fn is_free(problem: &Problem) -> bool {
    let weights = problem.weights;
    let has = |kind: AgentKind| problem.agents.iter().any(|a| a.kind == kind && a.operations > 0);
    let waits = (0..problem.agents.len())
        .filter(|a| problem.agents[*a].kind == AgentKind::Human)
        .any(|a| (0..problem.agents[a].operations).any(|i| problem.wait_weight(a, i) > 0.0));
    weights.energy == 0.0
        && weights.makespan == 0.0
        && !waits
        && (weights.worker_wait == 0.0 || !has(AgentKind::Worker))
}
