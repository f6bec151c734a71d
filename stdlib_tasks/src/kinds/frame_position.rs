//! Pulls the origin of a frame to a target position; its orientation is free.

use robot::LinkId;

use crate::bound::BoundParams;
use crate::build::check;
use crate::clik;
use crate::dimension::LENGTH;
use crate::kinds::frame_pose::{current_pose, pose_rows};
use crate::params::{Input, ParamType, Presence};
use crate::task::{
    BuildError, Context, CurrentValue, CurrentValueType, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault,
    TaskKind,
};
use quantities::usual;

crate::params! {
    /// Parameters of `frame_position`.
    pub struct Params {
        /// The frame: a link of the robot.
        frame: (String, LinkId) = ParamType::Frame, Presence::Required;
        /// Target position of the frame's origin in the world; it may move with time.
        position: Input<3> = ParamType::Vector(LENGTH), Presence::Required;
        /// K: how fast the error decays.
        gain: Input<1> = ParamType::Scalar(usual::GAIN), Presence::Default("2 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "frame_position",
    summary: "pulls the origin of a frame to a target position",
    docs: "Three equality rows in the world's axes; the orientation of the frame stays free:\n\n\
```text\n\
J_p v = p_d' + K (p_d - p)        [m/s]\n\n\
p, p_d  3×1  m              position of the frame's origin in the world, and its target\n\
p_d'    3×1  m/s            exact time derivative of the target\n\
J_p     3×n  m/rad or m/m   Jacobian of the frame's origin in the world's axes\n\
v       n×1  rad/s or m/s   velocity of the n degrees of freedom\n\
K       1/s                 gain\n\
```\n\n\
The task reports the error `|p_d - p|` in m.\n\n\
Source: thesis (2.5), (3.33), (3.34).",
    example: "task reach = frame_position(tool) { position initial(position) + [0, 0, 0.1] m }",
    positional: &["frame"],
    current_values: &[CurrentValue::in_world("position", CurrentValueType::Vector(LENGTH))],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct FramePosition(Params);

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    Ok(Box::new(FramePosition(Params::from_bound(bound)?)))
}

impl Task for FramePosition {
    fn rows(&self) -> Vec<RowInfo> {
        pose_rows("").into_iter().take(3).collect()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: "position".to_string(), dimension: LENGTH }]
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.0.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [gain] = self.0.gain.of(state.values);
        let target = clik::position_target(state, self.0.position);
        rows.measures[0] = clik::position(state, rows, 0, self.0.frame.1, &target, gain);
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        name == "position" && current_pose(name, self.0.frame.1, state, out)
    }
}
