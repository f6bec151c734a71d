//! Forces of people on a sensor: a constant wrench, or a hand that pulls.

use nalgebra::Vector3;
use robot::{Data, Model};

use super::NOW;
use crate::program::{Conditioning, Force, Program, PushScript};
use crate::signals::Signals;

/// Force of a person on a sensor.
pub(super) struct Push {
    script: PushScript,
    model: Model,
    data: Data,
    /// Time and position of the link at the last evaluation.
    last: Option<(f64, Vector3<f64>)>,
    /// Conditioning of the sensor that reports it.
    sensor: Conditioning,
}

impl Push {
    pub fn new(script: &PushScript, program: &Program) -> Push {
        let model = program.robot.model.clone();
        let sensor = program.interface.signals[script.signal].conditioning.clone();
        Push { script: script.clone(), data: Data::new(&model), model, last: None, sensor }
    }

    /// Index of the signal that reports it.
    pub fn signal(&self) -> usize {
        self.script.signal
    }

    /// Reading of the sensor for a wrench in the axes of the world: the wrench in its own axes, plus its bias.
    fn shown(&mut self, wrench: [f64; 6], q: &[f64]) -> [f64; 6] {
        let mut shown = wrench;
        if let Some(link) = self.sensor.frame {
            self.model.forward(q, &mut self.data);
            let axes = self.data.pose(link).rotation;
            for part in shown.chunks_exact_mut(3) {
                let turned = axes.inverse_transform_vector(&Vector3::new(part[0], part[1], part[2]));
                part.copy_from_slice(turned.as_slice());
            }
        }
        shown.iter_mut().zip(self.sensor.bias.unwrap_or_default()).for_each(|(x, b)| *x += b);
        shown
    }

    /// Wrench at a time; zero while nobody touches the sensor.
    pub fn wrench(&mut self, q: &[f64], time: f64) -> [f64; 6] {
        let s = &self.script;
        let here = time >= s.from - NOW && s.to.is_none_or(|to| time < to - NOW);
        match &s.force {
            _ if !here => {
                self.last = None;
                [0.0; 6]
            }
            Force::Constant(wrench) => *wrench,
            Force::Towards { link, point, stiffness, damping, most } => {
                self.model.forward(q, &mut self.data);
                let x = self.data.pose(*link).translation.vector;
                let speed = match self.last.replace((time, x)) {
                    Some((before, at)) if time > before => (x - at) / (time - before),
                    _ => Vector3::zeros(),
                };
                let f = pull(&(Vector3::from(*point) - x), &speed, *stiffness, *damping, *most);
                [f.x, f.y, f.z, 0.0, 0.0, 0.0]
            }
        }
    }
}

/// Sends each sensor's reading of the sum of its wrenches; only the bias remains while nobody touches it.
pub(super) fn tick(pushes: &mut [Push], signals: &mut Signals, q: &[f64], time: f64) {
    for i in 0..pushes.len() {
        let signal = pushes[i].signal();
        if pushes[..i].iter().any(|p| p.signal() == signal) {
            continue;
        }
        let mut sum = [0.0; 6];
        for push in pushes[i..].iter_mut().filter(|p| p.signal() == signal) {
            let wrench = push.wrench(q, time);
            sum.iter_mut().zip(wrench).for_each(|(s, w)| *s += w);
        }
        let shown = pushes[i].shown(sum, q);
        signals.set(signal, &shown, time);
    }
}

/// Force of a spring with a damper, no larger than `most`.
fn pull(way: &Vector3<f64>, speed: &Vector3<f64>, stiffness: f64, damping: f64, most: f64) -> Vector3<f64> {
    let force = way * stiffness - speed * damping;
    let size = force.norm();
    if size > most { force * (most / size) } else { force }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-3.0..3.0_f64).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn a_hand_is_never_stronger_than_it_is(way in vector(), speed in vector(), most in 0.0..100.0_f64) {
            let f = pull(&way, &speed, 200.0, 20.0, most);
            prop_assert!(f.norm() <= most * (1.0 + 1e-12));
            // The direction is that of the spring and the damper.
            let free = pull(&way, &speed, 200.0, 20.0, f64::INFINITY);
            prop_assert!(f.cross(&free).norm() <= 1e-9 * (1.0 + free.norm_squared()));
            prop_assert!(f.dot(&free) >= 0.0);
        }
    }
}
