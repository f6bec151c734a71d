//! The plan of a schedule as data.

use mission::kinds::schedule::problem::{AgentKind, Problem};
use mission::plan::{Activity, Actor};

use super::{ActivityData, AgentData, CostData, Named, OperationData, Part, PlanData, ServiceData, VERSION};
use crate::planned::{Planned, Service};

impl PlanData {
    /// The plan of this mission of this spec.
    pub fn of_schedule(spec: &str, mission: &str, problem: &Problem, p: &Planned) -> PlanData {
        PlanData {
            version: VERSION,
            ok: true,
            spec: spec.to_string(),
            mission: mission.to_string(),
            kind: "schedule",
            formulation: p.choice.formulation.name().to_string(),
            why: p.choice.why.to_string(),
            engine: p.plan.engine.clone(),
            valid: true,
            status: p.plan.status.clone(),
            statistics: p.plan.statistics,
            cost: cost(p),
            agents: agents(problem),
            objects: Vec::new(),
            layers: Vec::new(),
            tasks: Vec::new(),
            activities: p.plan.activities.iter().map(|activity| of(p, activity)).collect(),
            services: p.services.iter().map(service).collect(),
        }
    }
}

fn cost(p: &Planned) -> CostData {
    let c = &p.cost;
    let parts = [
        ("human_wait", c.human_wait),
        ("worker_wait", c.worker_wait),
        ("energy_going", c.going),
        ("energy_proximity", c.proximity),
        ("energy_depositing", c.depositing),
        ("makespan", c.makespan),
    ];
    let part = |(name, cost)| Part { name, cost, value: None, weight: None };
    CostData { total: c.total(), parts: parts.map(part).to_vec() }
}

fn agents(problem: &Problem) -> Vec<AgentData> {
    let named = |name: &str| Named::new(name, problem.labels.member(name));
    let on_ground = |[x, y]: [f64; 2]| [x, y, 0.0];
    let robots = problem.robots.iter().map(|robot| AgentData {
        named: named(&robot.name),
        kind: "robot",
        place: on_ground(robot.depot),
        operations: None,
    });
    let served = problem.agents.iter().map(|who| AgentData {
        named: named(&who.name),
        kind: match who.kind {
            AgentKind::Human => "human",
            AgentKind::Worker => "worker",
        },
        place: on_ground(who.place),
        operations: Some(who.operations),
    });
    robots.chain(served).collect()
}

fn of(p: &Planned, activity: &Activity) -> ActivityData {
    let served = p.plan.name(Actor::Agent(activity.target.agent)).to_string();
    ActivityData {
        agent: p.plan.name(activity.actor).to_string(),
        phase: activity.phase.name(),
        operation: Some(OperationData { of: served, number: activity.target.operation + 1 }),
        task: None,
        layer: None,
        object: None,
        start: activity.start,
        end: activity.end,
        speed: activity.speed,
        place: activity.place,
        begun: activity.begun,
    }
}

fn service(s: &Service) -> ServiceData {
    ServiceData {
        agent: s.robot.clone(),
        operation: OperationData { of: s.agent.clone(), number: s.operation },
        leaves: s.leaves,
        waits: s.waits,
        approaches: s.approaches,
        serves: s.serves,
        returns: s.returns,
        ends: s.ends,
        going_speed: s.going_speed,
        approach_speed: s.approach_speed,
        return_speed: s.return_speed,
        operation_ends: s.operation_ends,
        wait: s.agent_waits,
    }
}
