//! Models of the person over the grid of a problem: a trained policy, or one of the simple predictors beside it.

use learning::grid::{Action, Cell, State, Target, World};
use learning::policy::{Policy, most_likely};
use learning::predict::{ConstantVelocity, End, GoalDirected, Learned, Limits, Observation, Prediction, Predictor};

use super::foresight::Covariance;
use super::grid::Grid;
use super::problem::{Model, Problem};

/// A model, ready to be asked.
pub(super) struct Mind {
    world: World,
    /// Targets as the model knows them: none for one that nobody can collect there.
    targets: Vec<Option<Target>>,
    predictor: Box<dyn Predictor>,
    /// The policy of which actions are drawn, if the model is one.
    policy: Option<Box<Policy>>,
}

impl std::fmt::Debug for Mind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Mind").field("targets", &self.targets).finish_non_exhaustive()
    }
}

/// An action as it is expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Expected {
    /// The cell in which it ends.
    pub cell: usize,
    /// The target that it takes.
    pub takes: Option<usize>,
}

/// The way that a model expects.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Walk {
    /// Its actions.
    pub steps: Vec<Expected>,
    /// It leads to the exit.
    pub arrives: bool,
    /// Covariances of column and row at the begin and after the actions, as far as they are known.
    pub spread: Vec<Covariance>,
}

/// Ways that are drawn for the spread of a prediction.
const SAMPLES: usize = 100;

/// The world of the models for a problem with this number of types of targets.
///
/// # Errors
/// The grid cannot be one of theirs.
pub(super) fn world(grid: &Grid, types: usize) -> Result<World, String> {
    let obstacles: Vec<usize> = (0..grid.count()).filter(|cell| grid.blocked[*cell]).collect();
    let exits: Vec<usize> = grid.exits().collect();
    World::new(grid.columns, grid.rows, &obstacles, &exits, types).map_err(|why| why.to_string())
}

impl Mind {
    /// Makes a model ready for a problem.
    ///
    /// # Errors
    /// The file of a policy cannot be read, or is of another grid.
    pub fn new(problem: &Problem, grid: &Grid, model: &Model) -> Result<Mind, String> {
        let used = problem.targets.iter().map(|target| target.of + 1).max().unwrap_or(1);
        let policy = match model {
            Model::Policy(file) => Some(Policy::from_bytes(&file.bytes).map_err(|why| why.to_string())?),
            Model::GoalDirected { .. } | Model::ConstantVelocity => None,
        };
        let types = policy.as_ref().map_or(used, |policy| policy.world().types());
        if types < used {
            return Err(format!("the policy knows {types} types of targets, and this mission has {used}"));
        }
        let world = world(grid, types)?;
        let predictor: Box<dyn Predictor> = match (&policy, model) {
            (Some(policy), _) => {
                policy.check(&world).map_err(|why| why.to_string())?;
                Box::new(Learned::new(policy.clone()))
            }
            (None, Model::GoalDirected { values }) => {
                let values: Vec<f64> = (0..types).map(|of| values.get(of).copied().unwrap_or(1.0)).collect();
                Box::new(GoalDirected::new(world.clone(), &values).map_err(|why| why.to_string())?)
            }
            (None, _) => Box::new(ConstantVelocity::new(world.clone())),
        };
        let mut targets: Vec<Option<Target>> = Vec::new();
        for target in &problem.targets {
            let cell = grid.at(target.shape.middle()).filter(|cell| !grid.blocked[*cell] && !grid.exit[*cell]);
            let known = cell.map(|cell| Target { cell: cell as Cell, kind: target.of as u8 });
            // Models know one target of a type in a cell.
            targets.push(known.filter(|known| !targets.contains(&Some(*known))));
        }
        Ok(Mind { world, targets, predictor, policy: policy.map(Box::new) })
    }

    fn state(&self, cell: usize, open: &[bool]) -> Option<State> {
        let targets = self.targets.iter().zip(open).filter(|(_, open)| **open).filter_map(|(target, _)| *target);
        self.world.state(cell as Cell, &targets.collect::<Vec<Target>>()).ok()
    }

    /// The target that is taken in a cell.
    pub fn target_in(&self, cell: usize, open: &[bool]) -> Option<usize> {
        let here = |of: &Target| usize::from(of.cell) == cell;
        let targets = self.targets.iter().enumerate().filter_map(|(index, target)| {
            let target = target.filter(|target| open[index] && here(target))?;
            Some((target.kind, index))
        });
        // The least type is taken first, as in the worlds of the models.
        targets.min().map(|(_, index)| index)
    }

    /// The next action: the most likely one, or the one that a number between 0 and 1 draws.
    pub fn action(&self, cell: usize, open: &[bool], last: Option<Action>, draw: Option<f64>) -> Action {
        let Some(state) = self.state(cell, open) else { return Action::Collect };
        if let (Some(policy), Some(draw)) = (&self.policy, draw) {
            let probabilities = policy.probabilities(&state);
            let mut sum = 0.0;
            let drawn = Action::ALL.into_iter().find(|action| {
                sum += probabilities[action.index()];
                draw < sum
            });
            return drawn.unwrap_or_else(|| most_likely(&probabilities));
        }
        let found = self.predict(state, last, 1, 0);
        // A person with nowhere to go stands.
        found.and_then(|found| found.steps.first().and_then(|step| step.action)).unwrap_or(Action::Collect)
    }

    fn predict(&self, state: State, heading: Option<Action>, most: usize, samples: usize) -> Option<Prediction> {
        let limits = Limits { steps: most, samples, seed: 0 };
        self.predictor.predict(&Observation { state, heading }, &limits).ok()
    }

    /// The most likely actions, up to the exit or to this number.
    ///
    /// Algorithm 1 never ends where the most likely actions lead in a circle. People do not walk in circles for ever: there the way goes on
    /// to the nearest exit.
    pub fn walk(&self, cell: usize, open: &[bool], last: Option<Action>, most: usize) -> Walk {
        let state = self.state(cell, open);
        let Some(found) = state.and_then(|state| self.predict(state, last, most, SAMPLES)) else {
            return Walk::default();
        };
        let mut open = open.to_vec();
        let expected = found.steps.windows(2).map(|two| {
            let at = usize::from(two[0].state.cell());
            let takes = (two[0].action == Some(Action::Collect)).then(|| self.target_in(at, &open)).flatten();
            if let Some(target) = takes {
                open[target] = false;
            }
            Expected { cell: usize::from(two[1].state.cell()), takes }
        });
        let mut steps: Vec<Expected> = expected.collect();
        let draws = self.policy.is_some();
        let spread = found.occupancy.iter().filter(|_| draws).map(|of| of.covariance).collect();
        if !matches!(found.end, End::Loop { .. }) {
            return Walk { steps, arrives: found.reaches_exit(), spread };
        }
        let mut cell = found.last().cell();
        while let Some(left) = self.world.steps_to_exit(cell).filter(|left| *left > 0 && steps.len() < most) {
            let beside = Action::MOVES.into_iter().filter_map(|action| self.world.neighbour(cell, action));
            let nearer = |next: &Cell| self.world.steps_to_exit(*next).is_some_and(|steps| steps < left);
            let Some(next) = beside.into_iter().find(nearer) else { break };
            cell = next;
            steps.push(Expected { cell: usize::from(cell), takes: None });
        }
        Walk { steps, arrives: self.world.is_exit(cell), spread }
    }
}
