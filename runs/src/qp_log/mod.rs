//! Files of ticks: hierarchical problems as JSON, one object per line, to be checked and timed without a robot.
//!
//! | key | is |
//! |---|---|
//! | `id` | name of the tick |
//! | `kind` | optional; ticks of one kind are summarised together |
//! | `n` | number of variables |
//! | `levels` | from the highest priority; each `{"A", "lo", "up"}` and optionally `weight`, `hard`, `damping` |
//! | `reference` | optional; the preferred point in directions that no level determines, zero by default |
//! | `x`, `viol` | optional; the optimum, and per level the norm of the distances of its rows from `[lo, up]` |
//!
//! `A` is a list of rows, or `{"identity": k}` for `k` identities stacked vertically; `null` in `lo` or `up` means no
//! bound on that side. Unknown keys of a tick are ignored, unknown keys of a level are rejected, because they may be
//! meant to change the problem. The rows are defined as in [`solver::Problem`].
//!
//! A file may be larger than memory: it is read line by line ([`lines`]), and the size of a line is limited before
//! memory for it is allocated.

mod check;
mod form;
mod lines;
mod write;

use solver::Problem;

pub use lines::{Line, Lines};
pub use write::ProblemRecorder;

/// Maximum length of a line (bytes).
pub const MAX_LINE: usize = 16 << 20;
/// Maximum number of variables.
pub const MAX_VARIABLES: usize = 300;
/// Maximum number of levels.
pub const MAX_LEVELS: usize = 100;
/// Maximum number of rows in all levels.
pub const MAX_ROWS: usize = 3000;
/// Maximum length of `id` or `kind` (characters).
pub const MAX_NAME: usize = 100;
/// Maximum length of the reason in a refusal (characters), since it may quote the input.
const MAX_REASON: usize = 200;

/// A problem of a file, with its known solution if the file has one.
#[derive(Clone, Debug)]
pub struct LoggedProblem {
    /// Name.
    pub id: String,
    /// Name of the kind in summaries; empty if the file sets none.
    pub kind: String,
    /// Checked problem, which every solver accepts.
    pub problem: Problem,
    /// Optimum, `n` numbers.
    pub x: Option<Vec<f64>>,
    /// For each level, the norm of the distances of its rows from their intervals at the optimum.
    pub viol: Option<Vec<f64>>,
}

/// Reason why a line is not a tick.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Description of the mistake.
    pub reason: String,
    /// Help.
    pub help: String,
}

impl Refusal {
    /// Creates a refusal that fits on a line: shortens the reason, and replaces control characters in quoted input.
    pub fn new(reason: impl AsRef<str>, help: impl Into<String>) -> Refusal {
        let clean = |c: char| if c.is_control() { '?' } else { c };
        let mut short: String = reason.as_ref().chars().map(clean).take(MAX_REASON).collect();
        if reason.as_ref().chars().nth(MAX_REASON).is_some() {
            short.push_str(" ..");
        }
        Refusal { reason: short, help: help.into() }
    }
}

/// Parses a line.
///
/// # Errors
/// The line is not JSON, not a tick, or not a problem that solvers accept.
pub fn read(line: &[u8]) -> Result<LoggedProblem, Refusal> {
    check::tick(form::parse(line)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(line: &str) -> Result<LoggedProblem, Refusal> {
        read(line.as_bytes())
    }

    #[test]
    fn every_key_reaches_the_problem() {
        let t = tick(
            r#"{"id":"a","kind":"k","n":2,"reference":[1,-1],"x":[0,0.5],"viol":[0,1],"more":{"x":[[]]},"levels":[
               {"A":{"identity":2},"lo":[null,-1,0,0.5],"up":[1,null,0,0.5],"hard":true},
               {"A":[[1,2]],"lo":[3],"up":[4],"weight":[7],"damping":0.25}]}"#,
        )
        .expect("a tick");
        assert_eq!((t.id.as_str(), t.kind.as_str(), t.problem.n), ("a", "k", 2));
        let [first, second] = &t.problem.levels[..] else { panic!("two levels") };
        assert_eq!((first.rows(), first.hard, first.damping), (4, true, 0.0));
        assert_eq!([first.row(0), first.row(1), first.row(2), first.row(3)], [[1., 0.], [0., 1.], [1., 0.], [0., 1.]]);
        assert_eq!(first.lower, [f64::NEG_INFINITY, -1.0, 0.0, 0.5]);
        assert_eq!(first.upper, [1.0, f64::INFINITY, 0.0, 0.5]);
        assert_eq!((second.row(0), second.lower[0], second.upper[0]), (&[1.0, 2.0][..], 3.0, 4.0));
        assert_eq!((second.weight[0], second.hard, second.damping), (7.0, false, 0.25));
        assert_eq!(t.problem.reference, [1.0, -1.0]);
        assert_eq!((t.x.as_deref(), t.viol.as_deref()), (Some(&[0.0, 0.5][..]), Some(&[0.0, 1.0][..])));
    }

    #[test]
    fn what_is_quoted_is_short_and_harmless() {
        let long = format!(r#"{{"id":"a","n":"{}\u001b[2J","levels":[]}}"#, "y".repeat(5000));
        let refusal = tick(&long).expect_err("`n` is text");
        assert!(refusal.reason.chars().count() <= MAX_REASON + 3, "{}", refusal.reason.len());
        let key = r#"{"id":"a","n":1,"levels":[{"A":[],"lo":[],"up":[],"\u001b[2J":1}]}"#;
        let refusal = tick(key).expect_err("an unknown key");
        assert!(!refusal.reason.contains('\u{1b}'), "{}", refusal.reason);
    }
}
