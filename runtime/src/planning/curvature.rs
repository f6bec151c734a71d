//! Curvature of a safety field, estimated as in [`crate::evaluator`] for the rows of tasks.

use robot::{Data, Model};
use stdlib_tasks::field::Field;

use crate::sampling::{SAMPLES, SEED, Spread};

/// Estimates the curvature of a safety field with each degree of freedom over a time `horizon`, as for the rows of
/// tasks.
pub(crate) fn curvature_of_field(field: &mut Field, model: &Model, locked: &[usize], horizon: f64) -> Vec<f64> {
    let (mut data, mut spread) = (Data::new(model), Spread(SEED));
    let mut most = vec![0.0_f64; model.nv()];
    for _ in 0..SAMPLES {
        let q = model.random_configuration(&mut || spread.next());
        model.forward(&q, &mut data);
        most.iter_mut().zip(field.levers(model, &data)).for_each(|(most, lever)| *most = most.max(lever));
    }
    locked.iter().for_each(|&dof| most[dof] = 0.0);
    most.iter().map(|a| horizon * most.iter().map(|b| a.min(*b)).sum::<f64>()).collect()
}
