//! URDF reader: reports as many errors as possible in one pass, each with its location in the text.
//!
//! Stages: XML (`xml`), links and joints as written (`read`, `solid`), the tree (`tree`), the drives (`drive`), the
//! model. Only meshes access files and environment variables (`locate`).

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use crate::followers::with_followers;
use crate::model::assemble::Parts;
use crate::{Base, Dof, DofUnit, Drive, Joint, JointId, JointKind, Link, LinkId, MobileBase, Model};

pub(crate) mod cx;
mod drive;
mod followers;
mod link_mesh;
mod locate;
mod message;
mod read;
mod shapes;
mod solid;
mod tree;
mod units;
pub(crate) mod xml;

pub use link_mesh::LinkMesh;
pub use message::{UrdfCode, UrdfMessage};
pub use shapes::{ShapeKind, Shapes};

use cx::Cx;
use drive::Driven;
use read::RawRobot;
use tree::Tree;

/// Options for reading a URDF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Mobility of the root link. A URDF does not define it.
    pub base: Base,
    /// Joints to hold, with their positions \[rad or m\].
    pub lock: BTreeMap<String, f64>,
    /// If present: every movable joint that is not listed is locked at 0, or at the limit nearest to 0. Mimicking
    /// joints need not be listed: they follow.
    pub keep: Option<BTreeSet<String>>,
    /// Folder of the URDF, for relative mesh addresses.
    pub urdf_dir: Option<PathBuf>,
    /// Folders that contain packages, or are packages, for `package://` addresses; searched before `ROS_PACKAGE_PATH`,
    /// `AMENT_PREFIX_PATH` and the folders above the URDF.
    pub package_paths: Vec<PathBuf>,
    /// True to read collision meshes and bound them by shapes; otherwise they are left out.
    pub read_meshes: bool,
    /// Kinds of the collision shapes of links.
    pub shapes: Shapes,
    /// Folder in which the cache of pieces is; `None` to keep nothing.
    pub cache: Option<PathBuf>,
}

/// A model, and what else its file says.
#[derive(Clone, Debug)]
pub struct ReadUrdf {
    /// The model.
    pub model: Model,
    /// Warnings, sorted by their location in the text.
    pub warnings: Vec<UrdfMessage>,
    /// Meshes of collision shapes that were read.
    pub meshes: Vec<LinkMesh>,
}

impl Model {
    /// Reads a URDF. Returns the model with warnings, or the errors; both are sorted by their location in the text.
    ///
    /// Choices that the format leaves open:
    /// - A moving joint without `<limit>`, or with neither `lower` nor `upper`, is unlimited (a warning).
    /// - A joint with `lower` equal to `upper` is locked there (a warning).
    /// - A speed limit that is missing, not positive or above 1000 is ignored (a warning).
    /// - A mimicking joint follows its leader, even if the leader is locked. Its own limits bound the leader.
    /// - Elements that are not part of a model (transmissions, simulators' tags) are skipped.
    /// - Collision sizes must be positive (an error); a visual that cannot be drawn is left out (a warning).
    ///
    /// # Errors
    /// All codes of [`UrdfCode`] that are not marked as a warning.
    pub fn from_urdf(text: &str, options: &Options) -> Result<(Model, Vec<UrdfMessage>), Vec<UrdfMessage>> {
        read(text, options).map(|read| (read.model, read.warnings))
    }
}

/// Reads a URDF as [`Model::from_urdf`] does, with the meshes of its links.
///
/// # Errors
/// Those of [`Model::from_urdf`].
pub fn read(text: &str, options: &Options) -> Result<ReadUrdf, Vec<UrdfMessage>> {
    let document = xml::parse(text).map_err(|message| vec![message])?;
    let mut cx = Cx { text, errors: Vec::new(), warnings: Vec::new() };
    let root = document.root_element();
    let mut solids = solid::Solids::new(&mut cx, root, options);
    let model = read::robot(&mut cx, root, &mut solids).and_then(|robot| build(&mut cx, robot, options));
    solids.report_missing(&mut cx);
    cx.errors.sort_by_key(|m| m.span.start);
    cx.warnings.sort_by_key(|m| m.span.start);
    match model {
        Some(model) if cx.errors.is_empty() => {
            Ok(ReadUrdf { model, warnings: cx.warnings, meshes: solids.into_meshes() })
        }
        _ => Err(cx.errors),
    }
}

fn build(cx: &mut Cx, robot: RawRobot, options: &Options) -> Option<Model> {
    let tree = tree::grow(cx, &robot);
    // Without a tree the joints are still checked, in file order, to report more errors.
    let file_order: Vec<usize> = (0..robot.joints.len()).collect();
    let order = tree.as_ref().map_or(&file_order, |tree| &tree.joints);
    let driven = drive::resolve(cx, &robot, order, options.base.nv(), options);
    for (&j, driven) in order.iter().zip(&driven) {
        let name = &robot.joints[j].name;
        if matches!(driven.drive, Drive::Dof(_)) && options.base.dof_names().contains(&name.value.as_str()) {
            let text = format!("`{}` is already a degree of freedom of the base", name.value);
            cx.error(
                UrdfMessage::new(UrdfCode::ReservedName, name.span.clone(), text)
                    .help("rename the joint, lock it, or write `base: fixed` if it is the base"),
            );
        }
    }
    let tree = tree.filter(|_| cx.errors.is_empty())?;
    let tag = robot.tag.clone();
    let parts = parts(robot, &tree, &driven, options.base);
    // The checks above imply those of `try_from`. A failure here is a bug in this crate, but is reported.
    Model::try_from(parts).map_err(|text| cx.error(UrdfMessage::new(UrdfCode::Missing, tag, text))).ok()
}

fn parts(robot: RawRobot, tree: &Tree, driven: &[Driven], base: Base) -> Parts {
    let RawRobot { name, links: raw_links, joints: raw_joints, .. } = robot;
    // Index in the model for each link as written.
    let mut place = vec![LinkId(0); raw_links.len()];
    for (k, &j) in tree.joints.iter().enumerate() {
        place[tree.ends[j].1] = LinkId(k as u32 + 1);
    }
    let mut slots: Vec<Option<Link>> = vec![None; raw_links.len()];
    for (i, raw) in raw_links.into_iter().enumerate() {
        let at = place[i];
        debug_assert_eq!(i == tree.root, at == LinkId(0));
        slots[at.index()] = Some(Link {
            name: raw.name.value,
            parent_joint: at.0.checked_sub(1).map(JointId),
            collision: raw.collision,
            visual: raw.visual,
            mass: raw.mass,
            center_of_mass: raw.center_of_mass,
            inertia: raw.inertia,
        });
    }
    let mut slots_of_joints: Vec<Option<_>> = raw_joints.into_iter().map(Some).collect();
    let mut joints = Vec::with_capacity(driven.len());
    for (&j, d) in tree.joints.iter().zip(driven) {
        let Some(raw) = slots_of_joints[j].take() else { continue };
        let (parent, child) = tree.ends[j];
        joints.push(Joint {
            name: raw.name.value,
            kind: raw.kind,
            parent: place[parent],
            child: place[child],
            origin: raw.origin,
            axis: raw.axis,
            drive: d.drive,
            lower: d.lower,
            upper: d.upper,
            velocity: d.velocity,
            effort: d.effort,
            acceleration: d.acceleration,
        });
    }
    let dofs = dofs(base, &joints);
    let mobile = MobileBase { kind: base, link: LinkId(0), first_coordinate: 0, first_dof: 0 };
    let bases = if base == Base::Fixed { Vec::new() } else { vec![mobile] };
    Parts { name, bases, links: slots.into_iter().flatten().collect(), joints, dofs, roots: Vec::new() }
}

/// Returns the degrees of freedom of the base, then those of the joints.
fn dofs(base: Base, joints: &[Joint]) -> Vec<Dof> {
    let mut dofs: Vec<Dof> = base
        .dof_names()
        .iter()
        .enumerate()
        .map(|(i, name)| Dof {
            name: (*name).to_owned(),
            joint: None,
            unit: if base.turns(i) { DofUnit::Radian } else { DofUnit::Metre },
            q_index: None,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            velocity: f64::INFINITY,
            acceleration: f64::INFINITY,
        })
        .collect();
    for (k, joint) in joints.iter().enumerate() {
        if let Drive::Dof(_) = joint.drive {
            let limits = with_followers(joints, k);
            dofs.push(Dof {
                name: joint.name.clone(),
                joint: Some(JointId(k as u32)),
                unit: match joint.kind {
                    JointKind::Prismatic => DofUnit::Metre,
                    _ => DofUnit::Radian,
                },
                q_index: Some(base.nq() + dofs.len() - base.nv()),
                lower: limits.lower,
                upper: limits.upper,
                velocity: limits.velocity,
                acceleration: limits.acceleration,
            });
        }
    }
    dofs
}
