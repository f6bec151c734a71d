//! Results of forward kinematics for one configuration: link poses and motion columns, and the Jacobian rows that are
//! built from them.

use std::fmt;

use nalgebra::{DMatrix, Isometry3, Matrix3, Vector3};

use crate::{LinkId, Model};

/// A unit-speed motion in the world frame, at the WORLD ORIGIN: a body-fixed point `p` has velocity
/// `linear + angular × p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Velocity of the body-fixed point that is currently at the world origin \[m/s per unit\].
    pub linear: Vector3<f64>,
    /// Angular velocity \[rad/s per unit\].
    pub angular: Vector3<f64>,
}

impl Motion {
    /// No motion.
    pub const ZERO: Motion = Motion { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };
}

/// Workspace of [`Model::forward`]. All methods must get the model that the workspace was created for. They do not
/// allocate, except [`Data::new`]. Rows need at least `nv` entries; only those in the support of the link are written.
#[derive(Clone, PartialEq)]
pub struct Data {
    pub(crate) poses: Vec<Isometry3<f64>>,
    pub(crate) rotations: Vec<Matrix3<f64>>,
    pub(crate) columns: Vec<Motion>,
}

impl Data {
    /// Creates a workspace for `model`, evaluated at [`Model::neutral`].
    pub fn new(model: &Model) -> Data {
        let mut data = Data {
            poses: vec![Isometry3::identity(); model.links.len()],
            rotations: vec![Matrix3::identity(); model.links.len()],
            columns: vec![Motion::ZERO; model.tape.columns],
        };
        model.forward(&model.neutral(), &mut data);
        data
    }

    /// Returns the pose of the link's frame in the world, X_WL.
    #[inline]
    pub fn pose(&self, link: LinkId) -> &Isometry3<f64> {
        &self.poses[link.index()]
    }

    /// Returns the rotation matrix of the link's frame, R_WL: the rotation of [`Data::pose`].
    #[inline]
    pub fn rotation(&self, link: LinkId) -> &Matrix3<f64> {
        &self.rotations[link.index()]
    }

    /// Returns the position of the link's origin in the world \[m\].
    #[inline]
    pub fn position(&self, link: LinkId) -> &Vector3<f64> {
        &self.poses[link.index()].translation.vector
    }

    /// Returns the motion columns: those of each base, and one per moving joint, in the order of their links. A mimicking joint has
    /// its own column, scaled by its multiplier.
    #[inline]
    pub fn columns(&self) -> &[Motion] {
        &self.columns
    }

    /// Adds `Sᵀ f` to the row, for a wrench `f` on `link` in world axes with its `moment` about the WORLD ORIGIN. This
    /// is the row of `force·v_0 + moment·ω`, with `v_0` the velocity of the link's point at the world origin.
    #[inline]
    pub fn add_wrench(
        &self,
        model: &Model,
        link: LinkId,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
        row: &mut [f64],
    ) {
        for s in model.support(link) {
            let c = &self.columns[s.column as usize];
            row[s.dof as usize] += c.linear.dot(force) + c.angular.dot(moment);
        }
    }

    /// Adds the row of `n·(dp/dt)` for the point of `link` that is at `p_W` \[m\].
    #[inline]
    pub fn add_point(&self, model: &Model, link: LinkId, p_W: &Vector3<f64>, n_W: &Vector3<f64>, row: &mut [f64]) {
        self.add_wrench(model, link, n_W, &p_W.cross(n_W), row);
    }

    /// Adds the row of `axis·ω`, with ω the angular velocity of `link`.
    #[inline]
    pub fn add_angular(&self, model: &Model, link: LinkId, axis_W: &Vector3<f64>, row: &mut [f64]) {
        for s in model.support(link) {
            row[s.dof as usize] += self.columns[s.column as usize].angular.dot(axis_W);
        }
    }

    /// Returns the spatial velocity of `link` at the world origin for the velocity `v`.
    #[inline]
    pub fn motion(&self, model: &Model, link: LinkId, v: &[f64]) -> Motion {
        let mut sum = Motion::ZERO;
        for s in model.support(link) {
            let c = &self.columns[s.column as usize];
            sum.linear += c.linear * v[s.dof as usize];
            sum.angular += c.angular * v[s.dof as usize];
        }
        sum
    }

    /// Returns the velocity of the point of `link` that is at `p_W` \[m/s\].
    #[inline]
    pub fn point_velocity(&self, model: &Model, link: LinkId, p_W: &Vector3<f64>, v: &[f64]) -> Vector3<f64> {
        let m = self.motion(model, link, v);
        m.linear + m.angular.cross(p_W)
    }

    /// Returns the angular velocity of `link` \[rad/s\].
    #[inline]
    pub fn angular_velocity(&self, model: &Model, link: LinkId, v: &[f64]) -> Vector3<f64> {
        self.motion(model, link, v).angular
    }

    /// Computes the 6×nv Jacobian of the point of `link` at `p_W`, linear rows first, world-aligned (Pinocchio's
    /// LOCAL_WORLD_ALIGNED). `out` must be 6×nv and is overwritten.
    pub fn jacobian(&self, model: &Model, link: LinkId, p_W: &Vector3<f64>, out: &mut DMatrix<f64>) {
        assert_eq!(out.shape(), (6, model.nv()), "Jacobian of another robot");
        out.fill(0.0);
        for s in model.support(link) {
            let c = &self.columns[s.column as usize];
            let linear = c.linear + c.angular.cross(p_W);
            let mut column = out.column_mut(s.dof as usize);
            for i in 0..3 {
                column[i] += linear[i];
                column[i + 3] += c.angular[i];
            }
        }
    }
}

impl fmt::Debug for Data {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Data")
            .field("links", &self.poses.len())
            .field("columns", &self.columns.len())
            .finish_non_exhaustive()
    }
}
