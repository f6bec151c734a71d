//! Members that run their controllers while a mission is executed.
//!
//! Each has a simulated robot and a world of its own, and ticks in step with the time of the mission. A signal tells the machine
//! of a working robot that an operation goes on; when the machine enters a state, the operation has ended. Another one drives
//! the base of its robot along the planned way (`drive`), which ends when the base arrives. What keeps a robot from ever going
//! on makes it lost. Nothing ticks while a robot is lost, or behind the end of the mission.

use mission::kind::{Event, Execution, WorkState};
use serde::Serialize;

use crate::closed_loop::ClosedLoop;
use crate::controller::Controller;
use crate::fault::Fault;
use crate::program::{Job, MissionProgram, MissionScenarioProgram, ProgramError, WorkerProgram, error};

use super::drive::{Drive, DriveRecord};

/// The most faults of a controller that are told of.
const MOST_FAULTS: usize = 100;

/// Results of the controller of a member.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorkerRecord {
    /// The member.
    pub name: String,
    /// The spec whose controller it ran.
    pub spec: String,
    /// Number of ticks of the controller.
    pub ticks: u64,
    /// Duration of each operation or way that it ended, in s.
    pub operations_s: Vec<f64>,
    /// Record of its base, if it drives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive: Option<DriveRecord>,
    /// The state that its machine was in at the end.
    pub state: String,
    /// Its last breakdown, if it had one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub broke_down: Option<BrokeDown>,
}

impl WorkerRecord {
    /// Result of its work, in a sentence without its subject.
    pub fn describe(&self) -> String {
        let took: Vec<String> = self.operations_s.iter().map(|s| format!("{s:.1} s")).collect();
        let took = if took.is_empty() { "none has ended".to_string() } else { took.join(", ") };
        match &self.drive {
            None => format!("its operations took: {took}"),
            Some(DriveRecord { travelled_m, off_way_m }) => {
                format!("its ways took: {took}; it drove {travelled_m:.1} m, at most {off_way_m:.2} m off its way")
            }
        }
    }
}

/// Breakdown of a member that runs a controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BrokeDown {
    /// When, in s.
    pub at_s: f64,
    /// Why, in words.
    pub why: String,
}

/// Effect of a controller's tick on the mission.
enum Came {
    Ended,
    Broken(String),
}

/// Job of a controller in the mission.
enum Doing {
    /// It performs operations.
    Operations {
        go: usize,
        /// State of the machine that ends an operation.
        done: usize,
        /// It stood in the state that ends an operation at the last tick, or has not ticked yet.
        inside: bool,
    },
    Drives(Drive),
}

/// A member that runs a controller.
struct Worker {
    member: usize,
    name: String,
    label: String,
    spec: String,
    closed: ClosedLoop,
    doing: Doing,
    period: f64,
    /// Time of the mission at which its clock was 0, in s.
    base: f64,
    ticks: u64,
    standing: WorkState,
    /// Start of the operation under way, in s.
    began: f64,
    /// There was a fault at the last tick.
    faulty: bool,
    operations: Vec<f64>,
    broke_down: Option<BrokeDown>,
    faults: usize,
}

/// All of them.
pub struct Workers {
    all: Vec<Worker>,
    /// Log entries of the controllers: time in s, and text.
    pub(super) notes: Vec<(f64, String)>,
    /// The mission is at its end.
    still: bool,
}

/// The seed of the world around the member of this number.
fn seed_of(seed: u64, number: usize) -> u64 {
    let mut x = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (number as u64).wrapping_add(1);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

impl Worker {
    fn new(w: &WorkerProgram, mission: &MissionProgram, seed: u64) -> Result<Worker, ProgramError> {
        let missing = || error("workers", "a controller does not exist");
        let of = mission.running.controller(w).ok_or_else(missing)?;
        let members = mission.kind.members();
        let name = members.get(w.member).map(|member| member.name.to_string()).unwrap_or_default();
        // Robots that serve have no world of their own: another one in the team changes no seed.
        let number = match w.job {
            Job::Operations { .. } => members.iter().take(w.member).filter(|member| member.role != "robot").count(),
            Job::Drive(_) => w.member,
        };
        let mut world = w.world.clone();
        world.run.simulator.seed = seed_of(seed, number);
        let program = world.program(&of.program);
        let closed = ClosedLoop::new(&program, Some(&world))?;
        let doing = match &w.job {
            Job::Operations { go, done } => Doing::Operations { go: *go, done: *done, inside: true },
            Job::Drive(drive) => Doing::Drives(Drive::new(drive, w.member)),
        };
        Ok(Worker {
            member: w.member,
            label: mission.kind.labels().member(&name).to_string(),
            name,
            spec: of.spec.clone(),
            doing,
            period: program.robot.period,
            base: 0.0,
            ticks: 0,
            standing: WorkState::Waits,
            began: 0.0,
            faulty: false,
            operations: Vec::new(),
            broke_down: None,
            faults: 0,
            closed,
        })
    }

    /// Time of its next tick, in s of the mission; `None` while it is lost.
    fn next(&self) -> Option<f64> {
        (self.standing != WorkState::Lost).then_some(self.base + self.ticks as f64 * self.period)
    }

    /// Its clock, which stood for a time, goes on at this time of the mission.
    fn resume(&mut self, now: f64) {
        self.base = self.base.max(now - self.ticks as f64 * self.period);
    }

    fn tick(&mut self, execution: &mut dyn Execution, notes: &mut Vec<(f64, String)>) -> Option<Came> {
        let (now, time) = (self.next()?, self.ticks as f64 * self.period);
        self.ticks += 1;
        let ended = match &mut self.doing {
            Doing::Operations { go, done, inside } => {
                let go_on = if self.standing == WorkState::Works { 1.0 } else { -1.0 };
                self.closed.tick(time, &mut || 0.0, |controller| {
                    controller.signals().set(*go, &[go_on], time);
                });
                let within = self.closed.controller.is_in(*done);
                let before = std::mem::replace(inside, within);
                within && !before
            }
            Doing::Drives(drive) => {
                let base = self.closed.robot.q().get(..3).unwrap_or_default();
                let told = drive.look(base, now, self.closed.world.as_mut(), execution);
                self.closed.tick(time, &mut || 0.0, |controller| {
                    if let Some(told) = &told {
                        drive.tell(told, controller, time);
                    }
                });
                told.is_some_and(|told| told.arrived)
            }
        };
        let controller = &self.closed.controller;
        let fault = self.closed.fault;
        let faulty = std::mem::replace(&mut self.faulty, fault.is_some());
        let text = fault.filter(|_| !faulty).map(|fault| controller.describe(&fault));
        let came = match self.standing {
            WorkState::Works if ended => Some(Came::Ended),
            WorkState::Over => None,
            _ => broken(controller, fault),
        };
        if let Some(text) = text.filter(|_| self.faults < MOST_FAULTS) {
            self.faults += 1;
            notes.push((now, format!("the controller of {} has a fault: {text}", self.label)));
        }
        self.closed.apply();
        match self.closed.robot.failure() {
            Some(why) if self.standing != WorkState::Over => Some(Came::Broken(why.to_string())),
            _ => came,
        }
    }
}

/// Returns the breakdown if a controller cannot continue. `fault` is that of this tick.
fn broken(controller: &Controller, fault: Option<Fault>) -> Option<Came> {
    if let Some(fault) = fault.filter(|_| controller.is_halted()) {
        return Some(Came::Broken(controller.describe(&fault)));
    }
    let ended = || format!("its machine has come to its end in `{}`", controller.state());
    controller.is_final().then(|| Came::Broken(ended()))
}

impl Workers {
    /// Of a scenario of a checked mission.
    ///
    /// # Errors
    /// A controller cannot be run; those of compiled missions always can.
    pub(super) fn new(mission: &MissionProgram, scenario: &MissionScenarioProgram) -> Result<Workers, ProgramError> {
        let one = |w| Worker::new(w, mission, scenario.seed);
        let all = scenario.running(mission).iter().map(one).collect::<Result<_, _>>()?;
        Ok(Workers { all, notes: Vec::new(), still: false })
    }

    /// Their names, in the order of [`MissionScenarioProgram::running`].
    pub fn names(&self) -> Vec<String> {
        self.all.iter().map(|w| w.name.clone()).collect()
    }

    /// The states that their machines are in, in the order of [`MissionScenarioProgram::running`].
    pub fn states(&self) -> impl Iterator<Item = &str> {
        self.all.iter().map(|w| w.closed.controller.state())
    }

    /// Returns true if the machine of an agent is in a state, or in one inside it; `None` if the agent runs no machine.
    pub(super) fn is_in(&self, member: usize, state: usize) -> Option<bool> {
        let controller = &self.of(member)?.closed.controller;
        Some(controller.is_in(state))
    }

    /// Returns true if the controller of an agent has broken down.
    pub(super) fn has_faulted(&self, member: usize) -> bool {
        self.of(member).is_some_and(|w| w.broke_down.is_some() && w.standing == WorkState::Lost)
    }

    fn of(&self, member: usize) -> Option<&Worker> {
        self.all.iter().find(|w| w.member == member)
    }

    /// Looks at what the mission has come to.
    pub(super) fn look(&mut self, execution: &dyn Execution) {
        let now = execution.time();
        let went = std::mem::replace(&mut self.still, execution.done().is_some()) && !self.still;
        for w in &mut self.all {
            let Some(work) = execution.work(w.member) else { continue };
            let standing = work.state;
            let before = std::mem::replace(&mut w.standing, standing);
            // A way may follow another one at once.
            let drives = matches!(w.doing, Doing::Drives(_));
            if standing == WorkState::Works && (drives || before != WorkState::Works) {
                w.began = work.since;
            }
            if before == WorkState::Lost && standing != WorkState::Lost {
                // Whoever brought it back has mended it, and started it anew.
                w.closed.controller.restart();
                if let Doing::Operations { inside, .. } = &mut w.doing {
                    *inside = true;
                }
                w.faulty = false;
                w.resume(now);
            } else if went {
                w.resume(now);
            }
        }
    }

    /// Lets controllers tick that are due before a time, or at it where `inclusive`; ends at the first tick that the mission
    /// must know of, and gives when that was, in s, and what it is to be told.
    pub(super) fn work(&mut self, until: f64, inclusive: bool, execution: &mut dyn Execution) -> Option<(f64, Event)> {
        if self.still {
            return None;
        }
        loop {
            let due = self.all.iter().enumerate().filter_map(|(i, w)| Some((w.next()?, i)));
            let (now, i) = due.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
            if now > until || (now == until && !inclusive) {
                return None;
            }
            let w = self.all.get_mut(i)?;
            match w.tick(execution, &mut self.notes) {
                None => {}
                Some(Came::Ended) => {
                    w.operations.push(now - w.began);
                    return Some((now, Event::of("done", w.member)));
                }
                Some(Came::Broken(why)) => {
                    w.broke_down = Some(BrokeDown { at_s: now, why });
                    return Some((now, Event::of("lost", w.member)));
                }
            }
        }
    }

    /// Results of each controller.
    pub(super) fn records(&self) -> Vec<WorkerRecord> {
        let one = |w: &Worker| WorkerRecord {
            name: w.name.clone(),
            spec: w.spec.clone(),
            ticks: w.ticks,
            operations_s: w.operations.clone(),
            drive: match &w.doing {
                Doing::Drives(drive) => Some(drive.record.clone()),
                Doing::Operations { .. } => None,
            },
            state: w.closed.controller.state().to_string(),
            broke_down: w.broke_down.clone(),
        };
        self.all.iter().map(one).collect()
    }
}
