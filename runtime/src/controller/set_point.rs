//! Set point: the reference as it is sent to the robot, at the rate at which the host calls.
//!
//! The hierarchy moves its reference from `q_k` to `q_{k+1} = q_k + T v_k` in each period. Commands are the velocities of a ramp from one
//! decision to the next, each held for a time δ; see [`clock`](super::clock). A robot that follows them is, at `s = (t - t_k)/T`, at
//!
//! ```text
//! p(t)  =  B(t) + δ/2 w(t)
//! B(t)  =  q_k - T/2 v_{k-1} + T (s v_{k-1} + s²/2 (v_k - v_{k-1}))
//! ```
//!
//! for `δ <= T`, and `B(t + T/2)` for hosts that call less often. B is the quadratic B-spline whose control points are the references: it cuts their corners, at most half a period behind them. With
//! `δ = T` the set point at a decision is the reference itself. It follows from the decisions alone, so that no error of any host's clock
//! is summed up. Source: ours.

use robot::Model;

/// The last decision.
pub(super) struct SetPoint {
    period: f64,
    /// Reference at its begin.
    from: Vec<f64>,
    /// Velocity that was decided before it, and by it.
    before: Vec<f64>,
    after: Vec<f64>,
    /// Storage for a displacement.
    way: Vec<f64>,
}

impl SetPoint {
    pub fn new(model: &Model, period: f64, home: &[f64]) -> SetPoint {
        let still = vec![0.0; model.nv()];
        SetPoint { period, from: home.to_vec(), before: still.clone(), after: still.clone(), way: still }
    }

    /// Moves on to a decision: the velocity `v` from the reference `q`, after the velocity `before`.
    pub fn decide(&mut self, q: &[f64], before: &[f64], v: &[f64]) {
        self.from.copy_from_slice(q);
        self.before.copy_from_slice(before);
        self.after.copy_from_slice(v);
    }

    /// Rests at a configuration.
    pub fn rest(&mut self, q: &[f64]) {
        self.from.copy_from_slice(q);
        self.before.fill(0.0);
        self.after.fill(0.0);
    }

    /// Moves the bases of its reference to where they are in `q`.
    pub fn relocate(&mut self, model: &Model, q: &[f64]) {
        model.copy_bases(q, &mut self.from);
    }

    /// Returns true if nothing moves.
    pub fn is_at_rest(&self) -> bool {
        self.before.iter().chain(&self.after).all(|v| *v == 0.0)
    }

    /// Writes the velocity of the ramp at `s` to `out`.
    pub fn velocity(&self, s: f64, out: &mut [f64]) {
        for ((out, a), b) in out.iter_mut().zip(&self.before).zip(&self.after) {
            // The end of the ramp is the decision itself, without rounding.
            *out = if s == 1.0 { *b } else { a + s * (b - a) };
        }
    }

    /// Writes the set point at `s` to `out`, for commands that are held for a time (s). Before the last decision, where a slow host calls, the velocity
    /// was about that before it.
    pub fn place(&mut self, model: &Model, s: f64, hold: f64, out: &mut [f64]) {
        let t = self.period;
        let (s, hold) = if hold > t { (s + 0.5, 0.0) } else { (s, hold) };
        let (ramp, at) = if s > 0.0 { (0.5 * s * s, s) } else { (0.0, 0.0) };
        let before = t * (s - 0.5 - ramp) + 0.5 * hold * (1.0 - at);
        let after = t * ramp + 0.5 * hold * at;
        for ((way, a), b) in self.way.iter_mut().zip(&self.before).zip(&self.after) {
            *way = before * a + after * b;
        }
        out.copy_from_slice(&self.from);
        model.integrate(out, &self.way, 1.0);
    }
}
