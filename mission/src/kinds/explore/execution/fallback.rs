//! The motion of the robots while there is no plan.
//!
//! The paper stops the robots (section 4.1), and a person may walk into one that stands. Beyond it, the robots follow a way out
//! ([`way_out`]), or stand if there is none. Unless the way out is known to be safe, a control barrier filter changes these motions at each
//! tick as little as it can, so that distances `h` of bodies and margins `h` of connections fulfil
//! `dh/dt >= -rate h`: a hierarchy of limits, walls, distances of members, and connections. The direction in which a distance is
//! measured is the normal of a face of the Minkowski difference of both bodies.

use solver::{ActiveSet, HierarchicalSolver, LevelShape, Problem as Hierarchy, Solution, Status};

use super::super::foresight::Foresight;
use super::super::lattice::{Deadline, safe_way_out, way_out};
use super::super::motion::{Dynamics, State};
use super::super::polygon::{Convex, Face, Point, dot, minus};
use super::super::problem::{Escape, Fallback, Robot};
use super::ExploreExecution;

/// Largest rate at which a distance may shrink, relative to itself (1/s).
const RATE: f64 = 2.0;
/// Distance (m) that is kept in reserve.
const RESERVE: f64 = 0.05;

/// A row `low <= sum of factors times velocities`; the factors are those of a robot, and of another one.
struct Row {
    of: usize,
    normal: Point,
    against: Option<usize>,
    low: f64,
}

impl ExploreExecution {
    /// Looks for a way out at the begin of a period without a plan.
    pub(super) fn find_way_out(&mut self, foresight: &Foresight, until: &Deadline) {
        let found = match self.problem.planner.fallback {
            Fallback::Stop => None,
            Fallback::Barrier => way_out(&self.kept, self.solver.ground(), &self.present(), foresight, until),
        };
        self.way_out = found.map(|way| (self.time, way));
    }

    /// Takes a safe way out in place of a plan that exposes a robot; false: there is none.
    pub(super) fn leaves_for_safety(&mut self, foresight: &Foresight, until: &Deadline) -> bool {
        let required = self.problem.planner.escape == Escape::Required;
        let ground = self.solver.ground().filter(|_| required);
        let found = ground.and_then(|ground| safe_way_out(&self.kept, ground, &self.present(), foresight, until));
        self.way_out = found.map(|way| (self.time, way));
        self.way_out.is_some()
    }

    /// The velocities after a tick (s) by which the robots follow the way out; none: there is none, and they stand.
    fn wanted(&self, tick: f64) -> Option<Vec<Point>> {
        let (begin, way) = self.way_out.as_ref()?;
        let period = ((self.time - begin) / way.period + 1e-9) as usize;
        let each =
            self.robots.iter().zip(&self.problem.robots).zip(&way.inputs).map(|((mover, robot), inputs)| {
                Some(robot.over(tick).step(mover.state, *inputs.get(period)?).velocity)
            });
        each.collect()
    }

    /// True in the period of a way out that keeps clear of everywhere the person can walk.
    fn is_on_safe_way(&self) -> bool {
        self.way_out.as_ref().is_some_and(|(begin, way)| way.is_safe && self.time < begin + way.period - 1e-9)
    }

    /// Gives the robots inputs for a tick (s).
    pub(super) fn fall_back(&mut self, tick: f64) {
        let limits: Vec<[Point; 2]> = self
            .robots
            .iter()
            .zip(&self.problem.robots)
            .map(|(mover, robot)| reachable(robot, mover.state.velocity, tick))
            .collect();
        let stop = |[low, high]: &[Point; 2]| [0, 1].map(|i| f64::clamp(0.0, low[i], high[i]));
        let stopping: Vec<Point> = limits.iter().map(stop).collect();
        let wanted = match self.problem.planner.fallback {
            Fallback::Stop => stopping,
            Fallback::Barrier => match self.wanted(tick) {
                // The rates of the filter would make a robot miss the safe state to which the motion leads.
                Some(wanted) if self.is_on_safe_way() => wanted,
                wanted => self.filtered(&limits, wanted).unwrap_or(stopping),
            },
        };
        for ((mover, robot), velocity) in self.robots.iter_mut().zip(&self.problem.robots).zip(wanted) {
            mover.input = input_for(robot, mover.state.velocity, velocity, tick);
        }
    }

    /// The velocities nearest to those of the way out, or to standing still, that keep distances and connections as well as they can; none:
    /// the solver has none.
    fn filtered(&self, limits: &[[Point; 2]], wanted: Option<Vec<Point>>) -> Option<Vec<Point>> {
        let count = self.robots.len();
        let levels = [self.walls(), self.distances(), self.links()];
        let shape = |rows: usize, hard: bool| LevelShape { rows, hard, damping: 0.0 };
        let own = levels.iter().map(|rows| shape(rows.len().max(1), false));
        let way = shape(2 * count, false);
        let shapes: Vec<LevelShape> = std::iter::once(shape(2 * count, true)).chain(own).chain([way]).collect();
        let mut hierarchy = Hierarchy::new(2 * count, &shapes);
        for (robot, [low, high]) in limits.iter().enumerate() {
            for axis in 0..2 {
                let mut row = vec![0.0; 2 * count];
                row[2 * robot + axis] = 1.0;
                let bounds = if self.robots[robot].active { (low[axis], high[axis]) } else { (0.0, 0.0) };
                hierarchy.levels[0].set(2 * robot + axis, &row, bounds.0, bounds.1);
            }
        }
        for (level, rows) in levels.iter().enumerate().map(|(index, rows)| (index + 1, rows)) {
            for (index, of) in rows.iter().enumerate() {
                let mut row = vec![0.0; 2 * count];
                for axis in 0..2 {
                    row[2 * of.of + axis] += of.normal[axis];
                    if let Some(other) = of.against {
                        row[2 * other + axis] -= of.normal[axis];
                    }
                }
                hierarchy.levels[level].set(index, &row, of.low, f64::INFINITY);
            }
            if rows.is_empty() {
                hierarchy.levels[level].set(0, &vec![0.0; 2 * count], 0.0, 0.0);
            }
        }
        for (index, wanted) in wanted.unwrap_or_else(|| vec![[0.0; 2]; count]).into_iter().flatten().enumerate() {
            let mut row = vec![0.0; 2 * count];
            row[index] = 1.0;
            hierarchy.levels[levels.len() + 1].set(index, &row, wanted, wanted);
        }
        let mut solution = Solution::new(&hierarchy);
        ActiveSet::new(&hierarchy).solve(&hierarchy, &mut solution);
        let found = solution.status == Status::Optimal && solution.x.iter().all(|x| x.is_finite());
        found.then(|| (0..count).map(|robot| [solution.x[2 * robot], solution.x[2 * robot + 1]]).collect())
    }

    /// Rows that keep robots in the region and off obstacles. They come first: nobody moves through a wall to give way.
    fn walls(&self) -> Vec<Row> {
        let (problem, mut rows) = (&self.problem, Vec::new());
        for (of, mover) in self.robots.iter().enumerate().filter(|(_, mover)| mover.active) {
            let (at, body) = (mover.state.at, &problem.robots[of].body);
            for obstacle in &problem.obstacles {
                let obstruction = Obstruction::fixed(obstacle.shape.sum(&body.reflected()));
                rows.push(obstruction.row(of, mover.state, problem.robots[of].acceleration));
            }
            for face in problem.area.difference(body).iter().flat_map(Convex::faces) {
                let normal = [-face.normal[0], -face.normal[1]];
                rows.push(Row { of, normal, against: None, low: RATE * face.outside(at) });
            }
        }
        rows
    }

    /// Rows that keep bodies apart: from the person, while the person is seen, and from other robots.
    fn distances(&self) -> Vec<Row> {
        let (problem, mut rows) = (&self.problem, Vec::new());
        let person = self.person.at(self.time);
        let walks = self.person.velocity(self.time);
        for (of, mover) in self.robots.iter().enumerate().filter(|(_, mover)| mover.active) {
            let (back, acceleration) = (problem.robots[of].body.reflected(), problem.robots[of].acceleration);
            if !self.person.is_unseen() {
                let set = problem.person.body.sum(&back);
                let obstruction = Obstruction { set, from: person, moves: walks, against: None };
                rows.push(obstruction.row(of, mover.state, acceleration));
            }
            for (other, its) in self.robots.iter().enumerate().filter(|(other, its)| *other < of || !its.active) {
                if other != of {
                    let set = problem.robots[other].body.sum(&back);
                    let against = its.active.then_some(other);
                    let obstruction = Obstruction { set, from: its.state.at, moves: [0.0; 2], against };
                    rows.push(obstruction.row(of, mover.state, acceleration));
                }
            }
        }
        rows
    }

    /// Rows that keep the connections of a spanning tree of the team, the ones with the largest margins.
    fn links(&self) -> Vec<Row> {
        let active: Vec<usize> = (0..self.robots.len()).filter(|robot| self.robots[*robot].active).collect();
        let person = self.robots.len();
        let (at, walks) = (self.person.at(self.time), self.person.velocity(self.time));
        let place = |member: usize| self.robots.get(member).map_or(at, |robot| robot.state.at);
        // Nobody can follow a person who is not seen: the robots then stay with one of them.
        let (mut inside, mut outside) = (vec![person], active);
        if self.person.is_unseen() && !outside.is_empty() {
            inside = vec![outside.remove(0)];
        }
        let mut rows = Vec::new();
        while !outside.is_empty() {
            let pairs = outside.iter().flat_map(|robot| inside.iter().map(move |other| (*robot, *other)));
            let margin =
                |(robot, other): &(usize, usize)| -self.problem.connection.outside(minus(place(*robot), place(*other)));
            let Some((robot, other)) = pairs.max_by(|a, b| margin(a).total_cmp(&margin(b))) else { break };
            for face in self.problem.connection.faces() {
                let normal = [-face.normal[0], -face.normal[1]];
                let left = -face.outside(minus(place(robot), place(other))) - RESERVE;
                let (moves, against) = if other == person { (walks, None) } else { ([0.0; 2], Some(other)) };
                rows.push(Row { of: robot, normal, against, low: dot(normal, moves) - RATE * left });
            }
            outside.retain(|of| *of != robot);
            inside.push(robot);
        }
        rows
    }
}

/// A set around a point (m) that a robot keeps out of; it moves (m/s), or moves with another robot.
struct Obstruction {
    set: Convex,
    from: Point,
    moves: Point,
    against: Option<usize>,
}

impl Obstruction {
    /// A set that stands where it is.
    fn fixed(set: Convex) -> Obstruction {
        Obstruction { set, from: [0.0; 2], moves: [0.0; 2], against: None }
    }

    /// The row that keeps a robot out of the set, on the side on which most is left after it has braked: beside a corner the side
    /// that is farthest now may be the one that it cannot keep to any more.
    fn row(&self, of: usize, state: State, acceleration: f64) -> Row {
        let apart = minus(state.at, self.from);
        let left = |face: &Face| {
            let toward = -dot(face.normal, minus(state.velocity, self.moves)).min(0.0);
            face.outside(apart) - 0.5 * toward * toward / acceleration
        };
        let faces = self.set.faces().iter();
        let face = faces.max_by(|a, b| left(a).total_cmp(&left(b))).unwrap_or(&self.set.faces()[0]);
        let distance = face.outside(apart) - RESERVE;
        let low = dot(face.normal, self.moves) - RATE * distance;
        Row { of, normal: face.normal, against: self.against, low }
    }
}

/// The velocities that a robot can have after a tick: the least and the greatest along each axis (m/s).
fn reachable(robot: &Robot, velocity: Point, tick: f64) -> [Point; 2] {
    let end = |v: f64, sign: f64| {
        let discrete = robot.over(tick);
        let input = match robot.dynamics {
            Dynamics::Acceleration => sign * robot.acceleration,
            Dynamics::Velocity => (v + sign * robot.acceleration * tick).clamp(-robot.speed, robot.speed),
            Dynamics::Lag(constant) => (v + sign * robot.acceleration * constant).clamp(-robot.speed, robot.speed),
        };
        (discrete.velocity_velocity * v + discrete.velocity_input * input).clamp(-robot.speed, robot.speed)
    };
    [velocity.map(|v| end(v, -1.0)), velocity.map(|v| end(v, 1.0))]
}

/// The input with which a robot has a velocity after a tick.
fn input_for(robot: &Robot, now: Point, wanted: Point, tick: f64) -> Point {
    let discrete = robot.over(tick);
    let most = robot.most_input();
    [0, 1].map(|i| ((wanted[i] - discrete.velocity_velocity * now[i]) / discrete.velocity_input).clamp(-most, most))
}
