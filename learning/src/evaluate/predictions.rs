//! Accuracy of predictors: from each step of a person's way, the predicted way against the true one.

use super::{Estimate, bootstrap};
use crate::demonstrations::Trajectory;
use crate::grid::{Action, Cell, State, StateError, World};
use crate::predict::{Limits, Observation, Prediction, Predictor};

/// Figures of a predictor: means over ways, of means over their steps.
#[derive(Clone, PartialEq, Debug)]
pub struct Accuracy {
    /// Steps between the predicted and the true cell, along columns and rows, for each horizon. A person who has left stays on
    /// the exit.
    pub distances: Vec<Estimate>,
    /// Share of the remaining targets of which it is predicted rightly if the person still collects them; over the ways that
    /// have any.
    pub targets: Estimate,
    /// Share of the predictions that are cut before an exit.
    pub cut: Estimate,
}

/// Sums over the steps of a way.
struct Sums {
    distances: Vec<f64>,
    right: f64,
    targets: f64,
    cut: f64,
}

/// Compares predictions from each step of these ways with the rest of the way, at these numbers of steps ahead.
pub fn accuracy(
    predictor: &dyn Predictor,
    trajectories: &[Trajectory],
    horizons: &[usize],
    seed: u64,
) -> Result<Accuracy, StateError> {
    let ways = trajectories.iter().filter(|trajectory| !trajectory.actions.is_empty());
    let sums = ways.map(|way| one(predictor, way, horizons)).collect::<Result<Vec<_>, _>>()?;
    let estimate = |values: Vec<f64>| bootstrap(&values, seed);
    let ahead = |h: usize| estimate(sums.iter().map(|of| of.distances[h]).collect());
    let with_targets = sums.iter().filter(|of| of.targets > 0.0);
    Ok(Accuracy {
        distances: (0..horizons.len()).map(ahead).collect(),
        targets: estimate(with_targets.map(|of| of.right / of.targets).collect()),
        cut: estimate(sums.iter().map(|of| of.cut).collect()),
    })
}

fn one(predictor: &dyn Predictor, way: &Trajectory, horizons: &[usize]) -> Result<Sums, StateError> {
    let world = predictor.world();
    let limits = Limits { samples: 0, ..Limits::default() };
    let states: Vec<State> =
        [way.start].into_iter().chain(way.steps(world).map(|demonstrated| demonstrated.step.state)).collect();
    let end = &states[states.len() - 1];
    let n = way.actions.len() as f64;
    let mut sums = Sums { distances: vec![0.0; horizons.len()], right: 0.0, targets: 0.0, cut: 0.0 };
    let mut heading: Option<Action> = None;
    for (at, action) in way.actions.iter().enumerate() {
        let state = states[at];
        let prediction = predictor.predict(&Observation { state, heading }, &limits)?;
        for (sum, ahead) in sums.distances.iter_mut().zip(horizons) {
            let truth = states[(at + ahead).min(states.len() - 1)].cell();
            *sum += steps_between(world, cell_after(&prediction, *ahead), truth) / n;
        }
        for target in state.targets() {
            let expected = !prediction.last().targets().contains(target);
            sums.right += f64::from(u8::from(expected != end.targets().contains(target)));
            sums.targets += 1.0;
        }
        sums.cut += f64::from(u8::from(!prediction.reaches_exit())) / n;
        if *action != Action::Collect {
            heading = Some(*action);
        }
    }
    Ok(sums)
}

fn cell_after(prediction: &Prediction, ahead: usize) -> Cell {
    prediction.steps[ahead.min(prediction.steps.len() - 1)].state.cell()
}

fn steps_between(world: &World, a: Cell, b: Cell) -> f64 {
    (world.column(a).abs_diff(world.column(b)) + world.row(a).abs_diff(world.row(b))) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Target;
    use crate::predict::{ConstantVelocity, GoalDirected};

    /// A person who collects the first of two targets in a corridor, and leaves.
    #[test]
    fn accuracies_of_certain_predictors_are_known() {
        let world = World::new(5, 1, &[], &[4], 2).unwrap();
        let start = world.state(0, &[Target { cell: 1, kind: 0 }, Target { cell: 2, kind: 1 }]).unwrap();
        use Action::{Collect, East};
        let ways = [Trajectory { start, actions: vec![East, Collect, East, East, East] }];
        let of = |predictor: &dyn Predictor| accuracy(predictor, &ways, &[1, 3], 1).unwrap();
        let right = of(&GoalDirected::new(world.clone(), &[1.0, 0.0]).unwrap());
        assert_eq!(right.distances.iter().map(|d| d.mean).collect::<Vec<_>>(), [0.0, 0.0]);
        assert_eq!((right.targets.mean, right.cut.mean), (1.0, 0.0));
        // It stands at first, and then goes on past the target: cells 0, 2, 2, 3, 4 one step ahead where the truth is
        // 1, 1, 2, 3, 4, and 0, 4, 4, 4, 4 three steps ahead where it is 2, 3, 4, 4, 4.
        let straight = of(&ConstantVelocity::new(world.clone()));
        for (distance, expected) in straight.distances.iter().zip([0.4, 0.6]) {
            assert!((distance.mean - expected).abs() < 1e-12, "{straight:?}");
        }
        // Both targets are expected to be left. The first one is there in two states, the second one in all five.
        assert!((straight.targets.mean - 5.0 / 7.0).abs() < 1e-12);
        assert_eq!(straight.cut.mean, 0.2);
    }
}
