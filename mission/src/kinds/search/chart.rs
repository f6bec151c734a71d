//! The Gantt chart of a search: the ways, stays and waits of each agent.

use crate::chart::{Bar, Chart, Entry, LabelPlace, Row, Style};

use super::plan::{Activity, Phase};
use super::problem::Problem;

static GOING: Style = Style { name: "going", height: 8.0, sign: '-', colour: "34", activity: true, kept: false };
static STAYING: Style = Style { name: "serving", height: 16.0, sign: '#', colour: "35", activity: true, kept: true };
static WAITING: Style = Style { name: "waiting", height: 4.0, sign: '.', colour: "2", activity: true, kept: false };

/// The chart of activities: a row for each robot and then for each person.
pub fn chart(problem: &Problem, activities: &[Activity]) -> Chart {
    let row = |agent: usize| {
        let own = activities.iter().filter(|activity| activity.agent == agent);
        let bars = own.enumerate().map(|(work, activity)| bar(problem, work, activity)).collect();
        Row::new(problem.agent_label(agent).to_string(), LabelPlace::Above, bars)
    };
    let entry = |style: &'static Style, text: &str| Entry { style, group: None, text: text.into() };
    Chart {
        rows: (0..problem.agents.len()).map(row).collect(),
        legend: vec![entry(&GOING, "going"), entry(&STAYING, "staying at a source"), entry(&WAITING, "waiting")],
        groups: "",
    }
}

fn bar(problem: &Problem, work: usize, of: &Activity) -> Bar {
    let source = of.source.map(|source| problem.source_label(source));
    let (style, title) = match of.phase {
        Phase::Going => (&GOING, format!("to {}", source.unwrap_or("a place"))),
        Phase::Staying => (&STAYING, source.map_or("looks around".into(), |source| format!("at {source}"))),
        Phase::Waiting => {
            let whom = of.awaits.map_or("others", |of| problem.agent_label(of.agent));
            (&WAITING, format!("waits for {whom}"))
        }
    };
    let speed = (of.phase == Phase::Going).then(|| problem.agents.get(of.agent).map_or(0.0, |agent| agent.speed));
    let label = if of.phase == Phase::Staying { source.map(str::to_string) } else { None };
    Bar { style, group: None, work, title, label, start: of.start, end: of.end, speed, begun: of.begun }
}
