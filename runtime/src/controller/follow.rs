//! Whether the robot follows: what it is told against what it does.
//!
//! Per degree of freedom, both the commanded and the measured motion are summed over the last [`WINDOW`] seconds,
//!
//! ```text
//! d' = u - d/τ          m' = v - m/τ          τ: the window
//! ```
//!
//! for the command as drives with the declared lag obey it, with the correction of the tracking law, and for the reference alone, which is all that a
//! position servo is sent.
//! A degree of freedom whose reference moves, `|d|` above [`LEAST`], and that moves by less than [`FROZEN`] of both, or the other way, or more than
//! [`DOUBLED`] of the command and more than the reference, for [`PATIENCE`] seconds, does not follow: the fault `tracking`. So does one that moves away
//! from the reference while this waits for it, as long, and one that stands then, for [`WAITED`] seconds. A robot that is slow, blocked for a moment, or late by a lag that
//! nobody declared, does. So does a light joint that the motion of others pushes for a moment: one that moves too far has done so in all of
//! the last [`MEMORY`] seconds, in which it was told to go at least [`FAR`],
//!
//! ```text
//! Σ m d  >  DOUBLED Σ d²
//! ```
//!
//! and FARTHER than the reference likewise.
//!
//! A reading that the degree of freedom cannot have reached since the last one, at one and a half times its
//! speed limit, is the fault `jump`. Where readings repeat, because messages are lost, what it was told to move meanwhile counts too. Source: ours.

use robot::Model;

use crate::fault::Fault;

/// Time over which motion is summed (s).
const WINDOW: f64 = 0.3;

/// Time for which a degree of freedom may not follow (s).
const PATIENCE: f64 = 0.3;

/// Least commanded motion that counts, in rad or m: far more than the resolution of an encoder.
const LEAST: f64 = 5e-3;

/// Part of the commanded motion below which, and above which, a degree of freedom does not follow.
const FROZEN: f64 = 0.2;
const DOUBLED: f64 = 1.8;

/// Time over which a degree of freedom has moved too far (s), and the way that it was told to go in it, in rad or m: both faded as the sums above.
const MEMORY: f64 = 2.0;
const FAR: f64 = 0.05;

/// The same of the motion of the reference, from which the tracking law pulls a robot back that goes twice as far.
const FARTHER: f64 = 1.15;

/// Time for which the reference waits for a degree of freedom that stands (s).
const WAITED: f64 = 1.0;

/// Factor on the speed limit, and distance in rad or m for noise, within which the next reading lies.
const FASTER: f64 = 1.5;
const NOISE: f64 = 0.05;

/// What the robot was told at the last call.
#[derive(Clone, Copy)]
pub(super) struct Told<'a> {
    /// Velocity command, `nv` numbers.
    pub command: &'a [f64],
    /// The same without the correction.
    pub reference: &'a [f64],
    /// Degree of freedom that the reference waits for.
    pub waits: Option<usize>,
}

/// Motion of a degree of freedom, commanded and measured, over the last [`MEMORY`] seconds.
#[derive(Clone, Copy, Default)]
struct Memory {
    /// Way that it was told to go, forth and back, in rad or m.
    way: f64,
    /// Sums of squares of the motion of the command and of the reference, and of their products with the measured one, in rad² or m².
    told: [f64; 2],
    led: [f64; 2],
}

impl Memory {
    fn add(&mut self, keep: f64, way: f64, [told, led, done]: [f64; 3]) {
        self.way = keep * self.way + way.abs();
        for (sums, motion) in [(&mut self.told, told), (&mut self.led, led)] {
            *sums = [keep * sums[0] + motion * motion, keep * sums[1] + motion * done];
        }
    }

    /// True if it has moved too far all the time.
    fn is_doubled(self) -> bool {
        let farther = |[square, product]: [f64; 2], factor: f64| product > factor * square;
        self.way > FAR && farther(self.told, DOUBLED) && farther(self.led, FARTHER)
    }
}

/// A robot that is watched.
pub(super) struct Following {
    /// Last usable configuration, and the time that has passed since (s); `None` before the first.
    last: Vec<f64>,
    since: Option<f64>,
    /// Motion since the last reading.
    moved: Vec<f64>,
    /// Way that each degree of freedom was told to go since its reading last changed, in rad or m.
    unseen: Vec<f64>,
    told: Vec<f64>,
    led: Vec<f64>,
    done: Vec<f64>,
    memory: Vec<Memory>,
    /// Time for which the reference has waited (s).
    waited: f64,
    /// Time for which each degree of freedom has not followed (s).
    lost: Vec<f64>,
}

impl Following {
    pub fn new(model: &Model) -> Following {
        let zero = || vec![0.0; model.nv()];
        Following {
            last: vec![0.0; model.nq()],
            since: None,
            moved: zero(),
            unseen: zero(),
            told: zero(),
            led: zero(),
            done: zero(),
            memory: vec![Memory::default(); model.nv()],
            waited: 0.0,
            lost: zero(),
        }
    }

    /// Forgets the robot: the next reading may be anywhere.
    pub fn restart(&mut self) {
        self.since = None;
        self.forget();
    }

    /// Forgets its motion: it was not told anything, or stands.
    pub fn forget(&mut self) {
        self.unseen.fill(0.0);
        self.told.fill(0.0);
        self.led.fill(0.0);
        self.done.fill(0.0);
        self.memory.fill(Memory::default());
        self.lost.fill(0.0);
        self.waited = 0.0;
    }

    /// Lets time pass without a usable reading (s).
    pub fn miss(&mut self, dt: f64) {
        self.since = self.since.map(|since| since + dt);
        self.forget();
    }

    /// Takes a reading, after a command that was held for `dt` seconds. Returns a fault of the reading, or of the motion.
    pub fn look(&mut self, model: &Model, q: &[f64], told: Told, dt: f64) -> Option<Fault> {
        let u = told.command;
        let Some(since) = self.since.replace(0.0) else {
            self.last.copy_from_slice(q);
            return None;
        };
        model.difference(&self.last, q, &mut self.moved);
        self.last.copy_from_slice(q);
        let passed = since + dt;
        self.unseen.iter_mut().zip(u).for_each(|(way, u)| *way += u.abs() * dt);
        let reach = |i: usize| FASTER * (model.dofs[i].velocity * passed + self.unseen[i]) + NOISE;
        let far = |(i, moved): (usize, &f64)| moved.abs() > reach(i);
        if let Some(dof) = self.moved.iter().enumerate().position(far) {
            let by = self.moved[dof];
            self.forget();
            return Some(Fault::Jump { dof, by });
        }
        self.unseen.iter_mut().zip(&self.moved).filter(|(_, moved)| **moved != 0.0).for_each(|(way, _)| *way = 0.0);
        if dt <= 0.0 {
            return None;
        }
        let (keep, remember) = ((-dt / WINDOW).exp(), (-dt / MEMORY).exp());
        for (i, (u, v)) in u.iter().zip(told.reference).enumerate() {
            self.told[i] = keep * self.told[i] + u * dt;
            self.led[i] = keep * self.led[i] + v * dt;
            self.done[i] = keep * self.done[i] + self.moved[i];
            self.memory[i].add(remember, u * dt, [self.told[i], self.led[i], self.done[i]]);
            let (of_told, of_led) = (self.done[i] / self.told[i], self.done[i] / self.led[i]);
            let counts = self.led[i].abs() > LEAST && self.told[i].abs() > LEAST && v.abs() * WINDOW > 0.5 * LEAST;
            let stays = of_told < FROZEN && of_led < FROZEN;
            let runs = of_told > DOUBLED && self.memory[i].is_doubled();
            // The reference of a joint that turns the other way comes to a stand, and is no measure any more.
            let flees = told.waits == Some(i) && self.told[i].abs() > LEAST && of_told < -FROZEN;
            let follows = !flees && !(counts && (stays || runs));
            self.lost[i] = if follows { 0.0 } else { self.lost[i] + dt };
        }
        let stands = told.waits.filter(|&i| self.done[i].abs() < LEAST);
        self.waited = if stands.is_some() { self.waited + dt } else { 0.0 };
        let lost = self.lost.iter().position(|lost| *lost > PATIENCE);
        let dof = lost.or(stands.filter(|_| self.waited > WAITED))?;
        let fault = Fault::Tracking { dof, told: self.told[dof], moved: self.done[dof] };
        self.forget();
        Some(fault)
    }
}
