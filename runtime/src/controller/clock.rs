//! Time that passes: decisions on the grid of the spec's rate, commands at the rate at which the host calls.
//!
//! The hierarchy decides velocities `v_k` for periods of T, whatever the host does: a call decides as many periods as its
//! command needs, none if the last decision still lasts. Between two decisions the velocity is a ramp,
//!
//! ```text
//! w(τ)  =  v_{k-1} + (τ - t_k)/T (v_k - v_{k-1}),        t_k <= τ <= t_k + T
//! ```
//!
//! A command is held until the next call, δ later, and is therefore the velocity of the ramp at the end of this time, `w(t + δ)`.
//! A host that calls once a period is sent the `v_k` themselves, a host that calls at 1 kHz a ramp whose slope is the acceleration that
//! the hierarchy decided on. In both cases two commands differ by no more than the acceleration times the time between them: τ never
//! advances by more than the time that has passed.
//!
//! A host that calls less often than once a period is sent `w(t + (δ + T)/2)`, the velocity in the middle of the time for which it is held, counted
//! from half a period after the call, so that the robot is where the reference is.
//!
//! While a host is not late, δ is the mean time between its calls. A host may declare it; otherwise the robot stands still until the second
//! call, which tells it.
//!
//! The clock can be paused: motion time, in which trajectories and machines run, is the time of the host minus all pauses. Source: ours.

use crate::fault::Fault;

/// Part of a period by which times may differ and still count as equal: rounding of sums of periods.
const SAME: f64 = 1e-6;

/// Weight of the last interval in the mean time between calls.
const NEWEST: f64 = 0.1;

/// Difference of the mean interval from a period, as a part of it, up to which each call makes one decision, whatever its jitter.
const ON_GRID: f64 = 0.02;

/// Part of a rate by which the mean of the calls may differ from it before a user is told.
const OTHER_RATE: f64 = 0.05;

/// Most decisions of a call. A host that is later, within a long deadline, has motion time stand still for the rest.
pub(super) const MOST_DECISIONS: usize = 64;

/// A call of the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Call {
    /// Motion time (s).
    pub time: f64,
    /// Time of the host (s); what is expected where it cannot be used.
    pub host: f64,
    /// Time since the call before (s); a period at the first call, and where the host's time cannot be used.
    pub dt: f64,
    /// Time for which the command of this call will be held, as far as is known (s).
    pub hold: f64,
    /// The host's time cannot be used, or is too late.
    pub fault: Option<Fault>,
}

/// Clock of a controller.
#[derive(Debug)]
pub(super) struct Clock {
    period: f64,
    deadline: f64,
    /// Time between calls that the host has declared (s); `None` if it is to be found from the calls.
    declared: Option<f64>,
    /// Mean time between calls (s); `None` before it is known.
    hold: Option<f64>,
    /// Host's time of the last call (s); `None` before the first.
    last: Option<f64>,
    /// Sum of all pauses (s): motion time is the host's time minus this.
    paused: f64,
    /// Motion time of the last call (s).
    now: f64,
    /// Motion time of the next decision (s).
    due: f64,
    /// Motion time for which the last command was computed, τ (s).
    lead: f64,
    /// Numbers for the measured rate: intervals between calls, and their sum (s).
    calls: Intervals,
}

/// Intervals between calls that were not faults.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Intervals {
    /// Number of intervals.
    pub count: u64,
    /// Their sum (s).
    pub sum: f64,
    /// The longest (s).
    pub longest: f64,
}

impl Intervals {
    /// Mean rate of the calls (Hz), or `None` before the second call.
    pub fn rate(&self) -> Option<f64> {
        (self.count > 0 && self.sum > 0.0).then(|| self.count as f64 / self.sum)
    }

    /// Mean rate of the calls (Hz), if it differs from that of a period (s) by more than a twentieth.
    pub fn other_rate(&self, period: f64) -> Option<f64> {
        self.rate().filter(|rate| (rate * period - 1.0).abs() > OTHER_RATE)
    }
}

impl Clock {
    pub fn new(period: f64, deadline: f64) -> Clock {
        Clock {
            period,
            deadline,
            declared: Some(period),
            hold: Some(period),
            last: None,
            paused: 0.0,
            now: 0.0,
            due: 0.0,
            lead: 0.0,
            calls: Intervals::default(),
        }
    }

    /// Sets the time between two calls (s), or `None` to find it from the calls.
    pub fn declare(&mut self, interval: Option<f64>) {
        // A longer one would be a fault at the second call.
        self.declared = interval.filter(|i| i.is_finite() && *i > 0.0).map(|i| i.min(self.deadline));
        self.hold = self.declared;
    }

    /// Forgets all calls; what was found of their rate stays.
    pub fn restart(&mut self) {
        self.last = None;
        (self.paused, self.now, self.due, self.lead) = (0.0, 0.0, 0.0, 0.0);
        self.hold = self.declared.or(self.hold);
    }

    /// Longest time between two calls that is no fault (s).
    pub fn deadline(&self) -> f64 {
        self.deadline
    }

    /// Motion time of the last call (s).
    pub fn now(&self) -> f64 {
        self.now
    }

    /// Host's time of the last call (s).
    pub fn host(&self) -> f64 {
        self.now + self.paused
    }

    /// Intervals between calls since the controller was made.
    pub fn intervals(&self) -> Intervals {
        self.calls
    }

    /// Takes the host's time of a call (s).
    pub fn call(&mut self, time: f64) -> Call {
        let Some(last) = self.last else {
            let first = if time.is_finite() { time } else { 0.0 };
            self.last = Some(first);
            (self.now, self.due, self.lead) = (first, first, first);
            let fault = (!time.is_finite()).then_some(Fault::Observation { index: None });
            return Call { time: first, host: first, dt: self.period, hold: self.hold.unwrap_or(0.0), fault };
        };
        let gap = time - last;
        let in_time = gap >= 0.0 && gap <= self.deadline + SAME * self.period;
        if !in_time {
            // Motion goes on by one period, to slow down, whatever the host's clock has done.
            let fault = if time.is_finite() { Fault::Deadline { gap } } else { Fault::Observation { index: None } };
            if time.is_finite() {
                self.last = Some(time);
                self.paused = time - (self.now + self.period);
            }
            self.now += self.period;
            let hold = self.hold.unwrap_or(self.period);
            let host = self.now + self.paused;
            return Call { time: self.now, host, dt: self.period, hold, fault: Some(fault) };
        }
        self.last = Some(time);
        let dt = if (gap - self.period).abs() <= SAME * self.period { self.period } else { gap };
        if gap > 0.0 {
            self.calls.count += 1;
            self.calls.sum += gap;
            self.calls.longest = self.calls.longest.max(gap);
            self.learn(dt);
        }
        let most = (MOST_DECISIONS - 2) as f64 * self.period;
        self.paused += (gap - most).max(0.0);
        self.now = time - self.paused;
        if (self.now - self.due).abs() <= SAME * self.period {
            self.due = self.now;
        }
        Call { time: self.now, host: time, dt, hold: self.hold.unwrap_or(self.period), fault: None }
    }

    fn learn(&mut self, dt: f64) {
        match self.hold {
            None => {
                self.hold = Some(dt);
                // Nothing was commanded before: the first decision begins now.
                self.pause(dt);
            }
            Some(hold) if self.declared.is_none() => self.hold = Some(hold + NEWEST * (dt - hold)),
            Some(_) => {}
        }
    }

    /// Stops motion time for a duration before now (s).
    pub fn pause(&mut self, duration: f64) {
        self.paused += duration;
        self.now = self.last.map_or(self.now, |last| last - self.paused);
    }

    /// Lets the next command begin at this call, where the robot is at rest: a delay from jitter before is forgotten.
    pub fn begin_anew(&mut self) {
        self.lead = self.now;
        self.due = self.now;
    }

    /// Motion time τ for which the last command was computed (s).
    pub fn covered(&self) -> f64 {
        self.lead
    }

    /// Advances the motion time τ for which the command of a call is computed. Decisions are due until it is covered.
    pub fn lead(&mut self, call: &Call, at_rest: bool) {
        let slow = call.hold > (1.0 + ON_GRID) * self.period;
        let mut lead = call.time + if slow { 0.5 * (call.hold + self.period) } else { call.hold };
        if !at_rest && self.lead > call.time - call.dt {
            lead = lead.min(self.lead + call.dt);
        }
        lead = lead.max(self.lead);
        // With jitter, τ would now and then end just beyond a decision, and the next call then need none.
        let on_grid = (call.hold - self.period).abs() <= ON_GRID * self.period;
        let end = self.due + self.period;
        if on_grid && lead > end && lead < end + 0.5 * self.period && end >= call.time + 0.5 * call.hold {
            lead = end.max(self.lead);
        }
        self.lead = lead;
    }

    /// Returns the motion time of the next decision if the command needs it (s).
    pub fn is_due(&self) -> Option<f64> {
        (self.lead > self.due + SAME * self.period).then_some(self.due)
    }

    /// Notes that the decision that was due has been made.
    pub fn decided(&mut self) {
        self.due += self.period;
    }

    /// Position of a motion time on the ramp of the last decision: 0 at its begin, 1 at its end; negative before it.
    pub fn on_ramp(&self, time: f64) -> f64 {
        let x = 1.0 + (time - self.due) / self.period;
        [0.0, 1.0].into_iter().find(|exact| (x - exact).abs() <= SAME).unwrap_or(x.min(1.0))
    }

    /// Time for which the command of a call is the velocity of the robot (s): until the next call, as far as is known. A period is one without
    /// rounding.
    pub fn held(&self, call: &Call) -> f64 {
        let slow = call.hold > (1.0 + ON_GRID) * self.period;
        let held = if slow { call.hold } else { self.lead - call.time };
        if (held - self.period).abs() <= SAME * self.period { self.period } else { held.max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Decisions of each call at these times, with a declared interval.
    fn decisions(times: &[f64], interval: f64) -> Vec<usize> {
        let mut clock = Clock::new(0.01, 0.1);
        clock.declare(Some(interval));
        let made = |time: &f64| {
            let call = clock.call(*time);
            assert_eq!(call.fault, None);
            clock.lead(&call, false);
            let mut count = 0;
            while clock.is_due().is_some() {
                clock.decided();
                count += 1;
            }
            count
        };
        times.iter().map(made).collect()
    }

    #[test]
    fn a_call_a_period_is_a_decision_a_call() {
        let times: Vec<f64> = (0..100_000).map(|k| f64::from(k) * 0.01).collect();
        assert!(decisions(&times, 0.01).iter().all(|made| *made == 1));
        let sums: Vec<f64> = (0..10_000).scan(0.0, |t, _| Some(std::mem::replace(t, *t + 0.01))).collect();
        assert!(decisions(&sums, 0.01).iter().all(|made| *made == 1));
    }

    #[test]
    fn a_fast_host_decides_on_the_grid() {
        let times: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.002).collect();
        let made = decisions(&times, 0.002);
        assert!(made.iter().enumerate().all(|(k, made)| *made == usize::from(k % 5 == 0)));
    }

    #[test]
    fn the_first_call_of_an_unknown_rate_decides_nothing() {
        let mut clock = Clock::new(0.01, 0.1);
        clock.declare(None);
        for (time, due) in [(5.0, None), (5.004, Some(5.0)), (5.008, Some(5.0))] {
            let call = clock.call(time);
            clock.lead(&call, false);
            assert_eq!(clock.is_due().map(|t| (t * 1e6).round() / 1e6), due, "{time}");
        }
    }

    #[test]
    fn a_mean_rate_that_is_another_one_is_told() {
        for (interval, other) in
            [(0.01, None), (0.0104, None), (0.0096, None), (0.0125, Some(80.0)), (0.005, Some(200.0))]
        {
            let mut clock = Clock::new(0.01, 0.1);
            assert_eq!(clock.intervals().other_rate(0.01), None);
            for k in 0..100 {
                clock.call(f64::from(k) * interval);
            }
            assert_eq!(clock.intervals().other_rate(0.01).map(f64::round), other, "{interval}");
        }
    }

    #[test]
    fn late_calls_and_clocks_that_go_back_are_faults() {
        let mut clock = Clock::new(0.01, 0.03);
        assert_eq!(clock.call(0.0).fault, None);
        assert_eq!(clock.call(0.03 + 1e-12).fault, None);
        assert!(matches!(clock.call(0.07).fault, Some(Fault::Deadline { .. })));
        assert!(matches!(clock.call(0.06).fault, Some(Fault::Deadline { gap }) if gap < 0.0));
        assert!(matches!(clock.call(f64::NAN).fault, Some(Fault::Observation { index: None })));
        assert_eq!(clock.call(0.07).fault, None);
    }

    proptest! {
        /// τ advances by no more than the time that has passed, and never stays behind the call by more than was lost to jitter.
        #[test]
        fn the_ramp_is_no_faster_than_time(gaps in prop::collection::vec(1e-4..0.05_f64, 2..200), interval in 1e-3..0.05_f64) {
            let mut clock = Clock::new(0.01, 0.1);
            clock.declare(Some(interval));
            let (mut time, mut last) = (0.0, None);
            for gap in gaps {
                let call = clock.call(time);
                clock.lead(&call, false);
                let mut count = 0;
                while clock.is_due().is_some() {
                    clock.decided();
                    count += 1;
                }
                let x = clock.on_ramp(clock.covered());
                prop_assert!(count <= 8 && x > -1e-6 && x <= 1.0, "{count} {x}");
                if let Some((before, at)) = last {
                    let (ahead, passed): (f64, f64) = (clock.covered() - before, time - at);
                    prop_assert!(ahead >= 0.0 && ahead <= passed + 1e-12);
                }
                last = Some((clock.covered(), time));
                time += gap;
            }
        }
    }
}
