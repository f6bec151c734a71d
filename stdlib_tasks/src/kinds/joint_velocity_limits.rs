//! Keeps joint velocities inside their limits.

use crate::bound::{BoundParams, Slot};
use crate::build::check;
use crate::dimension::{ANGULAR_VELOCITY, VELOCITY};
use crate::kinds::joint_position_limits::{among, replaced};
use crate::params::{ParamType, Presence};
use crate::task::{BuildError, Context, PersonVelocityUse, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};

crate::params! {
    /// Parameters of `joint_velocity_limits`.
    pub struct Params {
        /// The joints. Default: all that have a velocity limit, including the base.
        joints: Option<Vec<usize>> = ParamType::Joints, Presence::Optional;
        /// Largest speeds that replace the robot's; constants. One value for all of these joints that have its unit
        /// (including the base, if `joints` is omitted), or one for each joint or group.
        max: Option<Vec<(usize, Slot)>> = ParamType::JointVelocities, Presence::Optional;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "joint_velocity_limits",
    summary: "keeps joint velocities inside their limits",
    docs: "One two-sided row for each joint:\n\n\
```text\n\
-v_max  <=  v  <=  v_max\n\n\
v       rad/s or m/s   velocity of the joint: the Jacobian is a unit row\n\
v_max   rad/s or m/s   its speed limit, a constant\n\
```\n\n\
The limits are those of the robot (URDF, or `limits` of the robot) unless `max` replaces them. A joint whose \
limit is missing, zero or implausible in the URDF gets no row unless `max` gives it one. The margin is `v_max - \
|v|` for the velocity that the hierarchy returned.\n\n\
Source: thesis (3.12), (3.16).",
    example: "task velocity_limits = joint_velocity_limits { max 0.5 rad/s }",
    positional: &["joints"],
    person_velocity: Some(&PersonVelocityUse::LIMIT),
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

struct JointVelocityLimits {
    rows: Vec<(usize, f64)>,
    info: Vec<RowInfo>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    among("max", &params.max, &params.joints, ctx)?;
    let all: Vec<usize> = (0..ctx.model.nv()).collect();
    let (mut rows, mut info) = (Vec::new(), Vec::new());
    for &dof in params.joints.as_ref().unwrap_or(&all) {
        let Some(d) = ctx.model.dofs.get(dof) else { continue };
        let max = replaced(&params.max, dof, ctx.values).unwrap_or(d.velocity);
        if max.is_nan() || max <= 0.0 {
            return Err(BuildError::new("max", format!("joint `{}` would get the velocity limit {max}", d.name))
                .help("a velocity limit is more than zero; to keep a joint still, `lock` it"));
        }
        if max.is_finite() {
            rows.push((dof, max));
            let dimension = d.unit.select(VELOCITY, ANGULAR_VELOCITY);
            info.push(RowInfo { name: d.name.clone(), dimension });
        }
    }
    if rows.is_empty() {
        return Err(BuildError::new("joints", "none of these joints has a velocity limit")
            .help("give `max`, such as `max 1 rad/s`, or a `velocity` to single joints in the robot under `limits`"));
    }
    Ok(Box::new(JointVelocityLimits { rows, info }))
}

impl Task for JointVelocityLimits {
    fn rows(&self) -> Vec<RowInfo> {
        self.info.clone()
    }

    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        Some(self.rows.iter().map(|r| r.0).collect())
    }

    fn update(&mut self, _state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        for (i, &(_, max)) in self.rows.iter().enumerate() {
            rows.lower[i] = -max;
            rows.upper[i] = max;
        }
        Ok(())
    }

    fn observe(&self, _state: &State, v: &[f64], margins: &mut [f64], _measures: &mut [f64]) {
        for (margin, &(dof, max)) in margins.iter_mut().zip(&self.rows) {
            *margin = max - v[dof].abs();
        }
    }

    fn speed_limits(&self, _values: &[f64]) -> Vec<(usize, f64)> {
        self.rows.clone()
    }
}
