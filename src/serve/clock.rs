//! The clock of a mission: it runs as fast as asked, and can be stopped.

use std::time::{Duration, Instant};

/// Mission time as a function of real time.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// What it showed when it was set (s).
    shown: f64,
    /// Since when it runs; none: it stands.
    since: Option<Instant>,
    /// Seconds of the mission in a second.
    speed: f64,
}

impl Clock {
    /// Stands at this time (s), and will run with this speed.
    pub fn standing(time: f64, speed: f64) -> Clock {
        Clock { shown: time, since: None, speed }
    }

    /// What it shows at an instant (s).
    pub fn at(&self, instant: Instant) -> f64 {
        let run = self.since.map_or(Duration::ZERO, |since| instant.saturating_duration_since(since));
        self.shown + self.speed * run.as_secs_f64()
    }

    /// Lets it run or stops it.
    pub fn set(&mut self, runs: bool, instant: Instant) {
        self.shown = self.at(instant);
        self.since = runs.then_some(instant);
    }

    /// True while it runs.
    pub fn runs(&self) -> bool {
        self.since.is_some()
    }

    /// Seconds of the mission in a second.
    pub fn speed(&self) -> f64 {
        self.speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_stands_runs_and_stands_again() {
        let start = Instant::now();
        let after = |seconds: u64| start + Duration::from_secs(seconds);
        let mut clock = Clock::standing(100.0, 10.0);
        assert_eq!(clock.at(after(5)), 100.0);
        clock.set(true, after(5));
        assert_eq!(clock.at(after(7)), 120.0);
        clock.set(true, after(7));
        clock.set(false, after(8));
        assert_eq!((clock.at(after(60)), clock.runs()), (130.0, false));
    }
}
