//! Checks of what is measured: readings without an end, filters, wrenches of another place, sensors that nothing watches.

mod absent;
mod ageless;
mod filters;
mod rising;
mod tare;
mod thresholds;
mod timeouts;
mod wrench_place;

use dsl::Diagnostic;

use super::Checked;

/// Runs all checks of sensors.
pub(super) fn checks(c: &Checked, out: &mut Vec<Diagnostic>) {
    ageless::check(c, out);
    filters::check(c, out);
    wrench_place::check(c, out);
    timeouts::check(c, out);
    absent::check(c, out);
    thresholds::check(c, out);
    tare::check(c, out);
}
