//! Graph of operations on numbers: equal nodes are shared, constants folded, and time derivatives are exact.

use std::collections::{BTreeMap, BTreeSet};

use runtime::program::{Op, Shape, TrajectoryProgram};

use super::vector_bounds::{Known, VectorBound};

/// The graph. Nodes are indices of operations; operands precede their users.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    ops: Vec<Op>,
    /// For each operation, true if it depends on the robot's state.
    state: Vec<bool>,
    known: BTreeMap<(u8, u64, usize, usize), usize>,
    rates: BTreeMap<usize, usize>,
    /// Numbers of the table of signals with a rate, mapped to the number of the rate.
    moving: BTreeMap<usize, usize>,
    /// Bounds of several nodes as a whole, by each of the nodes.
    bounds: BTreeMap<usize, Vec<Known>>,
    /// Trajectories; their inputs are nodes.
    trajectories: Vec<TrajectoryProgram>,
    /// Nodes that numbers of the robot's state depend on, as in safety fields.
    reading: BTreeMap<usize, Vec<usize>>,
}

/// Maximum number of bounds per node.
const MAX_BOUNDS: usize = 8;

fn key(op: Op) -> (u8, u64, usize, usize) {
    match op {
        Op::Const(x) => (0, x.to_bits(), 0, 0),
        Op::T => (1, 0, 0, 0),
        Op::Time => (2, 0, 0, 0),
        Op::Input(k) => (3, 0, k, 0),
        Op::Add(a, b) => (4, 0, a.min(b), a.max(b)),
        Op::Sub(a, b) => (5, 0, a, b),
        Op::Mul(a, b) => (6, 0, a.min(b), a.max(b)),
        Op::Div(a, b) => (7, 0, a, b),
        Op::Neg(a) => (8, 0, a, 0),
        Op::Sin(a) => (9, 0, a, 0),
        Op::Cos(a) => (10, 0, a, 0),
        Op::Exp(a) => (11, 0, a, 0),
        Op::Log(a) => (12, 0, a, 0),
        Op::Sqrt(a) => (13, 0, a, 0),
        Op::Abs(a) => (14, 0, a, 0),
        Op::Powi(a, n) => (15, n as u32 as u64, a, 0),
        Op::Min(a, b) => (16, 0, a, b),
        Op::Max(a, b) => (17, 0, a, b),
        Op::Select(a, b, c) => (18, a as u64, b, c),
        Op::State(k) => (19, 0, k, 0),
        Op::Asin(a) => (20, 0, a, 0),
        Op::Acos(a) => (21, 0, a, 0),
        Op::Atan2(a, b) => (22, 0, a, b),
        Op::Less(a, b) => (23, 0, a, b),
        Op::LessEqual(a, b) => (24, 0, a, b),
        Op::Signal(k) => (25, 0, k, 0),
        Op::Trajectory(k) => (26, 0, k, 0),
    }
}

impl Graph {
    /// All operations.
    pub fn ops(&self) -> &[Op] {
        &self.ops
    }

    /// Value of a constant node.
    pub fn constant(&self, node: usize) -> Option<f64> {
        match self.ops[node] {
            Op::Const(x) => Some(x),
            _ => None,
        }
    }

    /// Adds a number of the table of signals; `rate` is the number of its time derivative in that table.
    pub fn moving_signal(&mut self, number: usize, rate: usize) -> usize {
        self.moving.insert(number, rate);
        self.push(Op::Signal(number))
    }

    /// Adds a number of the robot's state that depends on some nodes.
    pub fn reading_state(&mut self, number: usize, nodes: Vec<usize>) -> usize {
        self.reading.insert(number, nodes);
        self.push(Op::State(number))
    }

    /// True if a node depends on the robot's current state.
    pub fn is_state(&self, node: usize) -> bool {
        self.state[node]
    }

    /// Adds a constant.
    pub fn number(&mut self, x: f64) -> usize {
        self.push(Op::Const(x))
    }

    /// Adds an operation, or returns an existing or simpler equal node.
    pub fn push(&mut self, op: Op) -> usize {
        let op = match self.simplify(op) {
            Ok(op) => op,
            Err(node) => return node,
        };
        let k = key(op);
        if let Some(&node) = self.known.get(&k) {
            return node;
        }
        let operands = op.operands();
        self.state.push(matches!(op, Op::State(_)) || operands.iter().flatten().any(|&o| self.state[o]));
        self.ops.push(op);
        let node = self.ops.len() - 1;
        self.known.insert(k, node);
        node
    }

    /// Simplifies an operation, or returns the node that it is equal to.
    fn simplify(&mut self, op: Op) -> Result<Op, usize> {
        let c = |node: usize| self.constant(node);
        if let Op::Select(a, x, y) = op
            && let Some(a) = c(a).filter(|a| !a.is_nan())
        {
            return Err(if a >= 0.0 { x } else { y });
        }
        let operands = op.operands();
        let constant = operands[0].is_some() && operands.iter().flatten().all(|&o| c(o).is_some());
        let folded = constant.then(|| op.value(|a| c(a).unwrap_or(f64::NAN), |_| f64::NAN));
        if let Some(x) = folded {
            return Ok(Op::Const(x));
        }
        match op {
            Op::Add(a, b) if c(a) == Some(0.0) => Err(b),
            Op::Add(a, b) | Op::Sub(a, b) if c(b) == Some(0.0) => Err(a),
            Op::Sub(a, b) if c(a) == Some(0.0) => Ok(Op::Neg(b)),
            Op::Mul(a, b) if c(a) == Some(1.0) => Err(b),
            Op::Mul(a, b) | Op::Div(a, b) if c(b) == Some(1.0) => Err(a),
            Op::Mul(a, b) if c(a) == Some(0.0) || c(b) == Some(0.0) => Ok(Op::Const(0.0)),
            Op::Div(a, _) if c(a) == Some(0.0) => Ok(Op::Const(0.0)),
            Op::Powi(_, 0) => Ok(Op::Const(1.0)),
            Op::Powi(a, 1) => Err(a),
            Op::Select(_, x, y) if x == y => Err(x),
            _ => Ok(op),
        }
    }

    /// Stores a bound of some nodes as a whole.
    pub fn note(&mut self, nodes: &[usize], bound: VectorBound) {
        let known = Known { nodes: nodes.to_vec(), bound };
        for &node in nodes {
            if self.constant(node).is_some() {
                continue;
            }
            let all = self.bounds.entry(node).or_default();
            if all.len() < MAX_BOUNDS && !all.contains(&known) {
                all.push(known.clone());
            }
        }
    }

    /// Bounds of a node together with others.
    pub fn bounds_of(&self, node: usize) -> &[Known] {
        self.bounds.get(&node).map_or(&[], Vec::as_slice)
    }

    /// Returns the time derivative of a node. At a point where a function is not differentiable (the edge of a `min`,
    /// `abs` at zero), it is the derivative of the branch that determines the value.
    pub fn rate(&mut self, node: usize) -> usize {
        if let Some(&r) = self.rates.get(&node) {
            return r;
        }
        // Operands come first in ascending order, so the derivatives are computed without deep recursion.
        let (mut left, mut needed) = (vec![node], BTreeSet::new());
        while let Some(i) = left.pop() {
            if !self.rates.contains_key(&i) && needed.insert(i) {
                left.extend(self.ops[i].operands().into_iter().flatten());
            }
        }
        for i in needed {
            let r = self.rate_of(i);
            self.rates.insert(i, r);
        }
        self.rates[&node]
    }

    fn rate_of(&mut self, node: usize) -> usize {
        let d = |g: &Self, n: usize| g.rates[&n];
        match self.ops[node] {
            Op::Signal(k) if self.moving.contains_key(&k) => self.push(Op::Signal(self.moving[&k])),
            Op::Const(_) | Op::Input(_) | Op::State(_) | Op::Signal(_) | Op::Less(..) | Op::LessEqual(..) => {
                self.number(0.0)
            }
            Op::T | Op::Time => self.number(1.0),
            Op::Trajectory(k) => match self.trajectory_of(k).map(|t| (k - t.at, t.shape.width())) {
                Some((part, width)) if part < width => self.push(Op::Trajectory(k + width)),
                _ => self.number(0.0),
            },
            Op::Add(a, b) => {
                let (da, db) = (d(self, a), d(self, b));
                self.push(Op::Add(da, db))
            }
            Op::Sub(a, b) => {
                let (da, db) = (d(self, a), d(self, b));
                self.push(Op::Sub(da, db))
            }
            Op::Mul(a, b) => {
                let (da, db) = (d(self, a), d(self, b));
                let (left, right) = (self.push(Op::Mul(da, b)), self.push(Op::Mul(a, db)));
                self.push(Op::Add(left, right))
            }
            Op::Div(a, b) => {
                // (a' - (a/b) b') / b
                let (da, db) = (d(self, a), d(self, b));
                let part = self.push(Op::Mul(node, db));
                let top = self.push(Op::Sub(da, part));
                self.push(Op::Div(top, b))
            }
            Op::Neg(a) => {
                let da = d(self, a);
                self.push(Op::Neg(da))
            }
            Op::Sin(a) => {
                let (da, cos) = (d(self, a), self.push(Op::Cos(a)));
                self.push(Op::Mul(cos, da))
            }
            Op::Cos(a) => {
                let (da, sin) = (d(self, a), self.push(Op::Sin(a)));
                let product = self.push(Op::Mul(sin, da));
                self.push(Op::Neg(product))
            }
            Op::Exp(a) => {
                let da = d(self, a);
                self.push(Op::Mul(node, da))
            }
            Op::Log(a) => {
                let da = d(self, a);
                self.push(Op::Div(da, a))
            }
            Op::Asin(a) => self.arc_rate(a),
            Op::Acos(a) => {
                let rate = self.arc_rate(a);
                self.push(Op::Neg(rate))
            }
            Op::Atan2(y, x) => {
                let (dy, dx) = (d(self, y), d(self, x));
                let (left, right) = (self.push(Op::Mul(x, dy)), self.push(Op::Mul(y, dx)));
                let top = self.push(Op::Sub(left, right));
                let (xx, yy) = (self.push(Op::Mul(x, x)), self.push(Op::Mul(y, y)));
                let square = self.push(Op::Add(xx, yy));
                let rate = self.push(Op::Div(top, square));
                self.zero_unless_positive(square, rate)
            }
            Op::Sqrt(a) => {
                // A constant argument has the rate zero, also if the root is zero.
                let da = d(self, a);
                let twice = self.push(Op::Add(node, node));
                let rate = self.push(Op::Div(da, twice));
                let speed = self.push(Op::Abs(da));
                self.zero_unless_positive(speed, rate)
            }
            Op::Abs(a) => {
                let da = d(self, a);
                let minus = self.push(Op::Neg(da));
                self.push(Op::Select(a, da, minus))
            }
            Op::Powi(a, n) => {
                let da = d(self, a);
                let (power, factor) = (self.push(Op::Powi(a, n - 1)), self.number(f64::from(n)));
                let outer = self.push(Op::Mul(factor, power));
                self.push(Op::Mul(outer, da))
            }
            Op::Min(a, b) => self.rate_of_choice(a, b, b, a),
            Op::Max(a, b) => self.rate_of_choice(a, b, a, b),
            Op::Select(a, b, c) => {
                let (db, dc) = (d(self, b), d(self, c));
                self.push(Op::Select(a, db, dc))
            }
        }
    }

    /// `a' / sqrt(1 - a²)`, and zero if that is infinite.
    fn arc_rate(&mut self, a: usize) -> usize {
        let da = self.rates[&a];
        let (one, square) = (self.number(1.0), self.push(Op::Mul(a, a)));
        let rest = self.push(Op::Sub(one, square));
        let root = self.push(Op::Sqrt(rest));
        let rate = self.push(Op::Div(da, root));
        self.zero_unless_positive(rest, rate)
    }

    /// `if test > 0 then node else 0`.
    pub fn zero_unless_positive(&mut self, test: usize, node: usize) -> usize {
        let (minus, zero) = (self.push(Op::Neg(test)), self.number(0.0));
        self.push(Op::Select(minus, zero, node))
    }

    /// Rate of `a` if `over - under >= 0`, else rate of `b`.
    fn rate_of_choice(&mut self, a: usize, b: usize, over: usize, under: usize) -> usize {
        let (da, db) = (self.rates[&a], self.rates[&b]);
        let test = self.push(Op::Sub(over, under));
        self.push(Op::Select(test, da, db))
    }

    /// Adds a trajectory, or finds an equal one; sets its first number and returns the nodes of its value.
    pub fn trajectory(&mut self, mut program: TrajectoryProgram) -> Vec<usize> {
        let known = self.trajectories.iter().find(|t| TrajectoryProgram { at: t.at, ..program.clone() } == **t);
        program.at =
            known.or(self.trajectories.last()).map_or(0, |t| if known.is_some() { t.at } else { t.numbers().end });
        let (numbers, width) = (program.numbers(), program.shape.width());
        if known.is_none() {
            self.trajectories.push(program);
        }
        // Pushed now, so that these nodes come after all inputs of the trajectory.
        let nodes: Vec<usize> = numbers.map(|k| self.push(Op::Trajectory(k))).collect();
        nodes.into_iter().take(width).collect()
    }

    /// The same angle on the circle: trajectories among its summands move to their goals by the nearest turn.
    pub fn by_nearest_turn(&mut self, node: usize) -> usize {
        let (mut summands, mut open) = (BTreeSet::new(), vec![node]);
        while let Some(node) = open.pop() {
            let sum = matches!(self.ops[node], Op::Neg(_) | Op::Add(..) | Op::Sub(..));
            if summands.insert(node) && sum {
                open.extend(self.ops[node].operands().into_iter().flatten());
            }
        }
        // Operands come first in ascending order.
        let mut near: BTreeMap<usize, usize> = BTreeMap::new();
        for node in summands {
            let found = match self.ops[node] {
                Op::Trajectory(k) => {
                    let own = self.trajectory_of(k).filter(|t| t.at == k && t.shape == Shape::Number).cloned();
                    let turned = own.map(|t| self.trajectory(TrajectoryProgram { turn: true, ..t }));
                    turned.and_then(|nodes| nodes.first().copied()).unwrap_or(node)
                }
                op @ (Op::Neg(_) | Op::Add(..) | Op::Sub(..)) => {
                    self.push(op.renumber(|o| near.get(&o).copied().unwrap_or(o)))
                }
                _ => node,
            };
            near.insert(node, found);
        }
        near.get(&node).copied().unwrap_or(node)
    }

    /// Trajectories; their inputs are nodes.
    pub fn trajectories(&self) -> &[TrajectoryProgram] {
        &self.trajectories
    }

    /// Trajectory that computes a number.
    pub fn trajectory_of(&self, number: usize) -> Option<&TrajectoryProgram> {
        self.trajectories.iter().find(|t| t.numbers().contains(&number))
    }

    /// Final value of some nodes: the goal, if they are the value of a trajectory, else the nodes themselves.
    pub fn goal(&self, nodes: &[usize]) -> Vec<usize> {
        let Some(Op::Trajectory(first)) = nodes.first().map(|&n| self.ops[n]) else { return nodes.to_vec() };
        let in_order = nodes.iter().enumerate().all(|(i, &n)| self.ops[n] == Op::Trajectory(first + i));
        let whole = self.trajectory_of(first).filter(|t| in_order && t.at == first && t.shape.width() == nodes.len());
        whole.map_or_else(|| nodes.to_vec(), |t| self.goal(&t.goals[t.goals.len() - nodes.len()..]))
    }

    /// Nodes that a node depends on directly.
    pub fn reads(&self, node: usize) -> Vec<usize> {
        let op = self.ops[node];
        let moved = match op {
            Op::Trajectory(k) => self.trajectory_of(k),
            _ => None,
        };
        let read = match op {
            Op::State(k) => self.reading.get(&k).map_or(&[][..], Vec::as_slice),
            _ => &[],
        };
        let moved = moved.into_iter().flat_map(TrajectoryProgram::inputs);
        op.operands().into_iter().flatten().chain(moved).chain(read.iter().copied()).collect()
    }

    /// True if one of the nodes depends on a trajectory.
    pub fn moves_along(&self, roots: &[usize]) -> bool {
        !self.trajectories.is_empty() && self.extract(roots).0.iter().any(|op| matches!(op, Op::Trajectory(_)))
    }

    /// Extracts the operations that the given nodes need, in order, with the new index of each old one.
    pub fn extract(&self, roots: &[usize]) -> (Vec<Op>, BTreeMap<usize, usize>) {
        let mut needed = vec![false; self.ops.len()];
        for &r in roots {
            needed[r] = true;
        }
        for i in (0..self.ops.len()).rev() {
            if needed[i] {
                for o in self.reads(i) {
                    needed[o] = true;
                }
            }
        }
        let (mut ops, mut index) = (Vec::new(), BTreeMap::new());
        for (i, op) in self.ops.iter().enumerate().filter(|(i, _)| needed[*i]) {
            ops.push(op.renumber(|a| index[&a]));
            index.insert(i, ops.len() - 1);
        }
        (ops, index)
    }
}
