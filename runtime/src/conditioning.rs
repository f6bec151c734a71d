//! Conditioning of signal values at a tick: subtraction of the bias of a wrench, rotation of the wrench into the world
//! axes, and a low-pass filter.
//!
//! ```text
//! f_w = R (f - f_bias)        m_w = R (m - m_bias)        R: the sensor's link at the observed configuration
//! y_k = u_k + a (y_{k-1} - u_k),    a = exp(-2π f_c T)
//! ```
//!
//! The reference point of the moment remains the origin of the link. The filter is of first order,
//! `y' = 2π f_c (u - y)`, discretized exactly for an input u that is constant over the tick, with T the time since the
//! previous tick. The difference of two angles is that to the nearest turn: 179 and -179 degrees are two degrees apart, and the
//! output is at most half a turn from the input. It starts at the first value after the signal was absent. It runs in the world axes, so that its
//! output does not depend on the mounting of the sensor. Source: Åström, Wittenmark, Computer-Controlled Systems
//! (1997), ch. 3.

use nalgebra::{UnitQuaternion, Vector3};
use robot::nearest_turn;

use crate::program::Interface;

/// Conditioning of all signals, with its memory.
#[derive(Debug)]
pub(crate) struct Conditioner {
    /// Bias of each signal in the sensor's axes; zero if it has none.
    bias: Vec<[f64; 6]>,
    /// Orientation of each signal's axes at the last tick.
    axes: Vec<UnitQuaternion<f64>>,
    /// Outputs of the filters, at the indices of the table of signals.
    filtered: Vec<f64>,
    /// True for each signal whose filter has started.
    running: Vec<bool>,
    /// Time of the last tick (s).
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

    /// Restores the declared biases and resets the filters.
    pub fn restart(&mut self, interface: &Interface) {
        for (bias, s) in self.bias.iter_mut().zip(&interface.signals) {
            *bias = s.conditioning.bias.unwrap_or_default();
        }
        self.running.fill(false);
    }

    /// Begins the tick at `time` and returns the time since the last tick (s), at least 0.
    pub fn tick(&mut self, time: f64) -> f64 {
        let dt = time - self.last;
        self.last = time;
        if dt > 0.0 { dt } else { 0.0 }
    }

    /// Resets the filter of a signal that is absent at this tick.
    pub fn absent(&mut self, signal: usize) {
        self.running[signal] = false;
    }

    /// Conditions a value in place, `dt` (s) after the previous tick. `axes` returns the orientation of a link. Returns
    /// false if there is no usable value: the axes are not known, or a number is not finite.
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
            let behind = if s.kind == "angle" { nearest_turn(*y - *u) } else { *y - *u };
            let next = if begun { *u + kept * behind } else { *u };
            // The difference of two numbers near the largest finite one overflows.
            *y = if next.is_finite() { next } else { *u };
            *u = *y;
        }
        true
    }

    /// Tares a wrench: adds its present value to the bias and sets the value to zero.
    pub fn tare(&mut self, interface: &Interface, signal: usize, shown: &mut [f64]) {
        let s = &interface.signals[signal];
        turn(shown, &self.axes[signal].inverse());
        self.bias[signal].iter_mut().zip(&*shown).for_each(|(b, x)| *b += x);
        shown.fill(0.0);
        self.filtered[s.at + 1..=s.at + s.len].fill(0.0);
    }
}
