//! `hierarq serve`: real requests over loopback, valid and hostile.

mod access;
mod client;
mod command;
mod crash;
mod crowd;
mod hostile;
mod journal;
mod labels;
mod layers;
mod people;
mod search;
mod walk;

use hierarq::serve::{Options, Server};
use mission::kinds::schedule::Schedule;
use mission::kinds::schedule::problem::{AgentKind, Duration, Problem, Robot, WorkingAgent};
use mission::numbers::{Energy, Range};

use client::Client;

fn robot(name: &str, depot: [f64; 2]) -> Robot {
    Robot {
        name: name.into(),
        depot,
        speed: Range::point(0.5),
        proximity: Some(Range::point(0.5)),
        serve: 20.0,
        deposit: 1.0,
        factor: 1.0,
        energy: Energy::of_factor(1.0),
    }
}

fn agent(name: &str, kind: AgentKind, place: [f64; 2]) -> WorkingAgent {
    let operations = if kind == AgentKind::Human { 2 } else { 1 };
    WorkingAgent {
        severity: 0.5,
        ..WorkingAgent::new(name, kind, place, operations, Duration { mean: 40.0, sigma: 0.0 })
    }
}

/// Members: the robots m1 and m2, the people anna and ben, a working robot.
const M1: usize = 0;
const M2: usize = 1;
const ANNA: usize = 2;
const BEN: usize = 3;
const CARRIER: usize = 4;

/// Two people and a working robot, served by two robots with fixed speeds: planned quickly.
fn mission() -> Schedule {
    let problem = Problem::new(
        vec![robot("m1", [0.0, 0.0]), robot("m2", [6.0, 0.0])],
        vec![
            agent("anna", AgentKind::Human, [0.0, 5.0]),
            agent("<b>ben</b>", AgentKind::Human, [6.0, 5.0]),
            agent("carrier", AgentKind::Worker, [3.0, 8.0]),
        ],
    );
    Schedule { problem, adaptation: Default::default(), reallocate_above: 0.1, batch: 4 }
}

/// A running server.
struct Running {
    server: Option<Server>,
}

impl Running {
    fn with(options: &Options) -> Running {
        Running { server: Some(Server::start("field", &mission(), options).expect("a server")) }
    }

    fn at_speed(speed: f64) -> Running {
        Running::with(&Options { speed, begin: true, ..Options::default() })
    }

    /// Starts a server whose clock is stopped.
    fn standing() -> Running {
        Running::with(&Options::default())
    }

    fn server(&self) -> &Server {
        self.server.as_ref().expect("it runs")
    }

    /// Returns a client that has not opened a link.
    fn stranger(&self) -> Client {
        Client::new(self.server().address())
    }

    /// Returns the path of the link of a person, or of the supervisor.
    fn link(&self, person: Option<&str>) -> String {
        let links = self.server().links();
        let link = links.iter().find(|link| link.person.as_deref() == person).expect("a link");
        let start = format!("http://{}", self.server().address());
        link.url.strip_prefix(&start).expect("of this server").to_string()
    }

    /// Returns a client whose page is open.
    fn open(&self, person: Option<&str>) -> Client {
        let mut client = self.stranger();
        client.open(&self.link(person));
        client
    }

    fn anna(&self) -> Client {
        self.open(Some("anna"))
    }

    fn ben(&self) -> Client {
        self.open(Some("<b>ben</b>"))
    }

    fn supervisor(&self) -> Client {
        self.open(None)
    }

    /// Ends the server and waits for it.
    fn end(mut self) {
        self.stop();
    }

    fn stop(&mut self) {
        if let Some(server) = self.server.take() {
            server.end().send(true).expect("it listens");
            server.wait().expect("it ended because we said so");
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.stop();
        }
    }
}
