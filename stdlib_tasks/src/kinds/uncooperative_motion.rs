//! Moves two arms independently of each other.

use robot::LinkId;

use crate::bound::{Arm, BoundParams};
use crate::build::check;
use crate::clik;
use crate::dimension::LENGTH;
use crate::kinds::frame_pose::{current_pose, pose_measures, pose_rows};
use crate::params::{Input, ParamType, Presence};
use crate::task::{
    BuildError, Context, CurrentValue, CurrentValueType, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault,
    TaskKind,
};

crate::params! {
    /// Target pose of one arm's tip in the world.
    pub struct Pose {
        /// Target position; it may move with time.
        position: Input<3> = ParamType::Vector(LENGTH), Presence::Required;
        /// Target orientation; it may move with time.
        orientation: Input<4> = ParamType::Rotation, Presence::Required;
    }
}

crate::params! {
    /// Parameters of `uncooperative_motion`.
    pub struct Params {
        /// The left arm.
        left_arm: Arm = ParamType::Arm, Presence::Default("left");
        /// The right arm.
        right_arm: Arm = ParamType::Arm, Presence::Default("right");
        /// Target pose of the left arm's tip.
        left: BoundParams = ParamType::Group(Pose::INFO), Presence::Required;
        /// Target pose of the right arm's tip.
        right: BoundParams = ParamType::Group(Pose::INFO), Presence::Required;
        /// K: how fast the errors decay.
        gain: Input<2> = ParamType::Gains(&["linear", "angular"]), Presence::Default("2 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "uncooperative_motion",
    summary: "moves two arms independently of each other",
    docs: "Twelve equality rows in the world's axes: the pose of the left tip, then that of the right tip. For \
each tip they are the six rows of `frame_pose`,\n\n\
```text\n\
J_p v = p_d' + K_linear  (p_d - p)        [m/s]\n\
J_o v = ω_d  + K_angular log(R_d R^T)     [rad/s]\n\
```\n\n\
with the symbols, frames and units of that page, for the pose (p, R) of the tip in the world. The task reports \
the two errors of each tip. It is `cooperative_motion` with `beta 0` and `alpha 1`.\n\n\
Source: thesis (3.7), (3.25), (3.33), (3.34).",
    example: "task motion = uncooperative_motion {\n  \
left  { position initial(left.position)   orientation initial(left.orientation) }\n  \
right { position initial(right.position)  orientation initial(right.orientation) }\n}",
    current_values: &[
        CurrentValue::in_world("left.position", CurrentValueType::Vector(LENGTH)),
        CurrentValue::in_world("left.orientation", CurrentValueType::Rotation),
        CurrentValue::in_world("right.position", CurrentValueType::Vector(LENGTH)),
        CurrentValue::in_world("right.orientation", CurrentValueType::Rotation),
    ],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct UncooperativeMotion {
    sides: [(LinkId, Pose); 2],
    gain: Input<2>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.left_arm.tip == params.right_arm.tip {
        return Err(BuildError::new("right_arm", "both arms end in the same tip").help("name two different arms"));
    }
    let left = Pose::from_bound(&params.left)?;
    let right = Pose::from_bound(&params.right)?;
    let sides = [(params.left_arm.tip, left), (params.right_arm.tip, right)];
    Ok(Box::new(UncooperativeMotion { sides, gain: params.gain }))
}

impl Task for UncooperativeMotion {
    fn rows(&self) -> Vec<RowInfo> {
        ["left.", "right."].iter().flat_map(|p| pose_rows(p)).collect()
    }

    fn measures(&self) -> Vec<Measure> {
        ["left.", "right."].iter().flat_map(|p| pose_measures(p)).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [linear, angular] = self.gain.of(state.values);
        for (i, (link, pose)) in self.sides.iter().enumerate() {
            let target = clik::position_target(state, pose.position);
            rows.measures[2 * i] = clik::position(state, rows, 6 * i, *link, &target, linear);
            let target = clik::orientation_target(state, pose.orientation);
            rows.measures[2 * i + 1] = clik::orientation(state, rows, 6 * i + 3, *link, &target, angular);
        }
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        match name.split_once('.') {
            Some(("left", part)) => current_pose(part, self.sides[0].0, state, out),
            Some(("right", part)) => current_pose(part, self.sides[1].0, state, out),
            _ => false,
        }
    }
}
