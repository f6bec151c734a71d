//! The description of a robot in a model that it was merged into.

use super::{DisabledPair, EndEffector, Group, PassiveJoint, Posture, Srdf, VirtualJoint};
use crate::Merged;

/// Group of all joints, which every robot has and no file declares.
const ALL: &str = "all";

impl Srdf {
    /// Returns the description for the model that the robot was merged into, with `prefix` before the names of groups and of
    /// end effectors. Postures keep their names.
    pub fn merged(&self, robot: Merged, prefix: &str) -> Srdf {
        let named = |name: &str| if name == ALL { name.to_string() } else { format!("{prefix}{name}") };
        let joint = |id: &crate::JointId| robot.joint(*id);
        Srdf {
            name: self.name.clone(),
            groups: self
                .groups
                .iter()
                .map(|group| Group {
                    name: named(&group.name),
                    joints: group.joints.iter().map(joint).collect(),
                    links: group.links.iter().map(|l| robot.link(*l)).collect(),
                    tip: group.tip.map(|l| robot.link(l)),
                    ..group.clone()
                })
                .collect(),
            end_effectors: self
                .end_effectors
                .iter()
                .map(|tool| EndEffector {
                    name: named(&tool.name),
                    group: named(&tool.group),
                    parent_link: robot.link(tool.parent_link),
                    parent_group: tool.parent_group.as_deref().map(named),
                })
                .collect(),
            postures: self
                .postures
                .iter()
                .map(|posture| Posture {
                    group: named(&posture.group),
                    positions: (posture.positions.iter())
                        .map(|position| super::Position { joint: joint(&position.joint), ..position.clone() })
                        .collect(),
                    ..posture.clone()
                })
                .collect(),
            passive: (self.passive.iter())
                .map(|passive| PassiveJoint { joint: joint(&passive.joint), ..passive.clone() })
                .collect(),
            virtual_joints: (self.virtual_joints.iter())
                .map(|j| VirtualJoint { child: robot.link(j.child), ..j.clone() })
                .collect(),
            disabled: (self.disabled.iter())
                .map(|pair| DisabledPair { links: pair.links.map(|l| robot.link(l)), ..pair.clone() })
                .collect(),
        }
    }
}
