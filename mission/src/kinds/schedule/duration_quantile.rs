//! Planned duration of an operation, thesis (5.12c): the quantile of its distribution at the required probability.
//!
//! `delta = phi + sqrt(2) sigma erf^-1(2 pr - 1)`, the quantile of a normal distribution. The thesis prints an
//! inequality, which would let a planner stretch an operation to shorten the computed wait after it; so it is an
//! equality here.

use super::problem::{Duration, Problem};
use crate::random::normal_quantile;

/// Returns the planned duration of an operation of this agent, `delta_{a,min}^o` (s); 0 if the agent does not exist.
pub fn nominal(problem: &Problem, agent: usize) -> f64 {
    problem.agents.get(agent).map_or(0.0, |who| quantile(who.duration, problem.confidence))
}

/// Computes the time (s) within which an operation of this duration ends with probability `confidence`, between 0 and
/// 1.
pub fn quantile(duration: Duration, confidence: f64) -> f64 {
    if duration.sigma == 0.0 { duration.mean } else { duration.mean + duration.sigma * normal_quantile(confidence) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duration_without_spread_is_its_mean() {
        assert_eq!(quantile(Duration { mean: 97.0, sigma: 0.0 }, 0.9), 97.0);
        assert!((quantile(Duration { mean: 204.0, sigma: 20.4 }, 0.9) - 230.143_651_937_109_85).abs() < 1e-9);
    }
}
