//! Random environments of the paper's Appendix A: `n_t ~ U(0, 4)` targets, of them `n_B ~ U(0, n_t)` of type B, in distinct
//! cells, and a start that is uniform over the remaining cells. Obstacles and exits are those of the world.
//!
//! The numbers are taken as whole numbers with both ends included. Their means are then 1 target of each type, less than the
//! 1.09 targets of type B that Table B3 says were collected: the paper's environments must have had more, and it does not say
//! how many. `least` and `most` set other numbers.

use super::{Cell, MAX_TARGETS, State, Target, World};
use crate::random::{Pcg64, below};

/// Distribution of starts: number of targets and their types.
#[derive(Clone, PartialEq, Debug)]
pub struct Environments {
    world: World,
    least: usize,
    most: usize,
    open: Vec<Cell>,
}

/// Reason why environments cannot be drawn.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum EnvironmentsError {
    /// Bounds in the wrong order.
    #[error("at least {least} and at most {most} targets")]
    Order {
        /// Least number.
        least: usize,
        /// Greatest number.
        most: usize,
    },
    /// No room for targets and a start.
    #[error("up to {most} targets and the person need {} cells, and {open} are free and have a way to an exit", most + 1)]
    Room {
        /// Greatest number of targets.
        most: usize,
        /// Cells for them.
        open: usize,
    },
    /// More targets than a state holds.
    #[error("up to {0} targets, and a state holds at most {MAX_TARGETS}")]
    TooMany(usize),
}

impl Environments {
    /// Environments with `least` to `most` targets; 0 to 4 in the paper.
    pub fn new(world: &World, least: usize, most: usize) -> Result<Environments, EnvironmentsError> {
        let open: Vec<Cell> = world.open_cells().collect();
        if least > most {
            return Err(EnvironmentsError::Order { least, most });
        }
        if most > MAX_TARGETS {
            return Err(EnvironmentsError::TooMany(most));
        }
        if most + 1 > open.len() {
            return Err(EnvironmentsError::Room { most, open: open.len() });
        }
        Ok(Environments { world: world.clone(), least, most, open })
    }

    /// The world in which environments are drawn.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Least number of targets.
    pub fn least(&self) -> usize {
        self.least
    }

    /// Greatest number of targets.
    pub fn most(&self) -> usize {
        self.most
    }

    /// Draws the start of an episode.
    pub fn draw(&self, generator: &mut Pcg64) -> State {
        let count = self.least + below(generator, self.most - self.least + 1);
        // The first `count` cells of a partial shuffle are the targets, the next one the start.
        let mut cells = self.open.clone();
        for at in 0..=count {
            let other = at + below(generator, cells.len() - at);
            cells.swap(at, other);
        }
        let mut targets = Vec::with_capacity(count);
        let mut left = count;
        for kind in (0..self.world.types()).rev() {
            // The last type first, as in the paper; the first type has what is left.
            let of_kind = if kind == 0 { left } else { below(generator, left + 1) };
            for _ in 0..of_kind {
                targets.push(Target { cell: cells[targets.len()], kind: kind as u8 });
            }
            left -= of_kind;
        }
        State::of_checked(cells[count], &targets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::stream;

    #[test]
    fn environments_have_the_distribution_of_the_paper() {
        let world = World::new(5, 4, &[7, 12], &[4], 2).unwrap();
        let environments = Environments::new(&world, 0, 4).unwrap();
        let mut generator = stream(5, "test", &[]);
        let mut sums = [0.0; 2];
        let mut starts = [0_u32; 20];
        for _ in 0..20_000 {
            let state = environments.draw(&mut generator);
            world.check(&state).unwrap();
            assert!(state.target_here().is_none());
            for target in state.targets() {
                sums[usize::from(target.kind)] += 1.0 / 20_000.0;
            }
            starts[usize::from(state.cell())] += 1;
        }
        // Both means are 1; their standard deviation is below 0.01.
        assert!(sums.iter().all(|mean| (mean - 1.0_f64).abs() < 0.04), "{sums:?}");
        for cell in world.open_cells() {
            // 20,000 / 17 starts, six standard deviations.
            let count = f64::from(starts[usize::from(cell)]);
            assert!((count - 1_176.5).abs() < 200.0, "{cell}: {count}");
        }
        assert_eq!(starts.iter().filter(|count| **count > 0).count(), 17);
    }

    #[test]
    fn environments_without_room_are_refused() {
        let world = World::new(3, 1, &[], &[0], 1).unwrap();
        assert!(Environments::new(&world, 0, 1).is_ok());
        assert_eq!(Environments::new(&world, 0, 2).unwrap_err(), EnvironmentsError::Room { most: 2, open: 2 });
        assert_eq!(Environments::new(&world, 2, 1).unwrap_err(), EnvironmentsError::Order { least: 2, most: 1 });
        assert_eq!(Environments::new(&world, 0, 40).unwrap_err(), EnvironmentsError::TooMany(40));
    }
}
