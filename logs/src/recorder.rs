//! Recorder of a run: a tick is copied into storage that was allocated before, and a thread makes and writes its messages.
//!
//! The thread looks for ticks every millisecond and is never woken, since waking a thread is a call of the system. If it is too
//! slow, a simulation waits for it, so that its log is complete, and a host drops ticks and counts them.

use std::io::{Error, Result, Write};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::{JoinHandle, sleep};
use std::time::Duration;

use runtime::{Controller, Program};
use runtime::{Recorder, Tick};

use crate::about::About;
use crate::file::LogFile;
use crate::messages::Messages;
use crate::snapshot::{Camera, Snapshot};

/// Ticks that can wait.
const WAITING: usize = 1024;
/// Time between two looks of the thread.
const LOOK: Duration = Duration::from_millis(1);

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
    camera: Camera,
    overflow: Overflow,
    taken: Option<SyncSender<Snapshot>>,
    free: Receiver<Snapshot>,
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
        let (taken, ticks) = sync_channel(WAITING);
        let (back, free) = sync_channel(WAITING);
        for _ in 0..WAITING {
            // There is room for all of them.
            let _ = back.try_send(Snapshot::default());
        }
        let write = move || -> Result<Done<W>> {
            let mut count = 0;
            while let Some(tick) = next(&ticks) {
                messages.tick(&tick, &mut |topic, time, message| file.write(topic, time, message))?;
                count += 1;
                let _ = back.try_send(tick);
            }
            Ok(Done { file, ticks: count })
        };
        let thread = std::thread::Builder::new().name("mcap".to_string()).spawn(write)?;
        let camera = Camera::new(program, controller);
        Ok(McapRecorder { camera, overflow, taken: Some(taken), free, thread: Some(thread), dropped: 0 })
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
        let free = match self.overflow {
            Overflow::Wait => self.free.recv().map_err(|_| TryRecvError::Disconnected),
            Overflow::Drop => self.free.try_recv(),
        };
        let mut snapshot = match free {
            Ok(snapshot) => snapshot,
            Err(TryRecvError::Empty) => {
                self.dropped += 1;
                return Ok(());
            }
            Err(TryRecvError::Disconnected) => return Err(self.reason()),
        };
        self.camera.take(tick, &mut snapshot);
        // As many snapshots exist as have room: the thread alone can be the reason.
        let sent = self.taken.as_ref().is_some_and(|taken| taken.try_send(snapshot).is_ok());
        if sent { Ok(()) } else { Err(self.reason()) }
    }

    /// The error with which the thread ended.
    fn reason(&mut self) -> Error {
        match self.join() {
            Err(e) => e,
            Ok(_) => Error::other("the log was ended"),
        }
    }

    fn join(&mut self) -> Result<Done<W>> {
        self.taken = None;
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

/// The next tick for a thread that looks for them every millisecond; none after the last one.
pub fn next(ticks: &Receiver<Snapshot>) -> Option<Snapshot> {
    loop {
        match ticks.try_recv() {
            Ok(tick) => return Some(tick),
            Err(TryRecvError::Disconnected) => return None,
            Err(TryRecvError::Empty) => sleep(LOOK),
        }
    }
}

impl<W: Write + Send + 'static> Recorder for McapRecorder<W> {
    fn tick(&mut self, tick: &Tick) -> Result<()> {
        self.record(tick)
    }
}
