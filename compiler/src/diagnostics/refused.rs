//! The error of functions that find at most one mistake and leave it to their caller to report it.

use dsl::Diagnostic;

/// The diagnostic of a mistake; none if it was reported elsewhere.
pub(crate) type Refused = Option<Box<Diagnostic>>;

/// A mistake that nobody has reported yet.
pub(crate) fn refuse<T>(d: Diagnostic) -> Result<T, Refused> {
    Err(Some(Box::new(d)))
}
