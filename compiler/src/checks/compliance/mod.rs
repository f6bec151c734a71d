//! Checks of frames that yield to a wrench like a body with mass, damping and stiffness.

mod base;
mod body;

use dsl::Diagnostic;

use super::Checked;

/// Runs all checks of such frames.
pub(super) fn checks(c: &Checked, out: &mut Vec<Diagnostic>) {
    body::check(c, out);
    base::check(c, out);
}
