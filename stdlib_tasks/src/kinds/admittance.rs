//! Follows a target pose as a body with mass, damping and stiffness that gives way to a wrench.

use nalgebra::Vector3;
use robot::LinkId;

use crate::bound::BoundParams;
use crate::build::check;
use crate::compliance::{Body, Damping, Mass, Motion, Stiffness, Wrench, read};
use crate::dimension::LENGTH;
use crate::kinds::frame_pose::{actual_pose, pose_measures, pose_rows};
use crate::params::{Input, ParamType, Presence};
use crate::so3;
use crate::task::{
    Actual, ActualType, Along, BuildError, Context, Measure, Nature, RowInfo, Rows, State, Task, TaskFault, TaskKind,
};
use crate::tracking;

crate::params! {
    /// Where the frame goes while nothing touches it.
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
        /// Where the frame goes while nothing touches it; where it was on entering the stack, if left out.
        target: BoundParams = ParamType::Group(Target::INFO), Presence::Default("{}");
        /// Km: how slowly the frame takes up a motion.
        mass: BoundParams = ParamType::Group(Mass::INFO), Presence::Required;
        /// Kd: what slows its motion against the target's.
        damping: BoundParams = ParamType::Group(Damping::INFO), Presence::Required;
        /// Kp: what pulls it to the target.
        stiffness: BoundParams = ParamType::Group(Stiffness::INFO), Presence::Required;
        /// h: what a person or the surroundings exert on the robot at the frame.
        wrench: BoundParams = ParamType::Group(Wrench::INFO), Presence::Required;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "admittance",
    summary: "follows a target pose, and gives way to a wrench like a mass on a spring with a damper",
    docs: "Six equality rows, three of the position and three of the orientation, in the world's axes. They let the frame move \
as a body would,\n\n\
```text\nKm (a_d - a) + Kd (v_d - v) + Kp e = -h\n```\n\n\
where `h` is the wrench exerted **on** the robot: a push towards +x has a positive first number. With \
`a = (v - v_prev) / T` and the control period T, and each row divided by `Km/T + Kd`, they are\n\n\
```text\nJ v = (Km (v_prev + T a_d) + T (Kd v_d + Kp e + h)) / (Km + T Kd)      [m/s], [rad/s]\n```\n\n\
- A steady force h displaces the frame by `h / Kp`, and it comes back when the force ends. `Kd = 2 sqrt(Km Kp)` brings it \
back as fast as it goes without overshooting.\n\
- `e` is `p_d - p`, and `log(R_d R^T)` as in `frame_orientation`: a rotation vector in rad, so that a moment μ turns the \
frame by `μ / Kp`. The thesis takes the quaternion's vector part, which is half of it for small angles: its angular \
stiffness of 60 N m is one of 30 N m here.\n\
- Radians may be left out: angular stiffness is in `N m` or `N m/rad`, angular damping in `N m s` or `N m s/rad`.\n\
- `v_d` is the exact time derivative of the target. `a_d` is its change since the last tick over T, zero at the \
first tick.\n\
- `v_prev` is `J v_stack`: the frame's velocity now for the velocity that the stack returned at the last tick; at its \
first tick, for the one that the reference moved with. So limits wind nothing up, another stack may have moved the robot \
before, and mass, damping and stiffness may change at any time, with the stack or with time: the velocity goes on from where \
it is, and only its slope has a corner. The offset by which a `blend` moves the reference is not part of `v_prev`, and \
the law acts from the second tick of a blend on.\n\
- A sensor measures along its own axes: `force (f in wrist) in world` turns what it says into the world's. The moment \
counts about the frame's origin; a sensor elsewhere measures another: add `r x f`. A wrench without `moment` leaves the \
orientation to spring and damper.\n\n\
Mass and damping are stable with any period. The spring pulls with the error at the beginning of a tick, and is stable exactly \
where\n\n\
```text\nKp T^2  <  4 Km + 2 Kd T\n```\n\n\
on each axis; a larger stiffness is refused when the spec is compiled, or is a fault where it moves with time. Stay well below: \
a motion is followed closely where `T sqrt(Kp / Km)` and `T Kd / Km` are much smaller than 1. A wrench that is not finite is a \
fault.\n\n\
Source: thesis (4.36)-(4.45). The sign of `h`, and with it those of (4.42)-(4.44), is corrected, and the rows are not \
scaled by `Km/T + Kd`.",
    example: "task comply = admittance(tool) {\n  \
mass { linear 20 kg  angular 3 kg m^2 }\n  \
damping { linear 253 N s/m  angular 27 N m s }\n  \
stiffness { linear [800, 800, 400] N/m  angular 60 N m }\n  \
wrench { force [20, 0, 0] N * smoothstep(t/(1 s)) }\n}",
    nature: Nature::Target,
    params: Params::INFO,
    positional: &["frame"],
    actuals: &[
        Actual { name: "target.position", ty: ActualType::Vector(LENGTH), along: Along::World },
        Actual { name: "target.orientation", ty: ActualType::Rotation, along: Along::World },
    ],
    tells: &[],
    reckons: None,
    build,
};

struct Admittance {
    body: Body,
    target: Target,
    /// The target's linear and angular velocity at the last tick; none at the first.
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
    let body = Body::new(params.frame.1, ctx, (mass, damping, Some(stiffness)), wrench)?;
    Ok(Box::new(Admittance { body, target, before: None }))
}

impl Task for Admittance {
    fn rows(&self) -> Vec<RowInfo> {
        pose_rows("")
    }

    fn measures(&self) -> Vec<Measure> {
        pose_measures("")
    }

    fn gains(&self, _values: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    fn enter(&mut self, _state: &State) {
        self.before = None;
        self.body.enter();
    }

    fn hand_over(&mut self) {
        self.body.hand_over();
    }

    fn remembers_target(&self) -> bool {
        true
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let pose = state.data.pose(self.body.link());
        let (p_d, v_d) = tracking::position_target(state, self.target.position);
        let (r_d, w_d) = tracking::orientation_target(state, self.target.orientation);
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

    fn actual(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        name.strip_prefix("target.").is_some_and(|part| actual_pose(part, self.body.link(), state, out))
    }
}
