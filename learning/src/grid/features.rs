//! Inputs of networks. They begin with the feature maps (6): position, one map for each type of target, obstacles, exit, each
//! with one input for each cell. Behind them, each type has a map of its targets relative to the person.
//!
//! The relative maps repeat what the others say. The paper does not describe its networks; those of its source (Peschl et al.,
//! 2022) are convolutional, and treat a target to the east alike everywhere. A network of dense layers has to learn that cell
//! by cell: without relative maps, the synthetic person of the paper collects a third of what it collects with them.
//!
//! Nearly all inputs are 0, so that a state is the list of inputs that are 1.

use super::{State, World};

impl World {
    /// Feature maps (6): position, one for each type, obstacles, exit.
    pub fn maps(&self) -> usize {
        self.types() + 3
    }

    /// Inputs of a network: the cells of the feature maps, and of a map of twice the size for each type.
    pub fn inputs(&self) -> usize {
        self.maps() * self.cells() + self.types() * self.offsets()
    }

    /// Differences between two cells.
    fn offsets(&self) -> usize {
        (2 * self.columns() - 1) * (2 * self.rows() - 1)
    }

    /// Replaces `active` by the inputs that are 1 in a state of this world. Input `map * cells + cell` is a cell of a feature
    /// map; then come the relative maps, row by row, with the person in their middle.
    pub fn features(&self, state: &State, active: &mut Vec<u32>) {
        let at = |map: usize, cell: u16| (map * self.cells()) as u32 + u32::from(cell);
        active.clear();
        active.push(at(0, state.cell()));
        active.extend(state.targets().iter().map(|target| at(1 + usize::from(target.kind), target.cell)));
        active.extend(self.obstacles().map(|cell| at(1 + self.types(), cell)));
        active.extend(self.exits().map(|cell| at(2 + self.types(), cell)));
        let (column, row) = (self.column(state.cell()), self.row(state.cell()));
        active.extend(state.targets().iter().map(|target| {
            let east = self.column(target.cell) + self.columns() - 1 - column;
            let north = self.row(target.cell) + self.rows() - 1 - row;
            let map = self.maps() * self.cells() + usize::from(target.kind) * self.offsets();
            (map + north * (2 * self.columns() - 1) + east) as u32
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::super::Target;
    use super::*;

    #[test]
    fn each_map_has_its_range_of_inputs() {
        let world = World::new(3, 2, &[1], &[2], 2).unwrap();
        let state = world.state(4, &[Target { cell: 5, kind: 1 }, Target { cell: 0, kind: 0 }]).unwrap();
        let mut active = Vec::new();
        world.features(&state, &mut active);
        // Five maps of 6 cells, then two of 5 x 3, whose middle is cell 7.
        assert_eq!(world.inputs(), 30 + 30);
        assert_eq!(active, [4, 6, 12 + 5, 18 + 1, 24 + 2, 30 + 1, 45 + 8]);
    }
}
