//! The action sets of the agents (srs 4.3): spots where sources are consumed, and ways between them with the rewards along
//! them.
//!
//! Each spot is the root of a tree, as the paper roots one at each source of positive reward. An action of an agent is a way
//! to a spot, or a stay there. Lookouts are spots as well.

use std::sync::Arc;

use super::belief::{Dwell, dwells};
use super::geometry::{Point, Pose, along, between, bounds, distance, middle};
use super::ground::{Body, Ground, Raster, Reached};
use super::lookouts::lookouts;
use super::problem::{Boundary, Problem, Source, SourceKind, Travel};
use super::roads::Roads;
use super::sight::Sight;

use super::tree::{Price, Tree, shortcut};
use crate::parallel::in_parallel;
use crate::random::stream;

/// Time of a step of the quadrature of rewards along a way (s).
const STEP: f64 = 0.1;
/// The most steps of a way.
const MOST_STEPS: usize = 256;
/// Side of the raster of points that are tried inside a boundary.
const TRIED: usize = 13;
/// The most spots of a source.
const MOST_SPOTS: usize = 4;
/// Least distance between two spots of a source (m).
const APART: f64 = 2.0;
/// Factor of the number of nodes of a tree that reaches no goal.
const REGROWN: usize = 4;

/// The spot of a goal that somebody has told, behind that of the start.
const TOLD: usize = 1;

/// Returns the number of steps of the quadrature of a motion that takes this time (s).
pub fn steps(duration: f64) -> usize {
    // Rounding of times does not add a step.
    ((duration / STEP - 1e-6).ceil() as usize).clamp(1, MOST_STEPS)
}

/// Returns the reward rate (1/s) of a source for an agent that is at a point with a motion. That of an interaction source
/// needs the position of another agent, and is zero here.
pub fn rate(problem: &Problem, agent: usize, source: usize, at: Point, travel: Travel) -> f64 {
    if !problem.consumes(agent, source) {
        return 0.0;
    }
    let of = &problem.sources[source];
    match of.kind {
        SourceKind::Environment | SourceKind::Task => of.rate(at),
        SourceKind::Action => of.rate_of(travel),
        SourceKind::Interaction => 0.0,
    }
}

/// The purpose of a place to which an agent may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// Somebody has told the agent to go there.
    Told,
    /// A source is consumed there, by index.
    Source(usize),
    /// Hidden objects are looked for from there.
    Lookout,
}

/// A place where an agent can begin, consume a source, or look for hidden objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Position (m).
    pub at: Point,
    /// The source; none: the start, a goal that somebody has told, or a lookout.
    pub source: Option<usize>,
    /// Hidden objects are looked for from here.
    pub lookout: bool,
    /// Cell from which an agent sees here; none: it does not look.
    pub seat: Option<u32>,
    /// Reward rate of each source at rest here (1/s).
    pub rates: Vec<f64>,
}

/// A motion of an agent.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Its polyline (m).
    pub points: Vec<Point>,
    /// Time that it takes (s).
    pub duration: f64,
    /// For each source that rewards along it: the reward from its begin to the end of each step, srs (2).
    pub rewards: Vec<(usize, Vec<f64>)>,
    /// Cells from which the agent sees on it, if it looks for hidden objects.
    pub dwells: Vec<Dwell>,
}

impl Way {
    /// A motion of an agent along a polyline.
    pub fn new(problem: &Problem, agent: usize, points: Vec<Point>) -> Way {
        let speed = problem.agents[agent].speed;
        let duration = super::geometry::length(&points) / speed;
        let count = steps(duration);
        let places: Vec<Pose> = (0..count).map(|i| along(&points, (i as f64 + 0.5) / count as f64, 0.0)).collect();
        let mut rewards = Vec::new();
        for source in 0..problem.sources.len() {
            let mut sums = vec![0.0];
            let mut sum = 0.0;
            for place in &places {
                let travel = Travel { speed, heading: place.heading };
                sum += rate(problem, agent, source, place.at, travel) * duration / count as f64;
                sums.push(sum);
            }
            if sums.iter().any(|sum| *sum != 0.0) {
                rewards.push((source, sums));
            }
        }
        let dwells = problem.looks(agent).map_or_else(Vec::new, |_| {
            let sight = problem.sight();
            dwells(count, |share| sight.seat(along(&points, share, 0.0).at))
        });
        Way { points, duration, rewards, dwells }
    }

    /// Adds the reward between two shares of the way to that of each source. The rate is constant in each step.
    pub fn add(&self, from: f64, to: f64, sums: &mut [f64]) {
        for (source, steps) in &self.rewards {
            let at = |share: f64| {
                let x = share.clamp(0.0, 1.0) * (steps.len() - 1) as f64;
                let step = (x as usize).min(steps.len() - 2);
                steps[step] + (x - step as f64) * (steps[step + 1] - steps[step])
            };
            sums[*source] += at(to) - at(from);
        }
    }
}

/// The action set of an agent.
#[derive(Clone, Debug, Default)]
pub struct ActionSet {
    /// Spots: the start, and those of sources.
    pub spots: Vec<Spot>,
    /// The spot of the goal that somebody has told it.
    pub told: Option<usize>,
    /// Greatest rate of each source at a spot (1/s), not below zero.
    pub best_rates: Vec<f64>,
    /// Ways from spot to spot, row by row; none: there is none, or it leads to the start.
    ways: Vec<Option<Way>>,
}

impl ActionSet {
    /// Returns the way between two spots.
    pub fn way(&self, from: usize, to: usize) -> Option<&Way> {
        self.ways.get(from * self.spots.len() + to)?.as_ref()
    }
}

/// The action sets of all agents. Those who are lost have none.
#[derive(Clone, Debug)]
pub struct ActionSets {
    /// By agent.
    pub of: Vec<ActionSet>,
    /// Cells in sight of one another, if hidden objects are looked for.
    pub sight: Option<Arc<Sight>>,
    /// Number of nodes of all trees.
    pub nodes: u64,
}

/// Polylines between the spots of agents with one body.
struct Lines {
    body: Body,
    goals: Vec<(Point, Goal)>,
    start: Point,
    agent: usize,
    lines: Vec<Option<Vec<Point>>>,
}

impl ActionSets {
    /// Builds the action sets on at most this number of threads, which changes nothing about them.
    pub fn new(problem: &Problem, threads: usize) -> ActionSets {
        let sight = problem.is_searching().then(|| problem.sight());
        let mut sets = ActionSets { of: Vec::new(), sight, nodes: 0 };
        let mut known: Vec<Lines> = Vec::new();
        for (index, agent) in problem.agents.iter().enumerate() {
            if agent.lost {
                sets.of.push(ActionSet::default());
                continue;
            }
            let body = Body::of(agent);
            let ground = Ground::new(problem, &body);
            let raster = ground.raster();
            let reached =
                (!problem.walls.is_empty() || !ground.clear_everywhere()).then(|| raster.reached(agent.start));
            let of_sources = goals(problem, index, &ground, reached.as_ref());
            let told = agent.told.filter(|to| ground.fits(*to)).map(|to| (to, Goal::Told));
            let of_sources = of_sources.into_iter().map(|(at, source)| (at, Goal::Source(source)));
            let views = lookouts(problem, index, &ground, reached.as_ref());
            let views = views.into_iter().map(|at| (at, Goal::Lookout));
            let goals: Vec<(Point, Goal)> = told.into_iter().chain(of_sources).chain(views).collect();
            let same = |other: &&Lines| {
                other.body == body && other.goals == goals && price_is_same(problem, other.agent, index)
            };
            let shared = known.iter().find(same);
            let network = Network { problem, agent: index, ground: &ground, raster: &raster };
            let lines = network.lines(&goals, shared, threads, &mut sets.nodes);
            let set = action_set(problem, index, &goals, &lines);
            sets.of.push(ActionSet { told: told.map(|_| TOLD), ..set });
            known.push(Lines { body, goals, start: agent.start, agent: index, lines });
        }
        sets
    }
}

/// Returns true if two agents pay the same for a motion.
fn price_is_same(problem: &Problem, a: usize, b: usize) -> bool {
    let (one, other) = (Price::of(problem, a), Price::of(problem, b));
    let repelled = |of: usize| {
        (0..problem.sources.len())
            .filter(|k| problem.sources[*k].repels() && problem.consumes(of, *k))
            .collect::<Vec<_>>()
    };
    (one.is_length() && other.is_length())
        || (problem.agents[a].speed == problem.agents[b].speed && repelled(a) == repelled(b))
}

/// Everything on which the ways of an agent depend.
struct Network<'p> {
    problem: &'p Problem,
    agent: usize,
    ground: &'p Ground,
    raster: &'p Raster<'p>,
}

impl Network<'_> {
    /// Ways from the start, which is spot 0, to the goals and between them, row by row.
    fn lines(
        &self,
        goals: &[(Point, Goal)],
        shared: Option<&Lines>,
        threads: usize,
        nodes: &mut u64,
    ) -> Vec<Option<Vec<Point>>> {
        let start = self.problem.agents[self.agent].start;
        let spots: Vec<Point> = std::iter::once(start).chain(goals.iter().map(|goal| goal.0)).collect();
        let price = Price::of(self.problem, self.agent);
        let sight = self.problem.looks(self.agent).map(|_| self.problem.sight());
        let roads = sight.as_ref().map(|sight| Roads::new(sight, self.ground, self.problem.cell, &price));
        let count = spots.len();
        let rows =
            in_parallel(count, threads, |from| match shared.filter(|shared| from > 0 || shared.start == start) {
                Some(shared) => (shared.lines[from * count..(from + 1) * count].to_vec(), 0),
                None => self.row(from, &spots, roads.as_ref(), &price),
            });
        let mut all: Vec<Option<Vec<Point>>> = Vec::with_capacity(count * count);
        for (row, grown) in rows {
            all.extend(row);
            *nodes += grown;
        }
        // A way back is the same one.
        for from in 1..count {
            for to in from + 1..count {
                let back = all[from * count + to].clone().map(|way| way.into_iter().rev().collect());
                if all[to * count + from].is_none() {
                    all[to * count + from] = back;
                }
            }
        }
        all
    }

    /// Ways from a spot to the later ones, and the number of nodes that were grown for them.
    fn row(
        &self,
        from: usize,
        spots: &[Point],
        roads: Option<&Roads<'_>>,
        price: &Price<'_>,
    ) -> (Vec<Option<Vec<Point>>>, u64) {
        let ground = self.ground;
        let (mut row, mut nodes) = (vec![None; spots.len()], 0);
        let straight = |to: usize| price.is_length() && ground.clear(spots[from], spots[to]);
        let (straight, others): (Vec<usize>, Vec<usize>) = (from + 1..spots.len()).partition(|to| straight(*to));
        for to in straight {
            row[to] = Some(vec![spots[from], spots[to]]);
        }
        if others.is_empty() {
            return (row, nodes);
        }
        let targets: Vec<Point> = others.iter().map(|to| spots[*to]).collect();
        let mut found = match roads {
            Some(roads) => roads.ways(ground, spots[from], &targets, price),
            None => vec![None; targets.len()],
        };
        for way in found.iter_mut().flatten() {
            *way = shortcut(ground, way, price);
        }
        let missing: Vec<usize> = (0..targets.len()).filter(|k| found[*k].is_none()).collect();
        if !missing.is_empty() {
            let far: Vec<Point> = missing.iter().map(|k| targets[*k]).collect();
            let grown = self.grown(spots[from], &far, price, from, &mut nodes);
            missing.into_iter().zip(grown).for_each(|(k, way)| found[k] = way);
        }
        for (to, way) in others.into_iter().zip(found) {
            row[to] = way;
        }
        (row, nodes)
    }

    /// Ways from a root to targets by RRT*; where no node reaches a target, over the raster.
    fn grown(
        &self,
        root: Point,
        targets: &[Point],
        price: &Price<'_>,
        number: usize,
        nodes: &mut u64,
    ) -> Vec<Option<Vec<Point>>> {
        let (ground, settings) = (self.ground, &self.problem.planner);
        let grow = |count: usize, nodes: &mut u64| {
            let mut random = stream(settings.seed, &["tree", &number.to_string(), &count.to_string()]);
            let tree = Tree::grow(ground, root, targets, count, price, &mut random);
            *nodes += tree.len() as u64;
            tree
        };
        let tree = grow(settings.tree_nodes, nodes);
        let mut ways: Vec<Option<Vec<Point>>> = targets.iter().map(|to| tree.way(ground, *to, price)).collect();
        if ways.iter().any(Option::is_none) {
            let larger = grow(REGROWN * settings.tree_nodes, nodes);
            for (way, to) in ways.iter_mut().zip(targets).filter(|(way, _)| way.is_none()) {
                *way = larger.way(ground, *to, price);
            }
        }
        if ways.iter().any(Option::is_none) {
            let reached = self.raster.reached(root);
            for (way, to) in ways.iter_mut().zip(targets).filter(|(way, _)| way.is_none()) {
                *way = reached.way(*to);
            }
        }
        for way in ways.iter_mut().flatten() {
            *way = shortcut(ground, way, price);
        }
        ways
    }
}

/// The action set with the rewards along its ways.
fn action_set(problem: &Problem, agent: usize, goals: &[(Point, Goal)], lines: &[Option<Vec<Point>>]) -> ActionSet {
    let sight = problem.looks(agent).map(|_| problem.sight());
    let spot = |at: Point, goal: Goal| Spot {
        at,
        source: if let Goal::Source(source) = goal { Some(source) } else { None },
        lookout: goal == Goal::Lookout,
        seat: sight.as_ref().and_then(|sight| sight.seat(at)),
        rates: (0..problem.sources.len()).map(|source| rate(problem, agent, source, at, Travel::REST)).collect(),
    };
    let start = spot(problem.agents[agent].start, Goal::Told);
    let spots: Vec<Spot> = std::iter::once(start).chain(goals.iter().map(|(at, goal)| spot(*at, *goal))).collect();
    let best = |source: usize| spots.iter().map(|spot| spot.rates[source]).fold(0.0, f64::max);
    let best_rates = (0..problem.sources.len()).map(best).collect();
    let way = |line: &Option<Vec<Point>>| line.clone().map(|points| Way::new(problem, agent, points));
    ActionSet { spots, told: None, best_rates, ways: lines.iter().map(way).collect() }
}

/// Goals of an agent: for each source that it may consume points where it is rewarding and the agent fits, with the index
/// of the source.
pub fn goals(problem: &Problem, agent: usize, ground: &Ground, reached: Option<&Reached<'_>>) -> Vec<(Point, usize)> {
    let mut goals = Vec::new();
    for (index, source) in problem.sources.iter().enumerate() {
        let stays = matches!(source.kind, SourceKind::Environment | SourceKind::Task);
        if stays && source.attracts() && problem.consumes(agent, index) {
            goals.extend(spots_of(source, ground, reached).into_iter().map(|at| (at, index)));
        }
    }
    goals
}

/// Points where a source is rewarding: the one with the highest rate, and others of an extended source.
fn spots_of(source: &Source, ground: &Ground, reached: Option<&Reached<'_>>) -> Vec<Point> {
    let good =
        |p: &Point| source.rate(*p) > 0.0 && ground.fits(*p) && reached.is_none_or(|reached| reached.reaches(*p));
    match &source.boundary {
        Boundary::Speed(_) | Boundary::Heading(_) => Vec::new(),
        Boundary::Points(points) => {
            let mut all: Vec<Point> = points.iter().copied().filter(good).collect();
            if all.is_empty() {
                all = best(source, raster(source), &good);
            }
            all
        }
        Boundary::Line(points) => {
            let middles = points.windows(2).map(|two| between(two[0], two[1], 0.5));
            let on: Vec<Point> = middles.chain(points.iter().copied()).filter(good).collect();
            best(source, if on.is_empty() { raster(source) } else { on }, &good)
        }
        Boundary::Circle { .. } | Boundary::Polygon(_) => {
            let centre = middle(&source.boundary.points());
            best(source, std::iter::once(centre).chain(raster(source)).collect(), &good)
        }
    }
}

/// The best of some points and up to three others apart from each other, of at least half its rate.
fn best(source: &Source, tried: Vec<Point>, good: &dyn Fn(&Point) -> bool) -> Vec<Point> {
    let mut tried: Vec<(f64, Point)> = tried.into_iter().map(|p| (source.rate(p), p)).collect();
    // A stable sort: of equal points the first one stays first.
    tried.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Point> = Vec::new();
    let mut top = 0.0;
    for (rate, p) in tried {
        if chosen.len() == MOST_SPOTS || rate < 0.5 * top {
            break;
        }
        if chosen.iter().all(|other| distance(*other, p) >= APART) && good(&p) {
            top = if chosen.is_empty() { rate } else { top };
            chosen.push(p);
        }
    }
    chosen
}

/// Points in and around a boundary.
fn raster(source: &Source) -> Vec<Point> {
    let margin = if source.outside.range()[1] > 0.0 { source.outside.reach() } else { 0.0 };
    let more = match source.boundary {
        Boundary::Circle { radius, .. } => radius + margin,
        _ => margin,
    };
    let [low, high] = bounds(source.boundary.points());
    let at = |i: usize, axis: usize| {
        let share = (i as f64 + 0.5) / TRIED as f64;
        low[axis] - more + share * (high[axis] - low[axis] + 2.0 * more)
    };
    (0..TRIED * TRIED).map(|i| [at(i % TRIED, 0), at(i / TRIED, 1)]).collect()
}
