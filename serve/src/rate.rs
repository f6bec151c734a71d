//! Rate limits of requests: a token bucket.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// A token bucket.
#[derive(Debug)]
pub struct Bucket {
    most: f64,
    /// Tokens per second.
    rate: f64,
    now: Mutex<(f64, Instant)>,
}

impl Bucket {
    /// Creates a full bucket for `most` tokens, refilled with `rate` tokens per second.
    pub fn new(most: f64, rate: f64) -> Bucket {
        Bucket { most, rate, now: Mutex::new((most, Instant::now())) }
    }

    /// Limit for the requests of one page: 30 at once, then 5 per second.
    pub fn of_a_session() -> Bucket {
        Bucket::new(30.0, 5.0)
    }

    /// Limit for invalid links of all visitors together: 20 at once, then 1 per second.
    pub fn of_links() -> Bucket {
        Bucket::new(20.0, 1.0)
    }

    /// Takes a token; returns false if there is none.
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
