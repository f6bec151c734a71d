//! How often somebody may ask: a bucket that fills with time and gives one portion for each request.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// A bucket of portions.
#[derive(Debug)]
pub struct Bucket {
    most: f64,
    /// Portions a second.
    rate: f64,
    now: Mutex<(f64, Instant)>,
}

impl Bucket {
    /// Full, with room for `most`, filled with `rate` a second.
    pub fn new(most: f64, rate: f64) -> Bucket {
        Bucket { most, rate, now: Mutex::new((most, Instant::now())) }
    }

    /// For what one page asks: 30 at once, then 5 a second.
    pub fn of_a_session() -> Bucket {
        Bucket::new(30.0, 5.0)
    }

    /// For links that do not open, of all people together: 20 at once, then 1 a second.
    pub fn of_links() -> Bucket {
        Bucket::new(20.0, 1.0)
    }

    /// Takes a portion; false if there is none.
    pub fn take(&self) -> bool {
        self.take_at(Instant::now())
    }

    fn take_at(&self, instant: Instant) -> bool {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let since = instant.saturating_duration_since(now.1).as_secs_f64();
        let filled = (now.0 + self.rate * since).min(self.most);
        let enough = filled >= 1.0;
        *now = (if enough { filled - 1.0 } else { filled }, instant.max(now.1));
        enough
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_bucket_gives_what_it_holds_and_what_comes_in() {
        let bucket = Bucket::new(3.0, 2.0);
        let start = Instant::now();
        let taken = |after: u64, times: usize| {
            (0..times).filter(|_| bucket.take_at(start + Duration::from_millis(after))).count()
        };
        assert_eq!(taken(0, 10), 3);
        assert_eq!(taken(400, 10), 0);
        assert_eq!(taken(1000, 10), 2);
        assert_eq!(taken(60_000, 10), 3);
    }
}
