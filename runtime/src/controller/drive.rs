//! Model of the drives: what a robot will still do by commands that were sent already.
//!
//! A declared lag L and a dead time D say how a velocity command u becomes a velocity v,
//!
//! ```text
//! L v' = u(t - D) - v        q_p = q + L v + ∫ u over the last D seconds        hence  q_p' = u
//! ```
//!
//! q_p is where the robot comes to rest if zero is sent from now on. It moves as a robot with ideal drives would: the tracking law and the rows
//! of hard limits use it in place of q, and need to know nothing else of the drives. v is computed from the commands, not from
//! differences of encoders. Source: Smith, Closer control of loops with dead time (1957), for the law; the rest is ours.

/// Most parts into which a dead time is divided, and parts of a period that are divided no further.
const PARTS: f64 = 32.0;
const PARTS_OF_PERIOD: f64 = 8.0;

/// Drives of a robot.
pub(super) struct Drive {
    lag: f64,
    dead_time: f64,
    /// Velocity of each degree of freedom by the model (rad/s or m/s).
    speed: Vec<f64>,
    /// Way that was commanded in each part of the dead time, `nv` numbers each (rad or m); the one at `part` acts now.
    waiting: Vec<f64>,
    /// Duration of a part (s).
    width: f64,
    part: usize,
    /// Time of the present part that has passed (s), and the way that was commanded in it.
    filled: f64,
    entering: Vec<f64>,
    /// Way still to go (rad or m).
    coast: Vec<f64>,
    /// Mean velocity while the last command was held (rad/s or m/s).
    mean: Vec<f64>,
}

impl Drive {
    /// Drives of `nv` degrees of freedom with a lag and a dead time, for decisions every `period` (s).
    pub fn new(lag: f64, dead_time: f64, period: f64, nv: usize) -> Drive {
        let parts = (dead_time / period * PARTS_OF_PERIOD).ceil().min(PARTS) as usize;
        Drive {
            lag,
            dead_time,
            speed: vec![0.0; nv],
            waiting: vec![0.0; parts * nv],
            width: dead_time / parts.max(1) as f64,
            part: 0,
            filled: 0.0,
            entering: vec![0.0; nv],
            coast: vec![0.0; nv],
            mean: vec![0.0; nv],
        }
    }

    /// True if commands act at once, as far as is known.
    pub fn is_ideal(&self) -> bool {
        self.lag + self.dead_time == 0.0
    }

    /// Way that the robot will still go (`nv` numbers).
    pub fn coast(&self) -> &[f64] {
        &self.coast
    }

    /// Mean velocity that the last command and those before it gave the robot (`nv` numbers).
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// The robot stands, and nothing that was sent will still move it.
    pub fn rest(&mut self) {
        for numbers in [&mut self.speed, &mut self.waiting, &mut self.entering, &mut self.coast, &mut self.mean] {
            numbers.fill(0.0);
        }
    }

    /// Takes a velocity command that was held for a time (s).
    pub fn advance(&mut self, u: &[f64], dt: f64) {
        if self.is_ideal() || dt <= 0.0 {
            self.mean.copy_from_slice(u);
            return;
        }
        self.mean.fill(0.0);
        if self.waiting.is_empty() {
            let Drive { speed, mean, lag, .. } = self;
            follow(*lag, dt, u.iter().copied(), speed, mean);
        } else {
            self.delay(u, dt);
        }
        for ((coast, mean), u) in self.coast.iter_mut().zip(&mut self.mean).zip(u) {
            *coast += u * dt - *mean;
            *mean /= dt;
        }
    }

    /// Passes a command through the dead time.
    fn delay(&mut self, u: &[f64], dt: f64) {
        let Drive { lag, speed, waiting, width, part, filled, entering, mean, .. } = self;
        let mut left = dt;
        while left > 0.0 {
            let step = left.min(*width - *filled);
            left -= step;
            *filled += step;
            let acts = &mut waiting[*part * u.len()..][..u.len()];
            follow(*lag, step, acts.iter().map(|way| way / *width), speed, mean);
            entering.iter_mut().zip(u).for_each(|(way, u)| *way += u * step);
            if *filled >= *width {
                acts.copy_from_slice(entering);
                entering.fill(0.0);
                (*part, *filled) = ((*part + 1) % (waiting.len() / u.len()), 0.0);
            }
        }
    }
}

/// Moves velocities for a time (s) towards those that are wanted, with a lag (s), and adds the ways.
fn follow(lag: f64, time: f64, wanted: impl Iterator<Item = f64>, speed: &mut [f64], ways: &mut [f64]) {
    let gone = if lag > 0.0 { -(-time / lag).exp_m1() } else { 1.0 };
    for ((v, way), wanted) in speed.iter_mut().zip(ways).zip(wanted) {
        *way += wanted * time + (*v - wanted) * lag * gone;
        *v += gone * (wanted - *v);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn drive(lag: f64, dead_time: f64) -> Drive {
        Drive::new(lag, dead_time, 0.01, 1)
    }

    proptest! {
        /// A robot that obeys the law in small steps goes by what was said, and comes to rest where it was said.
        #[test]
        fn a_robot_comes_to_rest_where_the_model_says(
            commands in prop::collection::vec((-2.0..2.0_f64, 1e-3..0.03_f64), 1..20),
            lag in prop_oneof![Just(0.0), 0.005..0.1_f64],
            parts in 0_usize..30,
        ) {
            // Dead times of whole parts of what is integrated.
            let (small, dead_time) = (2.5e-4, parts as f64 * 2.5e-3);
            let mut model = drive(lag, dead_time);
            let mut late = std::collections::VecDeque::from(vec![0.0; (dead_time / small).round() as usize]);
            let (mut q, mut v) = (0.0, 0.0);
            let mut go = |u: f64, steps: usize| {
                let begin = q;
                for _ in 0..steps {
                    late.push_back(u);
                    let acts = late.pop_front().expect("a command");
                    if lag > 0.0 {
                        let gone = 1.0 - (-small / lag).exp();
                        q += acts * small + (v - acts) * lag * gone;
                        v += gone * (acts - v);
                    } else {
                        q += acts * small;
                    }
                }
                (q, q - begin)
            };
            let mut place = 0.0;
            for (u, held) in commands {
                let steps = (held / small).round().max(1.0) as usize;
                let held = steps as f64 * small;
                model.advance(&[u], held);
                let (q, by) = go(u, steps);
                // Commands differ by at most 4 rad/s, and a part of a dead time, of 2.5 ms at most, is taken as even.
                prop_assert!((model.mean()[0] * held - by).abs() < 4.0 * 2.5e-3, "{} and {by}", model.mean()[0] * held);
                place = q + model.coast()[0];
            }
            let (end, _) = go(0.0, 20_000);
            prop_assert!((end - place).abs() < 4.0 * 2.5e-3, "{end} and {place}");
        }
    }

    #[test]
    fn ideal_drives_have_no_way_to_go() {
        let mut model = drive(0.0, 0.0);
        model.advance(&[1.5], 0.01);
        assert_eq!((model.coast(), model.mean()), (&[0.0][..], &[1.5][..]));
    }

    #[test]
    fn the_place_of_rest_moves_as_it_is_told() {
        for (lag, dead_time) in [(0.05, 0.0), (0.0, 0.02), (0.1, 0.033)] {
            let mut model = drive(lag, dead_time);
            let mut q = 0.0;
            for k in 0..300 {
                model.advance(&[0.3], 0.004);
                q += model.mean()[0] * 0.004;
                let told = 0.3 * 0.004 * f64::from(k + 1);
                assert!((q + model.coast()[0] - told).abs() < 1e-12, "{q} {told}");
            }
            assert!((model.coast()[0] - 0.3 * (lag + dead_time)).abs() < 1e-3, "{:?}", model.coast());
            model.rest();
            assert_eq!(model.coast(), &[0.0]);
        }
    }
}
