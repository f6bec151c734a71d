//! Figures of the sampled postures, beside the diagnostics.

use std::collections::BTreeMap;

/// Figures of all stacks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// Seed of the postures.
    pub seed: u64,
    /// The stacks that run and move a joint.
    pub stacks: Vec<SampledStack>,
    /// Pairs of links that touch at some postures and that no limit keeps apart; `None` if the robot has no collision
    /// shapes.
    pub touching: Option<usize>,
}

/// Figures of a stack.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledStack {
    /// Name of the stack.
    pub name: String,
    /// Number of postures inside all limits of hard levels.
    pub inside: usize,
    /// Number of these at which a hard level cannot be met by a robot at rest.
    pub infeasible: usize,
    /// True if the stack needs signals, whose values are unknown, so that nothing was sampled.
    pub needs_signals: bool,
    /// Freedom at each level.
    pub freedom: Vec<Freedom>,
}

/// Freedom of a level: the degrees of freedom that locks and the targets of the levels above leave.
#[derive(Clone, Debug, PartialEq)]
pub struct Freedom {
    /// Name of the level.
    pub level: String,
    /// Number of postures by the freedom there.
    pub counts: BTreeMap<usize, usize>,
}

impl Freedom {
    /// The smallest freedom of a share of the postures, from 0 to 1: the minimum, the median for 0.5. `None` without
    /// postures.
    pub fn quantile(&self, share: f64) -> Option<usize> {
        let total: usize = self.counts.values().sum();
        let wanted = (share * total as f64).ceil().max(1.0) as usize;
        let mut seen = 0;
        self.counts
            .iter()
            .find(|(_, count)| {
                seen += **count;
                seen >= wanted
            })
            .map(|(freedom, _)| *freedom)
    }
}

/// Formats a share in percent, never rounded to none or all.
pub(super) fn share(part: usize, of: usize) -> String {
    let percent = 100.0 * part as f64 / of.max(1) as f64;
    match () {
        () if part == of => "all".to_string(),
        () if percent < 0.1 => format!("{part} of {of}"),
        () if percent > 99.9 => format!("all but {} of {of}", of - part),
        () => format!("{percent:.1} %"),
    }
}
