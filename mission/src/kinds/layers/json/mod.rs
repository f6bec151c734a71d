//! Layers as JSON: the form that a language model is asked for, that a person may write, and in which they are given out.
//!
//! ```json
//! { "layers": [ { "name": "base", "tasks": [
//!     { "name": "left_foot", "action": "pick_and_place", "features": ["cube", "red"],
//!       "motion": [[0, 0, 0.2]], "to": [0.1, 0, 0] } ] } ] }
//! ```
//!
//! `to` is a position in metres or the name of a place, `motion` positions to pass on the way. Instead of `layers` there may
//! be `tasks` with `after`, the names of tasks that come before: each comes into the first layer after all of these. A
//! `description` may stand in every object and is not read. With [`Mode::Allocated`] each task also has an `agent` and, if
//! it needs one, an `object`; with [`Mode::Scheduled`] a `start` and an `end` in seconds as well: the baselines of thesis
//! 6.4.4.
//!
//! [`import`] tells every mistake that it finds, a hundred at most, where it is and what would be right.

mod export;
mod given;
mod import;
mod nearest;
mod order;
mod task;
mod text;

use serde::{Deserialize, Serialize};

pub use self::export::{export, export_plan};
pub use self::import::{Imported, import};

/// How much the text decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Tasks and their order; an agent or an object only where it must be that one.
    Context,
    /// Also the agent and the object of each task.
    Allocated,
    /// Also when each task begins and ends.
    Scheduled,
}

/// A place in the text. Lines and columns count from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Position {
    /// The line.
    pub line: usize,
    /// The column.
    pub column: usize,
}

/// What kind of mistake it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// The text is no JSON.
    Syntax,
    /// The text ends too early.
    Truncated,
    /// Too long, too deep, too many.
    TooMuch,
    /// A value of another type is expected.
    Type,
    /// A key is missing.
    Missing,
    /// A key has no meaning here.
    UnknownKey,
    /// A name or key stands twice.
    Twice,
    /// No agent performs this action.
    UnknownAction,
    /// No object has this feature.
    UnknownFeature,
    /// No object has all of these features.
    NoObject,
    /// There is no agent, object, task or place of this name.
    UnknownName,
    /// Tasks come after each other in a circle.
    Cycle,
    /// The tasks can be read and cannot be planned.
    Impossible,
}

/// A mistake in the text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("line {}, column {}{}{path}: {what}; {fix}", at.line, at.column, if path.is_empty() { "" } else { ", " })]
pub struct Fault {
    /// Where it is.
    pub at: Position,
    /// The way to it through the text, as `layers[0].tasks[2].action`; empty for the text as a whole.
    pub path: String,
    /// What kind it is.
    pub kind: FaultKind,
    /// What is wrong.
    pub what: String,
    /// What would be right.
    pub fix: String,
}
