//! Journal: a file with all requests that had an effect, from which a mission is restored after a crash.
//!
//! One JSON object per line. The first line holds the mission's name and digest; each further one a mission time and an
//! entry. A request is written and synced to the disk before it has any effect; if that fails, it has none. Since a
//! mission is a function of its problem and of the requests with their times, replaying the lines restores the same
//! state. A request is the kind's own JSON, as it came from a page.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use files::Unopened;
use mission::kind::pages::Request;
use runtime::program::MAX_MISSION;
use serde::{Deserialize, Serialize};

use super::lines::Lines;

/// Maximum size of a journal for reading and writing (bytes).
const LARGEST: u64 = 256 << 20;

/// Entry of a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Entry {
    /// A request.
    Request(Request),
    /// A heartbeat with the number of log entries of the execution.
    Records(usize),
}

/// A line after the first one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Mission time (s).
    pub time: f64,
    /// The entry.
    pub entry: Entry,
}

/// Format of the file.
const FORMAT: u32 = 2;

/// The part of the first line that all formats have.
#[derive(Deserialize)]
struct Format {
    journal: u32,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    journal: u32,
    mission: String,
    digest: String,
}

/// A journal that is open for writing.
#[derive(Debug)]
pub struct Journal {
    lines: Lines,
    path: PathBuf,
    /// Time of the last line (s).
    time: f64,
}

/// Reason why a journal cannot be used.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum NoJournal {
    #[error("cannot use the journal `{}`: {why}", .path.display())]
    File { path: PathBuf, why: std::io::Error },
    #[error("another server writes the journal `{}`", .path.display())]
    Locked { path: PathBuf },
    #[error("cannot use the journal `{}`: it is no regular file; name one, or a file that does not exist yet", .path.display())]
    Irregular { path: PathBuf },
    #[error("the journal `{}` has no room for more: one of more than 256 MiB could not be read again", .path.display())]
    Full { path: PathBuf },
    #[error(
        "the journal `{}` takes no line of {time} s: one before {since} s, or after {MAX_MISSION} s, could not be read again",
        .path.display()
    )]
    Time { path: PathBuf, time: f64, since: f64 },
    #[error("the journal `{}` has more than 256 MiB; name a file that does not exist yet", .path.display())]
    Large { path: PathBuf },
    #[error(
        "the journal `{}` has format {format}, and this version of hierarq reads and writes format {FORMAT}; continue it with the \
         version that began it, or name a file that does not exist yet",
        .path.display()
    )]
    Format { path: PathBuf, format: u32 },
    #[error("`{}` is no journal of a mission; name a file that does not exist yet", .path.display())]
    Foreign { path: PathBuf },
    #[error(
        "the journal `{}` is of another mission, or of `{mission}` as it was before the spec or an option changed; name a file \
         that does not exist yet, or serve what the journal was begun with",
        .path.display()
    )]
    Other { path: PathBuf, mission: String },
    #[error(
        "line {line} of the journal `{}` cannot be used: {why}; go on without that line and all below, in a copy, or name a file \
         that does not exist yet",
        .path.display()
    )]
    Broken { path: PathBuf, line: usize, why: String },
}

impl Journal {
    /// Opens or creates a journal; returns it with its lines so far. An incomplete last line is removed.
    ///
    /// # Errors
    ///
    /// The file cannot be used, or belongs to another mission or program.
    pub fn open(path: &Path, mission: &str, digest: &str) -> Result<(Journal, Vec<Line>), NoJournal> {
        let no = |why| NoJournal::File { path: path.into(), why };
        let existed = path.exists();
        let mut file = files::journal(path).map_err(|why| match why {
            Unopened::Locked => NoJournal::Locked { path: path.into() },
            Unopened::Io(e) if matches!(e.kind(), ErrorKind::IsADirectory | ErrorKind::Unsupported) => {
                NoJournal::Irregular { path: path.into() }
            }
            Unopened::Io(e) => no(e),
        })?;
        if file.metadata().map_err(no)?.len() > LARGEST {
            return Err(NoJournal::Large { path: path.into() });
        }
        let mut bytes = Vec::new();
        (&mut file).take(LARGEST).read_to_end(&mut bytes).map_err(no)?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let broken = |line, why| NoJournal::Broken { path: path.into(), line, why };
        let text = std::str::from_utf8(&bytes[..whole]).map_err(|e| {
            match bytes[..e.valid_up_to()].iter().filter(|byte| **byte == b'\n').count() {
                0 => NoJournal::Foreign { path: path.into() },
                lines => broken(lines + 1, "it is no text in UTF-8".into()),
            }
        })?;
        let head = Head { journal: FORMAT, mission: mission.into(), digest: digest.into() };
        let mut lines = text.lines();
        let begun = match lines.next() {
            // A file without a complete line is foreign, unless it is empty or has a torn journal header.
            None if bytes.is_empty() || bytes.starts_with(format!("{{\"journal\":{FORMAT}").as_bytes()) => false,
            None => return Err(NoJournal::Foreign { path: path.into() }),
            Some(first) => match serde_json::from_str::<Head>(first) {
                Ok(is) if is == head => true,
                Ok(is) if is.journal == FORMAT => {
                    return Err(NoJournal::Other { path: path.into(), mission: is.mission });
                }
                _ => match serde_json::from_str::<Format>(first) {
                    Ok(Format { journal }) if journal != FORMAT => {
                        return Err(NoJournal::Format { path: path.into(), format: journal });
                    }
                    _ => return Err(NoJournal::Foreign { path: path.into() }),
                },
            },
        };
        let read = |(index, line): (usize, &str)| {
            let line: Result<Line, _> = serde_json::from_str(line);
            line.map_err(|e| {
                let why = e.to_string();
                let why = why.rsplit_once(" at line ").map_or(why.as_str(), |(what, _)| what);
                broken(index + 2, format!("{why} in column {}", e.column()))
            })
        };
        let said = lines.enumerate().map(read).collect::<Result<Vec<Line>, NoJournal>>()?;
        let mut time = 0.0;
        for (index, line) in said.iter().enumerate() {
            if !(time..=MAX_MISSION).contains(&line.time) {
                let why =
                    format!("its time is {}, and lies between {time}, the one before, and {MAX_MISSION} s", line.time);
                return Err(broken(index + 2, why));
            }
            time = line.time;
        }
        // An incomplete last line is removed before the next one is added.
        let lines = Lines::new(Box::new(file), whole as u64);
        let mut journal = Journal { lines, path: path.into(), time };
        if !begun {
            journal.write(&head)?;
        }
        if !existed {
            files::settle(path);
        }
        Ok((journal, said))
    }

    /// Writes a line and syncs it to the disk.
    ///
    /// # Errors
    ///
    /// The line is rejected: the file cannot be written, or the line would not be readable. Earlier lines are
    /// unaffected, and further lines may be tried.
    pub fn add(&mut self, line: &Line) -> Result<(), NoJournal> {
        let Line { time, .. } = *line;
        if !(self.time..=MAX_MISSION).contains(&time) {
            return Err(NoJournal::Time { path: self.path.clone(), time, since: self.time });
        }
        self.write(line)?;
        self.time = time;
        Ok(())
    }

    /// Creates a journal on a test disk, without a first line.
    #[cfg(test)]
    pub fn on(disk: impl super::lines::Disk + 'static) -> Journal {
        Journal { lines: Lines::new(Box::new(disk), 0), path: "test".into(), time: 0.0 }
    }

    /// Returns the error for an invalid entry at this index.
    pub fn broken(&self, index: usize, why: String) -> NoJournal {
        NoJournal::Broken { path: self.path.clone(), line: index + 2, why }
    }

    fn write(&mut self, line: &impl Serialize) -> Result<(), NoJournal> {
        let no = |why| NoJournal::File { path: self.path.clone(), why };
        let mut text = serde_json::to_string(line).map_err(|e| no(e.into()))?;
        text.push('\n');
        if self.lines.length() + text.len() as u64 > LARGEST {
            return Err(NoJournal::Full { path: self.path.clone() });
        }
        self.lines.add(&text).map_err(no)
    }
}

#[cfg(test)]
mod tests {
    use mission::kind::pages::Client;
    use serde_json::json;

    use super::*;

    fn path(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("hierarq-journal-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("writable");
        let path = folder.join(name);
        let _ = std::fs::remove_file(&path);
        path
    }

    fn line(time: f64) -> Line {
        let body = json!({ "what": "done", "operation": 0, "until": 0.1 + 0.2 });
        Line { time, entry: Entry::Request(Request { from: Client::Person(1), body }) }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let path = path("again");
        let (mut journal, said) = Journal::open(&path, "vineyard", "d").expect("new");
        assert!(said.is_empty());
        let lines = [line(1.5), Line { time: 2.0, entry: Entry::Records(9) }, line(0.1 + 0.2 + 3.0)];
        lines.iter().for_each(|line| journal.add(line).expect("writable"));
        assert!(matches!(Journal::open(&path, "vineyard", "d"), Err(NoJournal::Locked { .. })));
        drop(journal);
        assert_eq!(Journal::open(&path, "vineyard", "d").expect("mine").1, lines);
    }

    #[test]
    fn a_torn_last_line_is_forgotten() {
        let path = path("torn");
        let (mut journal, _) = Journal::open(&path, "vineyard", "d").expect("new");
        journal.add(&line(1.0)).expect("writable");
        drop(journal);
        let whole = std::fs::read(&path).expect("readable");
        let second = serde_json::to_string(&line(2.0)).expect("json");
        for torn in 0..second.len() {
            std::fs::write(&path, [&whole, &second.as_bytes()[..torn]].concat()).expect("writable");
            let (mut journal, said) = Journal::open(&path, "vineyard", "d").expect("mine");
            assert_eq!(said, [line(1.0)], "{torn}");
            journal.add(&line(3.0)).expect("writable");
            drop(journal);
            assert_eq!(Journal::open(&path, "vineyard", "d").expect("mine").1, [line(1.0), line(3.0)]);
        }
    }

    #[test]
    fn a_file_of_something_else_is_left_alone() {
        let path = path("foreign");
        for text in [
            "dear diary",
            "dear diary\n",
            "{}\n",
            "\u{0}\u{1}\n",
            "{\"journal\":1,\"mission\":\"v\",\"digest\":\"d\"}\n",
            "{\"journal\":3,\"mission\":\"v\",\"digest\":\"d\"}\n",
        ] {
            std::fs::write(&path, text).expect("writable");
            assert!(Journal::open(&path, "v", "d").is_err(), "{text}");
            assert_eq!(std::fs::read_to_string(&path).expect("readable"), text);
        }
        let _ = std::fs::remove_file(&path);
        drop(Journal::open(&path, "v", "d").expect("new"));
        assert!(matches!(Journal::open(&path, "v", "e"), Err(NoJournal::Other { .. })));
        let text = std::fs::read_to_string(&path).expect("readable");
        std::fs::write(&path, text + "{\"time\":1}\n{\"time\":2,\"entry\":{\"records\":1}}\n").expect("writable");
        assert!(matches!(Journal::open(&path, "v", "d"), Err(NoJournal::Broken { line: 2, .. })));
    }

    #[test]
    fn a_journal_of_another_format_is_refused() {
        let path = path("format");
        std::fs::write(&path, "{\"journal\":1,\"mission\":\"v\",\"digest\":\"d\"}\n").expect("writable");
        let refused = Journal::open(&path, "v", "d").expect_err("an earlier format").to_string();
        assert!(refused.contains("has format 1, and this version of hierarq reads and writes format 2"), "{refused}");
    }

    #[test]
    fn a_line_that_could_not_be_read_again_is_not_written() {
        let path = path("bounds");
        let (mut journal, _) = Journal::open(&path, "v", "d").expect("new");
        journal.add(&line(7.0)).expect("writable");
        for time in [6.9, 1e6 + 1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(journal.add(&line(time)), Err(NoJournal::Time { .. })), "{time}");
        }
        journal.add(&line(7.0)).expect("writable");
        drop(journal);
        assert_eq!(Journal::open(&path, "v", "d").expect("mine").1, [line(7.0), line(7.0)]);
        let lines = Lines::new(Box::new(crate::lines::tests::Faulty::default()), LARGEST - 9);
        let mut journal = Journal { lines, path, time: 0.0 };
        assert!(matches!(journal.add(&line(1.0)), Err(NoJournal::Full { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_neither_read_nor_written() {
        for device in ["/dev/full", "/dev/zero", "/"] {
            assert!(matches!(Journal::open(Path::new(device), "v", "d"), Err(NoJournal::Irregular { .. })), "{device}");
        }
        let pipe = path("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo runs");
        assert!(made.success());
        assert!(matches!(Journal::open(&pipe, "v", "d"), Err(NoJournal::Irregular { .. })), "and nobody waits");
        std::fs::remove_file(pipe).expect("removed");
    }

    #[test]
    fn a_damaged_line_is_told_with_its_number() {
        let path = path("damaged");
        drop(Journal::open(&path, "v", "d").expect("new"));
        let head = std::fs::read(&path).expect("readable");
        let good = "{\"time\":1,\"entry\":{\"records\":1}}\n";
        for (damaged, words) in [
            (&b"oops\n"[..], "expected value in column 1"),
            (b"\xff\xfe\n", "UTF-8"),
            (b"{\"time\":0.5,\"entry\":{\"records\":1}}\n", "between 1,"),
            (b"{\"time\":2e6,\"entry\":{\"records\":1}}\n", "between 1, the one before, and 1000000 s"),
        ] {
            std::fs::write(&path, [&head, good.as_bytes(), damaged, good.as_bytes()].concat()).expect("writable");
            let told = Journal::open(&path, "v", "d").expect_err("damaged").to_string();
            assert!(told.starts_with("line 3 of the journal") && told.contains(words), "{told}");
            assert_eq!(told.matches("line ").count(), 2, "{told}");
        }
        std::fs::write(&path, [&head, &b"{\"time\":-5,\"entry\":{\"records\":1}}\n"[..]].concat()).expect("writable");
        assert!(matches!(Journal::open(&path, "v", "d"), Err(NoJournal::Broken { line: 2, .. })));
    }
}
