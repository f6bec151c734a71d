//! Body with mass, damping and stiffness that a wrench moves, shared by `admittance` and `hand_guiding`.
//!
//! For each axis, with mass m, damping d, stiffness k, the target's velocity v_d and acceleration a_d, the error e of
//! the position and the external force h, thesis (4.36) with the sign of h corrected is
//!
//! ```text
//! m (a_d - a) + d (v_d - v) + k e = -h
//! ```
//!
//! With `a = (v - v_prev) / T` of thesis (4.41), the velocity of this tick is
//!
//! ```text
//! v = (m (v_prev + T a_d) + T (d v_d + k e + h)) / (m + T d)
//! ```
//!
//! which is thesis (4.44) divided by `m/T + d`: each row is in m/s or rad/s, so that a level that cannot meet all of
//! its rows weighs errors of velocities, as for every other target, and not forces.
//!
//! Velocity of the body. `v_prev` is `J v_stack`, with the velocity that the stack's hierarchy returned at the last
//! tick. It includes the reductions by limits and by more important levels, so that there is no windup. It excludes the
//! offset by which a blend moves the reference: fed back, the offset of each tick would count as a velocity of the
//! body, and accumulate. At the tick at which the stack is entered, `v_stack` is the velocity of the reference. If the
//! stack is entered with a blend, the law applies from the second tick on: the first one asks for `v_prev`, so that the
//! offset of the blend, which is measured then, contains no acceleration of the body.
//!
//! Stability. For a target at rest, with x the displacement, a tick is
//!
//! ```text
//! v' = (m v - T k x) / (m + T d)        x' = x + T v'
//! ```
//!
//! Its matrix has the determinant `m / (m + T d)` and the trace `1 + (m - k T^2) / (m + T d)`. Both eigenvalues lie
//! inside the unit circle if and only if (Jury) `d > 0`, `k > 0` and `1 + trace + determinant > 0`, which is
//!
//! ```text
//! k T^2  <  4 m + 2 d T
//! ```
//!
//! Mass and damping alone are stable with any period: they are implicit in `v`. Only the spring, which acts on the
//! error of the last tick, imposes a bound.

use nalgebra::Vector3;
use robot::LinkId;

use crate::bound::BoundParams;
use crate::clik::axes;
use crate::dimension::{ANGULAR_DAMPING, DAMPING, Dimension, FORCE, INERTIA, MASS, MOMENT, STIFFNESS};
use crate::expression::Term;
use crate::expression_tasks::fault;
use crate::params::{Form, Input, Operand, ParamType, Presence, Quantity, WrongForm};
use crate::task::{BuildError, Context, Rows, State, TaskFault};

crate::params! {
    /// The virtual mass of a frame.
    pub struct Mass {
        /// The mass of its position, for all axes of the world or one for each; it may move with time.
        linear: Input<3> = ParamType::PerAxis(Quantity::above(MASS, 0.0).usually(1e-3, 2e3)), Presence::Required;
        /// The moment of inertia of its orientation, for all axes of the world or one for each; it may move with time.
        angular: Input<3> = ParamType::PerAxis(Quantity::above(INERTIA, 0.0).usually(1e-6, 1e3)), Presence::Required;
    }
}

crate::params! {
    /// The virtual damping of a frame.
    pub struct Damping {
        /// The damping of its position, for all axes of the world or one for each; it may move with time.
        linear: Input<3> = ParamType::PerAxis(Quantity::above(DAMPING, 0.0).usually(1e-2, 1e5)), Presence::Required;
        /// The damping of its orientation, for all axes of the world or one for each, in N m s or N m s/rad; it may
        /// move with time.
        angular: Input<3> = ParamType::PerAxis(Quantity::above(ANGULAR_DAMPING, 0.0).usually(1e-4, 1e4)), Presence::Required;
    }
}

crate::params! {
    /// The virtual stiffness of a frame.
    pub struct Stiffness {
        /// The stiffness of its position, for all axes of the world or one for each; it may move with time.
        linear: Input<3> = ParamType::PerAxis(Quantity::at_least(STIFFNESS, 0.0).usually(0.1, 1e6)), Presence::Required;
        /// The stiffness of its orientation, for all axes of the world or one for each, in N m or N m/rad; it may move
        /// with time.
        angular: Input<3> = ParamType::PerAxis(Quantity::at_least(MOMENT, 0.0).usually(1e-3, 1e5)), Presence::Required;
    }
}

crate::params! {
    /// External wrench on the robot at a frame, in the world's axes.
    pub struct Wrench {
        /// The force that a person or the environment exerts on the robot, along the world's axes: a push towards +x
        /// has a positive first number.
        force: Operand = ParamType::Expression(Form::Vector(FORCE)), Presence::Required;
        /// The moment of this wrench on the robot about the frame's origin, along the world's axes.
        moment: Operand = ParamType::Expression(Form::Vector(MOMENT)), Presence::Default("[0, 0, 0] N m");
    }
}

/// Names of the parts of a pose, and the dimension of their stiffness.
const PARTS: [(&str, Dimension); 2] = [("linear", STIFFNESS), ("angular", MOMENT)];

/// Reads a group of the parameters of a task.
///
/// # Errors
/// A number in it is missing or has another form; the error names the group.
pub fn read<T>(
    name: &str,
    group: &BoundParams,
    from: impl Fn(&BoundParams) -> Result<T, WrongForm>,
) -> Result<T, BuildError> {
    from(group).map_err(|_| WrongForm { param: name.to_string() }.into())
}

/// Mass, damping and stiffness along one axis, in SI units of a position or of an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// kg or kg m^2.
    pub mass: f64,
    /// N s/m or N m s.
    pub damping: f64,
    /// N/m or N m.
    pub stiffness: f64,
}

/// Inputs of an axis at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Velocity of the body at the last tick, m/s or rad/s.
    pub before: f64,
    /// Velocity of the target.
    pub velocity: f64,
    /// Change of the target's velocity since the last tick, `T a_d`.
    pub change: f64,
    /// Target minus value, m or rad.
    pub error: f64,
    /// External force or moment, N or N m.
    pub force: f64,
}

impl Axis {
    /// Velocity of this tick, m/s or rad/s; `period` in s.
    pub fn velocity(&self, period: f64, d: &Drive) -> f64 {
        let force = self.damping * d.velocity + self.stiffness * d.error + d.force;
        (self.mass * (d.before + d.change) + period * force) / (self.mass + period * self.damping)
    }

    /// Smallest stiffness with which the body does not come to rest at this period, N/m or N m.
    pub fn stiffness_bound(&self, period: f64) -> f64 {
        (4.0 * self.mass / period + 2.0 * self.damping) / period
    }

    /// Returns true if the body comes to rest. False if a number is NaN.
    pub fn comes_to_rest(&self, period: f64) -> bool {
        self.mass > 0.0 && self.damping > 0.0 && self.stiffness >= 0.0 && self.stiffness < self.stiffness_bound(period)
    }
}

/// Error and motion of a target, position and orientation; all zero for none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Errors, in m and in rad.
    pub error: [Vector3<f64>; 2],
    /// Velocities, in m/s and rad/s.
    pub velocity: [Vector3<f64>; 2],
    /// Their changes since the last tick.
    pub change: [Vector3<f64>; 2],
}

/// Parameters of the body's response to a wrench.
pub struct Impedance {
    /// Mass.
    pub mass: Mass,
    /// Damping.
    pub damping: Damping,
    /// Stiffness; `None` for a body that no target attracts.
    pub stiffness: Option<Stiffness>,
}

/// Frame that yields to a wrench.
pub struct Body {
    link: LinkId,
    period: f64,
    mass: [Input<3>; 2],
    damping: [Input<3>; 2],
    stiffness: Option<[Input<3>; 2]>,
    wrench: [Term; 2],
    /// True if the next update asks for the velocity that is taken over, without the acceleration of a period.
    handing_over: bool,
}

impl Body {
    /// Creates the body from its parameters.
    ///
    /// # Errors
    /// A stiffness is larger than the period allows, or the wrench is not a pair of vectors.
    pub fn new(link: LinkId, ctx: &Context, impedance: Impedance, wrench: Wrench) -> Result<Self, BuildError> {
        if wrench.force.len() != 3 || wrench.moment.len() != 3 {
            return Err(BuildError::new("wrench", "force and moment are vectors"));
        }
        let period = ctx.period;
        let Impedance { mass, damping, stiffness } = impedance;
        let body = Body {
            link,
            period,
            mass: [mass.linear, mass.angular],
            damping: [damping.linear, damping.angular],
            stiffness: stiffness.map(|k| [k.linear, k.angular]),
            wrench: [wrench.force, wrench.moment].map(|w| Term::new(&w, ctx.model)),
            handing_over: false,
        };
        for (part, (name, dimension)) in PARTS.into_iter().enumerate() {
            for (axis, letter) in body.axes(part, ctx.values).iter().zip(["x", "y", "z"]) {
                let bound = axis.stiffness_bound(period);
                // The ranges of the parameters ensure the signs, and each tick checks values that move.
                if axis.mass > 0.0 && axis.damping > 0.0 && axis.stiffness >= bound {
                    let k = axis.stiffness;
                    let text = format!(
                        "a stiffness of {k} {dimension} ({name}, {letter}) swings up: a control period of {period} s is too \
                         long for it"
                    );
                    let bound: f64 = format!("{bound:.3e}").parse().unwrap_or(bound);
                    return Err(BuildError::new("stiffness", text).help(format!(
                        "with this mass and damping stay well below {bound} {dimension}, where k T^2 = 4 m + 2 d T; or \
                         raise the mass, the damping or the rate"
                    )));
                }
            }
        }
        Ok(body)
    }

    /// The frame.
    pub fn link(&self) -> LinkId {
        self.link
    }

    /// Resets the memory at the entry of the stack.
    pub fn enter(&mut self) {
        self.wrench.iter_mut().for_each(Term::forget);
        self.handing_over = false;
    }

    /// Makes the next update ask for the velocity that the frame has.
    pub fn hand_over(&mut self) {
        self.handing_over = true;
    }

    fn axes(&self, part: usize, values: &[f64]) -> [Axis; 3] {
        let (m, d) = (self.mass[part].of(values), self.damping[part].of(values));
        let k = self.stiffness.map_or([0.0; 3], |k| k[part].of(values));
        [0, 1, 2].map(|i| Axis { mass: m[i], damping: d[i], stiffness: k[i] })
    }

    /// Writes six rows, position and orientation. Never allocates.
    ///
    /// # Errors
    /// A number is not finite, or mass, damping and stiffness are not those of a body that comes to rest.
    pub fn update(&mut self, state: &State, rows: &mut Rows, target: &Motion) -> Result<(), TaskFault> {
        let p = state.data.pose(self.link).translation.vector;
        for part in 0..2 {
            self.wrench[part].forward(state).map_err(fault)?;
            let wrench = self.wrench[part].vector(state);
            for (k, (direction, axis)) in axes().iter().zip(self.axes(part, state.values)).enumerate() {
                let i = 3 * part + k;
                let row = rows.row(i);
                if part == 0 {
                    state.data.add_point(state.model, self.link, &p, direction, row);
                } else {
                    state.data.add_angular(state.model, self.link, direction, row);
                }
                let drive = Drive {
                    before: row.iter().zip(state.stack_velocity).map(|(j, v)| j * v).sum(),
                    velocity: target.velocity[part][k],
                    change: target.change[part][k],
                    error: target.error[part][k],
                    force: wrench[k],
                };
                let velocity = if self.handing_over { drive.before } else { axis.velocity(self.period, &drive) };
                if !velocity.is_finite() {
                    return Err(TaskFault::NotFinite { row: i });
                }
                if !axis.comes_to_rest(self.period) {
                    return Err(TaskFault::Gain { row: i });
                }
                rows.equal(i, velocity);
            }
        }
        self.handing_over &= rows.trial;
        Ok(())
    }
}
