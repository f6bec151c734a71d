//! True durations of tasks, and the expected end of a late one.

use crate::random::{normal_above, stream};

/// The least duration, as a share of the planned one.
const LEAST: f64 = 0.01;
/// Least further time that a late task is expected to take, as a share of its time over the planned one.
const LONGER: f64 = 0.1;
/// And no less than this longer (s).
const SOON: f64 = 0.1;
/// And, as a share of the time, no less than what a time can tell apart.
const STILL: f64 = 1e-9;

/// The duration of a task, relative to the planned one: normal with mean 1 and deviation `spread`, cut off below. It depends
/// on the seed, the names, and how often the task was tried before.
pub(super) fn sampled(seed: u64, agent: &str, task: &str, tries: usize, spread: f64) -> f64 {
    let mut generator = stream(seed, &["task", agent, task, &tries.to_string()]);
    normal_above(&mut generator, 1.0, spread, LEAST)
}

/// By how much longer (s) is waited at this time (s) for something that has taken `elapsed` (s).
pub(super) fn longer(elapsed: f64, time: f64) -> f64 {
    (LONGER * elapsed).max(SOON).max(STILL * time.abs())
}

/// The same for somebody who was waited for in vain for `waited` (s), to begin.
pub(super) fn patience(waited: f64, time: f64) -> f64 {
    (2.0 * LONGER * waited).max(10.0 * SOON).max(STILL * time.abs())
}
