//! The configuration of the robot from messages: positions of joints by their names, in any order and from several topics, and
//! the pose of a base from odometry.

use std::collections::BTreeSet;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use robot::{Base, Model};

use crate::messages::{JointState, Odometry};

/// Publishers of a topic that are known at once.
const PUBLISHERS: usize = 16;

/// A configuration under observation.
pub struct Configuration {
    /// Names of the numbers after those of the base.
    names: Vec<String>,
    base: Base,
    /// The last readings; NaN before the first one.
    last: Vec<f64>,
    /// Time of each reading (s); minus infinity before the first one.
    received: Vec<f64>,
    /// Publisher of each reading.
    sources: Vec<Source>,
    /// Time for which a reading is valid (s).
    stale_after: f64,
    /// The configuration of a tick.
    q: Vec<f64>,
    /// Names that messages had and the robot has not.
    strangers: BTreeSet<String>,
}

/// Identity of a publisher.
pub type Source = [u8; 16];

/// Mistake in a message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Mistake {
    /// A message names other joints than it has positions of: nothing is taken.
    #[error("it has {names} names and {positions} positions")]
    Lengths {
        /// Number of names.
        names: usize,
        /// Number of positions.
        positions: usize,
    },
    /// The pose of a base is in another frame than the world: it is not taken.
    #[error("it is in the frame `{frame}`")]
    OtherFrame {
        /// The frame.
        frame: String,
    },
    /// Another publisher sends positions of a joint already: those of its joints are not taken.
    #[error("another publisher sends the position of `{joint}`")]
    TwoSources {
        /// The first one of these joints.
        joint: String,
    },
}

/// Publishers of a topic, whose places in a configuration are found once: they keep the order of their joints.
#[derive(Default)]
pub struct Publishers(Vec<Publisher>);

struct Publisher {
    source: Source,
    names: Vec<String>,
    places: Vec<Option<usize>>,
}

impl Publishers {
    /// Places of the joints of a message. `find` looks for one.
    fn places(
        &mut self,
        source: Source,
        names: &[String],
        find: impl Fn(&String) -> Option<usize>,
    ) -> &[Option<usize>] {
        let known = self.0.iter().position(|p| p.source == source);
        let i = known.unwrap_or_else(|| {
            // A publisher that begins again is another one.
            self.0.truncate(PUBLISHERS - 1);
            self.0.insert(0, Publisher { source, names: Vec::new(), places: Vec::new() });
            0
        });
        let publisher = &mut self.0[i];
        if publisher.names != names {
            publisher.names = names.to_vec();
            publisher.places = names.iter().map(find).collect();
        }
        &publisher.places
    }
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
            sources: vec![Source::default(); model.nq()],
            stale_after,
            q: vec![f64::NAN; model.nq()],
            strangers: BTreeSet::new(),
        }
    }

    /// Takes a message that was received at a time (s). `prefix` is the beginning of names that the message leaves out.
    ///
    /// A first position of a joint is finite: drivers send what is no number before they know one. A joint is read from one publisher
    /// as long as that sends it.
    ///
    /// # Errors
    /// The message contradicts itself or the one of another publisher.
    pub fn joints(
        &mut self,
        message: &JointState,
        prefix: &str,
        publishers: &mut Publishers,
        from: Source,
        time: f64,
    ) -> Result<(), Mistake> {
        let (names, positions) = (message.name.len(), message.position.len());
        if names != positions {
            return Err(Mistake::Lengths { names, positions });
        }
        let (base, strangers) = (self.base.nq(), &mut self.strangers);
        let find = |name: &String| {
            let is = |own: &String| own.strip_prefix(prefix) == Some(name);
            self.names.iter().position(is).map(|i| base + i)
        };
        let places = publishers.places(from, &message.name, find);
        let mut refused = None;
        for ((place, position), name) in places.iter().zip(&message.position).zip(&message.name) {
            let Some(place) = *place else {
                if !strangers.contains(name) {
                    strangers.insert(name.clone());
                }
                continue;
            };
            let is_known = self.received[place] > f64::NEG_INFINITY;
            let is_fresh = time - self.received[place] <= self.stale_after;
            if is_known && is_fresh && self.sources[place] != from {
                refused = refused.or(Some(name));
            } else if is_known || position.is_finite() {
                (self.last[place], self.received[place], self.sources[place]) = (*position, time, from);
            }
        }
        refused.map_or(Ok(()), |joint| Err(Mistake::TwoSources { joint: joint.clone() }))
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
        let [x, y, z] = message.pose.position.numbers();
        let [w, i, j, k] = message.pose.orientation.numbers();
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
        let ahead = turn * Vector3::x();
        let pose = match self.base {
            Base::Fixed => return Ok(()),
            // The Euler angles of what is no rotation are finite.
            Base::Planar | Base::Unicycle => [x, y, ahead.y.atan2(ahead.x), 0.0, 0.0, 0.0, 0.0],
            Base::Floating => [x, y, z, turn.w, turn.i, turn.j, turn.k],
        };
        let n = self.base.nq();
        let is_known = self.received[..n].iter().all(|t| *t > f64::NEG_INFINITY);
        if is_known || pose.iter().all(|x| x.is_finite()) {
            self.last[..n].copy_from_slice(&pose[..n]);
            self.received[..n].fill(time);
        }
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
