//! The thread that owns a mission under way: it lets time pass, takes what is told, and publishes what pages show.
//!
//! Planning may take a while; pages go on being served meanwhile, and what is told waits in a short queue.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mission::execution::{Doing, Event, Execution, Happening};
use mission::plan::Actor;
use tokio::sync::{oneshot, watch};

use super::clock::Clock;
use super::diary::Diary;
use super::journal::{Entry, Journal, Line};
use super::overview::supervisor;
use super::told::{PersonTells, SupervisorTells, Tells};
use super::view::{ClockView, Published, person};
use super::words::written;

/// How often time passes.
const TICK: Duration = Duration::from_millis(50);
/// How often pages are told where robots are.
const FRAME: Duration = Duration::from_millis(500);
/// How often the journal notes that all is well.
const BEAT: Duration = Duration::from_secs(10);
/// What is told and not yet taken.
const QUEUE: usize = 64;

/// What became of something that was told: what to say, or why it was refused.
pub type Answer = Result<String, String>;

struct Asked {
    tells: Tells,
    answer: oneshot::Sender<Answer>,
}

/// The way to the engine. It ends when the last of them is dropped.
#[derive(Clone)]
pub struct Handle {
    asks: SyncSender<Asked>,
    /// What pages show, the latest.
    pub published: watch::Receiver<Arc<Published>>,
}

impl Handle {
    /// Tells the engine something, and waits for what becomes of it. None: too much waits already, or the engine has ended.
    pub async fn tell(&self, tells: Tells) -> Option<Answer> {
        let (answer, answered) = oneshot::channel();
        match self.asks.try_send(Asked { tells, answer }) {
            Ok(()) => answered.await.ok(),
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => None,
        }
    }
}

/// A mission under way, with its clock, its journal and what pages remember of it.
pub struct Engine {
    mission: Arc<str>,
    execution: Execution,
    clock: Clock,
    diary: Diary,
    journal: Option<Journal>,
    /// Records that the diary has taken note of.
    noted: usize,
}

impl Engine {
    /// Stands at the start of an execution.
    pub fn new(mission: &str, execution: Execution, speed: f64) -> Engine {
        let (clock, diary) = (Clock::standing(execution.time(), speed), Diary::new(execution.problem()));
        Engine { mission: mission.into(), execution, clock, diary, journal: None, noted: 0 }
    }

    /// Goes through what a journal says, and goes on writing it. Gives the time that was reached (s), and false if the
    /// execution came to another number of records than the journal notes.
    pub fn resume(&mut self, journal: Journal, said: &[Line]) -> (f64, bool) {
        let mut same = true;
        for line in said {
            self.advance(line.time);
            match &line.entry {
                // What was refused then is refused now.
                Entry::Event(event) => {
                    let _ = self.execution.tell(*event);
                }
                Entry::Serve { agent, operation } => {
                    if let Some(page) = self.diary.page_mut(*agent) {
                        page.begin(*operation, line.time);
                    }
                }
                Entry::Served { agent } => {
                    self.diary.page_mut(*agent).and_then(|page| page.end(line.time));
                }
                Entry::Records(count) => same &= *count == self.execution.records().len(),
            }
            self.note();
        }
        self.journal = Some(journal);
        self.clock = Clock::standing(self.execution.time(), self.clock.speed());
        (self.execution.time(), same)
    }

    /// Begins a thread that carries the mission on; `runs` says whether the clock does from the start.
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
            let received = asked.recv_timeout(TICK);
            let before = (self.noted, self.clock.runs());
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
            let changed = answered.is_some() || before != (self.noted, self.clock.runs());
            if changed || (self.clock.runs() && now.duration_since(shown) >= FRAME) {
                shown = now;
                publish.send_replace(Arc::new(self.view()));
            }
            // Whoever hears that it was noted finds it on the page.
            if let Some((answer, taken)) = answered {
                let _ = answer.send(taken);
            }
            if self.clock.runs() && now.duration_since(beat) >= BEAT {
                beat = now;
                self.beat();
            }
        }
        self.beat();
    }

    fn beat(&mut self) {
        // A journal that cannot be written is said where something is told, which is refused then.
        let _ = self.write(Entry::Records(self.execution.records().len()));
    }

    fn advance(&mut self, to: f64) {
        if to > self.execution.time() {
            self.execution.advance(to);
        }
        self.note();
    }

    fn note(&mut self) {
        for record in self.execution.records().iter().skip(self.noted) {
            self.diary.note(self.execution.problem(), record);
        }
        self.noted = self.execution.records().len();
    }

    fn view(&self) -> Published {
        let (execution, running) = (&self.execution, self.clock.runs());
        let people = 0..execution.problem().agents.len();
        Published {
            mission: self.mission.clone(),
            clock: ClockView { time: execution.time(), speed: self.clock.speed(), running },
            people: people.map(|index| person(execution, &self.diary, index, running)).collect(),
            supervisor: supervisor(execution, &self.diary),
            plan: Arc::new(execution.plan().clone()),
            problem: Arc::new(execution.problem().clone()),
        }
    }

    fn write(&mut self, entry: Entry) -> Result<(), String> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        let line = Line { time: self.execution.time(), entry };
        journal.add(&line).map_err(|e| format!("Nothing was changed, because it could not be written down: {e}."))
    }

    /// Writes an event down and lets it happen. Gives whether the plan has moved, or was made anew.
    fn happen(&mut self, event: Event) -> Result<Followed, String> {
        self.write(Entry::Event(event))?;
        let followed = self.execution.tell(event).map(|records| Followed {
            anew: records.iter().any(|record| matches!(record.what, Happening::Reallocated { .. })),
            moved: records.iter().any(|record| matches!(record.what, Happening::Rescheduled { .. })),
        });
        self.note();
        followed.map_err(|refused| format!("That cannot be now: {refused}."))
    }

    fn take(&mut self, tells: Tells) -> Answer {
        match tells {
            Tells::Person(agent, PersonTells::Feedback { operation, wait, approach, distance }) => {
                self.feedback(agent, operation, [wait, approach, distance])
            }
            Tells::Person(..) if !self.clock.runs() => {
                Err("The clock of the mission stands: nothing was noted.".into())
            }
            Tells::Person(agent, tells) => self.person(agent, tells),
            Tells::Supervisor(tells) => self.supervisor(tells),
        }
    }

    fn person(&mut self, agent: usize, tells: PersonTells) -> Answer {
        let view = self.execution.agent(agent).ok_or("There is no such person.")?;
        let (doing, now) = (view.doing, written(self.execution.time()));
        let is = |operation: usize| view.operation == Some(operation);
        let past = |operation: usize| view.operation.is_none_or(|current| operation < current);
        match tells {
            PersonTells::Begin { operation } if is(operation) && doing == Doing::Ready => {
                self.happen(Event::Begun { agent })?;
                Ok(format!("Noted: operation {} began at {now}.", operation + 1))
            }
            PersonTells::Begin { operation } if is(operation) || past(operation) => {
                Ok(format!("Operation {} has begun already.", operation + 1))
            }
            PersonTells::Done { operation } if is(operation) && doing == Doing::Working => {
                self.happen(Event::Done { agent })?;
                Ok(format!("Noted: operation {} ended at {now}.", operation + 1))
            }
            PersonTells::Done { operation } if past(operation) || (is(operation) && doing != Doing::Ready) => {
                Ok(format!("Operation {} is finished already.", operation + 1))
            }
            PersonTells::Serve { operation } if is(operation) && doing == Doing::Served => {
                if !self.diary.page(agent).measures() {
                    self.write(Entry::Serve { agent, operation })?;
                    let time = self.execution.time();
                    if let Some(page) = self.diary.page_mut(agent) {
                        page.begin(operation, time);
                    }
                }
                Ok(format!("Noted: the service began at {now}."))
            }
            PersonTells::Served { operation } => {
                self.served(agent, operation, is(operation) && doing == Doing::Served, past(operation))
            }
            PersonTells::Serve { .. } => Err("No robot serves you now.".into()),
            PersonTells::Begin { operation }
            | PersonTells::Done { operation }
            | PersonTells::Feedback { operation, .. } => Err(format!("Operation {} is not under way.", operation + 1)),
        }
    }

    /// A service is finished, or its measurement, or both.
    fn served(&mut self, agent: usize, operation: usize, serves: bool, past: bool) -> Answer {
        let measures = self.diary.page(agent).measures();
        let mut took = None;
        if measures {
            self.write(Entry::Served { agent })?;
            let time = self.execution.time();
            took = self.diary.page_mut(agent).and_then(|page| page.end(time));
        }
        let measured = took.map(|took| format!(" You measured {took:.0} s.")).unwrap_or_default();
        match (serves, measures || past) {
            (true, _) => {
                self.happen(Event::Served { agent })?;
                Ok(format!("Noted: the service of operation {} is finished.{measured}", operation + 1))
            }
            (false, true) => Ok(format!("The service is finished.{measured}")),
            (false, false) => Err("No robot serves you now.".into()),
        }
    }

    fn feedback(&mut self, agent: usize, operation: usize, [wait, approach, distance]: [i8; 3]) -> Answer {
        match self.diary.page(agent).spoken() {
            Some((last, false)) if last == operation => {
                let followed = self.happen(Event::Said { agent, wait, approach, distance })?;
                let then = match followed {
                    Followed { anew: true, .. } => "The plan was made anew.",
                    Followed { moved: true, .. } => "The plan has been adapted.",
                    _ => "It counts from now on.",
                };
                Ok(format!("Thank you. {then}"))
            }
            Some((last, _)) if operation <= last => {
                Ok("Thank you; that was noted before, or is about an earlier service.".into())
            }
            _ => Err("That service has not been.".into()),
        }
    }

    fn supervisor(&mut self, tells: SupervisorTells) -> Answer {
        match tells {
            SupervisorTells::Run {} | SupervisorTells::Stop {} => {
                let now = Instant::now();
                self.clock.set(matches!(tells, SupervisorTells::Run {}), now);
                self.advance(self.clock.at(now));
                let at = written(self.execution.time());
                Ok(if self.clock.runs() {
                    format!("The clock runs from {at}.")
                } else {
                    format!("The clock stands at {at}.")
                })
            }
            SupervisorTells::Replan {} => self.happen(Event::Replan).map(said),
            SupervisorTells::Lost { robot, agent } => self.happen(Event::Lost { who: who(robot, agent)? }).map(said),
            SupervisorTells::Back { robot, agent } => self.happen(Event::Back { who: who(robot, agent)? }).map(said),
            SupervisorTells::Moved { agent, place } => self.happen(Event::Moved { agent, place }).map(said),
            SupervisorTells::Invite { .. } => Err("That is not the engine's affair.".into()),
        }
    }
}

/// What an event led to.
struct Followed {
    anew: bool,
    moved: bool,
}

fn said(followed: Followed) -> String {
    match followed {
        Followed { anew: true, .. } => "Noted; planned anew.".into(),
        Followed { moved: true, .. } => "Noted; the plan has moved.".into(),
        _ => "Noted; the plan stays.".into(),
    }
}

fn who(robot: Option<usize>, agent: Option<usize>) -> Result<Actor, String> {
    match (robot, agent) {
        (Some(robot), None) => Ok(Actor::Robot(robot)),
        (None, Some(agent)) => Ok(Actor::Agent(agent)),
        _ => Err("Name a robot or an agent, not both.".into()),
    }
}
