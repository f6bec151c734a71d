//! Vectors and rotations as numbers of a table.

use nalgebra::{UnitQuaternion, Vector3};

/// Writes a vector.
pub fn write_vector(v: &Vector3<f64>, out: &mut [f64]) {
    for (o, x) in out.iter_mut().zip(v.iter()) {
        *o = *x;
    }
}

/// Writes a quaternion as `w x y z`.
pub fn write_rotation(q: &UnitQuaternion<f64>, out: &mut [f64]) {
    for (o, x) in out.iter_mut().zip([q.w, q.i, q.j, q.k]) {
        *o = x;
    }
}
