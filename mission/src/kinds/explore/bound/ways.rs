//! Shortest ways of a robot around obstacles, by the maximum norm: each axis has its own limit of speed.
//!
//! A shortest way by any norm is a chain of segments between corners of the grown obstacles, since a straight segment is never longer
//! than a way between its ends. The lengths are lower bounds: obstacles are cut back where they overlap a target, so that all of a target is
//! within its largest radius of its middle, and are made smaller by [`SLACK`].

use super::super::polygon::{Convex, Point, minus};
use super::super::problem::Problem;
use super::super::program::free;

/// Length (m) by which motions may pass the edge of a constraint, for tolerances.
pub(super) const SLACK: f64 = 1e-3;
/// The most corners of which the ways are computed; beyond, ways are straight.
const MOST_CORNERS: usize = 256;

/// Ways of the robots of a problem.
#[derive(Clone, Debug)]
pub struct Ways {
    /// By robot; those with the same body have the same.
    robots: Vec<RobotWays>,
}

#[derive(Clone, Debug)]
pub(super) struct RobotWays {
    /// The convex parts of the free ground.
    pub parts: Vec<Convex>,
    holes: Vec<Convex>,
    /// Corners of the obstacles, and then the middles of the targets.
    nodes: Vec<Point>,
    /// By target, the length of the way from each node to the middle of the target (m).
    to_targets: Vec<Vec<f64>>,
    /// By target, the largest distance of a point of it from its middle (m).
    radii: Vec<f64>,
}

/// Length by the maximum norm (m).
fn length(by: Point) -> f64 {
    by[0].abs().max(by[1].abs())
}

/// True if a segment passes through the inside of a polygon, deeper than [`SLACK`].
fn passes_through(hole: &Convex, from: Point, to: Point) -> bool {
    let along = minus(to, from);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for face in hole.faces() {
        let (begin, change) = (face.outside(from) + SLACK, face.normal[0] * along[0] + face.normal[1] * along[1]);
        if change.abs() < 1e-12 {
            if begin >= 0.0 {
                return false;
            }
            continue;
        }
        let share = -begin / change;
        if change > 0.0 { leave = leave.min(share) } else { enter = enter.max(share) }
    }
    enter < leave
}

/// The remaining part of an obstacle that overlaps a target: the largest one on the outer side of a face of the target. None: nothing.
fn cut_back(hole: Convex, target: &Convex) -> Option<Convex> {
    if hole.gap(target) >= 0.0 {
        return Some(hole);
    }
    let beyond = target.faces().iter().filter_map(|face| hole.cut(&face.opposite()));
    beyond.max_by(|a, b| extent(a).total_cmp(&extent(b)))
}

/// Sum of the sides of the box around a polygon (m).
fn extent(of: &Convex) -> f64 {
    let [low, high] = of.bounds();
    high[0] - low[0] + high[1] - low[1]
}

impl Ways {
    /// Computes the ways of a problem.
    pub fn new(problem: &Problem) -> Ways {
        let mut robots: Vec<RobotWays> = Vec::new();
        for (robot, who) in problem.robots.iter().enumerate() {
            let same = problem.robots[..robot].iter().position(|other| other.body == who.body);
            let ways = match same {
                Some(other) => robots[other].clone(),
                None => RobotWays::new(problem, robot),
            };
            robots.push(ways);
        }
        Ways { robots }
    }

    pub(super) fn of(&self, robot: usize) -> &RobotWays {
        &self.robots[robot]
    }
}

impl RobotWays {
    fn new(problem: &Problem, robot: usize) -> RobotWays {
        let body = &problem.robots[robot].body;
        let grown = problem.obstacles.iter().map(|of| of.shape.sum(&body.reflected()));
        let left = |hole: Convex| problem.targets.iter().try_fold(hole, |hole, target| cut_back(hole, &target.shape));
        let holes: Vec<Convex> = grown.filter_map(left).collect();
        let inside = |at: &Point| holes.iter().any(|hole| hole.outside(*at) < -SLACK);
        let region = problem.area.difference(body);
        let reachable = |at: &Point| region.as_ref().is_none_or(|region| region.contains(*at, SLACK));
        let corners = holes.iter().flat_map(|hole| hole.corners().iter().copied());
        let mut nodes: Vec<Point> = corners.filter(|at| reachable(at) && !inside(at)).collect();
        let count = nodes.len();
        nodes.extend(problem.targets.iter().map(|target| target.shape.middle()));
        let radius = |target: usize| {
            let shape = &problem.targets[target].shape;
            shape.corners().iter().map(|at| length(minus(*at, shape.middle()))).fold(0.0, f64::max)
        };
        let radii = (0..problem.targets.len()).map(radius).collect();
        let mut ways = RobotWays { parts: free(problem, robot), holes, nodes, to_targets: Vec::new(), radii };
        if count > MOST_CORNERS {
            ways.holes.clear();
        }
        let edges: Vec<Vec<f64>> = (0..ways.nodes.len())
            .map(|a| ways.nodes.iter().map(|to| ways.straight(ways.nodes[a], *to)).collect())
            .collect();
        ways.to_targets = (0..problem.targets.len()).map(|target| shortest(&edges, count + target)).collect();
        ways
    }

    /// Length of the straight way between two points (m); infinite: an obstacle is between them. Obstacles around the first point
    /// do not count.
    fn straight(&self, from: Point, to: Point) -> f64 {
        let mut holes = self.holes.iter().filter(|hole| hole.outside(from) >= -SLACK);
        match holes.any(|hole| passes_through(hole, from, to)) {
            true => f64::INFINITY,
            false => length(minus(to, from)),
        }
    }

    /// A lower bound on the length of a way from a point to each target (m); infinite: there is none.
    pub fn to_targets(&self, from: Point) -> Vec<f64> {
        let first: Vec<f64> = self.nodes.iter().map(|node| self.straight(from, *node)).collect();
        let least = |ways: &Vec<f64>| first.iter().zip(ways).map(|(a, b)| a + b).fold(f64::INFINITY, f64::min);
        self.to_targets.iter().zip(&self.radii).map(|(ways, radius)| (least(ways) - radius).max(0.0)).collect()
    }

    /// A lower bound on the length of a way between two targets (m).
    pub fn between(&self, a: usize, b: usize) -> f64 {
        let node = self.nodes.len() - self.radii.len() + a;
        (self.to_targets[b][node] - self.radii[a] - self.radii[b]).max(0.0)
    }
}

/// Lengths of the shortest ways from all nodes to one of them, by the algorithm of Dijkstra. The lengths of edges are the same in both directions.
fn shortest(edges: &[Vec<f64>], to: usize) -> Vec<f64> {
    let mut lengths = vec![f64::INFINITY; edges.len()];
    let mut open: Vec<usize> = (0..edges.len()).collect();
    lengths[to] = 0.0;
    while let Some(place) = (0..open.len()).min_by(|a, b| lengths[open[*a]].total_cmp(&lengths[open[*b]])) {
        let node = open.swap_remove(place);
        for other in &open {
            lengths[*other] = lengths[*other].min(lengths[node] + edges[node][*other]);
        }
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ways(holes: Vec<Convex>, targets: &[Point]) -> RobotWays {
        let mut nodes: Vec<Point> = holes.iter().flat_map(|hole| hole.corners().to_vec()).collect();
        let count = nodes.len();
        nodes.extend(targets);
        let mut ways =
            RobotWays { parts: Vec::new(), holes, nodes, to_targets: Vec::new(), radii: vec![0.0; targets.len()] };
        let edges: Vec<Vec<f64>> =
            ways.nodes.iter().map(|a| ways.nodes.iter().map(|b| ways.straight(*a, *b)).collect()).collect();
        ways.to_targets = (0..targets.len()).map(|target| shortest(&edges, count + target)).collect();
        ways
    }

    /// Against ways of a king over a fine grid: no shorter than the bound, and hardly longer, since a king's step is one by the maximum norm.
    #[test]
    fn ways_are_those_over_a_fine_grid() {
        let holes: Vec<Convex> = [([2.0, 2.0], [2.0, 3.0]), ([4.5, 4.0], [1.0, 4.0])]
            .iter()
            .filter_map(|(at, size)| Some(Convex::rectangle(*size)?.moved(*at)))
            .collect();
        let (side, step) = (65_usize, 0.1);
        let point = |index: usize| [(index % side) as f64 * step, (index / side) as f64 * step];
        let target = 3 * 10 + 45 * side;
        let found = ways(holes.clone(), &[point(target)]);
        let outside = |at: Point| holes.iter().all(|hole| hole.outside(at) >= -1e-9);
        let free = |index: usize| outside(point(index));
        let mut steps = vec![usize::MAX; side * side];
        let mut queue = std::collections::VecDeque::from([target]);
        steps[target] = 0;
        while let Some(at) = queue.pop_front() {
            let (x, y) = ((at % side) as i32, (at / side) as i32);
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                let (x, y) = (x + dx, y + dy);
                let inside = (0..side as i32).contains(&x) && (0..side as i32).contains(&y);
                let next = (y.max(0) as usize) * side + x.max(0) as usize;
                // A diagonal step must not cut a corner.
                let between = [0, 1].map(|axis| 0.5 * (point(at)[axis] + point(next)[axis]));
                if inside && free(next) && outside(between) && steps[next] == usize::MAX {
                    steps[next] = steps[at] + 1;
                    queue.push_back(next);
                }
            }
        }
        for index in (0..side * side).filter(|index| free(*index) && steps[*index] < usize::MAX) {
            let (bound, way) = (found.to_targets(point(index))[0], steps[index] as f64 * step);
            assert!(bound <= way + 1e-9 && way <= bound + 2.5 * step, "{:?}: {bound} {way}", point(index));
        }
    }
}
