//! The Gantt chart of an exploration: the ways of the robots and of the person, cut at the targets that they take.

use crate::chart::{Bar, Chart, Entry, LabelPlace, Row, Style};

use super::plan::{Activity, Phase};
use super::problem::Problem;

static GOING: Style = Style { name: "going", height: 12.0, sign: '#', colour: "35", activity: true, kept: true };
static LINKING: Style = Style { name: "waiting", height: 4.0, sign: '.', colour: "2", activity: true, kept: false };
static WALKING: Style = Style { name: "serving", height: 8.0, sign: '-', colour: "34", activity: true, kept: false };

/// The chart of activities: a row for each robot and then for the person.
pub fn chart(problem: &Problem, activities: &[Activity]) -> Chart {
    let row = |member: usize| {
        let own = activities.iter().filter(|activity| activity.member == member);
        let bars = own.enumerate().map(|(work, activity)| bar(problem, work, activity)).collect();
        Row::new(label(problem, member).to_string(), LabelPlace::Above, bars)
    };
    let entry = |style: &'static Style, text: &str| Entry { style, group: None, text: text.into() };
    Chart {
        rows: (0..=problem.robots.len()).map(row).collect(),
        legend: vec![
            entry(&GOING, "going to a target"),
            entry(&LINKING, "keeping the team connected"),
            entry(&WALKING, "walking, as expected"),
        ],
        groups: "",
    }
}

/// Text that people read in place of the name of a member.
pub(super) fn label(problem: &Problem, member: usize) -> &str {
    if member < problem.robots.len() { problem.robot_label(member) } else { problem.person_label() }
}

fn bar(problem: &Problem, work: usize, of: &Activity) -> Bar {
    let target = of.target.map(|target| problem.target_label(target));
    let (style, title) = match (of.phase, target) {
        (Phase::Going, target) => (&GOING, format!("to {}", target.unwrap_or("a target"))),
        (Phase::Linking, _) => (&LINKING, "keeps the team connected".into()),
        (Phase::Walking, Some(target)) => (&WALKING, format!("walks to {target}")),
        (Phase::Walking, None) => (&WALKING, "walks to the exit".into()),
    };
    let label = target.map(str::to_string);
    Bar { style, group: None, work, title, label, start: of.start, end: of.end, speed: None, begun: of.begun }
}
