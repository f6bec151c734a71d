//! Pulls joints to target positions.

use crate::bound::{BoundParams, Slot};
use crate::build::check;
use crate::dimension::Dimension;
use crate::kinds::joint_position_limits::dof_dimension;
use crate::params::{Input, ParamType, Presence};
use crate::task::{BuildError, Context, Measure, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};
use crate::turns::{TURNS, asks_for_nearest, nearest_turn};
use quantities::usual;

crate::params! {
    /// Parameters of `joint_position`.
    pub struct Params {
        /// Target of each joint or group, or one value for all joints of its unit, in rad or m; it may move with time.
        target: Vec<(usize, Slot)> = ParamType::JointPositions, Presence::Required;
        /// Way to the target of a continuous joint without position limits: `nearest` turns by at most half a turn,
        /// `exact` to the target as a number of turns. Other joints always move to the target as it is written.
        turns: String = TURNS, Presence::Default("nearest");
        /// K: how fast the error decays.
        gain: Input<1> = ParamType::Scalar(usual::GAIN), Presence::Default("2 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "joint_position",
    summary: "pulls joints to target positions",
    docs: "One equality row for each joint:\n\n\
```text\n\
v = q_d' + K (q_d - q)\n\n\
q, q_d  rad or m       position of the joint, and its target\n\
q_d'    rad/s or m/s   feed-forward: the exact time derivative of the target\n\
v       rad/s or m/s   velocity of the joint: the Jacobian is a unit row\n\
K       1/s            gain\n\
```\n\n\
A continuous joint without position limits is at the same place after each whole turn. Its error `q_d - q` is taken \
to the nearest turn, within -pi and pi, and a `trapezoid` or `s_curve` to its target goes the near way too. With \
`turns exact` the target is a number of turns, `target { spindle 720 deg }`. A joint with limits, of the URDF or of \
the spec, always turns to the target as it is written.\n\n\
The task reports the error as the Euclidean norm of `q_d - q` over the joints; for revolute and prismatic joints \
together, the norm mixes rad and m.\n\n\
Source: thesis (2.5) with `J = I`.",
    example: "task posture = joint_position { target { torso_lift 0.15 m } gain 2 /s }",
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct Row {
    dof: usize,
    q: usize,
    target: Slot,
    /// True if the error is that to the nearest turn.
    nearest: bool,
}

struct JointPosition {
    rows: Vec<Row>,
    info: Vec<RowInfo>,
    gain: Input<1>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.target.is_empty() {
        return Err(BuildError::new("target", "no joint is named").help("name one, or remove the task"));
    }
    let nearest = asks_for_nearest(&params.turns)?;
    let (mut rows, mut info) = (Vec::new(), Vec::new());
    for &(dof, target) in &params.target {
        let Some(d) = ctx.model.dofs.get(dof) else { continue };
        let Some(q) = d.q_index else {
            return Err(BuildError::new(
                "target",
                format!("`{}` belongs to the base, which has no joint position", d.name),
            )
            .help("use `frame_position` and `frame_orientation` of the base link"));
        };
        rows.push(Row { dof, q, target, nearest: nearest && ctx.model.is_on_circle(dof) });
        info.push(RowInfo { name: d.name.clone(), dimension: dof_dimension(ctx.model, dof) });
    }
    Ok(Box::new(JointPosition { rows, info, gain: params.gain }))
}

/// Dimension of the first row, which all rows share unless revolute and prismatic joints mix.
pub(crate) fn common_dimension(info: &[RowInfo]) -> Dimension {
    info.first().map_or(crate::dimension::NONE, |r| r.dimension)
}

impl Task for JointPosition {
    fn rows(&self) -> Vec<RowInfo> {
        self.info.clone()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: String::new(), dimension: common_dimension(&self.info) }]
    }

    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        Some(self.rows.iter().map(|r| r.dof).collect())
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [gain] = self.gain.of(state.values);
        let mut squares = 0.0;
        for (i, r) in self.rows.iter().enumerate() {
            let way = state.values[r.target.at] - state.q[r.q];
            let error = if r.nearest { nearest_turn(way) } else { way };
            rows.equal(i, state.rates[r.target.at] + gain * error);
            squares += error * error;
        }
        rows.measures[0] = squares.sqrt();
        Ok(())
    }
}
