//! The plan of an exploration: what each member does, as activities for charts, tables and files.

use super::foresight::Foresight;
use super::polygon::Point;
use super::problem::Problem;
use super::program::{Present, Trajectories};
use crate::plan;

/// The plan of an exploration.
pub type Plan = plan::Plan<Activity>;

/// Purpose of an activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// A robot moves to a target.
    Going,
    /// A robot keeps the team connected.
    Linking,
    /// The person walks, to a target or to the exit.
    Walking,
}

impl Phase {
    /// Name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Going => "going",
            Phase::Linking => "linking",
            Phase::Walking => "walking",
        }
    }
}

/// An activity.
#[derive(Clone, Debug, PartialEq)]
pub struct Activity {
    /// Index of the member: robots, and then the person.
    pub member: usize,
    /// Its purpose.
    pub phase: Phase,
    /// The target that is taken at its end.
    pub target: Option<usize>,
    /// Start (s).
    pub start: f64,
    /// End (s).
    pub end: f64,
    /// Positions at the start and at the end of each period (m).
    pub way: Vec<Point>,
    /// It has begun.
    pub begun: bool,
}

impl plan::Activity for Activity {
    fn start(&self) -> f64 {
        self.start
    }

    fn end(&self) -> f64 {
        self.end
    }
}

/// The activities of a plan that begins at a time (s).
pub fn activities(
    problem: &Problem,
    present: &Present,
    of: &Trajectories,
    foresight: &Foresight,
    begin: f64,
) -> Vec<Activity> {
    let mut all = Vec::new();
    for (robot, states) in of.states.iter().enumerate().filter(|(robot, _)| present.active[*robot]) {
        let points: Vec<Point> = states.iter().map(|state| state.at).collect();
        let mut visits: Vec<(usize, usize)> =
            of.visits.iter().filter(|visit| visit.robot == robot).map(|visit| (visit.step, visit.target)).collect();
        visits.sort_unstable();
        parts(problem, robot, &points, &visits, [Phase::Going, Phase::Linking], begin, &mut all);
    }
    let mut visits: Vec<(usize, usize)> = foresight.visits.iter().map(|(target, step)| (*step, *target)).collect();
    visits.sort_unstable();
    let person = problem.robots.len();
    parts(problem, person, &foresight.positions, &visits, [Phase::Walking; 2], begin, &mut all);
    all
}

/// Cuts the way of a member at its visits; `phases` are those before a visit and after the last one.
fn parts(
    problem: &Problem,
    member: usize,
    points: &[Point],
    visits: &[(usize, usize)],
    phases: [Phase; 2],
    begin: f64,
    all: &mut Vec<Activity>,
) {
    let time = |step: usize| begin + step as f64 * problem.period;
    let mut from = 0;
    let last = points.len().saturating_sub(1);
    let ends = visits.iter().map(|(step, target)| (*step, Some(*target))).chain([(last, None)]);
    for (to, target) in ends {
        let to = to.min(last);
        if to < from || (to == from && target.is_none()) {
            continue;
        }
        let phase = if target.is_some() { phases[0] } else { phases[1] };
        let way = points[from..=to].to_vec();
        all.push(Activity {
            member,
            phase,
            target,
            start: time(from),
            end: time(to),
            way,
            begun: from == 0 && begin > 0.0,
        });
        from = to;
    }
}
