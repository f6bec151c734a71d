//! Ranges of expressions, for all joint positions within their limits and all times.
//!
//! The analysis uses one interval per number. Bounds of whole vectors narrow them: each vector of three numbers has a
//! ball that contains it, and vectors and quaternions have an interval of lengths. An expression that cannot be bounded
//! is unbounded, so a value outside a range is proven to be unreachable.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Point3, Vector3};
use robot::{LinkId, Model};
use runtime::program::{Capture, CaptureSource, Op, Program};
use stdlib_tasks::bound::{Bound, Geometry};
use stdlib_tasks::expression::Leaf;
use stdlib_tasks::field::{DistanceProgram, FieldProgram, Over};
use stdlib_tasks::gradient_bound;

use crate::binding::Table;
use crate::expr::{Graph, Interval, VectorBound};

/// A ball that contains a vector, with centre and radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    /// Centre.
    pub centre: Vector3<f64>,
    /// Radius; infinite if the vector is unbounded.
    pub radius: f64,
}

/// Context of the analysis, shared by all ranges.
pub(crate) struct RangeContext<'a> {
    /// The graph.
    pub graph: &'a Graph,
    /// Leaves of the robot's state, and captured values.
    pub table: &'a Table,
    /// The robot.
    pub model: &'a Model,
    /// Links whose origins are captured as the position of a task's frame, by the first of the three inputs.
    origins: BTreeMap<usize, LinkId>,
    /// Ball at rest of a position, or range of a distance, for each leaf, by the leaf's first number.
    leaves: BTreeMap<usize, (Ball, Interval)>,
    /// Remaining number of nodes that may be visited.
    left: Cell<usize>,
}

/// Maximum number of visited nodes. A spec written by hand has a few thousand; beyond the limit, nothing is proven.
const EFFORT: usize = 300_000;

/// Ranges of some nodes and of all nodes that they depend on.
pub(crate) struct Ranges<'a> {
    context: &'a RangeContext<'a>,
    known: BTreeMap<usize, Interval>,
    balls: BTreeMap<Vec<usize>, Ball>,
    lengths: BTreeMap<Vec<usize>, Interval>,
}

impl<'a> Ranges<'a> {
    /// Computes the ranges of `roots`. `pins` holds ranges that are known from elsewhere.
    pub fn new(context: &'a RangeContext<'a>, roots: &[usize], pins: &BTreeMap<usize, Interval>) -> Self {
        let mut ranges = Ranges { context, known: BTreeMap::new(), balls: BTreeMap::new(), lengths: BTreeMap::new() };
        for node in context.needed(roots) {
            let range = pins.get(&node).copied().unwrap_or_else(|| ranges.range(node));
            ranges.known.insert(node, range);
        }
        ranges
    }

    /// Returns the range of a node.
    pub fn at(&self, node: usize) -> Interval {
        let constant = || self.context.graph.constant(node).map(Interval::point);
        self.known.get(&node).copied().or_else(constant).unwrap_or(Interval::ALL)
    }

    fn range(&mut self, node: usize) -> Interval {
        let context = self.context;
        let op = context.graph.ops()[node];
        let own = Interval::of(op, |a| self.at(a), |leaf| self.outside(leaf));
        // A bound of a whole vector narrows a number as soon as the ranges of all its operands are known.
        context.graph.bounds_of(node).iter().fold(own, |own, known| {
            let ready = known.bound.operands().all(|n| n < node);
            let Some(k) = known.nodes.iter().position(|n| *n == node).filter(|_| ready) else { return own };
            let own = own.meet(Interval::within(self.known_length(&known.bound).high));
            match self.known_ball(&known.bound) {
                Some(b) if b.radius.is_finite() && known.nodes.len() == 3 => {
                    own.meet(Interval::new(b.centre[k] - b.radius, b.centre[k] + b.radius))
                }
                _ => own,
            }
        })
    }

    /// Range of a node that is not an operation.
    fn outside(&self, leaf: Op) -> Interval {
        match leaf {
            Op::T | Op::Time => Interval::new(0.0, f64::INFINITY),
            Op::Input(k) => self.context.table.captured(k).map_or(Interval::ALL, |node| self.at(node)),
            Op::State(k) => self.context.state(k),
            _ => Interval::ALL,
        }
    }

    /// Ball of a vector of three nodes.
    pub fn ball(&mut self, nodes: &[usize]) -> Ball {
        if let Some(ball) = self.balls.get(nodes) {
            return *ball;
        }
        let parts: Vec<Interval> = nodes.iter().map(|&n| self.at(n)).collect();
        let middle = |i: usize| parts.get(i).map_or(0.0, |p| 0.5 * (p.low + p.high));
        let half = parts.iter().map(|p| (0.5 * (p.high - p.low)).powi(2)).sum::<f64>().sqrt();
        let boxed = Ball { centre: Vector3::from_fn(|i, _| middle(i)), radius: half };
        // Placeholder against endless recursion: a vector plus zero is itself, so bounds can lead back to these nodes.
        self.balls.insert(nodes.to_vec(), Ball { centre: Vector3::zeros(), radius: f64::INFINITY });
        let captured = || self.context.captured_origin(nodes);
        let own = self.context.leaf_of(nodes).map(|(at, _)| self.context.place(at)).or_else(captured);
        let bounds = nodes.first().map_or(&[][..], |&n| self.context.graph.bounds_of(n));
        let known: Vec<VectorBound> = bounds.iter().filter(|k| k.nodes == nodes).map(|k| k.bound.clone()).collect();
        let mut ball = boxed;
        let mut narrow = |other: Ball| {
            if other.radius < ball.radius || !ball.radius.is_finite() {
                ball = other;
            }
        };
        own.into_iter().for_each(&mut narrow);
        for bound in &known {
            self.known_ball(bound).into_iter().for_each(&mut narrow);
            narrow(Ball { centre: Vector3::zeros(), radius: self.known_length(bound).high });
        }
        let ball = if ball.centre.iter().all(|x| x.is_finite()) && ball.radius.is_finite() {
            ball
        } else {
            Ball { centre: Vector3::zeros(), radius: f64::INFINITY }
        };
        self.balls.insert(nodes.to_vec(), ball);
        ball
    }

    /// Ball that follows from a bound.
    fn known_ball(&mut self, bound: &VectorBound) -> Option<Ball> {
        match bound {
            VectorBound::Sum(a, b, sign) => {
                let (a, b) = (self.ball(a), self.ball(b));
                let centre = a.centre + b.centre * *sign;
                Some(Ball { centre, radius: a.radius + b.radius * sign.abs() })
            }
            VectorBound::Scaled(a, by) => {
                let factor = self.context.graph.constant(*by)?;
                let a = self.ball(a);
                Some(Ball { centre: a.centre * factor, radius: a.radius * factor.abs() })
            }
            _ => None,
        }
    }

    /// Range of the length of a vector or quaternion.
    pub fn length(&mut self, nodes: &[usize]) -> Interval {
        if let Some(length) = self.lengths.get(nodes) {
            return *length;
        }
        let root = |f: fn(Interval) -> f64, s: &Self| nodes.iter().map(|&n| f(s.at(n)).powi(2)).sum::<f64>().sqrt();
        let mut length = Interval::new(root(Interval::smallest, self), root(Interval::size, self));
        self.lengths.insert(nodes.to_vec(), Interval::new(0.0, f64::INFINITY));
        if let Some((_, Leaf::Orientation(_))) = self.context.leaf_of(nodes) {
            length = Interval::point(1.0);
        }
        if nodes.len() == 3 {
            let Ball { centre, radius } = self.ball(nodes);
            length = length.meet(Interval::new((centre.norm() - radius).max(0.0), centre.norm() + radius));
        }
        let bounds = nodes.first().map_or(&[][..], |&n| self.context.graph.bounds_of(n));
        for known in bounds.iter().filter(|k| k.nodes == nodes) {
            length = length.meet(self.known_length(&known.bound));
        }
        self.lengths.insert(nodes.to_vec(), length);
        length
    }

    /// Range of the length that follows from a bound.
    fn known_length(&mut self, bound: &VectorBound) -> Interval {
        match bound {
            VectorBound::Sum(a, b, sign) if *sign == -1.0 => match (self.context.point_of(a), self.context.point_of(b))
            {
                // The difference of two points of the robot does not depend on the base or on joints that carry both.
                (Some((to, point)), Some((from, origin))) => {
                    let (centre, radius) = gradient_bound::reach(self.context.model, Some(from), to, &point);
                    let far = (centre - origin).norm();
                    Interval::new((far - radius).max(0.0), far + radius)
                }
                _ => Interval::new(0.0, f64::INFINITY),
            },
            VectorBound::Sum(..) => Interval::new(0.0, f64::INFINITY),
            VectorBound::Scaled(a, by) => {
                let by = self.at(*by);
                self.length(a).by(Interval::new(by.smallest(), by.size()))
            }
            VectorBound::Turned(a) => self.length(a),
            VectorBound::Product(a, b) => self.length(a).by(self.length(b)),
            VectorBound::AtMost(a, b) => Interval::new(0.0, self.length(a).by(self.length(b)).high),
            VectorBound::Direction => Interval::new(0.0, 1.0),
        }
    }
}

/// Range of a safety field for all positions of people. Its function of the distance is monotone: it never decreases.
fn of_field(field: &FieldProgram) -> Interval {
    let chi = field.distance.chi();
    let below = match field.over {
        Over::SoftLeast { sharpness } => (field.points.len() as f64).ln() / sharpness,
        Over::Mean | Over::Least => 0.0,
    };
    let far = if field.distance == DistanceProgram::Identity { f64::INFINITY } else { chi.evaluate(FARTHEST).0 };
    Interval::new(chi.evaluate(0.0).0 - below, far)
}

/// Upper bound of the distance between a person and a robot (m).
const FARTHEST: f64 = 1e6;

/// Captured positions of the frames of tasks.
fn origins(program: &Program) -> BTreeMap<usize, LinkId> {
    let of = |capture: &Capture| {
        let CaptureSource::Task(task, name) = &capture.source else { return None };
        match program.tasks.get(*task)?.params.get("frame")? {
            Bound::Frame(_, link) if name == "position" && capture.len == 3 => Some((capture.at, *link)),
            _ => None,
        }
    };
    program.values.captures.iter().filter_map(of).collect()
}

impl<'a> RangeContext<'a> {
    /// Computes the ranges of all leaves from the parts of a program under construction.
    pub fn new(graph: &'a Graph, table: &'a Table, program: &'a Program) -> Self {
        let model = &program.robot.model;
        let (origins, leaves, left) = (origins(program), BTreeMap::new(), Cell::new(EFFORT));
        let mut context = RangeContext { graph, table, model, origins, leaves, left };
        let one = |(at, leaf): &(usize, Leaf)| {
            let range = match leaf {
                Leaf::Distance(pair) => context.distance(&pair.0, &pair.1),
                _ => Interval::ALL,
            };
            (*at, (context.at_rest(leaf), range))
        };
        context.leaves = table.leaves.iter().map(one).collect();
        context
    }

    /// Returns the nodes that `roots` depend on, including captured ones, in order; empty if the limit of visited nodes
    /// is reached.
    pub fn needed(&self, roots: &[usize]) -> BTreeSet<usize> {
        let (mut open, mut needed) = (roots.to_vec(), BTreeSet::new());
        while let Some(node) = open.pop() {
            let Some(left) = self.left.get().checked_sub(1) else { return BTreeSet::new() };
            self.left.set(left);
            if needed.insert(node) {
                match self.graph.ops()[node] {
                    Op::Input(k) => open.extend(self.table.captured(k)),
                    _ => open.extend(self.graph.reads(node)),
                }
            }
        }
        needed
    }

    /// Returns the leaf of the robot's state whose numbers are exactly these nodes.
    fn leaf_of(&self, nodes: &[usize]) -> Option<(usize, &Leaf)> {
        let state = |n: &usize| match self.graph.ops()[*n] {
            Op::State(k) => Some(k),
            _ => None,
        };
        let first = state(nodes.first()?)?;
        let (at, leaf) = self.table.leaf_of(first)?;
        let whole = at == first && leaf.width() == nodes.len();
        let in_order = nodes.iter().enumerate().all(|(i, n)| state(n) == Some(first + i));
        (whole && in_order).then_some((at, leaf))
    }

    /// Returns the link and the point on it, if these nodes are the position of such a point.
    fn point_of(&self, nodes: &[usize]) -> Option<(LinkId, Vector3<f64>)> {
        match self.leaf_of(nodes)? {
            (_, Leaf::Point { link, offset }) => Some((*link, *offset)),
            _ => None,
        }
    }

    /// Ball of a position that was captured from the origin of a task's frame, if these nodes are one.
    fn captured_origin(&self, nodes: &[usize]) -> Option<Ball> {
        let input = |n: &usize| match self.graph.ops()[*n] {
            Op::Input(k) => Some(k),
            _ => None,
        };
        let first = input(nodes.first()?)?;
        let link = self.origins.get(&first).filter(|_| nodes.len() == 3)?;
        nodes.iter().enumerate().all(|(i, n)| input(n) == Some(first + i)).then(|| self.origin(*link))?
    }

    /// Range of number `k` of the robot's state.
    fn state(&self, k: usize) -> Interval {
        let Some((at, leaf)) = self.table.leaf_of(k) else { return Interval::ALL };
        match leaf {
            Leaf::Joint(dof) => self.model.dofs.get(*dof).map_or(Interval::ALL, |d| Interval::new(d.lower, d.upper)),
            Leaf::Orientation(_) => Interval::within(1.0),
            Leaf::Point { .. } | Leaf::Com => {
                let Some((Ball { centre, radius }, _)) = self.leaves.get(&at) else { return Interval::ALL };
                if self.keeps(leaf, k - at) {
                    Interval::new(centre[k - at] - radius, centre[k - at] + radius)
                } else {
                    Interval::ALL
                }
            }
            Leaf::Distance(_) => self.leaves.get(&at).map_or(Interval::ALL, |l| l.1),
            Leaf::Manipulability(_) => Interval::new(0.0, f64::INFINITY),
            Leaf::PlaneDistance(_) | Leaf::PointDistance(_) => Interval::ALL,
            Leaf::Field(field) => of_field(field),
        }
    }

    /// Ball of the positions of a link's origin in the world; none: its base moves.
    pub fn origin(&self, link: LinkId) -> Option<Ball> {
        self.in_world(&Leaf::Point { link, offset: Vector3::zeros() }).filter(|ball| ball.radius.is_finite())
    }

    /// Ball of the positions of a part in the world, from its middle to its farthest point; none: its base moves.
    pub fn part(&self, part: &Geometry) -> Option<Ball> {
        let middle = Leaf::Point { link: part.link, offset: part.center().coords };
        let ball = self.in_world(&middle)?;
        let radius = ball.radius + part.shape.bounding_radius();
        radius.is_finite().then_some(Ball { radius, ..ball })
    }

    /// Ball of a position in the world, for the leaf whose first number is `at`.
    fn place(&self, at: usize) -> Ball {
        let of_leaf = self.table.leaf_of(at).and_then(|(_, leaf)| self.in_world(leaf));
        of_leaf.unwrap_or(Ball { centre: Vector3::zeros(), radius: f64::INFINITY })
    }

    /// Links with whose bases a position moves.
    fn carriers(&self, leaf: &Leaf) -> Vec<LinkId> {
        match leaf {
            Leaf::Point { link, .. } => vec![*link],
            Leaf::Com => {
                let heavy = self.model.links.iter().enumerate().filter(|(_, link)| link.mass > 0.0);
                heavy.map(|(i, _)| LinkId(i as u32)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Returns true if no base moves a position along an axis of the world: one on wheels keeps its height.
    fn keeps(&self, leaf: &Leaf, axis: usize) -> bool {
        let keeps = |link: &LinkId| {
            self.model.base_of(*link).is_none_or(|base| {
                let up = self.model.place(base).rotation * Vector3::z();
                base.kind.drives() && up[axis].abs() > 1.0 - 1e-12
            })
        };
        self.carriers(leaf).iter().all(keeps)
    }

    /// Ball of a position in the world; none: a base moves it.
    fn in_world(&self, leaf: &Leaf) -> Option<Ball> {
        let stands = self.carriers(leaf).iter().all(|link| self.model.base_of(*link).is_none());
        stands.then(|| self.at_rest(leaf))
    }

    /// Ball of a position while all bases are where their coordinates are zero.
    fn at_rest(&self, leaf: &Leaf) -> Ball {
        let one = |link: LinkId, point: &Vector3<f64>| {
            let base = self.model.base_of(link);
            let (centre, radius) = gradient_bound::reach(self.model, base.map(|base| base.link), link, point);
            let place = base.map_or_else(Isometry3::identity, |base| self.model.place(base));
            Ball { centre: (place * Point3::from(centre)).coords, radius }
        };
        match leaf {
            Leaf::Point { link, offset } => one(*link, offset),
            Leaf::Com => {
                let total: f64 = self.model.links.iter().map(|l| l.mass).sum();
                let heavy = self.model.links.iter().enumerate().filter(|(_, l)| l.mass > 0.0);
                heavy.fold(Ball { centre: Vector3::zeros(), radius: 0.0 }, |sum, (i, l)| {
                    let (share, part) = (l.mass / total, one(LinkId(i as u32), &l.center_of_mass));
                    Ball { centre: sum.centre + part.centre * share, radius: sum.radius + part.radius * share }
                })
            }
            _ => Ball { centre: Vector3::zeros(), radius: f64::INFINITY },
        }
    }

    /// Range of the distance between two parts.
    fn distance(&self, a: &Geometry, b: &Geometry) -> Interval {
        let (centre, radius) = gradient_bound::reach(self.model, Some(b.link), a.link, &a.center().coords);
        let far = (centre - b.center().coords).norm();
        let around = a.shape.bounding_radius() + b.shape.bounding_radius();
        Interval::new(far - radius - around, far + radius + around)
    }
}
