//! Definition of a task: given the kinematics at a tick, it writes its rows `lower <= J v <= upper`.

use robot::Model;

use crate::bound::BoundParams;
pub use crate::build::{BuildError, Context, Doubt};
use crate::dimension::Dimension;
use crate::params::ParamInfo;
use crate::protection::{BoundedPosition, Protection};
pub use crate::state::{Rows, State};

/// Kind of the rows of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowKind {
    /// Rows are equalities; the task has errors.
    Equality,
    /// Rows are inequalities; the task has margins.
    Inequality,
}

/// Current value of a task, which `initial(NAME)` captures on entering a stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentValue {
    /// Path of the value in the spec, which is that of the parameter whose target it is; `*` for any arm.
    pub name: &'static str,
    /// Its type.
    pub ty: CurrentValueType,
    /// ExpressedIn in which the value, and the parameter of its name, are expressed.
    pub expressed_in: ExpressedIn,
}

impl CurrentValue {
    /// A value in the world's axes.
    pub const fn in_world(name: &'static str, ty: CurrentValueType) -> CurrentValue {
        CurrentValue { name, ty, expressed_in: ExpressedIn::World }
    }
}

/// ExpressedIn in which a vector is expressed, or into which an orientation turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExpressedIn {
    /// The world's axes. Also used for a number, which has none.
    World,
    /// The axes of an arm's tip if all conditions hold, otherwise the world's.
    Tip {
        /// The parameter that names the arm.
        arm: &'static str,
        /// The conditions.
        when: &'static [Condition],
        /// Description of the axes in words, to follow the name of the value.
        text: &'static str,
    },
    /// The axes of the parameter that the value is the actual value of.
    SameAsParameter,
}

/// Condition on a parameter that is bound before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// The parameter of this name is this constant number.
    Number(&'static str, f64),
    /// The parameter of this name is this word.
    Word(&'static str, &'static str),
}

/// The type of a [`CurrentValue`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CurrentValueType {
    /// One number.
    Scalar(Dimension),
    /// Three numbers.
    Vector(Dimension),
    /// A unit quaternion `w x y z`.
    Rotation,
    /// A position in m and a unit quaternion: `x y z w x y z`.
    Pose,
    /// Type of the parameter of this name, which is an expression.
    Of(&'static str),
}

impl CurrentValueType {
    /// Largest number of numbers that it takes.
    pub fn len(self) -> usize {
        match self {
            CurrentValueType::Scalar(_) => 1,
            CurrentValueType::Vector(_) => 3,
            CurrentValueType::Rotation => 4,
            CurrentValueType::Pose | CurrentValueType::Of(_) => 7,
        }
    }

    /// Always false; clippy requires it beside `len`.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}

/// Output of a running task at each tick, named after the task: `guard.scaling`. Conditions, expectations and logs read
/// it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskOutput {
    /// Its name, without that of the task.
    pub name: &'static str,
    /// Its dimension.
    pub dimension: Dimension,
    /// Its description, in half a sentence.
    pub description: &'static str,
}

/// Builds a task from bound parameters, or returns the parameter that prevents this.
pub type Build = fn(&BoundParams, &Context) -> Result<Box<dyn Task>, BuildError>;

/// A task type: an entry of the catalogue.
pub struct TaskKind {
    /// Its name in a spec.
    pub name: &'static str,
    /// Description in one line.
    pub summary: &'static str,
    /// The page of the catalogue, in Markdown: equations, meaning, source, an example.
    pub docs: &'static str,
    /// A spec fragment that uses it, in the native syntax.
    pub example: &'static str,
    /// Kind of its rows: a target has equalities, a limit inequalities.
    pub row_kind: RowKind,
    /// Parameters in the order of the docs.
    pub params: &'static [ParamInfo],
    /// Parameters that may be given in parentheses, in order.
    pub positional: &'static [&'static str],
    /// Values that `initial(..)` can capture inside its parameters.
    pub current_values: &'static [CurrentValue],
    /// Outputs of the running task, in the order of [`Task::write_outputs`].
    pub outputs: &'static [TaskOutput],
    /// Use of the velocity of people; `None` for a task that protects nobody.
    pub person_velocity: Option<&'static PersonVelocityUse>,
    /// Builds a task.
    pub build: Build,
}

impl TaskKind {
    /// An entry without texts, whose parameters all have names, that captures no values, has no outputs and protects
    /// nobody. The static of a task type fills in the rest.
    pub const fn new(row_kind: RowKind, params: &'static [ParamInfo], build: Build) -> TaskKind {
        TaskKind {
            name: "",
            summary: "",
            docs: "",
            example: "",
            row_kind,
            params,
            positional: &[],
            current_values: &[],
            outputs: &[],
            person_velocity: None,
            build,
        }
    }
}

/// The task uses the velocity of tracked human points, through the time derivative of its parameters.
#[derive(Clone, Copy, Debug)]
pub struct PersonVelocityUse {
    /// Returns true if the task uses the rate of a parameter, given by its name, with these parameters.
    pub uses_rate: fn(&str, &BoundParams) -> bool,
    /// Consequence of a missing rate, in half a sentence.
    pub consequence: &'static str,
    /// Alternative that can be written into the task, if there is one.
    pub alternative: Option<&'static str>,
}

impl PersonVelocityUse {
    /// For a row that keeps a number above a bound: every rate is used.
    pub const LIMIT: PersonVelocityUse = PersonVelocityUse {
        uses_rate: |_, _| true,
        consequence: "without the person's velocity the distance can fall below the limit by up to their speed / `gain`",
        alternative: None,
    };
}

impl std::fmt::Debug for TaskKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "TaskKind({})", self.name)
    }
}

/// Name and unit of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct RowInfo {
    /// Point, joint, pair or axis of the row.
    pub name: String,
    /// Dimension of the row's value and margin.
    pub dimension: Dimension,
}

/// Error that a target task reports at every tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// `position`, `left.orientation`; empty if the task has only one.
    pub name: String,
    /// Its dimension.
    pub dimension: Dimension,
}

/// A task cannot write its rows at this configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TaskFault {
    /// A value is not finite.
    NotFinite {
        /// The row.
        row: usize,
    },
    /// Two shapes overlap so deeply that no separating direction is defined.
    Overlap {
        /// The row.
        row: usize,
    },
    /// A gain that depends on the state is negative, or overshoots within one period.
    Gain {
        /// The row.
        row: usize,
    },
    /// The lower side of a row lies above the upper one.
    Crossed {
        /// The row.
        row: usize,
    },
}

/// Methods of a task that hand over the fields that it remembers to the same task of another stack. What depends on the
/// other tasks of a stack, such as speeds that they allow, is not among them.
macro_rules! takes_over {
    ($($field:ident),+) => {
        fn as_any(&mut self) -> Option<&mut dyn std::any::Any> {
            Some(self)
        }

        fn take_over(&mut self, from: &mut dyn $crate::task::Task) -> bool {
            let Some(from) = from.as_any().and_then(|from| from.downcast_mut::<Self>()) else { return false };
            $(std::mem::swap(&mut self.$field, &mut from.$field);)+
            true
        }
    };
}
pub(crate) use takes_over;

/// A built task. All memory that it needs at a tick was allocated when it was built.
pub trait Task: Send {
    /// Its rows, in order; the number never changes.
    fn rows(&self) -> Vec<RowInfo>;

    /// Its errors, in order; empty for limits.
    fn measures(&self) -> Vec<Measure> {
        Vec::new()
    }

    /// Called once when a stack that contains the task becomes active.
    fn enter(&mut self, _state: &State) {}

    /// Takes over what the same task of another stack remembers, which ran until now: called in place of [`Task::enter`]
    /// where the task goes on. Returns false if it is to be entered instead. Never allocates.
    fn take_over(&mut self, _from: &mut dyn Task) -> bool {
        false
    }

    /// The task itself, for [`Task::take_over`].
    fn as_any(&mut self) -> Option<&mut dyn std::any::Any> {
        None
    }

    /// Called after [`Task::enter`] if the velocity blends from that of another stack. A task that integrates
    /// accelerations asks at its next update for the velocity that it takes over: the offset of the blend is measured
    /// at that tick, and must not contain the acceleration of a period.
    fn hand_over(&mut self) {}

    /// Called before [`Task::update`]: sets whether joints that the stack locks still come to rest, see
    /// [`Context::entry_speed`].
    fn set_locked_joints_moving(&mut self, _moving: bool) {}

    /// Returns true if the task uses values other than its parameters that it captured when its stack was entered.
    fn remembers_entry(&self) -> bool {
        false
    }

    /// Returns true if the rows depend on the motion of the task's target at the previous tick, beside its present
    /// parameters and rates.
    fn remembers_target(&self) -> bool {
        false
    }

    /// Writes the rows of this tick. Never allocates.
    ///
    /// # Errors
    /// The rows are not defined here; the controller treats this as a fault.
    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault>;

    /// Computes errors or margins that depend on the chosen velocity. Never allocates.
    fn observe(&self, _state: &State, _v: &[f64], _margins: &mut [f64], _measures: &mut [f64]) {}

    /// Writes the numbers of [`TaskKind::outputs`] in their units, for the velocity that was chosen; a number that is not
    /// finite is absent. Never allocates.
    fn write_outputs(&self, _state: &State, _v: &[f64], _out: &mut [f64]) {}

    /// Sets the velocity that the next [`Task::update`] asks for, `nv` numbers, for a task whose rows are decided
    /// elsewhere. Never allocates.
    fn set_decided_velocity(&mut self, _velocity: &[f64]) {}

    /// Writes the value that `initial(name)` captures; false for an unknown name.
    fn current_value(&self, _name: &str, _state: &State, _out: &mut [f64]) -> bool {
        false
    }

    /// Weights of the squared slacks of its rows, which multiply that of the task in its level; empty if all are 1.
    fn row_weights(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Gains of its rows in 1/s; empty without gains. The compiler checks them against the control period.
    fn gains(&self, _values: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    /// For limits whose `h` is curved: largest depth below zero that a row may reach between two ticks, in the row's
    /// unit, if nothing is added (mathematics, sampled time). Empty if this cannot happen.
    fn sampled_loss(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Part of [`Task::sampled_loss`] that the rows already keep in reserve.
    fn sampled_margin(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Number of things that its rows keep a margin of. More than its rows if each row is at each tick about another one
    /// of them; see [`Task::subject`].
    fn subjects(&self) -> usize {
        self.rows().len()
    }

    /// Thing that a row was about at the last tick, below [`Task::subjects`].
    fn subject(&self, row: usize) -> usize {
        row
    }

    /// Indices in the table of values on which the margin of a subject depends; `None` for all its parameters.
    fn margin_inputs(&self, _subject: usize) -> Option<Vec<usize>> {
        None
    }

    /// True for a limit whose margins after each tick are looked at if it is on a hard level: see [`Task::margin_after`].
    fn looks_ahead(&self) -> bool {
        false
    }

    /// For a limit that looks ahead: largest distance in m of a part that it keeps from something to a joint that moves
    /// the part, or what it is kept from. `chain` bounds the distance of all links from the root, in m.
    fn reach(&self, chain: f64) -> f64 {
        chain
    }

    /// For a limit that looks ahead: margin `h` of a row after a period (s), in the row's unit. `next` is the state there,
    /// with the parameters of this tick and their rates. Never allocates.
    fn margin_after(&self, _next: &State, _row: usize, _period: f64) -> f64 {
        f64::INFINITY
    }

    /// Looks for what the task takes for granted and what is not so at a configuration, such as feet that stand level. The
    /// compiler asks at home.
    fn doubt(&mut self, _state: &State) -> Option<Doubt> {
        None
    }

    /// For a task whose row `i` is always the velocity of a single degree of freedom: the degrees of freedom. The owner
    /// of the rows writes their coefficients once, all of them 1, and `update` does not write them.
    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        None
    }

    /// For limits: bounds of the gradient of each `h`, as one number for each degree of freedom, in the row's unit
    /// per rad or m, for all joint positions inside their limits. Empty if no bound is known.
    fn gradient_bounds(&self, _model: &Model) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Largest speeds that the task allows, as `(degree of freedom, rad/s or m/s)`.
    fn speed_limits(&self, _values: &[f64]) -> Vec<(usize, f64)> {
        Vec::new()
    }

    /// Joints whose positions the task bounds.
    fn bounded_positions(&self) -> Vec<BoundedPosition> {
        Vec::new()
    }

    /// Links that the task keeps from something.
    fn protections(&self) -> Vec<Protection> {
        Vec::new()
    }

    /// True for a task that may give way on every level, so that it protects as a soft level does.
    fn gives_way(&self) -> bool {
        false
    }

    /// Largest accelerations that the task allows, as `(degree of freedom, rad/s² or m/s²)`.
    fn acceleration_limits(&self) -> Vec<(usize, f64)> {
        Vec::new()
    }
}
