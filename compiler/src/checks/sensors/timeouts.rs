//! Warns of scenarios that send readings less often than they are valid: between two of them the value is absent.

use std::collections::BTreeSet;

use dsl::tree::Entry;
use dsl::{Diagnostic, Span};
use runtime::program::Lost;
use stdlib_tasks::dimension::TIME;

use crate::checks::{Checked, readings};
use crate::units::shown;

/// Readings that a scenario sends.
struct Sent {
    /// Index of a signal.
    signal: usize,
    /// Name of the signal or the person.
    name: String,
    /// Time between two readings (s).
    period: f64,
}

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<String> = BTreeSet::new();
    for scenario in &c.program.scenarios {
        let interface = &c.program.interface;
        let signals = scenario.world.signals.iter().filter_map(|s| {
            let name = interface.signals.get(s.signal)?.name.clone();
            Some(Sent { signal: s.signal, name, period: s.period })
        });
        let humans = scenario.world.humans.iter().filter_map(|s| {
            let human = interface.humans.get(s.human)?;
            Some(Sent { signal: *human.points.first()?, name: human.name.clone(), period: s.sending.period })
        });
        for sent in signals.chain(humans) {
            let Some(s) = interface.signals.get(sent.signal) else { continue };
            // A held person stays known between two readings.
            let held = s.motion.is_some_and(|m| matches!(m.lost, Lost::Hold(_)));
            let Some(timeout) = s.timeout.filter(|_| !held) else { continue };
            // A tick falls into the gap for certain if the gap is as long as the period of the controller.
            if sent.period < timeout + c.program.robot.period || !told.insert(sent.name.clone()) {
                continue;
            }
            let text = format!(
                "`{}` is valid for {}, and scenario `{}` sends it every {}",
                sent.name,
                shown(timeout, TIME),
                scenario.name,
                shown(sent.period, TIME)
            );
            out.push(
                Diagnostic::warning("HQ0559", place(c, &sent.name), text)
                    .note("before the next reading arrives the last one has expired, so the value comes and goes")
                    .help(format!(
                        "a `timeout` is a few periods of the sensor: write {} or more, or let the scenario send it more often",
                        shown(3.0 * sent.period, TIME)
                    )),
            );
        }
    }
}

/// Span of a written time-out, otherwise of the declaration.
fn place(c: &Checked, name: &str) -> Span {
    let of = |timeout: Option<&Entry>, name: Span| timeout.map_or(name, readings::entry);
    let signal = readings::signal(c.expanded, name).map(|s| of(s.settings.get("timeout"), s.name.span));
    let human = || readings::human(c.expanded, name).map(|h| of(h.body.get("timeout"), h.name.span));
    signal.or_else(human).unwrap_or_default()
}
