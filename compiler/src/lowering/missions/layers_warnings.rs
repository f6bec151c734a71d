//! What about a mission of layers can be planned and is hardly meant.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use dsl::tree::Mission;
use mission::kinds::layers::check::{Item, Key};
use mission::kinds::layers::problem::{Body, Problem};
use names::suggest;

use super::super::Lowerer;
use super::places::OfLayers as Places;
use crate::forms::text_of;

impl Lowerer<'_> {
    /// Tells of a cost that is always zero, and of what agents are kept from although nothing is of that kind.
    pub(super) fn layers_warnings(&mut self, m: &Mission, problem: &Problem, places: &Places) {
        let (weights, agents) = (problem.weights, &problem.agents);
        let robots = agents.iter().any(|agent| matches!(agent.body, Body::Robot { .. }));
        let people = agents.iter().any(|agent| matches!(agent.body, Body::Human { .. }));
        let costs =
            [weights.makespan, if robots { weights.energy } else { 0.0 }, if people { weights.workload } else { 0.0 }];
        if costs.iter().all(|cost| *cost == 0.0) {
            let at = places.of(Item::Mission, Some(Key::Weights));
            let text = "nothing costs anything, so that every plan is as good as any other";
            self.push(Diagnostic::warning("HQ0908", at, text).help("write a weight above zero, such as `makespan 1`"));
        }
        let of_objects = problem.objects.iter().flat_map(|object| &object.features);
        let known: BTreeSet<&str> =
            of_objects.chain(problem.tasks.iter().flat_map(|task| &task.features)).map(String::as_str).collect();
        for member in m.members.iter().filter(|k| matches!(k.role.value.as_str(), "robot" | "human")) {
            let words = member.settings.get("cannot").map_or(&[][..], |e| e.value.items());
            for (item, word) in words.iter().filter_map(|item| Some((item, text_of(item)?))) {
                if known.contains(word) {
                    continue;
                }
                let text = format!("nothing is `{word}`, so that this keeps `{}` from nothing", member.name.value);
                self.push(match suggest(word, known.iter().copied()) {
                    Some(near) => Diagnostic::error("HQ0913", item.span, text).help(format!("did you mean `{near}`?")),
                    None => Diagnostic::warning("HQ0913", item.span, text)
                        .help("name a feature that an object has, or leave it out"),
                });
            }
        }
    }
}
