//! The constants of an episode: the size of the grid, obstacles, exits, the number of types, the step limit; and
//! the transition function.

use super::distances::distances;
use super::state::{MAX_TARGETS, State, StateError, Target};
use super::{Action, Cell};
use serde::{Deserialize, Serialize};

/// The most cells of a grid.
pub const MAX_CELLS: usize = 4096;
/// The most types of targets.
pub const MAX_TYPES: u8 = 16;

/// A grid with obstacles and exits. It is checked when it is made: from at least one cell an exit can be reached.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(try_from = "Description", into = "Description")]
pub struct World {
    columns: u16,
    rows: u16,
    types: u8,
    step_limit: u32,
    obstacles: Vec<bool>,
    exits: Vec<bool>,
    /// Steps from each cell to the nearest exit; `None` for obstacles and cells that no way leads out of.
    to_exit: Vec<Option<u32>>,
}

/// A world in files.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    columns: usize,
    rows: usize,
    obstacles: Vec<usize>,
    exits: Vec<usize>,
    types: usize,
    step_limit: u32,
}

impl From<World> for Description {
    fn from(world: World) -> Description {
        Description {
            columns: world.columns(),
            rows: world.rows(),
            obstacles: world.obstacles().map(usize::from).collect(),
            exits: world.exits().map(usize::from).collect(),
            types: world.types(),
            step_limit: world.step_limit,
        }
    }
}

impl TryFrom<Description> for World {
    type Error = WorldError;

    fn try_from(of: Description) -> Result<World, WorldError> {
        World::new(of.columns, of.rows, &of.obstacles, &of.exits, of.types)?.with_step_limit(of.step_limit)
    }
}

/// Reason why a world cannot be made.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum WorldError {
    /// No cells, or too many.
    #[error(
        "a grid of {columns} columns and {rows} rows; at least one of each and at most {MAX_CELLS} cells are needed"
    )]
    Size {
        /// Columns.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// No type, or too many.
    #[error("there are {0} types of targets; 1 to {MAX_TYPES} are possible")]
    Types(usize),
    /// An obstacle or an exit outside of the grid.
    #[error("an {what} is in cell {cell}, and the grid has {cells} cells")]
    Outside {
        /// `obstacle` or `exit`.
        what: &'static str,
        /// The cell.
        cell: usize,
        /// Cells of the grid.
        cells: usize,
    },
    /// An exit inside an obstacle.
    #[error("cell {0} is an exit and an obstacle")]
    BlockedExit(usize),
    /// No exit.
    #[error("there is no exit, so that no episode ends")]
    NoExit,
    /// An episode can start nowhere.
    #[error("no exit can be reached from any other cell")]
    Unreachable,
    /// No steps.
    #[error("the step limit is 0")]
    NoSteps,
}

/// Result of an action.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Step {
    /// The next state.
    pub state: State,
    /// The person walked into a wall or an obstacle, and stays.
    pub collision: bool,
    /// The target that was collected.
    pub collected: Option<Target>,
    /// The person is on an exit.
    pub arrived: bool,
}

impl World {
    /// Steps of an episode unless [`World::with_step_limit`] sets another number. The paper names none.
    pub const DEFAULT_STEP_LIMIT: u32 = 50;

    /// A grid with these obstacles and exits, for targets of `types` types.
    pub fn new(
        columns: usize,
        rows: usize,
        obstacles: &[usize],
        exits: &[usize],
        types: usize,
    ) -> Result<World, WorldError> {
        let cells = columns.saturating_mul(rows);
        if cells == 0 || cells > MAX_CELLS {
            return Err(WorldError::Size { columns, rows });
        }
        let kinds = u8::try_from(types).ok().filter(|types| (1..=MAX_TYPES).contains(types));
        let kinds = kinds.ok_or(WorldError::Types(types))?;
        let obstacles = marked("obstacle", cells, obstacles)?;
        let marked_exits = marked("exit", cells, exits)?;
        if let Some(cell) = (0..cells).find(|cell| obstacles[*cell] && marked_exits[*cell]) {
            return Err(WorldError::BlockedExit(cell));
        }
        if exits.is_empty() {
            return Err(WorldError::NoExit);
        }
        let mut world = World {
            columns: columns as u16,
            rows: rows as u16,
            types: kinds,
            step_limit: World::DEFAULT_STEP_LIMIT,
            obstacles,
            exits: marked_exits,
            to_exit: Vec::new(),
        };
        let exits: Vec<Cell> = exits.iter().map(|cell| *cell as Cell).collect();
        world.to_exit = distances(&world, &exits);
        if !(0..cells).any(|cell| !world.exits[cell] && world.to_exit[cell].is_some()) {
            return Err(WorldError::Unreachable);
        }
        Ok(world)
    }

    /// The same world with another step limit, at least 1.
    pub fn with_step_limit(mut self, steps: u32) -> Result<World, WorldError> {
        if steps == 0 {
            return Err(WorldError::NoSteps);
        }
        self.step_limit = steps;
        Ok(self)
    }

    /// Columns of the grid.
    pub fn columns(&self) -> usize {
        usize::from(self.columns)
    }

    /// Rows of the grid.
    pub fn rows(&self) -> usize {
        usize::from(self.rows)
    }

    /// Cells of the grid, obstacles included.
    pub fn cells(&self) -> usize {
        self.obstacles.len()
    }

    /// Types of targets.
    pub fn types(&self) -> usize {
        usize::from(self.types)
    }

    /// Steps after which an episode has failed.
    pub fn step_limit(&self) -> u32 {
        self.step_limit
    }

    /// Column of a cell, from 0 at the left.
    pub fn column(&self, cell: Cell) -> usize {
        usize::from(cell % self.columns)
    }

    /// Row of a cell, from 0 at the bottom.
    pub fn row(&self, cell: Cell) -> usize {
        usize::from(cell / self.columns)
    }

    /// The cell in this column and row; `None` outside.
    pub fn cell(&self, column: usize, row: usize) -> Option<Cell> {
        (column < self.columns() && row < self.rows()).then(|| (row * self.columns() + column) as Cell)
    }

    /// Tests whether a cell of the grid is an obstacle.
    pub fn is_obstacle(&self, cell: Cell) -> bool {
        self.obstacles.get(usize::from(cell)).is_some_and(|obstacle| *obstacle)
    }

    /// Tests whether a cell of the grid is an exit.
    pub fn is_exit(&self, cell: Cell) -> bool {
        self.exits.get(usize::from(cell)).is_some_and(|exit| *exit)
    }

    /// Cells of the obstacles, in order.
    pub fn obstacles(&self) -> impl Iterator<Item = Cell> + '_ {
        set_cells(&self.obstacles)
    }

    /// Cells of the exits, in order.
    pub fn exits(&self) -> impl Iterator<Item = Cell> + '_ {
        set_cells(&self.exits)
    }

    /// Cells in which a person can be and from which an exit can be reached, without the exits: starts and targets of random
    /// environments.
    pub fn open_cells(&self) -> impl Iterator<Item = Cell> + '_ {
        let open = |cell: &Cell| !self.is_exit(*cell) && self.steps_to_exit(*cell).is_some();
        (0..self.cells() as Cell).filter(open)
    }

    /// Steps of the shortest way from a cell to an exit; `None` if there is no way.
    pub fn steps_to_exit(&self, cell: Cell) -> Option<u32> {
        self.to_exit.get(usize::from(cell)).copied().flatten()
    }

    /// The cell that a move leads to; `None` into a wall or an obstacle, and for `Collect`.
    pub fn neighbour(&self, cell: Cell, action: Action) -> Option<Cell> {
        let (column, row) = (self.column(cell), self.row(cell));
        let to = match action {
            Action::North => self.cell(column, row + 1),
            Action::South => self.cell(column, row.checked_sub(1)?),
            Action::West => self.cell(column.checked_sub(1)?, row),
            Action::East => self.cell(column + 1, row),
            Action::Collect => None,
        };
        to.filter(|to| !self.is_obstacle(*to))
    }

    /// A checked state of this world.
    pub fn state(&self, cell: Cell, targets: &[Target]) -> Result<State, StateError> {
        let cells = self.cells();
        if usize::from(cell) >= cells {
            return Err(StateError::Outside { cell, cells });
        }
        if self.is_obstacle(cell) {
            return Err(StateError::InObstacle(cell));
        }
        if targets.len() > MAX_TARGETS {
            return Err(StateError::TooMany(targets.len()));
        }
        for (i, target) in targets.iter().enumerate() {
            if usize::from(target.cell) >= cells {
                return Err(StateError::TargetOutside { cell: target.cell, cells });
            }
            if target.kind >= self.types {
                return Err(StateError::UnknownType { kind: target.kind, types: self.types });
            }
            if self.is_obstacle(target.cell) {
                return Err(StateError::TargetInObstacle(target.cell));
            }
            if self.is_exit(target.cell) {
                return Err(StateError::TargetOnExit(target.cell));
            }
            if targets[..i].contains(target) {
                return Err(StateError::Twice(*target));
            }
        }
        Ok(State::of_checked(cell, targets))
    }

    /// Checks a state that another world may have made.
    pub fn check(&self, state: &State) -> Result<(), StateError> {
        self.state(state.cell(), state.targets()).map(|_| ())
    }

    /// The transition `p(s'|s, a)`, which is deterministic.
    pub fn step(&self, state: &State, action: Action) -> Step {
        let stays = Step { state: *state, collision: false, collected: None, arrived: self.is_exit(state.cell()) };
        if action == Action::Collect {
            return match state.target_here() {
                Some(target) => Step { state: state.without(target), collected: Some(target), ..stays },
                None => stays,
            };
        }
        match self.neighbour(state.cell(), action) {
            Some(cell) => Step { state: state.moved(cell), arrived: self.is_exit(cell), ..stays },
            None => Step { collision: true, ..stays },
        }
    }
}

/// A mark for each of these cells.
fn marked(what: &'static str, cells: usize, of: &[usize]) -> Result<Vec<bool>, WorldError> {
    let mut marks = vec![false; cells];
    for cell in of {
        *marks.get_mut(*cell).ok_or(WorldError::Outside { what, cell: *cell, cells })? = true;
    }
    Ok(marks)
}

fn set_cells(marks: &[bool]) -> impl Iterator<Item = Cell> + '_ {
    marks.iter().enumerate().filter(|(_, marked)| **marked).map(|(cell, _)| cell as Cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three columns, two rows: an obstacle in the middle of the lower row, the exit at its right.
    fn world() -> World {
        World::new(3, 2, &[1], &[2], 2).unwrap()
    }

    #[test]
    fn steps_lead_to_neighbours_and_stop_at_walls_and_obstacles() {
        let world = world();
        let at = world.state(0, &[]).unwrap();
        assert_eq!(world.step(&at, Action::North).state.cell(), 3);
        for blocked in [Action::South, Action::West, Action::East] {
            let step = world.step(&at, blocked);
            assert!(step.collision && step.state == at, "{blocked:?}");
        }
        let above_exit = world.state(5, &[]).unwrap();
        assert!(world.step(&above_exit, Action::South).arrived);
        assert!(!world.step(&above_exit, Action::West).arrived);
    }

    #[test]
    fn a_target_is_collected_once() {
        let world = world();
        let targets = [Target { cell: 3, kind: 1 }, Target { cell: 3, kind: 0 }, Target { cell: 0, kind: 1 }];
        let start = world.state(3, &targets).unwrap();
        let first = world.step(&start, Action::Collect);
        assert_eq!(first.collected, Some(Target { cell: 3, kind: 0 }));
        let second = world.step(&first.state, Action::Collect);
        assert_eq!(second.collected, Some(Target { cell: 3, kind: 1 }));
        let third = world.step(&second.state, Action::Collect);
        assert_eq!((third.collected, third.collision), (None, false));
        assert_eq!(third.state.targets(), [Target { cell: 0, kind: 1 }]);
        assert_eq!(third.state, world.state(3, &[Target { cell: 0, kind: 1 }]).unwrap());
    }

    #[test]
    fn distances_lead_around_obstacles() {
        let world = world();
        let steps: Vec<Option<u32>> = (0..6).map(|cell| world.steps_to_exit(cell)).collect();
        assert_eq!(steps, [Some(4), None, Some(0), Some(3), Some(2), Some(1)]);
        assert_eq!(world.open_cells().collect::<Vec<_>>(), [0, 3, 4, 5]);
    }

    #[test]
    fn worlds_without_a_way_out_are_refused() {
        assert_eq!(World::new(0, 3, &[], &[], 1).unwrap_err(), WorldError::Size { columns: 0, rows: 3 });
        assert!(matches!(World::new(usize::MAX, 2, &[], &[0], 1), Err(WorldError::Size { .. })));
        assert_eq!(World::new(2, 2, &[], &[0], 0).unwrap_err(), WorldError::Types(0));
        assert_eq!(
            World::new(2, 2, &[4], &[0], 1).unwrap_err().to_string(),
            "an obstacle is in cell 4, and the grid has 4 cells"
        );
        assert_eq!(World::new(2, 2, &[0], &[0], 1).unwrap_err(), WorldError::BlockedExit(0));
        assert_eq!(World::new(2, 2, &[], &[], 1).unwrap_err(), WorldError::NoExit);
        assert_eq!(World::new(3, 1, &[1], &[0], 1).unwrap_err(), WorldError::Unreachable);
        assert_eq!(world().with_step_limit(0).unwrap_err(), WorldError::NoSteps);
    }

    #[test]
    fn states_outside_of_the_world_are_refused() {
        let world = world();
        let target = |cell, kind| [Target { cell, kind }];
        assert_eq!(world.state(6, &[]).unwrap_err(), StateError::Outside { cell: 6, cells: 6 });
        assert_eq!(world.state(1, &[]).unwrap_err(), StateError::InObstacle(1));
        assert_eq!(world.state(0, &target(9, 0)).unwrap_err(), StateError::TargetOutside { cell: 9, cells: 6 });
        assert_eq!(world.state(0, &target(1, 0)).unwrap_err(), StateError::TargetInObstacle(1));
        assert_eq!(world.state(0, &target(2, 0)).unwrap_err(), StateError::TargetOnExit(2));
        assert_eq!(world.state(0, &target(3, 2)).unwrap_err(), StateError::UnknownType { kind: 2, types: 2 });
        let twice = [Target { cell: 3, kind: 1 }; 2];
        assert_eq!(world.state(0, &twice).unwrap_err().to_string(), "cell 3 has two targets of type 1");
        assert_eq!(world.state(0, &[Target::default(); 33]).unwrap_err(), StateError::TooMany(33));
    }
}
