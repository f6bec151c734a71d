//! Sag of a robot at rest: how far it hangs below its set point, because of its weight.
//!
//! The set point of a robot that is moved by hand follows it, so that it is not pulled back when its drives are on again. That of an arm that
//! sags must stay: it would sink with it, and on. What is sag is known from the motion before, or from the moment in which brakes open, and learned
//! further in the first second of rest, slowly, and while the robot hardly moves; the set point follows what goes beyond it by more than [`HELD`].
//! Source: ours.

/// Distance from the learned sag, in rad or m, up to which the set point stays.
pub(super) const HELD: f64 = 0.02;

/// Largest sag, in rad or m, and the time in which an arm settles when its brakes open (s).
const MOST: f64 = 0.1;
pub(super) const SETTLES: f64 = 0.2;

/// Time in which the sag is learned (s), and the rate at which it is, in rad/s or m/s.
const LEARNS: f64 = 1.0;
const RATE: f64 = 0.05;

/// Motion of a robot that hardly moves: rad/s or m/s, and rad or m of noise.
const SLOW: f64 = 0.2;
const NOISE: f64 = 2e-3;

/// Sag of each degree of freedom.
pub(super) struct Sag {
    /// Place of the robot minus its set point (rad or m).
    by: Vec<f64>,
    /// Time for which it was at rest (s).
    time: f64,
    /// Time for which whatever it does is sag (s).
    settles: f64,
}

impl Sag {
    pub fn new(nv: usize) -> Sag {
        Sag { by: vec![0.0; nv], time: 0.0, settles: 0.0 }
    }

    /// The robot moves, or is held by its brakes: its sag is learned anew when it is at rest, at once in the first `settles` seconds.
    pub fn restart(&mut self, settles: f64) {
        (self.time, self.settles) = (0.0, settles);
    }

    /// Takes how far the robot is from its set point, and how far it has `moved` in the last `dt` seconds, and leaves in `off` what the set point
    /// has to follow. Returns false if that is nothing.
    pub fn follow(&mut self, off: &mut [f64], moved: &[f64], dt: f64) -> bool {
        let (settles, learns) = (self.time <= self.settles, self.time < LEARNS);
        self.time += dt;
        for ((by, off), moved) in self.by.iter_mut().zip(&mut *off).zip(moved) {
            if settles {
                *by = off.clamp(-MOST, MOST);
            } else if learns && moved.abs() <= SLOW * dt + NOISE {
                *by += (*off - *by).clamp(-RATE * dt, RATE * dt);
            }
            // A robot between its set point and its sag is on its way to one of them.
            *off -= off.clamp(by.min(0.0) - HELD, by.max(0.0) + HELD);
        }
        off.iter().any(|off| *off != 0.0)
    }
}
