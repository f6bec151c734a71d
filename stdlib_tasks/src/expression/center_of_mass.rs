//! The centre of mass of the whole robot.
//!
//! ```text
//! c = sum_i μ_i p_i        c' = sum_i μ_i J_i v        [m], [m/s]
//! ```
//!
//! with `p_i` the centre of mass of link i in the world, `J_i` the Jacobian of that point, and `μ_i` the link's share
//! of the total mass. Links without a mass are left out.

use nalgebra::{Point3, Vector3};
use robot::{Data, LinkId, Model};

use crate::state::State;

/// Links with a mass, each with its centre in its own frame in m, and its share of the total mass.
#[derive(Clone, Debug)]
pub(crate) struct CenterOfMass(Vec<(LinkId, Point3<f64>, f64)>);

/// Returns true if some link has a mass, so that there is a centre.
pub(crate) fn exists(model: &Model) -> bool {
    model.links.iter().any(|l| l.mass > 0.0)
}

/// Centre of mass of the whole robot in the world, in m; not finite if no link has a mass.
pub fn center_of_mass(model: &Model, data: &Data) -> Vector3<f64> {
    CenterOfMass::new(model).position(data)
}

impl CenterOfMass {
    /// Collects the links with a mass. All memory is allocated here.
    pub fn new(model: &Model) -> Self {
        // Scaled by the largest: a sum of huge numbers is not finite.
        let largest = model.links.iter().fold(0.0_f64, |a, l| a.max(l.mass));
        let sum: f64 = model.links.iter().map(|l| l.mass / largest).sum();
        let with_mass = model.links.iter().enumerate().filter(|(_, l)| l.mass > 0.0);
        let part =
            |(i, l): (usize, &robot::Link)| (LinkId(i as u32), Point3::from(l.center_of_mass), l.mass / largest / sum);
        CenterOfMass(with_mass.map(part).collect())
    }

    /// Position in the world, in m.
    pub fn position(&self, data: &Data) -> Vector3<f64> {
        let part = |(link, center, share): &(LinkId, Point3<f64>, f64)| (data.pose(*link) * center).coords * *share;
        self.0.iter().map(part).sum()
    }

    /// Adds the row of `n·c'`.
    pub fn add_row(&self, state: &State, n: &Vector3<f64>, row: &mut [f64]) {
        for (link, center, share) in &self.0 {
            let p = (state.data.pose(*link) * center).coords;
            state.data.add_point(state.model, *link, &p, &(n * *share), row);
        }
    }
}
