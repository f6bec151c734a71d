//! Mistakes in the problem of a planner, found before planning: the rejected declaration, the reason and, for a
//! contradiction, the other declaration.

use serde::{Deserialize, Serialize};

use crate::numbers::MAX_NUMBER;

/// A declaration of the problem: an entry `I`, or one key `K` of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Declaration<I, K> {
    /// The entry.
    pub item: I,
    /// The key of the entry; `None` for the whole entry.
    pub key: Option<K>,
}

/// Returns the declaration of a key of an entry.
pub(crate) fn of<I, K>(item: I, key: K) -> Declaration<I, K> {
    Declaration { item, key: Some(key) }
}

/// Returns the declaration of a whole entry.
pub(crate) fn entry<I, K>(item: I) -> Declaration<I, K> {
    Declaration { item, key: None }
}

/// A mistake in a problem, with a reason `R`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mistake<I, K, R> {
    /// The rejected declaration.
    pub at: Declaration<I, K>,
    /// The declaration that it contradicts.
    pub against: Option<Declaration<I, K>>,
    /// The reason.
    pub reason: R,
}

/// The reasons of every kind for rejecting a number.
pub(crate) trait NumberReason {
    /// It is no finite number of at most [`MAX_NUMBER`] in magnitude.
    fn too_large(value: f64) -> Self;

    /// It is below the least value.
    fn too_small(value: f64, least: f64) -> Self;
}

/// Collects the mistakes of a problem.
pub(crate) struct Checker<'a, P, I, K, R> {
    pub problem: &'a P,
    pub mistakes: Vec<Mistake<I, K, R>>,
}

impl<'a, P, I: Copy, K: Copy, R: NumberReason> Checker<'a, P, I, K, R> {
    pub fn new(problem: &'a P) -> Self {
        Checker { problem, mistakes: Vec::new() }
    }

    /// Records a mistake that contradicts no other declaration.
    pub fn refuse(&mut self, at: Declaration<I, K>, reason: R) {
        self.mistakes.push(Mistake { at, against: None, reason });
    }

    /// Returns true if a value is finite and at most [`MAX_NUMBER`] in magnitude; otherwise records a mistake.
    pub fn usual(&mut self, at: Declaration<I, K>, value: f64) -> bool {
        let good = value.is_finite() && value.abs() <= MAX_NUMBER;
        if !good {
            self.refuse(at, R::too_large(value));
        }
        good
    }

    /// Records a mistake if a value is below the least one, or is not usual.
    pub fn at_least(&mut self, at: Declaration<I, K>, value: f64, least: f64) {
        if self.usual(at, value) && value < least {
            self.refuse(at, R::too_small(value, least));
        }
    }

    /// Records a mistake if a value is negative, or is not usual.
    pub fn not_negative(&mut self, at: Declaration<I, K>, value: f64) {
        self.at_least(at, value, 0.0);
    }
}
