//! Construction of a [`Model`] from a description: checks the tree, then flattens the kinematics.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::circle::circular;
use super::{Drive, JointKind, Support};
use crate::{Base, Dof, Joint, Link, LinkId, MobileBase, Model};

/// Maximum number of moving joints: in a chain, the size of `supports` grows with their square.
pub(crate) const MAX_MOVING: usize = 4096;

/// Serialised form of a model: without the flat copy.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Parts {
    pub name: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bases: Vec<MobileBase>,
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    pub dofs: Vec<Dof>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub roots: Vec<LinkId>,
}

/// Motion type of a step of the tape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motor {
    Still,
    Turn,
    Slide,
    Base(Base),
}

/// One joint, prepared for evaluation. Locked positions are folded into `turn` and `shift`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Step {
    pub motor: Motor,
    /// Index of the parent link.
    pub parent: u32,
    /// Index of its motion column, if it moves; the first one of a base.
    pub column: u32,
    /// Index of its position in `q`; the first one of a base.
    pub q_index: u32,
    pub multiplier: f64,
    pub offset: f64,
    /// Axis in the parent's frame.
    pub axis: Vector3<f64>,
    /// `turn` is the rotation of the origin, `turn_axis` its product with the pure quaternion of the axis: the joint's
    /// rotation is `turn cos(x/2) + turn_axis sin(x/2)`.
    pub turn: Quaternion<f64>,
    pub turn_axis: Quaternion<f64>,
    pub shift: Vector3<f64>,
}

/// The flat copy of the model that kinematics runs on.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tape {
    pub nq: usize,
    /// Motion of link 0, whose coordinates and columns come first.
    pub root: Base,
    /// Step `k` poses link `k + 1`.
    pub steps: Vec<Step>,
    pub columns: usize,
    /// For each joint, true if it and its followers are at the same place after a whole turn of it, whatever its limits.
    pub circular: Vec<bool>,
    pub supports: Vec<Support>,
    /// Range in `supports` for each link; links without motion between them share one range.
    pub ranges: Vec<(u32, u32)>,
}

impl From<Model> for Parts {
    fn from(m: Model) -> Parts {
        Parts { name: m.name, bases: m.bases, links: m.links, joints: m.joints, dofs: m.dofs, roots: m.roots }
    }
}

impl TryFrom<Parts> for Model {
    type Error = String;

    fn try_from(parts: Parts) -> Result<Model, String> {
        check(&parts)?;
        let tape = lay_out(&parts);
        let carried = |base: &MobileBase| {
            let joint = parts.links[base.link.index()].parent_joint;
            joint.is_some_and(|j| {
                let (start, end) = tape.ranges[parts.joints[j.index()].parent.index()];
                start < end
            })
        };
        if parts.bases.iter().any(carried) {
            return Err("something moves a base".into());
        }
        let Parts { name, bases, links, joints, dofs, roots } = parts;
        Ok(Model { name, bases, links, joints, dofs, roots, tape })
    }
}

fn rigid(x: &Isometry3<f64>) -> bool {
    x.translation.vector.iter().all(|v| v.is_finite()) && (x.rotation.quaternion().norm_squared() - 1.0).abs() < 1e-9
}

/// Checks every property that later indexing relies on.
fn check(parts: &Parts) -> Result<(), String> {
    let Parts { bases, links, joints, dofs, .. } = parts;
    if links.len() != joints.len() + 1 {
        return Err(format!("{} joints cannot carry {} links", joints.len(), links.len()));
    }
    if links[0].parent_joint.is_some() {
        return Err("the root link has a parent joint".into());
    }
    check_bases(parts)?;
    let mut coordinates = 0;
    for (i, dof) in dofs.iter().enumerate() {
        let base = bases.iter().find(|base| base.dofs().contains(&i));
        if let Some(base) = base.filter(|base| base.first_dof == i) {
            if base.first_coordinate != coordinates {
                return Err(format!("the coordinates of `{}` are out of order", dof.name));
            }
            coordinates += base.kind.nq();
        }
        let expected = base.is_none().then_some(coordinates);
        coordinates += usize::from(base.is_none());
        if dof.q_index != expected || dof.joint.is_some() != expected.is_some() {
            return Err(format!("degree of freedom `{}` is out of order", dof.name));
        }
        if dof.joint.is_some_and(|j| joints.get(j.index()).is_none_or(|joint| joint.drive != Drive::Dof(i))) {
            return Err(format!("degree of freedom `{}` moves no joint", dof.name));
        }
    }
    if !parts.roots.is_sorted() || parts.roots.iter().any(|root| root.index() >= links.len()) {
        return Err("the first links of its robots are out of order".into());
    }
    let mut moving = 0;
    for (k, joint) in joints.iter().enumerate() {
        let wrong = |what: &str| Err(format!("joint `{}`: {what}", joint.name));
        if joint.child.index() != k + 1 || joint.parent.index() > k {
            return wrong("parents must come before children");
        }
        if links[k + 1].parent_joint.is_none_or(|j| j.index() != k) {
            return wrong("its child names another joint");
        }
        if !rigid(&joint.origin) || (joint.axis.norm_squared() - 1.0).abs() > 1e-9 {
            return wrong("its origin or its axis is not of unit length");
        }
        let fixed = joint.kind == JointKind::Fixed;
        match joint.drive {
            Drive::Fixed if !fixed => return wrong("it needs a drive"),
            Drive::Fixed => {}
            _ if fixed => return wrong("it is fixed and cannot be driven"),
            Drive::Locked(x) if !x.is_finite() => return wrong("locked at no finite position"),
            Drive::Locked(_) => {}
            Drive::Mimic { multiplier, offset, .. } if !multiplier.is_finite() || !offset.is_finite() => {
                return wrong("it mimics with numbers that are not finite");
            }
            Drive::Dof(dof) | Drive::Mimic { dof, .. } => {
                moving += 1;
                if dofs.get(dof).is_none_or(|d| d.joint.is_none()) {
                    return wrong("its degree of freedom does not exist");
                }
                if matches!(joint.drive, Drive::Dof(_)) && dofs[dof].joint.is_none_or(|j| j.index() != k) {
                    return wrong("its degree of freedom moves another joint");
                }
            }
        }
    }
    if moving > MAX_MOVING {
        return Err(format!("{moving} joints move, at most {MAX_MOVING} may"));
    }
    for link in links {
        let weighed = link.mass.is_finite()
            && link.mass >= 0.0
            && link.center_of_mass.iter().chain(&link.inertia).all(|x| x.is_finite());
        if !weighed {
            return Err(format!("link `{}`: its mass is negative, or it has no finite centre", link.name));
        }
    }
    for placed in links.iter().flat_map(|link| &link.collision) {
        if !rigid(&placed.origin) || !placed.shape.is_sound() {
            return Err("a collision shape has a size or a pose that is not sound".into());
        }
    }
    Ok(())
}

/// Checks that each base that moves has a link of its own that nothing else moves, and degrees of freedom with its names.
fn check_bases(parts: &Parts) -> Result<(), String> {
    let mut free = 0;
    for (k, base) in parts.bases.iter().enumerate() {
        let wrong = |what: &str| Err(format!("base {k}: {what}"));
        if base.kind == Base::Fixed {
            return wrong("it does not move");
        }
        let names = parts.dofs.get(base.first_dof..).unwrap_or_default().iter().zip(base.kind.dof_names());
        let named = names.filter(|(dof, name)| dof.name.ends_with(*name)).count();
        if base.first_dof < free || named < base.kind.nv() {
            return wrong("its degrees of freedom are missing");
        }
        free = base.first_dof + base.kind.nv();
        let Some(link) = parts.links.get(base.link.index()) else { return wrong("its link does not exist") };
        let joint = link.parent_joint.map(|j| parts.joints.get(j.index()));
        if joint.is_some_and(|joint| joint.is_none_or(|j| j.kind != JointKind::Fixed)) {
            return wrong("a joint moves its link");
        }
        if joint.is_none() && base.first_dof > 0 {
            return wrong("the root link moves, and its degrees of freedom do not come first");
        }
        if parts.bases[..k].iter().any(|other| other.link == base.link) {
            return wrong("another base moves its link");
        }
    }
    Ok(())
}

/// Returns the pose of the child link in its parent's frame if the joint is at `position`.
pub(crate) fn joint_pose(joint: &Joint, position: f64) -> Isometry3<f64> {
    joint.origin
        * match joint.kind {
            JointKind::Fixed => Isometry3::identity(),
            JointKind::Revolute | JointKind::Continuous => {
                Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_scaled_axis(joint.axis * position))
            }
            JointKind::Prismatic => {
                Isometry3::from_parts(Translation3::from(joint.axis * position), UnitQuaternion::identity())
            }
        }
}

fn lay_out(parts: &Parts) -> Tape {
    let surplus: usize = parts.bases.iter().map(|base| base.kind.nq() - base.kind.nv()).sum();
    let circular = circular(&parts.joints);
    let mut tape = Tape { nq: parts.dofs.len() + surplus, circular, ..Tape::default() };
    let base_at = |link: u32| parts.bases.iter().find(|base| base.link == LinkId(link));
    match base_at(0) {
        Some(base) => {
            tape.root = base.kind;
            let range = tape.moved_by(base);
            tape.ranges.push(range);
        }
        None => tape.ranges.push((0, 0)),
    }
    for joint in &parts.joints {
        let base = base_at(joint.child.0);
        let moves = match joint.drive {
            Drive::Fixed | Drive::Locked(_) => None,
            Drive::Dof(dof) => Some((dof, 1.0, 0.0)),
            Drive::Mimic { dof, multiplier, offset } => Some((dof, multiplier, offset)),
        };
        let rest = match joint.drive {
            Drive::Locked(position) => joint_pose(joint, position),
            _ => joint.origin,
        };
        let turn = *rest.rotation.quaternion();
        let (dof, multiplier, offset) = moves.unwrap_or((0, 0.0, 0.0));
        tape.steps.push(Step {
            motor: match (base, moves, joint.kind) {
                (Some(base), ..) => Motor::Base(base.kind),
                (_, None, _) | (.., JointKind::Fixed) => Motor::Still,
                (.., JointKind::Prismatic) => Motor::Slide,
                (.., JointKind::Revolute | JointKind::Continuous) => Motor::Turn,
            },
            parent: joint.parent.0,
            column: tape.columns as u32,
            q_index: match base {
                Some(base) => base.first_coordinate as u32,
                None => parts.dofs.get(dof).and_then(|d| d.q_index).unwrap_or(0) as u32,
            },
            multiplier,
            offset,
            axis: rest.rotation * joint.axis,
            turn,
            turn_axis: turn * Quaternion::from_imag(joint.axis),
            shift: rest.translation.vector,
        });
        let inherited = tape.ranges[joint.parent.index()];
        let range = if let Some(base) = base {
            tape.moved_by(base)
        } else if moves.is_some() {
            let start = tape.supports.len() as u32;
            tape.supports.extend_from_within(inherited.0 as usize..inherited.1 as usize);
            tape.supports.push(Support { column: tape.columns as u32, dof: dof as u32 });
            tape.columns += 1;
            (start, tape.supports.len() as u32)
        } else {
            inherited
        };
        tape.ranges.push(range);
    }
    tape
}

impl Tape {
    /// Adds the columns of a base, and returns the range of their supports.
    fn moved_by(&mut self, base: &MobileBase) -> (u32, u32) {
        let (start, first) = (self.supports.len() as u32, self.columns as u32);
        let columns = base.dofs().zip(first..);
        self.supports.extend(columns.map(|(dof, column)| Support { column, dof: dof as u32 }));
        self.columns += base.kind.nv();
        (start, self.supports.len() as u32)
    }
}
