//! The working set: for every level the rows that it violates, and for every stage (the levels, then the nearest point)
//! the rows of higher levels that hold it back.

use super::rows::Rows;
use crate::feasible_set::Kind;

/// A row in the working set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) level: usize,
    pub(crate) row: usize,
    /// The bound: +1 upper, -1 lower.
    pub(crate) side: f64,
    /// Multiplier at its stage, >= 0: of an active row scaled to norm one, of a violated row without scaling (weight times
    /// slack).
    pub(crate) value: f64,
    /// Multiplier in the current trial, any sign.
    pub(crate) trial: f64,
    /// Threshold below which the multiplier is rounding.
    pub(crate) noise: f64,
}

impl Entry {
    pub(crate) fn new(level: usize, row: usize, side: f64) -> Self {
        Entry { level, row, side, value: 0.0, trial: 0.0, noise: 0.0 }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct WorkingSet {
    /// Per level: the rows that it violates.
    pub(crate) own: Vec<Vec<Entry>>,
    /// Per stage: rows of higher levels that are held at their bound against it, in the order of the frame. The last
    /// stage is the nearest point.
    pub(crate) active: Vec<Vec<Entry>>,
    /// Per level: its equality rows.
    pub(crate) equal: Vec<Vec<usize>>,
}

impl WorkingSet {
    /// Creates storage for levels of these sizes. A row is in at most one list, but may be in any of them.
    pub(crate) fn new(rows: &[usize]) -> Self {
        let all = rows.iter().sum();
        WorkingSet {
            own: rows.iter().map(|m| Vec::with_capacity(*m)).collect(),
            active: (0..=rows.len()).map(|_| Vec::with_capacity(all)).collect(),
            equal: rows.iter().map(|m| Vec::with_capacity(*m)).collect(),
        }
    }

    /// Returns the number of rows in the working set, without equalities.
    pub(crate) fn count(&self) -> usize {
        self.own.iter().chain(&self.active).map(Vec::len).sum()
    }

    /// Removes all rows from the working set.
    pub(crate) fn clear(&mut self, rows: &mut Rows) {
        self.own.iter_mut().chain(&mut self.active).for_each(Vec::clear);
        rows.side.fill(0);
    }

    /// Reads the equality rows of the first `levels` levels, and removes from the working set the rows that this tick
    /// does not have: rows that are no longer inequalities, bounds that no longer exist.
    pub(crate) fn adopt(&mut self, problem: &crate::Problem, rows: &mut Rows, levels: usize) {
        for (l, equal) in self.equal.iter_mut().enumerate().take(levels) {
            equal.clear();
            for (i, kind) in rows.kind[rows.first[l]..rows.first[l + 1]].iter().enumerate() {
                if *kind == Kind::Equality {
                    equal.push(i);
                }
            }
        }
        rows.side.fill(0);
        // Rows held at stages beyond the last one are held at the last one.
        for s in levels + 1..self.active.len() {
            let (kept, beyond) = self.active.split_at_mut(s);
            kept[levels].append(&mut beyond[0]);
        }
        for list in self.own.iter_mut().chain(&mut self.active) {
            list.retain(|e| {
                let at = rows.at(e.level, e.row);
                let level = &problem.levels[e.level];
                let bound = if e.side > 0.0 { level.upper[e.row] } else { level.lower[e.row] };
                let stays = e.level < levels && rows.kind[at] == Kind::Inequality && bound.is_finite();
                if stays {
                    rows.side[at] = if e.side > 0.0 { 1 } else { -1 };
                }
                stays
            });
        }
    }
}
