//! The way of ticks from a loop to the thread that stores or shows them.
//!
//! Snapshots are made before the first tick and go round, so that a tick is a copy, without an allocation or a call of the system. The
//! one that came back last is used first: its memory is still in the caches. The thread looks for ticks by itself, since waking it
//! would be a call of the system.

use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::sleep;
use std::time::Duration;

use runtime::Tick;

use crate::snapshot::{Camera, Snapshot};

/// Reason for which a tick was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotSent {
    /// The thread is behind, and there is no room.
    Full,
    /// The thread has ended.
    Ended,
}

/// The end of the loop.
pub struct TickSender {
    camera: Camera,
    taken: SyncSender<Box<Snapshot>>,
    returned: Receiver<Box<Snapshot>>,
    /// Snapshots that are free, the last one first.
    #[allow(clippy::vec_box, reason = "they go through the channels as pointers")]
    free: Vec<Box<Snapshot>>,
}

/// The end of the thread.
pub struct TickReceiver {
    taken: Receiver<Box<Snapshot>>,
    back: SyncSender<Box<Snapshot>>,
    /// Time between two looks.
    look: Duration,
}

/// Both ends.
pub struct Queue {
    /// The end of the loop.
    pub sender: TickSender,
    /// The end of the thread.
    pub receiver: TickReceiver,
}

/// A queue with room for some ticks. The thread looks for them from time to time.
pub fn queue(camera: Camera, room: usize, look: Duration) -> Queue {
    let (taken, ticks) = sync_channel(room);
    let (back, returned) = sync_channel(room);
    let free = (0..room).map(|_| Box::new(camera.blank())).collect();
    Queue { sender: TickSender { camera, taken, returned, free }, receiver: TickReceiver { taken: ticks, back, look } }
}

impl TickSender {
    /// Sends a tick if there is room.
    ///
    /// # Errors
    /// There is none, or the thread has ended.
    pub fn send(&mut self, tick: &Tick) -> Result<(), NotSent> {
        loop {
            match self.returned.try_recv() {
                Ok(snapshot) => self.free.push(snapshot),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Err(NotSent::Ended),
            }
        }
        let snapshot = self.free.pop().ok_or(NotSent::Full)?;
        self.give(tick, snapshot)
    }

    /// Sends a tick, and waits until there is room.
    ///
    /// # Errors
    /// The thread has ended.
    pub fn send_and_wait(&mut self, tick: &Tick) -> Result<(), NotSent> {
        match self.send(tick) {
            Err(NotSent::Full) => {
                let snapshot = self.returned.recv().map_err(|_| NotSent::Ended)?;
                self.give(tick, snapshot)
            }
            done => done,
        }
    }

    fn give(&mut self, tick: &Tick, mut snapshot: Box<Snapshot>) -> Result<(), NotSent> {
        self.camera.take(tick, &mut snapshot);
        // As many snapshots exist as have room.
        self.taken.try_send(snapshot).map_err(|_| NotSent::Ended)
    }
}

impl TickReceiver {
    /// Acts on each tick until the sender has ended.
    ///
    /// # Errors
    /// The error of the first act that fails.
    pub fn each<E>(&self, mut act: impl FnMut(&Snapshot) -> Result<(), E>) -> Result<(), E> {
        loop {
            match self.taken.try_recv() {
                Ok(tick) => {
                    act(&tick)?;
                    // There is room for all of them.
                    let _ = self.back.try_send(tick);
                }
                Err(TryRecvError::Disconnected) => return Ok(()),
                Err(TryRecvError::Empty) => sleep(self.look),
            }
        }
    }
}
