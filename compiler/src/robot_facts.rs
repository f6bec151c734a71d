//! Facts of a robot that its SRDF and its shapes give: groups, postures, and the pairs of links that a limit on the whole robot
//! keeps apart or leaves out.

use std::collections::BTreeMap;

use robot::{Data, Drive, JointId, LinkId, Srdf, contacts};
use runtime::program::Program;

/// Facts of a robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotFacts {
    /// Groups of the SRDF.
    pub groups: Vec<GroupFacts>,
    /// Postures of the SRDF.
    pub postures: Vec<PostureFacts>,
    /// End effectors of the SRDF, each with the link that carries it.
    pub end_effectors: Vec<[String; 2]>,
    /// Joints without a motor.
    pub passive: Vec<String>,
    /// Pairs of links with shapes that the SRDF disables, without neighbours.
    pub disabled: Vec<PairFacts>,
    /// Pairs that touch at home and at each of [`contacts::POSTURES`] random postures, and that the SRDF does not disable.
    pub touching: Vec<[String; 2]>,
    /// Pairs of links that are left.
    pub apart: Vec<PairFacts>,
    /// Number of pairs of links that are left, which `self_collision { between all }` keeps apart.
    pub open: usize,
    /// Number of its rows: a row for each pair of shapes.
    pub rows: usize,
}

/// A group of an SRDF.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupFacts {
    /// Name.
    pub name: String,
    /// Joints that move.
    pub joints: Vec<String>,
    /// Links.
    pub links: Vec<String>,
    /// Last link, if the group is one chain.
    pub tip: Option<String>,
}

/// A posture of an SRDF.
#[derive(Clone, Debug, PartialEq)]
pub struct PostureFacts {
    /// Name.
    pub name: String,
    /// Group.
    pub group: String,
    /// Positions (rad or m) of joints that move, by name.
    pub positions: BTreeMap<String, f64>,
}

/// A pair of links.
#[derive(Clone, Debug, PartialEq)]
pub struct PairFacts {
    /// Names of the links.
    pub links: [String; 2],
    /// Reason as the SRDF gives it; empty without one, and for a pair that is left.
    pub reason: String,
    /// Distance at home (m), not above zero if they touch.
    pub at_home: f64,
}

/// Collects the facts of the robot of a program.
pub fn robot_facts(program: &Program, srdf: Option<&Srdf>) -> RobotFacts {
    let model = &program.robot.model;
    let name = |link: LinkId| model.link_ref(link).name.clone();
    let moving = |joint: JointId| {
        let joint = model.joint_ref(joint);
        matches!(joint.drive, Drive::Dof(_)).then(|| joint.name.clone())
    };
    let mut home = Data::new(model);
    model.forward(&program.robot.home, &mut home);
    let disabled = srdf.map(Srdf::disabled_pairs).unwrap_or_default();
    let (without, left): (Vec<_>, Vec<_>) =
        contacts::pairs(model).into_iter().partition(|pair| disabled.contains_key(pair));
    let touching = contacts::always_touching(model, &program.robot.home, &left);
    let shapes = |link: LinkId| model.link_ref(link).collision.len();
    let open: Vec<_> = left.iter().filter(|pair| !touching.contains(*pair)).collect();
    let facts = |pair: &[LinkId; 2]| PairFacts {
        links: pair.map(name),
        reason: disabled.get(pair).map(|reason| (*reason).to_string()).unwrap_or_default(),
        at_home: contacts::distance(model, &home, *pair),
    };
    let groups = srdf.iter().flat_map(|srdf| &srdf.groups);
    let postures = srdf.iter().flat_map(|srdf| &srdf.postures);
    RobotFacts {
        groups: groups
            .map(|group| GroupFacts {
                name: group.name.clone(),
                joints: group.joints.iter().filter_map(|joint| moving(*joint)).collect(),
                links: group.links.iter().map(|link| name(*link)).collect(),
                tip: group.tip.map(name),
            })
            .collect(),
        postures: postures
            .map(|posture| PostureFacts {
                name: posture.name.clone(),
                group: posture.group.clone(),
                positions: posture.positions.iter().filter_map(|p| Some((moving(p.joint)?, p.value))).collect(),
            })
            .collect(),
        end_effectors: srdf
            .iter()
            .flat_map(|srdf| &srdf.end_effectors)
            .map(|tool| [tool.name.clone(), name(tool.parent_link)])
            .collect(),
        passive: srdf
            .iter()
            .flat_map(|srdf| &srdf.passive)
            .map(|passive| model.joint_ref(passive.joint).name.clone())
            .collect(),
        disabled: without.iter().map(facts).collect(),
        apart: open.iter().copied().map(facts).collect(),
        touching: touching.iter().map(|pair| pair.map(name)).collect(),
        open: open.len(),
        rows: open.iter().map(|[a, b]| shapes(*a) * shapes(*b)).sum(),
    }
}
