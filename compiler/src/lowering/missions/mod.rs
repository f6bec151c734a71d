//! Missions: problems about teams, read from what a spec says of them, checked, and made data for the planners.

mod agents;
pub(super) mod controllers;
mod executed;
mod expectations;
mod happenings;
mod labels;
mod layers;
mod layers_file;
mod layers_mistakes;
mod layers_team;
mod layers_warnings;
mod mistakes;
mod places;
mod reading;
mod robots;
mod runs;
pub(super) mod scenario;
mod schedule;
mod spots;
mod warnings;
mod watch;

use dsl::tree::{Mission, MissionMember};
use dsl::{Diagnostic, Syntax};
use mission::any_mission::AnyMission;
use names::{list, suggest};
use runtime::program::{MissionProgram, Running};

use super::Lowerer;
use crate::expand::Expanded;
use crate::sections::{MISSION, Place, Section};

impl Lowerer<'_> {
    /// The missions of a spec; one in which something is wrong is left out, and the diagnostics say why.
    pub(super) fn missions(&mut self, missions: &[Mission]) -> Vec<MissionProgram> {
        let mut all = Vec::new();
        for m in missions {
            all.extend(self.mission(m).map(|(kind, running)| MissionProgram {
                name: m.name.value.clone(),
                kind,
                running,
                scenarios: Vec::new(),
            }));
        }
        all
    }

    fn mission(&mut self, m: &Mission) -> Option<(AnyMission, Running)> {
        match m.kind.value.as_str() {
            "schedule" => self.schedule(m).map(|(schedule, running)| (AnyMission::new(schedule), running)),
            "layers" => self.layers(m).map(|layers| (AnyMission::new(layers), Running::default())),
            // The reader has said that the kind is missing.
            "" => None,
            other => {
                let kinds = || MISSION.keys.iter().map(|k| k.name);
                let d = Diagnostic::error("HQ0201", m.kind.span, format!("there is no kind of mission `{other}`"));
                self.push(match suggest(other, kinds()) {
                    Some(near) => d.help(format!("did you mean `{near}`?")),
                    None => d.help(format!("kinds are {}", list(kinds(), 8))),
                });
                None
            }
        }
    }

    /// Reports a member whose role this kind of mission does not have, and what stands in one that holds nothing, or holds
    /// `inner` alone.
    fn roles(&mut self, member: &MissionMember, section: &Section, inner: Option<&'static Section>) -> bool {
        if !self.has_role(member, section) {
            return false;
        }
        for within in &member.members {
            if let Some(inner) = inner {
                self.has_role(within, inner);
                continue;
            }
            let text = format!("a {} of {} holds nothing of its own", member.role.value, section.name);
            let d = Diagnostic::error("HQ0205", within.role.span, text);
            self.push(d.help("write it beside the others, or leave it out"));
        }
        true
    }

    fn has_role(&mut self, member: &MissionMember, section: &Section) -> bool {
        let roles = || section.written(Syntax::Native).filter(|k| k.place == Place::Hq).map(|k| k.name);
        let role = member.role.value.as_str();
        let known = roles().any(|r| r == role);
        if !known {
            let d = Diagnostic::error("HQ0205", member.role.span, format!("{} has no `{role}`", section.name));
            self.push(d.help(format!("what stands there is {}", list(roles(), 8))));
        }
        known
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
