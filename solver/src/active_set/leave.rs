//! Rows that leave the working set because their multiplier has the wrong sign, or move to the stage below because it
//! is zero.

use super::search::{Search, Stopped};
use super::working_set::Entry;
use crate::problem::Problem;

/// Number of times that a row may move to a lower stage in one solve, in addition to once for each, before it stays.
const RETURNS: usize = 8;

impl Search {
    /// Makes the working set valid for its relaxed problem: rows with a negative multiplier leave it, and rows without
    /// a multiplier move to the stage below, where they may be needed.
    ///
    /// Returns true if anything changed.
    pub(super) fn settle(&mut self, problem: &Problem) -> Result<bool, Stopped> {
        let mut changed = false;
        while let Some((s, keep)) = self.first_idle() {
            self.count()?;
            self.relaxed.rewind(s, keep);
            self.relaxed.complete(problem);
            self.relaxed.accept(s);
            changed = true;
        }
        Ok(changed)
    }

    /// Frees or lowers the idle rows of the first stage that has any. Returns the stage and the number of its active rows
    /// that the frame may keep.
    pub(super) fn first_idle(&mut self) -> Option<(usize, usize)> {
        for s in 0..=self.relaxed.levels {
            let mut keep = self.relaxed.working_set.active[s].len();
            let mut changed = false;
            for j in (0..self.relaxed.working_set.active[s].len()).rev() {
                let e = self.relaxed.working_set.active[s][j];
                if e.value <= e.noise && self.retire(e, s) {
                    // A row that moves to a lower stage stays in the working set.
                    let side = self.relaxed.rows.side[self.relaxed.rows.at(e.level, e.row)];
                    self.relaxed.release(s, j);
                    let at = self.relaxed.rows.at(e.level, e.row);
                    self.relaxed.rows.side[at] = side;
                    keep = if s < self.relaxed.levels { j } else { keep - 1 };
                    changed = true;
                }
            }
            if s < self.relaxed.levels {
                for j in (0..self.relaxed.working_set.own[s].len()).rev() {
                    let e = self.relaxed.working_set.own[s][j];
                    if e.value <= e.noise && self.retire(e, s) {
                        self.relaxed.working_set.own[s].remove(j);
                        changed = true;
                        keep = keep.min(self.relaxed.working_set.active[s].len());
                    }
                }
            }
            if changed {
                return Some((s, keep));
            }
        }
        None
    }

    /// Frees an idle row of stage `s`, or moves it to the stage below; returns false if it has to stay.
    fn retire(&mut self, e: Entry, s: usize) -> bool {
        let at = self.relaxed.rows.at(e.level, e.row);
        if usize::from(self.returns[at]) >= RETURNS + self.relaxed.levels && e.value >= -e.noise {
            return false;
        }
        self.returns[at] = self.returns[at].saturating_add(1);
        if e.value >= -e.noise && s < self.relaxed.levels {
            self.relaxed.working_set.active[s + 1].push(Entry::new(e.level, e.row, e.side));
        } else {
            self.relaxed.rows.side[at] = 0;
        }
        true
    }

    /// Returns the first multiplier from stage `s` on that reaches zero on the way to the trial multipliers: stage,
    /// true for a violated row of that level, index in its list, fraction of the way. `added` marks a row that is being
    /// added: the last of the violated rows of `s` (true) or of its active ones (false). It is skipped, because its
    /// multiplier rises.
    pub(super) fn first_to_leave(&self, s: usize, added: Option<bool>) -> Option<(usize, bool, usize, f64)> {
        let mut first = None;
        let mut least = f64::INFINITY;
        for stage in s..=self.relaxed.levels {
            let violated = if stage < self.relaxed.levels { &self.relaxed.working_set.own[stage][..] } else { &[] };
            for (is_own, list) in [(true, violated), (false, &self.relaxed.working_set.active[stage][..])] {
                let added = usize::from(stage == s && added == Some(is_own));
                for (j, e) in list[..list.len() - added].iter().enumerate() {
                    if e.trial < -e.noise {
                        let part = e.value.max(0.0) / (e.value.max(0.0) - e.trial);
                        if part < least {
                            least = part;
                            first = Some((stage, is_own, j, part));
                        }
                    }
                }
            }
        }
        first
    }

    /// Moves the multipliers from stage `s` on by the fraction `part` towards the trial multipliers.
    pub(super) fn go_part(&mut self, s: usize, part: f64) {
        let own = self.relaxed.working_set.own[s.min(self.relaxed.levels)..].iter_mut();
        for e in own.chain(&mut self.relaxed.working_set.active[s..]).flatten() {
            e.value += part * (e.trial - e.value);
        }
    }
}
