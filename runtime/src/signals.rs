//! What the host tells the controller between ticks: values of signals, each with the time at which it was received, and
//! events.

use nalgebra::UnitQuaternion;

use crate::conditioning::Conditioner;
use crate::program::{Interface, Lost, SignalProgram};
use crate::tracking::Estimate;

/// A quaternion whose length differs from 1 by more is no orientation.
pub const NOT_UNIT: f64 = 1e-3;

/// Brings a quaternion to length 1; false where it is none.
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
/// A value counts until its signal's timeout has passed; then it is absent, as it is before the first one was received. A
/// value that is not finite makes its signal absent at once, and so does an orientation whose quaternion is further than
/// [`NOT_UNIT`] from length 1; closer ones are normalised. Variables of the machine stand among them; the host reads them
/// and cannot set them.
///
/// The tracked point of a person has a velocity beside its value, which the host sends behind the position or which is
/// estimated. When its readings stop it is absent too; but where it is held, its last position counts on, at rest, with
/// an uncertainty that grows from then on.
pub struct Signals {
    interface: Interface,
    /// For each signal when its value was received, in s; never is minus infinity.
    received: Vec<f64>,
    /// The table: for each signal whether it is present, 1 or -1, and its value, NaN where absent.
    table: Vec<f64>,
    /// The last value of each, in the places of the table.
    last: Vec<f64>,
    /// For each signal, of tracked points, how it moves.
    motions: Vec<Option<Estimate>>,
    /// For each signal since when its readings have been missing, in s; infinity where none ever came.
    lost: Vec<f64>,
    /// Events since the last tick.
    raised: Vec<bool>,
    conditioner: Conditioner,
}

impl Signals {
    pub(crate) fn new(interface: &Interface) -> Self {
        let mut signals = Signals {
            received: vec![f64::NEG_INFINITY; interface.signals.len()],
            table: interface.absent(),
            last: vec![f64::NAN; interface.width()],
            motions: interface.signals.iter().map(|s| s.motion.as_ref().map(Estimate::new)).collect(),
            lost: vec![f64::INFINITY; interface.signals.len()],
            raised: vec![false; interface.events.len()],
            conditioner: Conditioner::new(interface),
            interface: interface.clone(),
        };
        signals.restart();
        signals.at(0.0, |_| None);
        signals
    }

    /// Variables hold what they hold at the start, sensors have the bias that was declared.
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

    /// What signals and events there are.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Gives a signal a value that was received at a time, in s. Never allocates.
    ///
    /// False where there is no such signal, it has another number of numbers: of a tracked point whose velocity is
    /// measured they are six, its position in m and its velocity in m/s, or it is a variable of the machine.
    pub fn set(&mut self, signal: usize, value: &[f64], time: f64) -> bool {
        if self.interface.signals.get(signal).is_none_or(|s| s.is_variable()) {
            return false;
        }
        self.receive(signal, value, time)
    }

    fn receive(&mut self, signal: usize, value: &[f64], time: f64) -> bool {
        let Some(s) = self.interface.signals.get(signal).filter(|s| s.sent() == value.len()) else { return false };
        if let Some(Some(estimate)) = self.motions.get_mut(signal) {
            return point(
                s,
                estimate,
                value,
                time,
                (&mut self.received[signal], &mut self.lost[signal], &mut self.last),
            );
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
        true
    }

    /// Makes a signal absent; one that the machine sets stays as it is. What was known of it is forgotten.
    pub fn clear(&mut self, signal: usize) {
        if self.interface.signals.get(signal).is_some_and(|s| !s.is_variable()) {
            self.received[signal] = f64::NEG_INFINITY;
            self.lost[signal] = f64::INFINITY;
            if let Some(estimate) = &mut self.motions[signal] {
                estimate.forget();
            }
        }
    }

    /// Gives a variable the value that it has from now on, in the table too. False where that is none: the variable is as
    /// it was.
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

    /// Lets what a wrench shows become its bias; false where it is absent.
    pub(crate) fn tare(&mut self, signal: usize) -> bool {
        if !self.is_present(signal) {
            return false;
        }
        let s = &self.interface.signals[signal];
        self.conditioner.tare(&self.interface, signal, &mut self.table[s.at + 1..=s.at + s.len]);
        true
    }

    /// Raises an event; false where there is none. It is seen at the next tick, and gone after it.
    pub fn raise(&mut self, event: usize) -> bool {
        self.raised.get_mut(event).map(|r| *r = true).is_some()
    }

    /// Whether a signal is present at the last tick.
    pub fn is_present(&self, signal: usize) -> bool {
        self.interface.signals.get(signal).is_some_and(|s| self.table[s.at] > 0.0)
    }

    /// Whether the value of a signal may be used at the last tick: it is present, or it is held.
    pub fn is_known(&self, signal: usize) -> bool {
        self.interface.signals.get(signal).is_some_and(|s| self.table[s.known_at()] > 0.0)
    }

    /// The velocity of a tracked point at the last tick, in m/s; NaN where the point is absent, empty for other signals.
    pub fn velocity(&self, signal: usize) -> &[f64] {
        let points = self.interface.signals.get(signal).filter(|s| s.motion.is_some());
        points.map_or(&[], |s| &self.table[s.velocity_at()..s.known_at()])
    }

    /// The uncertainty of a tracked point at the last tick, in m; NaN where it is absent, none for other signals.
    pub fn uncertainty(&self, signal: usize) -> Option<f64> {
        let s = self.interface.signals.get(signal).filter(|s| s.motion.is_some())?;
        Some(self.table[s.uncertainty_at()])
    }

    /// The value of a signal at the last tick; NaN where absent.
    pub fn value(&self, signal: usize) -> &[f64] {
        self.interface.signals.get(signal).map_or(&[], |s| &self.table[s.at + 1..s.at + 1 + s.len])
    }

    /// The table of signals at the last tick.
    pub fn table(&self) -> &[f64] {
        &self.table
    }

    pub(crate) fn events(&self) -> &[bool] {
        &self.raised
    }

    pub(crate) fn forget_events(&mut self) {
        self.raised.fill(false);
    }

    /// Works out the table for a tick. `axes` says how a link stands at the observed configuration, where that is known.
    pub(crate) fn at(&mut self, time: f64, axes: impl Fn(robot::LinkId) -> Option<UnitQuaternion<f64>>) {
        let Signals { interface, received, table, last, conditioner, motions, lost, .. } = self;
        let dt = conditioner.tick(time);
        for (i, (s, &received)) in interface.signals.iter().zip(&*received).enumerate() {
            let known = received > f64::NEG_INFINITY;
            let in_time = known && s.timeout.is_none_or(|t| time - received <= t);
            if let Some(Some(estimate)) = motions.get_mut(i) {
                if !in_time {
                    estimate.forget();
                }
                moving(s, estimate, lost[i], time, last, table);
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

/// Takes a reading of a tracked point.
fn point(
    s: &SignalProgram,
    estimate: &mut Estimate,
    value: &[f64],
    time: f64,
    (received, lost, last): (&mut f64, &mut f64, &mut [f64]),
) -> bool {
    if value.iter().all(|x| x.is_finite()) {
        // A reading that was missing for too long has no predecessor.
        if time - *received > s.timeout.unwrap_or(f64::INFINITY) {
            estimate.forget();
        }
        estimate.reading(value, time);
        last[s.at + 1..s.at + 4].copy_from_slice(&value[..3]);
        *received = time;
        *lost = time + s.timeout.unwrap_or(f64::INFINITY);
    } else {
        estimate.forget();
        *received = f64::NEG_INFINITY;
        if lost.is_finite() {
            *lost = lost.min(time);
        }
    }
    true
}

/// Writes a tracked point into the table. `lost` is since when its readings have been missing: infinity where they are
/// not, or where none ever came.
fn moving(s: &SignalProgram, estimate: &Estimate, lost: f64, time: f64, last: &[f64], table: &mut [f64]) {
    let (value, velocity, known, uncertainty) = (s.at + 1, s.velocity_at(), s.known_at(), s.uncertainty_at());
    table[value..uncertainty + 2].fill(f64::NAN);
    let growth = s.motion.and_then(|m| if let Lost::Hold(growth) = m.lost { Some(growth) } else { None });
    let held = growth.filter(|_| lost.is_finite());
    let present = estimate.is_known();
    table[s.at] = if present { 1.0 } else { -1.0 };
    table[known] = if present || held.is_some() { 1.0 } else { -1.0 };
    if present {
        table[value..velocity].copy_from_slice(&last[value..velocity]);
        table[velocity..known].copy_from_slice(estimate.velocity());
        table[uncertainty..uncertainty + 2].fill(0.0);
    } else if let Some(growth) = held {
        table[value..velocity].copy_from_slice(&last[value..velocity]);
        table[velocity..known].fill(0.0);
        table[uncertainty] = growth * (time - lost).max(0.0);
        table[uncertainty + 1] = growth;
    }
}
