//! Closed loop of a controller and its simulated robot, with or without the world of a scenario.

use crate::controller::{Controller, Observation};
use crate::fault::Fault;
use crate::physics::{Around, Drives};
use crate::program::{Program, ProgramError, ScenarioProgram};
use crate::simulated_robot::SimulatedRobot;
use crate::world::World;

/// Controller and simulated robot in a closed loop: the commanded velocity moves the robot that the controller
/// observes.
pub(crate) struct ClosedLoop {
    pub controller: Controller,
    pub robot: SimulatedRobot,
    pub world: Option<World>,
    /// Velocity command of the last tick that was not late.
    pub velocity: Vec<f64>,
    /// Position command of that tick.
    position: Vec<f64>,
    /// Fault of that tick.
    pub fault: Option<Fault>,
    /// Table of signals at the last tick, with the true motion of people and of what is tracked.
    pub signals: Vec<f64>,
    /// Time of the last tick (s).
    time: f64,
    started: bool,
}

impl ClosedLoop {
    /// Prepares a program for execution. The program of a scenario is [`ScenarioProgram::program`].
    ///
    /// # Errors
    /// The program cannot be executed.
    pub fn new(program: &Program, scenario: Option<&ScenarioProgram>) -> Result<ClosedLoop, ProgramError> {
        let controller = Controller::new(program)?;
        Ok(ClosedLoop {
            velocity: vec![0.0; controller.velocity().len()],
            position: program.robot.home.clone(),
            robot: SimulatedRobot::of_run(program, scenario)?,
            world: scenario.map(|s| World::new(program, s)),
            fault: None,
            signals: program.interface.absent(),
            time: 0.0,
            started: false,
            controller,
        })
    }

    /// Executes the tick at `time` (s): the world and then `tell` pass signals and events to the controller, the robot
    /// is observed, and the controller steps. Returns the duration of the step by `clock` (s), or 0 if the tick is
    /// late.
    pub fn tick(&mut self, time: f64, clock: &mut dyn FnMut() -> f64, tell: impl FnOnce(&mut Controller)) -> f64 {
        // The first tick sets the reference of the controller, so it is never late.
        self.time = time;
        if std::mem::replace(&mut self.started, true) && self.world.as_ref().is_some_and(|w| w.is_late(time)) {
            self.look();
            return 0.0;
        }
        if let Some(world) = &mut self.world {
            world.send(&mut self.controller, self.robot.q(), time);
        }
        tell(&mut self.controller);
        let measured = self.robot.measure();
        let q = self.world.as_mut().map_or(measured, |w| w.observe(measured, time));
        let before = clock();
        let command = self.controller.step(&Observation { time, q });
        let elapsed = clock() - before;
        self.fault = command.fault;
        self.velocity.copy_from_slice(command.velocity);
        self.position.copy_from_slice(command.position);
        if let Some(world) = &mut self.world {
            let requests = command.requests.to_vec();
            world.ask(&self.controller, &requests, time);
        }
        self.look();
        elapsed
    }

    /// Updates the table of signals.
    fn look(&mut self) {
        self.signals.copy_from_slice(self.controller.signal_table());
        if let Some(world) = &self.world {
            world.truth(self.time, &mut self.signals);
        }
    }

    /// Moves the robot with the last command until the next tick.
    pub fn apply(&mut self) {
        let drives = Drives { velocity: &self.velocity, position: &self.position };
        self.robot.apply_among(drives, &Around { time: self.time, signals: &self.signals });
    }
}
