//! What a task is: "given the kinematics at this tick, write my rows `lower <= J v <= upper`".

use robot::Model;

use crate::bound::BoundParams;
pub use crate::build::{BuildError, Context};
use crate::dimension::Dimension;
use crate::params::ParamInfo;
pub use crate::state::{Rows, State};

/// Whether a task pulls towards a target or keeps out of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nature {
    /// Rows are equalities; the task has errors.
    Target,
    /// Rows are inequalities; the task has margins.
    Limit,
}

/// A value of the task as it is, which `initial(NAME)` captures on entering a stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actual {
    /// The path under which the spec names it, that of the parameter whose target it is; `*` for any arm.
    pub name: &'static str,
    /// Its type.
    pub ty: ActualType,
    /// The axes along which it counts, and the parameter of its name too.
    pub along: Along,
}

/// The axes along which a vector counts, or into which an orientation turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Along {
    /// The world's; a number has none, and this stands in their place.
    World,
    /// Those of an arm's tip where all of these hold, elsewhere the world's.
    Tip {
        /// The parameter that names the arm.
        arm: &'static str,
        /// What must hold.
        when: &'static [Is],
        /// The same in words, behind the name of the value.
        text: &'static str,
    },
    /// Those of the parameter that the value is the actual value of.
    Own,
}

/// What a parameter that is bound before is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Is {
    /// A constant number.
    Number(&'static str, f64),
    /// A word.
    Word(&'static str, &'static str),
}

/// The type of an [`Actual`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActualType {
    /// One number.
    Scalar(Dimension),
    /// Three numbers.
    Vector(Dimension),
    /// A unit quaternion `w x y z`.
    Rotation,
    /// A position in m and a unit quaternion: `x y z w x y z`.
    Pose,
    /// That of the parameter of this name, which is an expression.
    Of(&'static str),
}

impl ActualType {
    /// How many numbers it takes at most.
    pub fn len(self) -> usize {
        match self {
            ActualType::Scalar(_) => 1,
            ActualType::Vector(_) => 3,
            ActualType::Rotation => 4,
            ActualType::Pose | ActualType::Of(_) => 7,
        }
    }

    /// Never true; for clippy's peace of mind.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}

/// A number that a running task tells at each tick, behind its own name and a point: `guard.scaling`. Conditions,
/// expectations and logs read it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// Its name, without that of the task.
    pub name: &'static str,
    /// Its dimension.
    pub dimension: Dimension,
    /// What it is, in half a sentence.
    pub is: &'static str,
}

/// Builds a task from bound parameters, or says which of them makes that impossible.
pub type Build = fn(&BoundParams, &Context) -> Result<Box<dyn Task>, BuildError>;

/// A task type: an entry of the catalogue.
pub struct TaskKind {
    /// Its name in a spec.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// The page of the catalogue, in Markdown: equations, meaning, source, an example.
    pub docs: &'static str,
    /// A spec fragment that uses it, in the native spelling.
    pub example: &'static str,
    /// Target or limit.
    pub nature: Nature,
    /// Parameters in the order of the docs.
    pub params: &'static [ParamInfo],
    /// Parameters that may be given in parentheses, in order.
    pub positional: &'static [&'static str],
    /// What `initial(..)` can capture inside its parameters.
    pub actuals: &'static [Actual],
    /// What the task tells while it runs, in the order of [`Task::told`].
    pub tells: &'static [Told],
    /// How it reckons with people who come; none where it keeps nobody safe.
    pub reckons: Option<&'static Reckons>,
    /// Builds a task.
    pub build: Build,
}

/// That a task reckons with how fast the points of people move: with the rates of its parameters in time.
#[derive(Clone, Copy, Debug)]
pub struct Reckons {
    /// Whether the rate of a parameter, by its name, counts where all parameters are these.
    pub rate: fn(&str, &BoundParams) -> bool,
    /// What becomes of it where a rate is missing, in half a sentence.
    pub lacking: &'static str,
    /// What can be written into the task instead, if there is something.
    pub instead: Option<&'static str>,
}

impl Reckons {
    /// As a row does that keeps a number above a bound: every rate counts.
    pub const LIMIT: Reckons = Reckons {
        rate: |_, _| true,
        lacking: "a row that lacks it lets whoever comes get inside the limit, by their speed over `gain`",
        instead: None,
    };
}

impl std::fmt::Debug for TaskKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "TaskKind({})", self.name)
    }
}

/// What a row is called and measured in.
#[derive(Clone, Debug, PartialEq)]
pub struct RowInfo {
    /// The point, joint, pair or axis that it speaks of.
    pub name: String,
    /// Dimension of the row's value and margin.
    pub dimension: Dimension,
}

/// An error that a target task reports every tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// `position`, `left.orientation`; empty where the task has only one.
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
    /// Two shapes overlap so deeply that no direction leads apart.
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

/// A built task. Everything that it needs at a tick was allocated when it was built.
pub trait Task: Send {
    /// Its rows, in order; the number never changes.
    fn rows(&self) -> Vec<RowInfo>;

    /// Its errors, in order; empty for limits.
    fn measures(&self) -> Vec<Measure> {
        Vec::new()
    }

    /// Called once when a stack that holds the task becomes active.
    fn enter(&mut self, _state: &State) {}

    /// Called after [`Task::enter`] where the velocity blends over from that of another stack. A task that integrates
    /// accelerations asks at its next update for the velocity that it takes over: the offset of the blend is measured at
    /// that tick, and must not contain the acceleration of a period.
    fn hand_over(&mut self) {}

    /// Tells before [`Task::update`] whether joints that the stack locks still come to rest, see [`Context::coasting`].
    fn coast(&mut self, _coasts: bool) {}

    /// Whether the task asks for something that it took from the robot when its stack was entered, beside its parameters.
    fn remembers_entry(&self) -> bool {
        false
    }

    /// Whether the rows depend on how the task's target moved at the tick before, beside its parameters and rates now.
    fn remembers_target(&self) -> bool {
        false
    }

    /// Writes the rows of this tick. Never allocates.
    ///
    /// # Errors
    /// The rows are not defined here; the controller treats this as a fault.
    fn update(&mut self, state: &State, rows: &mut Rows) -> Result<(), TaskFault>;

    /// Errors or margins that exist only once the velocity is known. Never allocates.
    fn observe(&self, _state: &State, _v: &[f64], _margins: &mut [f64], _measures: &mut [f64]) {}

    /// Writes the numbers of [`TaskKind::tells`] in their units, for the velocity that was chosen; one that is not finite
    /// is absent. Never allocates.
    fn told(&self, _state: &State, _v: &[f64], _out: &mut [f64]) {}

    /// For a task whose rows are decided about elsewhere: what the next [`Task::update`] asks for, `nv` numbers. Never
    /// allocates.
    fn decided(&mut self, _velocity: &[f64]) {}

    /// Writes the value that `initial(name)` captures; false for an unknown name.
    fn actual(&self, _name: &str, _state: &State, _out: &mut [f64]) -> bool {
        false
    }

    /// The gains of its rows in 1/s: the compiler checks them against the control period.
    fn gains(&self, values: &[f64]) -> Vec<f64>;

    /// For limits whose `h` is curved: how far a row may fall below zero between two ticks, in the row's unit, if
    /// nothing is added (mathematics, sampled time). Empty where it cannot happen.
    fn sampled_loss(&self) -> Vec<f64> {
        Vec::new()
    }

    /// The share of [`Task::sampled_loss`] that the rows already keep in reserve.
    fn reserve(&self) -> Vec<f64> {
        Vec::new()
    }

    /// For a task whose row `i` is always the velocity of a single degree of freedom: which one. Whoever owns the rows
    /// writes their coefficients once, all of them 1, and `update` leaves them alone.
    fn degrees_of_freedom(&self) -> Option<Vec<usize>> {
        None
    }

    /// For limits: how steep the `h` of each row can be at most, as one number for each degree of freedom, in the row's
    /// unit per rad or m, wherever joints stand inside their limits. Empty where no bound is known.
    fn slopes(&self, _model: &Model) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Speeds that the task allows at most, as `(degree of freedom, rad/s or m/s)`.
    fn speed_limits(&self, _values: &[f64]) -> Vec<(usize, f64)> {
        Vec::new()
    }

    /// Accelerations that the task allows at most, as `(degree of freedom, rad/s² or m/s²)`.
    fn acceleration_limits(&self) -> Vec<(usize, f64)> {
        Vec::new()
    }
}
