//! Temporal operators, one tick at a time. `always` and `eventually` are forms of `until`: something holds always if
//! its negation never occurs, and eventually if it occurs after any values.
//!
//! Storage depends on the values that are needed. An operator without another temporal one above it is needed at the
//! first tick only: a running minimum and maximum ([`Running`]). Below another temporal operator, a bounded window
//! slides ([`Sliding`]). An unbounded window keeps its operands until the end and is then computed backwards
//! ([`open_end`]).

use super::queue::{Queue, Stretch};
use super::value::{Interval, Value};
use crate::program::Window;

/// `until` at the first tick.
#[derive(Clone, Debug)]
pub(super) struct Running {
    window: Window,
    seen: Stretch,
    ticks: u32,
}

impl Running {
    pub fn new(window: Window) -> Running {
        Running { window, seen: Stretch::NONE, ticks: 0 }
    }

    /// True while further ticks can change the value.
    pub fn is_open(&self) -> bool {
        self.window.last.is_none_or(|last| self.ticks <= last)
    }

    /// Takes the next tick.
    pub fn take(&mut self, tick: Stretch) {
        if self.ticks >= self.window.first {
            self.seen.goal = self.seen.goal.or(self.seen.hold.and(tick.goal));
        }
        self.seen.hold = self.seen.hold.and(tick.hold);
        self.ticks += 1;
    }

    /// Value as far as it is known now; `ended` is true if no tick follows.
    pub fn value(&self, ended: bool) -> Interval {
        let cut = match self.window.last {
            Some(_) => self.is_open(),
            None => !ended || self.ticks <= self.window.first,
        };
        let seen = self.seen.goal;
        if cut { seen.or(self.seen.hold.and(Interval::unknown(self.ticks))) } else { seen }
    }
}

/// `until` at every tick, in a bounded window.
#[derive(Clone, Debug)]
pub(super) struct Sliding {
    first: u32,
    last: u32,
    /// Ticks from the one whose value is returned next up to the beginning of its window.
    before: Queue,
    /// Ticks of its window that were seen.
    inside: Queue,
}

impl Sliding {
    /// Creates the operator for a run of at most `ticks`.
    pub fn new(first: u32, last: u32, ticks: u32) -> Sliding {
        let [before, inside] = Self::room(first, last, ticks).map(Queue::with_capacity);
        Sliding { first, last, before, inside }
    }

    /// Number of ticks that each queue must hold.
    pub fn room(first: u32, last: u32, ticks: u32) -> [usize; 2] {
        [first.min(ticks) as usize + 1, (last - first).min(ticks) as usize + 1]
    }

    /// Lag behind its operands, in ticks.
    pub fn reach(&self) -> u32 {
        self.last
    }

    /// Takes tick number `tick`. Returns the next value once its window is full.
    pub fn take(&mut self, tick: u32, stretch: Stretch) -> Option<Interval> {
        if tick < self.first {
            self.before.push(stretch);
            return None;
        }
        self.inside.push(stretch);
        (self.inside.len() > (self.last - self.first) as usize).then(|| {
            let value = self.before.product().hold.and(self.inside.product().goal);
            self.slide();
            value
        })
    }

    /// Next value after the last tick, with a window that is cut off.
    pub fn rest(&mut self, ticks: u32) -> Interval {
        let inside = self.inside.product();
        let value = self.before.product().hold.and(inside.goal.or(inside.hold.and(Interval::unknown(ticks))));
        self.slide();
        value
    }

    fn slide(&mut self) {
        let entered = self.inside.pop();
        if self.first > 0 {
            entered.into_iter().for_each(|tick| self.before.push(tick));
            self.before.pop();
        }
    }
}

/// Computes `until` at every tick with an unbounded window, after the end of a run of `ticks`. `at` returns the
/// operands. The values are written to `out`, which has room for all ticks. `before` has room for the ticks before a
/// window.
pub(super) fn open_end(first: u32, ticks: u32, at: impl Fn(u32) -> Stretch, before: &mut Queue, out: &mut [Interval]) {
    let mut next = Interval::FALSE;
    for (t, out) in (0..ticks).zip(out.iter_mut()).rev() {
        let tick = at(t);
        next = tick.goal.or(tick.hold.and(next));
        *out = next;
    }
    for t in 0..first.min(ticks) {
        before.push(at(t));
    }
    for t in 0..ticks {
        let from = t.saturating_add(first);
        let open = if from < ticks { out[from as usize] } else { Interval::unknown(ticks) };
        out[t as usize] = open.and(before.product().hold);
        if from < ticks {
            before.push(at(from));
        }
        before.pop();
    }
}

/// Slack to a deadline, at the first tick only.
#[derive(Clone, Debug, Default)]
pub(super) struct FirstTime {
    surely: Option<u32>,
    perhaps: Option<u32>,
    ticks: u32,
}

impl FirstTime {
    pub fn take(&mut self, of: Interval) {
        if of.lower.is_true() {
            self.surely.get_or_insert(self.ticks);
        }
        if of.upper.is_true() {
            self.perhaps.get_or_insert(self.ticks);
        }
        self.ticks += 1;
    }

    /// Slack as far as it is known now; unknown before the first tick.
    pub fn value(&self, last: u32, period: f64) -> Interval {
        if self.ticks == 0 {
            return Interval::unknown(0);
        }
        slack(u64::from(last), self.surely, self.perhaps, self.ticks, period)
    }
}

/// Computes the slack to a deadline `last` ticks ahead, at every tick, after the end of a run of `ticks`.
pub(super) fn first_times(last: u32, period: f64, ticks: u32, of: impl Fn(u32) -> Interval, out: &mut [Interval]) {
    let (mut surely, mut perhaps) = (None, None);
    for (t, out) in (0..ticks).zip(out.iter_mut()).rev() {
        let now = of(t);
        surely = if now.lower.is_true() { Some(t) } else { surely };
        perhaps = if now.upper.is_true() { Some(t) } else { perhaps };
        *out = slack(u64::from(t) + u64::from(last), surely, perhaps, ticks, period);
    }
}

/// Deadline minus the tick at which it was met, in s: for the lower end the first tick at which it surely was, for the
/// upper end the first at which it may have been.
fn slack(deadline: u64, surely: Option<u32>, perhaps: Option<u32>, ticks: u32, period: f64) -> Interval {
    let end = ticks.saturating_sub(1);
    let seconds = |met: u32| (deadline as f64 - f64::from(met)) * period;
    let met = |met: u32| Value::new(seconds(met), met);
    let never = Value::new(f64::NEG_INFINITY, end);
    let not_yet = Value::new(seconds(ticks), end);
    Interval { lower: surely.map_or(never, met), upper: perhaps.map_or(not_yet, met) }
}
