//! Places where mathematics gives out: nothing panics, and what is written says so.

use std::f64::consts::PI;

use hierarq_stdlib_tasks::bound::{Bound, Geometry};
use hierarq_stdlib_tasks::kinds::swivel_angle::swivel;
use hierarq_stdlib_tasks::so3;
use hierarq_stdlib_tasks::task::TaskFault;
use nalgebra::{UnitQuaternion, Vector3};
use robot::{Base, Shape};

use crate::bound::valid;
use crate::common::*;
use crate::limits::{collision, middle};

/// A point of the head that stands where the left tip's origin is.
fn meeting(place: &Place) -> (Geometry, Geometry) {
    let [left, _] = arms(place.model);
    let head = middle(place.model);
    let offset = place.data.pose(head).inverse_transform_point(&place.point(left.tip).into()).coords;
    (Geometry::point("tip", left.tip, Vector3::zeros()), Geometry::point("head", head, offset))
}

#[test]
fn points_that_meet_are_a_fault_first_and_keep_their_direction_later() {
    let mut rng = rng(61);
    let model = canopies(Base::Planar);
    let place = Place::new(&model, &model.random_configuration(&mut rng));
    let (mut tip, mut head) = meeting(&place);
    let case = collision(vec![tip.clone()], vec![head.clone()], (0.1, 0.0));
    let mut task = case.build(&model);
    assert_eq!(place.write(&mut *task, &case, 0.0).err(), Some(TaskFault::Overlap { row: 0 }));

    let v = velocity(&model, &mut rng, 1.0);
    let before = place.moved(&v, 1e-4).write(&mut *task, &case, 0.0).unwrap();
    let now = place.write(&mut *task, &case, 0.0).unwrap();
    assert!(now.margins[0] == -0.1 && (now.lower[0] - 10.0 * (0.1 + 0.02)).abs() < 1e-12);
    assert!((&now.j - &before.j).amax() < 1e-2 && now.j.amax() > 0.01, "the last direction was not kept");
    // A new stack knows no last direction.
    task.enter(&place.state(&case.values, &case.rates));
    assert!(place.write(&mut *task, &case, 0.0).is_err());

    // Balls overlap by both radii where their centres meet.
    tip.shape = Shape::Sphere { radius: 0.03 };
    head.shape = Shape::Capsule { radius: 0.05, half_length: 0.2 };
    let case = collision(vec![tip], vec![head], (0.1, 0.0));
    let mut task = case.build(&model);
    let near = place.moved(&v, 1e-6).write(&mut *task, &case, 0.0).unwrap();
    let now = place.write(&mut *task, &case, 0.0).unwrap();
    assert!((now.margins[0] - (-0.1 - 0.08)).abs() < 1e-12);
    assert!((now.margins[0] - near.margins[0]).abs() < 1e-5, "the margin jumps where the cores meet");
}

#[test]
fn rods_that_cross_keep_the_place_where_they_met() {
    // Cores that cross far from both middles: a lever about the middles would turn the wrong way.
    let model = canopies(Base::Planar);
    let mut rng = rng(64);
    let place = Place::new(&model, &model.random_configuration(&mut rng));
    let (mut tip, mut head) = meeting(&place);
    for (rod, z) in [(&mut tip, 0.2), (&mut head, -0.25)] {
        let turn = rotation(&mut rng);
        rod.origin.rotation = turn;
        rod.origin.translation.vector += turn * Vector3::z() * z;
        rod.shape = Shape::Capsule { radius: 0.02, half_length: 0.3 };
    }
    let case = collision(vec![tip], vec![head], (0.1, 0.0));
    let mut task = case.build(&model);
    let near = place.moved(&velocity(&model, &mut rng, 1.0), 1e-5).write(&mut *task, &case, 0.0).unwrap();
    let now = place.write(&mut *task, &case, 0.0).unwrap();
    assert!((now.margins[0] - (-0.1 - 0.04)).abs() < 1e-12 && (now.margins[0] - near.margins[0]).abs() < 1e-4);
    assert!((&now.j - &near.j).amax() < 1e-3 && now.j.amax() > 0.01);
}

#[test]
fn a_turn_that_is_no_number_is_no_overlap() {
    // The last joint turns its link on the spot: the place stays finite, the rod's direction does not.
    let model = arm7();
    let rod = Geometry {
        shape: Shape::Capsule { radius: 0.03, half_length: 0.1 },
        ..Geometry::point("rod", model.link("link_7").unwrap(), Vector3::zeros())
    };
    let case = collision(vec![rod], vec![Geometry::point("root", model.root(), Vector3::zeros())], (0.1, 0.0));
    let mut task = case.build(&model);
    let mut q = vec![0.3; 7];
    Place::new(&model, &q).write(&mut *task, &case, 0.0).unwrap();
    q[6] = f64::NAN;
    let bad = Place::new(&model, &q);
    assert!(bad.point(model.link("link_7").unwrap()).iter().all(|x| x.is_finite()));
    assert_eq!(bad.write(&mut *task, &case, 0.0).err(), Some(TaskFault::NotFinite { row: 0 }));
}

#[test]
fn what_lies_flat_against_a_wall_is_kept_away_in_its_middle() {
    let model = arm7();
    let root = model.root();
    let place = Place::new(&model, &model.neutral());
    let flat = |name: &str, shape: Shape, tilt: f64| {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * (PI / 2.0 + tilt));
        let origin = nalgebra::Isometry3::from_parts(Vector3::new(0.2, 0.1, 0.7).into(), turn);
        Geometry { name: name.to_string(), link: model.link("link_3").unwrap(), origin, shape }
    };
    for (shape, reach) in
        [(Shape::Capsule { radius: 0.03, half_length: 0.2 }, 0.03), (Shape::Box { half: [0.05, 0.1, 0.2] }, 0.05)]
    {
        let write = |tilt: f64| {
            let case = valid("virtual_wall", &model)
                .with("points", Bound::Geometries(vec![flat("flat", shape.clone(), tilt)]))
                .with("on", Bound::Frame("root".to_string(), root));
            (place.write(&mut *case.build(&model), &case, 0.0).unwrap(), case)
        };
        let (level, case) = write(0.0);
        let middle = Geometry { shape: Shape::Sphere { radius: reach }, ..flat("middle", shape.clone(), 0.0) };
        let case = case.with("points", Bound::Geometries(vec![middle]));
        let expected = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
        assert!((level.margins[0] - expected.margins[0]).abs() < 1e-12);
        assert!((&level.j - &expected.j).amax() < 1e-12, "{} and {}", level.j, expected.j);
        // The margin does not jump where the nearest point does; either end is as near as the middle.
        let (one, other) = (write(1e-6).0, write(-1e-6).0);
        assert!((one.margins[0] - level.margins[0]).abs() < 1e-6 && (other.margins[0] - level.margins[0]).abs() < 1e-6);
        assert!(((&one.j + &other.j) * 0.5 - &level.j).amax() < 1e-5);
        assert!((&one.j - &other.j).amax() > 0.1, "the nearest point does not depend on the tilt");
    }
}

#[test]
fn a_configuration_that_is_no_number_is_told_from_an_overlap() {
    let model = canopies(Base::Planar);
    let good = Place::new(&model, &model.neutral());
    let bad = Place::new(&model, &vec![f64::NAN; model.nq()]);
    for kind in hierarq_stdlib_tasks::KINDS {
        let case = valid(kind.name, &model);
        let mut task = case.build(&model);
        task.enter(&good.state(&case.values, &case.rates));
        let _ = good.write(&mut *task, &case, 0.0);
        match bad.write(&mut *task, &case, 0.0) {
            Err(fault) => assert_eq!(fault, TaskFault::NotFinite { row: 0 }, "`{}`", kind.name),
            Ok(w) => {
                let seen = w.j.iter().chain(w.lower.iter()).chain(w.upper.iter()).any(|x| x.is_nan());
                // These do not look at the configuration at all.
                let blind = [
                    "joint_velocity",
                    "least_motion",
                    "joint_velocity_limits",
                    "joint_acceleration_limits",
                    "safety_planner",
                ]
                .contains(&kind.name);
                assert_eq!(seen, !blind, "`{}`", kind.name);
            }
        }
    }
}

#[test]
fn a_stretched_arm_has_no_swivel_angle() {
    let model = arm7();
    let mut case = Case::new("swivel_angle").number("gain", &[1.0]);
    let slot = case.slot(&[0.5], &[0.0]);
    let case = case.with("angle", Bound::PerArm(vec![(arms(&model)[0].clone(), slot)]));
    let mut task = case.build(&model);
    let at = |q: &[f64]| Place::new(&model, q);
    // Stretched and upright, stretched and leaning, bent with the wrist above the shoulder.
    let upright = vec![0.0; 7];
    let mut leaning = upright.clone();
    leaning[1] = 0.7;
    for q in [&upright, &leaning] {
        let w = at(q).write(&mut *task, &case, 0.0).unwrap();
        assert!(w.undefined && w.measures[0].is_nan());
        assert!(w.lower[0] == f64::NEG_INFINITY && w.upper[0] == f64::INFINITY && w.j.amax() == 0.0);
        assert!(at(q).current_value(&*task, &case, 0.0, "angle.left", 1)[0].is_nan());
    }
    let mut bent = leaning.clone();
    bent[3] = 0.8;
    let w = at(&bent).write(&mut *task, &case, 0.0).unwrap();
    assert!(!w.undefined && w.lower[0].is_finite() && w.j.amax() > 0.0);
    let p = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
    assert!(swivel(&p(0.0, 0.0, 0.0), &p(0.1, 0.0, 0.2), &p(0.0, 0.0, 0.4)).is_none());
    assert!(swivel(&p(0.0, 0.0, 0.0), &p(0.1, 0.0, 0.2), &p(0.0, 0.0, 0.0)).is_none());
    // An elbow straight below the line is at half a turn; to its left and right at a quarter turn.
    let angle = |e: Vector3<f64>| swivel(&p(0.0, 0.0, 0.0), &e, &p(1.0, 0.0, 0.0)).unwrap().angle;
    let straight = [angle(p(0.5, 0.0, -0.3)).abs(), angle(p(0.5, 0.0, 0.3)).abs()];
    assert!((straight[0] - straight[1]).abs() > PI - 1e-12, "{straight:?}");
    assert!((angle(p(0.5, 0.3, 0.0)).abs() - PI / 2.0).abs() < 1e-12);
    assert!((angle(p(0.5, 0.3, 0.0)) + angle(p(0.5, -0.3, 0.0))).abs() < 1e-12);
}

#[test]
fn half_a_turn_off_goes_one_of_both_ways() {
    let model = arm7();
    let mut rng = rng(62);
    let q = model.random_configuration(&mut rng);
    let place = Place::new(&model, &q);
    let tip = arms(&model)[0].tip;
    for axis in [Vector3::x(), Vector3::y(), Vector3::z(), vector(&mut rng, 1.0).normalize()] {
        for beyond in [-1e-9, 0.0, 1e-9] {
            let turn = UnitQuaternion::from_scaled_axis(axis * (PI + beyond));
            let d = turn * place.data.pose(tip).rotation;
            let case = Case::new("frame_orientation")
                .with("frame", Bound::Frame("tip".to_string(), tip))
                .number("orientation", &[d.w, d.i, d.j, d.k])
                .number("gain", &[1.0]);
            let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
            let error = Vector3::new(w.lower[0], w.lower[1], w.lower[2]);
            assert!((w.measures[0] - PI).abs() < 1e-8 && (error.norm() - PI).abs() < 1e-8);
            assert!(error.cross(&axis).norm() < 1e-7, "{error} is not about {axis}");
        }
    }
    // Its neighbours: the inverse of the left Jacobian is finite up to half a turn.
    assert!(so3::left_jacobian_inverse(&(Vector3::x() * PI)).iter().all(|x| x.is_finite()));
}

#[test]
fn a_target_without_direction_is_not_repaired() {
    let model = canopies(Base::Planar);
    let place = Place::new(&model, &model.random_configuration(&mut rng(63)));
    for (name, path, row) in [
        ("frame_pose", "orientation", 3),
        ("frame_orientation", "orientation", 0),
        ("cooperative_motion", "absolute.orientation", 3),
        ("cooperative_motion", "relative.orientation", 9),
        ("uncooperative_motion", "right.orientation", 9),
    ] {
        for q in [[0.0; 4], [f64::NAN; 4]] {
            let mut case = valid(name, &model);
            case.set(path, &q);
            let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
            assert!((row..row + 3).all(|i| w.lower[i].is_nan() && w.upper[i].is_nan()), "{name} {path}");
        }
        // One of any other length is as good as a unit one.
        let mut case = valid(name, &model);
        let unit = [0.5, -0.5, 0.5, 0.5];
        case.set(path, &unit);
        case.rates.fill(0.0);
        let a = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
        case.set(path, &unit.map(|x| -3.0 * x));
        let b = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
        assert!((a.lower - b.lower).amax() < 1e-12, "{name} {path}");
    }
}
