//! Follows a target pose as a body with mass, damping and stiffness that yields to a wrench.

use nalgebra::Vector3;
use robot::LinkId;

use crate::bound::BoundParams;
use crate::build::check;
use crate::clik::{self, OrientationTarget, PositionTarget};
use crate::compliance::{Body, Damping, Impedance, Mass, Motion, Stiffness, Wrench, read};
use crate::dimension::LENGTH;
use crate::kinds::frame_pose::{current_pose, pose_measures, pose_rows};
use crate::params::{Input, ParamType, Presence};
use crate::so3;
use crate::task::{
    BuildError, Context, CurrentValue, CurrentValueType, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault,
    TaskKind,
};

crate::params! {
    /// Target pose of the frame without contact.
    pub struct Target {
        /// Target position of the frame's origin in the world; it may move with time.
        position: Input<3> = ParamType::Vector(LENGTH), Presence::Default("initial(position)");
        /// Target orientation of the frame in the world; it may move with time.
        orientation: Input<4> = ParamType::Rotation, Presence::Default("initial(orientation)");
    }
}

crate::params! {
    /// Parameters of `admittance`.
    pub struct Params {
        /// The frame: a link of the robot, or an arm, which stands for its tip.
        frame: (String, LinkId) = ParamType::Frame, Presence::Required;
        /// Target pose of the frame without contact. Default: its pose at the entry of the stack.
        target: BoundParams = ParamType::Group(Target::INFO), Presence::Default("{}");
        /// Km: virtual mass and inertia of the frame.
        mass: BoundParams = ParamType::Group(Mass::INFO), Presence::Required;
        /// Kd: virtual damping of its motion relative to that of the target.
        damping: BoundParams = ParamType::Group(Damping::INFO), Presence::Required;
        /// Kp: virtual stiffness towards the target.
        stiffness: BoundParams = ParamType::Group(Stiffness::INFO), Presence::Required;
        /// h: wrench that a person or the environment exerts on the robot at the frame.
        wrench: BoundParams = ParamType::Group(Wrench::INFO), Presence::Required;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "admittance",
    summary: "follows a target pose, and yields to a wrench like a mass on a spring with a damper",
    docs: "Six equality rows, three for the position and three for the orientation, in the world's axes. They \
let the frame move like a body with mass, damping and stiffness,\n\n\
```text\n\
Km (a_d - a) + Kd (v_d - v) + Kp e = -h\n\n\
a, v        m/s^2, m/s or rad/s^2, rad/s   acceleration and velocity of the frame, along an axis of the world\n\
a_d, v_d    the same units                 those of the target\n\
e           m or rad                       error: p_d - p for the position, log(R_d R^T) for the orientation\n\
h           N or N m                       wrench at the frame's origin, exerted on the robot\n\
Km, Kd, Kp  one for each axis              mass [kg, kg m^2], damping [N s/m, N m s/rad], stiffness [N/m, N m/rad]\n\
```\n\n\
A push towards +x has a positive first number in `h`. With `a = (v - v_prev) / T` and the control period T, and \
each row divided by `Km/T + Kd`, the rows are\n\n\
```text\n\
J v = (Km (v_prev + T a_d) + T (Kd v_d + Kp e + h)) / (Km + T Kd)      [m/s], [rad/s]\n\
```\n\n\
with the 6×n Jacobian `J` of the frame in the world's axes, at its origin, linear rows first. On the left side, \
`v` is the n×1 velocity of the degrees of freedom.\n\n\
- A steady force h displaces the frame by `h / Kp`; the frame returns when the force ends. With `Kd = 2 sqrt(Km \
Kp)` it returns as fast as possible without overshooting.\n\
- `log(R_d R^T)` is the rotation vector of `frame_orientation` in rad, so a moment μ rotates the frame by `μ / \
Kp`. The thesis uses the vector part of the quaternion, which is half of it for small angles: its angular \
stiffness of 60 N m is one of 30 N m here.\n\
- Radians may be omitted: angular stiffness is in `N m` or `N m/rad`, angular damping in `N m s` or `N m s/rad`.\n\
- `v_d` is the exact time derivative of the target. `a_d` is its change since the last tick divided by T, zero at \
the first tick.\n\
- `v_prev` is `J v_stack`, with the Jacobian of this tick and the velocity that the stack returned at the last \
tick; at the first tick of the stack, with the velocity of the reference. Limits therefore cause no windup, \
another stack may have moved the robot before, and mass, damping and stiffness may change at any time, with the \
stack or with time: the velocity is continuous, and only its slope changes abruptly. The offset by which a `blend` \
moves the reference is not part of `v_prev`, and the law acts from the second tick of a blend on.\n\
- A sensor measures along its own axes: `force (f in wrist) in world` converts its reading to the world's axes. \
The moment is about the frame's origin; a sensor at another place measures another moment: add `r x f`. Without \
`moment`, only spring and damper act on the orientation.\n\n\
Mass and damping are stable with any period. The spring acts on the error at the beginning of a tick, and is \
stable if and only if\n\n\
```text\n\
Kp T^2  <  4 Km + 2 Kd T\n\
```\n\n\
on each axis. The compiler rejects a larger stiffness; if the numbers change with time, a larger stiffness is a \
fault. Stay well below this bound: the law follows the continuous motion closely if `T sqrt(Kp / Km)` and `T Kd \
/ Km` are much smaller than 1. A wrench that is not finite is a fault.\n\n\
Source: thesis (4.36)-(4.45). The sign of `h`, and with it those of (4.42)-(4.44), is corrected, and the rows are not \
scaled by `Km/T + Kd`.",
    example: "task comply = admittance(tool) {\n  \
mass { linear 20 kg  angular 3 kg m^2 }\n  \
damping { linear 253 N s/m  angular 27 N m s }\n  \
stiffness { linear [800, 800, 400] N/m  angular 60 N m }\n  \
wrench { force [20, 0, 0] N * smoothstep(t/(1 s)) }\n}",
    positional: &["frame"],
    current_values: &[
        CurrentValue::in_world("target.position", CurrentValueType::Vector(LENGTH)),
        CurrentValue::in_world("target.orientation", CurrentValueType::Rotation),
    ],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct Admittance {
    body: Body,
    target: Target,
    /// Linear and angular velocity of the target at the last tick; `None` at the first.
    before: Option<[Vector3<f64>; 2]>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let target = read("target", &params.target, Target::from_bound)?;
    let mass = read("mass", &params.mass, Mass::from_bound)?;
    let damping = read("damping", &params.damping, Damping::from_bound)?;
    let stiffness = read("stiffness", &params.stiffness, Stiffness::from_bound)?;
    let wrench = read("wrench", &params.wrench, Wrench::from_bound)?;
    let body = Body::new(params.frame.1, ctx, Impedance { mass, damping, stiffness: Some(stiffness) }, wrench)?;
    Ok(Box::new(Admittance { body, target, before: None }))
}

impl Task for Admittance {
    fn rows(&self) -> Vec<RowInfo> {
        pose_rows("")
    }

    fn measures(&self) -> Vec<Measure> {
        pose_measures("")
    }

    fn enter(&mut self, _state: &State) {
        self.before = None;
        self.body.enter();
    }

    crate::task::takes_over!(before, body);

    fn hand_over(&mut self) {
        self.body.hand_over();
    }

    fn remembers_target(&self) -> bool {
        true
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let pose = state.data.pose(self.body.link());
        let PositionTarget { position: p_d, velocity: v_d } = clik::position_target(state, self.target.position);
        let OrientationTarget { orientation: r_d, angular_velocity: w_d } =
            clik::orientation_target(state, self.target.orientation);
        let error = [p_d - pose.translation.vector, so3::log(&(r_d * pose.rotation.inverse()))];
        let velocity = [v_d, w_d];
        let before = self.before.unwrap_or(velocity);
        if !rows.trial {
            self.before = Some(velocity);
        }
        let change = [v_d - before[0], w_d - before[1]];
        self.body.update(state, rows, &Motion { error, velocity, change })?;
        rows.measures[0] = error[0].norm();
        rows.measures[1] = error[1].norm();
        Ok(())
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        name.strip_prefix("target.").is_some_and(|part| current_pose(part, self.body.link(), state, out))
    }
}
