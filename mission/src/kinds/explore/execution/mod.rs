//! Executing an exploration: at each period the robots see where everybody is, predict the person, and plan anew.
//!
//! An [`ExploreExecution`] is a discrete-event simulation. Its steps are the actions of the person, the periods of the plan, and
//! ticks, twenty in each period, at which contacts and connections are looked at and the fallback acts. Between steps the
//! robots move as their dynamics say, exactly.
//!
//! The same problem, settings and events at the same times give the same records, unless a planner was ended by its wall time.

mod behind;
mod counts;
mod details;
mod driven;
mod fallback;
mod handle_event;
mod period;
mod person;
mod steps;
mod view;

use std::time::{Duration, Instant};

use super::foresight::Foresight;
use super::grid::Grid;
use super::lattice::WayOut;
use super::motion::State;
use super::polygon::Point;
use super::problem::Problem;
use super::program::{Group, Present, Trajectories};
use super::solve::{NoPlan, Solver};
use crate::execution::Replan;
use crate::kind::course::Driven;

pub(super) use self::behind::MEASURES;
pub use self::counts::Counts;
use self::details::{Links, PlanNote};
use self::driven::{DrivenBase, with_reserves};
use self::person::Walker;

/// Ticks in each period.
pub const TICKS: u64 = 20;

/// Settings of an execution.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Seed of the person's actions; none: the person acts as the model finds most likely.
    pub sampled: Option<u64>,
    /// [`Replan::None`] keeps the first plan: the open-loop baseline of the paper.
    pub replan: Replan,
    /// The person is played: poses come from outside.
    pub played: bool,
    /// The most nodes of a search; none: those of the problem.
    pub nodes: Option<u64>,
    /// Robots whose bases controllers drive.
    pub driven: Vec<Driven>,
}

/// A robot under way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mover {
    pub state: State,
    /// It takes part; a lost one stands where it is.
    pub active: bool,
    /// The input that it holds.
    pub input: Point,
    /// Number of targets that it has taken.
    pub taken: usize,
    /// Length of its way so far (m).
    pub travelled: f64,
    /// Its base, if a controller drives it.
    base: Option<DrivenBase>,
}

/// The plan that is executed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Committed {
    pub trajectories: Trajectories,
    pub foresight: Foresight,
    /// State of the team at its begin.
    pub present: Present,
    /// Time of its begin (s).
    pub begin: f64,
    /// Periods of it that have begun.
    pub step: usize,
}

/// An exploration under way.
#[derive(Debug)]
pub struct ExploreExecution {
    pub(super) problem: Problem,
    /// The problem of plans, which keep the tolerances of driven bases in reserve.
    kept: Problem,
    pub(super) settings: Settings,
    grid: Grid,
    solver: Solver,
    time: f64,
    /// Time up to which the robots have moved (s).
    moved_to: f64,
    /// Number of the next period, and of the next tick.
    period: u64,
    tick: u64,
    pub(super) robots: Vec<Mover>,
    pub(super) person: Walker,
    /// The member that has taken each target, robots and then the person, with the time (s).
    pub(super) takers: Vec<Option<(usize, f64)>>,
    plan: Option<Committed>,
    /// The robots move by the fallback: there is no plan for this period.
    without_plan: bool,
    /// The way out that the fallback follows, with its begin (s).
    way_out: Option<(f64, WayOut)>,
    pub(super) counts: Counts,
    touching: Vec<bool>,
    apart: bool,
    /// Times at which pairs of members were connected.
    links: Links,
    /// The plans that were made.
    plans: Vec<PlanNote>,
    pub(super) records: Vec<Record>,
    done: Option<f64>,
    /// Ways walked, at the ends of periods: robots, and then the person.
    pub(super) walked: Vec<Vec<Point>>,
}

/// An entry of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time (s).
    pub time: f64,
    /// Content.
    pub what: LogEntry,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub enum LogEntry {
    /// A member took a target.
    Taken {
        /// Robots, and then the person.
        member: usize,
        /// The target.
        target: usize,
    },
    /// A member came to take a target that somebody else had taken.
    Redundant {
        /// Robots, and then the person.
        member: usize,
        /// The target.
        target: usize,
    },
    /// Robots were sent to other targets than before: those of each robot.
    Assigned {
        /// Robot and target.
        visits: Vec<(usize, usize)>,
    },
    /// There is no plan for this period.
    NoPlan {
        /// Reason.
        why: String,
        /// The group of constraints that cannot be met, if it is known.
        group: Option<Group>,
        /// The last plan goes on.
        kept: bool,
    },
    /// There is a plan again.
    PlanAgain,
    /// The base of a robot is farther from its plan than its tolerance.
    OffPlan {
        /// The robot.
        robot: usize,
        /// Distance (m).
        by: f64,
    },
    /// Two members touch: robots, and then the person.
    Touch {
        /// One member.
        one: usize,
        /// The other one.
        other: usize,
    },
    /// The team is not connected any more.
    Disconnected,
    /// The team is connected again.
    Connected,
    /// An event.
    Handled {
        /// In words.
        text: String,
    },
    /// The person is at the exit.
    Done,
}

impl ExploreExecution {
    /// Plans, and stands at the start.
    ///
    /// # Errors
    /// The engine is not installed, a model cannot be used, or there is no plan.
    pub fn new(problem: Problem, settings: Settings) -> Result<ExploreExecution, String> {
        let grid = Grid::new(&problem).ok_or("the grid has no cells")?;
        let person = Walker::new(&problem, &grid, &settings)?;
        let mut solver = Solver::find(problem.planner.engine).map_err(|why| why.to_string())?;
        let mut problem = problem;
        problem.planner.nodes = settings.nodes.unwrap_or(problem.planner.nodes);
        let kept = with_reserves(&problem, &settings.driven)?;
        let base = |index: usize, at: Point| {
            let of = settings.driven.iter().find(|driven| driven.member == index)?;
            Some(DrivenBase::new(at, of.tolerance))
        };
        let mover = |(index, robot): (usize, &super::problem::Robot)| Mover {
            base: base(index, robot.start),
            state: robot.at_start(),
            active: true,
            input: [0.0; 2],
            taken: 0,
            travelled: 0.0,
        };
        let robots: Vec<Mover> = problem.robots.iter().enumerate().map(mover).collect();
        let walked = robots.iter().map(|robot| vec![robot.state.at]).chain([vec![person.at(0.0)]]).collect();
        let (count, targets) = (robots.len(), problem.targets.len());
        let present = Present {
            states: robots.iter().map(|robot| robot.state).collect(),
            active: vec![true; count],
            open: vec![true; targets],
        };
        let foresight = person.foresee(&problem, &grid, &present.open, 0.0);
        let time = first_time(&problem);
        let begun = Instant::now();
        let first = solver.plan(&kept, &present, &foresight, time).map_err(|why| why.to_string())?;
        let took = begun.elapsed().as_secs_f64();
        let plan = Committed { trajectories: first.trajectories.clone(), foresight, present, begin: 0.0, step: 0 };
        Ok(ExploreExecution {
            settings,
            grid,
            solver,
            time: 0.0,
            moved_to: 0.0,
            period: 0,
            tick: 0,
            robots,
            person,
            takers: vec![None; targets],
            plan: Some(plan),
            without_plan: false,
            way_out: None,
            counts: Counts::default(),
            touching: vec![false; (count + 1) * (count + 1)],
            apart: false,
            links: Links::new(count + 1),
            plans: vec![PlanNote::new(0.0, &first, took)],
            records: Vec::new(),
            done: None,
            walked,
            problem,
            kept,
        })
    }

    /// The problem.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Everything that has happened, in order.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// Number of periods that have begun.
    pub fn periods(&self) -> u64 {
        self.period
    }

    /// The input of the planner now.
    pub(super) fn present(&self) -> Present {
        Present {
            states: self.robots.iter().map(|robot| robot.state).collect(),
            active: self.robots.iter().map(|robot| robot.active).collect(),
            open: self.takers.iter().map(Option::is_none).collect(),
        }
    }

    fn record(&mut self, what: LogEntry) {
        self.records.push(Record { time: self.time, what });
    }
}

/// Wall time for the first plan.
pub(super) fn first_time(problem: &Problem) -> Duration {
    Duration::from_secs_f64(super::solve::FIRST * problem.planner.time)
}

/// The words for a reason without a plan, and its group.
fn reason(why: &NoPlan) -> (String, Option<Group>) {
    match why {
        NoPlan::Infeasible(group) => (why.to_string(), *group),
        _ => (why.to_string(), None),
    }
}
