//! Regions of states: parts of a state that are active beside each other, each in a state of its own, and the stacks that
//! run together.

use super::{MachineProgram, MergedStack};

/// Text between the states of regions that are active beside each other.
pub const BESIDE: &str = " | ";

/// Largest number of stacks that are merged of those of regions.
pub const MAX_MERGED: usize = 64;

impl MachineProgram {
    /// Innermost states that are entered together with a state: one, or one for each region inside it.
    pub fn leaves(&self, state: usize) -> Vec<usize> {
        let spine = self.spine(self.leaf(state));
        let regions = &self.states[spine].regions;
        // The state may be in a region itself, and is then one of these.
        let chosen = self.region(state).filter(|r| regions.contains(r));
        let of = |r: &usize| if chosen == Some(*r) { self.leaf(state) } else { self.leaf(*r) };
        if regions.is_empty() { vec![spine] } else { regions.iter().map(of).collect() }
    }

    /// Returns true if any state has regions.
    pub fn has_regions(&self) -> bool {
        self.states.iter().any(|s| !s.regions.is_empty())
    }

    /// Region that a state is, or in which it is.
    pub fn region(&self, state: usize) -> Option<usize> {
        let mut inner = state;
        for outer in self.path(state).skip(1) {
            if !self.states[outer].regions.is_empty() {
                return Some(inner);
            }
            inner = outer;
        }
        None
    }

    /// Returns true if two states are in different regions of the same state, so that both can be active.
    pub fn are_beside(&self, a: usize, b: usize) -> bool {
        let regions = self.region(a).zip(self.region(b));
        regions.is_some_and(|(a, b)| a != b && self.states[a].parent == self.states[b].parent)
    }

    /// The state itself, or the state around the regions of which one contains it.
    pub fn spine(&self, state: usize) -> usize {
        self.region(state).and_then(|r| self.states[r].parent).unwrap_or(state)
    }

    /// Returns true if a region has ended in an innermost state: it, or a state around it in the region, is final.
    pub fn region_ends(&self, leaf: usize) -> bool {
        let around = self.region(leaf).and_then(|r| self.states[r].parent);
        self.path(leaf).take_while(|&s| Some(s) != around).any(|s| self.states[s].is_final)
    }

    /// Describes the innermost states that are active together: `work.left.reach | work.right.wait`.
    pub fn describe(&self, leaves: &[usize]) -> String {
        leaves.iter().map(|&s| self.states[s].name.as_str()).collect::<Vec<_>>().join(BESIDE)
    }

    /// State in a region whose stack the region adds while it is in a state; `None` if it adds none.
    pub fn region_owner(&self, state: usize) -> Option<usize> {
        let around = self.region(state).and_then(|r| self.states[r].parent)?;
        self.path(state).take_while(|&s| s != around).find(|&s| self.states[s].stack.is_some())
    }

    /// States whose stacks run together in a state, in the order of their regions. In a region, the others are in their
    /// initial states.
    pub fn owners(&self, state: usize) -> Vec<usize> {
        let own = self.region(state);
        let around = own.and_then(|r| self.states[r].parent);
        let regions = around.map_or(&[][..], |p| &self.states[p].regions);
        let of = |&r: &usize| self.region_owner(if own == Some(r) { state } else { self.leaf(r) });
        let owners: Vec<usize> = regions.iter().filter_map(of).collect();
        if !owners.is_empty() {
            return owners;
        }
        self.path(around.unwrap_or(state)).find(|&s| self.states[s].stack.is_some()).into_iter().collect()
    }

    /// Stack that runs while the stacks of these states do; `None` for no state.
    pub fn stack_of(&self, owners: &[usize]) -> Option<usize> {
        match owners {
            [] => None,
            [one] => self.states[*one].stack,
            _ => {
                let is = |m: &&MergedStack| {
                    owners.iter().map(|&o| self.states[o].stack).eq(m.parts.iter().map(|&p| Some(p)))
                };
                self.merged.iter().find(is).map(|m| m.stack)
            }
        }
    }

    /// Stacks that the machine can enter; a stack may be listed more than once.
    pub fn stacks(&self) -> Vec<usize> {
        let alone = |s: &usize| match self.region(*s) {
            None => true,
            Some(region) => {
                let regions = self.states[region].parent.map_or(&[][..], |p| &self.states[p].regions);
                regions.iter().filter(|r| **r != region).all(|r| self.may_idle(*r))
            }
        };
        let own = (0..self.states.len()).filter(alone).filter_map(|s| self.states[s].stack);
        own.chain(self.merged.iter().map(|m| m.stack)).collect()
    }

    /// Returns true if a region can be in a state in which it adds no stack.
    pub fn may_idle(&self, region: usize) -> bool {
        let inside =
            (0..self.states.len()).filter(|&s| self.region(s) == Some(region) && self.states[s].initial.is_none());
        inside.into_iter().any(|s| self.region_owner(s).is_none())
    }

    /// Stacks that may run in an innermost state: with regions, one for each combination with what the others add.
    pub fn stacks_in(&self, leaf: usize) -> Vec<usize> {
        let Some(region) = self.region(leaf) else { return self.stack(leaf).into_iter().collect() };
        let around = self.states[region].parent.unwrap_or(0);
        let with = |owners: &Vec<usize>| match self.region_owner(leaf) {
            Some(own) => owners.iter().any(|&o| self.states[o].stack == self.states[own].stack),
            None => owners.iter().all(|&o| self.region(o) != Some(region)),
        };
        let all = self.combinations(around);
        let mut stacks: Vec<usize> =
            all.iter().filter(|o| with(o)).filter_map(|o| self.stack_around(around, o)).collect();
        stacks.sort_unstable();
        stacks.dedup();
        stacks
    }

    /// States that name a stack, or the stacks of which it was merged.
    pub fn naming(&self, stack: usize) -> Vec<usize> {
        let merged = self.merged.iter().find(|m| m.stack == stack);
        let names = |s: &usize| match merged {
            Some(m) => self.region(*s).is_some() && self.states[*s].stack.is_some_and(|k| m.parts.contains(&k)),
            None => self.states[*s].stack == Some(stack),
        };
        (0..self.states.len()).filter(names).collect()
    }

    /// Stack that runs while regions of a state add those of `owners`: that of the state itself, or of one around it, if
    /// they add none.
    fn stack_around(&self, state: usize, owners: &[usize]) -> Option<usize> {
        if owners.is_empty() { self.stack(state) } else { self.stack_of(owners) }
    }

    /// Stacks that a region can add, each by a state that names it; `None` if it can add none.
    fn choices(&self, region: usize) -> Vec<Option<usize>> {
        let mut out: Vec<Option<usize>> = Vec::new();
        let stack = |owner: Option<usize>| owner.and_then(|o| self.states[o].stack);
        for leaf in
            (0..self.states.len()).filter(|&s| self.states[s].initial.is_none() && self.region(s) == Some(region))
        {
            let owner = self.region_owner(leaf);
            if !out.iter().any(|o| stack(*o) == stack(owner)) {
                out.push(owner);
            }
        }
        out
    }

    /// Number of combinations of the stacks of a state's regions in which at least two regions add one.
    pub fn count_merged(&self, state: usize) -> usize {
        let mut several = 0_usize;
        // Combinations of the regions so far in which none or one adds a stack.
        let (mut none, mut one) = (1_usize, 0_usize);
        for region in &self.states[state].regions {
            let of = self.choices(*region);
            let idle = usize::from(of.contains(&None));
            let some = of.len() - idle;
            several = several.saturating_mul(of.len()).saturating_add(one.saturating_mul(some));
            one = one.saturating_mul(idle).saturating_add(none.saturating_mul(some));
            none *= idle;
        }
        several
    }

    /// Combinations of the stacks that the regions of a state add: the states that name them, in the order of the regions,
    /// each pair of stacks once. Their number may be large; see [`MachineProgram::count_merged`].
    pub fn combinations(&self, state: usize) -> Vec<Vec<usize>> {
        self.states[state].regions.iter().fold(vec![Vec::new()], |all, region| {
            let choices = self.choices(*region);
            let longer = |owners: &Vec<usize>| {
                let with = |owner: &Option<usize>| owners.iter().copied().chain(*owner).collect::<Vec<usize>>();
                choices.iter().map(with).collect::<Vec<_>>()
            };
            all.iter().flat_map(longer).collect()
        })
    }

    /// Returns true if the machine can be in a state in which no stack runs.
    pub fn may_stand(&self) -> bool {
        let idle = |s: usize| {
            let regions = &self.states[s].regions;
            !regions.is_empty() && regions.iter().all(|r| self.may_idle(*r)) && self.owners(s).is_empty()
        };
        (0..self.states.len()).any(|s| self.stack(self.leaf(s)).is_none() || idle(s))
    }

    /// State whose stack runs in a state; of several, that of its own region, or else the first.
    pub fn owner(&self, state: usize) -> Option<usize> {
        self.region_owner(state).or_else(|| self.owners(state).first().copied())
    }

    /// Stack that runs in a state.
    pub fn stack(&self, state: usize) -> Option<usize> {
        self.stack_of(&self.owners(state))
    }
}
