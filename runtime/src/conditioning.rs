//! What is done to the values of signals at a tick: the bias of a wrench taken away, the wrench turned into the axes of
//! the world, and a filter.
//!
//! ```text
//! f_w = R (f - f_bias)        m_w = R (m - m_bias)        R: the sensor's link at the observed configuration
//! y_k = u_k + a (y_{k-1} - u_k),    a = exp(-2π f_c T)
//! ```
//!
//! The point of the moment stays the origin of the link. The filter is that of first order, `y' = 2π f_c (u - y)`, solved
//! exactly for a u that stands over the tick, with T the time since the tick before; it begins at the first value after
//! the signal was absent. It runs in the axes of the world, so that a sensor that is mounted otherwise gives the same.
//! Source: Åström, Wittenmark, Computer-Controlled Systems (1997), ch. 3.

use nalgebra::{UnitQuaternion, Vector3};

use crate::program::Interface;

/// The conditioning of all signals, with what it remembers.
#[derive(Debug)]
pub(crate) struct Conditioner {
    /// For each signal its bias in the sensor's axes, zero where it has none.
    bias: Vec<[f64; 6]>,
    /// For each signal how its axes stood at the last tick.
    axes: Vec<UnitQuaternion<f64>>,
    /// The outputs of the filters, in the places of the table of signals.
    filtered: Vec<f64>,
    /// For each signal whether its filter has begun.
    running: Vec<bool>,
    /// When the last tick was, in s.
    last: f64,
}

fn turn(value: &mut [f64], by: &UnitQuaternion<f64>) {
    for part in value.chunks_exact_mut(3) {
        let turned = by * Vector3::new(part[0], part[1], part[2]);
        part.copy_from_slice(turned.as_slice());
    }
}

impl Conditioner {
    pub fn new(interface: &Interface) -> Self {
        let signals = interface.signals.len();
        let mut new = Conditioner {
            bias: vec![[0.0; 6]; signals],
            axes: vec![UnitQuaternion::identity(); signals],
            filtered: vec![0.0; interface.width()],
            running: vec![false; signals],
            last: 0.0,
        };
        new.restart(interface);
        new
    }

    /// Back to the biases that were declared, with filters that have not begun.
    pub fn restart(&mut self, interface: &Interface) {
        for (bias, s) in self.bias.iter_mut().zip(&interface.signals) {
            *bias = s.conditioning.bias.unwrap_or_default();
        }
        self.running.fill(false);
    }

    /// The next tick is at this time; gives how long ago the last one was, in s.
    pub fn tick(&mut self, time: f64) -> f64 {
        let dt = time - self.last;
        self.last = time;
        if dt > 0.0 { dt } else { 0.0 }
    }

    /// The signal is absent at this tick.
    pub fn absent(&mut self, signal: usize) {
        self.running[signal] = false;
    }

    /// Conditions a value in its place of the table, `dt` after the tick before. `axes` says how a link stands. False
    /// where there is nothing to be had: the axes are not known, or a number is not finite.
    pub fn apply(
        &mut self,
        interface: &Interface,
        signal: usize,
        value: &mut [f64],
        dt: f64,
        axes: impl Fn(robot::LinkId) -> Option<UnitQuaternion<f64>>,
    ) -> bool {
        let s = &interface.signals[signal];
        if s.kind == "wrench" {
            value.iter_mut().zip(self.bias[signal]).for_each(|(x, b)| *x -= b);
            if let Some(link) = s.conditioning.frame {
                let Some(stands) = axes(link) else { return false };
                self.axes[signal] = stands;
                turn(value, &stands);
            }
        }
        if !value.iter().all(|x| x.is_finite()) {
            return false;
        }
        let Some(cutoff) = s.conditioning.low_pass else { return true };
        let kept = (-std::f64::consts::TAU * cutoff * dt).exp();
        let begun = std::mem::replace(&mut self.running[signal], true);
        for (y, u) in self.filtered[s.at + 1..=s.at + s.len].iter_mut().zip(value) {
            let next = if begun { *u + kept * (*y - *u) } else { *u };
            // Two numbers near the largest one are further apart than a number can be.
            *y = if next.is_finite() { next } else { *u };
            *u = *y;
        }
        true
    }

    /// What a wrench shows now becomes its bias; it shows zero.
    pub fn tare(&mut self, interface: &Interface, signal: usize, shown: &mut [f64]) {
        let s = &interface.signals[signal];
        turn(shown, &self.axes[signal].inverse());
        self.bias[signal].iter_mut().zip(&*shown).for_each(|(b, x)| *b += x);
        shown.fill(0.0);
        self.filtered[s.at + 1..=s.at + s.len].fill(0.0);
    }
}
