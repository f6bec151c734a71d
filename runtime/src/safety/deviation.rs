//! Deviations from the nominal path: thesis (4.7)-(4.11), on the manifold.
//!
//! ```text
//! position     p_s = p_d + d                  e = d                   d'     = -T e + psi u
//! orientation  R_s = R_d D                    e = R_d log(D)          omega  = -T e + psi u
//! ```
//!
//! Each orientation has its own deviation (in (4.8) the absolute one is printed with that of the relative one), and `D`
//! rotates in the correct direction without an inverse: with `omega` in the axes in which the target is expressed,
//! `omega_s = omega_d + omega`, as the rates of (4.8) add. `e` is the rotation vector, as everywhere in this library,
//! not the quaternion's vector part. Over a period P the steps are
//!
//! ```text
//! d <- (1 - T P) d + P psi u          D <- exp(P R_d^T psi u) exp((1 - T P) log D)
//! ```
//!
//! Directions have unit length or are zero. A bound on the deviation is a bound on `u` alone, and exact for the step:
//! with `a = (1 - T P) e` and `r = |e| + k P (reach - |e|)`, it allows all `u` with `|a + P psi u| <= r`, an interval
//! between the roots of a quadratic. It is the barrier row of gain k for `reach - |e|`, without the loss of a sampled
//! barrier and for any change of the direction. For rotations the composed angle is at most `|a + P psi u|` (a hinge in
//! a space of non-negative curvature closes at most as far as in the plane: Toponogov), so the same interval applies.

use nalgebra::{UnitQuaternion, Vector3};
use stdlib_tasks::so3;

use stdlib_tasks::field::{SafetyError, gain, setting};

/// Kind of a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviationKind {
    /// A position: \[m\], additive.
    Position,
    /// An orientation: \[rad\], composed.
    Orientation,
}

/// Direction of a deviation: psi in thesis (4.11).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// Constant, in the axes of the task's rows.
    Fixed(Vector3<f64>),
    /// [`Frame::direction`] at each tick, for example [`towards`] a person.
    Given,
    /// The direction in which the field grows fastest for the law of the task; a positive input then always helps.
    Gradient,
}

/// Deviation of the protected task's target, and its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Position or orientation.
    pub kind: DeviationKind,
    /// The first of its three rows in the task.
    pub row: usize,
    /// T in 1/s: stiffness of the spring back to the nominal path; times the period at most 1.
    pub stiffness: f64,
    /// Smallest and largest input, m/s or rad/s, with zero between; thesis (4.29). [`towards`] points at the person, so
    /// moving away requires a negative input.
    pub speed: [f64; 2],
    /// Largest deviation, m or rad. Without it, the deviation is still bounded by the largest speed over the stiffness.
    pub reach: Option<f64>,
    /// Its direction.
    pub direction: Direction,
    /// Its weight in the planner's cost, positive.
    pub weight: f64,
}

/// Inputs of a deviation at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Nominal target R_d at the clock c, for orientations; otherwise unused.
    pub rotation: UnitQuaternion<f64>,
    /// Direction for [`Direction::Given`], of any length; zero for none.
    pub direction: Vector3<f64>,
}

impl Default for Frame {
    fn default() -> Self {
        Frame { rotation: UnitQuaternion::identity(), direction: Vector3::zeros() }
    }
}

/// Unit vector from `from` to `to`, thesis (4.48), (4.49); zero if they coincide.
pub fn towards(from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    unit(&(to - from))
}

/// Vector scaled to unit length; zero if it has (almost) none.
fn unit(v: &Vector3<f64>) -> Vector3<f64> {
    let n = v.norm();
    if n > 1e-12 && n.is_finite() { v / n } else { Vector3::zeros() }
}

/// Present state of a deviation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Course {
    pub(super) of: Deviation,
    /// d for a position.
    pub(super) offset: Vector3<f64>,
    /// D for an orientation.
    pub(super) turn: UnitQuaternion<f64>,
    /// R_d of this tick.
    frame: UnitQuaternion<f64>,
    /// psi of this tick.
    pub(super) along: Vector3<f64>,
    /// e of this tick.
    pub(super) error: Vector3<f64>,
}

impl Course {
    pub(super) fn new(of: Deviation, rows: usize, period: f64) -> Result<Course, SafetyError> {
        gain("stiffness", of.stiffness, period)?;
        if of.row.checked_add(3).is_none_or(|end| end > rows) {
            return Err(SafetyError::Shape { name: "deviations" });
        }
        let [least, most] = of.speed;
        setting("deviation speed", least, least <= 0.0 && least.is_finite(), "finite and at most zero, the lower one")?;
        setting("deviation speed", most, most >= 0.0 && most.is_finite(), "finite and at least zero, the upper one")?;
        setting("deviation weight", of.weight, of.weight > 0.0 && of.weight.is_finite(), "positive and finite")?;
        let reach = of.reach.unwrap_or(f64::INFINITY);
        setting("deviation reach", reach, reach > 0.0, "positive")?;
        let furthest = reach.min(most.max(-least) / of.stiffness);
        if of.kind == DeviationKind::Orientation {
            let must = "below half a turn: the greatest speed over the stiffness, or the reach";
            setting("orientation deviation", furthest, furthest < std::f64::consts::PI, must)?;
        }
        if let Direction::Fixed(d) = of.direction {
            let n = d.norm();
            setting("deviation direction", n, n > 1e-12 && n.is_finite(), "finite and not zero, its length")?;
        }
        let zero = Vector3::zeros();
        let one = UnitQuaternion::identity();
        Ok(Course { of, offset: zero, turn: one, frame: one, along: zero, error: zero })
    }

    pub(super) fn reset(&mut self) {
        self.offset = Vector3::zeros();
        self.turn = UnitQuaternion::identity();
        self.along = Vector3::zeros();
        self.error = Vector3::zeros();
    }

    /// Updates the state with the tick's frame and the field's gradient in all rows of the task.
    pub(super) fn see(&mut self, frame: &Frame, gradient: &[f64]) -> Result<(), SafetyError> {
        let nan = SafetyError::NotFinite { name: "deviation frame" };
        if !frame.direction.iter().all(|x| x.is_finite()) || !frame.rotation.coords.iter().all(|x| x.is_finite()) {
            return Err(nan);
        }
        self.frame = frame.rotation;
        self.error = match self.of.kind {
            DeviationKind::Position => self.offset,
            DeviationKind::Orientation => self.frame * so3::log(&self.turn),
        };
        self.along = match self.of.direction {
            Direction::Fixed(d) => unit(&d),
            Direction::Given => unit(&frame.direction),
            Direction::Gradient => match gradient.get(self.of.row..self.of.row + 3) {
                Some(g) => unit(&Vector3::new(g[0], g[1], g[2])),
                None => Vector3::zeros(),
            },
        };
        Ok(())
    }

    /// Range of the inputs that are allowed now: the speeds, restricted by the remaining reach with the barrier gain
    /// `k`.
    pub(super) fn bounds(&self, k: f64, period: f64) -> [f64; 2] {
        let [least, most] = self.of.speed;
        let Some(reach) = self.of.reach else { return [least, most] };
        let along2 = self.along.norm_squared();
        if along2 == 0.0 {
            return [least, most];
        }
        let far = self.error.norm();
        let a = self.error * (1.0 - self.of.stiffness * period);
        let r = far + k * period * (reach - far);
        let b = a.dot(&self.along) / along2;
        let root = (b * b + (r * r - a.norm_squared()) / along2).max(0.0).sqrt();
        // Outside the reach, the root is zero if no input returns within one period: the bounds are then the nearest
        // input.
        [((-b - root) / period).clamp(least, most), ((-b + root) / period).clamp(least, most)]
    }

    /// Advances by one period with the input `u`.
    pub(super) fn advance(&mut self, u: f64, period: f64) {
        let keep = 1.0 - self.of.stiffness * period;
        let push = self.along * (u * period);
        match self.of.kind {
            DeviationKind::Position => self.offset = self.offset * keep + push,
            DeviationKind::Orientation => {
                let back = UnitQuaternion::from_scaled_axis(so3::log(&self.turn) * keep);
                let step = UnitQuaternion::from_scaled_axis(self.frame.inverse() * push);
                self.turn = UnitQuaternion::new_normalize((step * back).into_inner());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::safety::testing::vector;
    use proptest::prelude::*;

    fn deviation(kind: DeviationKind) -> Deviation {
        Deviation {
            kind,
            row: 0,
            stiffness: 2.0,
            speed: [-0.4, 0.4],
            reach: Some(0.1),
            direction: Direction::Given,
            weight: 1.0,
        }
    }

    fn size(course: &Course) -> f64 {
        course.offset.norm() + so3::log(&course.turn).norm()
    }

    proptest! {
        /// For any directions and inputs, the deviation stays within the reach, and inputs stay in their box.
        #[test]
        fn the_reach_is_kept(
            turning in any::<bool>(), gain in 0.5..100.0f64, stiffness in 0.1..100.0f64,
            steps in prop::collection::vec((vector(1.0), vector(3.0), -1.0..1.0f64), 60),
        ) {
            let kind = if turning { DeviationKind::Orientation } else { DeviationKind::Position };
            let period = 0.01;
            let of = Deviation { stiffness, speed: [-6.0, 5.0], reach: Some(0.7), ..deviation(kind) };
            let Ok(mut course) = Course::new(of, 3, period) else { panic!() };
            for (direction, turn, u) in steps {
                let frame = Frame { rotation: UnitQuaternion::from_scaled_axis(turn), direction };
                prop_assert_eq!(course.see(&frame, &[0.0; 3]), Ok(()));
                let [low, high] = course.bounds(gain, period);
                prop_assert!((-6.0..=1e-9).contains(&low) && (-1e-9..=5.0).contains(&high), "{low} {high}");
                let before = size(&course);
                course.advance(if u > 0.0 { high } else { low }, period);
                let bound = before + gain * period * (0.7 - before);
                prop_assert!(size(&course) <= bound + 1e-9 && bound <= 0.7 + 1e-9, "{} {bound}", size(&course));
            }
        }

        /// Without input, the deviation decays by (1 - T P) at each tick; with an input, its speed is -T e + psi u.
        #[test]
        fn the_spring_and_the_rate(turning in any::<bool>(), turn in vector(3.0), direction in vector(1.0), u in -0.4..0.4f64) {
            prop_assume!(direction.norm() > 0.1);
            let kind = if turning { DeviationKind::Orientation } else { DeviationKind::Position };
            let period = 1e-6;
            let Ok(mut course) = Course::new(deviation(kind), 3, period) else { panic!() };
            course.offset = Vector3::new(0.05, 0.0, -0.02);
            course.turn = UnitQuaternion::from_scaled_axis(course.offset);
            let frame = Frame { rotation: UnitQuaternion::from_scaled_axis(turn), direction };
            prop_assert_eq!(course.see(&frame, &[0.0; 3]), Ok(()));
            let expected = course.along * u - course.error * 2.0;
            let (offset, safe) = (course.offset, frame.rotation * course.turn);
            course.advance(u, period);
            let rate = match kind {
                DeviationKind::Position => (course.offset - offset) / period,
                DeviationKind::Orientation => so3::log(&(frame.rotation * course.turn * safe.inverse())) / period,
            };
            prop_assert!((rate - expected).norm() < 1e-4, "{rate} {expected}");
        }
    }

    #[test]
    fn settings_that_mean_nothing_are_refused() {
        let good = deviation(DeviationKind::Position);
        assert!(Course::new(good, 3, 0.01).is_ok());
        let long = |stiffness| Course::new(Deviation { stiffness, ..good }, 3, 0.01).err();
        assert_eq!(long(101.0), Some(SafetyError::Overshoot { name: "stiffness", product: 1.01 }));
        assert!(long(0.0).is_some() && long(f64::NAN).is_some());
        let turn = deviation(DeviationKind::Orientation);
        for bad in [
            Deviation { row: 1, ..good },
            Deviation { row: usize::MAX, ..good },
            Deviation { speed: [0.1, 0.4], ..good },
            Deviation { speed: [-0.1, f64::NAN], ..good },
            Deviation { reach: Some(0.0), ..good },
            Deviation { weight: -1.0, ..good },
            Deviation { direction: Direction::Fixed(Vector3::zeros()), ..good },
            Deviation { reach: None, speed: [-7.0, 7.0], ..turn },
        ] {
            assert!(Course::new(bad, 3, 0.01).is_err(), "{bad:?}");
        }
        assert_eq!(towards(&Vector3::x(), &Vector3::x()), Vector3::zeros());
        assert_eq!(towards(&Vector3::x(), &(Vector3::x() * 3.0)), Vector3::x());
    }
}
