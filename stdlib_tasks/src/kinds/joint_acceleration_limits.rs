//! Keeps joint accelerations inside limits: the velocity may change by so much from tick to tick.

use crate::bound::{BoundParams, Slot};
use crate::build::check;
use crate::dimension::{ACCELERATION, ANGULAR_ACCELERATION};
use crate::kinds::joint_position_limits::{among, replaced};
use crate::params::{ParamType, Presence};
use crate::task::{BuildError, Context, Nature, Reckons, RowInfo, Rows, State, Task, TaskFault, TaskKind};

crate::params! {
    /// Parameters of `joint_acceleration_limits`.
    pub struct Params {
        /// The joints; where left out all that `max` gives a limit to, the base included, or all for which the URDF has a limit
        /// of acceleration or speed.
        joints: Option<Vec<usize>> = ParamType::Joints, Presence::Optional;
        /// Largest accelerations: one value for all of these joints that have its unit, or one for each joint or group:
        /// constants. Where left out, that of the URDF for each joint; for one without, ten times its speed limit a second.
        max: Option<Vec<(usize, Slot)>> = ParamType::JointAccelerations, Presence::Optional;
    }
}

/// The acceleration limit of a joint without one of its own, as a multiple of its speed limit, in 1/s: that of braking
/// along the barrier of `joint_position_limits` with its default gain.
const OF_SPEED: f64 = 10.0;

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "joint_acceleration_limits",
    summary: "keeps joint accelerations inside limits",
    docs: "One two-sided row a joint, with the control period T:\n\n\
```text\nv_last - a_max T  <=  v  <=  v_last + a_max T\n```\n\n\
`v_last` is the velocity that the reference moved with since the last tick, whatever level or stack chose it; it is \
zero at the beginning. The margin is `a_max - |v - v_last| / T` of the velocity that was chosen. Without `max` \
a joint gets the limit of its URDF: the lower one of `acceleration` and `deceleration` of `<limit>`, which URDF 1.2 has. Most \
files have none; a joint then gets `10 /s` times its speed limit: it may go from rest to its \
speed limit in 0.1 s, and can brake before its position limit with the gain that `joint_position_limits` has by \
default.\n\n\
**Together with `joint_position_limits`.** Along its rows `v <= φ h` with the distance `h` to a limit, a joint that was \
allowed the velocity `v_last` has `h - T v_last` left, and may move at `φ h - φ T v_last >= v_last - φ T v_last` now: it \
brakes by `φ v_last` at most. One hard level of limits of positions, velocities and accelerations can therefore always be \
met, for joints alone, where\n\n\
```text\na_max  >=  φ v_max\n```\n\n\
with the gain φ of the position limits and the speed limit `v_max` of the joint. With less, a joint that runs fast towards \
its limit cannot brake any more, and a hard level ends in a fault: raise `max`, lower the gain or the speed, or put this \
task on a soft level below the limits of positions. Limits of distances (`virtual_wall`, `self_collision`, `keep`) bend, and \
no such bound is enough for all of them: put limits of accelerations below them, on a soft level, where the fault \
`infeasible` is worse than a velocity that jumps.\n\n\
Source: thesis (4.41), the difference quotient of the velocity; the rows are ours.",
    example: "task gentle = joint_acceleration_limits { max 5 rad/s^2 }",
    nature: Nature::Limit,
    params: Params::INFO,
    positional: &["joints"],
    actuals: &[],
    tells: &[],
    reckons: Some(&Reckons::LIMIT),
    build,
};

struct JointAccelerationLimits {
    rows: Vec<(usize, f64)>,
    info: Vec<RowInfo>,
    period: f64,
    /// The velocity that the rows of this tick began with, one number a row.
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
            // Without `joints`, those that are meant are those that `max` names, or that have a speed limit.
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
        let dimension = match d.unit {
            robot::DofUnit::Metre => ACCELERATION,
            robot::DofUnit::Radian => ANGULAR_ACCELERATION,
        };
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

    fn gains(&self, _values: &[f64]) -> Vec<f64> {
        Vec::new()
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
