//! Clock of a mission, with adjustable speed; it can be stopped.

use std::time::{Duration, Instant};

/// Mission time as a function of real time.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// Mission time when it was last set (s).
    shown: f64,
    /// Instant since which it runs; `None`: it is stopped.
    since: Option<Instant>,
    /// Mission seconds per real second.
    speed: f64,
}

impl Clock {
    /// Creates a stopped clock with this time (s) and speed.
    pub fn stopped(time: f64, speed: f64) -> Clock {
        Clock { shown: time, since: None, speed }
    }

    /// Returns the mission time at an instant (s).
    pub fn at(&self, instant: Instant) -> f64 {
        let run = self.since.map_or(Duration::ZERO, |since| instant.saturating_duration_since(since));
        self.shown + self.speed * run.as_secs_f64()
    }

    /// Starts or stops the clock.
    pub fn set(&mut self, runs: bool, instant: Instant) {
        self.shown = self.at(instant);
        self.since = runs.then_some(instant);
    }

    /// Returns true while it runs.
    pub fn runs(&self) -> bool {
        self.since.is_some()
    }

    /// Returns the mission seconds per real second.
    pub fn speed(&self) -> f64 {
        self.speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_is_stopped_runs_and_is_stopped_again() {
        let start = Instant::now();
        let after = |seconds: u64| start + Duration::from_secs(seconds);
        let mut clock = Clock::stopped(100.0, 10.0);
        assert_eq!(clock.at(after(5)), 100.0);
        clock.set(true, after(5));
        assert_eq!(clock.at(after(7)), 120.0);
        clock.set(true, after(7));
        clock.set(false, after(8));
        assert_eq!((clock.at(after(60)), clock.runs()), (130.0, false));
    }
}
