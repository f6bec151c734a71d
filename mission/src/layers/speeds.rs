//! How fast the robots move in a layer, exactly: for given agents and objects the rest is a convex program in one number,
//! the length of the layer.
//!
//! A robot that has ways of together `S` (m) and `T` (s) to move takes least energy at one speed for all of them, `S / T`:
//! `varrho_1 T + varrho_2 S + varrho_3 S^2 / T` (6.4), convex in `T`. A layer of length `D` leaves it `T = D - release -
//! constant times`, of which it uses no more than the speed of least energy needs. The derivative by `D` is increasing and
//! concave, so that Newton's method from the shortest possible length comes to its root from the left, without overshoot.

use super::instance::{Layer, Mover};

/// What an agent has to do in a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Load {
    /// Number of tasks.
    pub count: usize,
    /// Sum of [`super::instance::Mode::time`].
    pub time: f64,
    /// Sum of the ways.
    pub way: f64,
    /// Sum of the costs.
    pub cost: f64,
}

/// A layer with its best speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Timing {
    /// Its length `D` (s).
    pub length: f64,
    /// What the layer costs: loads, energy, makespan.
    pub cost: f64,
}

impl Mover {
    /// The speed at which a metre costs least when a second costs `second`: the root of the derivative of
    /// `joule (varrho_1 / v + varrho_3 v) + second / v`, within the robot's speeds. 0 of a person.
    pub fn speed_at(&self, second: f64) -> f64 {
        let Mover::Robot { speed, energy, joule } = self else { return 0.0 };
        let drag = joule * energy.drag;
        if drag <= 0.0 {
            return speed.high;
        }
        ((joule * energy.standby + second) / drag).sqrt().clamp(speed.low, speed.high)
    }

    /// What a metre costs at this speed, friction left out, when a second costs `second`. 0 of a person.
    pub fn metre(&self, at: f64, second: f64) -> f64 {
        let Mover::Robot { energy, joule, .. } = self else { return 0.0 };
        joule * (energy.standby / at + energy.drag * at) + second / at
    }

    /// The time that ways take at most, at the speed of least energy, and at least (s).
    fn times(&self, way: f64) -> (f64, f64) {
        match self {
            Mover::Robot { speed, .. } if way > 0.0 => (way / self.speed_at(0.0), way / speed.high),
            _ => (0.0, 0.0),
        }
    }

    /// The time (s) that ways of together `way` (m) take where `most` (s) is left for them.
    pub fn moving(&self, way: f64, most: f64) -> f64 {
        let (slow, fast) = self.times(way);
        most.min(slow).max(fast)
    }
}

/// The best length of a layer with these loads of the agents, and its cost.
pub(super) fn timing(movers: &[Mover], layer: &Layer, loads: &[Load], second: f64) -> Timing {
    let busy = || (0..movers.len()).filter(|agent| loads[*agent].count > 0);
    let begun = |agent: usize| layer.release[agent] + loads[agent].time;
    let mut length = layer.floor;
    for agent in busy() {
        length = length.max(begun(agent) + movers[agent].times(loads[agent].way).1);
    }
    for _ in 0..64 {
        let (mut slope, mut curve) = (second, 0.0);
        for agent in busy() {
            let (mover, way) = (&movers[agent], loads[agent].way);
            let Mover::Robot { energy, joule, .. } = mover else { continue };
            let left = length - begun(agent);
            if way > 0.0 && left < mover.times(way).0 {
                let speed = way / left;
                slope -= joule * (energy.drag * speed * speed - energy.standby);
                curve += joule * energy.drag * 2.0 * speed * speed / left;
            }
        }
        if slope >= 0.0 || curve <= 0.0 {
            break;
        }
        let step = -slope / curve;
        length += step;
        if step <= 1e-13 * length {
            break;
        }
    }
    let mut cost = second * length;
    for agent in busy() {
        let Load { way, cost: own, .. } = loads[agent];
        cost += own;
        if way > 0.0 {
            let speed = way / movers[agent].moving(way, length - begun(agent));
            cost += way * movers[agent].metre(speed, 0.0);
        }
    }
    Timing { length, cost }
}
