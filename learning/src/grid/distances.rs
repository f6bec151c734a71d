//! Shortest ways: steps from every cell to the nearest of some cells, breadth first.

use super::{Action, Cell, World};
use std::collections::VecDeque;

/// Steps from each cell to the nearest goal; `None` for obstacles and cells without a way. A way leads over no exit but a
/// goal, because an episode ends there.
pub(crate) fn distances(world: &World, goals: &[Cell]) -> Vec<Option<u32>> {
    let mut steps = vec![None; world.cells()];
    let mut queue = VecDeque::new();
    for goal in goals {
        steps[usize::from(*goal)] = Some(0);
        queue.push_back(*goal);
    }
    while let Some(cell) = queue.pop_front() {
        let next = steps[usize::from(cell)].map(|n: u32| n + 1);
        // Moves are symmetric, so that ways from the goal are ways to it.
        for to in Action::MOVES.into_iter().filter_map(|action| world.neighbour(cell, action)) {
            if steps[usize::from(to)].is_none() && !world.is_exit(to) {
                steps[usize::from(to)] = next;
                queue.push_back(to);
            }
        }
    }
    steps
}
