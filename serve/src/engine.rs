//! The thread that owns a running mission: advances its time, applies requests, and publishes the state for pages.
//!
//! Planning may take a while; pages are still served then, and requests wait in a short queue.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mission::kind::pages::words::clock_time;
use mission::kind::pages::{JournalSink, Refusal, Request, Session};
use tokio::sync::{oneshot, watch};

use super::clock::Clock;
use super::journal::{Entry, Journal, Line, NoJournal};
use super::published::{ClockState, Published};

/// Interval between advances of time.
const TICK: Duration = Duration::from_millis(50);
/// Interval between updates of the robots' positions on pages.
const FRAME: Duration = Duration::from_millis(500);
/// Default interval between the journal's heartbeats.
const BEAT: Duration = Duration::from_secs(10);
/// Maximum duration of one advance, after which requests are processed first.
const PATIENCE: Duration = Duration::from_millis(100);
/// Delay behind the clock from which a mission counts as lagging.
const LAGS: Duration = Duration::from_secs(1);
/// Maximum number of queued requests.
const QUEUE: usize = 64;

/// Number of parts in which a journal is replayed.
const STRETCHES: f64 = 500.0;

/// Progress of replaying a journal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resuming {
    /// Mission time reached (s).
    pub time: f64,
    /// Mission time at the end of the journal (s).
    pub until: f64,
}

/// Result of a request: a reply, or the reason for rejecting it.
pub type Reply = Result<String, Refusal>;

/// A command for the engine.
pub enum Command {
    /// Start or stop the clock.
    Clock(bool),
    /// Pass a request to the mission.
    Request(Request),
}

struct Queued {
    command: Command,
    reply: oneshot::Sender<Reply>,
}

/// Connection to the engine, which ends when the last handle is dropped.
#[derive(Clone)]
pub struct Handle {
    commands: SyncSender<Queued>,
    /// The latest published state.
    pub published: watch::Receiver<Arc<Published>>,
}

impl Handle {
    /// Sends a command to the engine, and waits for the result. `None`: the queue is full, or the engine has ended.
    pub async fn send(&self, command: Command) -> Option<Reply> {
        let (reply, replied) = oneshot::channel();
        match self.commands.try_send(Queued { command, reply }) {
            Ok(()) => replied.await.ok(),
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => None,
        }
    }
}

/// A running mission with its clock and its journal.
pub struct Engine {
    mission: Arc<str>,
    session: Box<dyn Session>,
    clock: Clock,
    journal: JournalWriter,
    /// Interval between the journal's heartbeats.
    beat: Duration,
}

/// Writer of the journal, if there is one.
#[derive(Default)]
struct JournalWriter {
    journal: Option<Journal>,
    /// Error of the last write, if it failed.
    trouble: Option<String>,
}

impl JournalWriter {
    /// Writes an entry, if there is a journal. On failure the entry must have no effect.
    fn write(&mut self, time: f64, entry: Entry) -> Result<(), String> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        self.trouble = journal.add(&Line { time, entry }).err().map(|e| e.to_string());
        match &self.trouble {
            Some(why) => Err(format!("Nothing was changed, because the journal cannot be written: {why}.")),
            None => Ok(()),
        }
    }
}

impl Engine {
    /// Creates an engine at the start of a mission.
    pub fn new(mission: &str, session: Box<dyn Session>, speed: f64) -> Engine {
        let clock = Clock::stopped(session.time(), speed);
        Engine { mission: mission.into(), session, clock, journal: JournalWriter::default(), beat: BEAT }
    }

    /// Replays a journal, and continues writing it. Returns the time reached (s), and false if the number of log entries
    /// differs from that in the journal. `progress` is called from time to time.
    ///
    /// # Errors
    ///
    /// A line contains a request that is never valid in this mission.
    pub fn resume(
        &mut self,
        journal: Journal,
        lines: &[Line],
        progress: &mut dyn FnMut(Resuming),
    ) -> Result<(f64, bool), NoJournal> {
        let until = lines.last().map_or(0.0, |line| line.time);
        let stretch = (until / STRETCHES).max(1.0);
        let mut same = true;
        for (index, line) in lines.iter().enumerate() {
            while self.session.time() < line.time {
                progress(Resuming { time: self.session.time(), until });
                self.session.advance(line.time.min(self.session.time() + stretch));
            }
            match &line.entry {
                Entry::Records(count) => same &= *count == self.session.log_len(),
                Entry::Request(request) => match self.session.handle(request, true, &mut JournalSink::replay()) {
                    Err(Refusal::Invalid(why)) => return Err(journal.broken(index, why)),
                    // A request that the state of the mission rejected then is rejected again.
                    Ok(_) | Err(Refusal::NotNow(_)) => {}
                },
            }
        }
        self.journal.journal = Some(journal);
        self.clock = Clock::stopped(self.session.time(), self.clock.speed());
        Ok((self.session.time(), same))
    }

    /// Starts the thread of the mission; the clock runs from the start if `runs` is set.
    pub fn start(mut self, runs: bool) -> (Handle, JoinHandle<()>) {
        self.clock.set(runs, Instant::now());
        let (commands, queue) = sync_channel(QUEUE);
        let (publish, published) = watch::channel(Arc::new(self.view()));
        let thread = std::thread::spawn(move || self.run(&queue, &publish));
        (Handle { commands, published }, thread)
    }

    fn run(&mut self, queue: &Receiver<Queued>, publish: &watch::Sender<Arc<Published>>) {
        let (mut shown, mut beat) = (Instant::now(), Instant::now());
        loop {
            let received = queue.recv_timeout(if self.behind() > PATIENCE { Duration::ZERO } else { TICK });
            let before = self.urgent();
            let now = Instant::now();
            self.advance(self.clock.at(now));
            let mut replied = None;
            match received {
                Ok(Queued { command, reply }) => {
                    replied = Some((reply, self.execute(command)));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            // After an error, also retry while the clock is stopped: there may be space again.
            if (self.clock.runs() || self.journal.trouble.is_some()) && now.duration_since(beat) >= self.beat {
                beat = now;
                self.beat();
            }
            let changed = replied.is_some() || before != self.urgent();
            if changed || (self.clock.runs() && now.duration_since(shown) >= FRAME) {
                shown = now;
                publish.send_replace(Arc::new(self.view()));
            }
            // Publish before replying, so that the reply never precedes the page update.
            if let Some((reply, result)) = replied {
                let _ = reply.send(result);
            }
        }
        self.beat();
        publish.send_replace(Arc::new(self.view()));
    }

    /// State whose changes are published immediately.
    fn urgent(&self) -> (usize, bool, bool) {
        (self.session.log_len(), self.clock.runs(), self.journal.trouble.is_some())
    }

    fn beat(&mut self) {
        let (time, count) = (self.session.time(), self.session.log_len());
        // On failure the writer keeps the error, and pages show it.
        let _ = self.journal.write(time, Entry::Records(count));
    }

    /// Advances time in short steps, up to a maximum duration: requests may be waiting.
    fn advance(&mut self, to: f64) {
        let begun = Instant::now();
        let stretch = self.clock.speed() * TICK.as_secs_f64();
        while to > self.session.time() && begun.elapsed() < PATIENCE {
            self.session.advance(to.min(self.session.time() + stretch));
        }
    }

    /// Returns the delay of the mission behind its clock.
    fn behind(&self) -> Duration {
        let seconds = (self.clock.at(Instant::now()) - self.session.time()) / self.clock.speed();
        Duration::try_from_secs_f64(seconds).unwrap_or_default()
    }

    fn view(&self) -> Published {
        let clock = ClockState { time: self.session.time(), speed: self.clock.speed(), running: self.clock.runs() };
        let mut pages = self.session.data(clock.running);
        let behind = Some(self.behind()).filter(|behind| *behind >= LAGS);
        if let Some(behind) = behind {
            let lags = format!(
                "The mission is {:.0} s behind its clock: planning takes longer than a speed of {} allows.",
                behind.as_secs_f64(),
                self.clock.speed()
            );
            pages.supervisor.note = joined(pages.supervisor.note, &lags);
        }
        if let Some(why) = &self.journal.trouble {
            let refused = format!("Requests are rejected, because the journal cannot be written: {why}.");
            pages.supervisor.note = joined(pages.supervisor.note, &refused);
            for person in pages.people.values_mut() {
                person.note = joined(
                    person.note.take(),
                    "The server cannot record your input: buttons have no effect. Tell the supervisor, whose page shows the \
                     reason.",
                );
            }
        }
        Published { mission: self.mission.clone(), clock, behind, unwritten: self.journal.trouble.clone(), pages }
    }

    fn execute(&mut self, command: Command) -> Reply {
        match command {
            Command::Clock(runs) => {
                let now = Instant::now();
                self.clock.set(runs, now);
                self.advance(self.clock.at(now));
                let at = clock_time(self.session.time());
                Ok(if runs { format!("The clock runs from {at}.") } else { format!("The clock is stopped at {at}.") })
            }
            Command::Request(request) => {
                let Engine { session, journal, clock, .. } = self;
                let time = session.time();
                let mut write = || journal.write(time, Entry::Request(request.clone()));
                session.handle(&request, clock.runs(), &mut JournalSink::new(&mut write))
            }
        }
    }
}

/// Joins two notes.
fn joined(note: Option<String>, more: &str) -> Option<String> {
    Some(note.map_or(more.to_string(), |note| format!("{note} {more}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lines::tests::{Faults, Faulty};
    use mission::kind::pages::{Client, PageData, SupervisorPage};
    use mission::map::Map;
    use serde_json::json;

    /// A mission in which every step takes longer than real time.
    struct Slow(f64);

    impl Session for Slow {
        fn time(&self) -> f64 {
            self.0
        }
        fn log_len(&self) -> usize {
            0
        }
        fn advance(&mut self, to: f64) {
            std::thread::sleep(2 * TICK);
            self.0 = to;
        }
        fn data(&self, _: bool) -> PageData {
            let map = Map {
                title: "",
                most_scale: 1.0,
                extent: Vec::new(),
                clear: Vec::new(),
                shapes: Vec::new(),
                moving: Vec::new(),
                legend: Vec::new(),
            };
            let (people, supervisor) = (Default::default(), SupervisorPage::default());
            PageData { people, supervisor, chart: Arc::default(), map: Arc::new(map) }
        }
        fn handle(&mut self, _: &Request, _: bool, journal: &mut JournalSink<'_>) -> Reply {
            journal.record()?;
            journal.record()?;
            Ok("Noted.".into())
        }
    }

    fn replan() -> Request {
        Request { from: Client::Supervisor, body: json!({ "what": "replan" }) }
    }

    /// On a full disk nothing is recorded, and pages report that with and without presses; once there is space again,
    /// they stop reporting it, and new entries are written.
    #[test]
    fn a_journal_that_cannot_be_written_is_said_and_tried_again() {
        let disk = Faulty::default();
        let mut engine = Engine::new("slow", Box::new(Slow(0.0)), 1.0);
        (engine.journal.journal, engine.beat) = (Some(Journal::on(disk.clone())), 2 * TICK);
        let (handle, thread) = engine.start(false);
        let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
        let press = || runtime.block_on(handle.send(Command::Request(replan()))).expect("an answer");
        let until = |refused: bool| {
            let begun = Instant::now();
            while handle.published.borrow().unwritten.is_some() != refused {
                assert!(begun.elapsed() < Duration::from_secs(20), "pages do not say {refused}");
                std::thread::sleep(TICK);
            }
        };
        let full = Faults { room: Some(9), ..Faults::default() };
        disk.set(full);
        let Err(Refusal::NotNow(why)) = press() else { panic!("the disk is full") };
        assert!(why.starts_with("Nothing was changed, because the journal cannot be written"));
        let note = handle.published.borrow().pages.supervisor.note.clone();
        assert!(note.is_some_and(|note| note.contains("the journal cannot be written")));
        assert_eq!(disk.holds(), "");
        // No presses, with a stopped clock.
        disk.set(Faults::default());
        until(false);
        assert_eq!(press(), Ok("Noted.".into()));
        // No presses, with a running clock.
        disk.set(full);
        runtime.block_on(handle.send(Command::Clock(true))).expect("an answer").expect("runs");
        until(true);
        disk.set(Faults::default());
        until(false);
        drop(handle);
        thread.join().expect("ended");
        let lines: Vec<Line> = disk.holds().lines().map(|line| serde_json::from_str(line).expect("whole")).collect();
        let recorded = lines.iter().filter(|line| line.entry == Entry::Request(replan())).count();
        assert_eq!(recorded, 1, "a request is recorded once: {lines:?}");
    }

    #[test]
    fn a_mission_that_lags_says_so_and_still_answers() {
        let (handle, thread) = Engine::new("slow", Box::new(Slow(0.0)), 100.0).start(true);
        let begun = Instant::now();
        let lags = |handle: &Handle| handle.published.borrow().pages.supervisor.note.clone();
        while lags(&handle).is_none() {
            assert!(begun.elapsed() < Duration::from_secs(20), "it does not say so");
            std::thread::sleep(TICK);
        }
        assert!(lags(&handle).is_some_and(|note| note.contains("behind its clock")));
        assert!(handle.published.borrow().behind.is_some_and(|behind| behind >= LAGS));
        let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
        let asked = Instant::now();
        assert_eq!(runtime.block_on(handle.send(Command::Request(replan()))), Some(Ok("Noted.".into())));
        assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
        drop(handle);
        thread.join().expect("ended");
    }
}
