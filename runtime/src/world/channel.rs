//! Transmission of values from their measurement to the controller: instants of sending, noise, delay and loss.

use std::collections::VecDeque;

use rand_distr::{Distribution, Normal, Uniform};
use rand_pcg::Pcg64;

use super::NOW;
use crate::program::Sending;

/// A measured value.
pub(super) struct Sample {
    /// Its numbers.
    pub numbers: Vec<f64>,
    /// Number of them, from the first, that noise is added to.
    pub noisy: usize,
}

/// Transmission channel for values.
pub(super) struct Channel {
    sending: Sending,
    noise: Option<Normal<f64>>,
    chance: Option<Uniform<f64>>,
    random: Pcg64,
    /// Number of values that were due.
    sent: u64,
    /// Values in transmission: time of arrival, in s, and numbers.
    underway: VecDeque<(f64, Vec<f64>)>,
    /// Number of instants with NaN that have passed.
    bad: usize,
}

impl Channel {
    pub fn new(sending: Sending, random: Pcg64) -> Channel {
        let mut sending = sending;
        sending.nan.sort_by(f64::total_cmp);
        Channel {
            noise: (sending.noise > 0.0).then(|| Normal::new(0.0, sending.noise).ok()).flatten(),
            chance: (sending.drop > 0.0).then(|| Uniform::new(0.0, 1.0).ok()).flatten(),
            sending,
            random,
            sent: 0,
            underway: VecDeque::new(),
            bad: 0,
        }
    }

    /// Sends the sample that `value` returns if one is due. Passes samples that have arrived to `arrive`, with their time
    /// of arrival.
    pub fn tick(&mut self, time: f64, value: impl FnOnce() -> Sample, mut arrive: impl FnMut(&[f64], f64)) {
        let s = &self.sending;
        let open = time >= s.from - NOW && s.to.is_none_or(|to| time < to - NOW);
        // Counted, not summed: a value is never late by rounding.
        if open && time >= s.from + self.sent as f64 * s.period - NOW {
            // If the period is shorter than a tick, or ticks were left out, one value replaces all that are due.
            if s.period > 0.0 {
                self.sent = (((time - s.from + NOW) / s.period) as u64).saturating_add(1);
            }
            self.send(value(), time);
        }
        while self.underway.front().is_some_and(|u| u.0 <= time + NOW) {
            if let Some((arrived, value)) = self.underway.pop_front() {
                arrive(&value, arrived.min(time));
            }
        }
    }

    fn send(&mut self, sample: Sample, time: f64) {
        let Sample { numbers: mut value, noisy } = sample;
        // Drawn for every value, so that a lost value does not change later ones.
        if let Some(noise) = &self.noise {
            value.iter_mut().take(noisy).for_each(|x| *x += noise.sample(&mut self.random));
        }
        let lost = self.chance.is_some_and(|c| c.sample(&mut self.random) < self.sending.drop);
        let before = self.bad;
        while self.sending.nan.get(self.bad).is_some_and(|t| *t <= time + NOW) {
            self.bad += 1;
        }
        let hidden = self.sending.gaps.iter().any(|&(from, to)| time >= from - NOW && time < to - NOW);
        if self.bad > before {
            value.fill(f64::NAN);
        } else if lost || hidden {
            return;
        }
        self.underway.push_back((time + self.sending.delay, value));
    }
}
