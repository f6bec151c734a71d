//! Checks of what is assumed of people, and of what protects them.

mod held;
mod unprotected;
mod walking;

use dsl::Diagnostic;

use super::Checked;
pub(super) use unprotected::moves;

/// Walking speed of ISO 13855 (m/s), at which a person may approach.
pub(super) const WALKING: f64 = 1.6;

/// Runs all checks of people.
pub(super) fn checks(c: &Checked, out: &mut Vec<Diagnostic>) {
    if c.program.interface.humans.is_empty() {
        return;
    }
    walking::check(c, out);
    held::check(c, out);
    unprotected::check(c, out);
}
