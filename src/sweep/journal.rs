//! Finished runs on the disk until all are there: beside the file of the sweep, its head in the first line, then a run a
//! line. Only whole lines count, so that whatever ends the program leaves a journal that can be gone on with.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use files::Unopened;

use super::head::Head;
use super::row::Row;

/// Most bytes of a line.
const MAX_LINE: u64 = 64 << 20;

/// How every head begins.
const HEAD: &[u8] = b"{\"version\":";

/// The journal of a sweep that goes on.
pub struct Journal {
    file: File,
    path: PathBuf,
}

/// Where the journal of a sweep is that is written to a file.
pub fn path(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_os_string();
    name.push(".journal");
    PathBuf::from(name)
}

impl Journal {
    /// Begins a journal, or goes on with one: gives the runs that are in it.
    ///
    /// # Errors
    /// There is one and `resume` is not set, or it is that of another sweep, or of one that runs, or it cannot be written.
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

    /// Adds a run.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&mut self, row: &Row) -> Result<(), String> {
        self.line(&serde_json::to_string(row).map_err(|e| e.to_string())?)
    }

    fn line(&mut self, text: &str) -> Result<(), String> {
        // In one piece: a line is there, or its beginning, and never a part of another one.
        let whole = format!("{text}\n");
        self.file.write_all(whole.as_bytes()).map_err(|e| format!("cannot write {}: {e}", self.path.display()))
    }

    /// Ends the journal: all its runs are elsewhere now.
    ///
    /// # Errors
    /// It cannot be deleted.
    pub fn remove(self) -> Result<(), String> {
        files::remove(&self.path).map_err(|e| format!("cannot delete {}: {e}", self.path.display()))
    }
}

fn foreign(shown: &str) -> String {
    format!("{shown} is no journal of a sweep: move it away, or choose another `--out`")
}

/// The runs of a journal, each once, and how many of its bytes count.
fn read(file: &mut File, head: &Head, resume: bool, shown: &str) -> Result<(Vec<Row>, u64), String> {
    let failed = |e: std::io::Error| format!("cannot read {shown}: {e}");
    let mut input = BufReader::new(file);
    let (mut line, mut kept, mut rows) = (Vec::new(), 0_u64, Vec::new());
    loop {
        line.clear();
        let length = input.by_ref().take(MAX_LINE).read_until(b'\n', &mut line).map_err(failed)? as u64;
        if line.last() != Some(&b'\n') {
            // A line that was begun is written again. Without one that is whole it must be the begin of a head.
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
