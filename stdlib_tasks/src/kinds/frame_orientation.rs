//! Pulls a frame to a target orientation; its position is free.

use robot::LinkId;

use crate::axis_rows::{AXIS_WEIGHT, Axes, AxisRows};
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
        /// Axes about which the orientation is controlled; the other ones are free. Without it, all three.
        axes: Option<Axes> = ParamType::Axes, Presence::Optional;
        /// Frame whose axes these are; without it, those of the world.
        axes_of: Option<(String, LinkId)> = ParamType::Frame, Presence::Optional;
        /// Weights of the squared errors about the three axes, relative to other rows of the level, or one for all.
        axis_weights: Option<Input<3>> = ParamType::PerAxis(AXIS_WEIGHT), Presence::Optional;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "frame_orientation",
    summary: "pulls a frame to a target orientation",
    docs: "Three equality rows in the world's axes, or those of the chosen `axes`; the position of the frame stays \
free:\n\n\
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
`axes [x, y]` controls these components of the rotation vector `φ = log(R_d R^T)` only, along the world's axes or, with \
`axes_of FRAME`, those of a frame. Each decays by itself, with the exact derivative of `log`:\n\n\
```text\n\
n·J_l(φ)^-T ω - ω_A·(n × φ) = n·J_l(φ)^-1 ω_d + K n·φ        J_l: left Jacobian of the rotation group\n\
```\n\n\
To point one axis of a frame, with the rotation about it free however large, a direction is simpler: \
`track(frame(F).orientation*[0, 0, 1])`. `axis_weights [1, 1, 0.1]` has an effect where not all rows of a level can be \
met: the squared error about z counts a tenth. The weight of the task in its level multiplies them. On a hard level \
weights have no effect (`HQ0625`). The task reports the norm of the error about the chosen axes.\n\n\
Source: thesis (2.5), (3.33), (3.34); chosen axes are ours, the Jacobian of `log` as in Solà, Deray, Atchuthan, A micro \
Lie theory (2018), (145), (146).",
    example: "task level_tool = frame_orientation(tool) { orientation rpy(0 deg, 90 deg, 0 deg) }",
    positional: &["frame"],
    current_values: &[CurrentValue::in_world("orientation", CurrentValueType::Rotation)],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct FrameOrientation {
    params: Params,
    axes: AxisRows,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let axes = AxisRows::new(params.axes, params.axes_of.as_ref().map(|f| f.1), params.axis_weights, ctx);
    Ok(Box::new(FrameOrientation { params, axes }))
}

impl Task for FrameOrientation {
    fn rows(&self) -> Vec<RowInfo> {
        self.axes.of_all(&pose_rows("")[3..])
    }

    fn row_weights(&self) -> Vec<f64> {
        self.axes.weights()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: "orientation".to_string(), dimension: ANGLE }]
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.params.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [gain] = self.params.gain.of(state.values);
        let target = clik::orientation_target(state, self.params.orientation);
        rows.measures[0] = self.axes.orientation(state, rows, 0, self.params.frame.1, &target, gain);
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        name == "orientation" && current_pose(name, self.params.frame.1, state, out)
    }
}
