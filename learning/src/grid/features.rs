//! Feature maps (6): position, one map for each type of target, obstacles, exit, each with one input for each cell. Nearly all
//! inputs are 0, so that a state is the list of inputs that are 1.

use super::{State, World};

impl World {
    /// Feature maps: position, one for each type, obstacles, exit.
    pub fn maps(&self) -> usize {
        self.types() + 3
    }

    /// Inputs of a network: the cells of all maps.
    pub fn inputs(&self) -> usize {
        self.maps() * self.cells()
    }

    /// Replaces `active` by the inputs that are 1 in a state of this world. Input `map * cells + cell` is a cell of a map.
    pub fn features(&self, state: &State, active: &mut Vec<u32>) {
        let at = |map: usize, cell: u16| (map * self.cells()) as u32 + u32::from(cell);
        active.clear();
        active.push(at(0, state.cell()));
        active.extend(state.targets().iter().map(|target| at(1 + usize::from(target.kind), target.cell)));
        active.extend(self.obstacles().map(|cell| at(1 + self.types(), cell)));
        active.extend(self.exits().map(|cell| at(2 + self.types(), cell)));
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
        assert_eq!(world.inputs(), 30);
        assert_eq!(active, [4, 6, 12 + 5, 18 + 1, 24 + 2]);
    }
}
