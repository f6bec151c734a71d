//! The greedy baseline: each agent that is free takes the action with the most reward a second, whatever the others plan.

use super::team::{Act, Choices, State, Team};
use super::tree_search::Candidate;

/// The most choices of a plan: a bound that stays of at least a tenth of a second keep.
const MOST: usize = 100_000;

/// The action with the most reward a second that an agent can begin now; if none has any, it waits if that may help, and
/// ends otherwise.
pub fn greedy_act(team: &Team<'_>, state: &State, agent: usize) -> Act {
    let mut best = (0.0, Act::End);
    if let Some(told) = team.told(state, agent) {
        return told;
    }
    for act in team.menu(state, agent) {
        if matches!(act, Act::End | Act::Wait) || team.end_of(state, agent, act).is_none() {
            continue;
        }
        let estimate = team.estimate(state, agent, act, false);
        let worth = estimate.gain / estimate.time.max(1e-3);
        if worth > best.0 {
            best = (worth, act);
        }
    }
    let waits = best.1 == Act::End && team.menu(state, agent).contains(&Act::Wait);
    if waits && team.end_of(state, agent, Act::Wait).is_some() { Act::Wait } else { best.1 }
}

/// The greedy plan.
pub fn greedy(team: &Team<'_>) -> Candidate {
    let (mut state, mut choices) = (team.root(), Vec::new());
    while !state.terminal && choices.len() < MOST {
        let chosen: Choices = team.free(&state).map(|agent| (agent, greedy_act(team, &state, agent))).collect();
        state = team.next(&state, &chosen);
        choices.push(chosen);
    }
    Candidate::new(&state, choices)
}
