//! An append-only file of lines without partial lines.
//!
//! A line is accepted once it is completely on the disk. If writing fails half-way, for example on a full disk, the
//! file is truncated to its last complete line; until that succeeds, no further line is accepted, so that no line is
//! ever appended to a torn one.

use std::fmt::Debug;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};

/// Storage of the lines. Tests replace the file by one that fails.
pub trait Disk: Debug + Send {
    /// Returns the length (bytes).
    ///
    /// # Errors
    ///
    /// The length is unknown, or the file has been deleted.
    fn length(&self) -> io::Result<u64>;

    /// Writes bytes at this position. On an error a part of them may be written.
    ///
    /// # Errors
    ///
    /// Not all bytes are written.
    fn write(&mut self, from: u64, bytes: &[u8]) -> io::Result<()>;

    /// Syncs written bytes to the disk.
    ///
    /// # Errors
    ///
    /// It is unknown how many of them are persistent.
    fn sync(&mut self) -> io::Result<()>;

    /// Truncates to this length, and syncs.
    ///
    /// # Errors
    ///
    /// It is unknown how much was removed.
    fn cut(&mut self, length: u64) -> io::Result<()>;
}

impl Disk for File {
    fn length(&self) -> io::Result<u64> {
        let is = self.metadata()?;
        #[cfg(unix)]
        if std::os::unix::fs::MetadataExt::nlink(&is) == 0 {
            return Err(io::Error::other("the file was removed, or another took its place"));
        }
        Ok(is.len())
    }

    fn write(&mut self, from: u64, bytes: &[u8]) -> io::Result<()> {
        self.seek(SeekFrom::Start(from))?;
        self.write_all(bytes)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sync_data()
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)?;
        self.sync_all()
    }
}

/// A file of complete lines.
#[derive(Debug)]
pub struct Lines {
    disk: Box<dyn Disk>,
    /// Bytes of its complete lines.
    whole: u64,
    /// True if an incomplete line may follow them.
    torn: bool,
}

impl Lines {
    /// Continues after the first `whole` bytes; all further bytes are removed before the next line is added.
    pub fn new(disk: Box<dyn Disk>, whole: u64) -> Lines {
        Lines { disk, whole, torn: true }
    }

    /// Returns the number of bytes of its complete lines.
    pub fn length(&self) -> u64 {
        self.whole
    }

    /// Adds a line, which ends with a line break and contains no other.
    ///
    /// # Errors
    ///
    /// The line is rejected: it could not be written, or an earlier incomplete line could not be removed.
    pub fn add(&mut self, line: &str) -> io::Result<()> {
        self.mend()?;
        let written = self.disk.write(self.whole, line.as_bytes()).and_then(|()| self.disk.sync());
        let Err(why) = written else {
            self.whole += line.len() as u64;
            return Ok(());
        };
        self.torn = true;
        match self.mend() {
            Ok(()) => Err(why),
            Err(stays) => {
                Err(io::Error::new(why.kind(), format!("{why}; and the half-written line cannot be removed: {stays}")))
            }
        }
    }

    /// Truncates to the last complete line.
    fn mend(&mut self) -> io::Result<()> {
        let holds = self.disk.length()?;
        if holds < self.whole || (holds > self.whole && !self.torn) {
            return Err(io::Error::other(format!(
                "something else has changed the file: it has {holds} bytes where {} were written",
                self.whole
            )));
        }
        if self.torn {
            self.disk.cut(self.whole)?;
            self.torn = false;
        }
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::sync::{Arc, Mutex};

    use proptest::prelude::*;

    use super::*;

    /// Faults of a step: number of bytes of the line that are written before an error, and other failing calls.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct Faults {
        pub room: Option<usize>,
        pub sync: bool,
        pub cut: bool,
    }

    /// A disk with injected faults. It holds the data that a restart would read.
    #[derive(Clone, Debug, Default)]
    pub struct Faulty(pub Arc<Mutex<(Vec<u8>, Faults)>>);

    impl Faulty {
        pub fn set(&self, faults: Faults) {
            self.0.lock().expect("whole").1 = faults;
        }

        pub fn holds(&self) -> String {
            String::from_utf8(self.0.lock().expect("whole").0.clone()).expect("text")
        }
    }

    impl Disk for Faulty {
        fn length(&self) -> io::Result<u64> {
            Ok(self.0.lock().expect("whole").0.len() as u64)
        }

        fn write(&mut self, from: u64, bytes: &[u8]) -> io::Result<()> {
            let (held, faults) = &mut *self.0.lock().expect("whole");
            assert_eq!(held.len() as u64, from, "a line is glued to something");
            let room = faults.room.unwrap_or(bytes.len()).min(bytes.len());
            held.extend(&bytes[..room]);
            if faults.room.is_some() { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
        }

        fn sync(&mut self) -> io::Result<()> {
            if self.0.lock().expect("whole").1.sync { Err(io::Error::other("no sync")) } else { Ok(()) }
        }

        fn cut(&mut self, length: u64) -> io::Result<()> {
            let (held, faults) = &mut *self.0.lock().expect("whole");
            if faults.cut {
                return Err(io::Error::other("no cut"));
            }
            held.truncate(usize::try_from(length).expect("small"));
            Ok(())
        }
    }

    #[test]
    fn a_line_that_stays_half_written_is_removed_before_the_next() {
        let disk = Faulty::default();
        let mut lines = Lines::new(Box::new(disk.clone()), 0);
        lines.add("one\n").expect("written");
        disk.set(Faults { room: Some(2), cut: true, ..Faults::default() });
        let refused = lines.add("two\n").expect_err("no room").to_string();
        assert!(refused.contains("cannot be removed: no cut"), "{refused}");
        disk.set(Faults { cut: true, ..Faults::default() });
        assert!(lines.add("three\n").is_err(), "there is room, and a torn line");
        assert_eq!(disk.holds(), "one\ntw");
        disk.set(Faults::default());
        lines.add("four\n").expect("written");
        assert_eq!(disk.holds(), "one\nfour\n");
    }

    #[test]
    fn what_something_else_did_to_the_file_is_told_and_left() {
        for holds in ["", "on", "one\nmore\n"] {
            let disk = Faulty::default();
            let mut lines = Lines::new(Box::new(disk.clone()), 0);
            lines.add("one\n").expect("written");
            disk.0.lock().expect("whole").0 = holds.into();
            let refused = lines.add("two\n").expect_err("changed").to_string();
            assert!(refused.contains("something else has changed"), "{refused}");
            assert_eq!(disk.holds(), holds);
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_nobody_finds_again_takes_no_line() {
        let path = std::env::temp_dir().join(format!("hierarq-lines-{}", std::process::id()));
        let mut lines = Lines::new(Box::new(File::create(&path).expect("writable")), 0);
        lines.add("one\n").expect("written");
        std::fs::remove_file(&path).expect("removed");
        assert!(lines.add("two\n").expect_err("removed").to_string().contains("was removed"));
    }

    proptest! {
        /// For any faults, all accepted lines are stored completely and in order, followed at most by a rejected line
        /// that could not be removed.
        #[test]
        fn what_was_taken_stays(steps in prop::collection::vec((prop::option::weighted(0.4, 0usize..9), any::<[bool; 2]>()), 1..40)) {
            let disk = Faulty::default();
            let mut lines = Lines::new(Box::new(disk.clone()), 0);
            let mut taken = String::new();
            for (number, (room, [sync, cut])) in steps.into_iter().enumerate() {
                disk.set(Faults { room, sync, cut });
                let line = format!("line {number}\n");
                if lines.add(&line).is_ok() {
                    taken += &line;
                }
                let holds = disk.holds();
                let rest = holds.strip_prefix(&taken);
                prop_assert!(rest.is_some_and(|rest| line.starts_with(rest) || (cut && rest.matches('\n').count() <= 1)), "{holds:?} {taken:?}");
            }
        }
    }
}
