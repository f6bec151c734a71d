//! Points an axis of a frame at a point.
//!
//! ```text
//! d = (p_d - p) / |p_d - p|          direction to the point; a: the axis, in the world
//! Q: smallest rotation of a to d     e = log Q = θ k,  k = a × d / |a × d|
//! t_i·(ω + ω_a) - t_i·Q^T ω_d = K t_i·e,  i = 1, 2       with t_i orthogonal to a
//! ω_d = d × (p_d' - p') / |p_d - p|                      angular velocity of the direction
//! ```
//!
//! The two rows make `θ' = -K θ` exactly, with the axis on the great circle to the direction. Unlike the coordinates of
//! `d` in the frame, they are well conditioned everywhere, also half a turn away.
//!
//! Source: thesis (2.5) for the rotation vector of the smallest rotation; the transport of `ω_d` by `Q` is ours.

use nalgebra::{Unit, UnitQuaternion, Vector3};
use robot::LinkId;

use crate::bound::BoundParams;
use crate::build::check;
use crate::dimension::{ANGLE, LENGTH, NONE};
use crate::expression::Term;
use crate::expression_tasks::fault;
use crate::params::{Form, Input, Operand, ParamType, Presence};
use crate::task::{BuildError, Context, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};
use quantities::usual;

crate::params! {
    /// Parameters of `look_at`.
    pub struct Params {
        /// The frame: a link of the robot, such as that of a camera.
        frame: (String, LinkId) = ParamType::Frame, Presence::Required;
        /// p_d: the point, in the world; it may move, with time and with the robot.
        target: Operand = ParamType::Expression(Form::Vector(LENGTH)), Presence::Required;
        /// The axis that points at it, of any length, along the axes of the frame itself; it may move with time.
        axis: Input<3> = ParamType::Vector(NONE), Presence::Default("[0, 0, 1]");
        /// K: how fast the angle decays.
        gain: Input<1> = ParamType::Scalar(usual::GAIN), Presence::Default("2 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "look_at",
    summary: "points an axis of a frame at a point",
    docs: "Two equality rows; the rotation about the axis and the place of the frame stay free:\n\n\
```text\n\
d = (p_d - p) / |p_d - p|\n\
t·(ω + ω_a) - Q t·(d × (p_d' - p')) / |p_d - p| = K t·e        [rad/s]\n\n\
p, p_d  3×1  m      origin of the frame, and the point, in the world\n\
a       3×1         axis of the frame, in the world; ω_a: its angular velocity within the frame\n\
Q       3×3         smallest rotation of a to d;  e = log Q, with the angle θ between them\n\
t       3×1         two unit vectors orthogonal to a\n\
ω, p'   3×1         J_o v in rad/s and J_p v in m/s\n\
K       1/s         gain\n\
```\n\n\
The angle decays exactly, `θ' = -K θ`, on the shortest way: rows contain the rotation of the frame, its translation, \
and the motion of the point, of which the part with the robot, such as `target frame(hand).position`, is \
differentiated with respect to the configuration. The task reports `θ` in rad.\n\n\
Half a turn away all ways are equally short, and one of them is taken. If the point is at the origin of the frame, \
there is no direction: the rows are undefined, and the robot is left free.\n\n\
As a limit, a cone of sight is `keep(angle_between(frame(F).orientation*[0, 0, 1], p - frame(F).position)) { max 20 deg }`.\n\n\
Source: thesis (2.5) for the rotation vector of the smallest rotation; the transport of the direction's angular \
velocity by `Q` is ours.",
    example: "task watch = look_at(tool) { target [0.5, 0, 0] m  gain 2 /s }",
    positional: &["frame"],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

/// Distance in m below which the point has no direction.
const NEAREST: f64 = 1e-9;

/// Relative size of a coefficient that counts as rounding error: a point that the frame's own body carries moves with it.
const ROUNDING: f64 = 1e-12;

struct LookAt {
    link: LinkId,
    target: Term,
    axis: Input<3>,
    gain: Input<1>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.target.len() != 3 {
        return Err(BuildError::new("target", "`target` is a point"));
    }
    let axis = Vector3::from(params.axis.of(ctx.values));
    if axis.norm() < NEAREST {
        return Err(BuildError::new("axis", "an axis of zeros has no direction")
            .help("write the axis of the frame that points forwards, such as `[0, 0, 1]` for an optical frame"));
    }
    let target = Term::new(&params.target, ctx.model);
    Ok(Box::new(LookAt { link: params.frame.1, target, axis: params.axis, gain: params.gain }))
}

/// Two unit vectors that are orthogonal to a unit vector and to each other.
fn beside(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let first = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
    [first, axis.cross(&first)]
}

/// Smallest rotation between two unit vectors; for opposite ones, half a turn about `otherwise`.
fn smallest(from: &Vector3<f64>, to: &Vector3<f64>, otherwise: &Vector3<f64>) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let (normal, cosine) = (from.cross(to), from.dot(to));
    let sine = normal.norm();
    if sine < 1e-12 && cosine > 0.0 {
        return (UnitQuaternion::identity(), Vector3::zeros());
    }
    let about = if sine < 1e-12 { *otherwise } else { normal / sine };
    let vector = about * sine.atan2(cosine);
    (UnitQuaternion::from_axis_angle(&Unit::new_unchecked(about), sine.atan2(cosine)), vector)
}

impl Task for LookAt {
    fn rows(&self) -> Vec<RowInfo> {
        ["tilt_1", "tilt_2"].map(|name| RowInfo { name: name.to_string(), dimension: ANGLE }).into()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: String::new(), dimension: ANGLE }]
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn enter(&mut self, _state: &State) {
        self.target.forget();
    }

    crate::task::takes_over!(target);

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        self.target.forward(state).map_err(fault)?;
        let ([gain], pose) = (self.gain.of(state.values), state.data.pose(self.link));
        let (p, target) = (pose.translation.vector, self.target.vector(state));
        let own = Vector3::from(self.axis.of(state.values));
        let (distance, length) = ((target - p).norm(), own.norm());
        if !(distance.is_finite() && length > NEAREST && length.is_finite()) {
            return Err(TaskFault::NotFinite { row: 0 });
        }
        if distance < NEAREST {
            *rows.undefined = true;
            rows.measures[0] = f64::NAN;
            return Ok(());
        }
        let direction = (target - p) / distance;
        let axis = pose.rotation * (own / length);
        let turning = axis.cross(&(pose.rotation * Vector3::from(self.axis.of(state.rates)))) / length;
        let across = beside(&(own / length)).map(|t| pose.rotation * t);
        let (rotation, error) = smallest(&axis, &direction, &across[0]);
        for (i, t) in across.iter().enumerate() {
            let lever = (rotation * t).cross(&direction) / distance;
            let row = rows.row(i);
            state.data.add_angular(state.model, self.link, t, row);
            state.data.add_point(state.model, self.link, &p, &lever, row);
            let still = self.target.add_row(state, (-lever).as_slice(), row);
            let size = 1.0 + lever.norm() * (1.0 + p.norm() + target.norm());
            row.iter_mut().filter(|x| x.abs() <= ROUNDING * size).for_each(|x| *x = 0.0);
            rows.equal(i, gain * t.dot(&error) - t.dot(&turning) - still);
            if !rows.lower[i].is_finite() {
                return Err(TaskFault::NotFinite { row: i });
            }
        }
        rows.measures[0] = error.norm();
        Ok(())
    }
}
