//! The world of the paper's experiments, as far as its text describes it: 7 x 7 m, four obstacles and an exit (Section 4). Their
//! places are in a figure; those here were chosen. Each cell is a square of 1 m, and all free cells are connected.

use crate::grid::World;

/// Rows of the world from the top: `#` is an obstacle, `E` the exit.
const ROWS: [&str; 7] = [
    "......E", //
    ".##..#.", //
    ".....#.", //
    "..#....", //
    "..#..#.", //
    ".....#.", //
    ".......",
];

/// The world: 49 cells, four obstacles of two cells each, the exit in the upper right corner, types A and B.
pub fn world() -> World {
    let cells = |mark: u8| {
        let marked = |cell: &usize| ROWS[6 - cell / 7].as_bytes()[cell % 7] == mark;
        (0..49).filter(marked).collect::<Vec<_>>()
    };
    World::new(7, 7, &cells(b'#'), &cells(b'E'), 2).expect("the exit can be reached")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_free_cells_are_connected() {
        let world = world();
        assert_eq!((world.obstacles().count(), world.open_cells().count()), (8, 49 - 8 - 1));
        assert_eq!(world.exits().collect::<Vec<_>>(), [48]);
        // The corner opposite the exit.
        assert_eq!(world.steps_to_exit(0), Some(12));
    }
}
