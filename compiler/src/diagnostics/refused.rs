//! Error of functions that find at most one mistake and leave its report to the caller.

use dsl::Diagnostic;

/// Diagnostic of a mistake; `None` if it was reported elsewhere.
pub(crate) type Refused = Option<Box<Diagnostic>>;

/// Returns a mistake that is not reported yet.
pub(crate) fn refuse<T>(d: Diagnostic) -> Result<T, Refused> {
    Err(Some(Box::new(d)))
}
