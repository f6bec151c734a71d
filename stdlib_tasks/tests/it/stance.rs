//! The support polygon: rows against differences, with feet that move and shares that change; margins against a point in the
//! hull by brute force; what happens where the hull changes.

use hierarq_stdlib_tasks::bound::Bound;
use hierarq_stdlib_tasks::expression::center_of_mass;
use nalgebra::{Point3, Vector2, Vector3};
use proptest::prelude::*;
use robot::{Base, LinkId, Model};

use crate::common::*;

const H: f64 = 1e-6;

/// A foot of a case: a link, the points of its sole, and its share with the rate of it.
#[derive(Clone)]
pub struct Sole {
    link: LinkId,
    points: Vec<[f64; 3]>,
    carries: (f64, f64),
}

/// A stance on these feet.
pub fn stance(feet: &[Sole], margin: (f64, f64)) -> Case {
    let mut case = Case::new("stance").moving("margin", &[margin.0], &[margin.1]).number("gain", &[4.0]);
    let mut all = std::collections::BTreeMap::new();
    for (i, foot) in feet.iter().enumerate() {
        let numbers = foot.points.concat();
        let points = Bound::Value(case.slot(&numbers, &vec![0.0; numbers.len()]));
        let carries = Bound::Value(case.slot(&[foot.carries.0], &[foot.carries.1]));
        let frame = Bound::Frame(format!("foot_{i}"), foot.link);
        let group = [("points", points), ("carries", carries), ("frame", frame)];
        all.insert(format!("foot_{i}"), Bound::Group(group.map(|(n, b)| (n.to_string(), b)).into()));
    }
    case.with("feet", Bound::Group(all))
}

fn humanoid() -> Model {
    read(include_str!("../../../examples/robots/humanoid.urdf"), Base::Floating)
}

/// Corners of a rectangle.
fn rectangle(length: f64, width: f64) -> Vec<[f64; 3]> {
    let (x, y) = (0.5 * length, 0.5 * width);
    vec![[x, y, 0.0], [-x, y, 0.0], [-x, -y, 0.0], [x, -y, 0.0]]
}

/// Two soles and a hand, of different forms and shares.
fn feet(model: &Model, rng: &mut impl FnMut() -> f64, moving: bool) -> Vec<Sole> {
    let mut share = |x: f64| (x, if moving { rng() - 0.5 } else { 0.0 });
    let shares = [share(1.0 - 1e-4), share(0.6), share(0.3)];
    let five =
        vec![[0.1, 0.02, 0.0], [0.06, 0.04, 0.01], [-0.07, 0.03, 0.0], [-0.08, -0.03, -0.02], [0.09, -0.04, 0.0]];
    let links = ["left_sole", "right_sole", "left_wrist_yaw_link"].map(|name| model.link(name).unwrap());
    let points = [rectangle(0.17, 0.06), five, vec![[0.02, 0.0, 0.0], [-0.02, 0.01, 0.0], [0.0, -0.02, 0.03]]];
    links.into_iter().zip(points).zip(shares).map(|((link, points), carries)| Sole { link, points, carries }).collect()
}

#[test]
fn rows_are_the_derivative_of_the_margin() {
    let model = humanoid();
    let mut rng = rng(91);
    let mut rows = 0;
    for n in 0..40 {
        let q = model.random_configuration(&mut rng);
        let place = Place::new(&model, &q);
        let case = stance(&feet(&model, &mut rng, n % 2 == 1), (0.01, 0.05));
        let mut task = case.build(&model);
        let w = place.write(&mut *task, &case, 0.0).unwrap();
        let v = velocity(&model, &mut rng, 1.0);
        let after = place.moved(&v, H).write(&mut *task, &case, H).unwrap();
        let before = place.moved(&v, -H).write(&mut *task, &case, -H).unwrap();
        let still = Case { rates: vec![0.0; case.rates.len()], ..case.clone() };
        let fixed = place.write(&mut *task, &still, 0.0).unwrap();
        for i in 0..w.margins.len() {
            // A point may become a corner, or another edge may end elsewhere, within the step.
            if ![&w, &after, &before].iter().all(|w| w.margins[i].is_finite()) {
                continue;
            }
            rows += 1;
            let numeric = (after.margins[i] - before.margins[i]) / (2.0 * H);
            // lower = -φ h - what the margin does by itself, so that J v - lower - φ h is its derivative.
            let expected = w.rate(i, &v) - w.lower[i] - 4.0 * w.margins[i];
            let name = &task.rows()[i].name;
            assert!((numeric - expected).abs() < 5e-6 * (1.0 + numeric.abs()), "{name}: {numeric} and {expected}");
            assert_eq!(w.upper[i], f64::INFINITY);
            assert!((fixed.lower[i] + 4.0 * fixed.margins[i]).abs() < 1e-12, "{name}: a drift without rates");
        }
    }
    assert!(rows > 200, "{rows}");
}

#[test]
fn the_row_of_feet_that_stand_is_that_of_the_centre_of_mass_along_the_normal() {
    let model = humanoid();
    let mut q = model.neutral();
    q[2] = 0.79;
    let place = Place::new(&model, &q);
    let sole =
        |name: &str| Sole { link: model.link(name).unwrap(), points: rectangle(0.17, 0.06), carries: (1.0, 0.0) };
    let case = stance(&[sole("left_sole"), sole("right_sole")], (0.02, 0.0));
    let mut task = case.build(&model);
    let w = place.write(&mut *task, &case, 0.0).unwrap();
    let com = center_of_mass(&model, &place.data);
    let (left, right) = (place.point(model.link("left_sole").unwrap()), place.point(model.link("right_sole").unwrap()));
    // Both soles are parallel: a rectangle around both.
    let around = [left.x + 0.085 - com.x, com.x - left.x + 0.085, left.y + 0.03 - com.y, com.y - right.y + 0.03];
    let mut expected = around.map(|d| d - 0.02).to_vec();
    let mut found: Vec<f64> = w.margins.iter().copied().filter(|m| m.is_finite()).collect();
    expected.sort_by(f64::total_cmp);
    found.sort_by(f64::total_cmp);
    assert_eq!(found.len(), 4);
    assert!(expected.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-9), "{expected:?} {found:?}");
    // Without the right foot, the left one alone.
    let case = stance(&[sole("left_sole"), Sole { carries: (0.0, 0.0), ..sole("right_sole") }], (0.02, 0.0));
    let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
    assert_eq!(
        w.margins.iter().map(|m| m.is_finite()).collect::<Vec<_>>(),
        [true, true, true, true, false, false, false, false]
    );
    let inner = w.margins.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((inner - (com.y - left.y + 0.03 - 0.02)).abs() < 1e-9, "{inner}");
}

/// Depth of a point below the lines through pairs of points that have all points on one side: negative outside of the hull.
fn depth(points: &[Vector2<f64>], p: &Vector2<f64>) -> f64 {
    let mut least = f64::INFINITY;
    for (i, a) in points.iter().enumerate() {
        for (k, b) in points.iter().enumerate() {
            let along = b - a;
            if i == k || along.norm() < 1e-9 {
                continue;
            }
            let height = |c: &Vector2<f64>| along.perp(&(c - a)) / along.norm();
            if points.iter().all(|c| height(c) >= -1e-9) {
                least = least.min(height(p));
            }
        }
    }
    least
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_smallest_margin_is_the_depth_in_the_hull(seed in 0u64..1_000_000, left in 0.0..1.0f64, right in 0.0..1.0f64) {
        let model = humanoid();
        let mut rng = rng(seed);
        let q = model.random_configuration(&mut rng);
        let place = Place::new(&model, &q);
        let mut feet = feet(&model, &mut rng, false);
        (feet[0].carries, feet[1].carries, feet[2].carries) = ((left.max(1e-3), 0.0), (right, 0.0), (0.0, 0.0));
        let case = stance(&feet, (0.0, 0.0));
        let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
        let found = w.margins.iter().copied().fold(f64::INFINITY, f64::min);

        // The polygon by its definition.
        let world = |f: &Sole| {
            let pose = place.data.pose(f.link);
            f.points.iter().map(|p| (pose * Point3::from(*p)).coords).collect::<Vec<Vector3<f64>>>()
        };
        let middle = |f: &Sole| world(f).iter().sum::<Vector3<f64>>() / f.points.len() as f64;
        let weight: f64 = feet.iter().map(|f| f.carries.0).sum();
        let center = feet.iter().map(|f| middle(f) * f.carries.0).sum::<Vector3<f64>>() / weight;
        let drawn: Vec<Vector2<f64>> =
            feet.iter().flat_map(|f| world(f).into_iter().map(|p| (center + (p - center) * f.carries.0).xy())).collect();
        let com = center_of_mass(&model, &place.data).xy();
        let expected = depth(&drawn, &com);
        prop_assert!((found - expected).abs() < 1e-6, "{found} and {expected}");
    }

    /// Along a way of the robot and of the shares, the smallest margin never jumps, also where the hull changes.
    #[test]
    fn the_smallest_margin_has_no_jump(seed in 0u64..1_000_000) {
        let model = humanoid();
        let mut rng = rng(seed);
        let mut place = Place::new(&model, &model.random_configuration(&mut rng));
        let v = velocity(&model, &mut rng, 1.0);
        let mut feet = feet(&model, &mut rng, false);
        feet[1].carries = (0.0, 1.0);
        let case = stance(&feet, (0.0, 0.0));
        let mut task = case.build(&model);
        let mut last: Option<(f64, Vec<bool>)> = None;
        let mut changes = 0;
        for step in 0..200 {
            let w = place.write(&mut *task, &case, f64::from(step) * 5e-3).unwrap();
            let least = w.margins.iter().copied().fold(f64::INFINITY, f64::min);
            let corners: Vec<bool> = w.margins.iter().map(|m| m.is_finite()).collect();
            if let Some((before, old)) = last {
                changes += usize::from(old != corners);
                // Edges turn, so far away from an edge the distance from its line is fast.
                prop_assert!((least - before).abs() < 0.15, "step {step}: {before} and {least}");
            }
            last = Some((least, corners));
            place = place.moved(&v, 5e-3);
        }
        prop_assert!(changes > 0);
    }
}

#[test]
fn bad_feet_are_refused() {
    let model = humanoid();
    let link = model.link("left_sole").unwrap();
    let refused = |feet: &[Sole]| {
        stance(feet, (0.0, 0.0))
            .build_for(&model, 0.01, &vec![1.0; model.nv()])
            .err()
            .map(|e| (e.param, e.message))
            .unwrap()
    };
    let (param, text) =
        refused(&[Sole { link, points: vec![[0.0; 3], [0.1, 0.1, 0.0], [0.2, 0.2, 0.0]], carries: (1.0, 0.0) }]);
    assert_eq!(param, "feet.foot_0.points");
    assert!(text.contains("on one line"), "{text}");
    let (param, text) = refused(&[Sole { link, points: rectangle(0.1, 0.1), carries: (0.0, 0.0) }]);
    assert_eq!(param, "feet");
    assert!(text.contains("no foot carries"), "{text}");
    // While a machine runs, this is a fault.
    let case = stance(&[Sole { link, points: rectangle(0.1, 0.1), carries: (1.0, -1.0) }], (0.0, 0.0));
    let place = Place::new(&model, &model.neutral());
    assert!(place.write(&mut *case.build(&model), &case, 1.0).is_err());
}
