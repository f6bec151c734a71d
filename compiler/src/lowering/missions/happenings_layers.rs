//! What happens in a scenario of a mission of layers, and what of scenarios of schedules has no meaning there.

use dsl::Diagnostic;
use dsl::tree::Block;
use mission::kinds::layers::execution::Event;
use mission::kinds::layers::problem::Problem;
use names::list;
use runtime::program::Occurrence;

use super::super::Lowerer;
use super::executed::Executed;
use super::reading::Keys;

/// What can happen.
const EVENTS: [&str; 5] = ["late", "failed", "lost", "back", "done"];

impl Lowerer<'_> {
    /// What happens, of which a block says one thing.
    pub(super) fn happening_of_layers(&mut self, block: &Block, keys: Keys, problem: &Problem) -> Option<Occurrence> {
        let e = self.said(block, keys, &EVENTS)?;
        let name = self.somebody(&e.value)?;
        let Some(agent) = problem.agents.iter().position(|who| who.name == name.value) else {
            self.nobody_called(&name, Executed::Layers(problem));
            return None;
        };
        let why = match e.key.value.as_str() {
            "late" => {
                let Some(by) = keys.entry("by") else {
                    self.needs(e, keys, "by", "by 5 s");
                    return None;
                };
                return Some(Occurrence::Layered(Event::Late { agent, by: self.delay(by)? }));
            }
            "failed" => return Some(Occurrence::Layered(Event::Failed { agent })),
            "lost" => return Some(Occurrence::Layered(Event::Lost { agent })),
            "back" => return Some(Occurrence::Layered(Event::Back { agent })),
            "done" => return Some(Occurrence::Layered(Event::Done { agent })),
            "moved" => "every task begins and ends at the base of its agent, which stays where it is",
            "begun" => "an agent begins its next task as soon as it is free and the layers before are done",
            _ => "in a mission of layers nobody is served",
        };
        let text = format!("`{}` makes no sense in a mission of layers", e.key.value);
        let d = Diagnostic::error("HQ0922", e.key.span, text).note(why);
        self.push(d.help(format!("leave it out; there is {}", list(EVENTS.iter().copied(), 5))));
        None
    }

    /// Reports keys of scenarios that only schedules have.
    pub(super) fn nobody_serves(&mut self, keys: Keys) {
        for (key, why) in [
            ("travel", "agents of layers go the ways of their tasks, each from its base and back"),
            ("feedback", "people say what a service was like, and in a mission of layers nobody is served"),
        ] {
            let Some(e) = keys.entry(key) else { continue };
            let d =
                Diagnostic::error("HQ0921", e.key.span, format!("a scenario of a mission of layers has no `{key}`"));
            let d = match keys.entry("mission") {
                Some(mission) => d.label(mission.value.span, "this mission is of layers"),
                None => d,
            };
            self.push(d.note(why).help("leave it out"));
        }
    }
}
