//! Checks of sizes that are legal, and that the controller or the robot cannot use.

mod oscillation;
mod path_speed;
mod weak_gains;

use dsl::Diagnostic;

use super::Checked;

/// Runs all checks of sizes.
pub(super) fn checks(c: &Checked, out: &mut Vec<Diagnostic>) {
    oscillation::check(c, out);
    path_speed::check(c, out);
    weak_gains::targets(c, out);
    weak_gains::limits(c, out);
}
