//! Reserve of rows of curved distances against sampling in time.
//!
//! `δ = A T / (2 φ)`, with the acceleration bound A of [`crate::clearance`], enters a row as `φ δ = A T / 2`: a rate
//! that does not depend on φ, so that a margin computed by `auto` follows a gain that moves.

use robot::{Model, Shape};

use crate::bound::Geometry;
use crate::clearance;
use crate::params::Auto;
use crate::task::{BuildError, Context};

/// Largest distance from the origin of its link to the points of a shape that can be nearest to something, in m. The
/// distance of a ball is that of its centre minus a constant, so the centre is used.
pub fn extent(g: &Geometry) -> f64 {
    let around = if is_ball(&g.shape) { 0.0 } else { g.shape.bounding_radius() };
    g.origin.translation.vector.norm() + around
}

/// Returns true for a point and a sphere.
pub fn is_ball(shape: &Shape) -> bool {
    matches!(shape, Shape::Sphere { .. }) || matches!(shape, Shape::Capsule { half_length, .. } if *half_length == 0.0)
}

/// Bound on the downward acceleration of the distance of two parts, in m/s². For a ball, it is that of its centre relative
/// to the other part, which is convex. Of two long parts either may be the moving one.
pub fn separation_bound(a: &Geometry, b: &Geometry, model: &Model, speed: &[f64]) -> f64 {
    let seen = |from: &Geometry, to: &Geometry| {
        clearance::acceleration_bound(model, Some(from.link), to.link, extent(to), speed)
    };
    match (is_ball(&a.shape), is_ball(&b.shape)) {
        (true, true) => seen(a, b).min(seen(b, a)),
        (true, false) => seen(b, a),
        (false, true) => seen(a, b),
        (false, false) => seen(a, b).max(seen(b, a)),
    }
}

/// Loss of curved rows by sampling in time, and the margin that is kept against it.
pub struct SampledMargin {
    auto: bool,
    /// True if no reserve is written: on a hard level, the margins after each tick are then looked at.
    pub looks_ahead: bool,
    /// A T / 2 of each row, in m/s.
    half_bounds: Vec<f64>,
    /// The same while locked joints come to rest.
    entry_half_bounds: Vec<f64>,
    /// True while locked joints come to rest.
    locked_joints_moving: bool,
    /// A T / (2 φ) of each row at the initial gain of a stack, in m.
    pub loss: Vec<f64>,
    /// δ of each row at that gain, in m.
    pub kept: Vec<f64>,
}

impl SampledMargin {
    /// Creates the margin from the gain at the time of building, the name of each row, and its acceleration bound at given
    /// speeds, in m/s².
    ///
    /// # Errors
    /// The margin is `auto`, and nothing bounds the curvature of a row.
    pub fn new(
        written: Option<Auto>,
        gain: f64,
        names: &[&str],
        acceleration_bound_of: &dyn Fn(usize, &[f64]) -> f64,
        ctx: &Context,
    ) -> Result<Self, BuildError> {
        let bounds: Vec<f64> = (0..names.len()).map(|i| acceleration_bound_of(i, ctx.speed)).collect();
        let entry_bounds: Vec<f64> = (0..names.len()).map(|i| acceleration_bound_of(i, ctx.entry_speed)).collect();
        let loss: Vec<f64> = bounds.iter().map(|&a| clearance::loss(a, ctx.period, gain)).collect();
        let half = |bounds: &[f64]| bounds.iter().map(|&a| 0.5 * a * ctx.period).collect();
        let kept = match written {
            None => vec![0.0; loss.len()],
            Some(Auto::Given(x)) => vec![x.of(ctx.values)[0]; loss.len()],
            // Locked joints that still move only increase the bound.
            Some(Auto::Auto) => match entry_bounds.iter().position(|a| !a.is_finite()) {
                None => loss.clone(),
                Some(i) => return Err(unbounded(names[i], &|speed| acceleration_bound_of(i, speed), ctx)),
            },
        };
        let (half_bounds, entry_half_bounds) = (half(&bounds), half(&entry_bounds));
        Ok(SampledMargin {
            auto: written == Some(Auto::Auto),
            looks_ahead: written.is_none(),
            half_bounds,
            entry_half_bounds,
            locked_joints_moving: false,
            loss,
            kept,
        })
    }

    /// `φ δ` of a row, in m/s: `auto` follows a gain that moves.
    pub fn rate(&self, row: usize, gain: f64) -> f64 {
        match self.auto {
            true if self.locked_joints_moving => self.entry_half_bounds[row],
            true => self.half_bounds[row],
            false => gain * self.kept[row],
        }
    }

    /// Sets whether locked joints come to rest.
    pub fn set_locked_joints_moving(&mut self, moving: bool) {
        self.locked_joints_moving = moving;
    }
}

/// Returns the error that names the joints for which the curvature of a row is unbounded.
fn unbounded(name: &str, acceleration_bound: &dyn Fn(&[f64]) -> f64, ctx: &Context) -> BuildError {
    // A joint is at fault if the bound remains infinite although every other open speed is known.
    let known: Vec<f64> = ctx.entry_speed.iter().map(|s| if s.is_finite() { *s } else { 1.0 }).collect();
    let at_fault = |dof: &usize| {
        let mut speed = known.clone();
        speed[*dof] = ctx.entry_speed[*dof];
        !speed[*dof].is_finite() && !acceleration_bound(&speed).is_finite()
    };
    if !acceleration_bound(&known).is_finite() {
        let text = format!("`auto` has no bound for `{name}`: a joint on the way to it slides without position limits");
        return BuildError::new("sampled_margin", text).help(
            "give that joint `lower` and `upper` under `limits` of the robot, or leave `sampled_margin` out: the limit then looks ahead",
        );
    }
    let open: Vec<usize> = (0..ctx.entry_speed.len()).filter(at_fault).collect();
    let shown: Vec<String> =
        open.iter().take(4).filter_map(|&d| Some(format!("`{}`", ctx.model.dofs.get(d)?.name))).collect();
    if open.iter().all(|&d| ctx.speed[d].is_finite()) {
        let text = format!(
            "`auto` has no bound for `{name}`: {} may still move when this stack, which locks them, is entered, and another stack \
             limits their speed on no hard level",
            shown.join(", ")
        );
        return BuildError::new("sampled_margin", text)
            .help("put `joint_velocity_limits` on a hard level of every stack that moves it, or leave `sampled_margin` out: the limit then looks ahead");
    }
    let more = open.len().saturating_sub(shown.len());
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let text = format!(
        "`auto` has no bound for `{name}`: no hard level down to this one limits the speed of {}{more}",
        shown.join(", ")
    );
    BuildError::new("sampled_margin", text).help(
        "put `joint_velocity_limits` on a hard level, this one or one above it, with `max` for joints that have no \
         speed limit of their own; or leave `sampled_margin` out: the limit then looks ahead",
    )
}
