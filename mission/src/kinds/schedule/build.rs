//! A schedule from its declaration.

use blocks::{Block, ByName, OneOrEach};
use names::list;

use super::blocks::{ApproachBlock, HumanBlock, RobotBlock, ScheduleBlock, WorkerBlock};
use super::check::{Item, MAX_OPERATIONS};
use super::mission::{Schedule, members};
use super::problem::{AgentKind, Approach, Distances, Problem, Robot, WorkingAgent};
use super::{refusals, warnings};
use crate::declare::common::check_batch;
use crate::declare::{DeclaredMember, DeclaredMission, Origins, Remark, Remarks, labels, mistaken};

/// Number of missing ways that are named.
const MOST_NAMED: usize = 6;

/// Builds the mission.
pub(super) fn build(declared: &DeclaredMission, remarks: &mut Remarks) -> Schedule {
    let mut places = Origins::new(declared, Item::Mission);
    let settings = ScheduleBlock::read(&declared.settings);
    let (mut robots, mut agents) = (Vec::new(), Vec::new());
    for member in declared.of("robot") {
        places.add(Item::Robot(robots.len()), &member.settings);
        robots.push(robot(member));
    }
    for member in declared.of("human").chain(declared.of("worker")) {
        let (item, agent) =
            (Item::Agent(agents.len()), if member.role == "human" { human(member) } else { worker(member) });
        places.add(item, &member.settings);
        // Too many operations are rejected as a whole; their weights do not matter then.
        if agent.operations > MAX_OPERATIONS || member.settings.is_wrong("operations") {
            places.mark_wrong(item, "wait_weights");
            places.mark_wrong(item, "approach_weights");
        }
        agents.push(agent);
    }
    let distances = match &settings.distances {
        Some(written) => table(written, (&robots, &agents), &mut places, remarks),
        None => Distances::Straight,
    };
    check_batch(declared, Some(settings.batch), remarks);
    let problem = Problem {
        labels: labels(declared, [], remarks),
        distances,
        confidence: settings.confidence,
        weights: settings.weights,
        ..Problem::new(robots, agents)
    };
    mistaken(declared, members(&problem).iter().map(|member| member.name), &problem.labels, remarks);
    refusals::add(declared, &problem, &places, remarks);
    if !remarks.has_error() && !places.any_wrong() {
        warnings::add(declared, &problem, &places, remarks);
    }
    let ScheduleBlock { adaptation, reallocate_above, batch, .. } = settings;
    Schedule { problem, adaptation, reallocate_above, batch }
}

fn robot(member: &DeclaredMember) -> Robot {
    let block = RobotBlock::read(&member.settings);
    Robot {
        name: member.name.clone(),
        depot: block.depot,
        speed: block.speed,
        proximity: block.proximity_speed,
        serve: block.serve,
        deposit: block.deposit,
        factor: block.factor,
        energy: block.energy.of_factor(block.factor),
    }
}

fn human(member: &DeclaredMember) -> WorkingAgent {
    let block = HumanBlock::read(&member.settings);
    WorkingAgent {
        severity: block.severity,
        wait_distance: block.wait_distance,
        approaches: approaches(&block.approaches),
        wait_weights: weights(block.wait_weights, block.operations),
        wait_limit: block.wait_limit,
        approach_weights: weights(block.approach_weights, block.operations),
        ..WorkingAgent::new(&member.name, AgentKind::Human, block.place, block.operations, block.duration)
    }
}

fn worker(member: &DeclaredMember) -> WorkingAgent {
    let block = WorkerBlock::read(&member.settings);
    WorkingAgent {
        wait_distance: block.wait_distance,
        approaches: approaches(&block.approaches),
        approach_weights: weights(block.approach_weights, block.operations),
        ..WorkingAgent::new(&member.name, AgentKind::Worker, block.place, block.operations, block.duration)
    }
}

fn approaches(written: &[ByName<ApproachBlock>]) -> Vec<Approach> {
    let one = |e: &ByName<ApproachBlock>| Approach {
        robot: e.member,
        speed: e.value.value.speed.as_ref().map(|speed| speed.value),
        wait_distance: e.value.value.wait_distance,
    };
    written.iter().map(one).collect()
}

/// Weights of so many operations; empty if all are 1.
fn weights(written: OneOrEach, operations: usize) -> Vec<f64> {
    match written {
        OneOrEach::Each(all) => all,
        OneOrEach::One(1.0) => Vec::new(),
        // More operations are rejected as a whole.
        OneOrEach::One(weight) => vec![weight; operations.min(MAX_OPERATIONS)],
    }
}

/// The table of lengths. Reports the ways that it lacks.
fn table(
    written: &[ByName<Vec<ByName<f64>>>],
    (robots, agents): (&[Robot], &[WorkingAgent]),
    places: &mut Origins<Item>,
    remarks: &mut Remarks,
) -> Distances {
    let mut table = vec![vec![None; agents.len()]; robots.len()];
    for row in written {
        for way in &row.value.value {
            let slot = table.get_mut(row.member).and_then(|row| row.get_mut(way.member));
            slot.into_iter().for_each(|slot| *slot = Some(way.value.value));
        }
    }
    let mut missing = Vec::new();
    for (robot, row) in robots.iter().zip(&table) {
        let lacking = agents.iter().zip(row).filter(|(_, length)| length.is_none());
        missing.extend(lacking.map(|(agent, _)| format!("{} to {}", robot.name, agent.name)));
    }
    if !missing.is_empty() && !places.is_wrong(Item::Mission, &["distances"]) {
        let at = places.key(Item::Mission, "distances");
        places.mark_wrong(Item::Mission, "distances");
        let missing = list(missing.iter().map(String::as_str), MOST_NAMED);
        remarks.push(
            Remark::error("HQ0906", at, "this table lacks ways")
                .note(format!("nothing says how long these are: {missing}"))
                .help("write all of them, or leave `distances` out for straight lines"),
        );
    }
    let length = |length: Option<f64>| length.unwrap_or(1.0);
    Distances::Table(table.into_iter().map(|row| row.into_iter().map(length).collect()).collect())
}
