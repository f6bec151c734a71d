//! Keeps joints inside their position limits by control barrier functions.

use robot::Model;

use crate::bound::{BoundParams, Slot};
use crate::build::check;
use crate::dimension::{ANGLE, LENGTH};
use crate::params::{Input, ParamType, Presence};
use crate::protection::BoundedPosition;
use crate::task::{BuildError, Context, PersonVelocityUse, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind};
use quantities::usual;

crate::params! {
    /// Parameters of `joint_position_limits`.
    pub struct Params {
        /// The joints. Default: all that have a limit. A single value of `lower` or `upper` applies to all of them.
        joints: Option<Vec<usize>> = ParamType::Joints, Presence::Optional;
        /// Lower limits that replace the robot's; constants.
        lower: Option<Vec<(usize, Slot)>> = ParamType::JointPositions, Presence::Optional;
        /// Upper limits that replace the robot's; constants.
        upper: Option<Vec<(usize, Slot)>> = ParamType::JointPositions, Presence::Optional;
        /// φ: how fast the distance to a limit may decrease, relative to its size.
        gain: Input<1> = ParamType::Scalar(usual::LIMIT_GAIN), Presence::Default("10 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "joint_position_limits",
    summary: "keeps joints inside their position limits",
    docs: "Two barrier functions for each joint, which give one two-sided row:\n\n\
```text\n\
h_low = q - q_min,  h_up = q_max - q       safe where both are >= 0\n\
-φ (q - q_min)  <=  v  <=  φ (q_max - q)\n\n\
q             rad or m       position of the joint\n\
q_min, q_max  rad or m       its limits, constants\n\
v             rad/s or m/s   its velocity: the Jacobian is a unit row\n\
φ             1/s            gain\n\
```\n\n\
A joint that is outside a limit is driven back at the rate φ. The margin is the smaller of `h_low` and `h_up`.\n\n\
The limits are those of the robot (URDF, or `limits` of the robot) unless `lower` or `upper` replace them. A \
joint without any limit gets no row. With a control period T, `φ T <= 1` keeps `h >= 0` exactly, because `h` is \
linear in the position.\n\n\
Source: thesis (3.13)-(3.15); the lower bound of (3.15) lacks its minus sign there.",
    example: "task position_limits = joint_position_limits { gain 10 /s }",
    positional: &["joints"],
    person_velocity: Some(&PersonVelocityUse::LIMIT),
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

struct Row {
    dof: usize,
    q: usize,
    lower: f64,
    upper: f64,
}

struct JointPositionLimits {
    rows: Vec<Row>,
    info: Vec<RowInfo>,
    gain: Input<1>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    for (name, list) in [("lower", &params.lower), ("upper", &params.upper)] {
        among(name, list, &params.joints, ctx)?;
        if let Some(d) =
            list.iter().flatten().filter_map(|(dof, _)| ctx.model.dofs.get(*dof)).find(|d| d.q_index.is_none())
        {
            let text = format!("`{}` belongs to the base, which has no joint position", d.name);
            return Err(BuildError::new(name, text).help("leave it out; a base is kept in place by a `virtual_wall`"));
        }
    }
    let all: Vec<usize> = (0..ctx.model.nv()).collect();
    let (mut rows, mut info) = (Vec::new(), Vec::new());
    for &dof in params.joints.as_ref().unwrap_or(&all) {
        let Some(q) = ctx.model.dofs.get(dof).and_then(|d| d.q_index) else { continue };
        let d = &ctx.model.dofs[dof];
        let lower = replaced(&params.lower, dof, ctx.values).unwrap_or(d.lower);
        let upper = replaced(&params.upper, dof, ctx.values).unwrap_or(d.upper);
        if lower.is_nan() || upper.is_nan() {
            return Err(BuildError::new("lower", format!("joint `{}` would get a limit that is no number", d.name)));
        }
        if lower > upper {
            return Err(BuildError::new(
                "lower",
                format!("joint `{}` would have a lower limit of {lower} above its upper limit of {upper}", d.name),
            )
            .help("swap the two, or leave one out to keep the robot's own"));
        }
        if lower.is_finite() || upper.is_finite() {
            rows.push(Row { dof, q, lower, upper });
            info.push(RowInfo { name: d.name.clone(), dimension: dof_dimension(ctx.model, dof) });
        }
    }
    if rows.is_empty() {
        return Err(BuildError::new("joints", "none of these joints has a position limit").help(
            "joints that turn without end need none: remove the task. To limit them all the same, give `lower` and \
             `upper` here, or to single joints in the robot under `limits`",
        ));
    }
    Ok(Box::new(JointPositionLimits { rows, info, gain: params.gain }))
}

/// Rejects values for joints that `joints` leaves out: they would have no effect.
pub(crate) fn among(
    name: &str,
    list: &Option<Vec<(usize, Slot)>>,
    joints: &Option<Vec<usize>>,
    ctx: &Context,
) -> Result<(), BuildError> {
    let Some(joints) = joints.as_ref().filter(|j| !j.is_empty()) else { return Ok(()) };
    let left_out = list.iter().flatten().find(|(dof, _)| !joints.contains(dof));
    match left_out.and_then(|(dof, _)| ctx.model.dofs.get(*dof)) {
        None => Ok(()),
        Some(d) => {
            let text = format!("`{name}` gives a limit to `{}`, which `joints` leaves out", d.name);
            Err(BuildError::new(name, text).help("add it to `joints`, or take its value away"))
        }
    }
}

/// Value that is given for a degree of freedom, if there is one.
pub(crate) fn replaced(list: &Option<Vec<(usize, Slot)>>, dof: usize, values: &[f64]) -> Option<f64> {
    list.iter().flatten().find(|(d, _)| *d == dof).and_then(|(_, slot)| values.get(slot.at).copied())
}

/// Dimension of the position of a degree of freedom: rad or m.
pub(crate) fn dof_dimension(model: &Model, dof: usize) -> crate::dimension::Dimension {
    model.dofs.get(dof).map_or(ANGLE, |d| d.unit.select(LENGTH, ANGLE))
}

impl Task for JointPositionLimits {
    fn rows(&self) -> Vec<RowInfo> {
        self.info.clone()
    }

    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        Some(self.rows.iter().map(|r| r.dof).collect())
    }

    fn bounded_positions(&self) -> Vec<BoundedPosition> {
        let one = |r: &Row| BoundedPosition { dof: r.dof, lower: r.lower.is_finite(), upper: r.upper.is_finite() };
        self.rows.iter().map(one).collect()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.of(values).to_vec()
    }

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let [gain] = self.gain.of(state.values);
        for (i, r) in self.rows.iter().enumerate() {
            let q = state.q[r.q];
            rows.lower[i] = -gain * (q - r.lower);
            rows.upper[i] = gain * (r.upper - q);
            rows.margins[i] = (q - r.lower).min(r.upper - q);
        }
        Ok(())
    }
}
