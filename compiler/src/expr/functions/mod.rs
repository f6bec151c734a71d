//! The functions of the language, an entry each: name, form, arguments, result, and the operations that compute it.
//! Calls, messages, the editor and the page of functions derive from the entries.

mod numbers;
mod orientations;
mod vectors;

use std::ops::RangeInclusive;

use dsl::Span;

use super::arguments::CallError;
use super::{Graph, Typed};
pub(super) use orientations::slerp;

/// A function of the language.
#[derive(Debug)]
pub struct Function {
    /// Name.
    pub name: &'static str,
    /// Syntax of a call.
    pub form: &'static str,
    /// Arguments, in Markdown.
    pub takes: &'static str,
    /// Result, in Markdown.
    pub gives: &'static str,
    /// Kind of values that it is of.
    pub family: Family,
    /// Number of arguments.
    pub arity: RangeInclusive<usize>,
    /// Arguments that are angles, by their indices.
    angles: &'static [usize],
    /// Arguments that have the same dimension.
    same: Same,
    /// Computes the value; the number of arguments is within the arity.
    pub(super) apply: Apply,
}

/// Adds the operations of a call to the graph, and returns its value.
type Apply = fn(&mut Graph, &[Typed], Span) -> Result<Typed, CallError>;

/// Kind of values that a function is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Numbers.
    Numbers,
    /// Vectors.
    Vectors,
    /// Orientations and poses.
    Orientations,
}

/// Arguments of a function that have the same dimension.
#[derive(Clone, Copy, Debug)]
enum Same {
    /// None of them.
    None,
    /// All of them.
    All,
    /// The first two.
    FirstTwo,
    /// All after the first.
    AfterFirst,
}

impl Function {
    /// A function of one argument without texts. The static of a function fills in the rest.
    const fn of(family: Family) -> Function {
        Function {
            name: "",
            form: "",
            takes: "",
            gives: "",
            family,
            arity: 1..=1,
            angles: &[],
            same: Same::None,
            apply: |_, _, _| Err(CallError::Undefined("")),
        }
    }

    /// True if argument `index` is an angle.
    pub(super) fn is_angle(&self, index: usize) -> bool {
        self.angles.contains(&index)
    }

    /// The arguments that must have the same dimension.
    pub(super) fn same_dimension<'t>(&self, args: &'t [Typed]) -> &'t [Typed] {
        match self.same {
            Same::None => &[],
            Same::All => args,
            Same::FirstTwo => &args[..args.len().min(2)],
            Same::AfterFirst => &args[args.len().min(1)..],
        }
    }
}

/// All functions.
pub static FUNCTIONS: &[&Function] = &[
    &numbers::SIN,
    &numbers::COS,
    &numbers::TAN,
    &numbers::EXP,
    &numbers::LOG,
    &numbers::SQRT,
    &numbers::ABS,
    &numbers::MIN,
    &numbers::MAX,
    &numbers::CLAMP,
    &numbers::LERP,
    &numbers::SMOOTHSTEP,
    &numbers::ASIN,
    &numbers::ACOS,
    &numbers::ATAN2,
    &numbers::IF,
    &vectors::NORM,
    &vectors::DOT,
    &vectors::CROSS,
    &vectors::ANGLE_BETWEEN,
    &vectors::NORMALIZE,
    &orientations::RPY,
    &orientations::AXIS_ANGLE,
    &orientations::QUATERNION,
    &orientations::INVERSE,
    &orientations::POSE,
    &orientations::SLERP,
];

/// The function of this name.
pub fn function(name: &str) -> Option<&'static Function> {
    FUNCTIONS.iter().find(|f| f.name == name).copied()
}

/// Table of all functions, in Markdown.
pub fn functions_markdown() -> String {
    let row = |f: &&Function| format!("| `{}` | {} | {} |\n", f.form, f.takes, f.gives);
    let rows: String = FUNCTIONS.iter().map(row).collect();
    format!("| function | arguments | result |\n|---|---|---|\n{rows}")
}
