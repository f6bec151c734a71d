//! Predictions of a person who knows what it wants: it goes on shortest ways to the nearest target of the type it values most,
//! then to the next nearest of that type, then to those of the next type, and last to the nearest exit.
//!
//! Values decide the order of types and nothing else: a target of a better type is visited first however far it is, and no
//! target with a positive value is left out. Types whose value is 0 or less are neglected. Among equally near targets the one in
//! the cell with the lowest number is first, among equally short ways the one that begins north, then south, west, east.

use super::walk::{Choice, walk};
use super::{Limits, Observation, Occupancy, Prediction, Predictor};
use crate::grid::{Action, Cell, State, StateError, Target, World, distances};

/// Visits all targets of valued types, the most valued type first.
#[derive(Clone, PartialEq, Debug)]
pub struct GoalDirected {
    world: World,
    /// Types with positive values, the most valued first.
    order: Vec<u8>,
}

/// Reason why values cannot be used.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum GoalError {
    /// Not one value for each type.
    #[error("there are {values} values of targets, and the world has {types} types")]
    Types {
        /// Values.
        values: usize,
        /// Types.
        types: usize,
    },
    /// A value that is not finite.
    #[error("the value of targets of type {0} is not finite")]
    NotFinite(usize),
}

impl GoalDirected {
    /// A person with these values of the types. Equal values leave the lower type first.
    pub fn new(world: World, values: &[f64]) -> Result<GoalDirected, GoalError> {
        if values.len() != world.types() {
            return Err(GoalError::Types { values: values.len(), types: world.types() });
        }
        if let Some(kind) = values.iter().position(|value| !value.is_finite()) {
            return Err(GoalError::NotFinite(kind));
        }
        let mut order: Vec<u8> = (0..world.types() as u8).filter(|kind| values[usize::from(*kind)] > 0.0).collect();
        order.sort_by(|a, b| values[usize::from(*b)].total_cmp(&values[usize::from(*a)]));
        Ok(GoalDirected { world, order })
    }

    /// The target that the person goes to; `None` if only an exit is left. `to_here` are the steps to the person's cell.
    fn goal(&self, state: &State, to_here: &[Option<u32>]) -> Option<Target> {
        let nearest = |kind: u8| {
            let of_kind = state.targets().iter().filter(move |target| target.kind == kind);
            let reachable = of_kind.filter_map(|target| Some((to_here[usize::from(target.cell)]?, target)));
            reachable.min_by_key(|(steps, target)| (*steps, target.cell)).map(|(_, target)| *target)
        };
        self.order.iter().find_map(|kind| nearest(*kind))
    }

    fn action(&self, state: &State) -> Option<Action> {
        let to_here = distances(&self.world, &[state.cell()]);
        let Some(goal) = self.goal(state, &to_here) else {
            return self.towards(state.cell(), |cell| self.world.steps_to_exit(cell));
        };
        if goal.cell == state.cell() {
            return Some(Action::Collect);
        }
        let to_goal = distances(&self.world, &[goal.cell]);
        self.towards(state.cell(), |cell| if self.world.is_exit(cell) { None } else { to_goal[usize::from(cell)] })
    }

    /// The first move that shortens the way.
    fn towards(&self, cell: Cell, steps: impl Fn(Cell) -> Option<u32>) -> Option<Action> {
        let moves = Action::MOVES.into_iter();
        let reachable = moves.filter_map(|action| Some((steps(self.world.neighbour(cell, action)?)?, action)));
        reachable.min_by_key(|(steps, _)| *steps).map(|(_, action)| action)
    }
}

impl Predictor for GoalDirected {
    fn name(&self) -> &'static str {
        "goal_directed"
    }

    fn world(&self) -> &World {
        &self.world
    }

    fn predict(&self, from: &Observation, limits: &Limits) -> Result<Prediction, StateError> {
        self.world.check(&from.state)?;
        let choose = |state: &State| self.action(state).map(|action| Choice { action, probability: 1.0 });
        let walk = walk(&self.world, from.state, limits.steps, choose);
        let occupancy = Occupancy::along(&self.world, &walk, limits.samples);
        Ok(Prediction { steps: walk.steps, end: walk.end, occupancy })
    }
}

#[cfg(test)]
mod tests {
    use super::super::End;
    use super::*;

    fn predicted(predictor: &GoalDirected, cell: Cell, targets: &[Target]) -> Prediction {
        let state = predictor.world.state(cell, targets).unwrap();
        predictor.predict(&Observation { state, heading: None }, &Limits::default()).unwrap()
    }

    #[test]
    fn the_most_valued_type_is_visited_first() {
        let world = World::new(5, 1, &[], &[4], 2).unwrap();
        let targets = [Target { cell: 0, kind: 1 }, Target { cell: 2, kind: 0 }, Target { cell: 3, kind: 1 }];
        let b_first = GoalDirected::new(world.clone(), &[0.5, 1.0]).unwrap();
        let prediction = predicted(&b_first, 1, &targets);
        let order: Vec<Target> = prediction.collected().map(|collected| collected.target).collect();
        assert_eq!(order, [targets[0], targets[2], targets[1]]);
        assert_eq!(prediction.end, End::Exit);
        let only_a = GoalDirected::new(world.clone(), &[0.5, 0.0]).unwrap();
        let prediction = predicted(&only_a, 1, &targets);
        assert_eq!(prediction.waypoints().collect::<Vec<_>>(), [1, 2, 2, 3, 4]);
        assert_eq!(prediction.last().targets(), [targets[0], targets[2]]);
        assert!(prediction.occupancy.iter().all(|o| o.share == 1.0 && o.covariance == [[0.0; 2]; 2]));
        assert_eq!(GoalDirected::new(world.clone(), &[1.0]), Err(GoalError::Types { values: 1, types: 2 }));
        assert_eq!(GoalDirected::new(world, &[1.0, f64::NAN]), Err(GoalError::NotFinite(1)));
    }

    /// The exit stands between the person and a target: the way leads around it.
    #[test]
    fn ways_to_targets_avoid_exits() {
        let world = World::new(3, 2, &[], &[1], 1).unwrap();
        let prediction = predicted(&GoalDirected::new(world, &[1.0]).unwrap(), 0, &[Target { cell: 2, kind: 0 }]);
        assert_eq!(prediction.waypoints().collect::<Vec<_>>(), [0, 3, 4, 5, 2, 2, 1]);
    }

    #[test]
    fn unreachable_targets_and_exits_are_left_alone() {
        let world = World::new(5, 1, &[2], &[4], 1).unwrap();
        let predictor = GoalDirected::new(world, &[1.0]).unwrap();
        let target = [Target { cell: 0, kind: 0 }];
        assert_eq!(predicted(&predictor, 3, &target).waypoints().collect::<Vec<_>>(), [3, 4]);
        let enclosed = predicted(&predictor, 1, &target);
        assert_eq!((enclosed.end, enclosed.last().cell()), (End::Standing, 0));
    }
}
