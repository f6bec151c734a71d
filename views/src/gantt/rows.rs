//! Rows of a chart: the activities of each actor, and for an agent also its waits and services.

use std::collections::BTreeMap;

use mission::plan::{Activity, Actor, Phase, Plan, Target};

/// Kind of a bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// An activity of a schedule.
    Phase(Phase),
    /// A task of the layer of this index.
    Task(usize),
    /// The agent has finished its operation and waits for the service.
    Waits,
    /// The agent is served: the same interval as in the robot's row.
    Served,
}

impl Kind {
    /// Returns the name in the legend, which is also the class in a picture.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Phase(phase) => phase.name(),
            Kind::Task(_) => Phase::Task.name(),
            Kind::Waits => "wait",
            Kind::Served => "served",
        }
    }
}

/// An interval in the row of an actor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bar {
    pub kind: Kind,
    pub target: Target,
    /// Start and end (s), finite and in order.
    pub start: f64,
    pub end: f64,
    pub speed: Option<f64>,
    pub begun: bool,
}

/// An actor with its bars, sorted by time.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub actor: Actor,
    /// Label of the actor.
    pub name: String,
    pub bars: Vec<Bar>,
}

impl Row {
    /// Groups consecutive bars by target; each group is everything that a robot does for it.
    pub fn services(&self) -> impl Iterator<Item = &[Bar]> {
        self.bars.chunk_by(|a, b| a.target == b.target)
    }
}

/// Returns a row for each robot and then for each agent of the plan, also without activities. Activities with invalid
/// times are omitted.
pub(super) fn rows(plan: &Plan) -> Vec<Row> {
    let mut bars: BTreeMap<Actor, Vec<Bar>> = BTreeMap::new();
    let mut operations: BTreeMap<Target, f64> = BTreeMap::new();
    for activity in plan.activities.iter().filter(|activity| drawable(activity)) {
        bars.entry(activity.actor).or_default().push(bar(kind(activity), activity));
        if activity.phase == Phase::Operation {
            operations.insert(activity.target, activity.end);
        }
    }
    for serving in plan.activities.iter().filter(|a| a.phase == Phase::Serving && drawable(a)) {
        let agent = bars.entry(Actor::Agent(serving.target.agent)).or_default();
        agent.push(bar(Kind::Served, serving));
        let ended = operations.get(&serving.target).filter(|ended| **ended < serving.start);
        agent.extend(ended.map(|ended| Bar {
            kind: Kind::Waits,
            start: *ended,
            end: serving.start,
            ..agent[agent.len() - 1]
        }));
    }
    let robots = plan.robots.iter().enumerate().map(|(index, name)| (Actor::Robot(index), name));
    let agents = plan.agents.iter().enumerate().map(|(index, name)| (Actor::Agent(index), name));
    let row = |(actor, name): (Actor, &String)| {
        let mut bars = bars.remove(&actor).unwrap_or_default();
        bars.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.end.total_cmp(&b.end)).then(a.kind.cmp(&b.kind)));
        Row { actor, name: plan.labels.member(name).to_string(), bars }
    };
    robots.chain(agents).map(row).collect()
}

fn drawable(activity: &Activity) -> bool {
    activity.start.is_finite() && activity.end.is_finite() && activity.start <= activity.end
}

fn kind(activity: &Activity) -> Kind {
    match activity.phase {
        Phase::Task => Kind::Task(activity.target.agent),
        phase => Kind::Phase(phase),
    }
}

fn bar(kind: Kind, of: &Activity) -> Bar {
    Bar { kind, target: of.target, start: of.start, end: of.end, speed: of.speed, begun: of.begun }
}

/// Returns the first and the last instant of these rows (s); `None` if there are no bars.
pub(super) fn span(rows: &[Row]) -> Option<(f64, f64)> {
    let bars = || rows.iter().flat_map(|row| &row.bars);
    let first = bars().map(|bar| bar.start).reduce(f64::min)?;
    Some((first, bars().map(|bar| bar.end).fold(first, f64::max)))
}

/// Returns the label of a bar: `h1.2` for the second operation of h1; only the agent if it has one operation. The task
/// for a layered plan.
pub(super) fn label(plan: &Plan, bar: &Bar) -> String {
    if let Kind::Task(_) = bar.kind {
        let task = plan.layered.as_ref().and_then(|layered| layered.tasks.get(bar.target.operation));
        return task.map_or_else(String::new, |task| plan.labels.task(&task.name).to_string());
    }
    let name = plan.label(Actor::Agent(bar.target.agent));
    let several = plan.activities.iter().any(|a| a.target.agent == bar.target.agent && a.target.operation > 0);
    if several { format!("{name}.{}", bar.target.operation + 1) } else { name.to_string() }
}
