//! Reading a URDF: every complaint with its place in the text, as many as possible in one go.
//!
//! Order of work: XML (`xml`), what is written (`read`, `solid`), the tree (`tree`), what moves
//! (`drive`), and then the model. Files and environment are looked at for meshes only (`locate`).

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use crate::model::assemble::Parts;
use crate::{Base, Dof, DofUnit, Drive, Joint, JointId, JointKind, Link, LinkId, Model};

mod cx;
mod drive;
mod locate;
mod message;
mod read;
mod solid;
mod tree;
mod xml;

pub use message::{UrdfCode, UrdfMessage};

use cx::Cx;
use drive::Driven;
use read::RawRobot;
use tree::Tree;

/// How to read a URDF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// What carries the root link. URDF itself does not say.
    pub base: Base,
    /// Joints to hold, and where \[rad or m\].
    pub lock: BTreeMap<String, f64>,
    /// When given: every movable joint that is not listed is locked at 0, or at the limit
    /// nearest to it. Mimicking joints need not be listed: they follow.
    pub keep: Option<BTreeSet<String>>,
    /// Folder of the URDF, for mesh addresses relative to it.
    pub urdf_dir: Option<PathBuf>,
    /// Folders with packages, or of packages, for `package://` addresses; searched before
    /// `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`.
    pub package_paths: Vec<PathBuf>,
    /// Whether collision meshes are read and bounded by capsules; otherwise they are left out.
    pub read_meshes: bool,
}

impl Model {
    /// Reads a URDF. Warnings come with the model, errors instead of it, each in the order of
    /// their places in the text.
    ///
    /// Where the format leaves a choice: a moving joint without `<limit>`, or with neither
    /// `lower` nor `upper`, is unlimited (a warning); one with `lower` equal to `upper` is locked
    /// there (a warning); a speed limit that is missing, not positive or above 1000 is none (a
    /// warning). A mimicking joint follows what its leader does, also when that is locked.
    /// Elements that are not part of a model (transmissions, simulators' tags) are skipped.
    /// Collision sizes must be positive (an error); a visual that cannot be drawn is left out (a
    /// warning).
    ///
    /// # Errors
    /// All that [`UrdfCode`] lists and does not call a warning.
    pub fn from_urdf(text: &str, options: &Options) -> Result<(Model, Vec<UrdfMessage>), Vec<UrdfMessage>> {
        let document = xml::parse(text).map_err(|message| vec![message])?;
        let mut cx = Cx { text, errors: Vec::new(), warnings: Vec::new() };
        let root = document.root_element();
        let mut solids = solid::Solids::new(&mut cx, root, options);
        let model = read::robot(&mut cx, root, &mut solids).and_then(|robot| build(&mut cx, robot, options));
        cx.errors.sort_by_key(|m| m.span.start);
        cx.warnings.sort_by_key(|m| m.span.start);
        match model {
            Some(model) if cx.errors.is_empty() => Ok((model, cx.warnings)),
            _ => Err(cx.errors),
        }
    }
}

fn build(cx: &mut Cx, robot: RawRobot, options: &Options) -> Option<Model> {
    let tree = tree::grow(cx, &robot);
    // Without a tree the joints are still looked at, in file order, for more complaints.
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
    // What has passed the checks above passes these; if not, it is said rather than hidden.
    Model::try_from(parts).map_err(|text| cx.error(UrdfMessage::new(UrdfCode::Missing, tag, text))).ok()
}

fn parts(robot: RawRobot, tree: &Tree, driven: &[Driven], base: Base) -> Parts {
    let RawRobot { name, links: raw_links, joints: raw_joints, .. } = robot;
    // Where each written link stands in the model.
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
    Parts { name, base, links: slots.into_iter().flatten().collect(), joints, dofs }
}

/// The base's degrees of freedom, then those of the joints that have one.
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
            dofs.push(Dof {
                name: joint.name.clone(),
                joint: Some(JointId(k as u32)),
                unit: match joint.kind {
                    JointKind::Prismatic => DofUnit::Metre,
                    _ => DofUnit::Radian,
                },
                q_index: Some(base.nq() + dofs.len() - base.nv()),
                lower: joint.lower,
                upper: joint.upper,
                velocity: joint.velocity,
                acceleration: joint.acceleration,
            });
        }
    }
    dofs
}
