//! The configuration of the robot from messages: positions of joints by their names, in any order and from several topics, and
//! the pose of a base from odometry.

use std::collections::BTreeSet;

use nalgebra::{Quaternion, UnitQuaternion};
use robot::{Base, Model};

use crate::messages::{JointState, Odometry};

/// A configuration under observation.
pub struct Configuration {
    /// Names of the numbers after those of the base.
    names: Vec<String>,
    base: Base,
    /// The last readings; NaN before the first one.
    last: Vec<f64>,
    /// Time of each reading (s); minus infinity before the first one.
    received: Vec<f64>,
    /// Time for which a reading is valid (s).
    stale_after: f64,
    /// The configuration of a tick.
    q: Vec<f64>,
    /// Names that messages had and the robot has not.
    strangers: BTreeSet<String>,
}

/// Mistake in a message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Mistake {
    /// A message names other joints than it has positions of.
    #[error("it has {names} names and {positions} positions")]
    Lengths {
        /// Number of names.
        names: usize,
        /// Number of positions.
        positions: usize,
    },
    /// The pose of a base is in another frame than the world.
    #[error("it is in the frame `{frame}`")]
    OtherFrame {
        /// The frame.
        frame: String,
    },
}

/// Places of the joints of a topic in a configuration. Publishers keep the order of their joints, so that it is found once.
#[derive(Default)]
pub struct Order {
    names: Vec<String>,
    places: Vec<Option<usize>>,
}

impl Configuration {
    /// A configuration of which nothing is known.
    pub fn new(model: &Model, stale_after: f64) -> Configuration {
        let joints = model.dofs.iter().filter(|d| d.q_index.is_some()).map(|d| d.name.clone());
        Configuration {
            names: joints.collect(),
            base: model.base,
            last: vec![f64::NAN; model.nq()],
            received: vec![f64::NEG_INFINITY; model.nq()],
            stale_after,
            q: vec![f64::NAN; model.nq()],
            strangers: BTreeSet::new(),
        }
    }

    /// Takes a message that was received at a time (s). `prefix` is the beginning of names that the message leaves out.
    ///
    /// # Errors
    /// The message contradicts itself: nothing is taken.
    pub fn joints(&mut self, message: &JointState, prefix: &str, order: &mut Order, time: f64) -> Result<(), Mistake> {
        let (names, positions) = (message.name.len(), message.position.len());
        if names != positions {
            return Err(Mistake::Lengths { names, positions });
        }
        if order.names != message.name {
            order.names.clone_from(&message.name);
            let place = |name: &String| {
                let is = |own: &String| own.strip_prefix(prefix) == Some(name);
                self.names.iter().position(is).map(|i| self.base.nq() + i)
            };
            order.places = message.name.iter().map(place).collect();
            let strangers = message.name.iter().zip(&order.places).filter(|(_, place)| place.is_none());
            self.strangers.extend(strangers.map(|(name, _)| name.clone()));
        }
        for (place, position) in order.places.iter().zip(&message.position) {
            if let Some(place) = *place {
                self.last[place] = *position;
                self.received[place] = time;
            }
        }
        Ok(())
    }

    /// Takes the pose of the base in the frame `world` that was received at a time (s). A message without a frame is taken too.
    ///
    /// # Errors
    /// It is in another frame: nothing is taken.
    pub fn odometry(&mut self, message: &Odometry, world: &str, time: f64) -> Result<(), Mistake> {
        let frame = message.header.frame_id.trim_start_matches('/');
        if !frame.is_empty() && frame != world {
            return Err(Mistake::OtherFrame { frame: frame.to_string() });
        }
        let p = message.pose.position.numbers();
        let [w, x, y, z] = message.pose.orientation.numbers();
        let n = self.base.nq();
        match self.base {
            Base::Fixed => {}
            Base::Planar | Base::Unicycle => {
                let (_, _, yaw) = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).euler_angles();
                self.last[..3].copy_from_slice(&[p[0], p[1], yaw]);
            }
            Base::Floating => self.last[..7].copy_from_slice(&[p[0], p[1], p[2], w, x, y, z]),
        }
        self.received[..n].fill(time);
        Ok(())
    }

    /// Names of what has not been heard of yet.
    pub fn unknown(&self) -> Vec<String> {
        let never = |i: &usize| self.received[*i] == f64::NEG_INFINITY;
        let base = (self.base.nq() > 0 && never(&0)).then(|| "the base".to_string());
        let joints = self.names.iter().enumerate().filter(|(i, _)| never(&(self.base.nq() + i)));
        base.into_iter().chain(joints.map(|(_, name)| name.clone())).collect()
    }

    /// True if there is a reading of everything.
    pub fn is_known(&self) -> bool {
        self.received.iter().all(|time| *time > f64::NEG_INFINITY)
    }

    /// Names that messages had and the robot has not.
    pub fn strangers(&self) -> Vec<String> {
        self.strangers.iter().cloned().collect()
    }

    /// The last readings, however old.
    pub fn last(&self) -> &[f64] {
        &self.last
    }

    /// The configuration at a time (s). A reading that is too old is not a number, which is the fault `not_finite`.
    pub fn at(&mut self, time: f64) -> &[f64] {
        for ((q, last), received) in self.q.iter_mut().zip(&self.last).zip(&self.received) {
            *q = if time - received <= self.stale_after { *last } else { f64::NAN };
        }
        &self.q
    }
}
