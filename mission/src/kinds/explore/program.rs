//! The mixed-integer program of a plan: armchair (10a) to (10p) in the robust form (11) to (14).
//!
//! It differs from the paper where the paper is silent or can be passed between two samples:
//! - What holds at samples there holds at all times here. A motion stays in a triangle ([`motion`](super::motion)), and a
//!   constraint that is convex, or that one side of an obstacle fulfils, holds for the motion if it holds for the corners.
//! - In the first period the person may walk anywhere, which is a set that grows with time; of later periods (12) and (14) keep
//!   distance from the predicted position, enlarged by a stride.
//! - The horizon binary (10o), (10p) is known before the program is solved, since the prediction is: the horizon is cut at the arrival of the
//!   person. So are the visits of the person: targets that the person is expected to take are not offered to the robots.
//! - At the end of the horizon the robots stand.
//!
//! Big-M values come from the boxes that a robot can reach by then; sides of obstacles that it cannot reach have no binary.

use std::collections::BTreeMap;

use super::foresight::Foresight;
use super::motion::{Discrete, State};
use super::polygon::{Convex, Face, Point, dot, parts_around};
use super::problem::Problem;
use crate::engine::Model;

/// Slack of a test on boxes (m), for rounding.
const ROUNDING: f64 = 1e-7;
/// Distance (m) that the program keeps beyond each constraint, for the tolerances of engines.
pub const TOLERANCE: f64 = 1e-4;

/// Cost of a metre of reserve that is missing at the end of the first period.
pub const RESERVE_COST: f64 = 4.0;

/// The reserve (m) of distances from the person and of connections to the person at the end of the first period. A person who
/// turns around leaves the robots at least that much, with which they can follow or give way in the period after.
pub fn reserve(problem: &Problem) -> f64 {
    0.3 * problem.person.speed * problem.period
}

/// What a plan begins with.
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

/// A linear expression: columns with factors.
type Linear = Vec<(usize, f64)>;

/// A position as two affine expressions, with the box in which it is.
#[derive(Clone, Debug)]
struct Place {
    /// Columns of the position and of the velocity, and the factor of the velocity.
    at: [usize; 2],
    velocity: Option<([usize; 2], f64)>,
    /// Box (m) in which it is.
    low: Point,
    high: Point,
}

impl Place {
    fn along(&self, normal: Point) -> Linear {
        let mut terms = vec![(self.at[0], normal[0]), (self.at[1], normal[1])];
        if let Some((velocity, factor)) = self.velocity {
            terms.extend([(velocity[0], normal[0] * factor), (velocity[1], normal[1] * factor)]);
        }
        terms
    }

    /// The least value of `normal . y` in the box.
    fn least(&self, normal: Point) -> f64 {
        (0..2).map(|i| f64::min(normal[i] * self.low[i], normal[i] * self.high[i])).sum()
    }

    fn most(&self, normal: Point) -> f64 {
        -self.least([-normal[0], -normal[1]])
    }
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

/// What the robots do by a plan.
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

struct Builder<'p> {
    problem: &'p Problem,
    present: &'p Present,
    foresight: &'p Foresight,
    without: Option<Group>,
    model: Model,
    binaries: Vec<(Binary, usize)>,
    rows: Vec<Vec<Side>>,
    columns: Vec<Columns>,
    /// Positions that bound the motion in each period, by robot: its begin, its third point, its end.
    places: Vec<Vec<[Place; 3]>>,
    periods: usize,
}

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

impl Builder<'_> {
    fn has(&self, group: Group) -> bool {
        self.without != Some(group)
    }

    /// Columns, dynamics (10c) to (10e), limits (10f), (10g) and effort of a robot.
    fn robot(&mut self, robot: usize) -> Result<(), Blocked> {
        let who = &self.problem.robots[robot];
        let now = self.present.states[robot];
        let d = who.over(self.problem.period);
        let region = match self.has(Group::Limits) {
            true => self.problem.area.difference(&who.body).ok_or(Group::Limits)?,
            false => self.problem.area.sum(&self.problem.area.reflected()),
        };
        let [floor, ceiling] = region.bounds();
        let (moves, most) = (self.present.active[robot], who.most_input());
        let mut columns = Columns::default();
        let mut boxes = vec![(now.at, now.at, now.velocity, now.velocity)];
        for step in 1..=self.periods {
            let (low, high, slow, fast) = boxes[step - 1];
            boxes.push(if moves {
                reach(&d, who.speed, most, (low, high, slow, fast), [floor, ceiling])
            } else {
                boxes[0]
            });
        }
        for (step, (low, high, slow, fast)) in boxes.iter().enumerate() {
            let pair = |model: &mut Model, low: Point, high: Point| [0, 1].map(|i| model.real(0.0, low[i], high[i]));
            columns.at.push(pair(&mut self.model, *low, *high));
            // A plan ends with robots that stand; a lost one stands now.
            let last = step == self.periods && step > 0;
            let (slow, fast) = if last { ([0.0; 2], [0.0; 2]) } else { (*slow, *fast) };
            columns.velocity.push(pair(&mut self.model, slow, fast));
        }
        for step in 0..self.periods {
            let limit = if moves { most } else { 0.0 };
            let effort = self.problem.effort;
            let input = [0, 1].map(|_| self.model.real(0.0, -limit, limit));
            for axis in 0..2 {
                let (y, v, u) = (columns.at[step][axis], columns.velocity[step][axis], input[axis]);
                let (y1, v1) = (columns.at[step + 1][axis], columns.velocity[step + 1][axis]);
                let model = &mut self.model;
                if moves {
                    model.row(0.0, [(y1, -1.0), (y, 1.0), (v, d.position_velocity), (u, d.position_input)], 0.0);
                    model.row(0.0, [(v1, -1.0), (v, d.velocity_velocity), (u, d.velocity_input)], 0.0);
                    // The 1-norm of the input.
                    let size = model.real(effort, 0.0, limit);
                    model.at_least(0.0, [(size, 1.0), (u, 1.0)]);
                    model.at_least(0.0, [(size, 1.0), (u, -1.0)]);
                    // The acceleration at the begin of the period, which is its greatest one.
                    let change = match who.dynamics {
                        super::motion::Dynamics::Velocity => who.acceleration * self.problem.period,
                        super::motion::Dynamics::Lag(constant) => who.acceleration * constant,
                        super::motion::Dynamics::Acceleration => f64::INFINITY,
                    };
                    if change.is_finite() {
                        model.row(-change, [(u, 1.0), (v, -1.0)], change);
                    }
                }
            }
            columns.input.push(input);
        }
        let mut places = Vec::new();
        for step in 0..self.periods {
            let ((low, high, slow, fast), (low1, high1, ..)) = (boxes[step], boxes[step + 1]);
            let plain = |at: [usize; 2], low: Point, high: Point| Place { at, velocity: None, low, high };
            let third = Place {
                at: columns.at[step],
                velocity: (moves && d.middle > 0.0).then_some((columns.velocity[step], d.middle)),
                low: [0, 1].map(|i| f64::max(low[i] + d.middle * slow[i], floor[i].min(now.at[i]))),
                high: [0, 1].map(|i| f64::min(high[i] + d.middle * fast[i], ceiling[i].max(now.at[i]))),
            };
            places.push([plain(columns.at[step], low, high), third, plain(columns.at[step + 1], low1, high1)]);
        }
        if moves && self.has(Group::Limits) {
            for three in &places {
                for place in &three[1..] {
                    for face in region.faces() {
                        if place.most(face.normal) > face.bound {
                            let along = place.along(face.normal);
                            self.model.at_most(along, face.bound);
                        }
                    }
                }
            }
        }
        self.columns.push(columns);
        self.places.push(places);
        Ok(())
    }

    /// The rows of the three places of a motion in the first period, of which the first two are known: the end has to be far enough for
    /// the motion between them. A motion with a constant acceleration has the distances `b0 (1-s)^2 + 2 b1 s (1-s) + b2 s^2` from a line, which
    /// are not negative if `b1` is not, or else if `b2 >= b1^2 / b0`.
    fn first(&self, robot: usize, [begin, third, mut end]: [Side; 3]) -> Vec<Side> {
        let quadratic = self.problem.robots[robot].dynamics == super::motion::Dynamics::Acceleration;
        let (b0, b1) = (begin.least - begin.bound, third.least - third.bound);
        match b1 < 0.0 && quadratic && b0 > 0.0 {
            true => {
                end.bound += b1 * b1 / b0;
                vec![end]
            }
            // Who begins a little too near is not held to that for the begin.
            false => vec![third, end],
        }
    }

    /// A variable by which the reserve beyond a constraint may be less, and that costs.
    fn shortfall(&mut self) -> usize {
        let reserve = reserve(self.problem);
        self.model.real(RESERVE_COST, 0.0, reserve)
    }

    /// One of the sides of a set is between it and all these places in a period. `sides` has, for each place, the bound of
    /// `normal . y` from below; a row is `along >= bound`.
    fn pass(&mut self, sides: Vec<Vec<Side>>, binary: impl Fn(usize) -> Binary) -> Result<(), ()> {
        let is_clear = |side: &Vec<Side>| side.iter().all(|row| row.least >= row.bound - ROUNDING);
        if sides.iter().any(is_clear) {
            return Ok(());
        }
        let can = |side: &&(usize, Vec<Side>)| side.1.iter().all(|row| row.most >= row.bound - ROUNDING);
        let possible: Vec<(usize, Vec<Side>)> = sides.into_iter().enumerate().collect();
        let possible: Vec<&(usize, Vec<Side>)> = possible.iter().filter(can).collect();
        if let [(_, only)] = possible[..] {
            for row in only {
                self.model.at_least(row.bound, row.along.iter().copied());
            }
            return Ok(());
        }
        if possible.is_empty() {
            return Err(());
        }
        let mut one = Vec::new();
        for (index, rows) in possible {
            let z = self.model.binary(0.0);
            self.binaries.push((binary(*index), z));
            self.rows.push(rows.clone());
            one.push((z, 1.0));
            for row in rows.iter().filter(|row| row.least < row.bound) {
                // along >= bound - M (1 - z)
                let m = row.bound - row.least;
                let terms = row.along.iter().copied().chain([(z, -m)]);
                self.model.at_least(row.bound - m, terms);
            }
        }
        self.model.row(1.0, one, 1.0);
        Ok(())
    }

    /// (10h) with obstacles.
    fn obstacles(&mut self) -> Result<(), Blocked> {
        if !self.has(Group::Obstacles) {
            return Ok(());
        }
        for robot in 0..self.problem.robots.len() {
            if !self.present.active[robot] {
                continue;
            }
            let parts = free(self.problem, robot);
            for step in 0..self.periods {
                let places = &self.places[robot][step];
                let sides = parts.iter().map(|part| {
                    let rows = part.faces().iter().flat_map(|face| {
                        let side = |k: usize| Side::of(&places[k], &face.opposite(), -face.bound + TOLERANCE);
                        match step {
                            0 => self.first(robot, [side(0), side(1), side(2)]),
                            _ => (0..3).map(side).collect(),
                        }
                    });
                    rows.collect()
                });
                let sides = sides.collect();
                let binary = |part: usize| Binary::Part([robot, step, part]);
                self.pass(sides, binary).map_err(|()| Group::Obstacles)?;
            }
        }
        Ok(())
    }

    /// (12): the safety region around the person.
    fn person(&mut self) -> Result<(), Blocked> {
        if !self.has(Group::Person) {
            return Ok(());
        }
        let problem = self.problem;
        let strides = problem.strides(problem.period);
        for robot in 0..problem.robots.len() {
            if !self.present.active[robot] {
                continue;
            }
            let body = problem.robots[robot].body.reflected();
            let near = problem.person.body.sum(&body);
            let safe = near.sum_with_points(&strides);
            let ahead = problem.robots[robot].over(problem.period).middle / problem.period;
            for step in 0..self.periods {
                let from = self.foresight.positions[step];
                let places = self.places[robot][step].clone();
                let short = (step == 0).then(|| self.shortfall());
                let sides = safe.faces().iter().map(|face| {
                    let (own, whole) = (near.support(face.normal), face.bound);
                    // Until then the person can have walked this share of a stride.
                    let bounds: [f64; 3] = [own, own + ahead * (whole - own), whole];
                    let side = |k: usize| Side::of(&places[k], face, bounds[k] + dot(face.normal, from) + TOLERANCE);
                    match short {
                        None => (0..3).map(side).collect(),
                        Some(short) => {
                            let mut rows = self.first(robot, [side(0), side(1), side(2)]);
                            rows.push(side(2).with_reserve(short, reserve(problem)));
                            rows
                        }
                    }
                });
                let sides = sides.collect();
                let binary = |side: usize| Binary::Person([robot, step, side]);
                self.pass(sides, binary).map_err(|()| Group::Person)?;
            }
        }
        Ok(())
    }

    /// (10h) among robots.
    fn robots(&mut self) -> Result<(), Blocked> {
        if !self.has(Group::Robots) {
            return Ok(());
        }
        for (i, j) in pairs(self.problem.robots.len()) {
            if !self.present.active[i] && !self.present.active[j] {
                continue;
            }
            let (one, other) = (&self.problem.robots[i], &self.problem.robots[j]);
            let set = other.body.sum(&one.body.reflected());
            for step in 0..self.periods {
                let sides = set.faces().iter().map(|face| {
                    let side = |(a, b): (&Place, &Place)| Side::between(a, b, face, TOLERANCE);
                    self.of_both(i, j, step, side)
                });
                let sides = sides.collect();
                let binary = |side: usize| Binary::Robots([i, j, step, side]);
                self.pass(sides, binary).map_err(|()| Group::Robots)?;
            }
        }
        Ok(())
    }

    /// The rows of the difference of two motions in a period.
    fn of_both(&self, i: usize, j: usize, step: usize, row: impl Fn((&Place, &Place)) -> Side) -> Vec<Side> {
        let rows = |first: usize| self.both(i, j, step, first).into_iter().map(&row).collect::<Vec<Side>>();
        if step > 0 {
            return rows(0);
        }
        // The difference of two motions with constant accelerations is one too.
        match <[Side; 3]>::try_from(rows(0)) {
            Ok(three) if self.present.active[i] && self.present.active[j] => self.first(i, three),
            _ => rows(1),
        }
    }

    /// Pairs of places whose differences bound the difference of both motions in a period.
    fn both(&self, i: usize, j: usize, step: usize, first: usize) -> Vec<(&Place, &Place)> {
        let (a, b) = (&self.places[i][step], &self.places[j][step]);
        let alike = self.problem.robots[i].dynamics == self.problem.robots[j].dynamics
            || !self.present.active[i]
            || !self.present.active[j];
        match alike {
            // The difference of two motions of the same dynamics is a motion of them.
            true => (first..3).map(|place| (&a[place], &b[place])).collect(),
            false => (0..9).map(|k| (&a[k / 3], &b[k % 3])).skip(first).collect(),
        }
    }

    /// (10k) to (10n) with (14).
    fn connection(&mut self) -> Result<(), Blocked> {
        if !self.has(Group::Connection) {
            return Ok(());
        }
        let problem = self.problem;
        let count = problem.robots.len();
        let active: Vec<usize> = (0..count).filter(|robot| self.present.active[*robot]).collect();
        let strides = problem.strides(problem.period);
        for step in 0..self.periods {
            let mut links: Vec<((usize, usize), usize)> = Vec::new();
            for (i, j) in pairs(count) {
                if !active.contains(&i) || !active.contains(&j) {
                    continue;
                }
                let rows: Vec<Side> = problem
                    .connection
                    .faces()
                    .iter()
                    .flat_map(|face| {
                        let row = |(a, b): (&Place, &Place)| Side::within(a, b, face, TOLERANCE);
                        self.of_both(i, j, step, row)
                    })
                    .collect();
                if let Some(link) = self.link(rows, Binary::Link([i, j, step])) {
                    links.push(((i, j), link));
                }
            }
            // (10m): degrees of each pair of robots.
            for (i, j) in pairs(active.len()) {
                let pair = [active[i], active[j]];
                let terms = pair.iter().flat_map(|robot| {
                    let own = links.iter().filter(move |((a, b), _)| a == robot || b == robot);
                    own.map(|(_, link)| (*link, 1.0))
                });
                let terms: Vec<(usize, f64)> = terms.collect();
                if terms.is_empty() {
                    return Err(Group::Connection);
                }
                self.model.at_least(active.len() as f64, terms);
            }
            // (10n): somebody is connected to the person.
            let from = self.foresight.positions[step];
            let mut any = Vec::new();
            for &robot in &active {
                let ahead = problem.robots[robot].over(problem.period).middle / problem.period;
                let places = self.places[robot][step].clone();
                let short = (step == 0).then(|| self.shortfall());
                let rows: Vec<Side> = problem
                    .connection
                    .faces()
                    .iter()
                    .flat_map(|face| {
                        let stride = strides.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
                        let less = [0.0, ahead * stride, stride];
                        let side = |k: usize| {
                            let most = face.bound - less[k] + dot(face.normal, from);
                            Side::of(&places[k], &face.opposite(), -most + TOLERANCE)
                        };
                        match short {
                            None => (0..3).map(side).collect(),
                            Some(short) => {
                                let mut rows = self.first(robot, [side(0), side(1), side(2)]);
                                rows.push(side(2).with_reserve(short, reserve(problem)));
                                rows
                            }
                        }
                    })
                    .collect();
                any.extend(self.link(rows, Binary::Link([robot, count, step])).map(|link| (link, 1.0)));
            }
            if active.is_empty() {
                continue;
            }
            if any.is_empty() {
                return Err(Group::Connection);
            }
            self.model.at_least(1.0, any);
        }
        Ok(())
    }

    /// A binary that implies these rows; none if they cannot hold.
    fn link(&mut self, rows: Vec<Side>, binary: Binary) -> Option<usize> {
        if rows.iter().any(|row| row.most < row.bound - ROUNDING) {
            return None;
        }
        let z = self.model.binary(0.0);
        self.binaries.push((binary, z));
        self.rows.push(rows.clone());
        for row in rows.iter().filter(|row| row.least < row.bound) {
            let m = row.bound - row.least;
            self.model.at_least(row.bound - m, row.along.iter().copied().chain([(z, -m)]));
        }
        Some(z)
    }

    /// (10i), (10j) and the reward of (10a).
    fn targets(&mut self) {
        let taken = |target: usize| self.foresight.visits.iter().any(|(of, _)| *of == target);
        for (target, of) in self.problem.targets.iter().enumerate() {
            if !self.present.open[target] || taken(target) {
                continue;
            }
            let mut once = Vec::new();
            for robot in 0..self.problem.robots.len() {
                if !self.present.active[robot] {
                    continue;
                }
                for step in 1..=self.periods {
                    let place = self.places[robot][step - 1][2].clone();
                    let rows: Vec<Side> = of
                        .shape
                        .faces()
                        .iter()
                        .map(|face| Side::of(&place, &face.opposite(), -face.bound + TOLERANCE))
                        .collect();
                    if let Some(z) = self.link(rows, Binary::Visit([robot, target, step])) {
                        self.model.columns[z].cost = -of.worth;
                        once.push((z, 1.0));
                    }
                }
            }
            if once.len() > 1 {
                self.model.at_most(once, 1.0);
            }
        }
    }
}

/// A row `along >= bound`, with the least and the greatest value of its left side.
#[derive(Clone, Debug)]
struct Side {
    along: Linear,
    bound: f64,
    least: f64,
    most: f64,
}

impl Side {
    /// The same row with a reserve (m) beyond its bound, less what a variable takes of it.
    fn with_reserve(mut self, short: usize, reserve: f64) -> Side {
        self.along.push((short, 1.0));
        self.bound += reserve;
        self.most += reserve;
        self
    }

    /// A place is on the outer side of a face, at this bound.
    fn of(place: &Place, face: &Face, bound: f64) -> Side {
        let along = place.along(face.normal);
        Side { along, bound, least: place.least(face.normal), most: place.most(face.normal) }
    }

    /// The difference of two places is on the outer side of a face.
    fn between(a: &Place, b: &Place, face: &Face, slack: f64) -> Side {
        let back = [-face.normal[0], -face.normal[1]];
        let mut along = a.along(face.normal);
        along.extend(b.along(back));
        let (least, most) = (a.least(face.normal) + b.least(back), a.most(face.normal) + b.most(back));
        Side { along, bound: face.bound + slack, least, most }
    }

    /// The difference of two places is on the inner side of a face.
    fn within(a: &Place, b: &Place, face: &Face, slack: f64) -> Side {
        Side::between(a, b, &face.opposite(), slack)
    }
}

/// The convex parts of the ground that are free for the position of a robot.
pub fn free(problem: &Problem, robot: usize) -> Vec<Convex> {
    let body = &problem.robots[robot].body;
    let holes: Vec<Convex> = problem.obstacles.iter().map(|of| of.shape.sum(&body.reflected())).collect();
    problem.area.difference(body).map_or_else(Vec::new, |region| parts_around(&region, &holes))
}

/// Cost of the reserve that motions lack at the end of their first period.
pub fn lacking(problem: &Problem, present: &Present, foresight: &Foresight, of: &Trajectories) -> f64 {
    let (Some(from), reserve) = (foresight.positions.first(), reserve(problem)) else { return 0.0 };
    let strides = problem.strides(problem.period);
    let active = (0..problem.robots.len()).filter(|robot| present.active[*robot] && of.states[*robot].len() > 1);
    let (mut short, mut link) = (0.0, f64::INFINITY);
    for robot in active {
        let at = of.states[robot][1].at;
        let near = [at[0] - from[0], at[1] - from[1]];
        let safe = problem.person.body.sum(&problem.robots[robot].body.reflected()).sum_with_points(&strides);
        short += (reserve - safe.outside(near)).clamp(0.0, reserve);
        let left = problem.connection.faces().iter().map(|face| {
            let stride = strides.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
            -face.outside(near) - stride
        });
        link = f64::min(link, (reserve - left.fold(f64::INFINITY, f64::min)).max(0.0));
    }
    // One connection to the person is enough; without any the plan is refused anyway.
    RESERVE_COST * (short + if link.is_finite() { link.min(reserve) } else { 0.0 })
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

/// The pairs of different numbers below `count`, the smaller one first.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
}

/// Positions and velocities within boxes: least and greatest position, least and greatest velocity.
type Boxes = (Point, Point, Point, Point);

/// The boxes after one period. For these dynamics the farthest position follows from the greatest velocity.
fn reach(d: &Discrete, speed: f64, most: f64, (low, high, slow, fast): Boxes, [floor, ceiling]: [Point; 2]) -> Boxes {
    let end = |v: f64, sign: f64| {
        // The greatest input that keeps the speed within its limit.
        let input = most.min((speed - sign * d.velocity_velocity * v) / d.velocity_input);
        let input = sign * input;
        (d.position_velocity * v + d.position_input * input, d.velocity_velocity * v + d.velocity_input * input)
    };
    let mut next = (low, high, slow, fast);
    for i in 0..2 {
        let (down, slower) = end(slow[i], -1.0);
        let (up, faster) = end(fast[i], 1.0);
        next.0[i] = (low[i] + down).max(floor[i]);
        next.1[i] = (high[i] + up).min(ceiling[i]);
        (next.2[i], next.3[i]) = (slower.max(-speed), faster.min(speed));
        if next.0[i] > next.1[i] {
            // Outside of the region with no way back in one period: the rows say so.
            (next.0[i], next.1[i]) = (low[i] + down, high[i] + up);
        }
    }
    next
}

impl Program {
    /// Number of periods.
    pub fn periods(&self) -> usize {
        self.periods
    }

    /// Values of the binaries for these motions; none: the motions do not meet the constraints.
    pub fn start(&self, of: &Trajectories) -> Option<Vec<(usize, f64)>> {
        // What is missing of the reserve may be all of it.
        let mut point: Vec<f64> = self.model.columns.iter().map(|column| column.high).collect();
        for (columns, states) in self.columns.iter().zip(&of.states) {
            for ((at, velocity), state) in columns.at.iter().zip(&columns.velocity).zip(states) {
                for axis in 0..2 {
                    (point[at[axis]], point[velocity[axis]]) = (state.at[axis], state.velocity[axis]);
                }
            }
        }
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
