//! The mixed-integer program of a plan: armchair (10a) to (10p) in the robust form (11) to (14).
//!
//! It differs from the paper where the paper is silent or can be passed between two samples:
//! - Constraints that hold at samples there hold at all times here. A motion stays in a triangle ([`motion`](super::motion)), and a
//!   constraint that is convex, or that one side of an obstacle fulfils, holds for the motion if it holds for the corners.
//! - In the first period the person may walk anywhere, which is a set that grows with time; of later periods (12) and (14) keep
//!   distance from the predicted position, enlarged by a stride.
//! - The horizon binary (10o), (10p) is known before the program is solved, since the prediction is: the horizon is cut at the arrival of the
//!   person. So are the visits of the person: targets that the person is expected to take are not offered to the robots.
//! - At the end of the horizon the robots stand.
//!
//! Big-M values come from the boxes that a robot can reach by then; sides of obstacles that it cannot reach have no binary.

mod builder;
mod polish;
mod reach;
mod rows;
mod team;

use std::collections::BTreeMap;

use super::foresight::Foresight;
use super::motion::State;
use super::polygon::{Convex, Point, parts_around};
use super::problem::Problem;
use crate::engine::Model;

use self::builder::Builder;
pub use self::reach::{Reach, reach};
use self::rows::Side;

/// Slack of a test on boxes (m), for rounding.
const ROUNDING: f64 = 1e-7;
/// Distance (m) that the program keeps beyond each constraint, for the tolerances of engines.
pub const TOLERANCE: f64 = 1e-4;

/// State of the team at the begin of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Present {
    /// States of the robots.
    pub states: Vec<State>,
    /// Robots that take part; the others stand where they are.
    pub active: Vec<bool>,
    /// Targets that nobody has taken yet.
    pub open: Vec<bool>,
}

/// A group of constraints, for words about what cannot be met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// (10f), (10g): the region and the limits of the robots.
    Limits,
    /// (10h) with obstacles.
    Obstacles,
    /// (10h) among robots.
    Robots,
    /// (12): the safety region around the person.
    Person,
    /// (10k) to (10n), (14).
    Connection,
}

impl Group {
    /// All groups, in the order in which they are tried as the cause.
    pub const ALL: [Group; 5] = [Group::Connection, Group::Person, Group::Robots, Group::Obstacles, Group::Limits];

    /// Words for what cannot be met.
    pub fn words(self) -> &'static str {
        match self {
            Group::Limits => "the limits on speed and acceleration within the region",
            Group::Obstacles => "the distance from obstacles",
            Group::Robots => "the distance between robots",
            Group::Person => "the safety region around the person",
            Group::Connection => "the connection of the team",
        }
    }
}

/// Columns of a robot at the ends of the periods, from the present on.
#[derive(Clone, Debug, Default)]
struct Columns {
    at: Vec<[usize; 2]>,
    velocity: Vec<[usize; 2]>,
    input: Vec<[usize; 2]>,
}

/// A binary that says which robot takes a target at the end of which period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// Robot.
    pub robot: usize,
    /// Target.
    pub target: usize,
    /// Number of the period at whose end.
    pub step: usize,
}

/// The meaning of a binary, by which the binaries of the next program find their values in the last plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Binary {
    /// A robot takes a target at the end of a period.
    Visit([usize; 3]),
    /// A robot is in a part of the free ground in a period.
    Part([usize; 3]),
    /// A robot passes the person on a side in a period.
    Person([usize; 3]),
    /// A robot passes another one on a side in a period.
    Robots([usize; 4]),
    /// Two members are connected in a period.
    Link([usize; 3]),
}

impl Binary {
    /// The first of the binaries of which exactly one is chosen.
    fn group(self) -> Binary {
        match self {
            Binary::Part([robot, step, _]) => Binary::Part([robot, step, 0]),
            Binary::Person([robot, step, _]) => Binary::Person([robot, step, 0]),
            Binary::Robots([i, j, step, _]) => Binary::Robots([i, j, step, 0]),
            own => own,
        }
    }
}

/// The program.
#[derive(Clone, Debug)]
pub struct Program {
    /// The model.
    pub model: Model,
    /// Meaning of each binary, with its column.
    pub binaries: Vec<(Binary, usize)>,
    /// For each of them, the rows that it stands for.
    rows: Vec<Vec<Side>>,
    columns: Vec<Columns>,
    periods: usize,
}

/// Motions of the robots by a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectories {
    /// States at the present and at the end of each period, by robot.
    pub states: Vec<Vec<State>>,
    /// Inputs in each period, by robot.
    pub inputs: Vec<Vec<Point>>,
    /// Targets that robots take.
    pub visits: Vec<Visit>,
}

/// A group of constraints that cannot be met, found while the program was built.
pub type Blocked = Group;

/// Builds the program; `without` leaves out a group of constraints.
///
/// # Errors
/// A group that no motion within the limits can meet.
pub fn build(
    problem: &Problem,
    present: &Present,
    foresight: &Foresight,
    without: Option<Group>,
) -> Result<Program, Blocked> {
    let periods = foresight.periods().min(problem.periods);
    let mut builder = Builder {
        problem,
        present,
        foresight,
        without,
        model: Model::default(),
        binaries: Vec::new(),
        rows: Vec::new(),
        columns: Vec::new(),
        places: Vec::new(),
        periods,
    };
    for robot in 0..problem.robots.len() {
        builder.robot(robot)?;
    }
    builder.obstacles()?;
    builder.person()?;
    builder.robots()?;
    builder.connection()?;
    builder.targets();
    let Builder { model, binaries, rows, columns, .. } = builder;
    Ok(Program { model, binaries, rows, columns, periods })
}

/// The convex parts of the ground that are free for the position of a robot.
pub fn free(problem: &Problem, robot: usize) -> Vec<Convex> {
    let body = &problem.robots[robot].body;
    let holes: Vec<Convex> = problem.obstacles.iter().map(|of| of.shape.sum(&body.reflected())).collect();
    problem.area.difference(body).map_or_else(Vec::new, |region| parts_around(&region, &holes))
}

/// The motions that follow from inputs, without visits.
pub fn replayed(problem: &Problem, present: &Present, inputs: &[Vec<Point>]) -> Trajectories {
    let states = inputs.iter().enumerate().map(|(robot, inputs)| {
        let discrete = problem.robots[robot].over(problem.period);
        let mut state = present.states[robot];
        let next = inputs.iter().map(|input| {
            if present.active[robot] {
                state = discrete.step(state, *input);
            }
            state
        });
        let next: Vec<State> = next.collect();
        std::iter::once(present.states[robot]).chain(next).collect()
    });
    Trajectories { states: states.collect(), inputs: inputs.to_vec(), visits: Vec::new() }
}

impl Program {
    /// Number of periods.
    pub fn periods(&self) -> usize {
        self.periods
    }

    /// The values of the states of motions by column; all others have their greatest values, so that the whole reserve may be missing.
    fn point(&self, of: &Trajectories) -> Vec<f64> {
        let mut point: Vec<f64> = self.model.columns.iter().map(|column| column.high).collect();
        for (columns, states) in self.columns.iter().zip(&of.states) {
            for ((at, velocity), state) in columns.at.iter().zip(&columns.velocity).zip(states) {
                for axis in 0..2 {
                    (point[at[axis]], point[velocity[axis]]) = (state.at[axis], state.velocity[axis]);
                }
            }
        }
        point
    }

    /// Values of the binaries for these motions; none: the motions do not meet the constraints.
    pub fn start(&self, of: &Trajectories) -> Option<Vec<(usize, f64)>> {
        let point = self.point(of);
        let holds = |rows: &[Side]| {
            rows.iter().all(|row| {
                row.along.iter().map(|(column, factor)| factor * point[*column]).sum::<f64>() >= row.bound - ROUNDING
            })
        };
        let mut values = Vec::new();
        let mut chosen: BTreeMap<Binary, bool> = BTreeMap::new();
        for ((binary, column), rows) in self.binaries.iter().zip(&self.rows) {
            let value = match *binary {
                Binary::Visit([robot, target, step]) => of.visits.contains(&Visit { robot, target, step }),
                Binary::Link(_) => holds(rows),
                // Of the sides that are free one is chosen.
                side => {
                    let chosen = chosen.entry(side.group()).or_default();
                    let this = !*chosen && holds(rows);
                    *chosen |= this;
                    this
                }
            };
            values.push((*column, f64::from(u8::from(value))));
        }
        chosen.values().all(|chosen| *chosen).then_some(values)
    }

    /// The motions of a point of the program. States follow from the inputs by the dynamics, so that the tolerances of an engine
    /// do not move the robots.
    pub fn trajectories(&self, problem: &Problem, present: &Present, values: &[f64]) -> Trajectories {
        let inputs =
            self.columns.iter().map(|of| of.input.iter().map(|input| input.map(|column| values[column])).collect());
        let inputs: Vec<Vec<Point>> = inputs.collect();
        let visits = self.binaries.iter().filter(|(_, column)| values[*column] > 0.5);
        let visits = visits.filter_map(|(binary, _)| match *binary {
            Binary::Visit([robot, target, step]) => Some(Visit { robot, target, step }),
            _ => None,
        });
        Trajectories { visits: visits.collect(), ..replayed(problem, present, &inputs) }
    }
}
