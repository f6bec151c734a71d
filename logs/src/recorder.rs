//! Recorder of a run: a tick is copied into storage that was allocated before, and a thread makes and writes its messages.
//!
//! If the thread is too slow, a simulation waits for it, so that its log is complete, and a host drops ticks and counts them.

use std::io::{Error, Result, Write};
use std::thread::JoinHandle;
use std::time::Duration;

use runtime::{Controller, Program};
use runtime::{Recorder, Tick};

use crate::about::About;
use crate::file::LogFile;
use crate::messages::Messages;
use crate::queue::{NotSent, Queue, TickSender, queue};
use crate::snapshot::Camera;

/// Ticks that can wait.
const WAITING: usize = 1024;
/// Time between two looks of the thread for a simulation, which may wait for it.
const SOON: Duration = Duration::from_millis(1);
/// Time between two looks of the thread for a host. A thread that looks rarely leaves the caches to the loop.
const RARELY: Duration = Duration::from_millis(20);

/// Answer to a thread that is too slow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overflow {
    /// The caller waits: every tick is in the log.
    Wait,
    /// The tick is dropped and counted: the caller never waits.
    Drop,
}

/// Ticks of a finished log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Ticks in the log.
    pub ticks: usize,
    /// Ticks that were dropped.
    pub dropped: u64,
}

/// A finished log.
#[derive(Debug)]
pub struct Finished<W> {
    /// The stream, not flushed.
    pub out: W,
    /// Number of its ticks.
    pub written: Written,
}

/// End of the work of the thread: the file, and the number of its ticks.
struct Done<W: Write> {
    file: LogFile<W>,
    ticks: usize,
}

/// Writes a log in MCAP.
pub struct McapRecorder<W: Write> {
    overflow: Overflow,
    ticks: Option<TickSender>,
    thread: Option<JoinHandle<Result<Done<W>>>>,
    dropped: u64,
}

impl<W: Write + Send + 'static> McapRecorder<W> {
    /// Begins a log. The program is the one that the controller was made of.
    ///
    /// # Errors
    /// The stream failed, or the system gives no thread.
    pub fn new(
        out: W,
        about: &About,
        program: &Program,
        controller: &Controller,
        overflow: Overflow,
    ) -> Result<McapRecorder<W>> {
        let mut messages = Messages::new(program, controller);
        let mut file = LogFile::new(out, about, &messages)?;
        messages.begin(&mut |topic, time, message| file.write(topic, time, message))?;
        let look = if overflow == Overflow::Wait { SOON } else { RARELY };
        let Queue { sender, receiver } = queue(Camera::new(program, controller), WAITING, look);
        let write = move || -> Result<Done<W>> {
            let mut count = 0;
            receiver.each(|tick| {
                count += 1;
                messages.tick(tick, &mut |topic, time, message| file.write(topic, time, message))
            })?;
            Ok(Done { file, ticks: count })
        };
        let thread = std::thread::Builder::new().name("mcap".to_string()).spawn(write)?;
        Ok(McapRecorder { overflow, ticks: Some(sender), thread: Some(thread), dropped: 0 })
    }

    /// Number of ticks that were dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Records a tick.
    ///
    /// # Errors
    /// The stream failed at an earlier tick.
    pub fn record(&mut self, tick: &Tick) -> Result<()> {
        let Some(ticks) = &mut self.ticks else { return Err(self.reason()) };
        let sent = match self.overflow {
            Overflow::Wait => ticks.send_and_wait(tick),
            Overflow::Drop => ticks.send(tick),
        };
        match sent {
            Ok(()) => Ok(()),
            Err(NotSent::Full) => {
                self.dropped += 1;
                Ok(())
            }
            Err(NotSent::Ended) => Err(self.reason()),
        }
    }

    /// The error with which the thread ended.
    fn reason(&mut self) -> Error {
        match self.join() {
            Err(e) => e,
            Ok(_) => Error::other("the log was ended"),
        }
    }

    fn join(&mut self) -> Result<Done<W>> {
        self.ticks = None;
        let thread = self.thread.take().ok_or_else(|| Error::other("the log was ended"))?;
        thread.join().unwrap_or_else(|_| Err(Error::other("the thread of the log panicked")))
    }

    /// Waits for the thread and ends the log.
    ///
    /// # Errors
    /// The stream failed.
    pub fn finish(mut self) -> Result<Finished<W>> {
        let Done { file, ticks } = self.join()?;
        let written = Written { ticks, dropped: self.dropped };
        Ok(Finished { out: file.finish(ticks, self.dropped)?, written })
    }
}

impl<W: Write + Send + 'static> Recorder for McapRecorder<W> {
    fn tick(&mut self, tick: &Tick) -> Result<()> {
        self.record(tick)
    }
}
