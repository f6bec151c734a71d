//! Lets another task give way, so that a safety field stays above a threshold: scales its clock, deviates from its
//! path, and moves the robot inside its null space. Thesis 4.2.3, Algorithm 1.
//!
//! ```text
//! v = u_n        one row for each degree of freedom, thesis (4.34)
//! ```
//!
//! The runtime, which has both tasks, computes the decision and its effect on the protected task.

use crate::bound::{Bound, BoundParams};
use crate::build::check;
use crate::dimension::{ANGLE, ANGULAR_VELOCITY, LENGTH, NONE, VELOCITY};
use crate::kinds::joint_position::common_dimension;
use crate::params::{Form, Input, ParamInfo, ParamType, Presence, Quantity};
use crate::protection::{Hazard, Protection};
use crate::task::{
    BuildError, Context, Measure, PersonVelocityUse, RowInfo, RowKind, Rows, State, Task, TaskFault, TaskKind,
    TaskOutput,
};
use quantities::usual;

/// Range of a weight in the planner's cost.
const WEIGHT: Quantity = Quantity::above(NONE, 0.0).constant();

/// Names of the methods that decide.
const METHODS: &[&str] = &["planner", "evasive", "stop"];

crate::params! {
    /// Scaling of the clock of the protected task.
    pub struct Scaling {
        /// Weight of `(u_c - 1)^2`: with a large weight, the planner deviates rather than slows down.
        weight: Input<1> = ParamType::Scalar(WEIGHT), Presence::Default("1");
    }
}

crate::params! {
    /// Motion in the null space of the protected task.
    pub struct Internal {
        /// k_n: gain of the motion along the field's gradient while nothing requires another motion; 0 for none.
        gain: Input<1> = ParamType::Scalar(Quantity::at_least(NONE, 0.0).constant()), Presence::Default("1");
        /// Weight of the squared norm of `u_n - k_n dF/dq`.
        weight: Input<1> = ParamType::Scalar(WEIGHT), Presence::Default("1");
    }
}

/// Parameters of a deviation that both kinds share.
macro_rules! deviation {
    ($speed:expr, $size:expr) => {
        &[
            ParamInfo {
                name: "along",
                doc: &[
                    "Direction of the deviation, in the axes of the parameter; its length has no effect. Default: the \
                     direction in which the field increases fastest.",
                ],
                ty: ParamType::Expression(Form::Vector(LENGTH)),
                presence: Presence::Optional,
            },
            ParamInfo {
                name: "speed",
                doc: &["The greatest input to either side."],
                ty: ParamType::Scalar(Quantity::above($speed, 0.0).constant()),
                presence: Presence::Required,
            },
            ParamInfo {
                name: "weight",
                doc: &["Weight of `u^2`."],
                ty: ParamType::Scalar(WEIGHT),
                presence: Presence::Default("1"),
            },
            ParamInfo {
                name: "return",
                doc: &["T: how fast the deviation decays by itself."],
                ty: ParamType::Scalar(usual::LIMIT_GAIN.constant()),
                presence: Presence::Default("2 /s"),
            },
            ParamInfo {
                name: "most",
                doc: &["The greatest deviation."],
                ty: ParamType::Scalar(Quantity::above($size, 0.0).constant()),
                presence: Presence::Optional,
            },
        ]
    };
}

/// Parameters of a deviation of a position.
pub static PATH: &[ParamInfo] = deviation!(VELOCITY, LENGTH);
/// Parameters of a deviation of an orientation.
pub static TURN: &[ParamInfo] = deviation!(ANGULAR_VELOCITY, ANGLE);

crate::params! {
    /// Parameters of `safety_planner`.
    pub struct Params {
        /// The protected task, which gives way: any task with a target. It is in the same stack, on a level above.
        task: usize = ParamType::Task, Presence::Required;
        /// F: a declared `safety_field`.
        field: crate::params::FieldIndex = ParamType::Field, Presence::Required;
        /// F_min: the threshold of the field. It may move with time.
        min: Input<1> = ParamType::Scalar(Quantity::above(LENGTH, 0.0).usually(1e-4, 50.0)), Presence::Required;
        /// k_f: how fast the margin F - F_min may decrease, relative to its size.
        gain: Input<1> = ParamType::Scalar(usual::LIMIT_GAIN.constant()), Presence::Default("10 /s");
        /// The planner, or one of two methods for comparison: `evasive` motion (4.50), or a `stop` (4.52).
        method: String = ParamType::Choice(METHODS), Presence::Default("planner");
        /// Of `evasive`: half the width of the band about `min` in which the task fades out, as a fraction of `min`.
        epsilon: Input<1> = ParamType::Scalar(Quantity { min_included: false, ..Quantity::between(NONE, 0.0, 0.99) }.constant()), Presence::Default("0.1");
        /// Scaling of the clock of the task.
        scaling: BoundParams = ParamType::Group(Scaling::INFO), Presence::Default("{}");
        /// Positions and orientations of the task's target that may deviate from their path, by their names in the
        /// task.
        deviate: Option<BoundParams> = ParamType::Deviations, Presence::Optional;
        /// Motion in the null space of the task.
        internal: BoundParams = ParamType::Group(Internal::INFO), Presence::Default("{}");
        /// q_w: weight of the slack of the row that keeps the field; large compared with the other weights.
        relax: Input<1> = ParamType::Scalar(WEIGHT), Presence::Default("1e6");
    }
}

/// Parameters of a deviation, once bound.
#[derive(Clone, Debug)]
pub struct DeviationParams {
    /// Its direction; `None` for the gradient of the field.
    pub along: Option<crate::params::Operand>,
    /// Largest input, m/s or rad/s.
    pub speed: Input<1>,
    /// Its weight.
    pub weight: Input<1>,
    /// T, 1/s.
    pub back: Input<1>,
    /// Largest deviation, m or rad.
    pub most: Option<Input<1>>,
}

impl DeviationParams {
    /// Reads bound parameters; `None` for another form than [`PATH`] and [`TURN`] declare.
    pub fn from_bound(bound: &BoundParams) -> Option<Self> {
        use crate::params::FromBound;
        Some(DeviationParams {
            along: FromBound::from_bound(bound.get("along"))?,
            speed: FromBound::from_bound(bound.get("speed"))?,
            weight: FromBound::from_bound(bound.get("weight"))?,
            back: FromBound::from_bound(bound.get("return"))?,
            most: FromBound::from_bound(bound.get("most"))?,
        })
    }

    /// Returns true if a group of bound parameters is a deviation, and not a group of deviations.
    pub fn is_one(bound: &BoundParams) -> bool {
        bound.contains_key("speed")
    }
}

/// Outputs of a planner. The controller computes them, since the decision is made outside of this task.
pub const OUTPUTS: [TaskOutput; 5] = [
    TaskOutput { name: "scaling", dimension: NONE, description: "u_c, the rate of the clock" },
    TaskOutput { name: "deviation", dimension: LENGTH, description: "size of the largest deviation; rad count as m" },
    TaskOutput {
        name: "slack",
        dimension: VELOCITY,
        description: "w, the part of the demand that bounds, weights and limits above prevent",
    },
    TaskOutput {
        name: "withheld",
        dimension: VELOCITY,
        description: "rate of the field that the rest of the hierarchy prevents",
    },
    TaskOutput { name: "field", dimension: LENGTH, description: "F; absent without people" },
];

/// People move its field, so the rate of `field` counts.
const PERSON_VELOCITY: PersonVelocityUse =
    PersonVelocityUse { uses_rate: |param, _| param == "field", ..PersonVelocityUse::LIMIT };

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "safety_planner",
    summary: "delays and deviates another task so that a safety field stays above a threshold",
    docs: "Equality rows `v = u_n`, one for each degree of freedom: the motion that the protected task leaves \
free. The target of the protected task no longer follows the time, but a clock `c` of its own, and it may \
deviate from its path:\n\n\
```text\n\
c' = u_c                                    0 <= u_c <= 1\n\
target = nominal target at c, deviated      d' = -T d + psi u\n\
min  q_c (u_c - 1)^2 + sum q u^2 + q_n |u_n - k_n dF/dq|^2 + q_w w^2\n\
mu_1 u_c + mu_2 u + mu_3 u_n + w >= F_min' - k_f (F - F_min) - mu_4\n\n\
F, F_min       m                    safety field, and its threshold `min`\n\
dF/dq          1×n  m/rad or m/m    gradient of the field with respect to the configuration\n\
u_c            1                    rate of the clock\n\
d              3×1  m or rad        deviation of a position or an orientation, in the axes of its parameter\n\
psi            3×1                  unit direction `along` of the deviation\n\
u              m/s or rad/s         input of the deviation, at most `speed`\n\
u_n            n×1  rad/s or m/s    velocity of the degrees of freedom in the null space of the task\n\
w              m/s                  slack\n\
T, k_f         1/s                  `return` of a deviation, and `gain`\n\
k_n            1                    `internal.gain`\n\
q_c, q, q_n, q_w                    weights: `scaling.weight`, `weight` of a deviation, `internal.weight`, `relax`\n\
```\n\n\
The row is exact: `F' = mu_1 u_c + mu_2 u + mu_3 u_n + mu_4`, with the coefficients `mu_1` of the clock, `mu_2` \
of the deviations and `mu_3` (1×n) of the internal motion, and the rest `mu_4`, which includes the motion of \
people. The program has one row with a slack, so it always has a solution, and it is solved in one pass. If \
levels above the protected task would withhold the required velocity, the program includes these levels. [Safety \
field and planner](mathematics/safety_field.md) describes the guarantees and their conditions.\n\n\
`t` and `time` in the target of the protected task are its own clock, and trajectories in the target advance \
with that clock. At the entry of the stack, the clock is at 0, like `t`, without a deviation. A signal in the \
target must not move by itself (a tracked point of a person does).\n\n\
`admittance` and `hand_guiding` may be protected. Their wrench, and the velocity from which they continue, are \
those of the present tick. The clock scales only the motion of the target. `hand_guiding` has no target: it \
gives way only in its null space, and `method stop` does not hold it. Targets of tasks with a mass cannot \
deviate, and neither can the expressions of `track`.\n\n\
`method evasive` is `v = m v_task + (I - m J^+ J) k_n dF/dq`, with the pseudoinverse `J^+` of the task's \
Jacobian and `m` from 1 to 0 in a band about `min`. `method stop` stops the clock while the field is not above \
`min`. Both methods are for comparison.\n\n\
The task reports as error the Euclidean norm of `u_n - v`, which is not zero if levels above use a part of the \
motion.\n\n\
Source: thesis 4.2.3, (4.5)-(4.34), 4.4.1.3, with the corrections of Safety field and planner.",
    example: "task guard = safety_planner(hands) {\n  field nearness  min 0.75 m  gain 10 /s\n  scaling { weight 10 }\n  \
deviate { absolute { position { along operator.chest - frame(left_tool).position  speed 0.4 m/s  most 0.3 m } } }\n  internal { gain 0.1 }\n}",
    positional: &["task"],
    outputs: &OUTPUTS,
    person_velocity: Some(&PERSON_VELOCITY),
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

/// Largest nesting depth of groups that contain a parameter.
const GROUPS: usize = 8;

/// Returns true if there are deviations, and nothing else, in groups of at most this depth.
fn is_sound(deviate: &BoundParams, deep: usize) -> bool {
    let one = |b: &Bound| match b {
        Bound::Group(group) if DeviationParams::is_one(group) => DeviationParams::from_bound(group).is_some(),
        Bound::Group(group) => deep > 0 && is_sound(group, deep - 1),
        _ => false,
    };
    !deviate.is_empty() && deviate.values().all(one)
}

struct SafetyPlanner {
    field: usize,
    wanted: Vec<f64>,
    info: Vec<RowInfo>,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    let within = |name: &str| BuildError::new(name, format!("a setting of `{name}` is missing, or has another form"));
    Scaling::from_bound(&params.scaling).map_err(|_| within("scaling"))?;
    Internal::from_bound(&params.internal).map_err(|_| within("internal"))?;
    if !params.deviate.iter().all(|d| is_sound(d, GROUPS)) {
        return Err(within("deviate").help("name a position or an orientation of the protected task, or leave it out"));
    }
    if !METHODS.contains(&params.method.as_str()) {
        return Err(BuildError::new("method", format!("there is no method `{}`", params.method)));
    }
    let info: Vec<RowInfo> = (ctx.model.dofs.iter())
        .map(|d| RowInfo { name: d.name.clone(), dimension: d.unit.select(VELOCITY, ANGULAR_VELOCITY) })
        .collect();
    Ok(Box::new(SafetyPlanner { field: params.field.0, wanted: vec![0.0; info.len()], info }))
}

impl Task for SafetyPlanner {
    fn rows(&self) -> Vec<RowInfo> {
        self.info.clone()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: String::new(), dimension: common_dimension(&self.info) }]
    }

    fn protections(&self) -> Vec<Protection> {
        vec![Protection { links: Vec::new(), hazard: Hazard::Field(self.field) }]
    }

    fn gives_way(&self) -> bool {
        true
    }

    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        Some((0..self.info.len()).collect())
    }

    fn set_decided_velocity(&mut self, velocity: &[f64]) {
        for (w, v) in self.wanted.iter_mut().zip(velocity) {
            *w = *v;
        }
    }

    fn update(&mut self, _state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        for (i, wanted) in self.wanted.iter().enumerate() {
            rows.equal(i, *wanted);
        }
        Ok(())
    }

    fn observe(&self, _state: &State, v: &[f64], _margins: &mut [f64], measures: &mut [f64]) {
        let squares: f64 = self.wanted.iter().zip(v).map(|(w, v)| (w - v).powi(2)).sum();
        measures[0] = squares.sqrt();
    }
}
