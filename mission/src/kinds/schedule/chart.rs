//! The Gantt chart of a schedule, as thesis Figs. 5.7 and 5.8: services in the rows of robots, operations, waits and
//! services in the rows of agents.

use std::collections::BTreeMap;

use crate::chart::{Bar, Chart, Entry, LabelPlace, Row, Style};

use super::check::MAX_OPERATIONS;
use super::plan::{Activity, Actor, Phase, Plan, Target};
use super::problem::Problem;

const fn phase(name: &'static str, height: f64, sign: char, colour: &'static str) -> Style {
    Style { name, height, sign, colour, activity: true, kept: false }
}

static OPERATION: Style = phase("operation", 18.0, '=', "1");
static GOING: Style = phase("going", 14.0, '>', "34");
static WAITING: Style = phase("waiting", 4.0, '.', "33");
static PROXIMITY: Style = phase("proximity", 10.0, '~', "36");
static SERVING: Style = Style { kept: true, ..phase("serving", 18.0, '#', "32;1") };
static DEPOSITING: Style = phase("depositing", 7.0, '<', "35");
/// The agent has finished its operation and waits for the service.
static WAIT: Style = Style { activity: false, ..phase("wait", 4.0, '.', "33") };
/// The agent is served: the same interval as in the robot's row.
static SERVED: Style = Style { activity: false, kept: true, ..phase("served", 18.0, '#', "32;1") };

fn style(phase: Phase) -> &'static Style {
    match phase {
        Phase::Operation => &OPERATION,
        Phase::Going => &GOING,
        Phase::Waiting => &WAITING,
        Phase::Proximity => &PROXIMITY,
        Phase::Serving => &SERVING,
        Phase::Depositing => &DEPOSITING,
    }
}

/// The chart of a plan: a row for each robot and then for each agent.
pub fn chart(problem: &Problem, plan: &Plan) -> Chart {
    let operations: BTreeMap<Target, f64> = (plan.activities.iter())
        .filter(|activity| activity.phase == Phase::Operation)
        .map(|operation| (operation.target, operation.end))
        .collect();
    let robots = problem.robots.iter().enumerate().map(|(robot, who)| {
        let bars = plan.of(Actor::Robot(robot)).map(|activity| {
            let title = title(problem, plan, activity.target);
            bar(style(activity.phase), activity, Some(title.clone()), title)
        });
        row(problem, &who.name, LabelPlace::Above, bars.collect())
    });
    let agents = problem.agents.iter().enumerate().map(|(agent, who)| {
        let mut bars: Vec<Bar> = (plan.of(Actor::Agent(agent)))
            .map(|activity| {
                let number = (activity.target.operation + 1).to_string();
                bar(style(activity.phase), activity, Some(number), title(problem, plan, activity.target))
            })
            .collect();
        let serving = |activity: &&Activity| activity.phase == Phase::Serving && activity.target.agent == agent;
        for serving in plan.activities.iter().filter(serving) {
            let served = bar(&SERVED, serving, None, title(problem, plan, serving.target));
            if let Some(ended) = operations.get(&serving.target).filter(|ended| **ended < serving.start) {
                bars.push(Bar { style: &WAIT, start: *ended, end: serving.start, ..served.clone() });
            }
            bars.push(served);
        }
        row(problem, &who.name, LabelPlace::Within, bars)
    });
    Chart {
        rows: robots.chain(agents).collect(),
        legend: Phase::ALL.map(|phase| Entry { style: style(phase), group: None, text: phase.name().into() }).to_vec(),
        groups: "",
    }
}

fn row(problem: &Problem, name: &str, labels: LabelPlace, bars: Vec<Bar>) -> Row {
    Row::new(problem.labels.member(name).to_string(), labels, bars)
}

fn bar(style: &'static Style, of: &Activity, label: Option<String>, title: String) -> Bar {
    let Activity { target, start, end, speed, begun, .. } = *of;
    let work = target.agent * MAX_OPERATIONS + target.operation;
    Bar { style, group: None, work, title, label, start, end, speed, begun }
}

/// `h1.2` for the second operation of `h1`; the agent alone if it has one operation.
fn title(problem: &Problem, plan: &Plan, target: Target) -> String {
    let name = problem.agents.get(target.agent).map_or("", |agent| problem.labels.member(&agent.name));
    let several = plan.activities.iter().any(|a| a.target.agent == target.agent && a.target.operation > 0);
    if several { format!("{name}.{}", target.operation + 1) } else { name.to_string() }
}
