//! The world of a test: drives and encoders that are not ideal, a host that calls at its own times, stops and enables.
//!
//! Drives are integrated here, exactly between the instants at which a delayed command begins to act:
//!
//! ```text
//! L v' = w(u(t - D)) - v        q' = v + sag        w: dead zone, wrong sign, factor or order
//! ```

use std::collections::VecDeque;

use proptest::prelude::*;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use robot::Data;
use runtime::{Controller, FaultKind, Observation};

use super::cases::{Built, Delays};

/// Longest step in which margins are looked at (s).
const LOOK: f64 = 2e-3;

/// A joint that does not do what it is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ill {
    Stuck(usize),
    FrozenEncoder(usize),
    Reversed(usize),
    Doubled(usize),
    Exchanged(usize, usize),
}

/// Drives and encoders.
#[derive(Clone, Debug, Default)]
pub struct Plant {
    pub delays: Delays,
    /// Velocity that is added to each joint, alternately in both directions (rad/s or m/s).
    pub sag: f64,
    /// Standard deviation of a reading, and step of an encoder (rad or m).
    pub noise: f64,
    pub step: f64,
    /// Velocity below which a joint stands (rad/s or m/s).
    pub dead_zone: f64,
    /// What is wrong, and since when (s).
    pub ill: Option<(Ill, f64)>,
}

/// What a host tells the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Word {
    Stop,
    Resume,
    Disable,
    Enable,
}

/// Times of the calls, and what is said between them.
#[derive(Clone, Debug)]
pub struct Host {
    /// Mean time between calls: 0 for that of 2 kHz, 1 for the longest that is no fault.
    pub pace: f64,
    /// Deviation of a call from its time, as a part of the interval.
    pub jitter: f64,
    /// The controller knows the interval.
    pub declares: bool,
    pub words: Vec<(f64, Word)>,
    pub seed: u64,
}

/// Any host, without words.
pub fn host() -> impl Strategy<Value = Host> {
    (
        prop_oneof![2 => Just(-1.0), 1 => Just(0.0), 1 => Just(1.0), 4 => 0.0..1.0_f64],
        0.0..0.4_f64,
        any::<bool>(),
        any::<u64>(),
    )
        .prop_map(|(pace, jitter, declares, seed)| Host { pace, jitter, declares, words: Vec::new(), seed })
}

impl Host {
    /// Mean interval (s): that of the spec for a negative pace.
    pub fn interval(&self, built: &Built) -> f64 {
        let robot = &built.program.robot;
        let slowest = 0.999 * robot.deadline / (1.0 + self.jitter);
        if self.pace < 0.0 { robot.period } else { 5e-4 * (slowest / 5e-4).powf(self.pace) }
    }
}

/// A call, and what the robot did until the next one.
#[derive(Clone, Debug)]
pub struct Call {
    pub time: f64,
    pub words: Vec<Word>,
    pub q: Vec<f64>,
    pub u: Vec<f64>,
    pub position: Vec<f64>,
    pub fault: Option<(FaultKind, String)>,
    pub at_rest: bool,
    pub enabled: bool,
    /// Smallest margins of the true robot until the next call: joints, floor, wall.
    pub margins: [f64; 3],
    /// The same at the measured configuration.
    pub seen: [f64; 3],
}

/// The robot.
struct Body<'a> {
    built: &'a Built,
    plant: &'a Plant,
    data: Data,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Commands, and when they were sent; the first one acts.
    sent: VecDeque<(f64, Vec<f64>)>,
}

impl Body<'_> {
    fn margins(&mut self, q: &[f64]) -> [f64; 3] {
        let model = &self.built.program.robot.model;
        model.forward(q, &mut self.data);
        let at = self.data.position(self.built.tip);
        let room = |(x, d): (&f64, &robot::Dof)| (x - d.lower).min(d.upper - x);
        [
            q.iter().zip(&model.dofs).map(room).fold(f64::INFINITY, f64::min),
            self.built.floor.map_or(f64::INFINITY, |z| at.z - z),
            self.built.wall.map_or(f64::INFINITY, |x| x - at.x),
        ]
    }

    /// Velocity that drive `i` aims for by a command.
    fn wanted(&self, i: usize, u: &[f64], time: f64) -> f64 {
        let own = |i: usize| if u[i].abs() <= self.plant.dead_zone { 0.0 } else { u[i] };
        match self.plant.ill.filter(|(_, since)| time >= *since).map(|(ill, _)| ill) {
            Some(Ill::Stuck(k)) if i == k => 0.0,
            Some(Ill::Reversed(k)) if i == k => -own(i),
            Some(Ill::Doubled(k)) if i == k => 2.0 * own(i),
            Some(Ill::Exchanged(a, b)) if i == a => own(b),
            Some(Ill::Exchanged(a, b)) if i == b => own(a),
            _ => own(i),
        }
    }

    fn is_stuck(&self, i: usize, time: f64) -> bool {
        self.plant.ill.is_some_and(|(ill, since)| ill == Ill::Stuck(i) && time >= since)
    }

    /// Moves from a time to another one. Returns the smallest margins.
    fn advance(&mut self, mut time: f64, end: f64) -> [f64; 3] {
        let Delays { lag, dead_time } = self.plant.delays;
        let mut least = [f64::INFINITY; 3];
        while time < end {
            while self.sent.get(1).is_some_and(|next| next.0 + dead_time <= time + 1e-12) {
                self.sent.pop_front();
            }
            let change = self.sent.get(1).map_or(f64::INFINITY, |next| next.0 + dead_time);
            let to = end.min(time + LOOK).min(change);
            let (h, u) = (to - time, self.sent[0].1.clone());
            let decay = if lag > 0.0 { (-h / lag).exp() } else { 0.0 };
            for i in 0..self.q.len() {
                if self.is_stuck(i, time) {
                    self.v[i] = 0.0;
                    continue;
                }
                let (wanted, before) = (self.wanted(i, &u, time), self.v[i]);
                self.v[i] = wanted + (before - wanted) * decay;
                let sag = if i % 2 == 0 { self.plant.sag } else { -self.plant.sag };
                self.q[i] += (wanted + sag) * h + (before - wanted) * lag * (1.0 - decay);
            }
            time = to;
            let q = self.q.clone();
            least.iter_mut().zip(self.margins(&q)).for_each(|(least, m)| *least = least.min(m));
        }
        least
    }
}

/// Runs a controller in this world for a time (s).
pub fn run(built: &Built, plant: &Plant, host: &Host, seconds: f64) -> Vec<Call> {
    let program = &built.program;
    let (n, interval) = (program.robot.model.nv(), host.interval(built));
    let mut controller = Controller::new(program).expect("a compiled program can be executed");
    controller.called_every(host.declares.then_some(interval));
    let mut body = Body {
        built,
        plant,
        data: Data::new(&program.robot.model),
        q: program.robot.home.clone(),
        v: vec![0.0; n],
        sent: VecDeque::from([(f64::NEG_INFINITY, vec![0.0; n])]),
    };
    let (mut random, mut dice) = (Pcg64::seed_from_u64(host.seed), robot::random::units(host.seed));
    let (mut time, mut enabled, mut said) = (0.0, true, 0);
    let mut frozen: Option<f64> = None;
    let mut calls: Vec<Call> = Vec::new();
    for k in 1.. {
        let words: Vec<Word> = host.words[said..].iter().take_while(|w| w.0 <= time).map(|w| w.1).collect();
        said += words.len();
        for word in &words {
            match word {
                Word::Stop => controller.stop(),
                Word::Resume => controller.resume(),
                Word::Disable | Word::Enable => {
                    enabled = *word == Word::Enable;
                    controller.set_enabled(enabled);
                }
            }
        }
        let mut measured = body.q.clone();
        for x in &mut measured {
            let noise: f64 = StandardNormal.sample(&mut random);
            *x += plant.noise * noise;
            if plant.step > 0.0 {
                *x = (*x / plant.step).round() * plant.step;
            }
        }
        if let Some((Ill::FrozenEncoder(i), since)) = plant.ill
            && time >= since
        {
            measured[i] = *frozen.get_or_insert(measured[i]);
        }
        let command = controller.step(&Observation { time, q: &measured });
        let (u, position, at_rest) = (command.velocity.to_vec(), command.position.to_vec(), command.at_rest);
        let fault = command.fault.map(|fault| (fault.kind(), controller.describe(&fault)));
        let next = (k as f64 + host.jitter * (dice() - 0.5)) * interval;
        let acts = if enabled { u.clone() } else { vec![0.0; n] };
        if !enabled {
            // Brakes hold it.
            body.sent.clear();
            body.v.fill(0.0);
        }
        body.sent.push_back((if enabled { time } else { f64::NEG_INFINITY }, acts));
        let (q, seen) = (body.q.clone(), body.margins(&measured));
        let margins = body.advance(time, next);
        calls.push(Call { time, words, q, u, position, fault, at_rest, enabled, margins, seen });
        time = next;
        if time > seconds {
            break;
        }
    }
    calls
}
