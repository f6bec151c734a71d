//! Rotations: logarithm, its Jacobians, and targets given as quaternions with their derivative.
//!
//! The orientation error of the library is the rotation vector of `R_d R^T`: it has the direction of the quaternion's
//! vector part and the same shortest-way sign, and its length is the angle itself, so that a gain K yields the decay
//! `exp(-K t)` also for large errors.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Rotation vector of a rotation, in rad, with an angle in [0, pi].
pub fn log(q: &UnitQuaternion<f64>) -> Vector3<f64> {
    let (w, v) = if q.w < 0.0 { (-q.w, -q.imag()) } else { (q.w, q.imag()) };
    let s = v.norm();
    if s < 1e-9 {
        return v * (2.0 / w);
    }
    v * (2.0 * s.atan2(w) / s)
}

/// Rotation vector of a rotation, in rad, that is nearest to another one: its angle may exceed pi. After whole turns, where
/// the axis is undefined, it is that of `near`.
pub fn log_near(q: &UnitQuaternion<f64>, near: &Vector3<f64>) -> Vector3<f64> {
    let phi = log(q);
    let (angle, size) = (phi.norm(), near.norm());
    let axis = match (angle > 1e-9, size > 0.0) {
        (true, _) => phi / angle,
        (false, true) => near / size,
        (false, false) => return phi,
    };
    let turns = ((axis.dot(near) - angle) / TAU).round();
    axis * (angle + TAU * turns)
}

/// A target orientation from the table of values: the rotation and its angular velocity in the frame that the rotation
/// is expressed in, rad/s. The quaternion `w x y z` need not have unit length; a zero one yields NaN, which the
/// controller rejects.
pub fn target(q: [f64; 4], q_dot: [f64; 4]) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let quat = |a: [f64; 4]| Quaternion::new(a[0], a[1], a[2], a[3]);
    let (q, q_dot) = (quat(q), quat(q_dot));
    let n2 = q.norm_squared();
    let omega = (q_dot * q.conjugate()).imag() * (2.0 / n2);
    (UnitQuaternion::new_unchecked(q / n2.sqrt()), omega)
}

/// The skew matrix of `v`: `skew(v) u = v x u`.
pub fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Left Jacobian of SO(3) at a rotation vector: the angular velocity of `exp(phi)` is `J_l(phi) phi_dot`.
pub fn left_jacobian(phi: &Vector3<f64>) -> Matrix3<f64> {
    let t2 = phi.norm_squared();
    let (a, b) = if t2 < 1e-8 {
        (0.5 - t2 / 24.0, 1.0 / 6.0 - t2 / 120.0)
    } else {
        let t = t2.sqrt();
        let half = (0.5 * t).sin();
        (2.0 * half * half / t2, (t - t.sin()) / (t2 * t))
    };
    let k = skew(phi);
    Matrix3::identity() + k * a + k * k * b
}

/// Inverse of [`left_jacobian`]. It has none after a whole turn, where the result is not finite or very large.
pub fn left_jacobian_inverse(phi: &Vector3<f64>) -> Matrix3<f64> {
    let t2 = phi.norm_squared();
    let c = if t2 < 1e-6 {
        1.0 / 12.0 + t2 / 720.0
    } else {
        let half = 0.5 * t2.sqrt();
        (1.0 - half * half.cos() / half.sin()) / t2
    };
    let k = skew(phi);
    Matrix3::identity() - k * 0.5 + k * k * c
}

/// For `R_a = R_l exp(s phi)` with `phi = log(R_l^T R_r)`: the matrix `M` with
/// `omega_a = omega_l + R_l M R_l^T (omega_r - omega_l)` while `s` is constant.
///
/// It is `s J_l(s phi) J_l(phi)^-1`, which equals `s I` only along the axis of `phi`; thesis (3.32) uses `s I` always.
pub fn interpolation_rate(phi: &Vector3<f64>, s: f64) -> Matrix3<f64> {
    left_jacobian(&(phi * s)) * left_jacobian_inverse(phi) * s
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn log_inverts_exp(v in vector(), angle in 0.0..3.1f64) {
            prop_assume!(v.norm() > 1e-3);
            let v = v.normalize() * angle;
            prop_assert!((log(&UnitQuaternion::from_scaled_axis(v)) - v).norm() < 1e-9);
        }

        #[test]
        fn log_near_follows_a_rotation_through_half_a_turn(v in vector(), turn in vector()) {
            prop_assume!(v.norm() > 0.1);
            // From half a turn on, in small steps along any curve: a rotation vector whose exponential is the rotation.
            let mut q = UnitQuaternion::from_scaled_axis(v.normalize() * PI);
            let mut phi = v.normalize() * PI;
            for _ in 0..100 {
                q = UnitQuaternion::from_scaled_axis(turn * 0.02) * q;
                let next = log_near(&q, &phi);
                // Near a full turn, all axes are as near: the vector turns at once.
                if !(0.5 * PI..1.5 * PI).contains(&next.norm()) {
                    break;
                }
                prop_assert!(UnitQuaternion::from_scaled_axis(next).angle_to(&q) < 1e-6);
                prop_assert!((next - phi).norm() < 0.25, "{} {}", phi, next);
                phi = next;
            }
        }

        #[test]
        fn left_jacobian_is_the_derivative_of_exp(v in vector(), d in vector()) {
            let e = 1e-6;
            let plus = UnitQuaternion::from_scaled_axis(v + d * e);
            let minus = UnitQuaternion::from_scaled_axis(v - d * e);
            let omega = log(&(plus * minus.inverse())) / (2.0 * e);
            prop_assert!((omega - left_jacobian(&v) * d).norm() < 1e-8);
            prop_assert!((left_jacobian_inverse(&v) * left_jacobian(&v) - Matrix3::identity()).norm() < 1e-9);
        }

        #[test]
        fn target_rate_is_the_angular_velocity(v in vector(), w in vector()) {
            let q = UnitQuaternion::from_scaled_axis(v);
            let q_dot = Quaternion::from_imag(w) * q.quaternion() * 0.5;
            let (_, omega) = target([q.w * 3.0, q.i * 3.0, q.j * 3.0, q.k * 3.0],
                                    [q_dot.w * 3.0, q_dot.i * 3.0, q_dot.j * 3.0, q_dot.k * 3.0]);
            prop_assert!((omega - w).norm() < 1e-12);
        }
    }
}
