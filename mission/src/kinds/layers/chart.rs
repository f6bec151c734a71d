//! The Gantt chart of layers: the tasks of each agent, in the colours of their layers.

use crate::chart::{Bar, Chart, Entry, LabelPlace, Row, Style};

use super::plan::{Activity, Plan};
use super::problem::Problem;

static TASK: Style = Style { name: "task", height: 14.0, sign: '=', colour: "1", activity: true, kept: false };

/// The chart of a plan: a row for each robot and then for each person.
pub fn chart(problem: &Problem, plan: &Plan) -> Chart {
    let of = |human: bool| {
        let agents = problem.agents.iter().enumerate().filter(move |(_, who)| who.is_human() == human);
        agents.map(|(agent, who)| {
            let own = plan.activities.iter().filter(|activity| activity.agent == agent);
            let name = problem.labels.member(&who.name).to_string();
            Row::new(name, LabelPlace::Above, own.map(|activity| bar(problem, activity)).collect())
        })
    };
    let layer = |(group, name): (usize, &String)| Entry {
        style: &TASK,
        group: Some(group),
        text: problem.labels.layer(name).to_string(),
    };
    Chart {
        rows: of(false).chain(of(true)).collect(),
        legend: problem.layers.iter().enumerate().map(layer).collect(),
        groups: "tasks, of one layer and of the next",
    }
}

fn bar(problem: &Problem, of: &Activity) -> Bar {
    let Activity { task, start, end, speed, begun, .. } = *of;
    let what = problem.tasks.get(task);
    let title = what.map_or("", |task| problem.labels.task(&task.name)).to_string();
    let group = Some(what.map_or(0, |task| task.layer));
    Bar { style: &TASK, group, work: task, label: Some(title.clone()), title, start, end, speed, begun }
}
