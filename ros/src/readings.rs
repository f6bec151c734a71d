//! Values of signals in messages.

use nalgebra::{Isometry3, Quaternion as Hamilton, UnitQuaternion, Vector3 as Vector};
use runtime::program::SignalProgram;
use serde::de::DeserializeOwned;

use crate::messages::{
    Bool, Float32, Float64, Imu, Odometry, Pose, PoseStamped, Quaternion, QuaternionStamped, Vector3, Vector3Stamped,
    Wrench, WrenchStamped,
};

/// Value that a signal needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// One number, or a flag.
    Number,
    /// Three numbers.
    Vector,
    /// A position.
    Point,
    /// A position and its velocity.
    MovingPoint,
    /// An orientation.
    Orientation,
    /// A position and an orientation.
    Pose,
    /// A pose, its velocity and its angular velocity.
    MovingPose,
    /// A force and a moment.
    Wrench,
}

impl Wanted {
    /// True if the value has a velocity, which depends on that of its frame.
    pub fn has_velocity(self) -> bool {
        matches!(self, Wanted::MovingPoint | Wanted::MovingPose)
    }

    /// The value of a signal.
    pub fn by(signal: &SignalProgram) -> Wanted {
        match (signal.kind.as_str(), signal.sent()) {
            ("wrench", _) => Wanted::Wrench,
            ("orientation", _) => Wanted::Orientation,
            ("pose", 7) => Wanted::Pose,
            ("pose", _) => Wanted::MovingPose,
            ("point", 3) => Wanted::Point,
            ("point", _) => Wanted::MovingPoint,
            (_, 3) => Wanted::Vector,
            _ => Wanted::Number,
        }
    }
}

/// Numbers of a value, as a controller receives them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Numbers {
    all: [f64; 13],
    len: usize,
}

impl Numbers {
    /// The numbers.
    pub fn as_slice(&self) -> &[f64] {
        &self.all[..self.len]
    }

    fn and(mut self, more: &[f64]) -> Numbers {
        for x in more {
            if let Some(place) = self.all.get_mut(self.len) {
                *place = *x;
                self.len += 1;
            }
        }
        self
    }

    fn of(numbers: &[f64]) -> Numbers {
        Numbers::default().and(numbers)
    }

    /// The value in another frame, in which the present one has this pose; none if it has no meaning there. The moment of a wrench is about
    /// the origin of its frame.
    pub fn in_frame(&self, wanted: Wanted, pose: &Isometry3<f64>) -> Option<Numbers> {
        let turn = &pose.rotation;
        let vector = |at: usize| self.all.get(at..at + 3).map(Vector::from_column_slice).unwrap_or_default();
        let turned = |at: usize| -> [f64; 3] { (turn * vector(at)).into() };
        let placed = || -> [f64; 3] { (turn * vector(0) + pose.translation.vector).into() };
        // A quaternion that is none stays so.
        let oriented = |at: usize| {
            let [w, x, y, z] = [0, 1, 2, 3].map(|i| self.all[at + i]);
            let q = turn.quaternion() * Hamilton::new(w, x, y, z);
            [q.w, q.i, q.j, q.k]
        };
        Some(match wanted {
            Wanted::Number => return None,
            Wanted::Vector => Numbers::of(&turned(0)),
            Wanted::Point => Numbers::of(&placed()),
            Wanted::MovingPoint => Numbers::of(&placed()).and(&turned(3)),
            Wanted::Orientation => Numbers::of(&oriented(0)),
            Wanted::Pose => Numbers::of(&placed()).and(&oriented(3)),
            Wanted::MovingPose => Numbers::of(&placed()).and(&oriented(3)).and(&turned(7)).and(&turned(10)),
            Wanted::Wrench => {
                let force = turn * vector(0);
                let moment = turn * vector(3) + pose.translation.vector.cross(&force);
                Numbers::of(force.as_slice()).and(moment.as_slice())
            }
        })
    }
}

/// A message from which signals are read.
pub trait Reading: DeserializeOwned + 'static {
    /// Frame of its content; empty if it has none.
    fn frame(&self) -> &str {
        ""
    }

    /// The numbers of a value; none if the message does not contain it.
    fn numbers(&self, wanted: Wanted) -> Option<Numbers>;
}

impl Reading for Bool {
    fn numbers(&self, _: Wanted) -> Option<Numbers> {
        Some(Numbers::of(&[if self.data { 1.0 } else { -1.0 }]))
    }
}

impl Reading for Float64 {
    fn numbers(&self, _: Wanted) -> Option<Numbers> {
        Some(Numbers::of(&[self.data]))
    }
}

impl Reading for Float32 {
    fn numbers(&self, _: Wanted) -> Option<Numbers> {
        Some(Numbers::of(&[f64::from(self.data)]))
    }
}

impl Reading for Vector3 {
    fn numbers(&self, wanted: Wanted) -> Option<Numbers> {
        matches!(wanted, Wanted::Vector | Wanted::Point).then(|| Numbers::of(&self.numbers()))
    }
}

impl Reading for Quaternion {
    fn numbers(&self, wanted: Wanted) -> Option<Numbers> {
        (wanted == Wanted::Orientation).then(|| Numbers::of(&self.numbers()))
    }
}

impl Reading for Pose {
    fn numbers(&self, wanted: Wanted) -> Option<Numbers> {
        let (p, q) = (self.position.numbers(), self.orientation.numbers());
        match wanted {
            Wanted::Point => Some(Numbers::of(&p)),
            Wanted::Orientation => Some(Numbers::of(&q)),
            Wanted::Pose => Some(Numbers::of(&p).and(&q)),
            _ => None,
        }
    }
}

impl Reading for Wrench {
    fn numbers(&self, wanted: Wanted) -> Option<Numbers> {
        let both = || Numbers::of(&self.force.numbers()).and(&self.torque.numbers());
        (wanted == Wanted::Wrench).then(both)
    }
}

/// Messages with a header around one of the messages above.
macro_rules! stamped {
    ($($message:ident: $content:ident),*) => {
        $(
            impl Reading for $message {
                fn frame(&self) -> &str {
                    &self.header.frame_id
                }

                fn numbers(&self, wanted: Wanted) -> Option<Numbers> {
                    Reading::numbers(&self.$content, wanted)
                }
            }
        )*
    };
}

stamped!(
    Vector3Stamped: vector,
    QuaternionStamped: quaternion,
    PoseStamped: pose,
    WrenchStamped: wrench,
    Imu: orientation
);

impl Reading for Odometry {
    fn frame(&self) -> &str {
        &self.header.frame_id
    }

    fn numbers(&self, wanted: Wanted) -> Option<Numbers> {
        // Velocities are along the axes of the child frame, and a controller needs those of the world.
        let [w, x, y, z] = self.pose.orientation.numbers();
        let turn = UnitQuaternion::new_normalize(Hamilton::new(w, x, y, z));
        let in_world = |v: &Vector3| -> [f64; 3] { (turn * Vector::from(v.numbers())).into() };
        match wanted {
            Wanted::MovingPoint => Some(Numbers::of(&self.pose.position.numbers()).and(&in_world(&self.twist.linear))),
            Wanted::MovingPose => {
                let pose = Reading::numbers(&self.pose, Wanted::Pose)?;
                Some(pose.and(&in_world(&self.twist.linear)).and(&in_world(&self.twist.angular)))
            }
            other => Reading::numbers(&self.pose, other),
        }
    }
}
