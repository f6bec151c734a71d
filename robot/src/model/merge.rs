//! Several robots in one model: each stands at a place in the world, and all hang from one root link, the world.
//!
//! Links, joints and degrees of freedom get the prefix of their robot. A base in the plane becomes two sliding joints and a
//! turning one, so that its velocities are those of its coordinates, in the axes of the place where the robot stands.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Vector3};

use super::assemble::{MAX_MOVING, Parts};
use super::{Drive, Joint, JointKind, Link};
use crate::{Base, Dof, DofUnit, JointId, LinkId, Model};

/// Name of the root link.
pub const WORLD: &str = "world";

/// A robot to merge.
#[derive(Clone, Debug)]
pub struct Placed<'m> {
    /// The robot; its base is fixed or planar.
    pub model: &'m Model,
    /// Prefix of its names.
    pub prefix: &'m str,
    /// Pose of its root link in the world, or of the origin of its base.
    pub at: Isometry3<f64>,
}

/// Indices of a robot in a model that it was merged into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Merged {
    /// Index of its root link; those of its other links follow in their order.
    pub first_link: u32,
    /// Index that its first joint would have, without those of its base.
    pub first_joint: u32,
    /// Index of its first degree of freedom, and of its first coordinate.
    pub first_dof: usize,
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

    /// Returns the index of one of the robot's degrees of freedom. Its coordinate has the same index.
    pub fn dof(&self, of_robot: usize) -> usize {
        self.first_dof + of_robot
    }
}

/// Reason why robots cannot be merged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// The base of a robot, by its index, cannot be described by joints.
    #[error("the base of robot {robot} cannot be described by joints")]
    Base {
        /// Index of the robot.
        robot: usize,
    },
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
    names: [BTreeSet<String>; 2],
}

impl Model {
    /// Merges robots into one model with the name `name`, in their order. A configuration is the concatenation of theirs, and
    /// so is a velocity, with that of a planar base in the axes of its place.
    ///
    /// # Errors
    /// A base that is neither fixed nor planar, a name that two parts would have, or too many joints.
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
            base: Base::Fixed,
            links: vec![world],
            joints: Vec::new(),
            dofs: Vec::new(),
            roots: Vec::new(),
        };
        let mut builder = Builder { parts, names: [BTreeSet::from([WORLD.to_string()]), BTreeSet::new()] };
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
        let first_dof = self.parts.dofs.len();
        self.parts.roots.push(LinkId(self.parts.links.len() as u32));
        let fixed = (JointKind::Fixed, Vector3::z(), "stand");
        let mounts: &[(JointKind, Vector3<f64>, &str)] = match model.base {
            Base::Fixed => &[fixed],
            Base::Planar => &[
                (JointKind::Prismatic, Vector3::x(), "base_x"),
                (JointKind::Prismatic, Vector3::y(), "base_y"),
                (JointKind::Continuous, Vector3::z(), "base_yaw"),
            ],
            Base::Unicycle | Base::Floating => return Err(MergeError::Base { robot }),
        };
        let mut parent = LinkId(0);
        let mut origin = *at;
        for (k, (kind, axis, word)) in mounts.iter().enumerate() {
            let last = k + 1 == mounts.len();
            let child = match last {
                true => Link { name: format!("{prefix}{}", model.links[0].name), ..model.links[0].clone() },
                false => Link {
                    name: format!("{prefix}{word}_stage"),
                    collision: Vec::new(),
                    visual: Vec::new(),
                    mass: 0.0,
                    center_of_mass: Vector3::zeros(),
                    inertia: [0.0; 6],
                    parent_joint: None,
                },
            };
            let limits = (*kind != JointKind::Fixed).then(|| &model.dofs[k]);
            let unlimited = f64::INFINITY;
            let joint = Joint {
                name: format!("{prefix}{word}"),
                kind: *kind,
                parent,
                child: parent,
                origin,
                axis: *axis,
                drive: limits.map_or(Drive::Fixed, |_| Drive::Dof(first_dof + k)),
                lower: limits.map_or(-unlimited, |d| d.lower),
                upper: limits.map_or(unlimited, |d| d.upper),
                velocity: limits.map_or(unlimited, |d| d.velocity),
                effort: unlimited,
                acceleration: limits.map_or(unlimited, |d| d.acceleration),
            };
            parent = self.add(robot, joint, child, limits)?;
            origin = Isometry3::identity();
        }
        let merged = Merged {
            first_link: parent.0,
            // Joint `k` of the robot moves its link `k + 1`, and follows the joints of the base.
            first_joint: parent.0,
            first_dof,
        };
        for (joint, link) in model.joints.iter().zip(&model.links[1..]) {
            let of_dof = |dof: usize| first_dof + dof;
            let drive = match joint.drive {
                Drive::Dof(dof) => Drive::Dof(of_dof(dof)),
                Drive::Mimic { dof, multiplier, offset } => Drive::Mimic { dof: of_dof(dof), multiplier, offset },
                other => other,
            };
            let dof = match joint.drive {
                Drive::Dof(dof) => Some(&model.dofs[dof]),
                _ => None,
            };
            let name = format!("{prefix}{}", joint.name);
            let moved = Joint { name, parent: merged.link(joint.parent), drive, ..joint.clone() };
            self.add(robot, moved, Link { name: format!("{prefix}{}", link.name), ..link.clone() }, dof)?;
        }
        Ok(merged)
    }

    /// Adds a joint with the link that it moves, and with the degree of freedom that it drives.
    fn add(&mut self, robot: usize, joint: Joint, link: Link, dof: Option<&Dof>) -> Result<LinkId, MergeError> {
        for (names, name) in self.names.iter_mut().zip([&link.name, &joint.name]) {
            if !names.insert(name.clone()) {
                return Err(MergeError::Name { robot, name: name.clone() });
            }
        }
        let parts = &mut self.parts;
        let (id, child) = (JointId(parts.joints.len() as u32), LinkId(parts.links.len() as u32));
        if let Some(dof) = dof {
            let unit = if joint.kind == JointKind::Prismatic { DofUnit::Metre } else { DofUnit::Radian };
            let q_index = Some(parts.dofs.len());
            parts.dofs.push(Dof { name: joint.name.clone(), joint: Some(id), unit, q_index, ..dof.clone() });
        }
        parts.joints.push(Joint { child, ..joint });
        parts.links.push(Link { parent_joint: Some(id), ..link });
        Ok(child)
    }
}
