//! The thread that owns a running mission: advances its time, applies reports, and publishes the state for pages.
//!
//! Planning may take a while; pages are still served then, and reports wait in a short queue.

pub mod world;

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tokio::sync::{oneshot, watch};

use self::world::World;
use super::clock::Clock;
use super::journal::{Entry, Journal, Line, NoJournal};
use super::told::{PersonTells, SupervisorTells, Tells};
use super::view::{ClockView, Published};
use super::words::written;

/// Interval between advances of time.
const TICK: Duration = Duration::from_millis(50);
/// Interval between updates of the robots' positions on pages.
const FRAME: Duration = Duration::from_millis(500);
/// Default interval between the journal's heartbeats.
const BEAT: Duration = Duration::from_secs(10);
/// Maximum duration of one advance, after which reports are processed first.
const PATIENCE: Duration = Duration::from_millis(100);
/// Delay behind the clock from which a mission counts as lagging.
const LAGS: Duration = Duration::from_secs(1);
/// Maximum number of queued reports.
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

/// Result of a report: a reply, or the reason for rejecting it.
pub type Answer = Result<String, String>;

struct Asked {
    tells: Tells,
    answer: oneshot::Sender<Answer>,
}

/// Connection to the engine, which ends when the last handle is dropped.
#[derive(Clone)]
pub struct Handle {
    asks: SyncSender<Asked>,
    /// The latest published state.
    pub published: watch::Receiver<Arc<Published>>,
}

impl Handle {
    /// Sends a report to the engine, and waits for the result. `None`: the queue is full, or the engine has ended.
    pub async fn tell(&self, tells: Tells) -> Option<Answer> {
        let (answer, answered) = oneshot::channel();
        match self.asks.try_send(Asked { tells, answer }) {
            Ok(()) => answered.await.ok(),
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => None,
        }
    }
}

/// A running mission with its clock and its journal.
pub struct Engine {
    mission: Arc<str>,
    world: Box<dyn World>,
    clock: Clock,
    notes: Notes,
    /// Interval between the journal's heartbeats.
    beat: Duration,
}

/// Writer of the journal, if there is one.
#[derive(Default)]
struct Notes {
    journal: Option<Journal>,
    /// Error of the last write, if it failed.
    trouble: Option<String>,
}

impl Notes {
    /// Writes an entry, if there is a journal. On failure the entry must have no effect.
    fn write(&mut self, time: f64, entry: Entry) -> Result<(), String> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        self.trouble = journal.add(&Line { time, entry }).err().map(|e| e.to_string());
        match &self.trouble {
            Some(why) => Err(format!("Nothing was changed, because it could not be written down: {why}.")),
            None => Ok(()),
        }
    }
}

impl Engine {
    /// Creates an engine at the start of a mission.
    pub fn new(mission: &str, world: Box<dyn World>, speed: f64) -> Engine {
        let clock = Clock::standing(world.time(), speed);
        Engine { mission: mission.into(), world, clock, notes: Notes::default(), beat: BEAT }
    }

    /// Replays a journal, and continues writing it. Returns the time reached (s), and false if the number of records
    /// differs from that in the journal. `tell` is called with the progress from time to time.
    ///
    /// # Errors
    ///
    /// A line contains a report that is never valid in this mission.
    pub fn resume(
        &mut self,
        journal: Journal,
        said: &[Line],
        tell: &mut dyn FnMut(Resuming),
    ) -> Result<(f64, bool), NoJournal> {
        let until = said.last().map_or(0.0, |line| line.time);
        let stretch = (until / STRETCHES).max(1.0);
        let mut same = true;
        for (index, line) in said.iter().enumerate() {
            while self.world.time() < line.time {
                tell(Resuming { time: self.world.time(), until });
                self.world.advance(line.time.min(self.world.time() + stretch));
            }
            match &line.entry {
                Entry::Records(count) => same &= *count == self.world.records(),
                entry => self.world.replay(entry).map_err(|why| journal.broken(index, why))?,
            }
        }
        self.notes.journal = Some(journal);
        self.clock = Clock::standing(self.world.time(), self.clock.speed());
        Ok((self.world.time(), same))
    }

    /// Starts the thread of the mission; the clock runs from the start if `runs` is set.
    pub fn start(mut self, runs: bool) -> (Handle, JoinHandle<()>) {
        self.clock.set(runs, Instant::now());
        let (asks, asked) = sync_channel(QUEUE);
        let (publish, published) = watch::channel(Arc::new(self.view()));
        let thread = std::thread::spawn(move || self.run(&asked, &publish));
        (Handle { asks, published }, thread)
    }

    fn run(&mut self, asked: &Receiver<Asked>, publish: &watch::Sender<Arc<Published>>) {
        let (mut shown, mut beat) = (Instant::now(), Instant::now());
        loop {
            let received = asked.recv_timeout(if self.behind() > PATIENCE { Duration::ZERO } else { TICK });
            let before = self.stands();
            let now = Instant::now();
            self.advance(self.clock.at(now));
            let mut answered = None;
            match received {
                Ok(Asked { tells, answer }) => {
                    answered = Some((answer, self.take(tells)));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            // After an error, also retry while the clock is stopped: there may be space again.
            if (self.clock.runs() || self.notes.trouble.is_some()) && now.duration_since(beat) >= self.beat {
                beat = now;
                self.beat();
            }
            let changed = answered.is_some() || before != self.stands();
            if changed || (self.clock.runs() && now.duration_since(shown) >= FRAME) {
                shown = now;
                publish.send_replace(Arc::new(self.view()));
            }
            // Publish before replying, so that the reply never precedes the page update.
            if let Some((answer, taken)) = answered {
                let _ = answer.send(taken);
            }
        }
        self.beat();
        publish.send_replace(Arc::new(self.view()));
    }

    /// State whose changes are published immediately.
    fn stands(&self) -> (usize, bool, bool) {
        (self.world.records(), self.clock.runs(), self.notes.trouble.is_some())
    }

    fn beat(&mut self) {
        let (time, count) = (self.world.time(), self.world.records());
        // On failure the notes keep the error, and pages show it.
        let _ = self.notes.write(time, Entry::Records(count));
    }

    /// Advances time in short steps, up to a maximum duration: reports may be waiting.
    fn advance(&mut self, to: f64) {
        let begun = Instant::now();
        let stretch = self.clock.speed() * TICK.as_secs_f64();
        while to > self.world.time() && begun.elapsed() < PATIENCE {
            self.world.advance(to.min(self.world.time() + stretch));
        }
    }

    /// Returns the delay of the mission behind its clock.
    fn behind(&self) -> Duration {
        let seconds = (self.clock.at(Instant::now()) - self.world.time()) / self.clock.speed();
        Duration::try_from_secs_f64(seconds).unwrap_or_default()
    }

    fn view(&self) -> Published {
        let clock = ClockView { time: self.world.time(), speed: self.clock.speed(), running: self.clock.runs() };
        let mut shown = self.world.shown(clock.running);
        let behind = Some(self.behind()).filter(|behind| *behind >= LAGS);
        if let Some(behind) = behind {
            let lags = format!(
                "The mission is {:.0} s behind its clock: planning takes longer than a speed of {} allows.",
                behind.as_secs_f64(),
                self.clock.speed()
            );
            shown.supervisor.note = joined(shown.supervisor.note, &lags);
        }
        if let Some(why) = &self.notes.trouble {
            let refused = format!("What is told cannot be written down, and is refused: {why}.");
            shown.supervisor.note = joined(shown.supervisor.note, &refused);
            for person in &mut shown.people {
                person.note = joined(
                    person.note.take(),
                    "What you press cannot be noted now and has no effect. Tell the supervisor, whose page says why.",
                );
            }
        }
        Published {
            mission: self.mission.clone(),
            clock,
            behind,
            unwritten: self.notes.trouble.clone(),
            people: shown.people,
            supervisor: shown.supervisor,
            plan: shown.plan,
            map: shown.map,
        }
    }

    fn take(&mut self, tells: Tells) -> Answer {
        let Engine { world, notes, .. } = self;
        let time = world.time();
        let mut note = |entry: Entry| notes.write(time, entry);
        match tells {
            Tells::Person(agent, tells) => {
                if !self.clock.runs() && !matches!(tells, PersonTells::Feedback { .. }) {
                    return Err("The clock of the mission stands: nothing was noted.".into());
                }
                world.person(agent, tells, &mut note)
            }
            Tells::Supervisor(tells @ (SupervisorTells::Run {} | SupervisorTells::Stop {})) => {
                let now = Instant::now();
                self.clock.set(matches!(tells, SupervisorTells::Run {}), now);
                self.advance(self.clock.at(now));
                let at = written(self.world.time());
                Ok(if self.clock.runs() {
                    format!("The clock runs from {at}.")
                } else {
                    format!("The clock stands at {at}.")
                })
            }
            Tells::Supervisor(SupervisorTells::Invite { .. }) => Err("That is not the engine's affair.".into()),
            Tells::Supervisor(tells) => world.supervisor(tells, &mut note),
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
    use crate::engine::world::{Note, Shown};
    use crate::lines::tests::{Faults, Faulty};
    use crate::view::SupervisorView;

    /// A mission in which every step takes longer than real time.
    struct Slow(f64);

    impl World for Slow {
        fn time(&self) -> f64 {
            self.0
        }
        fn records(&self) -> usize {
            0
        }
        fn advance(&mut self, to: f64) {
            std::thread::sleep(2 * TICK);
            self.0 = to;
        }
        fn replay(&mut self, _: &Entry) -> Result<(), String> {
            Ok(())
        }
        fn shown(&self, _: bool) -> Shown {
            let supervisor = SupervisorView {
                status: String::new(),
                numbers: String::new(),
                over: None,
                note: None,
                moves: false,
                agents: Vec::new(),
                robots: Vec::new(),
                events: Vec::new(),
                drawing: 0,
            };
            Shown { people: Vec::new(), supervisor, plan: Arc::default(), map: None }
        }
        fn person(&mut self, _: usize, _: PersonTells, _: &mut Note<'_>) -> Answer {
            Ok("Noted.".into())
        }
        fn supervisor(&mut self, _: SupervisorTells, note: &mut Note<'_>) -> Answer {
            note(Entry::Records(7))?;
            Ok("Noted.".into())
        }
    }

    /// On a full disk nothing is recorded, and pages report that with and without presses; once there is space again,
    /// they stop reporting it, and new entries are written.
    #[test]
    fn a_journal_that_cannot_be_written_is_said_and_tried_again() {
        let disk = Faulty::default();
        let mut engine = Engine::new("slow", Box::new(Slow(0.0)), 1.0);
        (engine.notes.journal, engine.beat) = (Some(Journal::on(disk.clone())), 2 * TICK);
        let (handle, thread) = engine.start(false);
        let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
        let press = || runtime.block_on(handle.tell(Tells::Supervisor(SupervisorTells::Replan {}))).expect("an answer");
        let until = |refused: bool| {
            let begun = Instant::now();
            while handle.published.borrow().unwritten.is_some() != refused {
                assert!(begun.elapsed() < Duration::from_secs(20), "pages do not say {refused}");
                std::thread::sleep(TICK);
            }
        };
        let full = Faults { room: Some(9), ..Faults::default() };
        disk.set(full);
        assert!(press().expect_err("full").starts_with("Nothing was changed, because it could not be written down"));
        let note = handle.published.borrow().supervisor.note.clone();
        assert!(note.is_some_and(|note| note.contains("cannot be written down, and is refused")));
        assert_eq!(disk.holds(), "");
        // No presses, with a stopped clock.
        disk.set(Faults::default());
        until(false);
        assert_eq!(press(), Ok("Noted.".into()));
        // No presses, with a running clock.
        disk.set(full);
        runtime.block_on(handle.tell(Tells::Supervisor(SupervisorTells::Run {}))).expect("an answer").expect("runs");
        until(true);
        disk.set(Faults::default());
        until(false);
        drop(handle);
        thread.join().expect("ended");
        let lines: Vec<Line> = disk.holds().lines().map(|line| serde_json::from_str(line).expect("whole")).collect();
        assert!(lines.iter().any(|line| line.entry == Entry::Records(7)), "{lines:?}");
    }

    #[test]
    fn a_mission_that_lags_says_so_and_still_answers() {
        let (handle, thread) = Engine::new("slow", Box::new(Slow(0.0)), 100.0).start(true);
        let begun = Instant::now();
        let lags = |handle: &Handle| handle.published.borrow().supervisor.note.clone();
        while lags(&handle).is_none() {
            assert!(begun.elapsed() < Duration::from_secs(20), "it does not say so");
            std::thread::sleep(TICK);
        }
        assert!(lags(&handle).is_some_and(|note| note.contains("behind its clock")));
        assert!(handle.published.borrow().behind.is_some_and(|behind| behind >= LAGS));
        let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
        let asked = Instant::now();
        let tells = Tells::Person(0, PersonTells::Done { operation: 0 });
        assert_eq!(runtime.block_on(handle.tell(tells)), Some(Ok("Noted.".into())));
        assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
        drop(handle);
        thread.join().expect("ended");
    }
}
