//! Matching of tasks to objects: a maximum matching and, if it leaves tasks out, the tasks that need more objects than
//! there are (Hall's theorem).

/// A maximum matching of rows to columns, each column at most once (augmenting paths).
pub struct Matching {
    /// Column of each row.
    pub columns: Vec<Option<usize>>,
    /// Row of each column.
    rows: Vec<Option<usize>>,
}

/// A set of rows that together have fewer columns than rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shortage {
    /// The rows, ascending.
    pub rows: Vec<usize>,
    /// All columns of these rows, ascending.
    pub columns: Vec<usize>,
}

impl Matching {
    /// Computes a maximum matching; `candidates` holds the permitted columns of each row, less than `count`.
    pub fn new(candidates: &[Vec<usize>], count: usize) -> Matching {
        let mut matching = Matching { columns: vec![None; candidates.len()], rows: vec![None; count] };
        for row in 0..candidates.len() {
            matching.augment(candidates, row);
        }
        matching
    }

    /// Searches alternating paths from an unmatched row. Returns their rows and, by column, the row from which it was
    /// reached; and the unmatched column at the end of one, if there is one.
    fn search(&self, candidates: &[Vec<usize>], from: usize) -> (Vec<usize>, Vec<Option<usize>>, Option<usize>) {
        let mut parent: Vec<Option<usize>> = vec![None; self.rows.len()];
        let mut queue = vec![from];
        let mut next = 0;
        while let Some(&row) = queue.get(next) {
            next += 1;
            for &column in &candidates[row] {
                if parent[column].is_some() {
                    continue;
                }
                parent[column] = Some(row);
                match self.rows[column] {
                    None => return (queue, parent, Some(column)),
                    Some(other) => queue.push(other),
                }
            }
        }
        (queue, parent, None)
    }

    fn augment(&mut self, candidates: &[Vec<usize>], from: usize) {
        let (_, parent, end) = self.search(candidates, from);
        let mut at = end;
        while let Some(column) = at {
            let Some(row) = parent[column] else { break };
            at = self.columns[row];
            self.columns[row] = Some(column);
            self.rows[column] = Some(row);
            if row == from {
                break;
            }
        }
    }

    /// Returns the reasons for unmatched rows: for each such row the rows that compete with it, each set once.
    pub fn shortages(&self, candidates: &[Vec<usize>]) -> Vec<Shortage> {
        let mut shortages: Vec<Shortage> = Vec::new();
        for row in (0..candidates.len()).filter(|row| self.columns[*row].is_none()) {
            let (mut rows, parent, _) = self.search(candidates, row);
            rows.sort_unstable();
            let columns: Vec<usize> = (0..self.rows.len()).filter(|column| parent[*column].is_some()).collect();
            // Rows that compete for the same columns form one shortage.
            match shortages.iter_mut().find(|other| other.columns == columns && !columns.is_empty()) {
                Some(other) => {
                    other.rows.extend(rows);
                    other.rows.sort_unstable();
                    other.rows.dedup();
                }
                None => shortages.push(Shortage { rows, columns }),
            }
        }
        shortages
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_augmented() {
        let candidates = vec![vec![0], vec![0, 1], vec![1, 2]];
        let matching = Matching::new(&candidates, 3);
        assert_eq!(matching.columns, vec![Some(0), Some(1), Some(2)]);
        assert_eq!(matching.shortages(&candidates), Vec::new());
    }

    #[test]
    fn who_competes_is_named_once() {
        let candidates = vec![vec![0, 1], vec![2], vec![0, 1], vec![0, 1], vec![0, 1]];
        let shortages = Matching::new(&candidates, 3).shortages(&candidates);
        assert_eq!(shortages, vec![Shortage { rows: vec![0, 2, 3, 4], columns: vec![0, 1] }]);
    }
}
