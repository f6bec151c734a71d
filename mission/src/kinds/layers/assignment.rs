//! Minimum-cost assignment of rows to columns, each column at most once: the Hungarian method with potentials, with
//! rows added one after the other, on sparse cost lists.

/// Working memory of the method, kept between calls.
#[derive(Clone, Debug, Default)]
pub(super) struct Assignment {
    row_potential: Vec<f64>,
    column_potential: Vec<f64>,
    row_of: Vec<usize>,
    least: Vec<f64>,
    from: Vec<usize>,
    used: Vec<bool>,
    touched: Vec<usize>,
    /// Column of each row, the result of [`Assignment::solve`].
    pub columns: Vec<usize>,
}

const NONE: usize = usize::MAX;

impl Assignment {
    /// Returns the minimum sum of costs; `None` if some row gets no column. `rows` holds the permitted columns of each
    /// row, less than `count`, with their finite costs.
    pub fn solve(&mut self, rows: &[Vec<(usize, f64)>], count: usize) -> Option<f64> {
        self.row_potential.clear();
        self.row_potential.resize(rows.len(), 0.0);
        self.column_potential.clear();
        self.column_potential.resize(count, 0.0);
        self.row_of.clear();
        self.row_of.resize(count, NONE);
        self.least.clear();
        self.least.resize(count, f64::INFINITY);
        self.from.clear();
        self.from.resize(count, NONE);
        self.used.clear();
        self.used.resize(count, false);
        for row in 0..rows.len() {
            if !self.insert(rows, row) {
                return None;
            }
        }
        self.columns.clear();
        self.columns.resize(rows.len(), NONE);
        for (column, row) in self.row_of.iter().enumerate().filter(|(_, row)| **row != NONE) {
            self.columns[*row] = column;
        }
        let cost = |(row, column): (usize, &usize)| {
            rows[row].iter().find(|(other, _)| other == column).map_or(f64::INFINITY, |(_, cost)| *cost)
        };
        Some(self.columns.iter().enumerate().map(cost).sum())
    }

    /// Finds the cheapest augmenting path from a new row; returns false if there is none.
    fn insert(&mut self, rows: &[Vec<(usize, f64)>], new: usize) -> bool {
        let mut row = new;
        let mut by = NONE;
        let end = loop {
            for &(column, cost) in &rows[row] {
                if self.used[column] {
                    continue;
                }
                let reduced = cost - self.row_potential[row] - self.column_potential[column];
                if self.least[column] == f64::INFINITY {
                    self.touched.push(column);
                }
                if reduced < self.least[column] {
                    self.least[column] = reduced;
                    self.from[column] = by;
                }
            }
            let mut best = NONE;
            let mut delta = f64::INFINITY;
            for &column in &self.touched {
                if !self.used[column] && self.least[column] < delta {
                    (best, delta) = (column, self.least[column]);
                }
            }
            if best == NONE {
                break NONE;
            }
            self.row_potential[new] += delta;
            for &column in &self.touched {
                if self.used[column] {
                    self.row_potential[self.row_of[column]] += delta;
                    self.column_potential[column] -= delta;
                } else {
                    self.least[column] -= delta;
                }
            }
            self.used[best] = true;
            by = best;
            if self.row_of[best] == NONE {
                break best;
            }
            row = self.row_of[best];
        };
        let mut at = end;
        while at != NONE {
            let before = self.from[at];
            self.row_of[at] = if before == NONE { new } else { self.row_of[before] };
            at = before;
        }
        for &column in &self.touched {
            self.least[column] = f64::INFINITY;
            self.used[column] = false;
        }
        self.touched.clear();
        end != NONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Minimum cost by enumeration.
    fn brute(rows: &[Vec<(usize, f64)>], used: &mut Vec<usize>) -> f64 {
        let Some(row) = rows.get(used.len()) else { return 0.0 };
        let mut best = f64::INFINITY;
        for &(column, cost) in row {
            if !used.contains(&column) {
                used.push(column);
                best = best.min(cost + brute(rows, used));
                used.pop();
            }
        }
        best
    }

    proptest! {
        #[test]
        fn it_is_the_cheapest(costs in prop::collection::vec(prop::collection::vec(prop::option::of(-5_i32..20), 6), 1..6)) {
            let some = |(column, cost): (usize, &Option<i32>)| cost.map(|cost| (column, f64::from(cost)));
            let rows: Vec<Vec<(usize, f64)>> =
                costs.iter().map(|row| row.iter().enumerate().filter_map(some).collect()).collect();
            let mut assignment = Assignment::default();
            let best = brute(&rows, &mut Vec::new());
            for _ in 0..2 {
                match assignment.solve(&rows, 6) {
                    Some(cost) => prop_assert!((cost - best).abs() < 1e-9, "{} is not {}", cost, best),
                    None => prop_assert_eq!(best, f64::INFINITY),
                }
            }
        }
    }
}
