//! Named postures: the group states of the robot's SRDF, as values of joints. The name of a posture stands for the positions of
//! the joints of its group; `{ GROUP NAME }` for those of one group, a name alone for all groups that have such a posture.

use std::collections::BTreeMap;

use dsl::tree::Value;
use dsl::{Diagnostic, Help, Snippet, Span};
use names::{list, suggest};
use robot::{Drive, JointId, Model};

use super::srdf::RobotSrdf;
use crate::expr::constants::Params;
use crate::forms::text_of;

/// Words of expressions that no posture can be named by.
const RESERVED: &[&str] = &["t", "time", "pi", "auto"];

/// The position of a joint in a posture.
#[derive(Clone, Debug, PartialEq)]
pub struct PosturePosition {
    /// Joint.
    pub joint: String,
    /// Position (rad or m); `None` for a joint of the group that the posture leaves out, which stands where it is at home.
    pub value: Option<f64>,
}

#[derive(Clone, Debug)]
struct Posture {
    name: String,
    group: String,
    positions: BTreeMap<String, f64>,
}

/// The postures of a robot.
#[derive(Clone, Debug, Default)]
pub struct Postures {
    /// Joints of each group that move, in the order of the model.
    groups: BTreeMap<String, Vec<String>>,
    all: Vec<Posture>,
}

/// Name of a joint that has a degree of freedom of its own.
fn moving(model: &Model, joint: JointId) -> Option<String> {
    let joint = model.joint_ref(joint);
    matches!(joint.drive, Drive::Dof(_)).then(|| joint.name.clone())
}

impl Postures {
    /// The postures of an SRDF, for the robot with all its joints.
    pub(super) fn of(srdf: &RobotSrdf, model: &Model) -> Postures {
        let joints = |of: &[JointId]| of.iter().filter_map(|joint| moving(model, *joint)).collect();
        let mut groups: BTreeMap<String, Vec<String>> =
            srdf.srdf.groups.iter().map(|group| (group.name.clone(), joints(&group.joints))).collect();
        let every: Vec<JointId> = (0..model.joints.len() as u32).map(JointId).collect();
        groups.entry("all".to_string()).or_insert_with(|| joints(&every));
        let all = srdf.srdf.postures.iter().map(|posture| Posture {
            name: posture.name.clone(),
            group: posture.group.clone(),
            positions: posture
                .positions
                .iter()
                .filter_map(|position| Some((moving(model, position.joint)?, position.value)))
                .collect(),
        });
        Postures { groups, all: all.collect() }
    }

    /// Adds the postures of a robot that is part of this one; `named` gives the names of its groups and joints here.
    pub(super) fn add(&mut self, other: &Postures, named: impl Fn(&str) -> String) {
        for (group, joints) in &other.groups {
            let joints = joints.iter().map(|joint| named(joint));
            self.groups.entry(named(group)).or_default().extend(joints);
        }
        self.all.extend(other.all.iter().map(|posture| Posture {
            name: posture.name.clone(),
            group: named(&posture.group),
            positions: posture.positions.iter().map(|(joint, x)| (named(joint), *x)).collect(),
        }));
    }

    /// Names of the postures, each once.
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for posture in &self.all {
            if !names.contains(&posture.name.as_str()) {
                names.push(&posture.name);
            }
        }
        names
    }

    /// The word by which a value of joints names a posture: one that is no declared value. Beside a key of joints, only a group
    /// of the SRDF, or the name of a posture, makes it one.
    pub fn named_by<'v>(&self, value: &'v Value, key: Option<&str>, params: &Params) -> Option<&'v str> {
        if self.all.is_empty() {
            return None;
        }
        let word = text_of(value).filter(|word| !params.knows(word) && !RESERVED.contains(word))?;
        let known = || self.all.iter().any(|posture| posture.name == word);
        key.is_none_or(|key| key == "all" || self.groups.contains_key(key) || known()).then_some(word)
    }

    /// Positions of the posture with this name: that of the group `key`, or those of all groups without one, or with `all`.
    ///
    /// # Errors
    /// There is no such posture, or two groups give a joint different positions.
    pub fn positions(&self, name: &str, key: Option<&str>, at: Span) -> Result<Vec<PosturePosition>, Box<Diagnostic>> {
        let key = key.filter(|key| *key != "all");
        let fits = |posture: &&Posture| posture.name == name && key.is_none_or(|key| posture.group == key);
        let found: Vec<&Posture> = self.all.iter().filter(fits).collect();
        if found.is_empty() {
            return Err(Box::new(self.unknown(name, key, at)));
        }
        let mut given: BTreeMap<&str, (f64, &str)> = BTreeMap::new();
        for posture in &found {
            for (joint, x) in &posture.positions {
                if let Some((other, group)) = given.insert(joint, (*x, &posture.group)).filter(|(other, _)| other != x)
                {
                    let text =
                        format!("the postures `{name}` of `{group}` and `{}` contradict each other", posture.group);
                    let d = Diagnostic::error("HQ0207", at, text)
                        .note(format!("joint `{joint}` is at {other} in one of them, and at {x} in the other"));
                    let one = Snippet::braces([Snippet::entry(posture.group.as_str(), name)]);
                    return Err(Box::new(d.help(Help::with("name the posture of one group: {}", [one]))));
                }
            }
        }
        let mut out: Vec<PosturePosition> = Vec::new();
        let joints = found.iter().flat_map(|posture| self.groups.get(&posture.group).into_iter().flatten());
        // A joint that belongs to no group of the posture is given all the same.
        for joint in joints.map(String::as_str).chain(given.keys().copied()) {
            if out.iter().all(|known| known.joint != joint) {
                out.push(PosturePosition { joint: joint.to_string(), value: given.get(joint).map(|(x, _)| *x) });
            }
        }
        Ok(out)
    }

    fn unknown(&self, name: &str, key: Option<&str>, at: Span) -> Diagnostic {
        let of_group = |posture: &&Posture| key.is_none_or(|key| posture.group == key);
        let known: Vec<&str> = self.all.iter().filter(of_group).map(|posture| posture.name.as_str()).collect();
        let whose = key.map_or_else(|| "the robot's SRDF".to_string(), |key| format!("group `{key}` of the SRDF"));
        let d = Diagnostic::unknown_name(at, format!("{whose} has no posture `{name}`"));
        match suggest(name, known.iter().copied()) {
            Some(near) => d.meant(near),
            None if known.is_empty() => d.help(format!("postures are {}", list(self.names(), 12))),
            None => d.help(format!("it has {}", list(known, 12))),
        }
    }
}
