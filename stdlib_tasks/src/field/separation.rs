//! Speed and separation monitoring: the protective separation distance of ISO/TS 15066:2016, 5.5.4.2.3.
//!
//! ```text
//! S_p = S_h + S_r + S_s + C + Z_d + Z_r                                          formula (1)
//! S_h = v_h (T_r + T_s)    distance of the person until the robot is at rest, at a steady speed
//! S_r = v_r T_r            distance of the robot until it begins to stop
//! S_s                      distance of the robot while it stops
//!     = v_r T_s            for a known T_s and any deceleration
//!     = v_r^2 / (2 a)      for the deceleration a, with T_s = v_r / a
//! C     intrusion distance, ISO 13855: distance that a body part reaches in before it is detected
//! Z_d   uncertainty of the person's position,  Z_r   of the robot's
//! ```
//!
//! `v_h`, `v_r` are speeds towards each other along the shortest line between person and robot; a speed away counts as
//! zero. A person's speed that is not monitored must be taken as 1.6 m/s (ISO 13855; 2.0 m/s for hands within 0.5 m).
//! The tick at which the distance is evaluated is part of T_r: add one control period.
//!
//! The rule limits the COMMANDED speed: `S_p` rises with `v_r`, so `d >= S_p(v_r)` is `v_r <=` [`allowed_speed`], one
//! linear row `-n . J v <= allowed_speed(d)` with `n` the unit vector from the person to the nearest point of the
//! robot, exact and without a gain. This module is arithmetic, not a safety function: its results are as good as the
//! given figures, and the standard requires a rated implementation.
//!
//! [`allowed_speed`]: SpeedAndSeparation::allowed_speed

use crate::field::error::{SafetyError, setting};

/// Stopping behaviour of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stopping {
    /// T_s in s, for any speed; while stopping the robot may move with the full speed.
    Time(f64),
    /// With at least this deceleration along the line, m/s^2.
    Deceleration(f64),
}

/// Result of the rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The distance is sufficient for the present speed.
    Clear,
    /// The speed towards the person must be reduced to this, m/s.
    Slow(f64),
    /// Not even a robot at rest is far enough: a protective stop.
    Stop,
}

/// Figures of the formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedAndSeparation {
    reaction: f64,
    stopping: Stopping,
    intrusion: f64,
    human_uncertainty: f64,
    robot_uncertainty: f64,
}

impl SpeedAndSeparation {
    /// `reaction` is T_r in s; `intrusion` C, `human_uncertainty` Z_d, `robot_uncertainty` Z_r in m.
    ///
    /// # Errors
    /// [`SafetyError::Setting`] for a figure that is negative or not finite, for a deceleration that is not positive,
    /// and if both T_r and T_s are zero.
    pub fn new(
        reaction: f64,
        stopping: Stopping,
        intrusion: f64,
        human_uncertainty: f64,
        robot_uncertainty: f64,
    ) -> Result<SpeedAndSeparation, SafetyError> {
        for (name, value) in [
            ("reaction time", reaction),
            ("intrusion distance", intrusion),
            ("human uncertainty", human_uncertainty),
            ("robot uncertainty", robot_uncertainty),
        ] {
            setting(name, value, value >= 0.0 && value.is_finite(), "finite and not negative")?;
        }
        match stopping {
            Stopping::Time(t) => {
                setting("stopping time", t, t >= 0.0 && t.is_finite(), "finite and not negative")?;
                setting("reaction time", reaction, reaction + t > 0.0, "positive, or the stopping time")?;
            }
            Stopping::Deceleration(a) => setting("deceleration", a, a > 0.0 && a.is_finite(), "positive and finite")?,
        }
        Ok(SpeedAndSeparation { reaction, stopping, intrusion, human_uncertainty, robot_uncertainty })
    }

    /// T_s and S_s for the robot's speed `v` >= 0, and their derivatives.
    fn stop(&self, v: f64) -> [f64; 4] {
        match self.stopping {
            Stopping::Time(t) => [t, v * t, 0.0, t],
            Stopping::Deceleration(a) => [v / a, 0.5 * v * v / a, 1.0 / a, v / a],
        }
    }

    /// S_p \[m\] and its derivative in the robot's speed \[s\], for the speeds towards each other \[m/s\]. If the robot
    /// moves away, S_p is that at rest and the derivative is zero. NaN is passed on.
    pub fn distance(&self, robot: f64, human: f64) -> (f64, f64) {
        let (v, h) = (positive(robot), positive(human));
        let [time, way, longer, further] = self.stop(v);
        let fixed = self.intrusion + self.human_uncertainty + self.robot_uncertainty;
        let slope = if robot > 0.0 { h * longer + self.reaction + further } else { 0.0 };
        (h * (self.reaction + time) + v * self.reaction + way + fixed, slope)
    }

    /// Largest speed towards the person \[m/s\] with which `distance` is at least S_p; `None` if the robot would have
    /// to be at rest already, or a number is not finite.
    pub fn allowed_speed(&self, distance: f64, human: f64) -> Option<f64> {
        let h = positive(human);
        let room = distance - self.distance(0.0, h).0;
        if !room.is_finite() || room < 0.0 {
            return None;
        }
        Some(match self.stopping {
            Stopping::Time(t) => room / (self.reaction + t),
            // v^2 / (2 a) + v (T_r + h / a) = room, the root without a difference.
            Stopping::Deceleration(a) => {
                let b = self.reaction + h / a;
                let root = (b * b + 2.0 * room / a).sqrt();
                if room == 0.0 { 0.0 } else { 2.0 * room / (b + root) }
            }
        })
    }

    /// Applies the rule to a distance \[m\] and the speeds towards each other \[m/s\]. A number that is not finite is a
    /// stop.
    pub fn verdict(&self, distance: f64, robot: f64, human: f64) -> Verdict {
        match self.allowed_speed(distance, human) {
            Some(_) if !robot.is_finite() => Verdict::Stop,
            Some(allowed) if positive(robot) <= allowed => Verdict::Clear,
            Some(allowed) => Verdict::Slow(allowed),
            None => Verdict::Stop,
        }
    }
}

/// Part above zero; unlike `max`, it keeps NaN.
fn positive(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rules() -> [SpeedAndSeparation; 2] {
        [Stopping::Time(0.3), Stopping::Deceleration(2.5)].map(|s| {
            match SpeedAndSeparation::new(0.1, s, 0.2, 0.05, 0.01) {
                Ok(rule) => rule,
                Err(e) => panic!("{e}"),
            }
        })
    }

    #[test]
    fn by_hand() {
        // 1.6 m/s for 0.4 s, 1 m/s for 0.1 s and for 0.3 s, 0.26 m besides: 0.64 + 0.4 + 0.26.
        assert!((rules()[0].distance(1.0, 1.6).0 - 1.3).abs() < 1e-15);
        // Stops in 0.4 s over 0.2 m: 1.6 * 0.5 + 0.1 + 0.2 + 0.26.
        assert!((rules()[1].distance(1.0, 1.6).0 - 1.36).abs() < 1e-15);
        // At rest, and moving away: the displacement of the person and the fixed terms.
        for v in [0.0, -1.0] {
            assert!((rules()[0].distance(v, 1.6).0 - 0.9).abs() < 1e-15);
            assert!((rules()[1].distance(v, 1.6).0 - 0.42).abs() < 1e-15);
        }
        assert_eq!(rules()[0].verdict(1.4, 1.0, 1.6), Verdict::Clear);
        assert!(matches!(rules()[0].verdict(1.2, 1.0, 1.6), Verdict::Slow(v) if (v - 0.75).abs() < 1e-12));
        assert_eq!(rules()[0].verdict(0.89, 0.0, 1.6), Verdict::Stop);
    }

    #[test]
    fn what_is_not_finite_stops() {
        for rule in rules() {
            for (d, v, h) in
                [(f64::NAN, 0.0, 0.0), (9.0, f64::NAN, 0.0), (9.0, 0.0, f64::NAN), (9.0, 0.0, f64::INFINITY)]
            {
                assert_eq!(rule.verdict(d, v, h), Verdict::Stop);
            }
        }
        let new = SpeedAndSeparation::new;
        assert!(new(-0.1, Stopping::Time(0.1), 0.0, 0.0, 0.0).is_err());
        assert!(new(0.0, Stopping::Time(0.0), 0.0, 0.0, 0.0).is_err());
        assert!(new(0.1, Stopping::Deceleration(0.0), 0.0, 0.0, 0.0).is_err());
        assert!(new(0.1, Stopping::Time(f64::NAN), 0.0, 0.0, 0.0).is_err());
        assert!(new(0.1, Stopping::Time(0.1), 0.0, f64::INFINITY, 0.0).is_err());
    }

    proptest! {
        #[test]
        fn slope_and_inverse(v in 0.01..3.0f64, h in -1.0..2.0f64, d in 0.0..5.0f64) {
            for rule in rules() {
                let (_, slope) = rule.distance(v, h);
                let expected = (rule.distance(v + 1e-6, h).0 - rule.distance(v - 1e-6, h).0) / 2e-6;
                prop_assert!((slope - expected).abs() < 1e-8);
                match rule.allowed_speed(d, h) {
                    Some(allowed) => prop_assert!((rule.distance(allowed, h).0 - d).abs() < 1e-12 && allowed >= 0.0),
                    None => prop_assert!(rule.distance(0.0, h).0 > d),
                }
                let clear = rule.distance(v, h).0 <= d;
                prop_assert_eq!(clear, rule.verdict(d, v, h) == Verdict::Clear);
            }
        }

        /// The rule in a closed loop: at every tick the speed is the allowed one, until the person, who approaches at
        /// the assumed speed, makes the robot stop; from then on it brakes as specified. The remaining distance is
        /// never below C + Z.
        #[test]
        fn the_distance_suffices(start in 1.5..4.0f64, h in 0.1..1.6f64, a in 0.5..6.0f64, wanted in 0.1..2.0f64) {
            let period = 0.01;
            let Ok(rule) = SpeedAndSeparation::new(2.0 * period, Stopping::Deceleration(a), 0.2, 0.05, 0.01) else { panic!() };
            let (mut d, mut v) = (start, 0.0f64);
            for _ in 0..2000 {
                let allowed = rule.allowed_speed(d, h);
                // Slowing down below the limit is braking too, with no more than the deceleration.
                v = match allowed {
                    Some(allowed) => wanted.min(allowed).max(v - a * period),
                    None => (v - a * period).max(0.0),
                };
                d -= (v + h) * period;
                if v == 0.0 && allowed.is_none() {
                    break;
                }
            }
            prop_assert!(v == 0.0 && d >= 0.26 - 1e-9, "{d}");
        }
    }
}
