//! Regions of states that are active beside each other: where they may stand, transitions between them, and what they
//! wait for.

use dsl::tree::Value;
use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::program::{MachineProgram, Trigger};

use super::Lowerer;
use super::machine::MachineLowering;
use crate::forms::text_of;
use crate::source_map::MachinePlaces;

/// The word for all regions of a state.
const ALL: &str = "all";

impl MachineLowering<'_, '_> {
    /// Regions of a state, in the order written.
    pub(super) fn regions(&self, i: usize) -> Vec<usize> {
        (0..self.flat.len()).filter(|&k| self.flat[k].parent == Some(i) && self.flat[k].region).collect()
    }

    /// Reports regions that stand elsewhere than alone in a state.
    pub(super) fn misplaced_regions(&mut self) {
        for i in 0..self.flat.len() {
            let regions = self.regions(i);
            let Some(&first) = regions.first() else { continue };
            let at = self.flat[first].at;
            let around = std::iter::successors(Some(i), |&k| self.flat[k].parent).find(|&k| self.flat[k].region);
            if i == 0 {
                let d = misplaced(at, "a region is part of a state, not of the machine");
                self.lowerer.push(d.help(Help::with(
                    "put the regions into a state, {}",
                    [Snippet::each("state NAME { region .. }", "NAME: { regions: { .. } }")],
                )));
            }
            if let Some(outer) = around {
                let d = misplaced(at, "a region cannot contain regions");
                let d = d.label(self.flat[outer].at, "it is inside this region");
                self.lowerer.push(d.help("write them beside this region, as regions of the same state"));
            }
            for k in (0..self.flat.len()).filter(|&k| self.flat[k].parent == Some(i) && !self.flat[k].region) {
                let d = misplaced(self.flat[k].at, "a state cannot stand beside regions").label(at, "a region");
                self.lowerer.push(
                    d.note("all states inside a state with regions are in one of the regions")
                        .help("put it into one of the regions, or outside the state that contains them"),
                );
            }
            if let Some(entry) = self.flat[i].body.settings.get("initial").filter(|_| i > 0) {
                let d = misplaced(entry.key.span, "a state with regions has no initial state");
                self.lowerer
                    .push(d.note("all regions are entered with it").help("leave it out: each region has its own"));
            }
        }
    }

    /// Lowers `ended(left, right)` or `ended(all)` in state `i`.
    pub(super) fn ended(&mut self, i: usize, args: &[Value], at: Span) -> Option<Trigger> {
        let around: Vec<usize> = std::iter::successors(Some(i), |&k| self.flat[k].parent).collect();
        let known: Vec<usize> = around.iter().flat_map(|&k| self.regions(k)).collect();
        let Some(&nearest) = known.first() else {
            let d = Diagnostic::error("HQ0703", at, "there is no region here that could end");
            self.lowerer.push(d.help(Help::with(
                "wait for regions in the state that contains them, {}, or in one around it",
                [Snippet::each("state NAME { region .. }", "NAME: { regions: { .. } }")],
            )));
            return None;
        };
        if let [word] = args
            && text_of(word) == Some(ALL)
        {
            let parent = self.flat[nearest].parent;
            return Some(Trigger::Ended(known.into_iter().filter(|&r| self.flat[r].parent == parent).collect()));
        }
        let short = |name: &str| name.rsplit('.').next().unwrap_or(name).to_string();
        let names: Vec<String> = known.iter().map(|&r| short(&self.flat[r].name)).collect();
        let mut regions = Vec::new();
        for arg in args {
            match names.iter().position(|name| text_of(arg) == Some(name)) {
                Some(k) => regions.push(known[k]),
                None => {
                    let written = self.lowerer.sources.snippet(arg.span).to_string();
                    let d = Diagnostic::unknown_name(arg.span, format!("there is no region `{written}` here"));
                    self.lowerer.push(d.one_of("regions are", &written, names.iter().map(String::as_str)));
                }
            }
        }
        if args.is_empty() {
            let d = Diagnostic::error("HQ0310", at, "`ended` takes the names of regions");
            self.lowerer.push(d.help(Help::with("write {}", [Snippet::entry("on", "ended(all)")])));
        }
        (!regions.is_empty() && regions.len() == args.len()).then_some(Trigger::Ended(regions))
    }
}

fn misplaced(at: Span, text: &str) -> Diagnostic {
    Diagnostic::error("HQ0729", at, text)
}

impl Lowerer<'_> {
    /// Reports transitions into sibling regions.
    pub(super) fn region_errors(&mut self, machine: &MachineProgram, places: &MachinePlaces) {
        for (s, state) in machine.states.iter().enumerate() {
            for (t, place) in state.transitions.iter().zip(&places.transitions[s]) {
                if let (true, Some(from), Some(to)) =
                    (machine.are_beside(s, t.target), machine.region(s), machine.region(t.target))
                {
                    self.push(into_another(machine, places, [from, to], place.target));
                }
            }
        }
    }
}

/// A transition that leads from one region into another.
fn into_another(machine: &MachineProgram, places: &MachinePlaces, regions: [usize; 2], at: Span) -> Diagnostic {
    let [from, to] = regions;
    let names = regions.map(|r| &machine.states[r].name);
    let outer = machine.states[from].parent.map_or("", |p| machine.states[p].name.as_str());
    Diagnostic::error("HQ0730", at, format!("this transition leads from region `{}` into `{}`", names[0], names[1]))
        .label(places.states[to], "this region has a state of its own at any time")
        .note("a region changes only its own state, or leaves all regions")
        .help(Help::with(
            &format!("raise an event, {{}}, for which `{}` waits; or lead to a state outside `{outer}`", names[1]),
            [Snippet::each("enter emit(EVENT)", "enter: emit(EVENT)")],
        ))
}
