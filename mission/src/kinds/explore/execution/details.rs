//! Parts of the report of an exploration: the connections of the team over time, and the plans that were made.

use super::super::chart::label;
use super::super::polygon::minus;
use super::super::solve::{Best, Origin};
use super::ExploreExecution;
use crate::chart::{Bar, Chart, Entry, LabelPlace, Row, Style};
use crate::kind::{Cell, ReportPart, Table};

static CONNECTED: Style = Style { name: "connected", height: 8.0, sign: '=', colour: "34", activity: true, kept: true };
static APART: Style = Style { name: "apart", height: 12.0, sign: '!', colour: "31", activity: true, kept: true };

/// Times at which pairs of members were connected: robots, and then the person.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Links {
    /// By pair, intervals with a begin and an end (s). The last one is open while the pair is connected.
    pairs: Vec<Pair>,
}

#[derive(Clone, Debug, PartialEq)]
struct Pair {
    members: [usize; 2],
    times: Vec<[f64; 2]>,
    connected: bool,
}

impl Links {
    /// Nobody is connected yet.
    pub fn new(members: usize) -> Links {
        let pairs = (0..members).flat_map(|one| (one + 1..members).map(move |other| [one, other]));
        Links { pairs: pairs.map(|members| Pair { members, times: Vec::new(), connected: false }).collect() }
    }
}

/// A plan that was made.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlanNote {
    time: f64,
    targets: usize,
    cost: f64,
    gap: f64,
    origin: Origin,
    nodes: u64,
    /// Wall time of the planning (s).
    took: f64,
}

impl PlanNote {
    /// The note of a plan that was made at a time (s), in a wall time (s).
    pub fn new(time: f64, best: &Best, took: f64) -> PlanNote {
        let targets = best.trajectories.visits.len();
        PlanNote { time, targets, cost: best.cost, gap: best.gap(), origin: best.origin, nodes: best.nodes, took }
    }
}

impl ExploreExecution {
    /// Notes the pairs that are connected now.
    pub(super) fn look_at_links(&mut self) {
        let places: Vec<_> = (0..=self.robots.len()).map(|member| self.place(member)).collect();
        let active = |member: usize| self.robots.get(member).is_none_or(|robot| robot.active);
        for pair in &mut self.links.pairs {
            let [one, other] = pair.members;
            let near = places[one]
                .zip(places[other])
                .is_some_and(|(a, b)| self.problem.connection.contains(minus(a, b), 1e-6));
            let connected = near && active(one) && active(other);
            match pair.times.last_mut() {
                Some(last) if connected && pair.connected => last[1] = self.time,
                _ if connected => pair.times.push([self.time; 2]),
                Some(last) if pair.connected => last[1] = self.time,
                _ => {}
            }
            pair.connected = connected;
        }
    }

    /// The connections over time, and the plans.
    pub(super) fn parts_of_report(&self) -> Vec<ReportPart> {
        vec![
            ReportPart::Chart { title: "Connections", chart: self.connections() },
            ReportPart::Table { title: "Plans", table: self.plan_table() },
        ]
    }

    fn connections(&self) -> Chart {
        let bar = |style: &'static Style, title: &str, [start, end]: [f64; 2]| Bar {
            style,
            group: None,
            work: 0,
            title: title.into(),
            label: None,
            start,
            end,
            speed: None,
            begun: true,
        };
        let rows = self.links.pairs.iter().map(|pair| {
            let [one, other] = pair.members.map(|member| label(&self.problem, member));
            let bars = pair.times.iter().map(|times| bar(&CONNECTED, "connected", *times));
            Row::new(format!("{one}, {other}"), LabelPlace::Within, bars.collect())
        });
        let apart = self.lost_connections();
        let apart = apart.into_iter().map(|times| bar(&APART, "not connected", times)).collect();
        let team = Row::new("team".to_string(), LabelPlace::Within, apart);
        let entry = |style: &'static Style, text: &str| Entry { style, group: None, text: text.into() };
        Chart {
            rows: rows.chain([team]).collect(),
            legend: vec![entry(&CONNECTED, "connected"), entry(&APART, "the team is not connected")],
            groups: "",
        }
    }

    /// Intervals in which the team was not connected, from the log.
    fn lost_connections(&self) -> Vec<[f64; 2]> {
        let mut intervals: Vec<[f64; 2]> = Vec::new();
        let mut since = None;
        for record in &self.records {
            match record.what {
                super::LogEntry::Disconnected => since = Some(record.time),
                super::LogEntry::Connected => intervals.extend(since.take().map(|from| [from, record.time])),
                _ => {}
            }
        }
        let end = self.done.unwrap_or(self.time);
        intervals.extend(since.map(|from| [from, end]));
        intervals
    }

    fn plan_table(&self) -> Table {
        let rows = self.plans.iter().map(|plan| {
            vec![
                Cell::Number(plan.time, "s"),
                Cell::Count(plan.targets),
                Cell::Number(plan.cost, ""),
                Cell::Number(100.0 * plan.gap, "%"),
                Cell::Text(plan.origin.words().into()),
                Cell::Count(plan.nodes as usize),
                Cell::Number(1e3 * plan.took, "ms"),
            ]
        });
        Table {
            columns: vec!["at", "targets of robots", "cost", "gap", "from", "nodes", "wall time"],
            rows: rows.collect(),
        }
    }
}
