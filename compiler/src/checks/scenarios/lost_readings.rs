//! Scripts whose readings are all lost.

use dsl::{Diagnostic, Help, Snippet};
use runtime::FaultKind;
use runtime::program::Measure;

use super::Scene;

impl Scene<'_> {
    /// Warns of people and signals all of whose readings are lost in transmission, unless a stale signal is what is expected.
    pub(super) fn lost_readings(&self, out: &mut Vec<Diagnostic>) {
        if self.scenario.measures.contains(&Measure::Fault(Some(FaultKind::Stale))) {
            return;
        }
        let interface = &self.program.interface;
        let people = self.scenario.world.humans.iter().filter(|h| h.sending.drop >= 1.0);
        let people = people.map(|h| ("humans", interface.humans[h.human].name.as_str()));
        let signals = self.scenario.world.signals.iter().filter(|s| s.drop >= 1.0);
        let signals = signals.map(|s| ("signals", interface.signals[s.signal].name.as_str()));
        for (class, name) in people.chain(signals) {
            let at = self.of_script(class, name, &["drop"]);
            out.push(
                Diagnostic::warning("HQ0815", at, format!("all readings of `{name}` are lost"))
                    .note("`drop` is the share that is lost, from 0 to 1: nothing of this script arrives")
                    .help(Help::with(
                        "write a share below 1, such as {}, or leave the script out",
                        [Snippet::entry("drop", "0.1")],
                    )),
            );
        }
    }
}
