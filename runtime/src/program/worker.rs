//! Members of a mission that run controllers of their own while the mission is executed: working robots, and robots that are
//! driven.

use mission::kind::Mission;
use serde::{Deserialize, Serialize};

use super::check::ensure;
use super::{
    DriveProgram, MachineProgram, MissionMeasure, MissionScenarioProgram, Program, ProgramError, ScenarioProgram,
    Subject, error,
};

/// The most working robots of a mission that run controllers.
pub const MAX_RUNNING: usize = 16;

/// The most ticks of all controllers of a scenario together.
pub const MAX_TICKS: f64 = 2e7;

/// A controller that working robots run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControllerProgram {
    /// The spec that it comes from, as the mission names it.
    pub spec: String,
    /// It.
    pub program: Program,
}

/// A member that runs a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkerProgram {
    /// Index of the member.
    pub member: usize,
    /// Index of the controller among those of the mission.
    pub controller: usize,
    /// The job of the controller in the mission.
    #[serde(flatten)]
    pub job: Job,
    /// The world around the robot, its start and its simulator; nothing is expected there, and its duration does not count.
    pub world: ScenarioProgram,
}

/// Job of a controller in its mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Job {
    /// It performs operations.
    Operations {
        /// The signal of the controller, a flag, that is true while an operation goes on.
        go: usize,
        /// The state of its machine that ends an operation when it is entered.
        done: usize,
    },
    /// It drives the base along the planned way.
    Drive(DriveProgram),
}

/// Controllers of a mission's members, for its execution.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Running {
    /// Controllers, each of another spec.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub controllers: Vec<ControllerProgram>,
    /// Members that run controllers, each at most once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub workers: Vec<WorkerProgram>,
}

impl Running {
    /// True where nobody runs a controller.
    pub fn is_empty(&self) -> bool {
        self.workers.is_empty()
    }

    /// Index of the controller of a spec, which is added if it is not known.
    pub fn add(&mut self, spec: &str, program: Program) -> usize {
        let known = self.controllers.iter().position(|c| c.spec == spec);
        known.unwrap_or_else(|| {
            let program = Program { scenarios: Vec::new(), ..program };
            self.controllers.push(ControllerProgram { spec: spec.to_string(), program });
            self.controllers.len() - 1
        })
    }

    /// The controller of a member.
    pub fn controller(&self, worker: &WorkerProgram) -> Option<&ControllerProgram> {
        self.controllers.get(worker.controller)
    }

    /// The working robot that is this agent, with its controller.
    pub fn of(&self, member: usize) -> Option<(&WorkerProgram, &ControllerProgram)> {
        let worker = self.workers.iter().find(|w| w.member == member)?;
        Some((worker, self.controller(worker)?))
    }

    /// Number of ticks of all controllers together in this duration (s).
    pub fn ticks(&self, duration: f64) -> f64 {
        let rate = |w| self.controller(w).map_or(0.0, |c| 1.0 / c.program.robot.period);
        self.workers.iter().map(rate).sum::<f64>() * duration
    }

    /// Makes sure that all can be run; what the compiler gives always can.
    pub(super) fn check(&self, mission: &dyn Mission) -> Result<(), ProgramError> {
        ensure(self.workers.len() <= MAX_RUNNING, "workers", "more than 16 run controllers")?;
        for (i, c) in self.controllers.iter().enumerate() {
            let own = |e: ProgramError| error(format!("controllers[{i}].{}", e.place), e.message);
            c.program.check().map_err(own)?;
        }
        let members = mission.members();
        for (i, w) in self.workers.iter().enumerate() {
            let place = format!("workers[{i}]");
            let known = w.member < members.len()
                && match w.job {
                    Job::Operations { .. } => mission.work_of(w.member) > 0,
                    Job::Drive(_) => mission.drivable(w.member).is_some(),
                };
            let again = self.workers[..i].iter().any(|o| o.member == w.member);
            ensure(known && !again, &place, "runs no controller, or two")?;
            let controller = self.controller(w).ok_or_else(|| error(&place, "its controller does not exist"))?;
            w.check(&controller.program, mission, &place)?;
        }
        Ok(())
    }

    /// Makes sure that a scenario of a checked mission can be run with these.
    pub(super) fn check_scenario(&self, scenario: &MissionScenarioProgram, place: &str) -> Result<(), ProgramError> {
        let few = !scenario.sampled || self.ticks(scenario.duration) <= MAX_TICKS;
        ensure(few, &format!("{place}.duration"), "the controllers of working robots would have more than 2e7 ticks")?;
        for measure in &scenario.measures {
            let MissionMeasure::In(member, state) = *measure else { continue };
            let machine = self.of(member).and_then(|(w, c)| w.machine(&c.program));
            let good = machine.is_some_and(|m| state < m.states.len());
            ensure(good, &format!("{place}.measures"), "measures a state that does not exist")?;
        }
        Ok(())
    }
}

impl WorkerProgram {
    /// The machine that runs; none: a stack does.
    pub fn machine<'p>(&self, of: &'p Program) -> Option<&'p MachineProgram> {
        of.machine.as_ref().filter(|_| self.world.run.subject == Subject::Machine)
    }

    /// Its drive, if it drives.
    pub fn drive(&self) -> Option<&DriveProgram> {
        match &self.job {
            Job::Drive(drive) => Some(drive),
            Job::Operations { .. } => None,
        }
    }

    fn check(&self, program: &Program, mission: &dyn Mission, place: &str) -> Result<(), ProgramError> {
        let world = &self.world;
        match &self.job {
            Job::Operations { go, done } => {
                let flag = program.interface.signals.get(*go).is_some_and(|s| s.len == 1 && !s.is_variable());
                ensure(flag, &format!("{place}.go"), "is no signal that can be true")?;
                let machine = self.machine(program);
                ensure(machine.is_some(), &format!("{place}.world"), "runs no machine")?;
                let state = machine.is_some_and(|m| (1..m.states.len()).contains(done));
                ensure(state, &format!("{place}.done"), "is no state")?;
            }
            Job::Drive(drive) => drive.check(program, world, mission, place)?,
        }
        let bare = world.measures.is_empty() && world.predicates.is_empty() && world.expectations.is_empty();
        ensure(bare, &format!("{place}.world"), "expects something")?;
        let alone = Program { scenarios: vec![world.clone()], ..program.clone() };
        alone.check().map_err(|e| error(format!("{place}.world: {}", e.place), e.message))
    }
}
