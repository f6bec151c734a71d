//! Settings and figures of the checks at random postures.

use std::collections::BTreeMap;

/// Settings of the checks at sampled postures.
#[derive(Clone, Copy)]
pub struct Deep<'d> {
    /// Number of postures for each stack.
    pub postures: usize,
    /// Seed of the postures.
    pub seed: u64,
    /// Called now and then with the number of postures that have been examined, of all stacks, and with their total number.
    pub progress: &'d (dyn Fn(usize, usize) + Sync),
}

/// Figures of all stacks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// Seed of the postures.
    pub seed: u64,
    /// The stacks that run and move a joint.
    pub stacks: Vec<SampledStack>,
    /// Pairs of links that touch; `None` if the robot has no collision shapes.
    pub contacts: Option<Contacts>,
}

/// Pairs of links that touch at sampled postures and that no limit keeps apart, without neighbours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Number of pairs that touch at some postures, and are meant not to.
    pub unguarded: usize,
    /// Number of those that the robot's SRDF disables.
    pub disabled: usize,
    /// Those that touch at home, or at nearly all postures, by how their shapes are drawn.
    pub always: Vec<[String; 2]>,
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
