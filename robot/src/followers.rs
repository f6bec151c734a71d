//! Limits of followers as limits of the degree of freedom that they follow.
//!
//! A follower at `m q + o` stays within `a..b` where `q` stays within `(a - o)/m .. (b - o)/m`, the ends swapped if `m < 0`.
//! It is no faster than `v` where `|q̇| <= v/|m|`; the same holds for its acceleration.

use crate::{Drive, Joint, JointId, Model};

/// Tolerance of the position and the speed of a follower: multipliers are written rounded \[rad, m, or either per second\].
pub const ROUNDING: f64 = 1e-6;

/// Limits of a joint or of a degree of freedom; infinite if there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Lowest position \[rad or m\].
    pub lower: f64,
    /// Highest position \[rad or m\].
    pub upper: f64,
    /// Maximum speed \[rad/s or m/s\].
    pub velocity: f64,
    /// Maximum acceleration \[rad/s² or m/s²\].
    pub acceleration: f64,
}

impl Limits {
    /// No limits.
    pub const NONE: Limits =
        Limits { lower: f64::NEG_INFINITY, upper: f64::INFINITY, velocity: f64::INFINITY, acceleration: f64::INFINITY };

    /// Returns true if no two positions are within the limits.
    pub fn leave_no_motion(&self) -> bool {
        self.lower >= self.upper
    }

    /// Returns the limits of a leader whose follower at `multiplier * q + offset` has these. A multiplier of zero gives none.
    pub(crate) fn of_leader(self, multiplier: f64, offset: f64) -> Limits {
        if multiplier == 0.0 {
            return Limits::NONE;
        }
        let [a, b] = [self.lower, self.upper].map(|x| (x - offset) / multiplier);
        let size = multiplier.abs();
        Limits {
            lower: a.min(b),
            upper: a.max(b),
            velocity: self.velocity / size,
            acceleration: self.acceleration / size,
        }
    }

    /// Returns these limits within those that a follower with this multiplier sets. Differences below [`ROUNDING`] of the
    /// follower change nothing.
    pub(crate) fn narrowed(self, by: Limits, multiplier: f64) -> Limits {
        let rounding = ROUNDING / multiplier.abs();
        let least = |own: f64, other: f64| if other < own - rounding { other } else { own };
        Limits {
            lower: if by.lower > self.lower + rounding { by.lower } else { self.lower },
            upper: least(self.upper, by.upper),
            velocity: least(self.velocity, by.velocity),
            acceleration: least(self.acceleration, by.acceleration),
        }
    }
}

impl Joint {
    /// Returns the limits of the joint itself.
    pub fn limits(&self) -> Limits {
        Limits { lower: self.lower, upper: self.upper, velocity: self.velocity, acceleration: self.acceleration }
    }
}

/// Returns the limits of the joint `k` within those of its followers.
pub(crate) fn with_followers(joints: &[Joint], k: usize) -> Limits {
    let Drive::Dof(leader) = joints[k].drive else { return joints[k].limits() };
    joints.iter().fold(joints[k].limits(), |limits, joint| match joint.drive {
        Drive::Mimic { dof, multiplier, offset } if dof == leader => {
            limits.narrowed(joint.limits().of_leader(multiplier, offset), multiplier)
        }
        _ => limits,
    })
}

impl Model {
    /// Returns the joints that follow the degree of freedom `dof`, in the order of the model.
    pub fn followers(&self, dof: usize) -> impl Iterator<Item = JointId> {
        let follows = move |joint: &Joint| matches!(joint.drive, Drive::Mimic { dof: leader, .. } if leader == dof);
        self.joints.iter().enumerate().filter(move |(_, joint)| follows(joint)).map(|(k, _)| JointId(k as u32))
    }

    /// Returns the limits that the limits of `joint` set on the degree of freedom that moves it; none for one that stays still.
    pub fn limits_of_leader(&self, joint: JointId) -> Limits {
        let joint = self.joint_ref(joint);
        match joint.drive {
            Drive::Dof(_) => joint.limits(),
            Drive::Mimic { multiplier, offset, .. } => joint.limits().of_leader(multiplier, offset),
            Drive::Fixed | Drive::Locked(_) => Limits::NONE,
        }
    }

    /// Sets the limits of a joint. Those of the degree of freedom that moves it become the limits of its joint within those
    /// of all its followers; they may cross.
    pub fn set_limits(&mut self, joint: JointId, limits: Limits) {
        let own = &mut self.joints[joint.index()];
        (own.lower, own.upper) = (limits.lower, limits.upper);
        (own.velocity, own.acceleration) = (limits.velocity, limits.acceleration);
        let (Drive::Dof(dof) | Drive::Mimic { dof, .. }) = own.drive else { return };
        let Some(leader) = self.dofs[dof].joint else { return };
        let kept = with_followers(&self.joints, leader.index());
        let dof = &mut self.dofs[dof];
        (dof.lower, dof.upper) = (kept.lower, kept.upper);
        (dof.velocity, dof.acceleration) = (kept.velocity, kept.acceleration);
    }
}
