//! Blocks and keys that several kinds share.

use blocks::{Bound, FromBound, Help, Key, Located, Named, Snippet, ValueType, block};
use quantities::dimension::{DAMPING, Dimension, FORCE, LENGTH, NONE};
use quantities::{Quantity, usual};

use crate::numbers::{Energy, MAX_BATCH, Range};

use super::{DeclaredMission, Remark, Remarks};

const POWER: Dimension = Dimension { m: 2, kg: 1, s: -3, rad: 0 };

/// A time of zero or more.
pub const A_TIME: ValueType = ValueType::Number(usual::WORK_TIME);
/// A length of zero or more.
pub const A_LENGTH: ValueType = ValueType::Number(Quantity::at_least(LENGTH, 0.0));
/// A number of zero or more.
pub const A_WEIGHT: ValueType = ValueType::Number(Quantity::at_least(NONE, 0.0));
/// A number from 0 to 1.
pub const A_SHARE: ValueType = ValueType::Number(Quantity::between(NONE, 0.0, 1.0));
/// A factor above zero.
pub const A_FACTOR: ValueType = ValueType::Number(Quantity::above(NONE, 0.0));

/// The text that people read in place of a name.
pub const LABEL: Key = Key::optional(
    "label",
    ValueType::Text,
    "Text that people read in place of the name, in any script: `label \"Łukasz\"`; default: the name.",
)
.example("\"Łukasz\"");

block! {
    /// Coefficients of the power of a robot that moves.
    pub struct EnergyBlock = ENERGY, "the energy of a robot" {
        /// Constant power.
        standby: f64 = or(ValueType::Number(Quantity::at_least(POWER, 0.0).usually(1e-4, 1e5)), "1 W");
        /// Coefficient of the speed; default: 20 N times the factor.
        friction: Option<f64> = optional(ValueType::Number(Quantity::at_least(FORCE, 0.0).usually(1e-3, 1e5)));
        /// Coefficient of the squared speed; default: 400 N s/m times the factor.
        drag: Option<f64> = optional(ValueType::Number(Quantity::at_least(DAMPING, 0.0).usually(1e-3, 1e5)));
    }
}

impl EnergyBlock {
    /// Returns the coefficients for a robot of this physical factor.
    pub fn of_factor(&self, factor: f64) -> Energy {
        let usual = Energy::of_factor(factor);
        Energy {
            standby: self.standby,
            friction: self.friction.unwrap_or(usual.friction),
            drag: self.drag.unwrap_or(usual.drag),
        }
    }
}

block! {
    /// The controller that a member runs.
    pub struct RunsBlock = RUNS, "what a worker runs" {
        /// The spec of its controller, `"picker.hq"`, which has a machine.
        spec: Located<String> = required(ValueType::Spec, "\"picker.hq\"");
        /// A signal of that spec, a flag: true while an operation goes on, false between two operations.
        go: Located<String> = required(ValueType::Name(Named::SignalThere("flag")), "box_in_place");
        /// A state of its machine; the current operation ends when this state is entered.
        done: Located<String> = required(ValueType::Name(Named::StateThere), "waiting");
        /// A scenario of that spec that defines the environment of the robot: its start, its simulator, people,
        /// signals other than `go`, outcomes of actions. Its expectations and its duration are ignored. Default: no
        /// events, and every action ends immediately.
        scenario: Option<Located<String>> = optional(ValueType::Text);
    }
}

block! {
    /// A place with a name: members of the role `place` are positions that others may name.
    pub struct PlaceBlock = PLACE_BLOCK, "a place" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Position of the place.
        at: [f64; 3] = required(ValueType::Vector(Quantity::any(LENGTH)));
    }
}

/// Adds an error for a batch of too many operations.
pub(crate) fn check_batch(declared: &DeclaredMission, batch: Option<usize>, remarks: &mut Remarks) {
    let Some(size) = batch.filter(|size| *size > MAX_BATCH) else { return };
    let Some(at) = declared.settings.origin("batch") else { return };
    let text = format!("a batch has at most {MAX_BATCH} operations, and this is {size}");
    let help = Help::with("small batches are best: remove it, or write {}", [Snippet::entry("batch", "4")]);
    remarks.push(Remark::error("HQ0904", at, text).help(help));
}

impl FromBound for Range {
    fn from_bound(bound: &Bound) -> Option<Range> {
        match bound {
            Bound::Range([low, high]) => Some(Range::new(*low, *high)),
            _ => None,
        }
    }

    fn stand_in(_: &Key) -> Range {
        Range::point(1.0)
    }
}
