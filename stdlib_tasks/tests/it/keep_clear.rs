//! Rows of obstacles: the total derivative of the margin while robot and obstacles move, of all forms; nearest pairs;
//! absent obstacles.

use hierarq_stdlib_tasks::bound::{Bound, Geometry, Obstacle, Slot};
use hierarq_stdlib_tasks::obstacle::Form;
use hierarq_stdlib_tasks::task::TaskFault;
use nalgebra::{Isometry3, Vector3};
use robot::{Base, Hull, LinkId, Shape, Soup};

use crate::common::*;
use crate::limits::{middle, shaped};

const H: f64 = 1e-6;

/// Forms of all kinds, each placed somewhere in the obstacle's frame.
fn forms(rng: &mut impl FnMut() -> f64) -> Vec<(&'static str, Form)> {
    let turn = rotation(rng);
    let mut placed = |shape| Form::Shape(Isometry3::from_parts(vector(rng, 0.1).into(), rotation(rng)), shape);
    let corners: Vec<Vector3<f64>> = (0..40)
        .map(|i| {
            let a = f64::from(i) * 2.4;
            Vector3::new(0.1 * a.cos(), 0.2 * a.sin(), 0.15 * (a * 0.7).sin())
        })
        .collect();
    vec![
        ("ball", placed(Shape::Sphere { radius: 0.1 })),
        ("rod", placed(Shape::Capsule { radius: 0.05, half_length: 0.2 })),
        ("block", placed(Shape::Box { half: [0.1, 0.2, 0.15] })),
        ("drum", placed(Shape::Cylinder { radius: 0.1, half_length: 0.2 })),
        ("stone", placed(Shape::Hull(Hull::around(&corners).unwrap().1))),
        ("floor", Form::HalfSpace(turn)),
        ("cloud", Form::Soup(soup(60, 1, 0.02, rng))),
        ("sheet", Form::Soup(soup(20, 3, 0.0, rng))),
        ("pieces", Form::Soup(soup(6, 20, 0.0, rng))),
    ]
}

/// Elements of some corners within half a metre.
fn soup(count: usize, corners: usize, radius: f64, rng: &mut impl FnMut() -> f64) -> Soup {
    let mut element = |_| {
        let middle = vector(rng, 0.4);
        (0..corners).map(|_| middle + vector(rng, 0.1)).collect::<Vec<_>>()
    };
    Soup::new(&(0..count).map(&mut element).collect::<Vec<_>>(), radius).unwrap()
}

/// Adds an obstacle that moves and turns.
fn obstacle(
    case: &mut Case,
    (name, form): (&str, Form),
    link: Option<LinkId>,
    at: Vector3<f64>,
    rng: &mut impl FnMut() -> f64,
) -> Obstacle {
    let q = rotation(rng);
    let position = case.slot(at.as_slice(), vector(rng, 0.5).as_slice());
    let orientation = case.slot(&[q.w, q.i, q.j, q.k], vector(rng, 0.5).push(rng() - 0.5).as_slice());
    Obstacle { name: name.to_string(), form, link, position, orientation, present: None }
}

fn case(parts: Vec<Geometry>, obstacles: impl FnOnce(&mut Case) -> Vec<Obstacle>) -> Case {
    let mut case = Case::new("keep_clear");
    let of = obstacles(&mut case);
    case.with("links", Bound::Geometries(parts))
        .with("of", Bound::Obstacles(of))
        .moving("d_min", &[0.05], &[0.1])
        .number("gain", &[7.0])
        .number("sampled_margin", &[0.01])
}

#[test]
fn rows_are_the_derivative_of_the_margin_while_everything_moves() {
    let mut rng = rng(41);
    let (mut checked, mut of_spots) = (0, 0);
    for model in robots() {
        let [left, right] = arms(&model);
        for q in configurations(&model, 6, &mut rng).iter().skip(3) {
            let place = Place::new(&model, q);
            let parts = vec![
                point(left.tip, &mut rng),
                shaped("ball", right.tip, Shape::Sphere { radius: 0.04 }, &mut rng),
                shaped("rod", left.tip, Shape::Capsule { radius: 0.03, half_length: 0.08 }, &mut rng),
                shaped("cube", left.tip, Shape::Box { half: [0.05, 0.08, 0.03] }, &mut rng),
                shaped("can", right.tip, Shape::Cylinder { radius: 0.04, half_length: 0.07 }, &mut rng),
            ];
            for link in [None, Some(middle(&model))] {
                let forms = forms(&mut rng);
                let case = case(parts.clone(), |case| {
                    let place = |form| (form, vector(&mut rng, 1.5));
                    let all: Vec<_> = forms.into_iter().map(place).collect();
                    all.into_iter().map(|(form, at)| obstacle(case, form, link, at, &mut rng)).collect()
                });
                let mut task = case.build(&model);
                let Ok(w) = place.write(&mut *task, &case, 0.0) else { continue };
                let v = velocity(&model, &mut rng, 1.0);
                let names: Vec<String> = task.rows().into_iter().map(|r| r.name).collect();
                for (i, name) in names.iter().enumerate() {
                    // Pairs that touch or overlap lean on the last direction, or on a face.
                    if w.margins[i] < 0.05 && !name.ends_with("floor") {
                        continue;
                    }
                    let spots = ["cloud", "sheet", "pieces"].iter().any(|form| name.contains(form));
                    // Round bodies against bodies are approached, up to 1e-10.
                    let step = if name.contains("can") || name.contains("drum") { 3e-5 } else { H };
                    let after = place.moved(&v, step).write(&mut *task, &case, step).unwrap();
                    let before = place.moved(&v, -step).write(&mut *task, &case, -step).unwrap();
                    // A spot that is absent now or then, or gives way to another one.
                    let all = [before.margins[i], w.margins[i], after.margins[i]];
                    let jumps = (all[0] - 2.0 * all[1] + all[2]).abs() > 1e-6;
                    if spots && (all.iter().any(|h| !h.is_finite()) || jumps) {
                        continue;
                    }
                    of_spots += usize::from(spots);
                    let numeric = (after.margins[i] - before.margins[i]) / (2.0 * step);
                    let expected = w.rate(i, &v) - (w.lower[i] + 7.0 * (w.margins[i] - 0.01));
                    assert!((numeric - expected).abs() < 2e-5, "{name}: {numeric} and {expected}");
                    assert_eq!(w.upper[i], f64::INFINITY, "{name}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 500 && of_spots > 100, "{checked}, {of_spots}");
}

/// A robot, and obstacles at rest on a line.
fn line(present: Option<f64>, nearest: Option<f64>) -> (robot::Model, Case) {
    let model = arm7();
    let part = Geometry::point("tip", model.link("tool").unwrap(), Vector3::zeros());
    let mut case = case(vec![part], |case| {
        let one = |case: &mut Case, i: usize| {
            let position = case.slot(&[1.0 + i as f64, 0.0, 0.5], &[0.0; 3]);
            let orientation = case.slot(&[1.0, 0.0, 0.0, 0.0], &[0.0; 4]);
            let present = present.map(|x| case.slot(&[if i == 0 { x } else { 1.0 }], &[0.0]));
            let form = Form::Shape(Isometry3::identity(), Shape::Sphere { radius: 0.1 });
            Obstacle { name: format!("o{i}"), form, link: None, position, orientation, present }
        };
        (0..5).map(|i| one(case, i)).collect()
    });
    if let Some(n) = nearest {
        case = case.number("nearest", &[n]);
    }
    (model, case)
}

#[test]
fn the_nearest_pairs_have_the_rows_that_they_have_among_all() {
    let mut rng = rng(42);
    let (model, all) = line(None, None);
    let (_, few) = line(None, Some(2.0));
    for _ in 0..50 {
        let place = Place::new(&model, &model.random_configuration(&mut rng));
        let whole = place.write(&mut *all.build(&model), &all, 0.0).unwrap();
        let part = place.write(&mut *few.build(&model), &few, 0.0).unwrap();
        let mut order: Vec<usize> = (0..5).collect();
        order.sort_by(|a, b| whole.margins[*a].total_cmp(&whole.margins[*b]));
        let mut nearest = order[..2].to_vec();
        nearest.sort_unstable();
        assert_eq!(part.margins.len(), 2);
        for (row, pair) in nearest.into_iter().enumerate() {
            assert_eq!(part.margins[row], whole.margins[pair]);
            assert_eq!(part.lower[row], whole.lower[pair]);
            assert_eq!(part.j.row(row), whole.j.row(pair));
        }
    }
}

#[test]
fn an_absent_obstacle_has_no_row() {
    let (model, case) = line(Some(-1.0), None);
    let place = Place::new(&model, &model.neutral());
    let w = place.write(&mut *case.build(&model), &case, 0.0).unwrap();
    assert_eq!((w.margins[0], w.lower[0]), (f64::INFINITY, f64::NEG_INFINITY));
    assert!(w.j.row(0).iter().all(|x| *x == 0.0));
    assert!(w.margins[1].is_finite() && w.lower[1].is_finite());
    // Nothing is known of where an absent obstacle is.
    let mut unknown = case.clone();
    let Bound::Obstacles(of) = &case.params["of"] else { unreachable!() };
    unknown.values[of[0].position.at] = f64::NAN;
    assert!(place.write(&mut *unknown.build(&model), &unknown, 0.0).is_ok());
    let (_, mut here) = line(Some(1.0), None);
    here.values[of[0].position.at] = f64::NAN;
    let fault = place.write(&mut *here.build(&model), &here, 0.0).err();
    assert_eq!(fault, Some(TaskFault::NotFinite { row: 0 }));
}

#[test]
fn inside_an_obstacle_the_last_way_out_holds_and_without_one_there_is_a_fault() {
    let model = canopies(Base::Fixed);
    let tip = arms(&model)[0].tip;
    let rod = Geometry {
        name: "rod".to_string(),
        link: tip,
        origin: Isometry3::identity(),
        shape: Shape::Capsule { radius: 0.02, half_length: 0.1 },
    };
    let place = Place::new(&model, &model.neutral());
    let at = place.point(tip);
    let mut slot = Slot { at: 0, len: 3 };
    let mut case = case(vec![rod], |case| {
        let position = case.slot((at + Vector3::new(0.0, 0.0, 1.0)).as_slice(), &[0.0; 3]);
        slot = position;
        let orientation = case.slot(&[1.0, 0.0, 0.0, 0.0], &[0.0; 4]);
        let form = Form::Shape(Isometry3::identity(), Shape::Box { half: [0.3; 3] });
        vec![Obstacle { name: "box".to_string(), form, link: None, position, orientation, present: None }]
    });
    let mut task = case.build(&model);
    let outside = place.write(&mut *task, &case, 0.0).unwrap();
    case.values[slot.at + 2] -= 1.0;
    let inside = place.write(&mut *task, &case, 0.0).unwrap();
    assert_eq!(inside.j, outside.j);
    assert!((inside.margins[0] + 0.02 + 0.05).abs() < 1e-12 && inside.lower[0] > 0.0);
    let mut new = case.build(&model);
    assert_eq!(place.write(&mut *new, &case, 0.0).err(), Some(TaskFault::Overlap { row: 0 }));
}

/// Each row of a cloud is that of a ball in place of its point, and the first is the nearest of all.
#[test]
fn rows_of_a_cloud_are_those_of_its_points() {
    let mut rng = rng(43);
    let model = arm7();
    let rod = shaped("rod", model.link("tool").unwrap(), Shape::Capsule { radius: 0.03, half_length: 0.1 }, &mut rng);
    let cloud = soup(500, 1, 0.02, &mut rng);
    let balls: Vec<Vector3<f64>> = (0..cloud.len()).map(|i| cloud.corners(i)[0]).collect();
    let still = |case: &mut Case, at: &Vector3<f64>, form: Form| {
        let (position, orientation) =
            (case.slot(at.as_slice(), &[0.0; 3]), case.slot(&[1.0, 0.0, 0.0, 0.0], &[0.0; 4]));
        Obstacle { name: "o".to_string(), form, link: None, position, orientation, present: None }
    };
    let ball = |case: &mut Case, p: &Vector3<f64>| {
        still(case, p, Form::Shape(Isometry3::identity(), Shape::Sphere { radius: 0.02 }))
    };
    let whole = case(vec![rod.clone()], |case| vec![still(case, &Vector3::zeros(), Form::Soup(cloud.clone()))]);
    let each = case(vec![rod], |case| balls.iter().map(|p| ball(case, p)).collect());
    let mut spots = 0;
    for _ in 0..100 {
        let place = Place::new(&model, &model.random_configuration(&mut rng));
        let (Ok(whole), Ok(each)) =
            (place.write(&mut *whole.build(&model), &whole, 0.0), place.write(&mut *each.build(&model), &each, 0.0))
        else {
            continue;
        };
        let least = each.margins.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((whole.margins[0] - least).abs() < 1e-12);
        for row in 0..4 {
            if !whole.margins[row].is_finite() {
                assert!(row > 0 && whole.lower[row] == f64::NEG_INFINITY);
                continue;
            }
            let same = (0..balls.len()).find(|i| (each.margins[*i] - whole.margins[row]).abs() < 1e-12).unwrap();
            assert!((whole.lower[row] - each.lower[same]).abs() < 1e-9);
            let difference =
                (0..model.nv()).map(|j| (whole.j.row(row)[j] - each.j.row(same)[j]).abs()).fold(0.0, f64::max);
            assert!(difference < 1e-9, "{difference}");
            spots += 1;
        }
    }
    assert!(spots > 200, "{spots}");
}
