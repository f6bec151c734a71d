//! Joints on the circle: a continuous joint without position limits is at the same place after each whole turn.
//!
//! Its position counts turns in a reference, while encoders often report it in (-pi, pi]. What is compared is therefore taken
//! modulo one turn: the difference of two positions lies in [-pi, pi].

use std::f64::consts::TAU;

use crate::{Drive, Joint, JointKind, Model};

/// Returns the angle in [-pi, pi] that differs from `angle` \[rad\] by whole turns. An angle in that interval is returned as
/// it is, both ends too.
pub fn nearest_turn(angle: f64) -> f64 {
    // Ties to even: half a turn keeps its sign.
    angle - TAU * (angle / TAU).round_ties_even()
}

impl Model {
    /// Returns true if a whole turn of the degree of freedom `dof` leads to the same place: it belongs to a continuous joint
    /// without position limits, and each joint that follows it makes whole turns too.
    pub fn is_on_circle(&self, dof: usize) -> bool {
        let Some(dof) = self.dofs.get(dof) else { return false };
        // Limits of the spec and of followers are those of the degree of freedom.
        dof.lower == f64::NEG_INFINITY
            && dof.upper == f64::INFINITY
            && dof.joint.is_some_and(|j| self.tape.circular[j.index()])
    }

    /// Adds whole turns to the positions of joints on the circle in `q`, so that each is at most half a turn from that in
    /// `reference`; both have length nq. Everything else stays as it is.
    pub fn unwind(&self, q: &mut [f64], reference: &[f64]) {
        for (_, d) in self.dofs.iter().enumerate().filter(|(dof, _)| self.is_on_circle(*dof)) {
            let Some(i) = d.q_index else { continue };
            let (Some(x), Some(near)) = (q.get_mut(i), reference.get(i)) else { continue };
            // A position within half a turn keeps every bit.
            if (*x - near).abs() > std::f64::consts::PI {
                *x = near + nearest_turn(*x - near);
            }
        }
    }
}

/// For each joint, true if a whole turn of it turns it and its followers to where they are, whatever their limits.
pub(crate) fn circular(joints: &[Joint]) -> Vec<bool> {
    let mut all: Vec<bool> = joints.iter().map(|j| j.kind == JointKind::Continuous).collect();
    let leaders: Vec<(usize, usize)> = joints
        .iter()
        .enumerate()
        .filter_map(|(k, j)| if let Drive::Dof(dof) = j.drive { Some((dof, k)) } else { None })
        .collect();
    for joint in joints {
        let Drive::Mimic { dof, multiplier, .. } = joint.drive else { continue };
        let turns = matches!(joint.kind, JointKind::Revolute | JointKind::Continuous) && multiplier.fract() == 0.0;
        if let Some((_, leader)) = leaders.iter().find(|(of, _)| *of == dof).filter(|_| !turns) {
            all[*leader] = false;
        }
    }
    all
}
