//! Obstacles: bodies in the room, or fixed to a link, whose pose may move with time.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use robot::{Closest, Degenerate, LinkId, Model, Shape, Soup, geometry};
use serde::{Deserialize, Serialize};

use crate::slot::Slot;
use crate::so3;
use crate::state::State;

/// An obstacle, its numbers in the table of values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Obstacle {
    /// Name in the spec.
    pub name: String,
    /// Its form.
    pub form: Form,
    /// Link that carries it; `None` for the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<LinkId>,
    /// Position of its frame in the frame of the link, or in the world, in m: 3 numbers.
    pub position: Slot,
    /// Orientation of its frame, as a unit quaternion `w x y z`: 4 numbers.
    pub orientation: Slot,
    /// A number that is not negative while the obstacle is there; `None` for always.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub present: Option<Slot>,
}

/// Form of an obstacle, in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// A convex shape, placed in the obstacle's frame.
    Shape(Isometry3<f64>, Shape),
    /// Everything below z = 0 of a frame that is turned so against the obstacle's.
    HalfSpace(UnitQuaternion<f64>),
    /// Many convex elements: the points of a cloud, the triangles or the pieces of a mesh.
    Soup(Soup),
}

/// Obstacle at a tick.
#[derive(Clone, Copy, Debug)]
pub struct PlacedObstacle {
    /// Pose of its frame in the world.
    pub pose: Isometry3<f64>,
    /// Velocity of the frame's origin in m/s, along the world's axes; without the motion of a link that carries it.
    pub velocity: Vector3<f64>,
    /// Angular velocity in rad/s, along the world's axes; without that of the link.
    pub angular_velocity: Vector3<f64>,
}

impl PlacedObstacle {
    /// The obstacle after so many seconds at its present velocity.
    pub fn after(&self, time: f64) -> PlacedObstacle {
        let turn = UnitQuaternion::from_scaled_axis(self.angular_velocity * time);
        let translation = Translation3::from(self.pose.translation.vector + self.velocity * time);
        PlacedObstacle { pose: Isometry3::from_parts(translation, turn * self.pose.rotation), ..*self }
    }
}

/// Reason why an obstacle has no pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFinite;

impl Obstacle {
    /// All its numbers.
    pub fn slots(&self) -> impl Iterator<Item = Slot> {
        [self.position, self.orientation].into_iter().chain(self.present)
    }

    /// Checks sizes and the link. The table of values is checked by its owner.
    ///
    /// # Errors
    /// Description of the first error.
    pub fn check(&self, model: &Model) -> Result<(), &'static str> {
        let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
        ensure(self.link.is_none_or(|l| l.index() < model.links.len()), "a frame does not exist")?;
        let lengths = [self.position.len, self.orientation.len, self.present.map_or(1, |s| s.len)];
        ensure(lengths == [3, 4, 1], "an obstacle has a pose of another form")?;
        match &self.form {
            Form::HalfSpace(turn) => {
                ensure((turn.norm() - 1.0).abs() < 1e-6, "the placement of an obstacle is not finite")
            }
            Form::Shape(origin, shape) => {
                let placed = origin.translation.vector.iter().all(|x| x.is_finite())
                    && (origin.rotation.norm() - 1.0).abs() < 1e-6;
                ensure(placed, "the placement of an obstacle is not finite")?;
                ensure(shape.is_sound(), "an obstacle has a negative or infinite size")
            }
            // Elements are finite.
            Form::Soup(_) => Ok(()),
        }
    }

    /// Radius of the ball about its frame in which it is, in m; infinite for a half-space.
    pub fn radius(&self) -> f64 {
        match &self.form {
            Form::Shape(origin, shape) => origin.translation.vector.norm() + shape.bounding_radius(),
            Form::HalfSpace(_) => f64::INFINITY,
            Form::Soup(soup) => soup.bounding_radius(),
        }
    }

    /// True while the obstacle is there. One whose presence is not a number is.
    pub fn is_present(&self, values: &[f64]) -> bool {
        self.present.and_then(|s| values.get(s.at)).is_none_or(|x| x.is_nan() || *x >= 0.0)
    }

    /// Pose and velocity at a tick. Allocates nothing.
    ///
    /// # Errors
    /// A number of the pose is not finite, or its quaternion is zero.
    pub fn place(&self, state: &State) -> Result<PlacedObstacle, NotFinite> {
        let vector = |table: &[f64]| match table.get(self.position.at..) {
            Some(&[x, y, z, ..]) => Vector3::new(x, y, z),
            _ => Vector3::repeat(f64::NAN),
        };
        let quaternion = |table: &[f64]| match table.get(self.orientation.at..) {
            Some(&[w, x, y, z, ..]) => [w, x, y, z],
            _ => [f64::NAN; 4],
        };
        let (position, velocity) = (vector(state.values), vector(state.rates));
        let (rotation, angular_velocity) = so3::target(quaternion(state.values), quaternion(state.rates));
        let all = position.iter().chain(&velocity).chain(&angular_velocity).chain(rotation.as_vector());
        if !all.copied().all(f64::is_finite) {
            return Err(NotFinite);
        }
        let own = Isometry3::from_parts(Translation3::from(position), rotation);
        Ok(match self.link {
            None => PlacedObstacle { pose: own, velocity, angular_velocity },
            Some(link) => {
                let carrier = state.data.pose(link);
                PlacedObstacle {
                    pose: carrier * own,
                    velocity: carrier.rotation * velocity,
                    angular_velocity: carrier.rotation * angular_velocity,
                }
            }
        })
    }

    /// Closest points of a shape at a pose in the world and the obstacle, the shape being `a`.
    ///
    /// # Errors
    /// The shape overlaps the obstacle so deeply that no direction leads out.
    pub fn closest(&self, shape: &Shape, pose: &Isometry3<f64>, at: &PlacedObstacle) -> Result<Closest, Degenerate> {
        match &self.form {
            Form::Shape(origin, own) => geometry::closest(shape, pose, own, &(at.pose * origin)),
            Form::HalfSpace(turn) => {
                let normal = at.pose.rotation * (turn * Vector3::z());
                Ok(geometry::closest_plane(shape, pose, &normal, normal.dot(&at.pose.translation.vector)))
            }
            Form::Soup(soup) => match soup.nearest(shape, pose, &at.pose) {
                Ok(spot) => Ok(spot.closest),
                Err(_) => Err(Degenerate::Touching),
            },
        }
    }
}
