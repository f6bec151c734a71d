//! Keeps a value that the spec defines by an expression within limits.
//!
//! ```text
//! h = y - min                      safe where h >= 0;  likewise max - y
//! (J_y - J_min) v >= -φ (h - δ) + d/dt min - d/dt y    thesis (3.19) for any h; δ: the sampled-time reserve
//! ```
//!
//! where `J` is the derivative in the robot's configuration and `d/dt` the one in time while the robot stands still.

use std::cell::RefCell;

use crate::bound::BoundParams;
use crate::build::check;
use crate::curvature::{Bend, bends};
use crate::dimension::{Dimension, NONE};
use crate::expression::{Term, settle};
use crate::expression_tasks::{Gain, current_value, dimension, fault, row_names};
use crate::params::{Auto, Form, Operand, ParamType, Presence};
use crate::protection::{BoundedPosition, BoundedValue, Protection};
use crate::sampled_margin::SampledMargin;
use crate::task::{
    BuildError, Context, CurrentValue, CurrentValueType, ExpressedIn, PersonVelocityUse, RowInfo, RowKind, Rows, State,
    Task, TaskFault, TaskKind,
};
use quantities::usual;

crate::params! {
    /// Parameters of `keep`.
    pub struct Params {
        /// y: the value that is kept within limits, a number or a vector; of a vector, each of the three numbers.
        value: Operand = ParamType::Expression(Form::Value { orientation: false }), Presence::Required;
        /// The smallest allowed value; it may move. One of `min` and `max` must be given. In a vector, `none` is a number
        /// without a limit.
        min: Option<Operand> = ParamType::Expression(Form::Like("value")), Presence::Optional;
        /// The largest allowed value; it may move.
        max: Option<Operand> = ParamType::Expression(Form::Like("value")), Presence::Optional;
        /// φ: how fast the margin may decrease, relative to its size.
        gain: Operand = ParamType::Expression(Form::Number(usual::LIMIT_GAIN)), Presence::Default("5 /s");
        /// δ: reserve against the margin that sampling in time can lose; `auto` computes it from the hard speed limits, for
        /// all joints at full speed.
        sampled_margin: Auto = ParamType::Expression(Form::Size("value")), Presence::Default("0");
    }
}

/// Size from which a limit counts as absent: the compiler writes it, with its sign, for `none` in a vector of limits.
pub const OPEN: f64 = 1e300;

/// True for a limit that is absent. One that is not a number is none of these, and a fault.
fn is_open(limit: f64) -> bool {
    limit.abs() >= OPEN
}

/// The catalogue entry.
pub static KIND: TaskKind = TaskKind {
    name: "keep",
    summary: "keeps a value, written as an expression, within limits",
    docs: "One inequality row for a number, three (x, y, z) for a vector:\n\n\
```text\n\
h = y - min                                                safe where h >= 0\n\
(J_y - J_min) v  >=  -φ (h - δ) + d/dt min - d/dt y        likewise max - y\n\n\
y, min, max, h, δ  unit of the value          value, limits, margin, and reserve `sampled_margin`\n\
J_y, J_min         1×n  that unit/rad or /m   exact derivatives with respect to the configuration\n\
d/dt               that unit/s                derivative in time while the robot stands still\n\
v                  n×1  rad/s or m/s          velocity of the n degrees of freedom\n\
φ                  1/s                        gain\n\
```\n\n\
`value` is any expression that contains the present state of the robot: `frame(F).position`, \
`frame(F).orientation`, `point(F, [x, y, z] m)`, `joint(J)`, `distance(a, b)`, `com`, `manipulability(F)`. `min`, `max` and `gain` \
may contain the state too. A value with two limits, one of which depends on the state, has a separate row for \
each limit.\n\n\
If the value has no derivative (`norm` of zero, the corner of a `min`), the row is that of the branch that the \
value takes, or zero; the page on expressions lists these points. No motion can meet a row that is zero.\n\n\
A row is held over a period, and a curved value can fall slightly below its limit in that time: by `A T / (2 \
φ)`, with the control period T and a bound A of its curvature in time. `sampled_margin` is a reserve against \
this loss. `auto` computes A from the operations of `value`, `min` and `max` at the speeds that `joint_velocity_limits` allow, on the hard \
levels down to that of the task: positions, orientations, joints, `com` and `distance`, their sums, products, sines, norms and largest \
values. Numbers that move with time count as moving at constant rates. Where a value has no bound (a quotient, root or arc function that comes near a \
singular point, the smallest of several values, `manipulability`, positions of a base that multiply each other), `auto` is an error.\n\n\
Source: thesis (3.19) for any h; the derivative by reverse accumulation is ours.",
    example: "task gap = keep(norm(frame(left_tool).position - frame(right_tool).position)) { min 0.3 m  gain 5 /s }",
    positional: &["value"],
    current_values: &[CurrentValue {
        name: "value",
        ty: CurrentValueType::Of("value"),
        expressed_in: ExpressedIn::SameAsParameter,
    }],
    person_velocity: Some(&PersonVelocityUse::LIMIT),
    ..TaskKind::new(RowKind::Inequality, Params::INFO, build)
};

struct Keep {
    value: RefCell<Term>,
    min: Option<Term>,
    max: Option<Term>,
    gain: Gain,
    dimension: Dimension,
    /// Reserves of the numbers at their lower limits, and at their upper ones.
    reserves: [SampledMargin; 2],
    /// Links and joint positions that are bounded.
    bounded: BoundedValue,
    /// True if one row contains both sides.
    joint: bool,
}

fn build(bound: &BoundParams, ctx: &Context) -> Result<Box<dyn Task>, BuildError> {
    check(bound, ctx)?;
    let params = Params::from_bound(bound)?;
    if params.min.is_none() && params.max.is_none() {
        return Err(BuildError::new("", "`keep` has neither `min` nor `max`, and nothing is kept")
            .help("write the smallest value with `min`, the largest with `max`, or both"));
    }
    if matches!(params.value.len(), 4 | 7) {
        return Err(BuildError::new("value", "an orientation or a pose has no smallest or largest")
            .help("keep a number that is made of it, such as `dot(frame(F).orientation*[0, 0, 1], [0, 0, 1])`"));
    }
    for (name, side) in [("min", &params.min), ("max", &params.max)] {
        if side.as_ref().is_some_and(|s| s.len() != params.value.len()) {
            return Err(BuildError::new(name, format!("`{name}` has another form than `value`")));
        }
    }
    let bounded = BoundedValue::new(&params.value, params.min.as_ref(), params.max.as_ref());
    let ready = |o: &Operand| Term::new(o, ctx.model);
    let (min, max) = (params.min.as_ref().map(ready), params.max.as_ref().map(ready));
    let moves = |t: &Option<Term>| t.as_ref().is_some_and(Term::is_state);
    let joint = min.is_none() || max.is_none() || !(moves(&min) || moves(&max));
    let gain = Gain::new(&params.gain, ctx)?;
    let reserves = reserves(&params, &gain, ctx)?;
    let dimension = dimension(&params.value).unwrap_or(NONE);
    Ok(Box::new(Keep {
        value: RefCell::new(ready(&params.value)),
        min,
        max,
        gain,
        dimension,
        reserves,
        bounded,
        joint,
    }))
}

/// Reserves of both sides.
fn reserves(params: &Params, gain: &Gain, ctx: &Context) -> Result<[SampledMargin; 2], BuildError> {
    let names = row_names(params.value.len());
    let auto = params.sampled_margin == Auto::Auto;
    let gain = match gain.constant(ctx.values).as_slice() {
        [gain] => *gain,
        _ if auto => {
            return Err(BuildError::new(
                "sampled_margin",
                "`auto` needs a gain that does not depend on the robot's state",
            )
            .help("write a constant `gain`, or a length in place of `auto`"));
        }
        _ => 0.0,
    };
    let of = |operand: Option<&Operand>, number: usize, speed: &[f64]| match operand {
        Some(Operand::Expression(e)) => bends(e, ctx.model, speed).get(number).copied(),
        _ => Some(Bend::LINEAR),
    };
    let side = |least: bool| {
        let limit = if least { &params.min } else { &params.max };
        let bound = |number: usize, speed: &[f64]| match (auto, limit) {
            (true, Some(limit)) => {
                let (value, limit) = (of(Some(&params.value), number, speed), of(Some(limit), number, speed));
                let both = value.zip(limit);
                both.map_or(f64::INFINITY, |(y, s)| if least { y.down + s.up } else { y.up + s.down })
            }
            _ => 0.0,
        };
        SampledMargin::new(Some(params.sampled_margin), gain, names, &bound, ctx).map_err(|e| match auto {
            true => unbounded(e, &|number| bound(number, &vec![1.0; ctx.speed.len()]), names),
            false => e,
        })
    };
    Ok([side(true)?, side(false)?])
}

/// Error of a value without a bound at any speeds, in place of one about speeds.
fn unbounded(e: BuildError, bound: &dyn Fn(usize) -> f64, names: &[&str]) -> BuildError {
    match (0..names.len()).find(|&i| !bound(i).is_finite()) {
        Some(i) => {
            BuildError::new("sampled_margin", format!("`auto` has no bound for the curvature of `{}`", names[i]))
                .help("write a reserve in the unit of the value, or leave `sampled_margin` out")
        }
        None => e,
    }
}

impl Keep {
    /// Writes row `i` for number `c`: the lower side, the upper side, or both.
    fn row(
        &mut self,
        state: &State,
        rows: &mut Rows,
        i: usize,
        c: usize,
        sides: (bool, bool),
    ) -> Result<(), TaskFault> {
        let gain = self.gain.of(state);
        let (mut plus, mut minus) = ([0.0; 3], [0.0; 3]);
        (plus[c], minus[c]) = (1.0, -1.0);
        let value = self.value.get_mut();
        let y = value.value(state, c);
        let still = value.add_row(state, &plus, rows.row(i));
        // A side that depends on the state has a row of its own, which contains its coefficients.
        let mut margin = f64::INFINITY;
        // Sides that are given; `none` leaves one open.
        let mut closed = (false, false);
        if let Some(min) = self.min.as_mut().filter(|min| sides.0 && !is_open(min.value(state, c))) {
            let h = y - min.value(state, c);
            let own = min.add_row(state, &minus, rows.row(i));
            rows.lower[i] = -gain * h + self.reserves[0].rate(c, gain) - own - still;
            margin = h;
            closed.0 = true;
        }
        if let Some(max) = self.max.as_mut().filter(|max| sides.1 && !is_open(max.value(state, c))) {
            let h = max.value(state, c) - y;
            let own = max.add_row(state, &minus, rows.row(i));
            rows.upper[i] = gain * h - self.reserves[1].rate(c, gain) - own - still;
            margin = if h.is_nan() { h } else { margin.min(h) };
            closed.1 = true;
        }
        let value = self.value.get_mut();
        match (sides, &self.min, &self.max) {
            ((true, false), Some(side), _) | ((false, true), _, Some(side)) => settle(rows.row(i), &[value, side]),
            _ => settle(rows.row(i), &[value]),
        }
        // Comparisons with NaN are false, so NaN passes neither test.
        let side = |x: f64, closed: bool| !closed || x.is_finite();
        let good = y.is_finite() && (margin.is_finite() || closed == (false, false));
        if !good || !side(rows.lower[i], closed.0) || !side(rows.upper[i], closed.1) {
            return Err(TaskFault::NotFinite { row: i });
        }
        if rows.lower[i] > rows.upper[i] {
            return Err(TaskFault::Crossed { row: i });
        }
        rows.margins[i] = margin;
        Ok(())
    }
}

impl Keep {
    /// Numbers of both sides as numbers of rows; empty if all are zero.
    fn of_rows(&self, numbers: impl Fn(&SampledMargin) -> &Vec<f64>) -> Vec<f64> {
        let [lower, upper] = [numbers(&self.reserves[0]), numbers(&self.reserves[1])];
        let all: Vec<f64> = match self.joint {
            true => lower.iter().zip(upper).map(|(a, b)| a.max(*b)).collect(),
            false => lower.iter().chain(upper).copied().collect(),
        };
        if all.iter().all(|x| *x == 0.0) { Vec::new() } else { all }
    }
}

impl Task for Keep {
    fn rows(&self) -> Vec<RowInfo> {
        let names = row_names(self.value.borrow().len());
        let sides: &[&str] = if self.joint { &[""] } else { &[" min", " max"] };
        let row = |name: &&str, side: &str| RowInfo { name: format!("{name}{side}"), dimension: self.dimension };
        sides.iter().flat_map(|side| names.iter().map(|n| row(n, side))).collect()
    }

    fn bounded_positions(&self) -> Vec<BoundedPosition> {
        self.bounded.positions.clone()
    }

    fn protections(&self) -> Vec<Protection> {
        self.bounded.protections.clone()
    }

    fn gains(&self, values: &[f64]) -> Vec<f64> {
        self.gain.constant(values)
    }

    fn enter(&mut self, _state: &State) {
        self.value.get_mut().forget();
        [&mut self.min, &mut self.max].into_iter().flatten().for_each(Term::forget);
        self.gain.forget();
    }

    crate::task::takes_over!(value, min, max, gain);

    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault> {
        let value = self.value.get_mut();
        let n = value.len();
        value.forward(state).map_err(fault)?;
        for side in [&mut self.min, &mut self.max].into_iter().flatten() {
            side.forward(state).map_err(fault)?;
        }
        self.gain.forward(state)?;
        for c in 0..n {
            if self.joint {
                self.row(state, rows, c, c, (true, true))?;
            } else {
                self.row(state, rows, c, c, (true, false))?;
                self.row(state, rows, n + c, c, (false, true))?;
            }
        }
        Ok(())
    }

    fn sampled_loss(&self) -> Vec<f64> {
        self.of_rows(|reserve| &reserve.loss)
    }

    fn sampled_margin(&self) -> Vec<f64> {
        self.of_rows(|reserve| &reserve.kept)
    }

    fn set_locked_joints_moving(&mut self, moving: bool) {
        self.reserves.iter_mut().for_each(|reserve| reserve.set_locked_joints_moving(moving));
    }

    fn current_value(&self, name: &str, state: &State, out: &mut [f64]) -> bool {
        name == "value" && current_value(&self.value, state, out)
    }
}
