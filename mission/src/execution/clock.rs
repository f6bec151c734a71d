//! The loop of a discrete-event simulation.

/// A world in which steps happen by themselves.
pub trait DiscreteEvents {
    /// A step that happens by itself. Of steps at the same time the least comes first.
    type Step: Copy + Ord;

    /// Present time (s).
    fn now(&self) -> f64;

    /// Moves the clock.
    fn set_time(&mut self, time: f64);

    /// Every step that is due, each with its time (s). A time in the past stands for the present. `ticks`: with the periodic
    /// ones.
    fn due(&self, ticks: bool) -> Vec<(f64, Self::Step)>;

    /// Lets a step happen at the present time.
    fn perform(&mut self, step: Self::Step);

    /// The next step and its time (s), not before the present.
    fn upcoming(&self, ticks: bool) -> Option<(f64, Self::Step)> {
        let due = self.due(ticks).into_iter().map(|(time, step)| (time.max(self.now()), step));
        due.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }

    /// Lets time pass until `to` (s), step by step. A time before the present, or no finite number, lets nothing pass.
    fn run_until(&mut self, to: f64) {
        if !to.is_finite() || to < self.now() {
            return;
        }
        while let Some((time, step)) = self.upcoming(true).filter(|(time, _)| *time <= to) {
            self.set_time(time);
            self.perform(step);
        }
        self.set_time(to);
    }
}
