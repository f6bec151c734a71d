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
//! from the reference while this waits for it, as long, and one that stands then, for [`WAITED`] seconds; and one that stands or moves away as long although it
//! is told to go to a reference that rests, [`APART`] away, or [`NEAR`] away and told to go [`TOWARDS`]. One that stands although it is told to move
//! faster than [`LEAST`] in [`QUICK`] seconds is told after [`STUCK`] seconds already; the sums are then over [`QUICK`] seconds. A robot that is slow,
//! blocked for a moment, or late by a lag that nobody declared, follows. So does a light joint that the motion of others pushes for a moment: one that
//! moves too far is [`AHEAD`] of its set point for [`RUNS`] seconds, or has done so in all of the last [`MEMORY`] seconds, in which it was told to go at least [`FAR`],
//!
//! ```text
//! Σ m d  >  DOUBLED Σ d²
//! ```
//!
//! and FARTHER than the reference likewise.
//!
//! A robot that was told to stand, and moves by more than [`MOVES`] in the window for as long, does not follow either.
//!
//! A reading that the degree of freedom cannot have reached since the last one, at one and a half times its
//! speed limit, is the fault `jump`, and nothing is computed from it. A robot that is seen there for [`SURE`] seconds is there, unless that is beyond a
//! limit of a joint. Where readings repeat, because messages are lost, what it was told to move meanwhile counts too. Source: ours.

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

/// Shorter time over which motion is summed, for a degree of freedom that stands, and time for which it may (s).
const QUICK: f64 = 0.05;
const STUCK: f64 = 0.25;

/// Distance from its set point by which a degree of freedom that moves too far is ahead of it, in rad or m, and the same for each rad/s or m/s.
const AHEAD: f64 = 0.05;
const AHEAD_BY_SPEED: f64 = 0.05;

/// Time for which it may be (s): a light joint is pushed for as long.
const RUNS: f64 = 0.5;

/// Motion in the window of a robot that was told to stand, in rad or m, that is more than it takes to come to rest.
const MOVES: f64 = 0.1;

/// Time for which a robot is seen at another place until it is there (s).
const SURE: f64 = 0.1;

/// Time over which a degree of freedom has moved too far (s), and the way that it was told to go in it, in rad or m: both faded as the sums above.
const MEMORY: f64 = 2.0;
const FAR: f64 = 0.05;

/// The same of the motion of the reference, from which the tracking law pulls a robot back that goes twice as far.
const FARTHER: f64 = 1.15;

/// Time for which the reference waits for a degree of freedom that stands (s).
const WAITED: f64 = 1.0;

/// Distance from the reference beyond which a degree of freedom that stands does not follow, whatever the reference does, in rad or m: that at which a
/// moving reference waits. Servos of positions sag by less.
const APART: f64 = 0.05;

/// The same for one that was told to go [`TOWARDS`] in the last moments, by a high gain, in rad or m.
const NEAR: f64 = 0.02;
const TOWARDS: f64 = 0.1;

/// Factor on the speed limit, and distance in rad or m for noise, within which the next reading lies.
const FASTER: f64 = 1.5;
const NOISE: f64 = 0.05;

/// Speed of a number of a configuration that is still at the same place, in rad/s or m/s.
const SPEED: f64 = 3.0;

/// What the robot was told at the last call.
#[derive(Clone, Copy)]
pub(super) struct Told<'a> {
    /// Velocity command, `nv` numbers.
    pub command: &'a [f64],
    /// The same without the correction.
    pub reference: &'a [f64],
    /// Way from the robot to its set point.
    pub off: &'a [f64],
    /// Degree of freedom that the reference waits for.
    pub waits: Option<usize>,
    /// True if the robot was told to stand.
    pub stands: bool,
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
    /// Time from the last reading but one to the last one (s).
    gap: f64,
    /// Motion since the last reading.
    moved: Vec<f64>,
    /// Another place at which the robot was seen, and the time for which it was (s); `None` if it was not.
    other: Vec<f64>,
    seen: Option<f64>,
    /// Way that each degree of freedom was told to go since its reading last changed, in rad or m.
    unseen: Vec<f64>,
    told: Vec<f64>,
    led: Vec<f64>,
    done: Vec<f64>,
    memory: Vec<Memory>,
    quick_told: Vec<f64>,
    quick_led: Vec<f64>,
    quick_done: Vec<f64>,
    /// Time for which each degree of freedom has stood (s).
    stuck: Vec<f64>,
    /// Time for which each degree of freedom has moved too far, and was ahead of its set point (s).
    ahead: Vec<f64>,
    /// Time for which the reference has waited (s).
    waited: f64,
    /// Time for which each degree of freedom has not followed (s).
    lost: Vec<f64>,
    /// Time for which each degree of freedom has stood far from its reference (s).
    stood: Vec<f64>,
}

impl Following {
    pub fn new(model: &Model) -> Following {
        let zero = || vec![0.0; model.nv()];
        Following {
            last: vec![0.0; model.nq()],
            since: None,
            gap: 0.0,
            moved: zero(),
            other: vec![0.0; model.nq()],
            seen: None,
            quick_told: zero(),
            quick_led: zero(),
            quick_done: zero(),
            stuck: zero(),
            ahead: zero(),
            unseen: zero(),
            told: zero(),
            led: zero(),
            done: zero(),
            memory: vec![Memory::default(); model.nv()],
            waited: 0.0,
            lost: zero(),
            stood: zero(),
        }
    }

    /// Forgets the robot: the next reading may be anywhere.
    pub fn restart(&mut self) {
        (self.since, self.seen) = (None, None);
        self.forget();
    }

    /// Forgets its motion: it was not told anything, or stands.
    pub fn forget(&mut self) {
        let Following { unseen, told, led, done, lost, quick_told, quick_led, quick_done, stuck, ahead, .. } = self;
        for sums in [unseen, told, led, done, lost, quick_told, quick_led, quick_done, stuck, ahead] {
            sums.fill(0.0);
        }
        self.memory.fill(Memory::default());
        self.stood.fill(0.0);
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
        let passed = since + dt;
        self.unseen.iter_mut().zip(u).for_each(|(way, u)| *way += u.abs() * dt);
        if let Some((dof, by)) = self.too_far(model, passed) {
            if !self.is_sure(model, q, dt) {
                self.since = Some(passed);
                return Some(Fault::Jump { dof, by });
            }
            self.moved.fill(0.0);
            self.forget();
        } else if self.seen.is_some() {
            self.forget();
        }
        self.seen = None;
        self.gap = passed;
        self.last.copy_from_slice(q);
        self.unseen.iter_mut().zip(&self.moved).filter(|(_, moved)| **moved != 0.0).for_each(|(way, _)| *way = 0.0);
        if dt <= 0.0 {
            return None;
        }
        let (keep, remember, forget) = ((-dt / WINDOW).exp(), (-dt / MEMORY).exp(), (-dt / QUICK).exp());
        for (i, (u, v)) in u.iter().zip(told.reference).enumerate() {
            self.told[i] = keep * self.told[i] + u * dt;
            self.led[i] = keep * self.led[i] + v * dt;
            self.done[i] = keep * self.done[i] + self.moved[i];
            self.memory[i].add(remember, u * dt, [self.told[i], self.led[i], self.done[i]]);
            let (of_told, of_led) = (self.done[i] / self.told[i], self.done[i] / self.led[i]);
            let counts = self.led[i].abs() > LEAST && self.told[i].abs() > LEAST && v.abs() * WINDOW > 0.5 * LEAST;
            let stays = of_told < FROZEN && of_led < FROZEN;
            let is_ahead = -told.off[i] * v.signum() > AHEAD + AHEAD_BY_SPEED * v.abs() && self.memory[i].way > FAR;
            self.ahead[i] = if of_told > DOUBLED && is_ahead { self.ahead[i] + dt } else { 0.0 };
            let runs = of_told > DOUBLED && (self.ahead[i] > RUNS || self.memory[i].is_doubled());
            // The reference of a joint that turns the other way comes to a stand, and is no measure any more.
            let waits = told.waits == Some(i);
            let flees = waits && self.told[i].abs() > LEAST && of_told < -FROZEN;
            let moves = told.stands && (self.done[i] - self.told[i]).abs() > MOVES;
            let follows = !flees && !moves && !(counts && (stays || runs));
            self.lost[i] = if follows { 0.0 } else { self.lost[i] + dt };
            self.quick_told[i] = forget * self.quick_told[i] + u * dt;
            self.quick_led[i] = forget * self.quick_led[i] + v * dt;
            self.quick_done[i] = forget * self.quick_done[i] + self.moved[i];
            let (of_told, of_led) = (self.quick_done[i] / self.quick_told[i], self.quick_done[i] / self.quick_led[i]);
            // One that moves the other way may be pushed.
            let is_led = self.quick_led[i].abs() > LEAST && of_led.abs() < FROZEN;
            let stands = self.quick_told[i].abs() > LEAST && of_told.abs() < FROZEN && (is_led || waits);
            self.stuck[i] = if stands { self.stuck[i] + dt } else { 0.0 };
            let (way, most) = (told.off[i], self.told[i].abs());
            let far = way.abs() > APART || (way.abs() > NEAR && most > TOWARDS);
            let comes = self.done[i] * self.told[i].signum() > LEAST;
            let stands = far && most > LEAST && way * self.told[i] > 0.0 && !comes;
            self.stood[i] = if stands { self.stood[i] + dt } else { 0.0 };
        }
        let stands = told.waits.filter(|&i| self.done[i].abs() < LEAST);
        self.waited = if stands.is_some() { self.waited + dt } else { 0.0 };
        let lost = self.lost.iter().position(|lost| *lost > PATIENCE);
        let at = |times: &[f64], most: f64| times.iter().position(|time| *time > most);
        let lost = lost.or(at(&self.stuck, STUCK)).or(at(&self.stood, WAITED));
        let dof = lost.or(stands.filter(|_| self.waited > WAITED))?;
        let fault = Fault::Tracking { dof, told: self.told[dof], moved: self.done[dof] };
        self.forget();
        Some(fault)
    }

    /// Motion of each degree of freedom between the last two readings.
    pub fn moved(&self) -> &[f64] {
        &self.moved
    }

    /// Time between the last two readings (s).
    pub fn gap(&self) -> f64 {
        self.gap
    }

    /// First degree of freedom that has moved farther than it can have since the last reading, a time `passed` ago (s), and how far.
    fn too_far(&self, model: &Model, passed: f64) -> Option<(usize, f64)> {
        let reach = |i: usize| FASTER * (model.dofs[i].velocity * passed + self.unseen[i]) + NOISE;
        self.moved.iter().copied().enumerate().find(|(i, moved)| moved.abs() > reach(*i))
    }

    /// Takes a reading at another place, `dt` seconds after the one before. Returns true if the robot is there.
    fn is_sure(&mut self, model: &Model, q: &[f64], dt: f64) -> bool {
        let stays = |i: usize, x: f64| (x - self.other[i]).abs() <= NOISE + FASTER * SPEED * dt;
        let seen = self.seen.filter(|_| q.iter().enumerate().all(|(i, x)| stays(i, *x))).map(|seen| seen + dt);
        self.other.copy_from_slice(q);
        self.seen = Some(seen.unwrap_or(0.0));
        let beyond = |x: f64, lower: f64, upper: f64| (lower - x).max(x - upper);
        let is_possible = model.dofs.iter().all(|d| {
            d.q_index
                .is_none_or(|i| beyond(q[i], d.lower, d.upper) <= NOISE.max(beyond(self.last[i], d.lower, d.upper)))
        });
        seen.is_some_and(|seen| seen >= SURE) && is_possible
    }
}
