//! Pulls the origin of a frame to a target position; its orientation is free.

use robot::LinkId;

use crate::axis_rows::{AXIS_WEIGHT, Axes, AxisRows};
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
        /// Axes along which the position is controlled; the other ones are free. Without it, all three.
        axes: Option<Axes> = ParamType::Axes, Presence::Optional;
        /// Frame whose axes these are; without it, those of the world.
        axes_of: Option<(String, LinkId)> = ParamType::Frame, Presence::Optional;
        /// Weights of the squared errors along the three axes, relative to other rows of the level, or one for all.
        axis_weights: Option<Input<3>> = ParamType::PerAxis(AXIS_WEIGHT), Presence::Optional;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "frame_position",
    summary: "pulls the origin of a frame to a target position",
    docs: "Three equality rows in the world's axes, or those of the chosen `axes`; the orientation of the frame stays \
free:\n\n\
```text\n\
J_p v = p_d' + K (p_d - p)        [m/s]\n\n\
p, p_d  3×1  m              position of the frame's origin in the world, and its target\n\
p_d'    3×1  m/s            exact time derivative of the target\n\
J_p     3×n  m/rad or m/m   Jacobian of the frame's origin in the world's axes\n\
v       n×1  rad/s or m/s   velocity of the n degrees of freedom\n\
K       1/s                 gain\n\
```\n\n\
The task reports the error `|p_d - p|` in m.\n\n\
`axes [x, y]` leaves the other axes free, as the mask of TSID does. With `axes_of FRAME` they are the axes of that \
frame, which may be the controlled one; the row of an axis `n` then is the exact derivative of `n·(p_d - p)`, with \
the rotation of `n`, so that an error along a free axis disturbs no other one. `axis_weights [1, 1, 0.1]`, as the cost \
vectors of Pink, has an effect where not all rows of a level can be met: the squared error along z counts a tenth. The \
weight of the task in its level multiplies them. On a hard level weights have no effect (`HQ0625`). The task reports \
the norm of the error along the chosen axes.\n\n\
Source: thesis (2.5), (3.33), (3.34); chosen axes are ours.",
    example: "task reach = frame_position(tool) { position initial(position) + [0, 0, 0.1] m }",
    positional: &["frame"],
    current_values: &[CurrentValue::in_world("position", CurrentValueType::Vector(LENGTH))],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct FramePosition {
    params: Params,
    axes: AxisRows,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let axes = AxisRows::new(params.axes, params.axes_of.as_ref().map(|f| f.1), params.axis_weights, ctx);
    Ok(Box::new(FramePosition { params, axes }))
}

impl Task for FramePosition {
    fn rows(&self) -> Vec<RowInfo> {
        self.axes.of_all(&pose_rows("")[..3])
    }

    fn row_weights(&self) -> Vec<f64> {
        self.axes.weights()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: "position".to_string(), dimension: LENGTH }]
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.params.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [gain] = self.params.gain.of(state.values);
        let target = clik::position_target(state, self.params.position);
        rows.measures[0] = self.axes.position(state, rows, 0, self.params.frame.1, &target, gain);
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        name == "position" && current_pose(name, self.params.frame.1, state, out)
    }
}
