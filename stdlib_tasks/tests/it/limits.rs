//! Inequality rows of every limit: `J v` is the derivative of the margin, bounds are `-φ h` on the right side, and a
//! velocity that uses the margin up too fast violates the row.

use hierarq_stdlib_tasks::bound::{Bound, Geometry};
use nalgebra::{Isometry3, Translation3, Vector3};
use robot::{LinkId, Model, Shape};

use crate::common::*;

const H: f64 = 1e-6;

/// A shape at a random place of a link.
pub fn shaped(name: &str, link: LinkId, shape: Shape, rng: &mut impl FnMut() -> f64) -> Geometry {
    let origin = Isometry3::from_parts(Translation3::from(vector(rng, 0.05)), rotation(rng));
    Geometry { name: name.to_string(), link, origin, shape }
}

/// Links in the middle of the robot.
pub fn middle(model: &Model) -> LinkId {
    model.link("link_3").or(model.link("head_link")).unwrap()
}

/// A wall; its plane is fixed to `on`, or to the world.
pub fn wall(points: Vec<Geometry>, on: Option<LinkId>, d_min: (f64, f64), rng: &mut impl FnMut() -> f64) -> Case {
    let corners: Vec<f64> = (0..3).flat_map(|_| <[f64; 3]>::from(vector(rng, 1.0))).collect();
    let case = Case::new("virtual_wall")
        .with("points", Bound::Geometries(points))
        .number("through", &corners)
        .moving("d_min", &[d_min.0], &[d_min.1])
        .number("gain", &[5.0])
        .number("sampled_margin", &[0.01]);
    match on {
        Some(link) => case.with("on", Bound::Frame("carrier".to_string(), link)),
        None => case,
    }
}

/// A collision task.
pub fn collision(a: Vec<Geometry>, b: Vec<Geometry>, d_min: (f64, f64)) -> Case {
    Case::new("self_collision")
        .with("between", Bound::Geometries(a))
        .with("and", Bound::Geometries(b))
        .moving("d_min", &[d_min.0], &[d_min.1])
        .number("gain", &[10.0])
        .number("sampled_margin", &[0.02])
}

/// Walls and collisions; with flat and long shapes only where nothing is aligned.
fn cases(model: &Model, aligned: bool, rng: &mut impl FnMut() -> f64) -> Vec<Case> {
    let [left, right] = arms(model);
    let head = middle(model);
    let ball = Shape::Sphere { radius: 0.04 };
    let rod = Shape::Capsule { radius: 0.03, half_length: 0.08 };
    let cube = Shape::Box { half: [0.05, 0.08, 0.03] };
    let points = vec![point(left.tip, rng), shaped("ball", right.tip, ball.clone(), rng)];
    let mut shapes = points.clone();
    if !aligned {
        shapes.extend([shaped("rod", left.tip, rod.clone(), rng), shaped("cube", left.tip, cube.clone(), rng)]);
    }
    let other = [shaped("ball", head, ball, rng), shaped("rod", head, rod, rng), shaped("cube", head, cube, rng)];
    vec![
        wall(shapes.clone(), None, (0.2, 0.0), rng),
        wall(shapes.clone(), None, (0.2, 0.3), rng),
        wall(shapes.clone(), Some(head), (0.1, -0.2), rng),
        collision(shapes, other.to_vec(), (0.1, 0.2)),
        collision(points, other.to_vec(), (0.1, 0.0)),
    ]
}

#[test]
fn rows_are_the_derivative_of_the_margin() {
    let mut rng = rng(21);
    let mut rows = 0;
    for model in robots() {
        for (n, q) in configurations(&model, 6, &mut rng).iter().enumerate() {
            let place = Place::new(&model, q);
            for case in cases(&model, n < 3, &mut rng) {
                let mut task = case.build(&model);
                let Ok(w) = place.write(&mut *task, &case, 0.0) else { continue };
                let v = velocity(&model, &mut rng, 1.0);
                let after = place.moved(&v, H).write(&mut *task, &case, H).unwrap();
                let before = place.moved(&v, -H).write(&mut *task, &case, -H).unwrap();
                let d_min_rate = case.rates[case.place("d_min").at];
                let gain = case.values[case.place("gain").at];
                let kept = case.values[case.place("sampled_margin").at];
                for i in 0..w.margins.len() {
                    rows += 1;
                    let numeric = (after.margins[i] - before.margins[i]) / (2.0 * H);
                    let expected = w.rate(i, &v) - d_min_rate;
                    let what = format!("{} {}", case.name, task.rows()[i].name);
                    assert!((numeric - expected).abs() < 2e-6, "{what}: {numeric} and {expected}");
                    let bound = d_min_rate - gain * (w.margins[i] - kept);
                    assert!((w.lower[i] - bound).abs() < 1e-12, "{what}");
                    assert_eq!(w.upper[i], f64::INFINITY, "{what}");
                }
            }
        }
    }
    assert!(rows > 1000, "{rows}");
}

#[test]
fn margins_are_distances_less_the_threshold() {
    let mut rng = rng(22);
    for model in robots() {
        let [left, right] = arms(&model);
        for q in configurations(&model, 6, &mut rng) {
            let place = Place::new(&model, &q);
            let (a, b) = (point(left.tip, &mut rng), point(middle(&model), &mut rng));
            let at = |g: &Geometry| place.data.pose(g.link) * g.center();
            let case = collision(vec![a.clone()], vec![b.clone()], (0.07, 0.0));
            let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
            assert!((w.margins[0] - ((at(&a) - at(&b)).norm() - 0.07)).abs() < 1e-12);

            // The plane given by three points; the distance is the height of a parallelepiped: volume over base.
            for on in [None, Some(right.tip)] {
                let case = wall(vec![b.clone()], on, (0.07, 0.0), &mut rng);
                let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
                let c = &case.values[case.place("through").at..];
                let corner = |k: usize| Vector3::new(c[3 * k], c[3 * k + 1], c[3 * k + 2]);
                let p = match on {
                    Some(link) => place.data.pose(link).inverse() * at(&b),
                    None => at(&b),
                };
                let (u, v, d) = (corner(1) - corner(0), corner(2) - corner(0), p.coords - corner(0));
                let volume = nalgebra::Matrix3::from_columns(&[u, v, d]).determinant();
                let base = (u.norm_squared() * v.norm_squared() - u.dot(&v).powi(2)).sqrt();
                assert!((w.margins[0] - (volume / base - 0.07)).abs() < 1e-10);
            }
        }
    }
}

#[test]
fn a_velocity_that_uses_the_margin_up_violates() {
    let mut rng = rng(23);
    for model in robots() {
        let q = model.random_configuration(&mut rng);
        let place = Place::new(&model, &q);
        for case in cases(&model, false, &mut rng) {
            let mut task = case.build(&model);
            let Ok(w) = place.write(&mut *task, &case, 0.0) else { continue };
            for i in 0..w.margins.len() {
                let size = w.j.row(i).norm_squared();
                if size < 1e-6 || w.margins[i] < 0.02 {
                    continue;
                }
                // A step against the row's direction brings the parts closer: by brute force, not by the row.
                let push: Vec<f64> = w.j.row(i).iter().map(|x| -x / size).collect();
                let case = Case { rates: vec![0.0; case.rates.len()], ..case.clone() };
                let closer = place.moved(&push, 1e-4).write(&mut *task, &case, 0.0).unwrap();
                let away = place.moved(&push, -1e-4).write(&mut *task, &case, 0.0).unwrap();
                assert!(closer.margins[i] < w.margins[i] - 5e-5, "{}", case.name);
                assert!(away.margins[i] > w.margins[i], "{}", case.name);
                let fast: Vec<f64> = push.iter().map(|x| x * 1e3).collect();
                let back: Vec<f64> = push.iter().map(|x| x * -1e3).collect();
                assert!(w.rate(i, &fast) < w.lower[i], "a push through the barrier is allowed");
                assert!(w.rate(i, &back) > w.lower[i], "moving away is forbidden");
            }
        }
    }
}

#[test]
fn joint_limits_hold_their_side() {
    let mut rng = rng(24);
    for model in robots() {
        for _ in 0..5 {
            let q = model.random_configuration(&mut rng);
            let place = Place::new(&model, &q);
            let mut case = Case::new("joint_position_limits").number("gain", &[8.0]);
            let dof = model.nv() - 1;
            let lower = case.slot(&[-0.1], &[0.0]);
            let case = case.with("lower", Bound::PerJoint(vec![(dof, lower)]));
            let mut task = case.build(&model);
            let w = place.write(&mut *task, &case, 0.0).unwrap();
            let names: Vec<String> = task.rows().into_iter().map(|r| r.name).collect();
            let limited = model.dofs.iter().filter(|d| d.lower.is_finite() || d.upper.is_finite());
            assert_eq!(names, limited.map(|d| d.name.clone()).collect::<Vec<_>>());
            let v = velocity(&model, &mut rng, 1.0);
            let after = place.moved(&v, H).write(&mut *task, &case, H).unwrap();
            for (i, name) in names.iter().enumerate() {
                let k = model.dof(name).unwrap();
                let d = &model.dofs[k];
                let low = if k == dof { -0.1 } else { d.lower };
                let now = q[d.q_index.unwrap()];
                assert!((w.rate(i, &v) - v[k]).abs() < 1e-15);
                assert!((w.lower[i] + 8.0 * (now - low)).abs() < 1e-12);
                assert!((w.upper[i] - 8.0 * (d.upper - now)).abs() < 1e-12);
                let nearer_low = now - low < d.upper - now;
                let slope = (after.margins[i] - w.margins[i]) / H;
                assert!((slope - if nearer_low { v[k] } else { -v[k] }).abs() < 1e-8, "{name}");
            }
        }
    }
}

#[test]
fn velocity_limits_are_those_of_the_robot_or_of_the_spec() {
    let model = canopies(robot::Base::Planar);
    let mut case = Case::new("joint_velocity_limits");
    let slow = case.slot(&[0.05], &[0.0]);
    let base = case.slot(&[0.3], &[0.0]);
    let lift = model.dof("torso_lift").unwrap();
    let case = case.with("max", Bound::PerJoint(vec![(lift, slow), (0, base)]));
    let mut task = case.build(&model);
    let place = Place::new(&model, &model.neutral());
    let w = place.write(&mut *task, &case, 0.0).unwrap();
    let limits = task.speed_limits(&case.values);
    // base_y and base_yaw have no limit, and so no row.
    assert_eq!(limits.len(), model.nv() - 2);
    let mut rng = rng(25);
    let v = velocity(&model, &mut rng, 3.0);
    let mut margins = vec![f64::INFINITY; limits.len()];
    task.observe(&place.state(&case.values, &case.rates), &v, &mut margins, &mut []);
    for (i, &(dof, max)) in limits.iter().enumerate() {
        let expected = if dof == lift {
            0.05
        } else if dof == 0 {
            0.3
        } else {
            model.dofs[dof].velocity
        };
        assert_eq!(max, expected);
        assert_eq!((w.lower[i], w.upper[i]), (-max, max));
        assert_eq!(w.rate(i, &v), v[dof]);
        let inside = w.lower[i] <= v[dof] && v[dof] <= w.upper[i];
        assert_eq!(inside, margins[i] >= 0.0);
        assert!((margins[i] - (max - v[dof].abs())).abs() < 1e-15);
    }
}
