//! Multi-agent Monte Carlo tree search, srs section 4, Algorithms 1 and 2.
//!
//! A rollout samples the actions of free agents by their probabilities `q` until nothing happens any more; then `q` of the
//! actions that it took is reduced, srs (14). The paper prints `q w gamma^n`, and says that the reduction is the lower the
//! farther an action is from the end of its rollout; the factor here, `1 - (1 - w) gamma^n`, has that property.
//!
//! Two additions are ours. Of three rollouts two follow the best plan so far for some states and then sample, one of them
//! just once before it goes on greedily. And a state all of whose successors are exhausted is not entered again, so that the
//! search of a small world ends with every sequence of the action sets tried.
//!
//! A fixed number of streams, each with its own tree, `q` and random numbers, exchange the best plan after rounds of a fixed
//! number of states. The result therefore depends on the seed and the number of states alone, and not on the threads that
//! run the streams.

mod states;
mod stream;

use super::team::{Choices, State, Team};
use crate::engine::Watch;

use self::stream::Stream;

/// Number of streams.
const STREAMS: usize = 4;
/// States that a stream expands in a round.
const ROUND: u64 = 500;
/// Rewards that differ by less are equal.
const EQUAL: f64 = 1e-9;

/// A plan as choices, with its worth.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Reward of the team.
    pub reward: f64,
    /// End of the last activity (s), which decides between equal rewards.
    pub latest: f64,
    /// Sum of the times of all actions (s), which decides where both are equal.
    pub busy: f64,
    /// Choices in each state.
    pub choices: Vec<Choices>,
}

impl Candidate {
    /// The plan that ends in a state.
    pub fn new(end: &State, choices: Vec<Choices>) -> Candidate {
        Candidate { reward: end.reward, latest: end.latest, busy: end.busy, choices }
    }

    /// Returns true if it is better than another one.
    pub fn beats(&self, other: &Candidate) -> bool {
        let [reward, latest, busy] = [self.reward - other.reward, other.latest - self.latest, other.busy - self.busy];
        let first = [reward, latest, busy].into_iter().find(|by| by.abs() > EQUAL);
        first.is_some_and(|by| by > 0.0)
    }
}

/// Result of a search.
#[derive(Clone, Debug)]
pub struct Found {
    /// The best plan.
    pub best: Candidate,
    /// Number of states that were expanded.
    pub states: u64,
    /// Every sequence of the action sets was tried.
    pub exhausted: bool,
    /// The clock ended the search.
    pub timed_out: bool,
}

/// Searches, Algorithm 1, from a first plan on, with at most this number of states and threads.
pub(crate) fn search(team: &Team<'_>, first: Candidate, states: u64, watch: &Watch, threads: usize) -> Found {
    let mut streams: Vec<Stream<'_>> = (0..STREAMS).map(|number| Stream::new(team, number, first.clone())).collect();
    let count = |streams: &[Stream<'_>]| streams.iter().map(Stream::states).sum::<u64>();
    let mut timed_out = false;
    loop {
        let left = states.saturating_sub(count(&streams));
        let round = left.div_ceil(STREAMS as u64).min(ROUND);
        if round == 0 || timed_out || streams.iter().any(Stream::is_over) {
            break;
        }
        timed_out = run(&mut streams, round, watch, threads.clamp(1, STREAMS));
        let best = streams.iter().map(|stream| &stream.best);
        let Some(best) = best.reduce(|best, other| if other.beats(best) { other } else { best }).cloned() else {
            break;
        };
        streams.iter_mut().for_each(|stream| stream.best = best.clone());
    }
    let exhausted = streams.iter().any(Stream::is_exhausted);
    let states = count(&streams);
    let best = streams.into_iter().next().map_or(first, |stream| stream.best);
    Found { best, states, exhausted, timed_out }
}

/// Runs a round of all streams; true if the time is over.
fn run(streams: &mut [Stream<'_>], round: u64, watch: &Watch, threads: usize) -> bool {
    if threads == 1 {
        return expand(streams, round, watch);
    }
    let share = streams.len().div_ceil(threads);
    std::thread::scope(|scope| {
        let running: Vec<_> =
            streams.chunks_mut(share).map(|part| scope.spawn(move || expand(part, round, watch))).collect();
        let mut over = false;
        for thread in running {
            // A thread that panicked leaves no plan to use: its panic goes on here.
            over |= thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        }
        over
    })
}

/// Expands each of these streams; true if the time is over.
fn expand(streams: &mut [Stream<'_>], round: u64, watch: &Watch) -> bool {
    let mut over = false;
    for stream in streams {
        over |= stream.expand(round, watch);
    }
    over
}
