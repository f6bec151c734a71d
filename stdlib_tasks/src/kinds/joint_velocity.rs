//! Drives joints at given velocities.

use crate::bound::{BoundParams, Slot};
use crate::build::check;
use crate::dimension::{ANGULAR_VELOCITY, VELOCITY};
use crate::kinds::joint_position::common_dimension;
use crate::params::{ParamType, Presence};
use crate::task::{BuildError, Context, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};

crate::params! {
    /// Parameters of `joint_velocity`.
    pub struct Params {
        /// Velocity of each joint or group, in rad/s or m/s; it may move with time.
        velocity: Vec<(usize, Slot)> = ParamType::JointVelocities, Presence::Required;
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "joint_velocity",
    summary: "drives joints at given velocities",
    docs: "One equality row for each joint:\n\n\
```text\n\
v = v_d\n\n\
v    rad/s or m/s   velocity of the joint: the Jacobian is a unit row\n\
v_d  rad/s or m/s   its target\n\
```\n\n\
The task reports the error as the Euclidean norm of `v_d - v` for the velocity that the hierarchy returned; for \
revolute and prismatic joints together, the norm mixes rad/s and m/s.\n\n\
Source: thesis 3.5.1.1, (3.43).",
    example: "task sine = joint_velocity { velocity { arm_left 0.75*sin(2*pi*t/(25 s)) rad/s } }",
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct JointVelocity {
    rows: Vec<(usize, Slot)>,
    wanted: Vec<f64>,
    info: Vec<RowInfo>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.velocity.is_empty() {
        return Err(BuildError::new("velocity", "no joint is named").help("name one, or remove the task"));
    }
    let info: Vec<RowInfo> = params
        .velocity
        .iter()
        .filter_map(|&(dof, _)| ctx.model.dofs.get(dof))
        .map(|d| RowInfo { name: d.name.clone(), dimension: d.unit.select(VELOCITY, ANGULAR_VELOCITY) })
        .collect();
    Ok(Box::new(JointVelocity { wanted: vec![0.0; info.len()], rows: params.velocity, info }))
}

impl Task for JointVelocity {
    fn rows(&self) -> Vec<RowInfo> {
        self.info.clone()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: String::new(), dimension: common_dimension(&self.info) }]
    }

    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        Some(self.rows.iter().map(|r| r.0).collect())
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        for (i, &(_, slot)) in self.rows.iter().enumerate() {
            self.wanted[i] = state.values[slot.at];
            rows.equal(i, self.wanted[i]);
        }
        Ok(())
    }

    fn observe(&self, _state: &State, v: &[f64], _margins: &mut [f64], measures: &mut [f64]) {
        let squares: f64 = self.rows.iter().zip(&self.wanted).map(|(&(dof, _), w)| (w - v[dof]).powi(2)).sum();
        measures[0] = squares.sqrt();
    }
}
