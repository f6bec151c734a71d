//! Lets another task give way, so that a safety field stays above a threshold: scales its clock, deviates its path, and
//! moves the robot inside its null space. Thesis 4.2.3, Algorithm 1.
//!
//! ```text
//! v = u_n        one row for each degree of freedom, thesis (4.34)
//! ```
//!
//! What is decided, and what it does to the protected task, is worked out by the runtime, which knows both tasks.

use crate::bound::{Bound, BoundParams};
use crate::build::check;
use crate::dimension::{ANGLE, ANGULAR_VELOCITY, LENGTH, NONE, RATE, VELOCITY};
use crate::kinds::joint_position::common_dimension;
use crate::params::{Form, Input, ParamInfo, ParamType, Presence, Quantity};
use crate::task::{
    BuildError, Context, Measure, Nature, Reckons, RowInfo, Rows, State, Task, TaskFault, TaskKind, Told,
};

/// A weight in the planner's cost.
const WEIGHT: Quantity = Quantity::above(NONE, 0.0).constant();

/// What decides.
const METHODS: &[&str] = &["planner", "evasive", "stop"];

crate::params! {
    /// How the clock of the protected task is scaled.
    pub struct Scaling {
        /// Weight of `(u_c - 1)^2`: large, and the planner rather deviates than slows down.
        weight: Input<1> = ParamType::Scalar(WEIGHT), Presence::Default("1");
    }
}

crate::params! {
    /// Motion in the null space of the protected task.
    pub struct Internal {
        /// k_n: how much of the field's gradient is followed while nothing forces it; 0 for none.
        gain: Input<1> = ParamType::Scalar(Quantity::at_least(NONE, 0.0).constant()), Presence::Default("1");
        /// Weight of `|u_n - k_n dF/dq|^2`.
        weight: Input<1> = ParamType::Scalar(WEIGHT), Presence::Default("1");
    }
}

/// A parameter of a deviation that both kinds have.
macro_rules! deviation {
    ($speed:expr, $size:expr) => {
        &[
            ParamInfo {
                name: "along",
                doc: &["Where it leads, in the axes of the parameter; the length does not count. Left out: where the field grows fastest."],
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
                doc: &["T: how fast it goes back to the nominal path by itself."],
                ty: ParamType::Scalar(Quantity::above(RATE, 0.0).constant()),
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

/// What a deviation of a position is described by.
pub static PATH: &[ParamInfo] = deviation!(VELOCITY, LENGTH);
/// What a deviation of an orientation is described by.
pub static TURN: &[ParamInfo] = deviation!(ANGULAR_VELOCITY, ANGLE);

crate::params! {
    /// Parameters of `safety_planner`.
    pub struct Params {
        /// The task that gives way: any that pulls towards a target. It stands in the same stack, on a level above.
        task: usize = ParamType::Task, Presence::Required;
        /// F: a declared `safety_field`.
        field: crate::params::FieldIndex = ParamType::Field, Presence::Required;
        /// F_min: what the field is kept above. It may move with time.
        min: Input<1> = ParamType::Scalar(Quantity::above(LENGTH, 0.0)), Presence::Required;
        /// k_f: how fast the margin F - F_min may be used up.
        gain: Input<1> = ParamType::Scalar(Quantity::above(RATE, 0.0).constant()), Presence::Default("10 /s");
        /// The planner, or one of the two it is compared with: `evasive` motion (4.50), or a `stop` (4.52).
        method: String = ParamType::Choice(METHODS), Presence::Default("planner");
        /// Of `evasive`: half the width of the band about `min` in which the task fades, as a share of `min`.
        epsilon: Input<1> = ParamType::Scalar(Quantity { min_included: false, ..Quantity::between(NONE, 0.0, 0.99) }.constant()), Presence::Default("0.1");
        /// The clock of the task.
        scaling: BoundParams = ParamType::Group(Scaling::INFO), Presence::Default("{}");
        /// Positions and orientations of the task's target that may leave their path, under the names that they have in
        /// the task.
        deviate: Option<BoundParams> = ParamType::Deviations, Presence::Optional;
        /// Motion in the null space of the task.
        internal: BoundParams = ParamType::Group(Internal::INFO), Presence::Default("{}");
        /// q_w: weight of the slack of the row that keeps the field; large against the others.
        relax: Input<1> = ParamType::Scalar(WEIGHT), Presence::Default("1e6");
    }
}

/// Parameters of a deviation, once bound.
#[derive(Clone, Debug)]
pub struct DeviationParams {
    /// Where it leads; none for the gradient of the field.
    pub along: Option<crate::params::Operand>,
    /// The greatest input, m/s or rad/s.
    pub speed: Input<1>,
    /// Its weight.
    pub weight: Input<1>,
    /// T, 1/s.
    pub back: Input<1>,
    /// The greatest deviation, m or rad.
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

    /// Whether a group of bound parameters is a deviation, and no group of them.
    pub fn is_one(bound: &BoundParams) -> bool {
        bound.contains_key("speed")
    }
}

/// What the controller tells of a planner, which decides beside its task.
pub const TELLS: [Told; 5] = [
    Told { name: "scaling", dimension: NONE, is: "u_c, how fast the clock goes" },
    Told { name: "deviation", dimension: LENGTH, is: "the size of the largest deviation; rad count as m" },
    Told {
        name: "slack",
        dimension: VELOCITY,
        is: "w, what bounds, weights and limits above did not let the inputs give",
    },
    Told {
        name: "withheld",
        dimension: VELOCITY,
        is: "how much faster the field would rise if the rest of the hierarchy let the robot move as planned",
    },
    Told { name: "field", dimension: LENGTH, is: "F; absent while there is nobody" },
];

/// People move its field.
const RECKONS: Reckons = Reckons { rate: |param, _| param == "field", ..Reckons::LIMIT };

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "safety_planner",
    summary: "lets another task give way so that a safety field stays above a threshold",
    docs: "Equality rows `v = u_n`, one for each degree of freedom: what the protected task leaves free. The protected task \
itself is no longer followed in time, but on a clock `c` of its own, and may leave its path:\n\n\
```text\n\
c' = u_c                                    0 <= u_c <= 1\n\
target = nominal target at c, deviated      d' = -T d + psi u\n\
min  q_c (u_c - 1)^2 + sum q u^2 + q_n |u_n - k_n dF/dq|^2 + q_w w^2\n\
     mu_1 u_c + mu_2 u + mu_3 u_n + w >= F_min' - k_f (F - F_min) - mu_4\n\
```\n\n\
where `F' = mu_1 u_c + mu_2 u + mu_3 u_n + mu_4` is what each of them does to the field, exactly. The program has one row and \
a slack, so it always has a solution, which is found in one pass. Where levels above the protected task would withhold \
what it asks for, they are taken into the program. What is guaranteed, and what is not, stands in \
[Safety field and planner](mathematics/safety_field.md).\n\n\
`t` and `time` in the target of the protected task are its own clock, and trajectories in it step with that clock. On \
entering the stack the clock stands where `t` does, at 0, without a deviation. A signal in the target must not move by itself \
(a tracked point of a person does).\n\n\
`admittance` and `hand_guiding` may be protected. Their wrench and the velocity that they go on from are those of now; what the \
clock scales is the motion of the target, so that `hand_guiding`, which has none, gives way in its null space alone, and `method stop` \
does not hold it. Targets with a mass behind them do not deviate, and neither do expressions that `track` follows.\n\n\
`method evasive` is `v = m v_task + (I - m J^+ J) k_n dF/dq` with `m` from 1 to 0 in a band about `min`; `method stop` stops the \
clock while the field is not above `min`. Both are there to be compared with.\n\n\
The error is the Euclidean norm of `u_n - v`; levels above take from it what they need.\n\n\
Source: thesis 4.2.3, (4.5)-(4.34), 4.4.1.3, with the corrections of Safety field and planner.",
    example: "task guard = safety_planner(hands) {\n  field nearness  min 0.75 m  gain 10 /s\n  scaling { weight 10 }\n  \
deviate { absolute { position { along operator.chest - frame(left_tool).position  speed 0.4 m/s  most 0.3 m } } }\n  internal { gain 0.1 }\n}",
    nature: Nature::Target,
    params: Params::INFO,
    positional: &["task"],
    actuals: &[],
    tells: &TELLS,
    reckons: Some(&RECKONS),
    build,
};

/// Most groups within each other in which a parameter may stand.
const GROUPS: usize = 8;

/// Whether there are deviations, and nothing else, in groups at most so deep.
fn is_sound(deviate: &BoundParams, deep: usize) -> bool {
    let one = |b: &Bound| match b {
        Bound::Group(group) if DeviationParams::is_one(group) => DeviationParams::from_bound(group).is_some(),
        Bound::Group(group) => deep > 0 && is_sound(group, deep - 1),
        _ => false,
    };
    !deviate.is_empty() && deviate.values().all(one)
}

struct SafetyPlanner {
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
        .map(|d| RowInfo {
            name: d.name.clone(),
            dimension: match d.unit {
                robot::DofUnit::Metre => VELOCITY,
                robot::DofUnit::Radian => ANGULAR_VELOCITY,
            },
        })
        .collect();
    Ok(Box::new(SafetyPlanner { wanted: vec![0.0; info.len()], info }))
}

impl Task for SafetyPlanner {
    fn rows(&self) -> Vec<RowInfo> {
        self.info.clone()
    }

    fn measures(&self) -> Vec<Measure> {
        vec![Measure { name: String::new(), dimension: common_dimension(&self.info) }]
    }

    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        Some((0..self.info.len()).collect())
    }

    fn gains(&self, _values: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    fn decided(&mut self, velocity: &[f64]) {
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
