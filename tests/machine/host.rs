//! A host that runs a machine on an ideal robot and records the results.

use runtime::{Controller, FaultKind, Observation, Program, SimulatedRobot};

/// An arm, and a stack that stops it.
pub const ARM: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
stack still { level limits hard { joint_position_limits  joint_velocity_limits } }
";

/// Results of a tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    pub state: String,
    /// Requests, for instance `+say hello`, `-capture camera`.
    pub asked: Vec<String>,
    pub fault: Option<FaultKind>,
}

/// The host.
pub struct Host {
    pub controller: Controller,
    pub robot: SimulatedRobot,
    pub tick: usize,
    period: f64,
}

impl Host {
    /// Creates the host of a spec: `text` is appended to [`ARM`].
    pub fn new(text: &str) -> Host {
        Host::of(&crate::common::program_of(&format!("{ARM}{text}")))
    }

    /// Creates the host of a program.
    pub fn of(program: &Program) -> Host {
        Host {
            controller: Controller::new(program).expect("a compiled program can be executed"),
            robot: SimulatedRobot::new(program),
            tick: 0,
            period: program.robot.period,
        }
    }

    pub fn time(&self) -> f64 {
        self.tick as f64 * self.period
    }

    pub fn raise(&mut self, event: &str) {
        let index = self.controller.signals().interface().event(event).expect("a declared event");
        assert!(self.controller.signals().raise(index));
    }

    pub fn set(&mut self, signal: &str, value: &[f64]) {
        let (index, time) = (self.controller.signals().interface().signal(signal).expect("a signal"), self.time());
        assert!(self.controller.signals().set(index, value, time));
    }

    /// Executes one tick.
    pub fn step(&mut self) -> Seen {
        let q = self.robot.measure().to_vec();
        self.step_at(self.time(), &q)
    }

    /// Executes one tick with the given observation.
    pub fn step_at(&mut self, time: f64, q: &[f64]) -> Seen {
        self.tick += 1;
        let command = self.controller.step(&Observation { time, q });
        let (velocity, requests) = (command.velocity.to_vec(), command.requests.to_vec());
        let fault = command.fault.map(|f| f.kind());
        assert!(velocity.iter().all(|v| v.is_finite()));
        self.robot.apply(&velocity);
        let asked = requests.iter().map(|r| {
            let action = self.controller.action(r).expect("requests are of actions");
            format!("{}{} {}", if r.begin { '+' } else { '-' }, action.verb, action.arguments.join(" "))
        });
        Seen { asked: asked.collect(), state: self.controller.state().to_string(), fault }
    }

    /// Executes some ticks; returns the state after the last one.
    pub fn steps(&mut self, ticks: usize) -> String {
        (0..ticks).map(|_| self.step()).last().map_or_else(String::new, |s| s.state)
    }
}

/// Returns two hosts of one spec: from the text appended to [`ARM`], and from its YAML syntax.
pub fn in_both_syntaxes(text: &str) -> [Host; 2] {
    let (spec, _) = dsl::parse(dsl::SourceId(0), &format!("{ARM}{text}"), dsl::Syntax::Native);
    let yaml = dsl::print(&spec, dsl::Syntax::Yaml);
    [Host::new(text), Host::of(&crate::common::program_in(&yaml, dsl::Syntax::Yaml))]
}
