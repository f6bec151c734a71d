//! Manipulability of a frame: the volume of the velocities that its joints give it at unit speed.
//!
//! ```text
//! w = sqrt(det(J J^T)) = |r_1 .. r_m|        with J^T = Q R, R upper triangular, diagonal r_1 .. r_m
//! dw = w tr(J^+ dJ)                           where the rank is full
//!
//! d u_s / dt = a_t × u_s,  d a_s / dt = a_t × a_s       along joint t, if t carries s, or t = s
//! d u_s / dt = a_s × u_t,  d a_s / dt = 0               if s carries t
//! ```
//!
//! J is the geometric Jacobian of the frame's origin, or its linear or angular half, with a column `(u_s, a_s)` for each
//! joint: the velocity of the origin and the angular velocity at unit speed. The degrees of freedom of a base are
//! expressed in the base's own axes, so that each of them carries all of them. A joint that mimics another one adds its
//! column to that of its leader.
//!
//! All m rows of dw are sums over the joints: with the dual rows `C = (J^+)^T`, split into `c_s` and `d_s` for the linear
//! and the angular half of column s,
//!
//! ```text
//! dw/dt = w (a_t · sum_{s carried by t} (u_s × c_s + a_s × d_s) + u_t · sum_{s carries t} (c_s × a_s))
//! ```
//!
//! Orthogonalising the rows of J, the one with the largest remainder first, loses half as many digits as `det(J J^T)`.
//! If J loses rank, w has no derivative, as `|x|` at zero: there w is 0, and its row is zero.
//!
//! Source: Yoshikawa, Manipulability of robotic mechanisms, IJRR 4(2), 1985, (9); the derivative of the Jacobian as in
//! Haviland, Corke, A systematic approach to computing the manipulator Jacobian and Hessian using the elementary
//! transform sequence (2020), sec. 4; the sums over chains are ours.

use nalgebra::Vector3;
use robot::{Data, LinkId, Model};
use serde::{Deserialize, Serialize};

/// Remainder of a row, relative to the row, that counts as rounding error.
const ROUNDING: f64 = 1e-12;

/// Velocities of a frame that count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionPart {
    /// Those of its origin and of its axes: six.
    Whole,
    /// Those of its origin: three.
    Linear,
    /// Those of its axes: three.
    Angular,
}

impl MotionPart {
    /// First and last row of the geometric Jacobian, the latter excluded.
    fn rows(self) -> std::ops::Range<usize> {
        match self {
            MotionPart::Whole => 0..6,
            MotionPart::Linear => 0..3,
            MotionPart::Angular => 3..6,
        }
    }

    /// Number of velocities.
    pub fn size(self) -> usize {
        self.rows().len()
    }
}

/// A frame, and the joints whose motion counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manipulability {
    /// The frame.
    pub link: LinkId,
    /// Its velocities that count.
    pub part: MotionPart,
    /// Degrees of freedom that count, ascending; those that do not move the frame have no effect.
    pub dofs: Vec<usize>,
}

impl Manipulability {
    /// Checks that link and degrees of freedom exist.
    pub(super) fn check(&self, model: &Model) -> Result<(), &'static str> {
        let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
        ensure(self.link.index() < model.links.len(), "a frame does not exist")?;
        ensure(self.dofs.is_sorted_by(|a, b| a < b), "joints of a manipulability are not in order")?;
        ensure(self.dofs.last().is_none_or(|&dof| dof < model.nv()), "a joint does not exist")
    }

    /// Its value, in m³ or, for the axes alone, as a number; a joint that slides by 1 m counts as one that turns by 1 rad.
    pub fn value(&self, model: &Model, data: &Data) -> f64 {
        let mut ready = Ready::new(self, model);
        ready.find(model, data);
        ready.value
    }
}

/// A column of the geometric Jacobian.
#[derive(Clone, Copy, Debug)]
struct Column {
    /// Index of its degree of freedom among those that count; none if it does not count.
    counted: Option<usize>,
    /// Velocity of the origin, in m/s at unit speed.
    linear: Vector3<f64>,
    /// Angular velocity, in rad/s at unit speed.
    angular: Vector3<f64>,
    /// Derivative of the value along the joint.
    slope: f64,
}

/// Leaf with its storage.
#[derive(Clone, Debug)]
pub(super) struct Ready {
    link: LinkId,
    part: MotionPart,
    /// Number of degrees of freedom that count and move the frame.
    width: usize,
    /// Columns of the joints that move the frame, from the root outwards.
    columns: Vec<Column>,
    /// Number of columns of the base.
    base: usize,
    /// Rows of J, orthogonal after the decomposition, in the end the dual rows; `width` numbers each.
    rows: Vec<f64>,
    /// Row of the Jacobian that each of them is.
    order: [usize; 6],
    /// The value.
    pub(super) value: f64,
    /// Magnitude of the terms of which the slopes are sums.
    size: f64,
}

impl Ready {
    /// Prepares the leaf. All memory is allocated here.
    pub(super) fn new(of: &Manipulability, model: &Model) -> Ready {
        let support = model.support(of.link);
        let moves = |dof: &&usize| support.iter().any(|s| s.dof as usize == **dof);
        let counted: Vec<usize> = of.dofs.iter().filter(moves).copied().collect();
        let column = |dof: usize| Column {
            counted: counted.iter().position(|&c| c == dof),
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
            slope: 0.0,
        };
        Ready {
            link: of.link,
            part: of.part,
            width: counted.len(),
            columns: support.iter().map(|s| column(s.dof as usize)).collect(),
            base: model.base_of(of.link).map_or(0, |base| base.kind.nv()),
            rows: vec![0.0; of.part.size() * counted.len()],
            order: [0; 6],
            value: 0.0,
            size: 0.0,
        }
    }

    /// Computes value and slopes at this tick. Allocates nothing.
    pub(super) fn find(&mut self, model: &Model, data: &Data) {
        self.read(model, data);
        self.columns.iter_mut().for_each(|c| c.slope = 0.0);
        (self.value, self.size) = (0.0, 0.0);
        let Some(volume) = self.decompose() else { return };
        self.value = volume;
        self.slopes(data.position(self.link).norm());
    }

    /// Reads the columns, and makes the rows of J of them.
    fn read(&mut self, model: &Model, data: &Data) {
        let p = data.position(self.link);
        self.rows.fill(0.0);
        let range = self.part.rows();
        for (column, s) in self.columns.iter_mut().zip(model.support(self.link)) {
            let motion = &data.columns()[s.column as usize];
            column.angular = motion.angular;
            column.linear = motion.linear + motion.angular.cross(p);
            if let Some(k) = column.counted {
                for (i, row) in range.clone().enumerate() {
                    let x = if row < 3 { column.linear[row] } else { column.angular[row - 3] };
                    self.rows[i * self.width + k] += x;
                }
            }
        }
    }

    /// Orthogonalises the rows by Gram and Schmidt, twice each, and replaces them by the dual rows. Returns the volume;
    /// `None` if the rank is not full.
    fn decompose(&mut self) -> Option<f64> {
        let (m, n) = (self.part.size(), self.width);
        if n < m {
            return None;
        }
        let mut r = [[0.0; 6]; 6];
        let mut lengths = [0.0; 6];
        let mut volume = 1.0;
        for (i, length) in lengths.iter_mut().enumerate().take(m) {
            self.order[i] = i;
            *length = self.dot(i, i).sqrt();
        }
        for i in 0..m {
            // The row with the largest remainder, relative to its own length, comes next.
            let share = |this: &Ready, k: usize| this.dot(k, k) / (lengths[k] * lengths[k]).max(f64::MIN_POSITIVE);
            let mut best = i;
            for k in i + 1..m {
                if share(self, k) > share(self, best) {
                    best = k;
                }
            }
            if best != i {
                self.order.swap(i, best);
                lengths.swap(i, best);
                r.iter_mut().for_each(|row| row.swap(i, best));
                for k in 0..n {
                    self.rows.swap(i * n + k, best * n + k);
                }
            }
            // The remainder lost digits when the earlier rows were taken out; once more restores orthogonality.
            for (j, of_earlier) in r.iter_mut().enumerate().take(i) {
                let share = self.dot(j, i);
                of_earlier[i] += share;
                self.subtract(i, j, share);
            }
            let length = self.dot(i, i).sqrt();
            if length <= ROUNDING * lengths[i] {
                return None;
            }
            r[i][i] = length;
            volume *= length;
            self.rows[i * n..(i + 1) * n].iter_mut().for_each(|x| *x /= length);
            for (k, share) in r[i].iter_mut().enumerate().take(m).skip(i + 1) {
                *share = self.dot(i, k);
                self.subtract(k, i, *share);
            }
        }
        // R C = Q, from the last row upwards.
        for i in (0..m).rev() {
            for (j, share) in r[i].iter().enumerate().take(m).skip(i + 1) {
                self.subtract(i, j, *share);
            }
            self.rows[i * n..(i + 1) * n].iter_mut().for_each(|x| *x /= r[i][i]);
        }
        Some(volume)
    }

    /// Product of two rows.
    fn dot(&self, i: usize, k: usize) -> f64 {
        let n = self.width;
        self.rows[i * n..(i + 1) * n].iter().zip(&self.rows[k * n..(k + 1) * n]).map(|(a, b)| a * b).sum()
    }

    /// Subtracts `share` times row `from` from row `i`.
    fn subtract(&mut self, i: usize, from: usize, share: f64) {
        let n = self.width;
        for k in 0..n {
            self.rows[i * n + k] -= share * self.rows[from * n + k];
        }
    }

    /// Halves of the dual column of a joint, zero if it does not count.
    fn dual(&self, column: &Column) -> [Vector3<f64>; 2] {
        let mut halves = [Vector3::zeros(); 2];
        let first = self.part.rows().start;
        if let Some(k) = column.counted {
            for i in 0..self.part.size() {
                let row = first + self.order[i];
                halves[row / 3][row % 3] = self.rows[i * self.width + k];
            }
        }
        halves
    }

    /// Computes the slopes from the dual rows; the origin is `far` from that of the world, in m.
    fn slopes(&mut self, far: f64) {
        // First what each joint carries, from the tip inwards, then what carries it, from the root outwards.
        let (mut carried, mut amount) = (Vector3::zeros(), 0.0);
        for s in (0..self.columns.len()).rev() {
            let column = self.columns[s];
            let [c, d] = self.dual(&column);
            carried += column.linear.cross(&c) + column.angular.cross(&d);
            amount += column.linear.norm() * c.norm() + column.angular.norm() * d.norm();
            self.columns[s].slope = column.angular.dot(&carried);
        }
        for s in 0..self.base.min(self.columns.len()) {
            self.columns[s].slope = self.columns[s].angular.dot(&carried);
        }
        let mut carries = Vector3::zeros();
        for s in 0..self.columns.len() {
            let column = self.columns[s];
            if s >= self.base {
                self.columns[s].slope += column.linear.dot(&carries);
            }
            let [c, _] = self.dual(&column);
            carries += c.cross(&column.angular);
            amount += column.linear.norm() * c.norm() * column.angular.norm();
            self.columns[s].slope *= self.value;
        }
        self.size = self.value * amount * (1.0 + far);
    }

    /// Adds its row for the adjoint `g`. Returns the magnitude of the terms that were summed.
    pub(super) fn add_row(&self, model: &Model, g: f64, row: &mut [f64]) -> f64 {
        for (column, s) in self.columns.iter().zip(model.support(self.link)) {
            row[s.dof as usize] += g * column.slope;
        }
        g.abs() * self.size
    }
}
