//! Warnings about a mission of layers that can be planned and is hardly meant.

use std::collections::BTreeSet;

use blocks::{Bound, Help, Snippet};
use names::suggest;

use super::check::{Item, Key};
use super::magnitudes;
use super::problem::{Body, Problem};
use crate::declare::{Origins, Remark, Remarks};

/// Warns of a cost that is always zero, and of features that agents cannot handle and that nothing has.
pub(super) fn add(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    let (weights, agents) = (problem.weights, &problem.agents);
    let robots = agents.iter().any(|agent| matches!(agent.body, Body::Robot { .. }));
    let people = agents.iter().any(|agent| matches!(agent.body, Body::Human { .. }));
    let costs =
        [weights.makespan, if robots { weights.energy } else { 0.0 }, if people { weights.workload } else { 0.0 }];
    if costs.iter().all(|cost| *cost == 0.0) {
        let at = places.of(Item::Mission, Key::Weights.names());
        let text = "all weights are zero, so all plans have equal cost";
        remarks.push(
            Remark::warning("HQ0908", at, text)
                .help(Help::with("write a weight above zero, such as {}", [Snippet::entry("makespan", "1")])),
        );
    }
    magnitudes::add(problem, places, remarks);
    let of_objects = problem.objects.iter().flat_map(|object| &object.features);
    let known: BTreeSet<&str> =
        of_objects.chain(problem.tasks.iter().flat_map(|task| &task.features)).map(String::as_str).collect();
    for (index, agent) in agents.iter().enumerate() {
        let Some(block) = places.block(Item::Agent(index)) else { continue };
        for item in block.items("cannot") {
            let Bound::Text(word) = &item.value else { continue };
            if known.contains(word.as_str()) {
                continue;
            }
            let text = format!("nothing is `{word}`, so that this keeps `{}` from nothing", agent.name);
            remarks.push(match suggest(word, known.iter().copied()) {
                Some(near) => Remark::error("HQ0913", item.at, text).meant(near),
                None => {
                    Remark::warning("HQ0913", item.at, text).help("name a feature that an object has, or leave it out")
                }
            });
        }
    }
}
