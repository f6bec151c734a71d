//! Pulls a frame to a target pose.

use robot::LinkId;

use crate::axis_rows::{AXIS_WEIGHT, Axes, AxisRows};
use crate::bound::BoundParams;
use crate::build::check;
use crate::clik;
use crate::compliance::read;
use crate::dimension::{ANGLE, LENGTH};
use crate::numbers;
use crate::params::{Input, ParamType, Presence};
use crate::task::{
    BuildError, Context, CurrentValue, CurrentValueType, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault,
    TaskKind,
};

crate::params! {
    /// Controlled axes of a pose.
    pub struct PoseAxes {
        /// Axes along which the position is controlled. Without it, all three.
        linear: Option<Axes> = ParamType::Axes, Presence::Optional;
        /// Axes about which the orientation is controlled. Without it, all three.
        angular: Option<Axes> = ParamType::Axes, Presence::Optional;
    }
}

crate::params! {
    /// Weights of the axes of a pose.
    pub struct PoseAxisWeights {
        /// Weights of the squared errors along the three axes, or one for all.
        linear: Option<Input<3>> = ParamType::PerAxis(AXIS_WEIGHT), Presence::Optional;
        /// Weights of the squared errors about the three axes, or one for all.
        angular: Option<Input<3>> = ParamType::PerAxis(AXIS_WEIGHT), Presence::Optional;
    }
}

crate::params! {
    /// Parameters of `frame_pose`.
    pub struct Params {
        /// The frame: a link of the robot.
        frame: (String, LinkId) = ParamType::Frame, Presence::Required;
        /// Target position of the frame's origin in the world; it may move with time.
        position: Input<3> = ParamType::Vector(LENGTH), Presence::Required;
        /// Target orientation of the frame in the world; it may move with time.
        orientation: Input<4> = ParamType::Rotation, Presence::Default("initial(orientation)");
        /// K: how fast the errors decay.
        gain: Input<2> = ParamType::Gains(&["linear", "angular"]), Presence::Default("2 /s");
        /// Controlled axes; the other ones are free. Without it, all.
        axes: Option<BoundParams> = ParamType::Group(PoseAxes::INFO), Presence::Optional;
        /// Frame whose axes these are; without it, those of the world.
        axes_of: Option<(String, LinkId)> = ParamType::Frame, Presence::Optional;
        /// Weights of the squared errors along and about the axes, relative to other rows of the level.
        axis_weights: Option<BoundParams> = ParamType::Group(PoseAxisWeights::INFO), Presence::Optional;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "frame_pose",
    summary: "pulls a frame to a target pose",
    docs: "Six equality rows, three for the position and three for the orientation, in the world's axes:\n\n\
```text\n\
J_p v = p_d' + K_linear  (p_d - p)        [m/s]\n\
J_o v = ω_d  + K_angular log(R_d R^T)     [rad/s]\n\n\
p, p_d     3×1  m                    position of the frame's origin in the world, and its target\n\
R, R_d     3×3                       orientation of the frame in the world, and its target\n\
J_p        3×n  m/rad or m/m         Jacobian of the frame's origin in the world's axes\n\
J_o        3×n  rad/rad or rad/m     Jacobian of the frame's angular velocity in the world's axes\n\
p_d', ω_d  3×1  m/s, rad/s           exact time derivative and angular velocity of the target\n\
log        3×1  rad                  rotation vector, with an angle of at most pi: the shortest way\n\
v          n×1  rad/s or m/s         velocity of the n degrees of freedom\n\
K          1/s                       gain\n\
```\n\n\
The task reports the errors `|p_d - p|` in m and `|log(R_d R^T)|` in rad. `initial(position)` and \
`initial(orientation)` are the frame's own pose at the moment the stack became active.\n\n\
`axes { linear [x, y]  angular z }` leaves the other axes free, as the mask of TSID does; with `axes_of FRAME` they are \
the axes of that frame. `axis_weights { linear [1, 1, 0.1]  angular 0.5 }`, as the costs of Pink, has an effect where \
not all rows of a level can be met. `frame_position` and `frame_orientation` describe both.\n\n\
Source: thesis (2.5), (3.33), (3.34); chosen axes are ours.",
    example: "task reach = frame_pose(tool) { position initial(position) + [0, 0, 0.1] m  gain { linear 5 /s  angular 2 /s } }",
    positional: &["frame"],
    current_values: &[
        CurrentValue::in_world("position", CurrentValueType::Vector(LENGTH)),
        CurrentValue::in_world("orientation", CurrentValueType::Rotation),
    ],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct FramePose {
    link: LinkId,
    params: Params,
    linear: AxisRows,
    angular: AxisRows,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let none = BoundParams::new();
    let axes = read("axes", params.axes.as_ref().unwrap_or(&none), PoseAxes::from_bound)?;
    let weights = read("axis_weights", params.axis_weights.as_ref().unwrap_or(&none), PoseAxisWeights::from_bound)?;
    let of = params.axes_of.as_ref().map(|f| f.1);
    Ok(Box::new(FramePose {
        link: params.frame.1,
        linear: AxisRows::new(axes.linear, of, weights.linear, ctx),
        angular: AxisRows::new(axes.angular, of, weights.angular, ctx),
        params,
    }))
}

/// Names and dimensions of the six rows of a pose, with a prefix such as `left.`.
pub(crate) fn pose_rows(prefix: &str) -> Vec<RowInfo> {
    ["x", "y", "z", "rx", "ry", "rz"]
        .iter()
        .enumerate()
        .map(|(i, axis)| RowInfo { name: format!("{prefix}{axis}"), dimension: if i < 3 { LENGTH } else { ANGLE } })
        .collect()
}

/// The two errors of a pose, with a prefix such as `left.`.
pub(crate) fn pose_measures(prefix: &str) -> Vec<Measure> {
    vec![
        Measure { name: format!("{prefix}position"), dimension: LENGTH },
        Measure { name: format!("{prefix}orientation"), dimension: ANGLE },
    ]
}

/// Writes the pose of a link as `initial(position)` or `initial(orientation)` captures it; false for another part.
pub(crate) fn current_pose(part: &str, link: LinkId, state: &State, out: &mut [f64]) -> bool {
    let pose = state.data.pose(link);
    match part {
        "position" => numbers::write_vector(&pose.translation.vector, out),
        "orientation" => numbers::write_rotation(&pose.rotation, out),
        _ => return false,
    }
    true
}

impl Task for FramePose {
    fn rows(&self) -> Vec<RowInfo> {
        let all = pose_rows("");
        [self.linear.of_all(&all[..3]), self.angular.of_all(&all[3..])].concat()
    }

    fn row_weights(&self) -> Vec<f64> {
        [self.linear.weights(), self.angular.weights()].concat()
    }

    fn measures(&self) -> Vec<Measure> {
        pose_measures("")
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.params.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [linear, angular] = self.params.gain.of(state.values);
        let target = clik::position_target(state, self.params.position);
        rows.measures[0] = self.linear.position(state, rows, 0, self.link, &target, linear);
        let target = clik::orientation_target(state, self.params.orientation);
        rows.measures[1] = self.angular.orientation(state, rows, self.linear.len(), self.link, &target, angular);
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        current_pose(name, self.link, state, out)
    }
}
