//! Warns of people whose last place is held after they were lost, without a limit that grows with the uncertainty.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{Lost, SignalProgram};

use crate::checks::{Checked, readings};

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let limits = readings::limits(c.program);
    let conditions = readings::of_conditions(c);
    for human in &c.program.interface.humans {
        let signals: Vec<&SignalProgram> = readings::points(c.program, human).collect();
        if !signals.iter().any(|s| s.motion.is_some_and(|m| matches!(m.lost, Lost::Hold(_)))) {
            continue;
        }
        let positions: BTreeSet<usize> = signals.iter().flat_map(|s| readings::position(s)).collect();
        let uncertainties: BTreeSet<usize> =
            signals.iter().flat_map(|s| [s.uncertainty_at(), s.uncertainty_at() + 1]).collect();
        let presences: BTreeSet<usize> = signals.iter().flat_map(|s| [s.at, s.known_at()]).collect();
        let uncertain = limits.iter().any(|(_, numbers)| !numbers.is_disjoint(&uncertainties));
        // A machine that sees the loss can stop the robot instead.
        let answered = !conditions.is_disjoint(&uncertainties) || !conditions.is_disjoint(&presences);
        let user = limits.iter().find(|(_, numbers)| !numbers.is_disjoint(&positions));
        let (Some((task, _)), false) = (user, uncertain || answered) else { continue };
        let Some(written) = readings::human(c.expanded, &human.name).and_then(|h| h.body.get("lost")) else { continue };
        let name = &c.program.tasks[*task].name;
        out.push(
            Diagnostic::warning(
                "HQ0541",
                readings::entry(written),
                format!("`{}` counts as standing at the last place when lost", human.name),
            )
            .label(c.places.tasks[*task].span, format!("`{name}` keeps away from that place only"))
            .note(
                "a person who is not seen walks on, 1.6 m each second, and no limit uses the uncertainty of the place",
            )
            .help(Help::with(
                &format!(
                    "add `uncertainty({})` to the distance, {{}}; or write {{}}, a fault that stops the robot",
                    human.name
                ),
                [
                    Snippet::entry("min", format!("0.4 m + uncertainty({})", human.name)),
                    Snippet::entry("lost", "fault"),
                ],
            )),
        );
    }
}
