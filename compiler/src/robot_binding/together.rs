//! Several robots of a spec as one: their models merged, with the name of each robot before its names, `left_tool`. They have
//! one controller, so that one hierarchy moves them all, and limits know the parts of each.

use std::collections::{BTreeMap, BTreeSet};

use dsl::tree::Value;
use dsl::{Diagnostic, Help, Snippet, Span};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use robot::{LinkMesh, MergeError, Merged, Model, Placed};
use stdlib_tasks::bound::{Arm, Geometry};
use stdlib_tasks::dimension::LENGTH;

use super::{BoundRobot, JointGroups, Postures, RobotSrdf};
use crate::expr::Kind;
use crate::expr::constants::Constants;
use crate::sections::prefix;

/// Names that all robots share.
const SHARED: &[&str] = &["all", "arms"];

/// The stand of a robot in the world: the value of `at`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stand {
    /// Pose of its root link in the world, while the coordinates of its base are zero.
    pub pose: Isometry3<f64>,
    /// Place of the value; none without one.
    pub span: Option<Span>,
}

impl Stand {
    /// Reads `at`: a position or a pose. Mistakes are reported.
    pub(super) fn read(value: Option<&Value>, constants: &mut Constants, diagnostics: &mut Vec<Diagnostic>) -> Stand {
        let Some(value) = value else { return Stand::default() };
        let span = Some(value.span);
        let wrong = Stand { pose: Isometry3::identity(), span };
        let Some(typed) = constants.constant(value, diagnostics) else { return wrong };
        if !matches!(typed.kind, Kind::Vector | Kind::Pose) {
            let is = typed.kind.describe();
            let text = format!("`at` is a position or a pose, and this is {is}");
            let d = Diagnostic::error("HQ0304", value.span, text).here(is);
            diagnostics.push(d.help("write `[1, 0, 0] m`, or `pose([1, 0, 0] m, rpy(0, 0, 90 deg))`"));
            return wrong;
        }
        if let Some(d) = constants.check_dimension(&typed, LENGTH, "`at`").filter(|_| typed.kind == Kind::Vector) {
            diagnostics.push(d);
        }
        let numbers: Vec<f64> = typed.nodes.iter().filter_map(|&node| constants.graph.constant(node)).collect();
        let pose = match numbers.as_slice() {
            [x, y, z] => Isometry3::translation(*x, *y, *z),
            [x, y, z, w, i, j, k] => Isometry3::from_parts(
                Translation3::new(*x, *y, *z),
                UnitQuaternion::new_normalize(Quaternion::new(*w, *i, *j, *k)),
            ),
            _ => return wrong,
        };
        Stand { pose, span }
    }
}

/// Makes one robot of all robots of a spec. A single one without `at` stays as it is. Mistakes are reported.
pub fn together(mut robots: Vec<BoundRobot>, diagnostics: &mut Vec<Diagnostic>) -> Option<BoundRobot> {
    let before = diagnostics.len();
    let alone = robots.len() == 1;
    if alone && robots[0].stand.span.is_none() {
        return robots.pop();
    }
    let first = robots.first()?;
    for other in &robots[1..] {
        diagnostics.extend(differing(first, other));
    }
    let prefixes: Vec<String> =
        robots.iter().map(|r| if alone { String::new() } else { prefix(&r.name.value) }).collect();
    let name = robots.iter().map(|r| r.name.value.as_str()).collect::<Vec<_>>().join(" and ");
    let placed: Vec<Placed> = (robots.iter().zip(&prefixes))
        .map(|(r, prefix)| Placed { model: &r.model, prefix, at: r.stand.pose })
        .collect();
    let merged = Model::merged(&name, &placed).map_err(|why| diagnostics.push(refused(&why, &robots)));
    let (model, places) = merged.ok()?;
    if diagnostics.len() > before {
        return None;
    }
    let mut all = BoundRobot {
        name: first.name.clone(),
        urdf: robots.iter().map(|r| r.urdf.as_str()).collect::<Vec<_>>().join(", "),
        model,
        home: robots.iter().flat_map(|r| r.home.iter().copied()).collect(),
        arms: Vec::new(),
        geometries: Vec::new(),
        groups: BTreeMap::new(),
        joint_groups: JointGroups::default(),
        srdf: Vec::new(),
        meshes: Vec::new(),
        postures: Postures::default(),
        failed: BTreeSet::new(),
        ..first.clone()
    };
    all.name.value = name;
    for ((robot, prefix), place) in robots.iter().zip(&prefixes).zip(&places) {
        all.add(robot, prefix, *place, alone);
    }
    Some(all)
}

/// Reports a property in which two robots with one controller differ.
fn differing(first: &BoundRobot, other: &BoundRobot) -> Option<Diagnostic> {
    let settings = [
        ("stop", ["to_rest", "now"], first.stops_at_once, other.stops_at_once),
        ("resume", ["told", "itself"], first.resumes_itself, other.resumes_itself),
    ];
    if let Some((key, words, a, b)) = settings.into_iter().find(|(_, _, a, b)| a != b) {
        let word = |set: bool| words[usize::from(set)];
        let text = format!("robot `{}` has another `{key}` than `{}`", other.name.value, first.name.value);
        let d = Diagnostic::error("HQ0412", other.name.span, text)
            .here(format!("`{}`", word(b)))
            .label(first.name.span, format!("`{}`", word(a)))
            .note("robots of one spec have one controller, which stops them together");
        return Some(d.help(Help::with("write {} for both", [Snippet::entry(key, word(a))])));
    }
    let words = [
        ("rate", 1.0 / first.period, 1.0 / other.period, "Hz"),
        ("deadline", first.deadline, other.deadline, "s"),
        ("lag", first.lag, other.lag, "s"),
        ("dead_time", first.dead_time, other.dead_time, "s"),
        ("tracking_gain", first.tracking_gain, other.tracking_gain, "/s"),
    ];
    let (key, a, b, unit) = words.into_iter().find(|(_, a, b, _)| (a - b).abs() > 1e-9 * a.abs().max(b.abs()))?;
    let text = format!("robot `{}` has another `{key}` than `{}`", other.name.value, first.name.value);
    let place = if key == "rate" { other.rate_span } else { other.name.span };
    let at = if key == "rate" { first.rate_span } else { first.name.span };
    let number = runtime::text::number;
    let d = Diagnostic::error("HQ0412", place, text)
        .here(format!("{} {unit}", number(b)))
        .label(at, format!("{} {unit}", number(a)))
        .note("robots of one spec have one controller, which computes all their commands in one tick");
    Some(d.help(Help::with(
        "write {} for both, or one spec for each robot",
        [Snippet::entry(key, format!("{} {unit}", number(a)))],
    )))
}

/// The diagnostic for robots that cannot be merged.
fn refused(why: &MergeError, robots: &[BoundRobot]) -> Diagnostic {
    let robot = |i: usize| robots.get(i).unwrap_or(&robots[0]);
    match why {
        MergeError::Name { robot: i, name } => {
            Diagnostic::error("HQ0412", robot(*i).name.span, format!("two parts of the robots have the name `{name}`"))
                .note("the name of a robot stands before the names of its parts")
                .help("choose another name for the robot")
        }
        MergeError::TooMany => {
            Diagnostic::error("HQ0412", robot(0).name.span, why.to_string()).help("lock joints that tasks do not need")
        }
    }
}

impl BoundRobot {
    /// Adds the names of a robot.
    fn add(&mut self, robot: &BoundRobot, prefix: &str, place: Merged, alone: bool) {
        let named = |name: &str| match SHARED.contains(&name) {
            true => name.to_string(),
            false if name.starts_with("arms.") => format!("arms.{prefix}{}", &name["arms.".len()..]),
            false => format!("{prefix}{name}"),
        };
        let link = |l: robot::LinkId| place.link(l);
        self.arms.extend(robot.arms.iter().map(|arm| Arm {
            name: named(&arm.name),
            shoulder: arm.shoulder.map(link),
            elbow: arm.elbow.map(link),
            wrist: arm.wrist.map(link),
            tip: link(arm.tip),
        }));
        self.geometries.extend(robot.geometries.iter().map(|part| Geometry {
            name: named(&part.name),
            link: link(part.link),
            ..part.clone()
        }));
        for (group, names) in &robot.groups {
            let names = names.iter().map(|name| named(name));
            self.groups.entry(named(group)).or_default().extend(names);
        }
        let dofs = |of: &[usize]| of.iter().map(|dof| place.dof(*dof)).collect::<Vec<usize>>();
        for (group, members) in &robot.joint_groups.members {
            self.joint_groups.members.entry(named(group)).or_default().extend(dofs(members));
        }
        self.joint_groups.failed.extend(robot.joint_groups.failed.iter().map(|name| named(name)));
        self.joint_groups.locked.extend(robot.joint_groups.locked.iter().map(|name| named(name)));
        self.failed.extend(robot.failed.iter().map(|name| named(name)));
        self.enabling.extend(&robot.enabling);
        self.postures.add(&robot.postures, named);
        let srdfs = robot.srdf.iter().map(|of| RobotSrdf { srdf: of.srdf.merged(place, prefix), ..of.clone() });
        self.srdf.extend(srdfs);
        self.meshes.extend(robot.meshes.iter().map(|m| LinkMesh { link: named(&m.link), ..m.clone() }));
        if !alone {
            // The name of a robot means all of it.
            let own = &robot.name.value;
            let joints: Vec<usize> = (0..robot.model.nv()).collect();
            self.joint_groups.members.entry(own.clone()).or_insert_with(|| dofs(&joints));
            let shaped = robot.model.links.iter().filter(|l| !l.collision.is_empty());
            let shaped: Vec<String> = shaped.map(|l| named(&l.name)).collect();
            if !shaped.is_empty() {
                self.groups.entry(own.clone()).or_insert(shaped);
            }
        }
    }
}
