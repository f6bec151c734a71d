//! Checks of scenarios and of their expectations: those that no run of the scenario can satisfy, or that no run can violate.

mod at_start;
mod exclusive;
mod late_readings;
mod lost_readings;
mod never_true;
mod people;
mod reactions;
mod written;

use dsl::Diagnostic;
use dsl::tree::Scenario;
use runtime::program::{Program, ScenarioProgram};

use super::Checked;
use crate::analysis::played::Played;
use crate::analysis::stacks::Stacks;
use crate::expr::Graph;
use crate::source_map::SourceMap;

/// A scenario, as the checks see it.
struct Scene<'s> {
    program: &'s Program,
    stacks: &'s Stacks<'s>,
    scenario: &'s ScenarioProgram,
    /// All that can happen in it.
    played: &'s Played<'s>,
    /// Its text.
    written: &'s Scenario,
    places: &'s SourceMap,
    graph: &'s Graph,
}

/// Runs all checks of scenarios.
pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    for index in 0..c.program.scenarios.len() {
        let Some(played) = Played::new(c.program, index, c.places, c.context) else { continue };
        let Some((written, _)) = c.expanded.scenarios.get(played.places.written) else { continue };
        // An expectation that could not be read was reported.
        if written.expects.len() != played.scenario.expectations.len() {
            continue;
        }
        let scene = Scene {
            program: c.program,
            stacks: &c.stacks,
            scenario: played.scenario,
            played: &played,
            written,
            places: c.places,
            graph: c.context.graph,
        };
        scene.lost_readings(out);
        scene.late_readings(out);
        scene.unknown_people(out);
        scene.people_out_of_reach(out);
        scene.never_true(out);
        scene.reactions(out);
        scene.exclusive(out);
        scene.decided_at_start(out);
    }
}
