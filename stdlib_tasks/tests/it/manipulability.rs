//! Manipulability against the singular values of the Jacobian, its row against central differences, on arms, bases,
//! sliding, mimicking and locked joints; values that can be checked by hand; singularities.

use hierarq_stdlib_tasks::dimension::NONE;
use hierarq_stdlib_tasks::expression::{Evaluation, Expression, Leaf, Manipulability, MotionPart, Op};
use nalgebra::DMatrix;
use robot::{Base, LinkId, Model, Options};

use crate::common::*;

const PARTS: [MotionPart; 3] = [MotionPart::Whole, MotionPart::Linear, MotionPart::Angular];

/// A chain with a sliding joint and a joint that mimics another one, on a stick.
const SLIDING: &str = r#"<robot name="crane">
  <link name="root"/>
  <joint name="turn" type="revolute"><parent link="root"/><child link="column"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <link name="column"/>
  <joint name="lift" type="prismatic"><origin xyz="0 0.1 0.2" rpy="0.1 0.2 0.3"/><parent link="column"/><child link="boom"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <link name="boom"/>
  <joint name="a" type="revolute"><origin xyz="0.3 0 0.1"/><parent link="boom"/><child link="one"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <link name="one"/>
  <joint name="follower" type="revolute"><origin xyz="0.3 0.05 0"/><parent link="one"/><child link="two"/><axis xyz="1 0 0.5"/>
    <limit lower="-9" upper="9" velocity="9" effort="1"/><mimic joint="a" multiplier="-1.5" offset="0.2"/></joint>
  <link name="two"/>
  <joint name="b" type="revolute"><origin xyz="0.2 0 0.1" rpy="0.4 0 0"/><parent link="two"/><child link="three"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <link name="three"/>
  <joint name="c" type="continuous"><origin xyz="0.1 0.1 0.1"/><parent link="three"/><child link="four"/><axis xyz="1 1 0"/>
    <limit velocity="1" effort="1"/></joint>
  <link name="four"/>
  <joint name="d" type="prismatic"><origin xyz="0.1 0 0.1"/><parent link="four"/><child link="five"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <link name="five"/>
  <joint name="e" type="revolute"><origin xyz="0.1 0.2 0.1" rpy="0 0.7 0"/><parent link="five"/><child link="tool"/><axis xyz="0 1 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <link name="tool"/>
</robot>"#;

fn leaf(model: &Model, link: LinkId, part: MotionPart, dofs: Option<Vec<usize>>) -> Evaluation {
    let dofs = dofs.unwrap_or_else(|| (0..model.nv()).collect());
    let leaves = vec![Leaf::Manipulability(Box::new(Manipulability { link, part, dofs }))];
    let e = Expression { ops: vec![Op::State(0)], inputs: Vec::new(), leaves, outputs: vec![0], dimension: NONE };
    e.check(model, 0).unwrap();
    Evaluation::new(&e, model)
}

fn value(place: &Place, e: &mut Evaluation) -> f64 {
    e.forward(&place.state(&[], &[])).unwrap();
    e.value(0)
}

fn row(place: &Place, e: &mut Evaluation) -> Vec<f64> {
    value(place, e);
    let mut row = vec![0.0; place.model.nv()];
    e.add_row(&place.state(&[], &[]), &[1.0], &mut row);
    row
}

/// The product of the singular values of the counted columns.
fn reference(place: &Place, link: LinkId, part: MotionPart, dofs: &[usize]) -> f64 {
    let mut j = DMatrix::zeros(6, place.model.nv());
    place.data.jacobian(place.model, link, &place.point(link), &mut j);
    let rows = match part {
        MotionPart::Whole => 0..6,
        MotionPart::Linear => 0..3,
        MotionPart::Angular => 3..6,
    };
    let counted = j.select_columns(dofs).rows_range(rows).into_owned();
    counted.singular_values().iter().product()
}

/// Robots with a frame each.
fn cases() -> Vec<(Model, LinkId)> {
    let mut all: Vec<(Model, LinkId)> =
        robots().into_iter().map(|m| (arms(&m)[0].tip, m)).map(|(l, m)| (m, l)).collect();
    for base in [Base::Fixed, Base::Planar, Base::Unicycle, Base::Floating] {
        let model = read(SLIDING, base);
        let tool = model.link("tool").unwrap();
        all.push((model, tool));
    }
    let locked = Options { lock: [("lift".to_string(), 0.3)].into(), ..Options::default() };
    let model = Model::from_urdf(SLIDING, &locked).unwrap().0;
    let tool = model.link("tool").unwrap();
    all.push((model, tool));
    all
}

#[test]
fn it_is_the_product_of_the_singular_values() {
    let mut rng = rng(21);
    for (model, link) in cases() {
        for _ in 0..10 {
            let place = Place::new(&model, &model.random_configuration(&mut rng));
            let every: Vec<usize> = (0..model.nv()).collect();
            let some: Vec<usize> = every.iter().copied().filter(|_| rng() < 0.8).collect();
            for (part, dofs) in PARTS.into_iter().flat_map(|p| [(p, every.clone()), (p, some.clone())]) {
                let w = value(&place, &mut leaf(&model, link, part, Some(dofs.clone())));
                let expected = if dofs.len() < part.size() { 0.0 } else { reference(&place, link, part, &dofs) };
                assert!((w - expected).abs() < 1e-12 * (1.0 + expected), "{part:?}: {w} and {expected}");
            }
        }
    }
}

#[test]
fn its_row_is_its_derivative() {
    let mut rng = rng(22);
    let mut largest: f64 = 0.0;
    for (model, link) in cases() {
        for q in configurations(&model, 6, &mut rng) {
            let place = Place::new(&model, &q);
            let some: Vec<usize> = (0..model.nv()).filter(|_| rng() < 0.8).collect();
            for (part, dofs) in PARTS.into_iter().flat_map(|p| [(p, None), (p, Some(some.clone()))]) {
                let mut e = leaf(&model, link, part, dofs);
                let w = value(&place, &mut e);
                // At a singularity the value has a corner, and close to one differences cut it off.
                if w < 1e-4 {
                    continue;
                }
                let row = row(&place, &mut e);
                let v = velocity(&model, &mut rng, 1.0);
                let h = 1e-6;
                let (before, after) = (value(&place.moved(&v, -h), &mut e), value(&place.moved(&v, h), &mut e));
                let rate = (after - before) / (2.0 * h);
                let from_row: f64 = row.iter().zip(&v).map(|(a, b)| a * b).sum();
                largest = largest.max(from_row.abs());
                assert!((rate - from_row).abs() < 2e-7 * (1.0 + from_row.abs()), "{part:?}: {rate} and {from_row}");
                // The pose of a base changes nothing.
                assert!(row[..model.root_base().nv()].iter().all(|x| x.abs() < 1e-10), "{row:?}");
            }
        }
    }
    assert!(largest > 0.1, "no value moved");
}

/// Two bars of length 1 in a plane with a third, sliding axis across it: w = |sin q2|, as for Yoshikawa's two bars.
#[test]
fn two_bars_have_the_sine_of_the_elbow() {
    let urdf = r#"<robot name="bars"><link name="r"/>
      <joint name="q0" type="prismatic"><parent link="r"/><child link="x"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint><link name="x"/>
      <joint name="q1" type="revolute"><parent link="x"/><child link="a"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint><link name="a"/>
      <joint name="q2" type="revolute"><origin xyz="1 0 0"/><parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint><link name="b"/>
      <joint name="end" type="fixed"><origin xyz="1 0 0"/><parent link="b"/><child link="tip"/></joint><link name="tip"/></robot>"#;
    let model = read(urdf, Base::Fixed);
    let tip = model.link("tip").unwrap();
    for elbow in [-2.0, -0.5, 0.3, 1.0, 2.5_f64] {
        let place = Place::new(&model, &[0.1, 0.7, elbow]);
        let mut e = leaf(&model, tip, MotionPart::Linear, None);
        assert!((value(&place, &mut e) - elbow.sin().abs()).abs() < 1e-14);
        let row = row(&place, &mut e);
        assert!(row[0].abs() < 1e-14 && row[1].abs() < 1e-14);
        assert!((row[2] - elbow.cos() * elbow.sin().signum()).abs() < 1e-13);
    }
    // Stretched: no value, no direction, no NaN.
    let place = Place::new(&model, &[0.1, 0.7, 0.0]);
    let mut e = leaf(&model, tip, MotionPart::Linear, None);
    assert_eq!((value(&place, &mut e), row(&place, &mut e)), (0.0, vec![0.0; 3]));
    // A hair beside it, the derivative is still exact.
    let place = Place::new(&model, &[0.1, 0.7, 1e-9]);
    let row = row(&place, &mut e);
    assert!((value(&place, &mut e) - 1e-9).abs() < 1e-15 && (row[2] - 1.0).abs() < 1e-6, "{row:?}");
}

#[test]
fn a_foot_without_joints_has_none() {
    let model = arm7();
    let mut e = leaf(&model, LinkId(0), MotionPart::Linear, None);
    assert_eq!(value(&Place::new(&model, &model.neutral()), &mut e), 0.0);
    assert!(row(&Place::new(&model, &model.neutral()), &mut e).iter().all(|x| *x == 0.0));
}
