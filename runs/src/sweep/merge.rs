//! Merges the shards of a sweep to the result of the whole.

use std::path::PathBuf;

use super::head::Head;
use super::row::Row;
use super::table;

/// Reads the parts of a sweep and sorts their runs.
///
/// # Errors
/// A file cannot be read; the files belong to different sweeps; a run is duplicate or missing.
pub fn merge(files: &[PathBuf]) -> Result<(Head, Vec<Row>), String> {
    let mut whole: Option<(Head, String)> = None;
    let mut all: Vec<(Row, usize)> = Vec::new();
    for (i, path) in files.iter().enumerate() {
        let shown = path.display().to_string();
        let (head, rows) = table::read(path)?;
        let head = head.whole();
        match &whole {
            Some((first, known)) => {
                if let Some(why) = head.differs(first) {
                    return Err(format!("`{known}` and `{shown}` are not parts of one sweep, {why}"));
                }
            }
            None => whole = Some((head, shown)),
        }
        all.extend(rows.into_iter().map(|row| (row, i)));
    }
    let Some((head, _)) = whole else { return Err("no files to merge".to_string()) };
    all.sort_by_key(|(row, _)| row.run);
    if let Some([a, b]) = all.windows(2).find(|w| matches!(w, [a, b] if a.0.run == b.0.run)) {
        let name = |i: usize| files.get(i).map_or_else(String::new, |p| p.display().to_string());
        return Err(format!("run {} is both in `{}` and in `{}`", a.0.run, name(a.1), name(b.1)));
    }
    let rows: Vec<Row> = all.into_iter().map(|(row, _)| row).collect();
    let missing = (0..head.runs).find(|&run| rows.get(run as usize).is_none_or(|r| r.run != run));
    match missing {
        Some(run) => {
            let count = head.runs.saturating_sub(rows.len() as u64);
            Err(format!("{count} of {} runs are missing, the first of them is run {run}: give all shards", head.runs))
        }
        None if rows.len() as u64 > head.runs => {
            Err(format!("there are more than the {} runs of the sweep", head.runs))
        }
        None => Ok((head, rows)),
    }
}
