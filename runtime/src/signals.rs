//! Inputs that the host sends to the controller between ticks: values of signals, each with the time at which it was
//! received, and events.

use nalgebra::UnitQuaternion;

use crate::conditioning::Conditioner;
use crate::program::{Interface, Lost, SignalProgram};
use crate::tracking::Estimate;

/// Largest difference from 1 of the length of a quaternion that counts as an orientation.
pub const NOT_UNIT: f64 = 1e-3;

/// Value of a signal that the controller sets itself.
pub(crate) struct SignalValue {
    /// Index of the signal.
    pub signal: usize,
    /// Value; not finite if there is none.
    pub value: f64,
}

/// Largest number of numbers that the host sends: a pose with its velocities.
const MAX_SENT: usize = 13;

/// Scales a quaternion to length 1; false if its length is too far from 1.
fn normalised(q: &mut [f64]) -> bool {
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let good = (length - 1.0).abs() <= NOT_UNIT;
    if good {
        q.iter_mut().for_each(|x| *x /= length);
    }
    good
}

/// The signals of a controller.
///
/// A value is valid until its signal's timeout has passed. Then the signal is absent, as it is before the first value
/// was received. A value that is not finite makes its signal absent at once, and so does an orientation whose
/// quaternion is further than [`NOT_UNIT`] from length 1; closer ones are normalised. Variables of the machine are
/// among the signals; the host can read them and cannot set them.
///
/// A tracked point or pose has a velocity beside its value, which the host sends after the value or which is
/// estimated. Between two readings its value stays, or goes on with this velocity. When its readings stop, it becomes
/// absent too. If it is held, the place of its last reading remains valid, at rest, with an uncertainty that grows from
/// then on.
pub struct Signals {
    interface: Interface,
    /// Time at which each signal's value was received, in s; minus infinity for never.
    received: Vec<f64>,
    /// Time of each signal's last valid reading, in s; minus infinity for never.
    read: Vec<f64>,
    /// The table: for each signal 1 if it is present and -1 otherwise, and its value, NaN if absent.
    table: Vec<f64>,
    /// Last value of each signal, at the indices of the table.
    last: Vec<f64>,
    /// Estimated motion of each signal that is tracked.
    motions: Vec<Option<Estimate>>,
    /// Time from which each signal's readings count as missing, in s; infinity if none ever came.
    lost: Vec<f64>,
    /// True for each signal whose last value could not be used.
    refused: Vec<bool>,
    /// Events since the last tick.
    raised: Vec<bool>,
    conditioner: Conditioner,
    /// Time by which people are foreseen (s).
    foresight: f64,
}

impl Signals {
    pub(crate) fn new(interface: &Interface) -> Self {
        let mut signals = Signals {
            received: vec![f64::NEG_INFINITY; interface.signals.len()],
            read: vec![f64::NEG_INFINITY; interface.signals.len()],
            table: interface.absent(),
            last: vec![f64::NAN; interface.width()],
            motions: interface.signals.iter().map(estimate).collect(),
            lost: vec![f64::INFINITY; interface.signals.len()],
            refused: vec![false; interface.signals.len()],
            raised: vec![false; interface.events.len()],
            conditioner: Conditioner::new(interface),
            foresight: 0.0,
            interface: interface.clone(),
        };
        signals.restart();
        signals.at(0.0, |_| None);
        signals
    }

    /// Foresees people by a time (s): their places are those where they are then, at their velocity. A robot whose drives are behind its commands by
    /// this time is where it is told to be then.
    pub(crate) fn with_foresight(self, foresight: f64) -> Signals {
        Signals { foresight, ..self }
    }

    /// Resets variables to their initial values and sensors to their declared bias.
    pub(crate) fn restart(&mut self) {
        self.conditioner.restart(&self.interface);
        for (s, received) in self.interface.signals.iter().zip(&mut self.received) {
            let Some(initial) = &s.variable else { continue };
            *received = if initial.value.is_some() { f64::INFINITY } else { f64::NEG_INFINITY };
            if let Some(value) = &initial.value {
                self.last[s.at + 1..=s.at + s.len].copy_from_slice(value);
            }
        }
    }

    /// Declared signals and events.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Sets the value of a signal that was received at a time, in s. Never allocates.
    ///
    /// Returns false if there is no such signal, if it is a variable of the machine, or if it has another number of
    /// numbers. A tracked point whose velocity is measured has six: its position in m and its velocity in m/s. A pose has
    /// thirteen: its position, a quaternion `w x y z`, its velocity, and its angular velocity in rad/s along the axes of
    /// the world.
    pub fn set(&mut self, signal: usize, value: &[f64], time: f64) -> bool {
        if self.interface.signals.get(signal).is_none_or(|s| s.is_variable()) {
            return false;
        }
        let known = self.receive(signal, value, time);
        if known && self.received[signal] == time {
            self.read[signal] = time;
        }
        known
    }

    fn receive(&mut self, signal: usize, value: &[f64], time: f64) -> bool {
        let Some(s) = self.interface.signals.get(signal).filter(|s| s.sent() == value.len()) else { return false };
        if let Some(Some(estimate)) = self.motions.get_mut(signal) {
            let readings =
                Readings { received: &mut self.received[signal], lost: &mut self.lost[signal], last: &mut self.last };
            tracked(s, estimate, value, time, readings);
            self.refused[signal] = self.received[signal] == f64::NEG_INFINITY;
            return true;
        }
        let last = &mut self.last[s.at + 1..s.at + 1 + s.len];
        last.copy_from_slice(value);
        let turned = match s.kind.as_str() {
            "orientation" => normalised(last),
            "pose" => last.get_mut(3..).is_some_and(normalised),
            _ => true,
        };
        let good = turned && value.iter().all(|x| x.is_finite());
        self.received[signal] = if good { time } else { f64::NEG_INFINITY };
        self.refused[signal] = !good;
        true
    }

    /// Makes a signal absent and forgets its history. A signal that the machine sets is unchanged.
    pub fn clear(&mut self, signal: usize) {
        if self.interface.signals.get(signal).is_some_and(|s| !s.is_variable()) {
            self.received[signal] = f64::NEG_INFINITY;
            self.read[signal] = f64::NEG_INFINITY;
            self.lost[signal] = f64::INFINITY;
            if let Some(estimate) = &mut self.motions[signal] {
                estimate.forget();
            }
        }
    }

    /// Sets the value of a variable, in the table too. Returns false if the value is invalid; the variable is then
    /// unchanged.
    pub(crate) fn assign(&mut self, variable: usize, value: &[f64]) -> bool {
        let mut good = [0.0; crate::program::MAX_SIGNAL];
        let good = &mut good[..value.len().min(crate::program::MAX_SIGNAL)];
        let Some(s) = self.interface.signals.get(variable) else { return false };
        let before = s.at + 1..=s.at + s.len;
        if good.len() != s.len || !value.iter().all(|x| x.is_finite()) {
            return false;
        }
        good.copy_from_slice(&self.last[before.clone()]);
        let received = self.received[variable];
        self.receive(variable, value, f64::INFINITY);
        if self.received[variable] == f64::NEG_INFINITY {
            self.last[before].copy_from_slice(good);
            self.received[variable] = received;
            return false;
        }
        self.table[before.clone()].copy_from_slice(&self.last[before]);
        self.table[self.interface.signals[variable].at] = 1.0;
        true
    }

    /// Makes a variable absent, in the table too.
    pub(crate) fn forget(&mut self, variable: usize) {
        let Some(s) = self.interface.signals.get(variable) else { return };
        self.received[variable] = f64::NEG_INFINITY;
        self.table[s.at] = -1.0;
        self.table[s.at + 1..=s.at + s.len].fill(f64::NAN);
    }

    /// Tares a wrench; false if it is absent.
    pub(crate) fn tare(&mut self, signal: usize) -> bool {
        if !self.is_present(signal) {
            return false;
        }
        let s = &self.interface.signals[signal];
        self.conditioner.tare(&self.interface, signal, &mut self.table[s.at + 1..=s.at + s.len]);
        true
    }

    /// Raises an event; false if it does not exist. It is visible at the next tick only.
    pub fn raise(&mut self, event: usize) -> bool {
        self.raised.get_mut(event).map(|r| *r = true).is_some()
    }

    /// Returns true if a signal is present at the last tick.
    pub fn is_present(&self, signal: usize) -> bool {
        self.interface.signals.get(signal).is_some_and(|s| self.table[s.at] > 0.0)
    }

    /// Returns true if the value of a signal may be used at the last tick: it is present, or it is held.
    pub fn is_known(&self, signal: usize) -> bool {
        self.interface.signals.get(signal).is_some_and(|s| self.table[s.known_at()] > 0.0)
    }

    /// Signal that is waited for, of those that a stack `needs`: one that is absent, if each absent one may still be late,
    /// `since` seconds after the start. A signal without `?` may be late until its timeout.
    pub(crate) fn awaited(&self, needs: &[usize], since: f64) -> Option<usize> {
        let is_late = |s: usize| {
            let signal = self.interface.signals.get(s);
            signal.is_some_and(|s| !s.optional && s.timeout.is_some_and(|timeout| since <= timeout))
        };
        let absent = || needs.iter().copied().filter(|s| !self.is_known(*s));
        absent().next().filter(|_| absent().all(is_late))
    }

    /// Velocity of a tracked point or pose at the last tick, in m/s; NaN if it is absent, empty for other signals.
    pub fn velocity(&self, signal: usize) -> &[f64] {
        let tracked = self.interface.signals.get(signal).filter(|s| s.motion.is_some());
        tracked.map_or(&[], |s| &self.table[s.velocity_at()..s.velocity_at() + 3])
    }

    /// Uncertainty of a tracked point at the last tick, in m; NaN if it is absent, `None` for other signals.
    pub fn uncertainty(&self, signal: usize) -> Option<f64> {
        let s = self.interface.signals.get(signal).filter(|s| s.motion.is_some())?;
        Some(self.table[s.uncertainty_at()])
    }

    /// Value of a signal at the last tick; NaN if absent.
    pub fn value(&self, signal: usize) -> &[f64] {
        self.interface.signals.get(signal).map_or(&[], |s| &self.table[s.at + 1..s.at + 1 + s.len])
    }

    /// Table of signals at the last tick.
    pub fn table(&self) -> &[f64] {
        &self.table
    }

    /// Time at which the last usable value of a signal was received, in s; minus infinity if there is none.
    pub(crate) fn received(&self, signal: usize) -> f64 {
        self.received.get(signal).copied().unwrap_or(f64::NEG_INFINITY)
    }

    /// Returns true if the last value of a signal could not be used.
    pub(crate) fn was_refused(&self, signal: usize) -> bool {
        self.refused.get(signal) == Some(&true)
    }

    pub(crate) fn events(&self) -> &[bool] {
        &self.raised
    }

    pub(crate) fn forget_events(&mut self) {
        self.raised.fill(false);
    }

    /// Computes the table for a tick. `axes` returns the orientation of a link at the observed configuration, if it is
    /// known.
    pub(crate) fn at(&mut self, time: f64, axes: impl Fn(robot::LinkId) -> Option<UnitQuaternion<f64>>) {
        let Signals { interface, received, read, table, last, conditioner, motions, lost, foresight, .. } = self;
        let dt = conditioner.tick(time);
        for (i, (s, &received)) in interface.signals.iter().zip(&*received).enumerate() {
            if let Some(of) = s.age_of {
                (table[s.at], table[s.at + 1]) = (1.0, (time - read[of]).max(0.0));
                continue;
            }
            let known = received > f64::NEG_INFINITY;
            let in_time = known && s.timeout.is_none_or(|t| time - received <= t);
            if let Some(Some(estimate)) = motions.get_mut(i) {
                if !in_time {
                    estimate.forget();
                }
                let foresight = if s.is_of_person() { *foresight } else { 0.0 };
                moving(s, estimate, lost[i], (time, foresight), last, table);
                continue;
            }
            let value = &mut table[s.at + 1..=s.at + s.len];
            value.copy_from_slice(&last[s.at + 1..=s.at + s.len]);
            let present = in_time && conditioner.apply(interface, i, value, dt, &axes);
            if !present {
                conditioner.absent(i);
                value.fill(f64::NAN);
            }
            table[s.at] = if present { 1.0 } else { -1.0 };
        }
    }
}

/// Motion of a signal that is tracked, before its first reading.
fn estimate(s: &SignalProgram) -> Option<Estimate> {
    s.motion.as_ref().map(|motion| Estimate::new(motion, s.conditioning.low_pass))
}

/// Times and values of the readings of a tracked signal.
struct Readings<'a> {
    /// Time of the last reading, in s; minus infinity if there is none.
    received: &'a mut f64,
    /// Time from which its readings count as missing, in s; infinity if none ever came.
    lost: &'a mut f64,
    /// Table of the last values.
    last: &'a mut [f64],
}

/// Takes a reading of a tracked signal.
fn tracked(s: &SignalProgram, estimate: &mut Estimate, value: &[f64], time: f64, readings: Readings) {
    let Readings { received, lost, last } = readings;
    let mut reading = [f64::NAN; MAX_SENT];
    let Some(reading) = reading.get_mut(..value.len()) else { return };
    reading.copy_from_slice(value);
    let turned = !s.is_pose() || reading.get_mut(3..7).is_some_and(normalised);
    if turned && reading.iter().all(|x| x.is_finite()) {
        // After a gap longer than the timeout, the reading has no predecessor.
        if time - *received > s.timeout.unwrap_or(f64::INFINITY) {
            estimate.forget();
        }
        if s.is_pose() {
            estimate.pose(reading, time);
        } else {
            estimate.point(reading, time);
        }
        last[s.at + 1..=s.at + s.len].copy_from_slice(&reading[..s.len]);
        *received = time;
        *lost = time + s.timeout.unwrap_or(f64::INFINITY);
    } else {
        estimate.forget();
        *received = f64::NEG_INFINITY;
        if lost.is_finite() {
            *lost = lost.min(time);
        }
    }
}

/// Writes a tracked signal into the table, at a time, and foreseen by another (s). `lost` is the time from which its readings count as
/// missing: infinity if none ever came.
fn moving(
    s: &SignalProgram,
    estimate: &mut Estimate,
    lost: f64,
    (time, foresight): (f64, f64),
    last: &[f64],
    table: &mut [f64],
) {
    let (value, velocity, known, uncertainty) = (s.at + 1, s.velocity_at(), s.known_at(), s.uncertainty_at());
    table[value..uncertainty + 2].fill(f64::NAN);
    let growth = s.motion.and_then(|m| if let Lost::Hold(growth) = m.lost { Some(growth) } else { None });
    let held = growth.filter(|_| lost.is_finite());
    let present = estimate.is_known();
    table[s.at] = if present { 1.0 } else { -1.0 };
    table[known] = if present || held.is_some() { 1.0 } else { -1.0 };
    if present {
        let (before, rates) = table.split_at_mut(velocity);
        estimate.write(time, foresight, &mut before[value..], &mut rates[..known - velocity]);
        table[uncertainty..uncertainty + 2].fill(0.0);
    } else if let Some(growth) = held {
        table[value..velocity].copy_from_slice(&last[value..velocity]);
        table[velocity..known].fill(0.0);
        table[uncertainty] = growth * (time - lost).max(0.0);
        table[uncertainty + 1] = growth;
    }
}
