//! Several robots in one model: each stands at a place in the world, and all hang from one root link, the world.
//!
//! Links, joints and degrees of freedom get the prefix of their robot, and each robot moves as it does alone, in the axes of its
//! place.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Vector3};

use super::assemble::{MAX_MOVING, Parts};
use super::{Drive, Joint, JointKind, Link};
use crate::{Dof, JointId, LinkId, MobileBase, Model};

/// Name of the root link.
pub const WORLD: &str = "world";

/// A robot to merge.
#[derive(Clone, Debug)]
pub struct Placed<'m> {
    /// The robot.
    pub model: &'m Model,
    /// Prefix of its names.
    pub prefix: &'m str,
    /// Pose of its root link in the world, while the coordinates of its base are zero.
    pub at: Isometry3<f64>,
}

/// Indices of a robot in a model that it was merged into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Merged {
    /// Index of its root link; those of its other links follow in their order.
    pub first_link: u32,
    /// Index of its first joint.
    pub first_joint: u32,
    /// Index of its first degree of freedom.
    pub first_dof: usize,
    /// Index of its first coordinate.
    pub first_coordinate: usize,
}

impl Merged {
    /// Returns the index of one of the robot's links.
    pub fn link(&self, of_robot: LinkId) -> LinkId {
        LinkId(self.first_link + of_robot.0)
    }

    /// Returns the index of one of the robot's joints.
    pub fn joint(&self, of_robot: JointId) -> JointId {
        JointId(self.first_joint + of_robot.0)
    }

    /// Returns the index of one of the robot's degrees of freedom.
    pub fn dof(&self, of_robot: usize) -> usize {
        self.first_dof + of_robot
    }

    /// Returns the index of one of the robot's coordinates.
    pub fn coordinate(&self, of_robot: usize) -> usize {
        self.first_coordinate + of_robot
    }
}

/// Reason why robots cannot be merged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// Two links, or two joints, would have one name.
    #[error("two parts have the name `{name}`")]
    Name {
        /// Index of the later robot.
        robot: usize,
        /// The name.
        name: String,
    },
    /// There would be too many moving joints.
    #[error("more than {MAX_MOVING} joints move")]
    TooMany,
}

/// Parts of a model under construction.
struct Builder {
    parts: Parts,
    nq: usize,
    /// Names of links; of joints and of coordinates of bases.
    names: [BTreeSet<String>; 2],
}

impl Model {
    /// Merges robots into one model with the name `name`, in their order. A configuration is the concatenation of theirs, and
    /// so is a velocity.
    ///
    /// # Errors
    /// A name that two parts would have, or too many joints.
    pub fn merged(name: &str, robots: &[Placed]) -> Result<(Model, Vec<Merged>), MergeError> {
        let world = Link {
            name: WORLD.to_string(),
            parent_joint: None,
            collision: Vec::new(),
            visual: Vec::new(),
            mass: 0.0,
            center_of_mass: Vector3::zeros(),
            inertia: [0.0; 6],
        };
        let parts = Parts {
            name: name.to_string(),
            bases: Vec::new(),
            links: vec![world],
            joints: Vec::new(),
            dofs: Vec::new(),
            roots: Vec::new(),
        };
        let mut builder = Builder { parts, nq: 0, names: [BTreeSet::from([WORLD.to_string()]), BTreeSet::new()] };
        let mut merged = Vec::with_capacity(robots.len());
        for (robot, placed) in robots.iter().enumerate() {
            merged.push(builder.robot(robot, placed)?);
        }
        let moving = |joint: &&Joint| matches!(joint.drive, Drive::Dof(_) | Drive::Mimic { .. });
        if builder.parts.joints.iter().filter(moving).count() > MAX_MOVING {
            return Err(MergeError::TooMany);
        }
        let model = Model::try_from(builder.parts);
        Ok((model.unwrap_or_else(|text| unreachable!("sound models merge to a sound one: {text}")), merged))
    }

    /// Returns the index of the robot that a link belongs to, in a model that was merged; 0 in one that was not.
    pub fn robot_of(&self, link: LinkId) -> usize {
        self.roots.partition_point(|root| *root <= link).saturating_sub(1)
    }
}

impl Builder {
    fn robot(&mut self, robot: usize, placed: &Placed) -> Result<Merged, MergeError> {
        let Placed { model, prefix, at } = placed;
        let (first_link, first_joint) = (self.parts.links.len() as u32, self.parts.joints.len() as u32 + 1);
        let merged = Merged { first_link, first_joint, first_dof: self.parts.dofs.len(), first_coordinate: self.nq };
        self.nq += model.nq();
        self.parts.roots.push(LinkId(first_link));
        self.parts.dofs.extend(model.dofs.iter().map(|dof| Dof {
            name: format!("{prefix}{}", dof.name),
            joint: dof.joint.map(|joint| merged.joint(joint)),
            q_index: dof.q_index.map(|i| merged.coordinate(i)),
            ..dof.clone()
        }));
        self.parts.bases.extend(model.bases.iter().map(|base| MobileBase {
            kind: base.kind,
            link: merged.link(base.link),
            first_coordinate: merged.coordinate(base.first_coordinate),
            first_dof: merged.dof(base.first_dof),
        }));
        let stand = Joint {
            name: format!("{prefix}stand"),
            kind: JointKind::Fixed,
            parent: LinkId(0),
            child: LinkId(first_link),
            origin: *at,
            axis: Vector3::z(),
            drive: Drive::Fixed,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            velocity: f64::INFINITY,
            effort: f64::INFINITY,
            acceleration: f64::INFINITY,
        };
        for base in &model.bases {
            for name in base.kind.coordinate_names().iter().chain(base.kind.dof_names()).collect::<BTreeSet<_>>() {
                self.reserve(robot, 1, format!("{prefix}{}{name}", base.prefix(model)))?;
            }
        }
        let root = &model.links[0];
        self.add(robot, stand, Link { name: format!("{prefix}{}", root.name), ..root.clone() })?;
        for (joint, link) in model.joints.iter().zip(&model.links[1..]) {
            let drive = match joint.drive {
                Drive::Dof(dof) => Drive::Dof(merged.dof(dof)),
                Drive::Mimic { dof, multiplier, offset } => Drive::Mimic { dof: merged.dof(dof), multiplier, offset },
                other => other,
            };
            let joint = Joint {
                name: format!("{prefix}{}", joint.name),
                parent: merged.link(joint.parent),
                child: merged.link(joint.child),
                drive,
                ..joint.clone()
            };
            self.add(robot, joint, Link { name: format!("{prefix}{}", link.name), ..link.clone() })?;
        }
        Ok(merged)
    }

    /// Makes sure that no two links have one name, and that no two joints or coordinates of bases have.
    fn reserve(&mut self, robot: usize, kind: usize, name: String) -> Result<(), MergeError> {
        match self.names[kind].insert(name.clone()) {
            true => Ok(()),
            false => Err(MergeError::Name { robot, name }),
        }
    }

    /// Adds a joint with the link that it moves.
    fn add(&mut self, robot: usize, joint: Joint, link: Link) -> Result<(), MergeError> {
        self.reserve(robot, 0, link.name.clone())?;
        self.reserve(robot, 1, joint.name.clone())?;
        self.parts.links.push(Link { parent_joint: Some(JointId(self.parts.joints.len() as u32)), ..link });
        self.parts.joints.push(joint);
        Ok(())
    }
}
