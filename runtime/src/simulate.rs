//! Runs a program on the simulated robot and passes every tick to a recorder.

use solver::Problem;

use crate::closed_loop::ClosedLoop;
use crate::controller::Controller;
use crate::evaluator::{Evaluator, TickInputs};
use crate::program::{Program, ProgramError, ScenarioProgram, Times};
use crate::tick::{Recorder, Tick};

/// Reason why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The program cannot be executed.
    #[error(transparent)]
    Program(ProgramError),
    /// A recorder failed.
    #[error(transparent)]
    Record(std::io::Error),
}

/// Stacks at the robot's true configuration, which the controller does not know.
struct Truth {
    /// Evaluator and problem of each stack.
    stacks: Vec<(Evaluator, Problem)>,
    /// Last visit to a stack that was seen.
    visit: Option<u64>,
    /// Command of the previous tick.
    last: Vec<f64>,
    /// Velocity of the controller's stack at the previous tick.
    stack_velocity: Vec<f64>,
}

/// A run in progress.
pub struct Simulation {
    closed: ClosedLoop,
    truth: Option<Truth>,
    period: f64,
    ticks: usize,
}

impl Truth {
    fn tick(&mut self, controller: &Controller, q: &[f64], time: f64, signals: &[f64], velocity: &[f64]) -> &Evaluator {
        let active = controller.active_stack();
        let times = Times { t: time - controller.stack_entered(), time };
        let anew = self.visit != Some(controller.visit());
        if anew {
            self.stack_velocity.copy_from_slice(&self.last);
        }
        let inputs = TickInputs { times, signals, velocity: &self.last, stack_velocity: &self.stack_velocity };
        if anew {
            self.stacks[active].0.follow_parts(controller.evaluator());
            if let Some(from) = controller.carried_from().filter(|from| *from != active) {
                let (low, high) = self.stacks.split_at_mut(from.max(active));
                let (low, high) = (&mut low[from.min(active)].0, &mut high[0].0);
                let (own, from) = if from < active { (high, low) } else { (low, high) };
                own.take_over(from, controller.carried());
            }
        }
        let (evaluator, problem) = &mut self.stacks[active];
        evaluator.follow(controller.evaluator());
        if anew {
            self.visit = Some(controller.visit());
            evaluator.enter_fresh(q, inputs);
            if controller.is_blending() {
                evaluator.hand_over();
            }
        }
        // A fault of the monitors alone is not one of the controller: their last valid numbers are kept.
        let _ = evaluator.update(q, inputs, problem);
        evaluator.observe(q, velocity);
        self.last.copy_from_slice(velocity);
        self.stack_velocity.copy_from_slice(controller.stack_velocity());
        evaluator
    }
}

impl Simulation {
    /// Prepares a program for a run.
    ///
    /// # Errors
    /// The program cannot be executed.
    pub fn new(program: &Program) -> Result<Simulation, ProgramError> {
        Simulation::among(program, None)
    }

    /// Prepares a program for a run in the world of a scenario. The program is that of [`ScenarioProgram::program`].
    ///
    /// # Errors
    /// The program cannot be executed.
    pub fn in_world(program: &Program, scenario: &ScenarioProgram) -> Result<Simulation, ProgramError> {
        Simulation::among(program, Some(scenario))
    }

    fn among(program: &Program, scenario: Option<&ScenarioProgram>) -> Result<Simulation, ProgramError> {
        let closed = ClosedLoop::new(program, scenario)?;
        let seen = !scenario.is_some_and(|s| s.world.disturbs());
        let truth = if closed.robot.is_perfect() && program.robot.home_is_legal() && seen {
            None
        } else {
            let moved = scenario.and_then(|s| s.true_program(program));
            let truth = moved.as_ref().unwrap_or(program);
            Some(Truth {
                stacks: closed.controller.stacks().iter().map(|s| s.again(truth)).collect::<Result<_, _>>()?,
                visit: None,
                last: vec![0.0; program.robot.model.nv()],
                stack_velocity: vec![0.0; program.robot.model.nv()],
            })
        };
        let ticks = (program.run.duration / program.robot.period).round() as usize;
        Ok(Simulation { closed, truth, period: program.robot.period, ticks })
    }

    /// The controller.
    pub fn controller(&self) -> &Controller {
        &self.closed.controller
    }

    /// Number of ticks of the run.
    pub fn ticks(&self) -> usize {
        self.ticks
    }

    /// Runs to the end, or until `go_on` returns false, or until the simulation of a robot with masses has diverged, which is told
    /// to the recorder. `clock` returns seconds; the run does not depend on it.
    ///
    /// # Errors
    /// A recorder failed.
    pub fn run(
        &mut self,
        recorder: &mut dyn Recorder,
        clock: &mut dyn FnMut() -> f64,
        go_on: &mut dyn FnMut(usize) -> bool,
    ) -> Result<(), RunError> {
        if let Some(plant) = self.closed.robot.plant() {
            recorder.moved_by(plant);
        }
        for index in 0..self.ticks {
            if !go_on(index) {
                break;
            }
            let time = index as f64 * self.period;
            let elapsed = self.closed.tick(time, clock, |_| ());
            let ClosedLoop { controller, robot, velocity, fault, signals, .. } = &self.closed;
            let evaluator = match &mut self.truth {
                Some(truth) => truth.tick(controller, robot.q(), time, signals, velocity),
                None => controller.evaluator(),
            };
            let tick = Tick {
                index,
                time,
                q: robot.q(),
                v: controller.velocity(),
                stack: controller.active_stack(),
                state: controller.state(),
                state_index: controller.state_index(),
                controller,
                command: velocity,
                signals,
                evaluator,
                problem: controller.problem(),
                solution: controller.solution(),
                fault: *fault,
                elapsed,
            };
            recorder.tick(&tick).map_err(RunError::Record)?;
            self.closed.apply();
            if let Some(why) = self.closed.robot.failure() {
                recorder.diverged(&format!("at {time:.3} s {why}"));
                break;
            }
        }
        Ok(())
    }
}
