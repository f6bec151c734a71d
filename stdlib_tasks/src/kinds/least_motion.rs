//! Keeps velocities or accelerations of joints as small as the levels above allow.

use crate::bound::BoundParams;
use crate::build::check;
use crate::dimension::{ANGULAR_VELOCITY, RATE, VELOCITY};
use crate::kinds::joint_position::common_dimension;
use crate::params::{ParamType, Presence};
use crate::task::{BuildError, Context, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};

crate::params! {
    /// Parameters of `least_motion`.
    pub struct Params {
        /// `velocity`: as little motion as possible. `acceleration`: as little change of the velocity as possible.
        of: String = ParamType::Choice(&["velocity", "acceleration"]), Presence::Required;
        /// The joints, and the degrees of freedom of the base. Default: all.
        joints: Option<Vec<usize>> = ParamType::Joints, Presence::Optional;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "least_motion",
    summary: "keeps velocities or accelerations of joints as small as the levels above allow",
    docs: "One equality row for each joint, and each degree of freedom of the base:\n\n\
```text\n\
v = 0           of velocity\n\
v = v_last      of acceleration\n\n\
v       rad/s or m/s   velocity of the joint: the Jacobian is a unit row\n\
v_last  rad/s or m/s   velocity that the hierarchy of the stack returned at the last tick\n\
```\n\n\
As the last level of a stack, `least_motion(velocity)` decides what the other levels leave open by the least norm of the velocity \
at each tick. `least_motion(acceleration)` decides it by the least change: a redundant arm goes on as it moves, and neither stops nor turns \
when a target ends. Nothing brakes it then, so put a posture or `least_motion(velocity)` in the same level, with weights: \
`weight 0.01` for the velocity lets the motion of its own decay by about 1 % in a tick. On one level with a target, with a small weight, both are \
the regularisation that other frameworks call damping. A level of it alone is never met exactly, and `damping auto` of the level then \
brakes what the levels above hold back; with `damping none` the optimum is exact.\n\n\
At the tick at which a stack is entered, `v_last` is the velocity of the robot, so that another state of a machine begins without a jump.\n\n\
The task reports the Euclidean norm of the velocities or accelerations; for revolute and prismatic joints together, it mixes units.\n\n\
Source: thesis 3.5.1.1, (3.43), with the desired velocity zero, or the last one.",
    example: "task smooth = least_motion(acceleration)",
    positional: &["of"],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct LeastMotion {
    dofs: Vec<usize>,
    /// Velocity that each row asks for at this tick.
    wanted: Vec<f64>,
    info: Vec<RowInfo>,
    /// Control period T in s for accelerations; `None` for velocities.
    period: Option<f64>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let dofs = params.joints.unwrap_or_else(|| (0..ctx.model.nv()).collect());
    if dofs.is_empty() {
        return Err(BuildError::new("joints", "no joint is named").help("name one, or leave `joints` out for all"));
    }
    let period = match params.of.as_str() {
        "velocity" => None,
        "acceleration" => Some(ctx.period),
        other => return Err(BuildError::new("of", format!("there is no least `{other}`"))),
    };
    let named = |d: &robot::Dof| RowInfo { name: d.name.clone(), dimension: d.unit.select(VELOCITY, ANGULAR_VELOCITY) };
    let info: Vec<RowInfo> = dofs.iter().filter_map(|&dof| ctx.model.dofs.get(dof)).map(named).collect();
    Ok(Box::new(LeastMotion { wanted: vec![0.0; dofs.len()], dofs, info, period }))
}

impl Task for LeastMotion {
    fn rows(&self) -> Vec<RowInfo> {
        self.info.clone()
    }

    fn measures(&self) -> Vec<Measure> {
        let velocity = common_dimension(&self.info);
        let dimension = match self.period {
            Some(_) => velocity.times(RATE).unwrap_or(velocity),
            None => velocity,
        };
        vec![Measure { name: String::new(), dimension }]
    }

    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        Some(self.dofs.clone())
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        for (i, (&dof, wanted)) in self.dofs.iter().zip(&mut self.wanted).enumerate() {
            *wanted = if self.period.is_some() { state.stack_velocity[dof] } else { 0.0 };
            rows.equal(i, *wanted);
        }
        Ok(())
    }

    fn observe(&self, _state: &State, v: &[f64], _margins: &mut [f64], measures: &mut [f64]) {
        let squares: f64 = self.dofs.iter().zip(&self.wanted).map(|(&dof, w)| (v[dof] - w).powi(2)).sum();
        measures[0] = squares.sqrt() / self.period.unwrap_or(1.0);
    }
}
