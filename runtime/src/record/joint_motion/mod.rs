//! How smoothly joints move: the largest acceleration of each, jumps of its velocity, and reversals.
//!
//! The velocity is the one that the hierarchy chose, before the low-level layer adds its correction for the measured position:
//! limits of acceleration are about it, and noise of simulated sensors is not in it. The robot stands before the first tick.
//! An acceleration is the change of the velocity from a tick to the next, divided by the period.
//!
//! What enters a stack without a blend, and a fault, which commands zero, explain a jump: at that tick, and after a fault at the
//! next one. The largest acceleration counts these ticks like all others. [`reversals`] and [`jumps`] have the definitions.

mod jumps;
mod reversals;

use std::collections::BTreeMap;

use serde::Serialize;
use stdlib_tasks::dimension::{ACCELERATION, ANGULAR_ACCELERATION, Dimension};

use crate::controller::{Controller, Stage};
use crate::tick::{Recorder, Tick};
pub use jumps::Jumps;
use jumps::{Change, JumpCounter};
pub use reversals::Reversals;

/// How smoothly a joint moved, or a degree of freedom of the base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointMotion {
    /// The SI unit of its acceleration.
    pub unit: String,
    /// The largest acceleration.
    pub max_acceleration: f64,
    /// When it was, in s.
    pub at_s: f64,
    /// Ticks at which the velocity jumped.
    pub jumps: usize,
    /// When it first did, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_jump_s: Option<f64>,
    /// How often the joint turned round and back within 0.2 s.
    pub reversals: usize,
    /// When it first did, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_reversal_s: Option<f64>,
}

impl JointMotion {
    /// Whether it jumped or reversed.
    pub fn is_rough(&self) -> bool {
        self.jumps > 0 || self.reversals > 0
    }
}

/// What is known of a joint so far.
struct Joint {
    name: String,
    dimension: Dimension,
    /// The largest change of its velocity in a tick, in rad/s or m/s, and when, in s.
    change: f64,
    at: f64,
    jumps: JumpCounter,
    reversals: Reversals,
}

/// Measures them during a run, without allocating.
pub struct JointMotionRecorder {
    period: f64,
    joints: Vec<Joint>,
    /// For each stage the limit of each degree of freedom's acceleration; infinite if there is none.
    limits: Vec<Vec<f64>>,
    /// The velocity of the tick before.
    before: Vec<f64>,
    /// The visit to a stack of the tick before.
    visit: Option<u64>,
    /// There was a fault at the tick before.
    fault: bool,
}

impl JointMotionRecorder {
    /// For a run of this controller.
    pub fn new(controller: &Controller) -> Self {
        let period = controller.period();
        let dofs = &controller.evaluator().model().dofs;
        let joint = |d: &robot::Dof| Joint {
            name: d.name.clone(),
            dimension: match d.unit {
                robot::DofUnit::Metre => ACCELERATION,
                robot::DofUnit::Radian => ANGULAR_ACCELERATION,
            },
            change: 0.0,
            at: 0.0,
            jumps: JumpCounter::new(d.velocity, period),
            reversals: Reversals::new(d.velocity),
        };
        let limits = |stage: &Stage| stage.evaluator().acceleration_limits();
        JointMotionRecorder {
            period,
            joints: dofs.iter().map(joint).collect(),
            limits: controller.stages().iter().map(limits).collect(),
            before: vec![0.0; dofs.len()],
            visit: None,
            fault: false,
        }
    }

    /// How smoothly each joint moved so far, by its name.
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
        let explained = entered || fault || self.fault;
        let limits = &self.limits[tick.stage];
        let joints = self.joints.iter_mut().zip(&mut self.before).zip(tick.v).zip(limits);
        for (((joint, before), &now), &limit) in joints {
            let change = (now - *before).abs();
            if change > joint.change {
                (joint.change, joint.at) = (change, tick.time);
            }
            joint.jumps.tick(Change { time: tick.time, before: *before, now, limit }, explained);
            joint.reversals.tick(now, tick.time);
            *before = now;
        }
        (self.visit, self.fault) = (visit, fault);
        Ok(())
    }
}
