//! Pulls a value that the spec defines by an expression to a target.
//!
//! ```text
//! (J_y - J_d) v = d/dt y_d - d/dt y + K (y_d - y)          thesis (2.5) for any y
//! ```
//!
//! where `J` is the derivative in the robot's configuration and `d/dt` the one in time while the robot stands still.
//! For an orientation, the derivatives are angular velocities and the error is the rotation vector of `R_d R^T`. A pose
//! has the rows of its position and those of its orientation.

use std::cell::RefCell;

use nalgebra::{UnitQuaternion, Vector3};

use crate::bound::BoundParams;
use crate::build::check;
use crate::dimension::{ANGLE, Dimension};
use crate::expression::{Term, Turning, settle, turn_seeds};
use crate::expression_tasks::{Gain, current_value, dimension, fault, row_names};
use crate::kinds::frame_pose::{pose_measures, pose_rows};
use crate::params::{Form, Operand, ParamType, Presence};
use crate::so3;
use crate::task::{
    BuildError, Context, CurrentValue, CurrentValueType, ExpressedIn, Measure, RowInfo, RowKind, Rows, State, Task,
    TaskFault, TaskKind,
};
use crate::turns::{TURNS, asks_for_nearest, nearest_turn};
use quantities::usual;

crate::params! {
    /// Parameters of `track`.
    pub struct Params {
        /// y: the value that is pulled to the target: a number, a vector, an orientation or a pose.
        value: Operand = ParamType::Expression(Form::Value { orientation: true }), Presence::Required;
        /// y_d: the target of the value; it may move.
        target: Operand = ParamType::Expression(Form::Like("value")), Presence::Required;
        /// Way to the target of an angle whose whole turns mean nothing, an `atan2` or the position of a continuous joint
        /// without limits: `nearest` turns by at most half a turn, `exact` to the target as a number of turns. Other
        /// values always move to the target as it is written.
        turns: String = TURNS, Presence::Default("nearest");
        /// K: how fast the error decays.
        gain: Operand = ParamType::Expression(Form::Number(usual::GAIN)), Presence::Default("2 /s");
    }
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "track",
    summary: "pulls a value, written as an expression, to a target",
    docs: "One equality row for a number, three for a vector (x, y, z) or an orientation (rx, ry, rz, in the \
world's axes), six for a pose:\n\n\
```text\n\
(J_y - J_d) v = d/dt y_d - d/dt y + K (y_d - y)      numbers, vectors, positions\n\
(J_y - J_d) v = ω_d - ω_y + K log(R_d R^T)           orientations\n\n\
y, y_d    unit of the value          value and target;  R, R_d for orientations\n\
J_y, J_d  1×n  that unit/rad or /m   exact derivatives with respect to the configuration, one row per number\n\
d/dt      that unit/s                derivative in time while the robot stands still\n\
ω_y, ω_d  3×1  rad/s                 that derivative of an orientation: angular velocity in the world's axes\n\
log       3×1  rad                   rotation vector, with an angle of at most pi\n\
v         n×1  rad/s or m/s          velocity of the n degrees of freedom\n\
K         1/s                        gain\n\
```\n\n\
`value` is any expression that contains the present state of the robot: `frame(F).position`, \
`frame(F).orientation`, `frame(F).pose`, `point(F, [x, y, z] m)`, `joint(J)`, `distance(a, b)`. `target` and \
`gain` may contain the state too. For an orientation, `J_y` and `J_d` map `v` to angular velocities. The task \
reports the norm of the error.\n\n\
An `atan2` jumps by a turn where its point crosses the seam, and a continuous joint without position limits is at \
the same place after each turn. The error of such an angle, alone or in a sum, is taken to the nearest turn, within \
-pi and pi, so that the value may cross the seam; a `trapezoid` or `s_curve` to its target goes the near way too. \
With `turns exact` the target of a joint is a number of turns. Half an `atan2`, or its square root, jumps by \
something else than a turn, and is a warning.\n\n\
If the value has no derivative (`norm` of zero, the corner of a `min`), the row is that of the branch that the \
value takes, or zero; the page on expressions lists these points. A row that is zero has no effect.\n\n\
A direction (a vector of length 1) has three numbers and two degrees of freedom. If the target is a direction \
that moves with the robot too, the three rows approach linear dependence as the error becomes small. Track two \
numbers instead, such as `dot` with two axes, or a position in the robot's own frame, \
`inverse(frame(F).orientation)*(p - frame(F).position)`.\n\n\
Source: thesis (2.5) for any y; the derivative by reverse accumulation is ours.",
    example: "task pointing = track(frame(tool).orientation*[0, 0, 1]) { target [0, 0, -1]  gain 2 /s }",
    positional: &["value"],
    current_values: &[CurrentValue {
        name: "value",
        ty: CurrentValueType::Of("value"),
        expressed_in: ExpressedIn::SameAsParameter,
    }],
    ..TaskKind::new(RowKind::Equality, Params::INFO, build)
};

struct Track {
    value: RefCell<Term>,
    target: Term,
    gain: Gain,
    dimension: Dimension,
    /// True if the error is that to the nearest turn.
    nearest: bool,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.target.len() != params.value.len() {
        return Err(BuildError::new("target", "`target` has another form than `value`"));
    }
    let gain = Gain::new(&params.gain, ctx)?;
    let dimension = dimension(&params.value).unwrap_or(ANGLE);
    let turning = match &params.value {
        Operand::Expression(e) if params.value.len() == 1 => e.turning(ctx.model),
        _ => Turning::Steady,
    };
    let nearest = asks_for_nearest(&params.turns)?;
    if !nearest && turning == Turning::JumpsByTurns {
        return Err(BuildError::new(
            "turns",
            "an `atan2` counts no turns, so that its target is never a number of them",
        )
        .help("leave `turns` out"));
    }
    let nearest = nearest && turning.is_angle_on_circle();
    let (value, target) = (Term::new(&params.value, ctx.model), Term::new(&params.target, ctx.model));
    Ok(Box::new(Track { value: RefCell::new(value), target, gain, dimension, nearest }))
}

/// Returns how many numbers of a value have a row each, and true if an orientation follows them.
fn form(len: usize) -> (usize, bool) {
    match len {
        4 => (0, true),
        7 => (3, true),
        n => (n, false),
    }
}

impl Track {
    /// Writes the rows of a number, a vector or a position; returns the norm of the error.
    fn linear(&mut self, state: &State, rows: &mut Rows, n: usize, gain: f64) -> f64 {
        let value = self.value.get_mut();
        let mut squares = 0.0;
        for i in 0..n {
            let (mut plus, mut minus) = ([0.0; 3], [0.0; 3]);
            (plus[i], minus[i]) = (1.0, -1.0);
            let way = self.target.value(state, i) - value.value(state, i);
            let error = if self.nearest { nearest_turn(way) } else { way };
            let still = value.add_row(state, &plus, rows.row(i)) + self.target.add_row(state, &minus, rows.row(i));
            settle(rows.row(i), &[value, &self.target]);
            rows.equal(i, gain * error - still);
            squares += error * error;
        }
        squares.sqrt()
    }

    /// Writes the rows of an orientation that follows `first` other numbers; returns the angle of the error.
    fn angular(&mut self, state: &State, rows: &mut Rows, first: usize, gain: f64) -> f64 {
        let value = self.value.get_mut();
        let (q, d) = (value.quaternion(state), self.target.quaternion(state));
        let (length, target_length) = (q.norm(), d.norm());
        let (q, d) = (UnitQuaternion::new_unchecked(q / length), UnitQuaternion::new_unchecked(d / target_length));
        let error: Vector3<f64> = so3::log(&(d * q.inverse()));
        for i in 0..3 {
            let (mut plus, mut minus) = ([0.0; 7], [0.0; 7]);
            for (k, (s, t)) in turn_seeds(&q, i).into_iter().zip(turn_seeds(&d, i)).enumerate() {
                (plus[first + k], minus[first + k]) = (s / length, -t / target_length);
            }
            let row = first + i;
            let still = value.add_row(state, &plus, rows.row(row)) + self.target.add_row(state, &minus, rows.row(row));
            settle(rows.row(row), &[value, &self.target]);
            rows.equal(row, gain * error[i] - still);
        }
        error.norm()
    }
}

impl Task for Track {
    fn rows(&self) -> Vec<RowInfo> {
        let len = self.value.borrow().len();
        if len == 7 {
            return pose_rows("");
        }
        let row = |name: &&str| RowInfo { name: (*name).to_string(), dimension: self.dimension };
        row_names(len).iter().map(row).collect()
    }

    fn measures(&self) -> Vec<Measure> {
        if self.value.borrow().len() == 7 {
            return pose_measures("");
        }
        vec![Measure { name: String::new(), dimension: self.dimension }]
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.constant(values)
    }

    fn enter(&mut self, _state: &State) {
        self.value.get_mut().forget();
        self.target.forget();
        self.gain.forget();
    }

    crate::task::takes_over!(value, target, gain);

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let value = self.value.get_mut();
        let n = value.len();
        value.forward(state).map_err(fault)?;
        self.target.forward(state).map_err(fault)?;
        self.gain.forward(state)?;
        let gain = self.gain.of(state);
        let (plain, turned) = form(n);
        if plain > 0 {
            rows.measures[0] = self.linear(state, rows, plain, gain);
        }
        if turned {
            rows.measures[usize::from(plain > 0)] = self.angular(state, rows, plain, gain);
        }
        match (0..plain + if turned { 3 } else { 0 }).find(|&i| !rows.lower[i].is_finite()) {
            Some(row) => Err(TaskFault::NotFinite { row }),
            None => Ok(()),
        }
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        name == "value" && current_value(&self.value, state, out)
    }
}
