//! Layers as JSON: the format for language models and for people, and of exports.
//!
//! ```json
//! { "layers": [ { "name": "base", "tasks": [
//!     { "name": "left_foot", "action": "pick_and_place", "features": ["cube", "red"],
//!       "motion": [[0, 0, 0.2]], "to": [0.1, 0, 0] } ] } ] }
//! ```
//!
//! `to` is a position in metres or the name of a place, `motion` a list of via positions. Instead of `layers` the text
//! may have `tasks` with `after`, the names of earlier tasks: each task is put into the first layer after all of these.
//! Every object may have a `description`, which is ignored. With [`Mode::Allocated`] each task also has an `agent` and,
//! if it needs one, an `object`; with [`Mode::Scheduled`] a `start` and an `end` in seconds as well: the baselines of
//! thesis 6.4.4.
//!
//! [`import`] reports up to a hundred mistakes, each with its position and a fix.

mod export;
mod import;
mod nearest;
mod order;
mod scheduled_plan;
mod task;
mod text;

use serde::{Deserialize, Serialize};

pub use self::export::{export, export_plan};
pub use self::import::{Imported, import};

/// Decisions that the text contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Tasks and their order; an agent or an object only if it is required.
    Context,
    /// Also the agent and the object of each task.
    Allocated,
    /// Also the start and end of each task.
    Scheduled,
}

/// A position in the text. Lines and columns count from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Position {
    /// The line.
    pub line: usize,
    /// The column.
    pub column: usize,
}

/// Kind of a mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// The text is not valid JSON.
    Syntax,
    /// The text ends too early.
    Truncated,
    /// The text is too long, too deeply nested, or has too many values.
    TooMuch,
    /// A value of another type is expected.
    Type,
    /// A key is missing.
    Missing,
    /// A key has no meaning here.
    UnknownKey,
    /// A name or key is duplicated.
    Twice,
    /// No agent performs this action.
    UnknownAction,
    /// No object has this feature.
    UnknownFeature,
    /// No object has all of these features.
    NoObject,
    /// There is no agent, object, task or place of this name.
    UnknownName,
    /// The precedences of tasks form a cycle.
    Cycle,
    /// The tasks are readable but cannot be planned.
    Impossible,
}

/// A mistake in the text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("line {}, column {}{}{path}: {what}; {fix}", at.line, at.column, if path.is_empty() { "" } else { ", " })]
pub struct Fault {
    /// Position of the mistake.
    pub at: Position,
    /// Path to the mistake in the text, as `layers[0].tasks[2].action`; empty for the text as a whole.
    pub path: String,
    /// Kind of the mistake.
    pub kind: FaultKind,
    /// Description of the mistake.
    pub what: String,
    /// Description of the fix.
    pub fix: String,
}
