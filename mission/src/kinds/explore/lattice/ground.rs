//! The ground of a lattice: its positions, and the parts of the free ground that hold each of them. It depends on the problem alone, and
//! is made once for an execution.

use super::super::grid::Grid;
use super::super::motion::Dynamics;
use super::super::polygon::{Convex, Point, plus};
use super::super::problem::{Escape, Problem};
use super::super::program::free;
use super::safe::SafeStates;
use super::{MARGIN, MOST_PARTS};

/// Distance of the positions of plans, as a share of a cell.
pub(super) const SHARE: f64 = 0.5;

/// The ground of a lattice.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Distance of positions (m).
    pub(super) spacing: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
    origin: Point,
    /// By robot, the convex parts of the free ground.
    pub(super) parts: Vec<Vec<Convex>>,
    /// By robot and position, the parts that hold it.
    pub(super) free: Vec<Vec<u64>>,
    /// By robot, the states from which it can always give way; none: they are not known.
    pub(super) safe: Vec<Option<SafeStates>>,
}

impl Ground {
    /// The ground of plans; none: a robot has dynamics that no lattice fits, or the ground has too many parts.
    pub fn new(problem: &Problem) -> Option<Ground> {
        let mut ground = Ground::with_spacing(problem, SHARE)?;
        let grid = Grid::new(problem)?;
        if problem.planner.escape == Escape::Ignored {
            return Some(ground);
        }
        for (robot, who) in problem.robots.iter().enumerate() {
            let mut before = problem.robots.iter().zip(&ground.safe);
            let same = before.find(|(other, _)| {
                let dynamics = (other.dynamics, other.speed, other.acceleration);
                other.body == who.body && dynamics == (who.dynamics, who.speed, who.acceleration)
            });
            let known = same.map(|(_, safe)| safe.clone());
            let safe = known.unwrap_or_else(|| SafeStates::new(problem, robot, &grid, &ground));
            ground.safe.push(safe);
        }
        Some(ground)
    }

    /// The ground whose positions are this share of a cell apart, without safe states.
    pub(super) fn with_spacing(problem: &Problem, share: f64) -> Option<Ground> {
        if problem.robots.iter().any(|robot| matches!(robot.dynamics, Dynamics::Lag(_))) {
            return None;
        }
        let grid = Grid::new(problem)?;
        let [low, _] = problem.area.bounds();
        let places = |cells: usize| (cells as f64 / share).round() as usize + 1;
        let parts: Vec<Vec<Convex>> = (0..problem.robots.len()).map(|robot| free(problem, robot)).collect();
        if parts.iter().any(|parts| parts.is_empty() || parts.len() > MOST_PARTS) {
            return None;
        }
        let mut ground = Ground {
            spacing: share * grid.cell,
            columns: places(grid.columns),
            rows: places(grid.rows),
            origin: low,
            parts,
            free: Vec::new(),
            safe: Vec::new(),
        };
        let holds = |part: &Convex, at: Point| part.faces().iter().all(|face| -face.outside(at) >= MARGIN);
        let bits = |parts: &[Convex], at: Point| {
            parts.iter().enumerate().fold(0, |bits, (index, part)| bits | u64::from(holds(part, at)) << index)
        };
        let all = ground.parts.iter();
        ground.free = all.map(|parts| (0..ground.len()).map(|q| bits(parts, ground.point(q))).collect()).collect();
        Some(ground)
    }

    /// True if it is known of the states of a robot if it can always give way.
    pub fn knows_safe_states(&self) -> bool {
        self.safe.iter().any(Option::is_some)
    }

    /// Number of positions.
    pub(super) fn len(&self) -> usize {
        self.columns * self.rows
    }

    pub(super) fn point(&self, index: usize) -> Point {
        let (column, row) = (index % self.columns, index / self.columns);
        plus(self.origin, [column as f64 * self.spacing, row as f64 * self.spacing])
    }

    pub(super) fn index(&self, column: i32, row: i32) -> Option<usize> {
        let inside = (0..self.columns as i32).contains(&column) && (0..self.rows as i32).contains(&row);
        inside.then(|| row as usize * self.columns + column as usize)
    }

    /// The position that a point is; none: it is between positions.
    pub(super) fn at(&self, point: Point) -> Option<usize> {
        let steps = [0, 1].map(|axis| (point[axis] - self.origin[axis]) / self.spacing);
        let near = steps.map(f64::round);
        let is_one = (0..2).all(|axis| (steps[axis] - near[axis]).abs() * self.spacing < SAME);
        is_one.then(|| self.index(near[0] as i32, near[1] as i32)).flatten()
    }
}

/// Lengths (m) and velocities (m/s) that are the same but for rounding.
pub(super) const SAME: f64 = 1e-7;
