//! The states of a tree without an allocation for each: the numbers of all of them in a few vectors.

use crate::kinds::search::team::{Standing, State};

/// The numbers of a state that every state has once.
#[derive(Clone, Copy, Debug)]
struct Scalars {
    time: f64,
    reward: f64,
    undetected: f64,
    busy: f64,
    latest: f64,
    terminal: bool,
}

/// States of one team, by number.
#[derive(Debug, Default)]
pub(super) struct States {
    scalars: Vec<Scalars>,
    pools: Vec<f64>,
    weights: Vec<f64>,
    agents: Vec<Standing>,
}

impl States {
    /// Adds a state of the same team as all others.
    pub fn push(&mut self, state: &State) {
        self.scalars.push(Scalars {
            time: state.time,
            reward: state.reward,
            undetected: state.undetected.sum,
            busy: state.busy,
            latest: state.latest,
            terminal: state.terminal,
        });
        self.pools.extend_from_slice(&state.pools);
        self.weights.extend_from_slice(&state.undetected.weights);
        self.agents.extend_from_slice(&state.agents);
    }

    /// Writes the state of this number over another one of the same team.
    pub fn load(&self, number: u32, state: &mut State) {
        let number = number as usize;
        let scalars = &self.scalars[number];
        state.time = scalars.time;
        state.reward = scalars.reward;
        state.undetected.sum = scalars.undetected;
        state.busy = scalars.busy;
        state.latest = scalars.latest;
        state.terminal = scalars.terminal;
        load(&self.pools, number, &mut state.pools);
        load(&self.weights, number, &mut state.undetected.weights);
        load(&self.agents, number, &mut state.agents);
    }

    /// True if nothing happens any more in the state of this number.
    pub fn is_terminal(&self, number: u32) -> bool {
        self.scalars[number as usize].terminal
    }

    /// Number of cells in which something is hidden.
    pub fn cells(&self) -> usize {
        self.weights.len() / self.scalars.len().max(1)
    }
}

/// Copies the part of a state from those of all.
fn load<T: Copy>(all: &[T], number: usize, part: &mut [T]) {
    let count = part.len();
    part.copy_from_slice(&all[number * count..(number + 1) * count]);
}
