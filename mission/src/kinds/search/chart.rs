//! The Gantt chart of a search: the ways, stays and waits of each agent.

use crate::chart::{Bar, Chart, Entry, LabelPlace, Row, Style};

use super::execution::{LogEntry, Role, SearchExecution};
use super::plan::{Activity, Phase};
use super::problem::Problem;

static GOING: Style = Style { name: "going", height: 8.0, sign: '-', colour: "34", activity: true, kept: false };
static STAYING: Style = Style { name: "serving", height: 16.0, sign: '#', colour: "35", activity: true, kept: true };
static WAITING: Style = Style { name: "waiting", height: 4.0, sign: '.', colour: "2", activity: true, kept: false };

static ROLE: Style = Style { name: "role", height: 10.0, sign: '=', colour: "36", activity: false, kept: true };

/// The chart of an execution: that of its activities, and a row with the roles of people and robots if somebody has told a goal.
pub fn chart_of_execution(of: &SearchExecution) -> Chart {
    let mut chart = chart(&of.problem, &of.activities());
    let told: Vec<(f64, Role)> = of.records().iter().filter_map(|record| role_of(&record.what, record.time)).collect();
    let Some(first) = chart.start().filter(|_| !told.is_empty()) else { return chart };
    let changes: Vec<(f64, Role)> = std::iter::once((first, Role::LeaderFollower)).chain(told).collect();
    let ends = changes.iter().skip(1).map(|(time, _)| *time).chain([of.log.done.unwrap_or(of.time).max(first)]);
    let bars = changes.iter().zip(ends).enumerate().filter(|(_, ((start, _), end))| start < end);
    let bar = |(work, ((start, role), end)): (usize, (&(f64, Role), f64))| Bar {
        style: &ROLE,
        group: Some(*role as usize),
        work,
        title: role.name().to_string(),
        label: Some(role.name().to_string()),
        start: *start,
        end,
        speed: None,
        begun: true,
    };
    chart.rows.push(Row::new("roles".into(), LabelPlace::Within, bars.map(bar).collect()));
    let entry = |role: Role| Entry { style: &ROLE, group: Some(role as usize), text: role.name().into() };
    chart.legend.extend(Role::ALL.map(entry));
    chart.groups = "one role of people and robots, and the next";
    chart
}

fn role_of(what: &LogEntry, time: f64) -> Option<(f64, Role)> {
    match what {
        LogEntry::Role { role } => Some((time, *role)),
        _ => None,
    }
}

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
