//! A controller with its simulated robot, in the world of a scenario or without one: what happens at a tick.

use crate::controller::{Controller, Observation};
use crate::fault::Fault;
use crate::program::{Program, ProgramError, ScenarioProgram};
use crate::simulated_robot::SimulatedRobot;
use crate::world::World;

/// A loop that is closed: what the controller commands moves the robot that it observes.
pub(crate) struct ClosedLoop {
    pub controller: Controller,
    pub robot: SimulatedRobot,
    pub world: Option<World>,
    /// The command of the last tick that came in time.
    pub velocity: Vec<f64>,
    /// Its fault.
    pub fault: Option<Fault>,
    started: bool,
}

impl ClosedLoop {
    /// Makes a program ready. That of a scenario is [`ScenarioProgram::program`].
    ///
    /// # Errors
    /// The program cannot be executed.
    pub fn new(program: &Program, scenario: Option<&ScenarioProgram>) -> Result<ClosedLoop, ProgramError> {
        let controller = Controller::new(program)?;
        Ok(ClosedLoop {
            velocity: vec![0.0; controller.velocity().len()],
            robot: SimulatedRobot::new(program),
            world: scenario.map(|s| World::new(program, s)),
            fault: None,
            started: false,
            controller,
        })
    }

    /// A tick, at a time in s: the world and then `tell` say what the controller is told, the robot is observed, and the
    /// controller answers. Gives how long that took by `clock`, in s; 0 where the tick comes late.
    pub fn tick(&mut self, time: f64, clock: &mut dyn FnMut() -> f64, tell: impl FnOnce(&mut Controller)) -> f64 {
        // The first tick tells the controller where it is: it cannot be late.
        if std::mem::replace(&mut self.started, true) && self.world.as_ref().is_some_and(|w| w.is_late(time)) {
            return 0.0;
        }
        if let Some(world) = &mut self.world {
            world.tell(&mut self.controller, self.robot.q(), time);
        }
        tell(&mut self.controller);
        let measured = self.robot.measure();
        let q = self.world.as_mut().map_or(measured, |w| w.observe(measured, time));
        let before = clock();
        let command = self.controller.step(&Observation { time, q });
        let elapsed = clock() - before;
        self.fault = command.fault;
        self.velocity.copy_from_slice(command.velocity);
        if let Some(world) = &mut self.world {
            let requests = command.requests.to_vec();
            world.ask(&self.controller, &requests, time);
        }
        elapsed
    }

    /// The robot moves until the next tick as it was commanded.
    pub fn apply(&mut self) {
        self.robot.apply(&self.velocity);
    }
}
