//! Records of a run: every tick as CSV, a summary, and thinned series for plots.

pub mod columns;
pub mod csv;
pub mod expectations;
pub mod held_back;
pub mod joint_motion;
mod remarks;
pub mod roster;
pub mod series;
pub mod signals;
pub mod slow_ticks;
mod summarise;
pub mod summary;
pub mod verify;

use crate::physics::PlantRecord;
use crate::tick::{Recorder, Tick};

/// Several recorders at once.
pub struct All<'a>(pub Vec<&'a mut dyn Recorder>);

impl Recorder for All<'_> {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.0.iter_mut().try_for_each(|r| r.tick(tick))
    }

    fn moved_by(&mut self, plant: &PlantRecord) {
        self.0.iter_mut().for_each(|r| r.moved_by(plant));
    }

    fn diverged(&mut self, why: &str) {
        self.0.iter_mut().for_each(|r| r.diverged(why));
    }
}
