//! State of the process: the cell of the person, and the targets that are left. Obstacles and exits, which the paper's state
//! (6) holds too, belong to the [`World`](super::World), because they do not change.

use super::Cell;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The most targets of a state.
pub const MAX_TARGETS: usize = 32;

/// A target: its cell, and the number of its type, from 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default, Serialize, Deserialize)]
pub struct Target {
    /// Cell of the target.
    pub cell: Cell,
    /// Number of its type; 0 is type A of the paper, 1 its type B.
    pub kind: u8,
}

/// The cell of the person and the remaining targets, ordered by cell and type. Made by
/// [`World::state`](super::World::state), which checks it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct State {
    cell: Cell,
    count: u8,
    /// Ordered; the rest beyond `count` is always `Target::default()`, so that derived comparisons are right.
    targets: [Target; MAX_TARGETS],
}

/// Reason why a state is not one of a world.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum StateError {
    /// The cell of the person is outside.
    #[error("the person is in cell {cell}, and the grid has {cells} cells")]
    Outside {
        /// The cell.
        cell: Cell,
        /// Cells of the grid.
        cells: usize,
    },
    /// The person is in an obstacle.
    #[error("the person is in cell {0}, an obstacle")]
    InObstacle(Cell),
    /// A target is outside of the grid.
    #[error("a target is in cell {cell}, and the grid has {cells} cells")]
    TargetOutside {
        /// The cell.
        cell: Cell,
        /// Cells of the grid.
        cells: usize,
    },
    /// A target is in an obstacle.
    #[error("a target is in cell {0}, an obstacle")]
    TargetInObstacle(Cell),
    /// A target is on an exit, where an episode ends before it could be collected.
    #[error("a target is in cell {0}, an exit: the person leaves there and cannot collect it")]
    TargetOnExit(Cell),
    /// The type of a target is not one of the world.
    #[error("a target has type {kind}, and the world has {types} types, numbered from 0")]
    UnknownType {
        /// The type.
        kind: u8,
        /// Types of the world.
        types: u8,
    },
    /// Two targets of one type in one cell, which a feature map cannot hold.
    #[error("cell {} has two targets of type {}", .0.cell, .0.kind)]
    Twice(Target),
    /// Too many targets.
    #[error("there are {0} targets, and a state holds at most {MAX_TARGETS}")]
    TooMany(usize),
}

impl State {
    /// Orders the targets. The caller has checked them: no two are equal, and there are at most `MAX_TARGETS`.
    pub(super) fn of_checked(cell: Cell, targets: &[Target]) -> State {
        let mut state = State { cell, count: targets.len() as u8, targets: [Target::default(); MAX_TARGETS] };
        state.targets[..targets.len()].copy_from_slice(targets);
        state.targets[..targets.len()].sort_unstable();
        state
    }

    /// Cell of the person.
    pub fn cell(&self) -> Cell {
        self.cell
    }

    /// The remaining targets, ordered by cell, then type.
    pub fn targets(&self) -> &[Target] {
        &self.targets[..usize::from(self.count)]
    }

    /// The remaining target in the cell of the person; the one of the lowest type if there are several.
    pub fn target_here(&self) -> Option<Target> {
        self.targets().iter().copied().find(|target| target.cell == self.cell)
    }

    pub(super) fn moved(mut self, cell: Cell) -> State {
        self.cell = cell;
        self
    }

    /// The state without a target, whoever collected it; itself if the target is not there.
    pub fn without(mut self, target: Target) -> State {
        let count = usize::from(self.count);
        if let Ok(at) = self.targets().binary_search(&target) {
            self.targets.copy_within(at + 1..count, at);
            self.targets[count - 1] = Target::default();
            self.count -= 1;
        }
        self
    }
}

impl fmt::Debug for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("State").field("cell", &self.cell).field("targets", &self.targets()).finish()
    }
}
