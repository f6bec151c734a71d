//! Keeps joint accelerations inside limits: bounds the change of the velocity from tick to tick.

use crate::bound::{BoundParams, Slot};
use crate::build::check;
use crate::dimension::{ACCELERATION, ANGULAR_ACCELERATION};
use crate::kinds::joint_position_limits::{among, replaced};
use crate::params::{ParamType, Presence};
use crate::task::{BuildError, Context, PersonVelocityUse, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};

crate::params! {
    /// Parameters of `joint_acceleration_limits`.
    pub struct Params {
        /// The joints. Default: all to which `max` gives a limit, including the base; without `max`, all for which the
        /// URDF has a limit of acceleration or speed.
        joints: Option<Vec<usize>> = ParamType::Joints, Presence::Optional;
        /// Largest accelerations; constants. One value for all of these joints that have its unit, or one for each
        /// joint or group. Default: the limit of the URDF for each joint; for a joint without one, `10 /s` times its
        /// speed limit.
        max: Option<Vec<(usize, Slot)>> = ParamType::JointAccelerations, Presence::Optional;
    }
}

/// Acceleration limit of a joint without one of its own, as a multiple of its speed limit, in 1/s: that of braking
/// along the barrier of `joint_position_limits` with its default gain.
const OF_SPEED: f64 = 10.0;

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "joint_acceleration_limits",
    summary: "keeps joint accelerations inside limits",
    docs: "One two-sided row for each joint:\n\n\
```text\n\
v_last - a_max T  <=  v  <=  v_last + a_max T\n\n\
v        rad/s or m/s       velocity of the joint: the Jacobian is a unit row\n\
v_last   rad/s or m/s       velocity of the reference since the last tick, from any level or stack; zero at the \
beginning\n\
a_max    rad/s^2 or m/s^2   its acceleration limit, a constant\n\
T        s                  control period\n\
```\n\n\
The margin is `a_max - |v - v_last| / T` for the velocity that the hierarchy returned. Without `max`, a joint \
has the limit of its URDF: the lower one of `acceleration` and `deceleration` of `<limit>`, which URDF 1.2 \
defines. Most files have none. The limit is then `10 /s` times the speed limit: the joint can accelerate from \
rest to its speed limit in 0.1 s, and can brake before its position limit with the default gain of \
`joint_position_limits`.\n\n\
**Together with `joint_position_limits`.** The rows of that task are `v <= φ h`, with the distance `h` to a \
limit. After a tick with `v_last <= φ h`, the joint has the distance `h - T v_last` left and may move at `φ h - \
φ T v_last >= v_last - φ T v_last`. It therefore decelerates by at most `φ v_last`. A hard level with limits of \
positions, velocities and accelerations can always be met, for joints alone, if\n\n\
```text\n\
a_max  >=  φ v_max\n\
```\n\n\
with the gain φ of the position limits and the speed limit `v_max` of the joint. If `a_max` is smaller, a joint \
that moves fast towards its limit cannot brake in time, and a hard level ends in a fault. Raise `max`, lower the \
gain or the speed limit, or put this task on a soft level below the position limits. The margins of distance \
limits (`virtual_wall`, `self_collision`, `keep`) are curved, and no such bound is sufficient for all of them. \
If the fault `infeasible` is worse than a velocity that jumps, put the acceleration limits on a soft level below \
them.\n\n\
Source: thesis (4.41), the difference quotient of the velocity; the rows are ours.",
    example: "task gentle = joint_acceleration_limits { max 5 rad/s^2 }",
    positional: &["joints"],
    person_velocity: Some(&PersonVelocityUse::LIMIT),
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

struct JointAccelerationLimits {
    rows: Vec<(usize, f64)>,
    info: Vec<RowInfo>,
    period: f64,
    /// Velocity at which the rows of this tick begin, one number per row.
    last: Vec<f64>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let given = params.max;
    among("max", &given, &params.joints, ctx)?;
    let all: Vec<usize> = (0..ctx.model.nv()).collect();
    let (mut rows, mut info) = (Vec::new(), Vec::new());
    for &dof in params.joints.as_ref().unwrap_or(&all) {
        let Some(d) = ctx.model.dofs.get(dof) else { continue };
        let known = |limit: f64| (limit.is_finite() && limit > 0.0).then_some(limit);
        let own = || known(d.acceleration).or(known(d.velocity).map(|v| OF_SPEED * v));
        let found = if given.is_some() { replaced(&given, dof, ctx.values) } else { own() };
        let Some(max) = found else {
            // Without `joints`, the task limits the joints that `max` names, or that have a limit of their own.
            if params.joints.is_none() {
                continue;
            }
            if given.is_none() {
                return Err(BuildError::new(
                    "joints",
                    format!("`{}` has no speed limit to take its limit from", d.name),
                )
                .help("write `max`, or give the joint a speed limit under `limits` of the robot"));
            }
            return Err(BuildError::new("max", format!("`{}` gets no limit of its acceleration", d.name))
                .help("give it one, or take it out of `joints`"));
        };
        if !max.is_finite() || max <= 0.0 {
            return Err(BuildError::new("max", format!("joint `{}` would get the acceleration limit {max}", d.name))
                .help("a limit of an acceleration is more than zero; to keep a joint still, `lock` it"));
        }
        rows.push((dof, max));
        let dimension = d.unit.select(ACCELERATION, ANGULAR_ACCELERATION);
        info.push(RowInfo { name: d.name.clone(), dimension });
    }
    if rows.is_empty() {
        let at = match (&params.joints, &given) {
            (Some(_), _) => "joints",
            (None, Some(_)) => "max",
            (None, None) => "",
        };
        return Err(BuildError::new(at, "no joint gets a limit of its acceleration")
            .help("name joints, and give them a limit such as `max 5 rad/s^2`"));
    }
    Ok(Box::new(JointAccelerationLimits { last: vec![0.0; rows.len()], rows, info, period: ctx.period }))
}

impl Task for JointAccelerationLimits {
    fn rows(&self) -> Vec<RowInfo> {
        self.info.clone()
    }

    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        Some(self.rows.iter().map(|r| r.0).collect())
    }

    fn acceleration_limits(&self) -> Vec<(usize, f64)> {
        self.rows.clone()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        for (i, (&(dof, max), last)) in self.rows.iter().zip(&mut self.last).enumerate() {
            *last = state.velocity[dof];
            rows.lower[i] = *last - max * self.period;
            rows.upper[i] = *last + max * self.period;
        }
        Ok(())
    }

    fn observe(&self, _state: &State, v: &[f64], margins: &mut [f64], _measures: &mut [f64]) {
        for (margin, (&(dof, max), last)) in margins.iter_mut().zip(self.rows.iter().zip(&self.last)) {
            *margin = max - (v[dof] - last).abs() / self.period;
        }
    }
}
