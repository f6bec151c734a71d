//! The simulated world: what it sends, answers and does while a scenario runs.
//!
//! Everything random comes from generators seeded by the scenario, one for each script, so that a change of one script
//! leaves the others as they were, and the same scenario gives the same numbers.

mod channel;
mod human;
mod judge;
mod measures;
mod outcomes;
mod push;
mod script;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::controller::{Controller, Request};
use crate::program::{LostReading, Program, ScenarioProgram};

use human::Person;
pub use judge::Judge;
pub use measures::{is_bound_to_its_stack, stack_of};
use outcomes::Outcomes;
use push::Push;
use script::Sender;

/// Sums of periods are a little off: half a microsecond counts as nothing.
const NOW: f64 = 5e-7;

/// Spreads the seeds of the scripts of a scenario over all numbers: 2^64 over the golden ratio.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

/// The first number of the generators of people, far beyond those of other scripts.
const PEOPLE: usize = 1 << 20;

/// The generator of one script of a scenario. The simulated robot has the first one.
fn stream(seed: u64, script: usize) -> Pcg64 {
    Pcg64::seed_from_u64(seed.wrapping_add((script as u64 + 1).wrapping_mul(SPREAD)))
}

/// A world while it runs.
pub struct World {
    senders: Vec<Sender>,
    people: Vec<Person>,
    pushes: Vec<Push>,
    /// Events that are still to come: when, in s, and which; the next one last.
    events: Vec<(f64, usize)>,
    outcomes: Outcomes,
    late: Vec<(f64, f64)>,
    lost: Vec<(LostReading, usize)>,
    observed: Vec<f64>,
}

impl World {
    /// Of a scenario of a checked program.
    pub fn new(program: &Program, scenario: &ScenarioProgram) -> World {
        let world = &scenario.world;
        let seed = scenario.run.simulator.seed;
        let mut events: Vec<(f64, usize)> =
            world.events.iter().flat_map(|(event, times)| times.iter().map(|t| (*t, *event))).collect();
        events.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
        let q_of = |l: &LostReading| program.robot.model.dofs.get(l.dof).and_then(|d| d.q_index).map(|i| (*l, i));
        World {
            senders: world.signals.iter().enumerate().map(|(i, s)| Sender::new(s, stream(seed, i))).collect(),
            people: (world.humans.iter().enumerate())
                .map(|(i, h)| Person::new(h, &program.interface, stream(seed, PEOPLE + i)))
                .collect(),
            pushes: world.pushes.iter().map(|p| Push::new(p, program)).collect(),
            events,
            outcomes: Outcomes::new(&world.outcomes),
            late: world.late.clone(),
            lost: world.lost.iter().filter_map(q_of).collect(),
            observed: vec![0.0; program.robot.model.nq()],
        }
    }

    /// True where the controller is not called at a time, because its tick comes late.
    pub(crate) fn is_late(&self, time: f64) -> bool {
        self.late.iter().any(|&(at, by)| time >= at - NOW && time < at + by - NOW)
    }

    /// What the controller is told before a tick. `q` is the robot's true configuration.
    pub(crate) fn tell(&mut self, controller: &mut Controller, q: &[f64], time: f64) {
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
        self.outcomes.tell(signals, time);
    }

    /// Puts what is true of people in the place of what the controller knows of them, in a table of signals.
    pub fn truth(&self, time: f64, signals: &mut [f64]) {
        for person in &self.people {
            person.truth(time, signals);
        }
    }

    /// What the controller sees of a measured configuration.
    pub(crate) fn observe(&mut self, q: &[f64], time: f64) -> &[f64] {
        self.observed.copy_from_slice(q);
        for (lost, i) in &self.lost {
            if time >= lost.from - NOW && time < lost.to - NOW {
                self.observed[*i] = f64::NAN;
            }
        }
        &self.observed
    }

    /// Takes what the controller asks at a tick.
    pub(crate) fn ask(&mut self, controller: &Controller, requests: &[Request], time: f64) {
        for request in requests {
            if let Some(action) = controller.action(request) {
                self.outcomes.ask(request, action, time);
            }
        }
    }
}
