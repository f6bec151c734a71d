//! Smoothness of the motion of joints: the largest acceleration of each, jumps of its velocity, and reversals.
//!
//! The velocity is the one that the hierarchy chose, before the low-level layer adds its correction for the measured
//! position: limits of acceleration apply to it, and it contains no noise of simulated sensors. The robot is at rest
//! before the first tick. An acceleration is the change of the velocity from a tick to the next, divided by the period.
//!
//! The entry of a stack without a blend explains a jump at that tick. A fault, which commands zero, explains a jump at
//! that tick and at the next one, as drives do that are switched off. The largest acceleration includes these ticks. [`reversals`] and [`jumps`] contain
//! the definitions.

mod jumps;
mod reversals;

use std::collections::BTreeMap;

use serde::Serialize;
use stdlib_tasks::dimension::{ACCELERATION, ANGULAR_ACCELERATION, Dimension};

use crate::controller::{Controller, StackController};
use crate::tick::{Recorder, Tick};
pub use jumps::Jumps;
use jumps::{JumpCounter, VelocityChange};
pub use reversals::Reversals;

/// Smoothness of the motion of a joint, or of a degree of freedom of the base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointMotion {
    /// The SI unit of its acceleration.
    pub unit: String,
    /// Largest acceleration.
    pub max_acceleration: f64,
    /// Time of the largest acceleration, in s.
    pub at_s: f64,
    /// Number of ticks at which the velocity jumped.
    pub jumps: usize,
    /// Time of the first jump, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_jump_s: Option<f64>,
    /// Number of reversals: the joint turned round and back within 0.2 s.
    pub reversals: usize,
    /// Time of the first reversal, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_reversal_s: Option<f64>,
}

impl JointMotion {
    /// Returns true if it jumped or reversed.
    pub fn is_rough(&self) -> bool {
        self.jumps > 0 || self.reversals > 0
    }
}

/// Measurements of a joint so far.
struct Joint {
    name: String,
    dimension: Dimension,
    /// Largest change of its velocity in a tick, in rad/s or m/s, and the time of that tick, in s.
    change: f64,
    at: f64,
    jumps: JumpCounter,
    reversals: Reversals,
}

/// Measures the smoothness of the joints during a run, without allocating.
pub struct JointMotionRecorder {
    period: f64,
    joints: Vec<Joint>,
    /// Limit of each degree of freedom's acceleration, for each stack; infinite if there is none.
    limits: Vec<Vec<f64>>,
    /// Velocity at the previous tick.
    before: Vec<f64>,
    /// Visit to a stack at the previous tick.
    visit: Option<u64>,
    /// True if there was a fault at the previous tick.
    fault: bool,
}

impl JointMotionRecorder {
    /// Prepares for a run of this controller.
    pub fn new(controller: &Controller) -> Self {
        let period = controller.period();
        let dofs = &controller.evaluator().model().dofs;
        let joint = |d: &robot::Dof| Joint {
            name: d.name.clone(),
            dimension: d.unit.select(ACCELERATION, ANGULAR_ACCELERATION),
            change: 0.0,
            at: 0.0,
            jumps: JumpCounter::new(d.velocity, period),
            reversals: Reversals::new(d.velocity),
        };
        let limits = |stack: &StackController| stack.evaluator().acceleration_limits();
        JointMotionRecorder {
            period,
            joints: dofs.iter().map(joint).collect(),
            limits: controller.stacks().iter().map(limits).collect(),
            before: vec![0.0; dofs.len()],
            visit: None,
            fault: false,
        }
    }

    /// Smoothness of the motion of each joint so far, by its name.
    pub fn result(&self) -> BTreeMap<String, JointMotion> {
        let one = |joint: &Joint| {
            let (jumps, reversals) = (joint.jumps.result(), &joint.reversals);
            let motion = JointMotion {
                unit: joint.dimension.to_string(),
                max_acceleration: joint.change / self.period,
                at_s: joint.at,
                jumps: jumps.count,
                first_jump_s: jumps.first,
                reversals: reversals.count(),
                first_reversal_s: reversals.first(),
            };
            (joint.name.clone(), motion)
        };
        self.joints.iter().map(one).collect()
    }
}

impl Recorder for JointMotionRecorder {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let visit = Some(tick.controller.visit());
        let entered = self.visit != visit && !tick.controller.is_blending();
        let fault = tick.fault.is_some();
        let explained = entered || fault || self.fault || !tick.controller.is_enabled();
        let limits = &self.limits[tick.stack];
        let joints = self.joints.iter_mut().zip(&mut self.before).zip(tick.v).zip(limits);
        for (((joint, before), &now), &limit) in joints {
            let change = (now - *before).abs();
            if change > joint.change {
                (joint.change, joint.at) = (change, tick.time);
            }
            joint.jumps.tick(VelocityChange { time: tick.time, before: *before, now, limit }, explained);
            joint.reversals.tick(now, tick.time);
            *before = now;
        }
        (self.visit, self.fault) = (visit, fault);
        Ok(())
    }
}
