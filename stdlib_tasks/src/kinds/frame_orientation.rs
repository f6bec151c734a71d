//! Pulls a frame to a target orientation; its position is free.

use robot::LinkId;

use crate::bound::BoundParams;
use crate::build::check;
use crate::clik;
use crate::dimension::ANGLE;
use crate::kinds::frame_pose::{current_pose, pose_rows};
use crate::params::{Input, ParamType, Presence};
use crate::task::{
    BuildError, Context, CurrentValue, CurrentValueType, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault,
    TaskKind,
};
use quantities::usual;

crate::params! {
    /// Parameters of `frame_orientation`.
    pub struct Params {
        /// The frame: a link of the robot.
        frame: (String, LinkId) = ParamType::Frame, Presence::Required;
        /// Target orientation of the frame in the world; it may move with time.
        orientation: Input<4> = ParamType::Rotation, Presence::Required;
        /// K: how fast the error decays.
        gain: Input<1> = ParamType::Scalar(usual::GAIN), Presence::Default("2 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "frame_orientation",
    summary: "pulls a frame to a target orientation",
    docs: "Three equality rows in the world's axes; the position of the frame stays free:\n\n\
```text\n\
J_o v = ω_d + K log(R_d R^T)      [rad/s]\n\n\
R, R_d  3×3                    orientation of the frame in the world, and its target\n\
ω_d     3×1  rad/s             angular velocity of the target in the world's axes\n\
J_o     3×n  rad/rad or rad/m  Jacobian of the frame's angular velocity in the world's axes\n\
log     3×1  rad               rotation vector, with an angle of at most pi: the shortest way\n\
v       n×1  rad/s or m/s      velocity of the n degrees of freedom\n\
K       1/s                    gain\n\
```\n\n\
At an angle of exactly pi both ways are equally short, and either may be taken. The task reports the error \
`|log(R_d R^T)|` in rad.\n\n\
Source: thesis (2.5), (3.33), (3.34).",
    example: "task level_tool = frame_orientation(tool) { orientation rpy(0 deg, 90 deg, 0 deg) }",
    positional: &["frame"],
    current_values: &[CurrentValue::in_world("orientation", CurrentValueType::Rotation)],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct FrameOrientation(Params);

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    Ok(Box::new(FrameOrientation(Params::from_bound(bound)?)))
}

impl Task for FrameOrientation {
    fn rows(&self) -> Vec<RowInfo> {
        pose_rows("").into_iter().skip(3).collect()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: "orientation".to_string(), dimension: ANGLE }]
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.0.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [gain] = self.0.gain.of(state.values);
        let target = clik::orientation_target(state, self.0.orientation);
        rows.measures[0] = clik::orientation(state, rows, 0, self.0.frame.1, &target, gain);
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        name == "orientation" && current_pose(name, self.0.frame.1, state, out)
    }
}
