//! Forces of people on a sensor: a wrench that is the same all the time, or a hand that pulls.

use nalgebra::Vector3;
use robot::{Data, Model};

use super::NOW;
use crate::program::{Force, Program, PushScript};
use crate::signals::Signals;

/// A person at work.
pub(super) struct Push {
    script: PushScript,
    model: Model,
    data: Data,
    /// When and where the link was seen last.
    last: Option<(f64, Vector3<f64>)>,
}

impl Push {
    pub fn new(script: &PushScript, program: &Program) -> Push {
        let model = program.robot.model.clone();
        Push { script: script.clone(), data: Data::new(&model), model, last: None }
    }

    pub fn tick(&mut self, signals: &mut Signals, q: &[f64], time: f64) {
        let s = &self.script;
        let here = time >= s.from - NOW && s.to.is_none_or(|to| time < to - NOW);
        let wrench = match &s.force {
            // Nobody touches the sensor, and it says so.
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
        };
        signals.set(s.signal, &wrench, time);
    }
}

/// The force of a spring with a damper, no larger than `most`.
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
