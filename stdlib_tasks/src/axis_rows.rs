//! Rows that pull a frame along chosen axes only, each with a weight of its own.
//!
//! ```text
//! e_i = n_i·(p_d - p)                                                              [m]
//! e_i = n_i·φ,  φ = log(R_d R^T)                                                   [rad]
//! e_i' = -K e_i                                                                    for each chosen axis
//!
//! n_i·J_p v - ω_A·(n_i × (p_d - p))        = n_i·p_d' + K e_i                      positions
//! (J_l(φ)^-1 n_i)·ω - ω_A·(n_i × φ)        = (J_l(φ)^-T n_i)·ω_d + K e_i           orientations
//! ```
//!
//! with the axes `n_i` in the world, and `ω_A` the angular velocity of the frame that carries them, which is zero for the
//! world's. Both terms are those of the exact derivative: a free component of the error, however large, does not disturb
//! a chosen one. Source: thesis (2.5) for the components of the error; `J_l` as in Solà, Deray, Atchuthan, A micro Lie
//! theory (2018), (145), (146).

use nalgebra::Vector3;
use quantities::Quantity;
use robot::LinkId;

use crate::bound::Bound;
use crate::clik::{self, OrientationTarget, PositionTarget};
use crate::dimension::NONE;
use crate::params::{FromBound, Input};
use crate::so3;
use crate::state::{Rows, State};
use crate::task::{Context, RowInfo};

/// Names of the axes, in order.
pub const AXES: &[&str] = &["x", "y", "z"];

/// Weight of an axis.
pub const AXIS_WEIGHT: Quantity = Quantity::above(NONE, 0.0).usually(1e-6, 1e6).constant();

/// Chosen axes among x, y and z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes(pub [bool; 3]);

impl Axes {
    /// Names of the chosen axes.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + use<> {
        let chosen = self.0;
        AXES.iter().zip(chosen).filter(|(_, chosen)| *chosen).map(|(name, _)| *name)
    }
}

impl FromBound for Axes {
    fn from_bound(bound: Option<&Bound>) -> Option<Self> {
        match bound {
            Some(Bound::Axes(chosen)) if chosen.contains(&true) => Some(Axes(*chosen)),
            _ => None,
        }
    }
}

/// Rows of the chosen axes of a position or an orientation.
#[derive(Clone, Debug)]
pub struct AxisRows {
    /// Chosen axes, ascending.
    chosen: Vec<usize>,
    /// Link whose axes these are; the world's without one.
    of: Option<LinkId>,
    /// Weights of the three axes, if any are written.
    weights: Option<[f64; 3]>,
}

impl AxisRows {
    /// All three axes of the world if nothing is written. All memory is allocated here.
    pub fn new(axes: Option<Axes>, of: Option<LinkId>, weights: Option<Input<3>>, ctx: &Context) -> AxisRows {
        let Axes(chosen) = axes.unwrap_or(Axes([true; 3]));
        AxisRows { chosen: (0..3).filter(|&i| chosen[i]).collect(), of, weights: weights.map(|w| w.of(ctx.values)) }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.chosen.len()
    }

    /// True if no axis is chosen, which a bound parameter excludes.
    pub fn is_empty(&self) -> bool {
        self.chosen.is_empty()
    }

    /// Rows of the chosen axes among those of all three.
    pub fn of_all(&self, all: &[RowInfo]) -> Vec<RowInfo> {
        self.chosen.iter().filter_map(|&i| all.get(i).cloned()).collect()
    }

    /// True if weights are written.
    pub fn weighted(&self) -> bool {
        self.weights.is_some()
    }

    /// Weight of each row.
    pub fn weights(&self) -> Vec<f64> {
        self.chosen.iter().map(|&i| self.weights.map_or(1.0, |w| w[i])).collect()
    }

    /// True if the rows are those of the whole error, in the world's axes and without weights.
    fn whole(&self) -> bool {
        self.len() == 3 && self.of.is_none() && self.weights.is_none()
    }

    /// Axis `i` in the world.
    fn axis(&self, state: &State, i: usize) -> Vector3<f64> {
        match self.of {
            Some(link) => state.data.rotation(link).column(i).into(),
            None => Vector3::ith(i, 1.0),
        }
    }

    /// Adds the part of a row that comes from the motion of the axes, for the axis `n` and the whole error.
    fn add_turning(&self, state: &State, n: &Vector3<f64>, error: &Vector3<f64>, row: &mut [f64]) {
        if let Some(link) = self.of {
            state.data.add_angular(state.model, link, &error.cross(n), row);
        }
    }

    /// Writes the rows of a frame's position from `first` on; returns the norm in m of the chosen components of the
    /// error. `gain` is in 1/s.
    pub fn position(
        &self,
        state: &State,
        rows: &mut Rows,
        first: usize,
        link: LinkId,
        target: &PositionTarget,
        gain: f64,
    ) -> f64 {
        if self.whole() {
            return clik::position(state, rows, first, link, target, gain);
        }
        let p = state.data.pose(link).translation.vector;
        let error = target.position - p;
        let mut squares = 0.0;
        for (k, &i) in self.chosen.iter().enumerate() {
            let n = self.axis(state, i);
            let e = n.dot(&error);
            let row = rows.row(first + k);
            state.data.add_point(state.model, link, &p, &n, row);
            self.add_turning(state, &n, &error, row);
            rows.equal(first + k, n.dot(&target.velocity) + gain * e);
            squares += e * e;
        }
        squares.sqrt()
    }

    /// Writes the rows of a frame's orientation from `first` on; returns the norm in rad of the chosen components of the
    /// error. `gain` is in 1/s.
    pub fn orientation(
        &self,
        state: &State,
        rows: &mut Rows,
        first: usize,
        link: LinkId,
        target: &OrientationTarget,
        gain: f64,
    ) -> f64 {
        if self.whole() {
            return clik::orientation(state, rows, first, link, target, gain);
        }
        let error = so3::log(&(target.orientation * state.data.pose(link).rotation.inverse()));
        let inverse = so3::left_jacobian_inverse(&error);
        let mut squares = 0.0;
        for (k, &i) in self.chosen.iter().enumerate() {
            let n = self.axis(state, i);
            let e = n.dot(&error);
            let row = rows.row(first + k);
            state.data.add_angular(state.model, link, &(inverse * n), row);
            self.add_turning(state, &n, &error, row);
            rows.equal(first + k, (inverse.tr_mul(&n)).dot(&target.angular_velocity) + gain * e);
            squares += e * e;
        }
        squares.sqrt()
    }
}
