//! Spread of the position at a step of a prediction, from ways that are drawn.

use super::walk::Walk;
use crate::grid::{Action, Cell, State, World};
use crate::random::{index, stream};
use std::collections::BTreeMap;

/// Distribution of the position at one step. Positions are columns and rows, so that a length follows by the size of a cell.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Occupancy {
    /// Share of the draws that are in the predicted cell.
    pub share: f64,
    /// Mean column and row.
    pub mean: [f64; 2],
    /// Covariance of column and row.
    pub covariance: [[f64; 2]; 2],
}

impl Occupancy {
    /// A position without doubt.
    pub(super) fn certain(world: &World, cell: Cell) -> Occupancy {
        Occupancy { share: 1.0, mean: position(world, cell), covariance: [[0.0; 2]; 2] }
    }

    /// The position at each step of a way that draws nothing.
    pub(super) fn along(world: &World, walk: &Walk, samples: usize) -> Vec<Occupancy> {
        let certain = walk.steps.iter().map(|step| Occupancy::certain(world, step.state.cell()));
        if samples == 0 { Vec::new() } else { certain.collect() }
    }
}

/// Sums over the draws at one step.
#[derive(Clone, Copy, Default)]
struct Sums {
    inside: f64,
    position: [f64; 2],
    square: [[f64; 2]; 2],
}

/// Draws ways from the first state of a walk, and compares them with it step by step. A person who has left stays on the
/// exit.
pub(super) fn drawn(
    world: &World,
    walk: &Walk,
    samples: usize,
    seed: u64,
    mut probabilities: impl FnMut(&State) -> [f64; Action::COUNT],
) -> Vec<Occupancy> {
    if samples == 0 {
        return Vec::new();
    }
    let mut sums = vec![Sums::default(); walk.steps.len()];
    // Draws share most of their states, and the network is far slower than a look-up.
    let mut known: BTreeMap<State, [f64; Action::COUNT]> = BTreeMap::new();
    for sample in 0..samples {
        let mut generator = stream(seed, "prediction", &[sample as u64]);
        let mut state = walk.steps[0].state;
        for (sum, step) in sums.iter_mut().zip(&walk.steps) {
            let at = position(world, state.cell());
            sum.inside += f64::from(u8::from(state.cell() == step.state.cell()));
            for i in 0..2 {
                sum.position[i] += at[i];
                for (j, other) in at.iter().enumerate() {
                    sum.square[i][j] += at[i] * other;
                }
            }
            if !world.is_exit(state.cell()) {
                let p = known.entry(state).or_insert_with(|| probabilities(&state));
                state = world.step(&state, Action::ALL[index(&mut generator, p)]).state;
            }
        }
    }
    let n = samples as f64;
    let of = |sum: &Sums| {
        let mean = sum.position.map(|x| x / n);
        let covariance = [0, 1].map(|i| [0, 1].map(|j| sum.square[i][j] / n - mean[i] * mean[j]));
        Occupancy { share: sum.inside / n, mean, covariance }
    };
    sums.iter().map(of).collect()
}

fn position(world: &World, cell: Cell) -> [f64; 2] {
    [world.column(cell) as f64, world.row(cell) as f64]
}
