//! Moves two arms together: the pose of a frame between them and the pose of one relative to the other.
//!
//! ```text
//! p_a = α p_l + (1 - α) p_r                    absolute position      thesis (3.27)
//! R_a = R_l exp((1 - α) log(R_l^T R_r))        absolute orientation   thesis (3.28)
//! p_rel = p_r - β p_l        in the world      thesis (3.29), (3.31)
//!       = R_l^T (p_r - p_l)  in the left tool  if β = 1 and `relative_to left`
//! R_rel = R_l^T R_r  if β = 1,  R_r  if β = 0
//! ```
//!
//! Palms that face each other are half a turn apart, where the logarithm has two values, so that tracking errors would
//! choose between them. Its branch is therefore chosen when the stack is entered, and followed from tick to tick: the angle
//! may exceed pi. Ours.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use robot::LinkId;

use crate::bound::{Arm, BoundParams};
use crate::build::check;
use crate::clik::{self, OrientationTarget, PositionTarget, axes};
use crate::dimension::{LENGTH, NONE};
use crate::kinds::frame_pose::{pose_measures, pose_rows};
use crate::kinds::uncooperative_motion::Pose;
use crate::numbers;
use crate::params::{Input, ParamType, Presence, Quantity};
use crate::so3;
use crate::task::{
    BuildError, Condition, Context, CurrentValue, CurrentValueType, ExpressedIn, Measure, RowInfo, RowKind, Rows,
    State, Task, TaskFault, TaskKind,
};

crate::params! {
    /// Target pose of the right tip relative to the left one.
    pub struct Relative {
        /// Target position; it may move with time. It is expressed in the axes of the left tip; with
        /// `relative_to world` or `beta 0`, in those of the world.
        position: Input<3> = ParamType::Vector(LENGTH), Presence::Required;
        /// Target orientation; it may move with time. It rotates the axes of the right tip into those of the left one;
        /// with `beta 0`, into those of the world.
        orientation: Input<4> = ParamType::Rotation, Presence::Required;
    }
}

crate::params! {
    /// Parameters of `cooperative_motion`.
    pub struct Params {
        /// The left arm.
        left_arm: Arm = ParamType::Arm, Presence::Default("left");
        /// The right arm.
        right_arm: Arm = ParamType::Arm, Presence::Default("right");
        /// α: position of the absolute frame between the tips. 1 is the left tip, 0 the right one. It may move with
        /// time.
        alpha: Input<1> = ParamType::Scalar(Quantity::between(NONE, 0.0, 1.0)), Presence::Default("0.5");
        /// β: 1 couples the arms, 0 makes the relative pose that of the right tip in the world.
        beta: Input<1> = ParamType::Scalar(Quantity::between(NONE, 0.0, 1.0).constant()), Presence::Default("1");
        /// The axes of the relative position for β = 1: those of the left tip, or those of the world as in the thesis,
        /// in which a rotation of torso or base appears as relative motion.
        relative_to: String = ParamType::Choice(&["left", "world"]), Presence::Default("left");
        /// Target pose of the absolute frame in the world.
        absolute: BoundParams = ParamType::Group(Pose::INFO), Presence::Required;
        /// Target pose of the right tip relative to the left one.
        relative: BoundParams = ParamType::Group(Relative::INFO), Presence::Required;
        /// K: how fast the errors decay.
        gain: Input<2> = ParamType::Gains(&["linear", "angular"]), Presence::Default("2 /s");
    }
}

/// ExpressedIn of the relative position.
const POSITION: ExpressedIn = ExpressedIn::Tip {
    arm: "left_arm",
    when: &[Condition::Number("beta", 1.0), Condition::Word("relative_to", "left")],
    text: "counts along the axes of the left tip; with `relative_to world`, or `beta 0`, along those of the world",
};

/// ExpressedIn into which the relative orientation turns those of the right tip.
const ORIENTATION: ExpressedIn = ExpressedIn::Tip {
    arm: "left_arm",
    when: &[Condition::Number("beta", 1.0)],
    text: "turns the axes of the right tip into those of the left one; with `beta 0` into those of the world",
};

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "cooperative_motion",
    summary: "moves two arms together: an absolute frame between them and a relative one",
    docs: "Twelve equality rows `J v = x_d' + K e`: absolute position and orientation, relative position and \
orientation.\n\n\
```text\n\
p_a = α p_l + (1 - α) p_r\n\
R_a = R_l exp((1 - α) log(R_l^T R_r))\n\
p_rel = R_l^T (p_r - p_l)   relative_to left,  β = 1\n\
p_rel = p_r - β p_l         relative_to world, or β = 0\n\
R_rel = R_l^T R_r  for β = 1,   R_r  for β = 0\n\n\
p_l, p_r  3×1  m              positions of the left and right tip in the world\n\
R_l, R_r  3×3                 orientations of the left and right tip in the world\n\
e         m or rad            p_d - p for positions, log(R_d R^T) for orientations (rotation vector)\n\
x_d'      m/s or rad/s        time derivative of a target position, angular velocity ω_d of a target orientation\n\
J         12×n                Jacobian of these values (angular velocities for orientations)\n\
v         n×1  rad/s or m/s   velocity of the n degrees of freedom\n\
K         1/s                 gain: linear for positions, angular for orientations\n\
```\n\n\
The rows of the absolute frame are in the world's axes. If α moves, its part of the velocity is subtracted from \
`x_d'`: `α' (p_l - p_r)` for the position, and the last term of the angular velocity below for the orientation.\n\n\
`initial(relative.position)` and the target of the relative position are expressed in the same axes: those of \
the left tip, or those of the world with `relative_to world` or `beta 0`. The relative orientations rotate the \
axes of the right tip into those of the left one, or into those of the world with `beta 0`; `relative_to` does \
not affect them. A value in other axes is rejected.\n\n\
`alpha 1` is the left tip and `alpha 0` the right one (the sentence after thesis (3.28) has them exchanged). \
With `beta 0`, `alpha 1` the two arms are independent.\n\n\
The angular velocity of the absolute frame is `ω_l + R_l M R_l^T (ω_r - ω_l) - α' R_l log(R_l^T R_r)` with `M = \
s J_l(s φ) J_l(φ)^-1`, `s = 1 - α`, the left Jacobian `J_l` of SO(3), and the angular velocities `ω_l`, `ω_r` of \
the tips; thesis (3.32) has `s I` in place of `M`, which is correct only for rotations about the axis of `φ = \
log(R_l^T R_r)`.\n\n\
At a relative rotation of half a turn, as of two palms that face each other, both ways from the left tip to the right \
one are equally long. The way is chosen when the stack is entered, the shorter one, or within 6 degrees of half a turn \
always the same one, and is followed from then on, also where it becomes the longer one. After a whole turn the way is \
undefined: within 6 degrees of it the rows of the absolute orientation are left free, and `run` counts these ticks.\n\n\
Source: thesis (3.26)-(3.34).",
    example: "task motion = cooperative_motion {\n  \
absolute { position initial(absolute.position) + [0.1, 0, 0] m  orientation initial(absolute.orientation) }\n  \
relative { position initial(relative.position)  orientation initial(relative.orientation) }\n}",
    current_values: &[
        CurrentValue::in_world("absolute.position", CurrentValueType::Vector(LENGTH)),
        CurrentValue::in_world("absolute.orientation", CurrentValueType::Rotation),
        CurrentValue { name: "relative.position", ty: CurrentValueType::Vector(LENGTH), expressed_in: POSITION },
        CurrentValue { name: "relative.orientation", ty: CurrentValueType::Rotation, expressed_in: ORIENTATION },
    ],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct CooperativeMotion {
    left: LinkId,
    right: LinkId,
    alpha: Input<1>,
    coupled: bool,
    in_left: bool,
    absolute: Pose,
    relative: Relative,
    gain: Input<2>,
    /// log(R_l^T R_r) of the last tick, in rad, on the branch that is followed; `None` before the first one.
    phi: Option<Vector3<f64>>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let [beta] = params.beta.of(ctx.values);
    if beta != 0.0 && beta != 1.0 {
        return Err(BuildError::new("beta", format!("`beta` is {beta}, and only 0 and 1 have a meaning"))
            .help("write `beta 1` for arms that move together, `beta 0` for arms that move apart"));
    }
    if params.left_arm.tip == params.right_arm.tip {
        return Err(BuildError::new("right_arm", "both arms end in the same tip"));
    }
    let in_left = match params.relative_to.as_str() {
        "left" => true,
        "world" => false,
        other => {
            return Err(BuildError::new(
                "relative_to",
                format!("`relative_to` is `{other}`, and only `left` and `world` have a meaning"),
            ));
        }
    };
    Ok(Box::new(CooperativeMotion {
        left: params.left_arm.tip,
        right: params.right_arm.tip,
        alpha: params.alpha,
        coupled: beta == 1.0,
        in_left,
        absolute: Pose::from_bound(&params.absolute)?,
        relative: Relative::from_bound(&params.relative)?,
        gain: params.gain,
        phi: None,
    }))
}

/// Both tips at a tick.
struct Tips {
    p_l: Vector3<f64>,
    p_r: Vector3<f64>,
    r_l: UnitQuaternion<f64>,
    r_r: UnitQuaternion<f64>,
    /// log(R_l^T R_r) in rad, in the left tip's axes.
    phi: Vector3<f64>,
}

/// Angle in rad within which a relative rotation counts as half a turn, or as a whole one.
const NEAR: f64 = 0.1;

/// Largest change of the relative rotation between two evaluations in rad. Beyond it the robot did not move there, such as
/// in a search that begins anew, and there is no branch to follow.
const LARGEST_STEP: f64 = 1.5;

/// Rotation vector of the way from the left tip to the right one at the entry of the stack: the shorter one. Near half a
/// turn, where errors of tracking decide which one that is, it is the one whose axis has a positive product with a fixed
/// direction, so that each entry finds the same.
fn at_entry(relative: &UnitQuaternion<f64>) -> Vector3<f64> {
    // Not perpendicular to an axis of the tip, nor to a diagonal between them.
    const DIRECTION: Vector3<f64> = Vector3::new(1.0, 0.55, 0.3);
    let phi = so3::log(relative);
    if phi.norm() > PI - NEAR && phi.dot(&DIRECTION) < 0.0 { phi - phi * (TAU / phi.norm()) } else { phi }
}

impl CooperativeMotion {
    /// The tips, with the way between them that follows `before`.
    fn tips(&self, state: &State, before: Option<Vector3<f64>>) -> Tips {
        let (l, r) = (state.data.pose(self.left), state.data.pose(self.right));
        let relative = l.rotation.inverse() * r.rotation;
        let followed = before.map(|phi| (so3::log_near(&relative, &phi), phi));
        let phi = followed.filter(|(phi, before)| (phi - before).norm() < LARGEST_STEP).map(|(phi, _)| phi);
        Tips {
            p_l: l.translation.vector,
            p_r: r.translation.vector,
            r_l: l.rotation,
            r_r: r.rotation,
            phi: phi.unwrap_or_else(|| at_entry(&relative)),
        }
    }

    fn absolute(&self, tips: &Tips, alpha: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let turn = UnitQuaternion::from_scaled_axis(tips.phi * (1.0 - alpha));
        (tips.p_l * alpha + tips.p_r * (1.0 - alpha), tips.r_l * turn)
    }

    fn relative(&self, tips: &Tips) -> (Vector3<f64>, UnitQuaternion<f64>) {
        if !self.coupled {
            return (tips.p_r, tips.r_r);
        }
        let between = tips.p_r - tips.p_l;
        let p = if self.in_left { tips.r_l.inverse() * between } else { between };
        (p, tips.r_l.inverse() * tips.r_r)
    }

    fn absolute_rows(&self, state: &State, rows: &mut Rows, tips: &Tips, gain: [f64; 2]) {
        let ([alpha], [alpha_dot]) = (self.alpha.of(state.values), self.alpha.of(state.rates));
        let (p_a, r_a) = self.absolute(tips, alpha);
        let PositionTarget { position: p_d, velocity: p_d_dot } = clik::position_target(state, self.absolute.position);
        let drift = (tips.p_l - tips.p_r) * alpha_dot;
        let error = p_d - p_a;
        for (i, axis) in axes().iter().enumerate() {
            let row = rows.row(i);
            state.data.add_point(state.model, self.left, &tips.p_l, &(axis * alpha), row);
            state.data.add_point(state.model, self.right, &tips.p_r, &(axis * (1.0 - alpha)), row);
            rows.equal(i, p_d_dot[i] - drift[i] + gain[0] * error[i]);
        }
        rows.measures[0] = error.norm();

        let OrientationTarget { orientation: r_d, angular_velocity: omega_d } =
            clik::orientation_target(state, self.absolute.orientation);
        let error = so3::log(&(r_d * r_a.inverse()));
        rows.measures[1] = error.norm();
        let turns = tips.phi.norm() / TAU;
        if turns > 0.5 && (turns - turns.round()).abs() * TAU < NEAR {
            *rows.undefined = true;
            rows.measures[1] = f64::NAN;
            return;
        }
        let r_l = tips.r_l.to_rotation_matrix();
        let m_w: Matrix3<f64> = r_l * so3::interpolation_rate(&tips.phi, 1.0 - alpha) * r_l.transpose();
        let drift = tips.r_l * tips.phi * -alpha_dot;
        for (i, axis) in axes().iter().enumerate() {
            let from_right = m_w.row(i).transpose();
            let row = rows.row(3 + i);
            state.data.add_angular(state.model, self.left, &(axis - from_right), row);
            state.data.add_angular(state.model, self.right, &from_right, row);
            rows.equal(3 + i, omega_d[i] - drift[i] + gain[1] * error[i]);
        }
    }

    fn relative_rows(&self, state: &State, rows: &mut Rows, tips: &Tips, gain: [f64; 2]) {
        let (p, r) = self.relative(tips);
        let PositionTarget { position: p_d, velocity: p_d_dot } = clik::position_target(state, self.relative.position);
        let error = p_d - p;
        for (i, axis) in axes().iter().enumerate() {
            let row = rows.row(6 + i);
            if !self.coupled {
                state.data.add_point(state.model, self.right, &tips.p_r, axis, row);
            } else if self.in_left {
                // e_i·R_l^T (p_r' - p_l' - ω_l × (p_r - p_l)): the left tip moves as a body that reaches p_r
                let n = tips.r_l * axis;
                state.data.add_point(state.model, self.right, &tips.p_r, &n, row);
                state.data.add_point(state.model, self.left, &tips.p_r, &-n, row);
            } else {
                state.data.add_point(state.model, self.right, &tips.p_r, axis, row);
                state.data.add_point(state.model, self.left, &tips.p_l, &-axis, row);
            }
            rows.equal(6 + i, p_d_dot[i] + gain[0] * error[i]);
        }
        rows.measures[2] = error.norm();

        let OrientationTarget { orientation: r_d, angular_velocity: omega_d } =
            clik::orientation_target(state, self.relative.orientation);
        let error = so3::log(&(r_d * r.inverse()));
        for (i, axis) in axes().iter().enumerate() {
            let row = rows.row(9 + i);
            if self.coupled {
                let n = tips.r_l * axis;
                state.data.add_angular(state.model, self.right, &n, row);
                state.data.add_angular(state.model, self.left, &-n, row);
            } else {
                state.data.add_angular(state.model, self.right, axis, row);
            }
            rows.equal(9 + i, omega_d[i] + gain[1] * error[i]);
        }
        rows.measures[3] = error.norm();
    }
}

impl Task for CooperativeMotion {
    fn rows(&self) -> Vec<RowInfo> {
        ["absolute.", "relative."].iter().flat_map(|p| pose_rows(p)).collect()
    }

    fn measures(&self) -> Vec<Measure> {
        ["absolute.", "relative."].iter().flat_map(|p| pose_measures(p)).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn enter(&mut self, state: &State) {
        self.phi = Some(self.tips(state, None).phi);
    }

    crate::task::takes_over!(phi);

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let gain = self.gain.of(state.values);
        let tips = self.tips(state, self.phi);
        self.phi = Some(tips.phi);
        self.absolute_rows(state, rows, &tips, gain);
        self.relative_rows(state, rows, &tips, gain);
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        // Captured when the stack is entered, before there is a branch to follow.
        let tips = self.tips(state, None);
        let [alpha] = self.alpha.of(state.values);
        let Some((which, part)) = name.split_once('.') else { return false };
        let (p, r) = match which {
            "absolute" => self.absolute(&tips, alpha),
            "relative" => self.relative(&tips),
            _ => return false,
        };
        match part {
            "position" => numbers::write_vector(&p, out),
            "orientation" => numbers::write_rotation(&r, out),
            _ => return false,
        }
        true
    }
}
