//! Layers from precedences: each task is put into the first layer after all of its predecessors.

/// Returns the layer of each task, or the tasks of a cycle, each a predecessor of the previous one. `after` holds for
/// each task its predecessors, less than `after.len()`.
pub(super) fn layers(after: &[Vec<usize>]) -> Result<Vec<usize>, Vec<usize>> {
    let mut layer: Vec<Option<usize>> = vec![None; after.len()];
    let mut left = after.len();
    while left > 0 {
        let before = left;
        for task in 0..after.len() {
            if layer[task].is_none() {
                let least = after[task]
                    .iter()
                    .map(|other| layer[*other].map(|layer| layer + 1))
                    .try_fold(0, |a, b| b.map(|b| usize::max(a, b)));
                if let Some(least) = least {
                    layer[task] = Some(least);
                    left -= 1;
                }
            }
        }
        if left == before {
            return Err(circle(after, &layer));
        }
    }
    Ok(layer.into_iter().flatten().collect())
}

/// Finds a cycle: every task without a layer has a predecessor without a layer, and following these ends in a cycle.
fn circle(after: &[Vec<usize>], layer: &[Option<usize>]) -> Vec<usize> {
    let mut way: Vec<usize> = Vec::new();
    let mut at = (0..after.len()).find(|task| layer[*task].is_none());
    while let Some(task) = at {
        if let Some(start) = way.iter().position(|other| *other == task) {
            return way.split_off(start);
        }
        way.push(task);
        at = after[task].iter().copied().find(|other| layer[*other].is_none());
    }
    way
}

#[cfg(test)]
mod tests {
    use super::layers;

    #[test]
    fn the_first_layer_after_all_before() {
        assert_eq!(layers(&[vec![], vec![0], vec![], vec![1, 2], vec![2]]), Ok(vec![0, 1, 0, 2, 1]));
        assert_eq!(layers(&[vec![3], vec![0], vec![1], vec![]]), Ok(vec![1, 2, 3, 0]));
    }

    #[test]
    fn a_circle_is_named_without_what_leads_to_it() {
        assert_eq!(layers(&[vec![1], vec![2], vec![3], vec![1], vec![]]), Err(vec![1, 2, 3]));
        assert_eq!(layers(&[vec![0]]), Err(vec![0]));
    }
}
