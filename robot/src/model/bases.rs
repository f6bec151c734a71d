//! Bases that move, in a model: the links that they move, and the places of their numbers in `q` and `v`.

use std::ops::Range;

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use super::assemble::joint_pose;
use super::{Drive, Model};
use crate::{Base, LinkId};

/// A base that moves, in a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MobileBase {
    /// Its motion, which is not [`Base::Fixed`].
    pub kind: Base,
    /// Link that it moves: the root, or a link on a fixed joint, whose origin is then the place of the base.
    pub link: LinkId,
    /// Index of its first coordinate in `q`.
    pub first_coordinate: usize,
    /// Index of its first degree of freedom in `v`.
    pub first_dof: usize,
}

impl MobileBase {
    /// Returns its coordinates, as indices in `q`.
    #[inline]
    pub fn coordinates(&self) -> Range<usize> {
        self.first_coordinate..self.first_coordinate + self.kind.nq()
    }

    /// Returns its degrees of freedom, as indices in `v`.
    #[inline]
    pub fn dofs(&self) -> Range<usize> {
        self.first_dof..self.first_dof + self.kind.nv()
    }

    /// Returns the name of the link that it moves.
    pub fn link_name<'m>(&self, model: &'m Model) -> &'m str {
        &model.link_ref(self.link).name
    }

    /// Returns true for the name of one of its coordinates or degrees of freedom.
    pub fn has_number(&self, model: &Model, name: &str) -> bool {
        let of_kind = |of: &str| self.kind.coordinate_names().contains(&of) || self.kind.dof_names().contains(&of);
        name.strip_prefix(self.prefix(model)).is_some_and(of_kind)
    }

    /// Returns the prefix of its names, as `left_` in `left_base_x`; empty for a robot alone.
    pub fn prefix<'m>(&self, model: &'m Model) -> &'m str {
        let name = model.dofs.get(self.first_dof).map_or("", |dof| dof.name.as_str());
        self.kind.dof_names().first().and_then(|of_kind| name.strip_suffix(of_kind)).unwrap_or_default()
    }
}

impl Model {
    /// Returns the base that moves `link`; none if its robot is fixed.
    #[inline]
    pub fn base_of(&self, link: LinkId) -> Option<&MobileBase> {
        // Nothing moves a base, so that its degrees of freedom come first.
        self.base_of_dof(self.support(link).first()?.dof as usize)
    }

    /// Returns the base that has the degree of freedom `dof`; none for that of a joint.
    #[inline]
    pub fn base_of_dof(&self, dof: usize) -> Option<&MobileBase> {
        self.bases.iter().find(|base| base.dofs().contains(&dof))
    }

    /// Returns the base that moves `link` itself, and not only with a link that carries it.
    #[inline]
    pub fn base_at(&self, link: LinkId) -> Option<&MobileBase> {
        self.bases.iter().find(|base| base.link == link)
    }

    /// Returns the pose of a base's link in the world while the coordinates of the base are zero.
    pub fn place(&self, base: &MobileBase) -> Isometry3<f64> {
        let (mut X_OB, mut link) = (Isometry3::identity(), base.link);
        while let Some(j) = self.link_ref(link).parent_joint {
            let joint = self.joint_ref(j);
            let position = if let Drive::Locked(position) = joint.drive { position } else { 0.0 };
            X_OB = joint_pose(joint, position) * X_OB;
            link = joint.parent;
        }
        X_OB
    }

    /// Returns the base of the root link.
    pub fn root_base(&self) -> Base {
        self.base_at(self.root()).map_or(Base::Fixed, |base| base.kind)
    }

    /// Copies the coordinates of all bases from one configuration to another, both of length nq.
    pub fn copy_bases(&self, from: &[f64], to: &mut [f64]) {
        for base in &self.bases {
            to[base.coordinates()].copy_from_slice(&from[base.coordinates()]);
        }
    }
}
