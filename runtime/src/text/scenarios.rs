//! Scenarios as text.

use std::fmt::Write;

use super::subject;
use crate::program::{Program, ScenarioProgram};

/// Writes the subject of a scenario, its world, and its expectations.
pub(super) fn scenario(p: &Program, s: &ScenarioProgram, out: &mut String) -> std::fmt::Result {
    let seed = s.run.simulator.seed;
    let what = subject(p, s.run.subject);
    writeln!(out, "\nscenario \"{}\": {what} for {} s, seed {seed}", s.name, s.run.duration)?;
    super::simulator(&s.run.simulator, out)?;
    let w = &s.world;
    let counts = [
        (w.signals.len(), "scripts of signals"),
        (w.humans.len(), "people"),
        (w.events.iter().map(|e| e.1.len()).sum(), "events"),
        (w.outcomes.iter().map(|o| o.requests.len()).sum(), "outcomes"),
        (w.pushes.len(), "pushes"),
        (w.late.len(), "late ticks"),
        (w.lost.len(), "lost readings"),
    ];
    let said: Vec<String> = counts.iter().filter(|c| c.0 > 0).map(|(n, what)| format!("{what} {n}")).collect();
    if !said.is_empty() {
        writeln!(out, "  world: {}", said.join(", "))?;
    }
    for e in &s.expectations {
        let label = e.label.as_ref().map(|l| format!("\"{l}\" ")).unwrap_or_default();
        writeln!(out, "  expect {label}{}", e.text)?;
    }
    Ok(())
}
