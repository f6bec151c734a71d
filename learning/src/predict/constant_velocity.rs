//! Predictions of a person who keeps its direction, one cell at a time, until an exit, a wall or an obstacle. It collects
//! nothing. Without a direction it stands.

use super::walk::{Choice, walk};
use super::{Limits, Observation, Occupancy, Prediction, Predictor};
use crate::grid::{State, StateError, World};

/// Keeps the last direction.
#[derive(Clone, PartialEq, Debug)]
pub struct ConstantVelocity {
    world: World,
}

impl ConstantVelocity {
    /// Predicts in this world.
    pub fn new(world: World) -> ConstantVelocity {
        ConstantVelocity { world }
    }
}

impl Predictor for ConstantVelocity {
    fn name(&self) -> &'static str {
        "constant_velocity"
    }

    fn world(&self) -> &World {
        &self.world
    }

    fn predict(&self, from: &Observation, limits: &Limits) -> Result<Prediction, StateError> {
        self.world.check(&from.state)?;
        let choose = |state: &State| {
            let ahead = |heading: &_| self.world.neighbour(state.cell(), *heading).is_some();
            from.heading.filter(ahead).map(|action| Choice { action, probability: 1.0 })
        };
        let walk = walk(&self.world, from.state, limits.steps, choose);
        let occupancy = Occupancy::along(&self.world, &walk, limits.samples);
        Ok(Prediction { steps: walk.steps, end: walk.end, occupancy })
    }
}

#[cfg(test)]
mod tests {
    use super::super::End;
    use super::*;
    use crate::grid::Action;

    #[test]
    fn the_direction_is_kept_until_something_is_in_the_way() {
        let predictor = ConstantVelocity::new(World::new(4, 2, &[2], &[7], 1).unwrap());
        let predicted = |cell, heading| {
            let state = predictor.world.state(cell, &[]).unwrap();
            let prediction = predictor.predict(&Observation { state, heading }, &Limits::default()).unwrap();
            (prediction.waypoints().collect::<Vec<_>>(), prediction.end)
        };
        assert_eq!(predicted(0, Some(Action::East)), (vec![0, 1], End::Standing));
        assert_eq!(predicted(4, Some(Action::East)), (vec![4, 5, 6, 7], End::Exit));
        assert_eq!(predicted(4, Some(Action::North)), (vec![4], End::Standing));
        assert_eq!(predicted(4, Some(Action::Collect)), (vec![4], End::Standing));
        assert_eq!(predicted(4, None), (vec![4], End::Standing));
    }
}
