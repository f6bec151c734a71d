//! Files of ticks: hierarchical problems as JSON, one object a line, to be checked and timed outside of any robot.
//!
//! | key | is |
//! |---|---|
//! | `id` | name of the tick |
//! | `kind` | optional; ticks of one kind are summed up together |
//! | `n` | number of variables |
//! | `levels` | from the highest priority; each `{"A", "lo", "up"}` and optionally `weight`, `hard`, `damping` |
//! | `reference` | optional; the point to stay near to where no level decides, zero where left out |
//! | `x`, `viol` | optional; the optimum, and per level the norm of the distances of its rows from `[lo, up]` |
//!
//! `A` is a list of rows, or `{"identity": k}` for `k` identities one below the other; `null` in `lo` or `up` is no bound
//! on that side. Other keys of a tick are left alone, other keys of a level are refused: they would have changed the
//! problem. The meaning of the rows is [`solver::Problem`]'s.
//!
//! A file may be larger than memory: it is read line by line ([`lines`]), and what a line may cost is bounded before
//! anything of that size is made.

mod check;
mod form;
mod lines;
mod write;

use solver::Problem;

pub use lines::{Line, Lines};
pub use write::ProblemRecorder;

/// Longest line, in bytes.
pub const MAX_LINE: usize = 16 << 20;
/// Most variables.
pub const MAX_VARIABLES: usize = 300;
/// Most levels.
pub const MAX_LEVELS: usize = 100;
/// Most rows of all levels together.
pub const MAX_ROWS: usize = 3000;
/// Longest `id` or `kind`, in characters.
pub const MAX_NAME: usize = 100;
/// Longest reason of a refusal, in characters: it may quote what was written.
const MAX_REASON: usize = 200;

/// A problem of a file, with what the file knows of its answer.
#[derive(Clone, Debug)]
pub struct Tick {
    /// Its name.
    pub id: String,
    /// What it is counted under; empty where the file does not say.
    pub kind: String,
    /// The problem, checked: a solver takes it.
    pub problem: Problem,
    /// The optimum, `n` numbers.
    pub x: Option<Vec<f64>>,
    /// Per level the norm of the distances of its rows from their intervals at the optimum.
    pub viol: Option<Vec<f64>>,
}

/// Why a line is not a tick.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// What is wrong with it.
    pub reason: String,
    /// What to do.
    pub help: String,
}

impl Refusal {
    /// A refusal that fits on a line: what is quoted of the file is shortened, and cannot steer a terminal.
    pub fn new(reason: impl AsRef<str>, help: impl Into<String>) -> Refusal {
        let clean = |c: char| if c.is_control() { '?' } else { c };
        let mut short: String = reason.as_ref().chars().map(clean).take(MAX_REASON).collect();
        if reason.as_ref().chars().nth(MAX_REASON).is_some() {
            short.push_str(" ..");
        }
        Refusal { reason: short, help: help.into() }
    }
}

/// Reads a line.
///
/// # Errors
/// The line is not JSON, or not a tick, or one that no solver can take.
pub fn read(line: &[u8]) -> Result<Tick, Refusal> {
    check::tick(form::parse(line)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(line: &str) -> Result<Tick, Refusal> {
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
