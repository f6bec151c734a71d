//! What rows of curved distances keep in reserve against sampling in time.
//!
//! `δ = A T / (2 φ)`, with the acceleration bound A of [`crate::clearance`], goes into a row as `φ δ = A T / 2`: a rate that
//! does not depend on φ, so that a reserve worked out by `auto` follows a gain that moves.

use robot::Shape;

use crate::bound::Geometry;
use crate::clearance;
use crate::params::{Auto, Input};
use crate::task::{BuildError, Context};

/// The greatest distance of the points of a shape that can be nearest to something from the origin of its link, in m. A
/// ball's distance is that of its centre less a constant, so that the centre counts.
pub fn extent(g: &Geometry) -> f64 {
    let around = if is_ball(&g.shape) { 0.0 } else { g.shape.bounding_radius() };
    g.origin.translation.vector.norm() + around
}

/// True for a point and a sphere.
pub fn is_ball(shape: &Shape) -> bool {
    matches!(shape, Shape::Sphere { .. }) || matches!(shape, Shape::Capsule { half_length, .. } if *half_length == 0.0)
}

/// What curved rows can lose to sampling in time, and what they hold in reserve against it.
pub struct Reserve {
    auto: bool,
    /// A T / 2 of each row, in m/s.
    bend: Vec<f64>,
    /// A T / (2 φ) of each row at the gain that a stack starts with, in m.
    pub loss: Vec<f64>,
    /// δ of each row at that gain, in m.
    pub kept: Vec<f64>,
}

impl Reserve {
    /// From the name and the acceleration bound of each row.
    pub fn new(auto: Auto, gain: Input<1>, rows: Vec<(&str, f64)>, ctx: &Context) -> Result<Self, BuildError> {
        let [gain] = gain.of(ctx.values);
        let loss: Vec<f64> = rows.iter().map(|&(_, a)| clearance::loss(a, ctx.period, gain)).collect();
        let bend = rows.iter().map(|&(_, a)| 0.5 * a * ctx.period).collect();
        let kept = match auto {
            Auto::Given(x) => vec![x.of(ctx.values)[0]; loss.len()],
            Auto::Auto => match rows.iter().find(|(_, a)| !a.is_finite()) {
                None => loss.clone(),
                Some((name, _)) => {
                    let text = format!(
                        "`auto` needs a speed limit for every joint that moves `{name}`, and a stroke for those that slide"
                    );
                    return Err(BuildError::new("sampled_margin", text)
                        .help("give the limits in the robot, or add `joint_velocity_limits` with `max` to the stack"));
                }
            },
        };
        Ok(Reserve { auto: auto == Auto::Auto, bend, loss, kept })
    }

    /// `φ δ` of a row, in m/s: `auto` follows a gain that moves.
    pub fn rate(&self, row: usize, gain: f64) -> f64 {
        if self.auto { self.bend[row] } else { gain * self.kept[row] }
    }
}
