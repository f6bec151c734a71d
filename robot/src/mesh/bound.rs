//! A bounding capsule of points: small, not minimal, and guaranteed to contain them.

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::Shape;

/// Minimum radius \[m\]: straight meshes would get a radius of zero.
const THINNEST: f64 = 1e-6;

/// Returns a capsule that contains all points, and its pose in their frame. Candidates for its axis are the coordinate
/// axes, the principal axes and the longest extent; the one with the least volume is used. Returns `None` if there are
/// no points, or if a coordinate is not finite or beyond 1e9 m.
pub(crate) fn bounding_capsule(points: &[Vector3<f64>]) -> Option<(Isometry3<f64>, Shape)> {
    if points.is_empty() || points.iter().flatten().any(|x| !x.is_finite() || x.abs() > 1e9) {
        return None;
    }
    let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let spread: Matrix3<f64> =
        points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum::<Matrix3<f64>>() / points.len() as f64;
    let principal = spread.symmetric_eigen().eigenvectors;
    let farthest = |from: &Vector3<f64>| {
        points.iter().fold(
            *from,
            |far, p| {
                if (p - from).norm_squared() > (far - from).norm_squared() { *p } else { far }
            },
        )
    };
    let end = farthest(&mean);
    let mut best: Option<Capsule> = None;
    let axes = (0..3)
        .map(|i| Vector3::ith(i, 1.0))
        .chain(principal.column_iter().map(|c| c.into_owned()))
        .chain([farthest(&end) - end])
        .filter_map(|axis| Unit::try_new(axis, 1e-12));
    for axis in axes {
        let capsule = around(points, axis, 0);
        if best.as_ref().is_none_or(|b| capsule.volume() < b.volume()) {
            best = Some(capsule);
        }
    }
    let rough = best?;
    let fine = around(points, rough.axis, 64);
    let Capsule { axis, centre, radius, half_length } = if fine.volume() < rough.volume() { fine } else { rough };
    let rotation = UnitQuaternion::rotation_between(&Vector3::z(), &axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    // Margin for rounding errors, here and in later transformations.
    let slack = 1e-9 * (1.0 + centre.norm());
    let shape = Shape::Capsule { radius: radius.max(THINNEST) * (1.0 + 1e-9) + slack, half_length };
    Some((Isometry3::from_parts(Translation3::from(centre), rotation), shape))
}

struct Capsule {
    axis: Unit<Vector3<f64>>,
    centre: Vector3<f64>,
    radius: f64,
    half_length: f64,
}

impl Capsule {
    /// Volume divided by π.
    fn volume(&self) -> f64 {
        self.radius * self.radius * (2.0 * self.half_length + 4.0 / 3.0 * self.radius)
    }
}

/// Computes a capsule along `axis`: a circle around the points projected along the axis, then caps as close together as
/// the points allow. The centre of the circle starts at the middle of the extents and takes `rounds` steps towards the
/// farthest point, each shorter (Bădoiu and Clarkson, Smaller core-sets for balls, 2003).
fn around(points: &[Vector3<f64>], axis: Unit<Vector3<f64>>, rounds: usize) -> Capsule {
    let e = axis.into_inner();
    let u = e.cross(&Vector3::ith(e.iamin(), 1.0)).normalize();
    let v = e.cross(&u);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        for (i, x) in [u.dot(p), v.dot(p)].into_iter().enumerate() {
            low[i] = low[i].min(x);
            high[i] = high[i].max(x);
        }
    }
    let mut c = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
    let gap2 = |p: &Vector3<f64>, c: &[f64; 2]| {
        let (x, y) = (u.dot(p) - c[0], v.dot(p) - c[1]);
        x * x + y * y
    };
    let reach2 = |c: &[f64; 2]| points.iter().map(|p| gap2(p, c)).fold(0.0, f64::max);
    let (mut best, mut best_reach2) = (c, reach2(&c));
    for round in 0..rounds {
        let far = points.iter().fold((points[0], -1.0), |far, p| {
            let d = gap2(p, &c);
            if d > far.1 { (*p, d) } else { far }
        });
        if far.1 < best_reach2 {
            (best, best_reach2) = (c, far.1);
        }
        let step = 1.0 / (round as f64 + 2.0);
        c[0] += step * (u.dot(&far.0) - c[0]);
        c[1] += step * (v.dot(&far.0) - c[1]);
    }
    let radius = best_reach2.sqrt();
    let (mut top, mut bottom) = (f64::NEG_INFINITY, f64::INFINITY);
    for p in points {
        let along = e.dot(p);
        let cap = (best_reach2 - gap2(p, &best)).max(0.0).sqrt();
        top = top.max(along - cap);
        bottom = bottom.min(along + cap);
    }
    let centre = u * best[0] + v * best[1] + e * (0.5 * (top + bottom));
    Capsule { axis, centre, radius, half_length: (0.5 * (top - bottom)).max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn outside((X, shape): &(Isometry3<f64>, Shape), p: &Vector3<f64>) -> f64 {
        let Shape::Capsule { radius, half_length } = *shape else { panic!("no capsule") };
        let local = X.inverse_transform_point(&(*p).into()).coords;
        let z = local.z.clamp(-half_length, half_length);
        (local - Vector3::new(0.0, 0.0, z)).norm() - radius
    }

    proptest! {
        #[test]
        fn contains_every_point(
            points in proptest::collection::vec(prop::array::uniform3(-2.0f64..2.0), 1..40),
            flat in 0usize..3,
        ) {
            let mut points: Vec<_> = points.into_iter().map(Vector3::from).collect();
            // Solid, flat and straight point clouds.
            for p in &mut points {
                for i in 0..flat {
                    p[i] = 0.5;
                }
            }
            let capsule = bounding_capsule(&points).unwrap();
            for p in &points {
                prop_assert!(outside(&capsule, p) <= 0.0);
            }
        }
    }

    #[test]
    fn a_rod_gets_a_slender_capsule() {
        let axis = Vector3::new(1.0, 2.0, -0.5).normalize();
        let side = axis.cross(&Vector3::z()).normalize();
        let up = axis.cross(&side);
        let mut points = Vec::new();
        for i in 0..50 {
            let (sin, cos) = (i as f64 * 0.7).sin_cos();
            points.push(axis * (i as f64 / 49.0) + (side * cos + up * sin) * 0.05);
        }
        let (_, shape) = bounding_capsule(&points).unwrap();
        let Shape::Capsule { radius, half_length } = shape else { panic!("no capsule") };
        assert!(radius < 0.06 && half_length < 0.51, "{shape:?}");
    }

    #[test]
    fn nothing_around_nothing() {
        assert!(bounding_capsule(&[]).is_none());
        assert!(bounding_capsule(&[Vector3::new(0.0, f64::NAN, 0.0)]).is_none());
    }
}
