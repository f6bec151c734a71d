//! Cells as run lengths: `12.3#40?` is 12 free cells, 3 occupied ones and 40 unknown ones.

use std::fmt::Write;

use super::grid::Cell;

fn sign(cell: Cell) -> char {
    match cell {
        Cell::Free => '.',
        Cell::Occupied => '#',
        Cell::Unknown => '?',
    }
}

/// Writes cells.
pub(super) fn written(cells: &[Cell]) -> String {
    let mut out = String::new();
    for run in cells.chunk_by(|a, b| a == b) {
        // Writing to a String does not fail.
        let _ = write!(out, "{}{}", run.len(), sign(run[0]));
    }
    out
}

/// Reads `count` cells. None: there are more or fewer, or the text is wrong.
pub(super) fn read(text: &str, count: usize) -> Option<Vec<Cell>> {
    let mut cells = Vec::with_capacity(count);
    let mut length = 0_usize;
    for c in text.chars() {
        let cell = match c {
            '0'..='9' => {
                length = length.checked_mul(10)?.checked_add(c.to_digit(10)? as usize)?;
                continue;
            }
            '.' => Cell::Free,
            '#' => Cell::Occupied,
            '?' => Cell::Unknown,
            _ => return None,
        };
        if length == 0 || length > count - cells.len() {
            return None;
        }
        cells.resize(cells.len() + std::mem::take(&mut length), cell);
    }
    (length == 0 && cells.len() == count).then_some(cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_read_as_they_were_written() {
        use Cell::{Free as F, Occupied as O, Unknown as U};
        let cells = [F, F, O, U, U, U, F];
        assert_eq!(written(&cells), "2.1#3?1.");
        assert_eq!(read("2.1#3?1.", 7).as_deref(), Some(&cells[..]));
        for wrong in ["2.1#3?", "2.1#3?2.", "2.1#3?1.0#", "2.1#3?1.4", "2.1#3?.", "7x", "", "99999999999999999999999."]
        {
            assert_eq!(read(wrong, 7), None, "{wrong}");
        }
    }
}
