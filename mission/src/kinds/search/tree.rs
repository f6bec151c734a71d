//! RRT* (Karaman and Frazzoli 2011): a tree of ways from a root over the free ground, rewired towards the least price.

use rand_pcg::Pcg64;

use super::geometry::{Point, between, distance};
use super::ground::Ground;
use super::problem::{Problem, Source, SourceKind};
use crate::random::unit;

/// Distance of the samples along an edge (m).
const SAMPLE: f64 = 0.2;
/// Share of the samples that are goals.
const GOALS: f64 = 0.05;
/// Samples that may miss the free ground, for each node.
const MISSES: usize = 40;

/// Price of a motion: `int (time_price + sum of the negative rates) dt`.
#[derive(Clone, Debug)]
pub struct Price<'p> {
    /// Price of a second: the reward that the mission pays a second if it pays everything. Ours.
    time: f64,
    speed: f64,
    repelling: Vec<&'p Source>,
}

impl<'p> Price<'p> {
    /// The price for an agent.
    pub fn of(problem: &'p Problem, agent: usize) -> Price<'p> {
        let content = |source: &Source| match source.pool {
            Some(pool) => pool,
            None => source.inside.range()[1].max(source.outside.range()[1]).max(0.0) * (problem.end() - problem.start),
        };
        let hidden = problem.objects.iter().map(|object| object.worth * object.left() as f64);
        let all: f64 = problem.sources.iter().map(content).chain(hidden).sum();
        let stays = |source: &Source| matches!(source.kind, SourceKind::Environment | SourceKind::Task);
        let repelling = problem.sources.iter().enumerate();
        let repelling = repelling.filter(|(k, s)| s.repels() && stays(s) && problem.consumes(agent, *k));
        Price {
            time: (all / (problem.end() - problem.start)).max(1e-3),
            speed: problem.agents[agent].speed,
            repelling: repelling.map(|(_, source)| source).collect(),
        }
    }

    /// Returns true if the shortest way is the cheapest.
    pub fn is_length(&self) -> bool {
        self.repelling.is_empty()
    }

    /// Returns the price of a straight motion.
    pub fn edge(&self, a: Point, b: Point) -> f64 {
        let length = distance(a, b);
        let time = length / self.speed;
        if self.repelling.is_empty() {
            return self.time * time;
        }
        let steps = (length / SAMPLE).ceil().max(1.0);
        let costs = |p: Point| self.repelling.iter().map(|s| (-s.rate(p)).max(0.0)).sum::<f64>();
        let sum: f64 = (0..steps as usize).map(|i| costs(between(a, b, (i as f64 + 0.5) / steps))).sum();
        (self.time + sum / steps) * time
    }

    /// Returns the price of a polyline.
    pub fn way(&self, points: &[Point]) -> f64 {
        points.windows(2).map(|two| self.edge(two[0], two[1])).sum()
    }
}

/// A tree of ways.
#[derive(Clone, Debug)]
pub struct Tree {
    points: Vec<Point>,
    parents: Vec<u32>,
    prices: Vec<f64>,
    children: Vec<Vec<u32>>,
    cells: Cells,
    /// Longest edge (m).
    step: f64,
}

/// Nodes by square cells, for the neighbours of a point.
#[derive(Clone, Debug)]
struct Cells {
    low: Point,
    width: f64,
    columns: usize,
    rows: usize,
    nodes: Vec<Vec<u32>>,
}

impl Cells {
    fn new([low, high]: [Point; 2], width: f64) -> Cells {
        let count = |length: f64| ((length / width).ceil() as usize).clamp(1, 256);
        let (columns, rows) = (count(high[0] - low[0]), count(high[1] - low[1]));
        Cells { low, width, columns, rows, nodes: vec![Vec::new(); columns * rows] }
    }

    fn cell(&self, p: Point) -> [usize; 2] {
        let index = |x: f64, count: usize| ((x / self.width).max(0.0) as usize).min(count - 1);
        [index(p[0] - self.low[0], self.columns), index(p[1] - self.low[1], self.rows)]
    }

    fn add(&mut self, p: Point, node: u32) {
        let [column, row] = self.cell(p);
        self.nodes[row * self.columns + column].push(node);
    }

    /// Nodes of the cells at most `ring` away.
    fn near(&self, p: Point, ring: usize, mut each: impl FnMut(u32)) {
        let [column, row] = self.cell(p);
        for r in row.saturating_sub(ring)..=(row + ring).min(self.rows - 1) {
            for c in column.saturating_sub(ring)..=(column + ring).min(self.columns - 1) {
                self.nodes[r * self.columns + c].iter().for_each(|node| each(*node));
            }
        }
    }
}

impl Tree {
    /// Grows a tree of `nodes` nodes from a root where the body fits.
    pub fn grow(
        ground: &Ground,
        root: Point,
        goals: &[Point],
        nodes: usize,
        price: &Price<'_>,
        random: &mut Pcg64,
    ) -> Tree {
        let step = (ground.size().sqrt() / 10.0).max(0.2);
        let mut tree = Tree {
            points: vec![root],
            parents: vec![0],
            prices: vec![0.0],
            children: vec![Vec::new()],
            cells: Cells::new(ground.corners, step),
            step,
        };
        tree.cells.add(root, 0);
        // The radius of Karaman and Frazzoli for the plane, not above that of a step.
        let gamma = 2.0 * (1.5 * ground.size() / std::f64::consts::PI).sqrt();
        for _ in 0..nodes * MISSES {
            if tree.points.len() >= nodes {
                break;
            }
            let target = sample(ground, goals, random);
            let nearest = tree.nearest(target);
            let from = tree.points[nearest as usize];
            let far = distance(from, target);
            let p = if far > step { between(from, target, step / far) } else { target };
            if far < 1e-9 || !ground.fits(p) {
                continue;
            }
            let count = tree.points.len() as f64;
            let radius = (gamma * ((count + 1.0).ln() / (count + 1.0)).sqrt()).min(step);
            tree.insert(ground, p, nearest, radius, price);
        }
        tree
    }

    fn nearest(&self, p: Point) -> u32 {
        let mut best = (f64::INFINITY, 0);
        let reach = self.cells.columns.max(self.cells.rows);
        for ring in 1..=reach {
            self.cells.near(p, ring, |node| {
                let far = distance(self.points[node as usize], p);
                best = if far < best.0 { (far, node) } else { best };
            });
            // A node of a further ring is at least this far.
            if best.0 <= ring as f64 * self.cells.width {
                break;
            }
        }
        best.1
    }

    fn insert(&mut self, ground: &Ground, p: Point, nearest: u32, radius: f64, price: &Price<'_>) {
        let mut near = Vec::new();
        self.cells.near(p, 1, |node| {
            if distance(self.points[node as usize], p) <= radius {
                near.push(node);
            }
        });
        if !near.contains(&nearest) {
            near.push(nearest);
        }
        let edges: Vec<f64> = near.iter().map(|node| price.edge(self.points[*node as usize], p)).collect();
        let mut order: Vec<usize> = (0..near.len()).collect();
        let total = |i: &usize| self.prices[near[*i] as usize] + edges[*i];
        order.sort_by(|a, b| total(a).total_cmp(&total(b)).then(a.cmp(b)));
        let clear: Vec<bool> = near.iter().map(|node| ground.clear(self.points[*node as usize], p)).collect();
        let Some(parent) = order.into_iter().find(|i| clear[*i]) else { return };
        let node = self.points.len() as u32;
        let own = self.prices[near[parent] as usize] + edges[parent];
        self.points.push(p);
        self.parents.push(near[parent]);
        self.prices.push(own);
        self.children.push(Vec::new());
        self.children[near[parent] as usize].push(node);
        self.cells.add(p, node);
        for (i, other) in near.iter().enumerate() {
            if clear[i] && own + edges[i] < self.prices[*other as usize] - 1e-12 {
                self.rewire(*other, node, own + edges[i]);
            }
        }
    }

    /// Gives a node another parent, and its descendants the lower price.
    fn rewire(&mut self, node: u32, parent: u32, cost: f64) {
        let old = self.parents[node as usize] as usize;
        self.children[old].retain(|child| *child != node);
        self.parents[node as usize] = parent;
        self.children[parent as usize].push(node);
        let saved = self.prices[node as usize] - cost;
        let mut below = vec![node];
        while let Some(node) = below.pop() {
            self.prices[node as usize] -= saved;
            below.extend(&self.children[node as usize]);
        }
    }

    /// Returns the way from the root to a point where the body fits; none: no node reaches it straight.
    pub fn way(&self, ground: &Ground, to: Point, price: &Price<'_>) -> Option<Vec<Point>> {
        let mut near: Vec<(f64, u32)> = Vec::new();
        self.cells.near(to, 2, |node| {
            let p = self.points[node as usize];
            if distance(p, to) <= 2.0 * self.step {
                near.push((self.prices[node as usize] + price.edge(p, to), node));
            }
        });
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (_, mut node) = near.into_iter().find(|(_, node)| ground.clear(self.points[*node as usize], to))?;
        let mut way = vec![to];
        loop {
            way.push(self.points[node as usize]);
            if node == 0 {
                break;
            }
            node = self.parents[node as usize];
        }
        way.reverse();
        way.dedup_by(|a, b| distance(*a, *b) < 1e-9);
        Some(way)
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns true if there is nothing but a root.
    pub fn is_empty(&self) -> bool {
        self.points.len() <= 1
    }
}

fn sample(ground: &Ground, goals: &[Point], random: &mut Pcg64) -> Point {
    if !goals.is_empty() && unit(random) < GOALS {
        return goals[((unit(random) * goals.len() as f64) as usize).min(goals.len() - 1)];
    }
    let [low, high] = ground.corners;
    [low[0] + unit(random) * (high[0] - low[0]), low[1] + unit(random) * (high[1] - low[1])]
}

/// Distance of the points between which a way is shortened (m).
const FINE: f64 = 0.25;

/// Replaces parts of a way by straight lines that cost no more, from both ends.
pub fn shortcut(ground: &Ground, way: &[Point], price: &Price<'_>) -> Vec<Point> {
    let mut way = way.to_vec();
    for _ in 0..4 {
        way = shortened(ground, &fine(&way), price);
        way.reverse();
    }
    way
}

/// The same polyline with more points.
fn fine(way: &[Point]) -> Vec<Point> {
    let mut points: Vec<Point> = way.first().copied().into_iter().collect();
    for two in way.windows(2) {
        let count = (distance(two[0], two[1]) / FINE).ceil().max(1.0) as usize;
        points.extend((1..=count).map(|i| between(two[0], two[1], i as f64 / count as f64)));
    }
    points
}

/// One pass from the begin of a way.
fn shortened(ground: &Ground, way: &[Point], price: &Price<'_>) -> Vec<Point> {
    let mut short: Vec<Point> = way.first().copied().into_iter().collect();
    let mut from = 0;
    let mut sums = vec![0.0];
    sums.extend(way.windows(2).scan(0.0, |sum, two| {
        *sum += price.edge(two[0], two[1]);
        Some(*sum)
    }));
    let straight = |from: usize, to: usize| {
        price.edge(way[from], way[to]) <= sums[to] - sums[from] + 1e-9 && ground.clear(way[from], way[to])
    };
    while from + 1 < way.len() {
        let (mut next, mut step) = (from + 1, 1);
        // Far steps first double and then halve, as in a search for the end of what is clear.
        while next + step < way.len() && straight(from, next + step) {
            next += step;
            step *= 2;
        }
        while step > 0 {
            if next + step < way.len() && straight(from, next + step) {
                next += step;
            }
            step /= 2;
        }
        short.push(way[next]);
        from = next;
    }
    short
}
