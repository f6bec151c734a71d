//! Missions: bound by the tables of their kind, built by it, and its remarks reported at the texts that they are about.

pub(super) mod controllers;
mod declared;
mod drives;
mod events;
mod executed;
mod expectation_scope;
mod expectations;
mod remarks;
mod runs;
pub(super) mod scenario;

use dsl::tree::Mission;
use dsl::{Diagnostic, Span};
use mission::any_mission::AnyMission;
use mission::declare::Remarks;
use mission::kinds;
use runtime::program::MissionProgram;

use super::Lowerer;
use crate::expand::Expanded;

impl Lowerer<'_> {
    /// The missions of a spec; one in which something is wrong is left out, and the diagnostics say why.
    pub(super) fn missions(&mut self, missions: &[Mission]) -> Vec<MissionProgram> {
        missions.iter().filter_map(|m| self.mission(m)).collect()
    }

    fn mission(&mut self, m: &Mission) -> Option<MissionProgram> {
        let Some(entry) = kinds::find(&m.kind.value) else {
            self.unknown_kind(m);
            return None;
        };
        let (before, first) = (self.errors(), self.diagnostics.len());
        let declared = self.declared_mission(m, entry.schema);
        let mut remarks = Remarks::default();
        let built = AnyMission::build(entry, &declared, &mut remarks);
        let running = self.running(&declared, &*built);
        self.forget_values_of_refused_keys(m, &remarks, first);
        self.remarks(remarks, before);
        let good = self.errors() == before;
        good.then(|| MissionProgram {
            name: declared.name,
            kind: built,
            running,
            scenarios: Vec::new(),
            allowed: Vec::new(),
        })
    }

    /// Removes the diagnostics, from index `first` on, of values whose key is refused: without the key they are void.
    fn forget_values_of_refused_keys(&mut self, m: &Mission, remarks: &Remarks, first: usize) {
        let refused = |key: Span| remarks.all.iter().any(|r| r.is_error && self.origins.span(r.at) == key);
        let values: Vec<Span> =
            m.settings.entries.iter().filter(|e| refused(e.key.span)).map(|e| e.value.span).collect();
        let found = self.diagnostics.split_off(first);
        self.diagnostics.extend(found.into_iter().filter(|d| !values.contains(&d.primary.span)));
    }

    fn unknown_kind(&mut self, m: &Mission) {
        let kind = m.kind.value.as_str();
        if kind.is_empty() {
            // The reader has reported that the kind is missing.
            return;
        }
        let kinds = || kinds::KINDS.iter().map(|kind| kind.name);
        let d = Diagnostic::undeclared("kind of mission", kind, m.kind.span);
        self.push(d.one_of("kinds are", kind, kinds()));
    }
}

/// True for a spec that declares missions and nothing that needs a robot, but perhaps for scenarios that do not say what
/// they run.
pub(super) fn only(expanded: &Expanded) -> bool {
    !expanded.missions.is_empty()
        && expanded.robots.is_empty()
        && expanded.tasks.is_empty()
        && expanded.stacks.is_empty()
        && expanded.patterns.is_empty()
        && expanded.machines.is_empty()
        && expanded.runs.is_empty()
}
