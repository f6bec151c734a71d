//! The configuration of the robot from messages: positions of joints by their names, in any order and from several topics, and
//! the poses of bases from odometry.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use robot::{Base, MobileBase, Model};

use crate::messages::{JointState, Odometry};

/// Distance in m or rad between two poses of a base from which it has jumped. The controller takes less for noise.
const JUMP: f64 = 0.05;

/// Publishers of a topic that are known at once.
const PUBLISHERS: usize = 16;

/// A configuration under observation.
pub struct Configuration {
    joints: Vec<JointPlace>,
    bases: Vec<PlacedBase>,
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

/// A joint, and the place of its position in a configuration.
struct JointPlace {
    name: String,
    place: usize,
}

/// A base, and the place in the world where it stands if its coordinates are zero.
struct PlacedBase {
    base: MobileBase,
    at: Isometry3<f64>,
    /// Words for it.
    words: String,
}

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
        let joints = model.dofs.iter().filter_map(|d| Some(JointPlace { name: d.name.clone(), place: d.q_index? }));
        let placed = |base: &MobileBase| {
            let words = match model.bases.len() {
                1 => "the base".to_string(),
                _ => format!("the base `{}`", base.link_name(model)),
            };
            PlacedBase { base: *base, at: model.place(base), words }
        };
        Configuration {
            joints: joints.collect(),
            bases: model.bases.iter().map(placed).collect(),
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
        let (joints, strangers) = (&self.joints, &mut self.strangers);
        let find =
            |name: &String| joints.iter().find(|own| own.name.strip_prefix(prefix) == Some(name)).map(|own| own.place);
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

    /// Takes the pose of the base with this index in the frame `world` that was received at a time (s). A message without a
    /// frame is taken too. Returns true if the base is farther than [`JUMP`] from its last pose.
    ///
    /// # Errors
    /// It is in another frame: nothing is taken.
    pub fn odometry(&mut self, base: usize, message: &Odometry, world: &str, time: f64) -> Result<bool, Mistake> {
        let frame = message.header.frame_id.trim_start_matches('/');
        if !frame.is_empty() && frame != world {
            return Err(Mistake::OtherFrame { frame: frame.to_string() });
        }
        let Some(PlacedBase { base, at, .. }) = self.bases.get(base) else { return Ok(false) };
        let [w, x, y, z] = message.pose.orientation.numbers();
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let pose = at.inv_mul(&Isometry3::from_parts(message.pose.position.numbers().into(), turn));
        let (p, r) = (pose.translation, pose.rotation);
        let ahead = r * Vector3::x();
        let read = match base.kind {
            Base::Fixed => return Ok(false),
            // The Euler angles of what is no rotation are finite.
            Base::Planar | Base::Unicycle => [p.x, p.y, ahead.y.atan2(ahead.x), 0.0, 0.0, 0.0, 0.0],
            Base::Floating => [p.x, p.y, p.z, r.w, r.i, r.j, r.k],
        };
        let own = base.coordinates();
        let is_known = self.received[own.clone()].iter().all(|t| *t > f64::NEG_INFINITY);
        let mut jumps = false;
        if is_known || read.iter().all(|x| x.is_finite()) {
            let last = &mut self.last[own.clone()];
            jumps = is_known && last.iter().zip(&read).any(|(before, now)| (now - before).abs() > JUMP);
            last.copy_from_slice(&read[..last.len()]);
            self.received[own].fill(time);
        }
        Ok(jumps)
    }

    /// Names of what has not been heard of yet.
    pub fn unknown(&self) -> Vec<String> {
        let never = |i: &usize| self.received[*i] == f64::NEG_INFINITY;
        let bases = self.bases.iter().filter(|of| never(&of.base.first_coordinate)).map(|of| of.words.clone());
        let joints = self.joints.iter().filter(|of| never(&of.place)).map(|of| of.name.clone());
        bases.chain(joints).collect()
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
