//! Simulated world of a scenario: the values that it sends, its answers to requests, and its disturbances.
//!
//! All random numbers come from generators that the scenario seeds, one for each script, so that a change of one script
//! does not affect the others, and the same scenario yields the same numbers.

mod channel;
mod human;
mod measures;
mod monitors;
mod outcomes;
mod push;
mod script;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::controller::{Controller, Request};
use crate::program::{LostReading, Program, ScenarioProgram};

use human::Person;
pub use measures::{is_bound_to_its_stack, stack_of};
pub use monitors::ExpectationMonitors;
use outcomes::Outcomes;
use push::Push;
use script::Sender;

/// Tolerance for the rounding error of sums of periods: half a microsecond.
const NOW: f64 = 5e-7;

/// Spreads the seeds of the scripts of a scenario over all numbers: 2^64 over the golden ratio.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

/// Index of the first generator of people, far beyond those of other scripts.
const PEOPLE: usize = 1 << 20;

/// Generator of one script of a scenario. The simulated robot uses the seed itself.
fn stream(seed: u64, script: usize) -> Pcg64 {
    Pcg64::seed_from_u64(seed.wrapping_add((script as u64 + 1).wrapping_mul(SPREAD)))
}

/// Times in falling order (s): the next one last.
fn to_come(times: &[f64]) -> Vec<f64> {
    let mut times = times.to_vec();
    times.sort_by(|a, b| b.total_cmp(a));
    times
}

/// Takes the times that have come, and returns true if there is one.
fn has_come(times: &mut Vec<f64>, now: f64) -> bool {
    let before = times.len();
    times.truncate(times.partition_point(|t| *t > now + NOW));
    times.len() < before
}

/// World of a running scenario.
pub struct World {
    senders: Vec<Sender>,
    people: Vec<Person>,
    pushes: Vec<Push>,
    /// Events to come: time in s, and index; the next one last.
    events: Vec<(f64, usize)>,
    /// Times at which the host stops the robot, and lets it go on (s), the next one last.
    stops: Vec<f64>,
    resumes: Vec<f64>,
    outcomes: Outcomes,
    late: Vec<(f64, f64)>,
    lost: Vec<(LostReading, usize)>,
    observed: Vec<f64>,
}

impl World {
    /// Prepares the world of a scenario of a checked program.
    pub fn new(program: &Program, scenario: &ScenarioProgram) -> World {
        let world = &scenario.world;
        let seed = scenario.run.simulator.seed;
        let mut events: Vec<(f64, usize)> =
            world.events.iter().flat_map(|(event, times)| times.iter().map(|t| (*t, *event))).collect();
        events.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
        let q_of = |l: &LostReading| program.robot.model.dofs.get(l.dof).and_then(|d| d.q_index).map(|i| (*l, i));
        World {
            senders: world
                .signals
                .iter()
                .enumerate()
                .map(|(i, s)| Sender::new(s, &program.interface, stream(seed, i)))
                .collect(),
            people: (world.humans.iter().enumerate())
                .map(|(i, h)| Person::new(h, &program.interface, stream(seed, PEOPLE + i)))
                .collect(),
            pushes: world.pushes.iter().map(|p| Push::new(p, program)).collect(),
            events,
            stops: to_come(&world.stops),
            resumes: to_come(&world.resumes),
            outcomes: Outcomes::new(&world.outcomes),
            late: world.late.clone(),
            lost: world.lost.iter().filter_map(q_of).collect(),
            observed: vec![0.0; program.robot.model.nq()],
        }
    }

    /// Returns true if the controller is not called at a time, because its tick is late.
    pub(crate) fn is_late(&self, time: f64) -> bool {
        self.late.iter().any(|&(at, by)| time >= at - NOW && time < at + by - NOW)
    }

    /// Sends signals and events to the controller before a tick. `q` is the robot's true configuration.
    pub(crate) fn send(&mut self, controller: &mut Controller, q: &[f64], time: f64) {
        if has_come(&mut self.stops, time) {
            controller.stop();
        }
        if has_come(&mut self.resumes, time) {
            controller.resume();
        }
        let signals = controller.signals();
        for sender in &mut self.senders {
            sender.tick(signals, time);
        }
        for person in &mut self.people {
            person.tick(signals, time);
        }
        push::tick(&mut self.pushes, signals, q, time);
        while self.events.last().is_some_and(|e| e.0 <= time + NOW) {
            let event = self.events.pop();
            event.map(|(_, event)| signals.raise(event));
        }
        self.outcomes.send(signals, time);
    }

    /// Puts a person at a place (m), with a velocity (m/s), where the person stays: the points of the script are around it.
    pub(crate) fn place_person(&mut self, human: usize, at: [f64; 3], velocity: [f64; 3]) {
        let person = self.people.iter_mut().find(|person| person.human == human);
        person.into_iter().for_each(|person| person.place(at, velocity));
    }

    /// Replaces the motion of people and of tracked signals that the controller knows with the true one, in a table of
    /// signals.
    pub fn truth(&self, time: f64, signals: &mut [f64]) {
        for sender in &self.senders {
            sender.truth(time, signals);
        }
        for person in &self.people {
            person.truth(time, signals);
        }
    }

    /// Configuration that the controller observes: the measured one, with NaN for lost readings.
    pub(crate) fn observe(&mut self, q: &[f64], time: f64) -> &[f64] {
        self.observed.copy_from_slice(q);
        for (lost, i) in &self.lost {
            if time >= lost.from - NOW && time < lost.to - NOW {
                self.observed[*i] = f64::NAN;
            }
        }
        &self.observed
    }

    /// Processes the requests of the controller at a tick.
    pub(crate) fn ask(&mut self, controller: &Controller, requests: &[Request], time: f64) {
        for request in requests {
            if let Some(action) = controller.action(request) {
                self.outcomes.ask(request, action, time);
            }
        }
    }
}
