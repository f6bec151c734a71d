//! Expression prepared for evaluation, with all memory that its sweeps need.
//!
//! ```text
//! y = f(x(q), u(t))        y' = (df/dx) (dx/dq) v + (df/du) u'
//! ```
//!
//! One reverse sweep over the operations computes `df/dx` and `df/du` of one number. A leaf then writes its part of the
//! row: for a point p with adjoint a, `a·p' = a·(J_p v)`; for an orientation q with adjoint `a = (a_w, a_v)`,
//!
//! ```text
//! q' = (0, ω) q / 2        a·q' = ω · (-a_w v + w a_v + v × a_v) / 2,    q = (w, v)
//! ```
//!
//! A distance contributes its row along the line between the closest points, the centre of mass the rows of the links'
//! centres. A safety field, and the distance to a person, read points that are earlier operations: the reverse sweep
//! propagates the derivatives to these, so that their rates count like those of any input. Source: Griewank, Walther,
//! Evaluating Derivatives (2008), ch. 3; the leaves are ours.

use nalgebra::{Point3, Vector3};
use robot::Model;

use super::center_of_mass::CenterOfMass;
use super::human_field::HumanField;
use super::manipulability;
use super::plane_distance::{Lowest, PlaneDistance};
use super::point_distance;
use super::{Expression, Leaf, Op};
use crate::closest_points::{Pair, Separation, SeparationError};
use crate::numbers::{write_rotation, write_vector};
use crate::state::State;

/// A leaf, with its result at this tick.
#[derive(Clone, Debug)]
enum Found {
    Point { link: robot::LinkId, offset: Point3<f64> },
    Orientation(robot::LinkId),
    Joint { dof: usize, q: usize },
    Distance { pair: Box<Pair>, apart: Option<Separation> },
    PlaneDistance { above: Box<PlaneDistance>, lowest: Option<Lowest> },
    Com(CenterOfMass),
    Manipulability(Box<manipulability::Ready>),
    Field(Box<HumanField>),
    PointDistance(Box<point_distance::Ready>),
}

/// Expression prepared for evaluation. Nothing here allocates after [`Evaluation::new`].
#[derive(Clone, Debug)]
pub struct Evaluation {
    ops: Vec<Op>,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    /// Leaves, each with the index of its first number.
    leaves: Vec<(usize, Found)>,
    /// Leaves that read operations: index of the number, and index of the leaf.
    readers: Vec<(usize, usize)>,
    /// Numbers of the leaves, and the adjoint of each.
    state: Vec<f64>,
    state_adjoints: Vec<f64>,
    registers: Vec<f64>,
    adjoints: Vec<f64>,
    /// Magnitude of the terms of which the last row is the sum.
    size: f64,
}

impl Evaluation {
    /// Prepares an expression that has passed [`Expression::check`] for this robot.
    pub fn new(expression: &Expression, model: &Model) -> Self {
        let mut at = 0;
        let mut leaves = Vec::new();
        for leaf in &expression.leaves {
            let found = match leaf {
                Leaf::Point { link, offset } => Found::Point { link: *link, offset: Point3::from(*offset) },
                Leaf::Orientation(link) => Found::Orientation(*link),
                Leaf::Joint(dof) => {
                    let q = model.dofs.get(*dof).and_then(|d| d.q_index).unwrap_or(0);
                    Found::Joint { dof: *dof, q }
                }
                Leaf::Distance(pair) => {
                    Found::Distance { pair: Box::new(Pair::new(pair.0.clone(), pair.1.clone())), apart: None }
                }
                Leaf::PlaneDistance(above) => Found::PlaneDistance { above: above.clone(), lowest: None },
                Leaf::Com => Found::Com(CenterOfMass::new(model)),
                Leaf::Manipulability(of) => Found::Manipulability(Box::new(manipulability::Ready::new(of, model))),
                Leaf::Field(field) => Found::Field(Box::new(HumanField::new(field, model))),
                Leaf::PointDistance(away) => Found::PointDistance(Box::new(point_distance::Ready::new(away))),
            };
            leaves.push((at, found));
            at += leaf.width();
        }
        let reads = |found: &Found| matches!(found, Found::Field(_) | Found::PointDistance(_));
        let readers = leaves.iter().enumerate().filter(|(_, (_, found))| reads(found));
        Evaluation {
            readers: readers.map(|(i, (at, _))| (*at, i)).collect(),
            ops: expression.ops.clone(),
            inputs: expression.inputs.clone(),
            outputs: expression.outputs.clone(),
            leaves,
            state: vec![0.0; at],
            state_adjoints: vec![0.0; at],
            registers: vec![0.0; expression.ops.len()],
            adjoints: vec![0.0; expression.ops.len()],
            size: 0.0,
        }
    }

    /// Forgets the directions between parts that were last valid.
    pub fn forget(&mut self) {
        for (_, found) in &mut self.leaves {
            match found {
                Found::Distance { pair, apart } => {
                    pair.forget();
                    *apart = None;
                }
                Found::PointDistance(away) => away.forget(),
                _ => {}
            }
        }
    }

    /// Number of numbers in the value.
    pub fn len(&self) -> usize {
        self.outputs.len()
    }

    /// Returns true for a value without a number, which no checked expression has.
    pub fn is_empty(&self) -> bool {
        self.outputs.is_empty()
    }

    /// Forward sweep: computes the value at this tick.
    ///
    /// # Errors
    /// Two parts whose distance is read overlap from the beginning; or a pose is not finite.
    pub fn forward(&mut self, state: &State) -> Result<(), SeparationError> {
        for (at, found) in &mut self.leaves {
            let numbers = &mut self.state[*at..];
            match found {
                Found::Point { link, offset } => write_vector(&(state.data.pose(*link) * *offset).coords, numbers),
                Found::Orientation(link) => write_rotation(&state.data.pose(*link).rotation, numbers),
                Found::Joint { q, .. } => numbers[0] = state.q[*q],
                Found::Distance { pair, apart } => {
                    let now = pair.find(state)?;
                    numbers[0] = now.distance;
                    *apart = Some(now);
                }
                Found::PlaneDistance { above, lowest } => {
                    let now = above.find(state);
                    numbers[0] = now.height;
                    *lowest = Some(now);
                }
                Found::Com(com) => write_vector(&com.position(state.data), numbers),
                Found::Manipulability(of) => {
                    of.find(state.model, state.data);
                    numbers[0] = of.value;
                }
                // Their points are operations, which are evaluated below.
                Found::Field(_) | Found::PointDistance(_) => {}
            }
        }
        for (i, op) in self.ops.iter().enumerate() {
            let (before, rest) = self.registers.split_at_mut(i);
            if let Op::State(k) = *op
                && let Some((_, leaf)) = self.readers.iter().find(|f| f.0 == k)
            {
                match &mut self.leaves[*leaf].1 {
                    Found::Field(people) => self.state[k] = people.find(state, before)?,
                    Found::PointDistance(away) => self.state[k] = away.find(state, before)?,
                    _ => {}
                }
            }
            let leaf = |op: Op| match op {
                Op::Input(k) => state.values[self.inputs[k]],
                Op::State(k) => self.state[k],
                _ => f64::NAN,
            };
            rest[0] = op.value(|a| before[a], leaf);
        }
        Ok(())
    }

    /// Number `i` of the value, after [`Evaluation::forward`].
    pub fn value(&self, i: usize) -> f64 {
        self.registers[self.outputs[i]]
    }

    /// Magnitude of the terms of which the last row is the sum: coefficients far below it are rounding errors.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Reverse sweep, after [`Evaluation::forward`] of the same tick: adds to `row` the coefficients of `v` in the rate
    /// of `sum_i seeds[i] value(i)`, and returns the part of that rate that remains while the robot stands still.
    pub fn add_row(&mut self, state: &State, seeds: &[f64], row: &mut [f64]) -> f64 {
        for (&output, &seed) in self.outputs.iter().zip(seeds) {
            self.adjoints[output] += seed;
        }
        self.state_adjoints.fill(0.0);
        let mut still = 0.0;
        for (i, op) in self.ops.iter().enumerate().rev() {
            let g = std::mem::take(&mut self.adjoints[i]);
            if g == 0.0 {
                continue;
            }
            match *op {
                Op::Input(k) => still += g * state.rates[self.inputs[k]],
                Op::State(k) => {
                    self.state_adjoints[k] += g;
                    if let Some((_, leaf)) = self.readers.iter().find(|f| f.0 == k) {
                        match &self.leaves[*leaf].1 {
                            Found::Field(people) => people.pull(g, &mut self.adjoints[..i]),
                            Found::PointDistance(away) => away.pull(g, &mut self.adjoints[..i]),
                            _ => {}
                        }
                    }
                }
                _ => op.pull(g, self.registers[i], &self.registers[..i], &mut self.adjoints[..i]),
            }
        }
        self.size = 0.0;
        for (at, found) in &self.leaves {
            let (a, x) = (&self.state_adjoints[*at..], &self.state[*at..]);
            match found {
                Found::Point { link, .. } => {
                    let (n, p) = (Vector3::new(a[0], a[1], a[2]), Vector3::new(x[0], x[1], x[2]));
                    self.size += n.norm() * (1.0 + p.norm());
                    state.data.add_point(state.model, *link, &p, &n, row);
                }
                Found::Orientation(link) => {
                    let (a_v, v) = (Vector3::new(a[1], a[2], a[3]), Vector3::new(x[1], x[2], x[3]));
                    let axis = (a_v * x[0] - v * a[0] + v.cross(&a_v)) * 0.5;
                    self.size += a_v.norm() + a[0].abs();
                    state.data.add_angular(state.model, *link, &axis, row);
                }
                Found::Joint { dof, .. } => {
                    self.size += a[0].abs();
                    row[*dof] += a[0];
                }
                Found::Distance { pair, apart } => {
                    if let Some(apart) = apart {
                        self.size += 2.0 * a[0].abs() * (1.0 + apart.on_a.norm());
                        pair.add_row(state, apart, a[0], row);
                    }
                }
                Found::PlaneDistance { above, lowest } => {
                    if let Some(lowest) = lowest {
                        self.size += 2.0 * a[0].abs() * (1.0 + lowest.at.norm());
                        above.add_row(state, lowest, a[0], row);
                    }
                }
                Found::Com(com) => {
                    let (n, p) = (Vector3::new(a[0], a[1], a[2]), Vector3::new(x[0], x[1], x[2]));
                    self.size += n.norm() * (1.0 + p.norm());
                    com.add_row(state, &n, row);
                }
                Found::Manipulability(of) => self.size += of.add_row(state.model, a[0], row),
                Found::Field(people) => self.size += people.add_row(a[0], row),
                Found::PointDistance(away) => self.size += away.add_row(state, a[0], row),
            }
        }
        still
    }
}
