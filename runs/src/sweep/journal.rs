//! Journal of finished runs, until all are complete: a file beside that of the sweep with its head in the first line,
//! then one run per line. Only complete lines count, so an interrupted program always leaves a journal that can be
//! resumed.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use files::Unopened;

use super::head::Head;
use super::row::Row;

/// Maximum length of a line (bytes).
const MAX_LINE: u64 = 64 << 20;

/// Start of every head.
const HEAD: &[u8] = b"{\"version\":";

/// Journal of a sweep in progress.
pub struct Journal {
    file: File,
    path: PathBuf,
}

/// Path of the journal for the file of a sweep.
pub fn path(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_os_string();
    name.push(".journal");
    PathBuf::from(name)
}

impl Journal {
    /// Creates or resumes a journal, and returns the runs in it.
    ///
    /// # Errors
    /// A journal exists and `resume` is not set, or it belongs to another sweep or to a running one, or it cannot be
    /// written.
    pub fn open(out: &Path, head: &Head, resume: bool) -> Result<(Journal, Vec<Row>), String> {
        let path = path(out);
        let shown = path.display().to_string();
        let failed = |e: std::io::Error| format!("cannot write {shown}: {e}");
        let mut file = files::journal(&path).map_err(|why| match why {
            Unopened::Locked => format!("another sweep is writing {}", out.display()),
            Unopened::Io(e) => failed(e),
        })?;
        let (rows, kept) = read(&mut file, head, resume, &shown)?;
        file.set_len(kept).and_then(|()| file.seek(SeekFrom::End(0))).map_err(failed)?;
        let mut journal = Journal { file, path };
        if kept == 0 {
            journal.line(&serde_json::to_string(head).map_err(|e| e.to_string())?)?;
        }
        Ok((journal, rows))
    }

    /// Appends a run.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, row: &Row) -> Result<(), String> {
        self.line(&serde_json::to_string(row).map_err(|e| e.to_string())?)
    }

    fn line(&mut self, text: &str) -> Result<(), String> {
        // A single write, so that an interruption leaves at most an incomplete last line.
        let whole = format!("{text}\n");
        self.file.write_all(whole.as_bytes()).map_err(|e| format!("cannot write {}: {e}", self.path.display()))
    }

    /// Deletes the journal, after all its runs are stored elsewhere.
    ///
    /// # Errors
    /// The file cannot be deleted.
    pub fn remove(self) -> Result<(), String> {
        files::remove(&self.path).map_err(|e| format!("cannot delete {}: {e}", self.path.display()))
    }
}

fn foreign(shown: &str) -> String {
    format!("{shown} is no journal of a sweep: move it away, or choose another `--out`")
}

/// Reads the runs of a journal, without duplicates, and returns them with the length of its complete lines (bytes).
fn read(file: &mut File, head: &Head, resume: bool, shown: &str) -> Result<(Vec<Row>, u64), String> {
    let failed = |e: std::io::Error| format!("cannot read {shown}: {e}");
    let mut input = BufReader::new(file);
    let (mut line, mut kept, mut rows) = (Vec::new(), 0_u64, Vec::new());
    loop {
        line.clear();
        let length = input.by_ref().take(MAX_LINE).read_until(b'\n', &mut line).map_err(failed)? as u64;
        if line.last() != Some(&b'\n') {
            // An incomplete line is dropped and written again. As the first line, it must be the start of a head.
            let begun = line.starts_with(HEAD) || HEAD.starts_with(&line);
            if length == MAX_LINE || (kept == 0 && !begun) {
                return Err(foreign(shown));
            }
            break;
        }
        if kept == 0 {
            let begun: Head = serde_json::from_slice(&line).map_err(|_| foreign(shown))?;
            if let Some(why) = head.differs(&begun) {
                return Err(format!("{shown} belongs to another sweep, {why}; delete it to begin again"));
            }
        } else {
            let row: Row = serde_json::from_slice(&line)
                .map_err(|e| format!("{shown} is damaged, {e}: delete it to begin again"))?;
            rows.push(row);
        }
        kept += length;
    }
    if kept > 0 && !resume {
        let count = rows.len();
        return Err(format!(
            "{shown} holds {count} finished runs of this sweep: `--resume` goes on with it, deleting it begins again"
        ));
    }
    rows.sort_by_key(|r| r.run);
    rows.dedup_by_key(|r| r.run);
    Ok((rows, kept))
}
