//! Rows and Jacobians against central differences of the poses (four points, fourth
//! order), on random trees.

use hierarq_robot::{Base, Data, LinkId};
use nalgebra::{DMatrix, Vector3};
use proptest::prelude::*;

use crate::common::{base, load, rng, tree, vector};

const STEP: f64 = 1e-4;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn jacobian_is_the_derivative_of_the_pose(text in tree(), base in base(), seed in any::<u64>()) {
        let model = load(&text, base);
        let mut rng = rng(seed);
        let q = model.random_configuration(&mut rng);
        let mut at = Data::new(&model);
        model.forward(&q, &mut at);
        let r_L = vector(&mut rng, 0.5);
        let nv = model.nv();
        let mut J = DMatrix::zeros(6, nv);
        for dof in 0..nv {
            let mut v = vec![0.0; nv];
            v[dof] = 1.0;
            let pose_at = |steps: f64| {
                let (mut q, mut data) = (q.clone(), Data::new(&model));
                model.integrate(&mut q, &v, steps * STEP);
                model.forward(&q, &mut data);
                data
            };
            let [far, near, ahead, beyond] = [-2.0, -1.0, 1.0, 2.0].map(pose_at);
            // Odd in the step, so that 8 times the near one less the far one leaves order four.
            let slope = |near: Vector3<f64>, far: Vector3<f64>| (near * 8.0 - far) / (12.0 * STEP);
            for l in 0..model.links.len() as u32 {
                let link = LinkId(l);
                let p = |d: &Data| d.pose(link).transform_point(&r_L.into()).coords;
                let turn = |to: &Data, from: &Data| {
                    (to.pose(link).rotation * from.pose(link).rotation.inverse()).scaled_axis()
                };
                let linear = slope(p(&ahead) - p(&near), p(&beyond) - p(&far));
                let angular = slope(turn(&ahead, &near), turn(&beyond, &far));
                at.jacobian(&model, link, &p(&at), &mut J);
                let column = J.column(dof);
                prop_assert!((column.fixed_rows::<3>(0) - linear).norm() < 1e-9, "{column} {linear}");
                prop_assert!((column.fixed_rows::<3>(3) - angular).norm() < 1e-9, "{column} {angular}");
            }
        }
    }

    #[test]
    fn rows_and_velocities_agree_with_the_jacobian(text in tree(), base in base(), seed in any::<u64>()) {
        let model = load(&text, base);
        let mut rng = rng(seed);
        let q = model.random_configuration(&mut rng);
        let mut data = Data::new(&model);
        model.forward(&q, &mut data);
        let nv = model.nv();
        let v: Vec<f64> = (0..nv).map(|_| rng() - 0.5).collect();
        let v_column = DMatrix::from_column_slice(nv, 1, &v);
        let mut J = DMatrix::zeros(6, nv);
        for l in 0..model.links.len() as u32 {
            let link = LinkId(l);
            let (p, n, m) = (vector(&mut rng, 1.0), vector(&mut rng, 1.0), vector(&mut rng, 1.0));
            data.jacobian(&model, link, &p, &mut J);
            let twist = &J * &v_column;
            let linear = data.point_velocity(&model, link, &p, &v);
            let angular = data.angular_velocity(&model, link, &v);
            prop_assert!((twist.fixed_rows::<3>(0) - linear).norm() < 1e-12);
            prop_assert!((twist.fixed_rows::<3>(3) - angular).norm() < 1e-12);
            // Rows are added to what is there, and padding is left alone.
            let mut point = vec![0.25; nv + 3];
            let (mut axis, mut wrench) = (point.clone(), point.clone());
            data.add_point(&model, link, &p, &n, &mut point);
            data.add_angular(&model, link, &m, &mut axis);
            data.add_wrench(&model, link, &n, &(p.cross(&n) + m), &mut wrench);
            for i in 0..nv {
                let column = J.column(i);
                let along = n.dot(&column.fixed_rows::<3>(0));
                let about = m.dot(&column.fixed_rows::<3>(3));
                prop_assert!((point[i] - 0.25 - along).abs() < 1e-12);
                prop_assert!((axis[i] - 0.25 - about).abs() < 1e-12);
                prop_assert!((wrench[i] - 0.25 - along - about).abs() < 1e-12);
            }
            for row in [&point, &axis, &wrench] {
                prop_assert_eq!(&row[nv..], &[0.25; 3]);
            }
            // Joints outside the support do not move the link.
            for dof in 0..nv {
                if model.support(link).iter().all(|s| s.dof as usize != dof) {
                    prop_assert_eq!(J.column(dof).norm(), 0.0);
                }
            }
        }
    }
}

#[test]
fn pose_and_rotation_are_one() {
    let text = include_str!("arm.urdf");
    let model = load(text, Base::Floating);
    let mut rng = rng(3);
    let mut data = Data::new(&model);
    for _ in 0..20 {
        let mut q = model.random_configuration(&mut rng);
        // An estimator's quaternion may be off by a little.
        q[3..7].iter_mut().for_each(|x| *x *= 1.001);
        model.forward(&q, &mut data);
        for l in 0..model.links.len() as u32 {
            let (X, R) = (data.pose(LinkId(l)), data.rotation(LinkId(l)));
            let u = vector(&mut rng, 1.0);
            assert!((X.rotation * u - R * u).norm() < 1e-14);
            assert!((R.transpose() * R - nalgebra::Matrix3::identity()).norm() < 1e-14);
        }
    }
}

#[test]
fn a_point_on_the_axis_does_not_move() {
    let model = load(include_str!("arm.urdf"), Base::Fixed);
    let mut data = Data::new(&model);
    let q = model.random_configuration(&mut rng(5));
    model.forward(&q, &mut data);
    let elbow = model.link("forearm").unwrap();
    let mut row = vec![0.0; model.nv()];
    let p = *data.position(elbow);
    data.add_point(&model, elbow, &p, &Vector3::new(0.3, -0.4, 0.5), &mut row);
    assert!(row[model.dof("elbow").unwrap()].abs() < 1e-15);
    assert!(row[model.dof("shoulder").unwrap()].abs() > 1e-3);
}
