//! True durations of operations, and the expected end of a late one.

use crate::kinds::schedule::duration_quantile::quantile;
use crate::kinds::schedule::problem::Duration;
use crate::random::{normal_above, stream};

/// The least duration, as a share of the mean.
const LEAST: f64 = 0.01;
/// An operation that is late is expected to take at least this share of what it has taken longer.
const LONGER: f64 = 0.1;
/// And no less than this longer (s).
const SOON: f64 = 1e-3;

/// The duration of this operation (s): normal, cut off below.
pub(super) fn sampled(seed: u64, agent: &str, operation: usize, duration: Duration) -> f64 {
    let mut generator = stream(seed, &["duration", agent, &operation.to_string()]);
    normal_above(&mut generator, duration.mean, duration.sigma, LEAST * duration.mean)
}

/// Expected end (s after its start) of an operation that has taken `elapsed` (s): it ends by then with probability
/// `confidence`, given that it has not ended yet. `late` is the number of times that it was late.
pub(super) fn expected(duration: Duration, confidence: f64, late: usize, elapsed: f64) -> f64 {
    // After n failures of an event of this confidence, what is left is (1 - confidence)^(n + 1).
    let left = (1.0 - confidence).powi(i32::try_from(late).unwrap_or(i32::MAX).saturating_add(1));
    let by_chance = if left > 1e-12 { quantile(duration, 1.0 - left) } else { 0.0 };
    by_chance.max(elapsed + (LONGER * elapsed.max(duration.mean)).max(SOON))
}
