//! Poses of frames relative to each other: fixed transforms that others publish on `/tf_static`, and the links of the robot, whose poses are
//! those of its own kinematics at the observed configuration.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use robot::{Data, Model};

use crate::messages::{Transform, TransformStamped};

/// Longest way from a frame to the one that all are in: a longer one is a circle.
const DEPTH: usize = 64;
/// Most frames that are kept.
const FRAMES: usize = 4096;

/// A frame and its pose in another one.
struct Placed {
    parent: String,
    pose: Isometry3<f64>,
}

/// Frames that are known.
pub struct Frames {
    world: String,
    placed: BTreeMap<String, Placed>,
    model: Model,
    data: Data,
    /// True if the kinematics are those of the last observation.
    is_fresh: bool,
}

/// A transform that leads from one frame to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Pose of the one frame in the other.
    pub pose: Isometry3<f64>,
    /// True if it moves with the robot.
    pub moves: bool,
}

/// A frame on the way to the world.
struct Step<'f> {
    frame: &'f str,
    /// Pose of the frame at the beginning of the way in this one.
    pose: Isometry3<f64>,
    moves: bool,
}

impl Frames {
    /// The frames of a robot in a world.
    pub fn new(model: &Model, world: &str) -> Frames {
        let world = bare(world).to_string();
        Frames { world, placed: BTreeMap::new(), data: Data::new(model), model: model.clone(), is_fresh: false }
    }

    /// Takes a fixed transform. One that is no rotation, or whose frames are the same, is left out.
    pub fn place(&mut self, transform: &TransformStamped) {
        let (parent, frame) = (bare(&transform.header.frame_id), bare(&transform.child_frame_id));
        let Transform { translation, rotation } = &transform.transform;
        let [w, x, y, z] = rotation.numbers();
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let pose = Isometry3::from_parts(Translation3::from(translation.numbers()), turn);
        let is_finite = pose.translation.vector.iter().chain(turn.coords.iter()).all(|x| x.is_finite());
        if is_finite && parent != frame && (self.placed.len() < FRAMES || self.placed.contains_key(frame)) {
            self.placed.insert(frame.to_string(), Placed { parent: parent.to_string(), pose });
        }
    }

    /// Forgets the poses of links: the robot has moved.
    pub fn moved(&mut self) {
        self.is_fresh = false;
    }

    /// Pose of a frame in another one while the robot is at `q`; none if no transforms lead from one to the other.
    pub fn find(&mut self, frame: &str, needed: &str, q: &[f64]) -> Option<Found> {
        let (frame, needed) = (bare(frame), bare(needed));
        if !self.is_fresh && [frame, needed].iter().any(|f| self.leads_to_robot(f)) {
            if !q.iter().all(|x| x.is_finite()) {
                return None;
            }
            self.model.forward(q, &mut self.data);
            self.is_fresh = true;
        }
        let mut from = Step { frame, pose: Isometry3::identity(), moves: false };
        for _ in 0..DEPTH {
            if let Some(back) = self.climb(needed, from.frame) {
                return Some(Found { pose: back.pose.inverse() * from.pose, moves: back.moves || from.moves });
            }
            from = self.up(from)?;
        }
        None
    }

    /// Goes up from a frame until another one.
    fn climb<'f>(&'f self, frame: &'f str, until: &str) -> Option<Step<'f>> {
        let mut at = Step { frame, pose: Isometry3::identity(), moves: false };
        for _ in 0..DEPTH {
            if at.frame == until {
                return Some(at);
            }
            at = self.up(at)?;
        }
        None
    }

    /// Goes up to the frame that the present one is placed in.
    fn up<'f>(&'f self, at: Step<'f>) -> Option<Step<'f>> {
        // Its own kinematics know the robot best.
        if let Some(link) = self.model.link(at.frame).filter(|_| at.frame != self.world) {
            let moves = at.moves || !self.model.support(link).is_empty();
            return Some(Step { frame: &self.world, pose: self.data.pose(link) * at.pose, moves });
        }
        let placed = self.placed.get(at.frame)?;
        Some(Step { frame: &placed.parent, pose: placed.pose * at.pose, moves: at.moves })
    }

    /// True if a frame is a link, or placed on one.
    fn leads_to_robot(&self, frame: &str) -> bool {
        let mut frame = frame;
        for _ in 0..DEPTH {
            if self.model.link(frame).is_some() {
                return true;
            }
            let Some(placed) = self.placed.get(frame) else { return false };
            frame = &placed.parent;
        }
        false
    }
}

/// A name without the slash of old.
fn bare(frame: &str) -> &str {
    frame.trim_start_matches('/')
}
