//! An execution as everything outside of the kind sees it.

use serde::Serialize;

use super::super::chart::{chart, label};
use super::super::event::{describe, typed, words};
use super::super::foresight::Foresight;
use super::super::grid::Grid;
use super::super::map::{Way, doubts, map};
use super::super::plan::{Activity, Phase, activities};
use super::super::polygon::Point;
use super::super::problem::Problem;
use super::super::program::Present;
use super::person::Walker;
use super::{Counts, ExploreExecution, LogEntry, MEASURES, Settings};
use crate::chart::Chart;
use crate::execution::DiscreteEvents;
use crate::kind::course::{Course, GroundPose};
use crate::kind::{self, Cell, Entry, Event, Outcome, ReportPart, Table, Work, number};
use crate::labels::Labels;
use crate::map::Map;

/// Results, as they are written into files.
#[derive(Debug, Serialize)]
struct Results {
    arrived: Option<f64>,
    #[serde(flatten)]
    counts: Counts,
    targets: Vec<TargetResult>,
    members: Vec<MemberResult>,
}

#[derive(Debug, Serialize)]
struct TargetResult {
    name: String,
    by: Option<String>,
    at: Option<f64>,
}

#[derive(Debug, Serialize)]
struct MemberResult {
    name: String,
    taken: usize,
    travelled: f64,
}

impl ExploreExecution {
    /// The input of the planner at the start of the mission, and the prediction then.
    ///
    /// # Errors
    /// A model cannot be used.
    pub fn start(problem: &Problem, settings: &Settings) -> Result<(Present, Foresight), String> {
        let grid = Grid::new(problem).ok_or("the grid has no cells")?;
        let person = Walker::new(problem, &grid, settings)?;
        let present = Present {
            states: problem.robots.iter().map(super::super::problem::Robot::at_start).collect(),
            active: vec![true; problem.robots.len()],
            open: vec![true; problem.targets.len()],
        };
        let foresight = person.foresee(problem, &grid, &present.open, 0.0);
        Ok((present, foresight))
    }

    /// Position of a member: robots, and then the person (m).
    pub fn place(&self, member: usize) -> Option<Point> {
        let person = (member == self.robots.len()).then(|| self.person.at(self.time));
        self.state_at(member, self.time).map(|state| state.at).or(person)
    }

    /// Distance between the body of a robot and that of the person (m).
    pub fn clearance(&self, robot: usize) -> Option<f64> {
        let body = self.problem.robots.get(robot)?.body.moved(self.state_at(robot, self.time)?.at);
        Some(body.gap(&self.problem.person.body.moved(self.person.at(self.time))))
    }

    /// True if every robot is lost.
    pub fn nobody_is_left(&self) -> bool {
        self.robots.iter().all(|robot| !robot.active)
    }

    /// The words for a reason without a plan, while there is none.
    pub fn trouble(&self) -> Option<&str> {
        let last = self.records.iter().rev().find_map(|record| match &record.what {
            LogEntry::NoPlan { why, .. } => Some(why.as_str()),
            _ => None,
        });
        last.filter(|_| self.without_plan)
    }

    /// Activities of everybody, past and planned.
    pub fn activities(&self) -> Vec<Activity> {
        let mut all = Vec::new();
        let person = self.robots.len();
        for member in 0..=person {
            let mut from = 0.0;
            let mut ends: Vec<(f64, Option<usize>)> = Vec::new();
            for (target, taker) in self.takers.iter().enumerate() {
                ends.extend(taker.filter(|(by, _)| *by == member).map(|(_, at)| (at, Some(target))));
            }
            ends.sort_by(|a, b| a.0.total_cmp(&b.0));
            ends.push((self.done.unwrap_or(self.time), None));
            for (to, target) in ends.into_iter().filter(|(to, target)| *to > 0.0 || target.is_some()) {
                let phase = match (member == person, target) {
                    (true, _) => Phase::Walking,
                    (false, Some(_)) => Phase::Going,
                    (false, None) => Phase::Linking,
                };
                if to > from || target.is_some() {
                    all.push(Activity { member, phase, target, start: from, end: to, way: Vec::new(), begun: true });
                }
                from = to;
            }
        }
        if let (Some(plan), None) = (&self.plan, self.done)
            && !self.without_plan
        {
            let planned = activities(&self.problem, &plan.present, &plan.trajectories, &plan.foresight, plan.begin);
            let ahead = planned.into_iter().filter(|activity| activity.end > self.time);
            all.extend(ahead.map(|activity| Activity {
                start: activity.start.max(self.time),
                begun: false,
                ..activity
            }));
        }
        all
    }

    /// Ways so far, and those of the plan.
    fn ways(&self) -> Vec<Way> {
        let walked = self.walked.iter().enumerate();
        let mut ways: Vec<Way> =
            walked.map(|(member, points)| Way { member, points: points.clone(), expected: false }).collect();
        if let (Some(plan), None) = (&self.plan, self.done)
            && !self.without_plan
        {
            let done = plan.step.saturating_sub(1);
            let robots = plan.trajectories.states.iter().map(|states| states.iter().map(|state| state.at).collect());
            let all = robots.chain([plan.foresight.positions.clone()]).enumerate();
            ways.extend(all.map(|(member, points): (usize, Vec<Point>)| Way {
                member,
                points: points.into_iter().skip(done).collect(),
                expected: true,
            }));
        }
        ways
    }

    /// The words for an entry of the log.
    pub(in super::super) fn describe_entry(&self, what: &LogEntry) -> String {
        let p = &self.problem;
        match what {
            LogEntry::Taken { member, target } => format!("{} takes {}", label(p, *member), p.target_label(*target)),
            LogEntry::Redundant { member, target } => {
                format!("{} comes to {}, which is taken already", label(p, *member), p.target_label(*target))
            }
            LogEntry::Assigned { visits } => {
                let each: Vec<String> = visits
                    .iter()
                    .map(|(robot, target)| format!("{} to {}", p.robot_label(*robot), p.target_label(*target)))
                    .collect();
                format!("a new plan sends {}", each.join(", "))
            }
            LogEntry::NoPlan { why, kept: true, .. } => format!("{why}; the last plan goes on"),
            LogEntry::NoPlan { why, kept: false, .. } => match p.planner.fallback {
                super::super::problem::Fallback::Stop => format!("{why}; the robots stop"),
                super::super::problem::Fallback::Barrier => {
                    format!("{why}; the robots keep clear, and connected where they can")
                }
            },
            LogEntry::PlanAgain => "there is a plan again".into(),
            LogEntry::OffPlan { robot, by } => format!("{} is {by:.2} m off its plan", p.robot_label(*robot)),
            LogEntry::Touch { one, other } => format!("{} and {} touch", label(p, *one), label(p, *other)),
            LogEntry::Disconnected => "the team is not connected any more".into(),
            LogEntry::Connected => "the team is connected again".into(),
            LogEntry::Handled { text } => text.clone(),
            LogEntry::Done => format!("{} is at the exit", p.person_label()),
        }
    }
}

impl kind::Execution for ExploreExecution {
    fn time(&self) -> f64 {
        self.time
    }

    fn advance(&mut self, to: f64) {
        self.run_until(to);
    }

    fn next(&self) -> Option<f64> {
        // Bases are driven to the next step, whose effects they must not precede.
        self.upcoming(self.robots.iter().any(|robot| robot.base.is_some())).map(|(time, _)| time)
    }

    fn done(&self) -> Option<f64> {
        self.done
    }

    fn stranded(&self) -> Option<String> {
        self.nobody_is_left().then(|| "every robot is lost".into())
    }

    fn chart(&self) -> Chart {
        chart(&self.problem, &self.activities())
    }

    fn labels(&self) -> &Labels {
        &self.problem.labels
    }

    fn map(&self) -> Map {
        let taken: Vec<Option<usize>> = self.takers.iter().map(|taker| taker.map(|(member, _)| member)).collect();
        let places: Vec<Point> = (0..=self.robots.len()).filter_map(|member| self.place(member)).collect();
        let plan = self.plan.as_ref().filter(|_| self.done.is_none() && !self.without_plan);
        let doubts = plan.map_or_else(Vec::new, |plan| doubts(&plan.foresight, plan.step.saturating_sub(1)));
        map(&self.problem, &self.ways(), doubts, &taken, self.done.map(|_| &places[..]))
    }

    fn describe(&self, event: &Event) -> String {
        describe(&self.problem, event)
    }

    fn handle(&mut self, event: &Event) -> Result<(), String> {
        let event = typed(&self.problem, event)?;
        let text = words(&self.problem, &event);
        self.happen(&event, text)
    }

    fn log_len(&self) -> usize {
        self.records.len()
    }

    fn log_from(&self, first: usize) -> Vec<Entry> {
        let entries = self.records.iter().skip(first).map(|record| Entry {
            time: record.time,
            text: self.describe_entry(&record.what),
            notable: !matches!(record.what, LogEntry::PlanAgain | LogEntry::NoPlan { kept: true, .. }),
        });
        entries.collect()
    }

    fn measure(&self, name: &str, member: Option<usize>) -> [f64; 3] {
        let robots = self.robots.len();
        let (role, index) = match member {
            None => (None, 0),
            Some(member) if member < robots => (Some("robot"), member),
            Some(member) if member == robots => (Some("human"), member),
            Some(member) => (Some("target"), member - robots - 1),
        };
        let found = MEASURES.iter().find(|(measure, _)| measure.name == name && measure.is_of(role));
        found.and_then(|(_, value)| value(self, index)).unwrap_or(number(f64::NAN))
    }

    fn outcome(&self) -> Outcome {
        let p = &self.problem;
        let name = |member: usize| p.robots.get(member).map_or(&p.person.name, |robot| &robot.name).clone();
        let targets = p.targets.iter().zip(&self.takers).map(|(target, taker)| TargetResult {
            name: target.name.clone(),
            by: taker.map(|(member, _)| name(member)),
            at: taker.map(|(_, at)| at),
        });
        let all = self.robots.iter().map(|robot| (robot.taken, robot.travelled));
        let all: Vec<(usize, f64)> = all.chain([(self.person.taken, self.person.travelled)]).collect();
        let members = all.iter().enumerate().map(|(member, (taken, travelled))| MemberResult {
            name: name(member),
            taken: *taken,
            travelled: *travelled,
        });
        let results =
            Results { arrived: self.done, counts: self.counts, targets: targets.collect(), members: members.collect() };
        let rows = all.iter().enumerate().map(|(member, (taken, travelled))| {
            vec![Cell::Text(label(p, member).into()), Cell::Count(*taken), Cell::Number(*travelled, "m")]
        });
        let counts = &self.counts;
        let whole = vec![
            Cell::Count(self.takers.iter().flatten().count()),
            Cell::Count(counts.redundant),
            Cell::Count(counts.collisions),
            Cell::Count(counts.disconnections),
            Cell::Count(counts.without_plan),
        ];
        Outcome {
            reschedules: counts.kept,
            reallocations: counts.plans,
            data: serde_json::to_value(&results).unwrap_or_default(),
            tables: vec![
                Table { columns: vec!["who", "targets", "way"], rows: rows.collect() },
                Table {
                    columns: vec![
                        "targets",
                        "redundant visits",
                        "collisions",
                        "disconnections",
                        "periods without a plan",
                    ],
                    rows: vec![whole],
                },
            ],
        }
    }

    fn report_parts(&self) -> Vec<ReportPart> {
        self.parts_of_report()
    }

    fn columns(&self) -> Vec<String> {
        let p = &self.problem;
        let names = p.robots.iter().map(|robot| &robot.name).chain([&p.person.name]);
        let places = names.flat_map(|name| ["x", "y"].map(|axis| format!("{name}.{axis}")));
        places.chain(["targets".into(), "connected".into(), "planned".into()]).collect()
    }

    fn row(&self) -> Vec<Cell> {
        let places = (0..=self.robots.len()).filter_map(|member| self.place(member)).flatten();
        let counts =
            [self.takers.iter().flatten().count(), usize::from(self.is_connected()), usize::from(!self.without_plan)];
        places.map(|x| Cell::Number(x, "m")).chain(counts.map(Cell::Count)).collect()
    }

    fn work(&self, member: usize) -> Option<Work> {
        self.base_work(member)
    }

    fn course(&self, member: usize) -> Option<Course<'_>> {
        self.course_of(member)
    }

    fn drive(&mut self, member: usize, time: f64, pose: GroundPose) {
        self.drive_base(member, time, pose);
    }

    fn pose(&self, member: usize, time: f64) -> Option<GroundPose> {
        let person = (member == self.robots.len()).then(|| self.person.at(time));
        let at = self.state_at(member, time).map(|state| state.at).or(person)?;
        Some(GroundPose { at, heading: 0.0 })
    }
}
