//! Commands as messages.

use robot::{Base, Model};
use runtime::program::{CommandForm, CommandTopic};

use crate::messages::{Duration, Float64MultiArray, Header, JointTrajectory, JointTrajectoryPoint, Twist, Vector3};

/// Makes the messages of one topic.
#[derive(Clone, Debug)]
pub struct Commander {
    /// Content of the messages.
    pub form: CommandForm,
    dofs: Vec<usize>,
    /// Places in a configuration.
    places: Vec<usize>,
    /// Names in messages.
    names: Vec<String>,
    base: Base,
}

/// Motion that is commanded until the next tick.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Velocity, `nv` numbers.
    pub velocity: &'a [f64],
    /// Configuration to be reached at the next tick, `nq` numbers.
    pub position: &'a [f64],
    /// Time until the next tick (s).
    pub lasts: f64,
}

impl Commander {
    /// Prepares the messages of a topic.
    pub fn new(topic: &CommandTopic, model: &Model) -> Commander {
        let of = |dof: &usize| model.dofs.get(*dof);
        let short = |name: &str| name.strip_prefix(&topic.prefix).unwrap_or(name).to_string();
        Commander {
            form: topic.form,
            dofs: topic.dofs.clone(),
            places: topic.dofs.iter().filter_map(of).filter_map(|d| d.q_index).collect(),
            names: topic.dofs.iter().filter_map(of).map(|d| short(&d.name)).collect(),
            base: topic.dofs.first().and_then(|dof| model.base_of_dof(*dof)).map_or(Base::Fixed, |base| base.kind),
        }
    }

    /// Velocities or positions in a row.
    pub fn numbers(&self, motion: Motion) -> Float64MultiArray {
        let (places, of) = match self.form {
            CommandForm::Position => (&self.places, motion.position),
            _ => (&self.dofs, motion.velocity),
        };
        let data = places.iter().map(|i| of.get(*i).copied().unwrap_or(0.0)).collect();
        Float64MultiArray { data, ..Float64MultiArray::default() }
    }

    /// A trajectory with one point, due at the next tick.
    pub fn trajectory(&self, motion: Motion) -> JointTrajectory {
        let all = |places: &[usize], of: &[f64]| places.iter().map(|i| of.get(*i).copied().unwrap_or(0.0)).collect();
        let nanoseconds = (motion.lasts * 1e9).round() as u64;
        let point = JointTrajectoryPoint {
            positions: all(&self.places, motion.position),
            velocities: all(&self.dofs, motion.velocity),
            time_from_start: Duration {
                sec: (nanoseconds / 1_000_000_000) as i32,
                nanosec: (nanoseconds % 1_000_000_000) as u32,
            },
            ..JointTrajectoryPoint::default()
        };
        JointTrajectory { header: Header::default(), joint_names: self.names.clone(), points: vec![point] }
    }

    /// Velocity of a base in its own frame.
    pub fn twist(&self, motion: Motion) -> Twist {
        let v = |i: usize| self.dofs.get(i).and_then(|dof| motion.velocity.get(*dof)).copied().unwrap_or(0.0);
        let vector = |x: f64, y: f64, z: f64| Vector3 { x, y, z };
        match self.base {
            Base::Fixed => Twist::default(),
            Base::Planar => Twist { linear: vector(v(0), v(1), 0.0), angular: vector(0.0, 0.0, v(2)) },
            Base::Unicycle => Twist { linear: vector(v(0), 0.0, 0.0), angular: vector(0.0, 0.0, v(1)) },
            Base::Floating => Twist { linear: vector(v(0), v(1), v(2)), angular: vector(v(3), v(4), v(5)) },
        }
    }
}
