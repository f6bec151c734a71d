//! Several robots in one model: poses, Jacobians and masses are those of each robot alone.

use hierarq_robot::{Base, Data, JointId, LinkId, MergeError, Model, Placed, contacts};
use nalgebra::{DMatrix, Isometry3, Vector3};
use proptest::prelude::*;

use crate::common::{base, load, pose, rng, tree, vector};

const ARM: &str = include_str!("arm.urdf");
const WORKCELL: &str = include_str!("workcell.urdf");

fn two<'m>(a: &'m Model, b: &'m Model, at: [Isometry3<f64>; 2]) -> [Placed<'m>; 2] {
    let [at_a, at_b] = at;
    [Placed { model: a, prefix: "a_", at: at_a }, Placed { model: b, prefix: "b_", at: at_b }]
}

/// Mass and centre of mass in the world.
fn balance(model: &Model, data: &Data) -> (f64, Vector3<f64>) {
    let weighed = |l: usize| {
        let link = &model.links[l];
        (data.pose(LinkId(l as u32)) * nalgebra::Point3::from(link.center_of_mass)).coords * link.mass
    };
    let mass = model.links.iter().map(|l| l.mass).sum::<f64>();
    (mass, (0..model.links.len()).map(weighed).sum::<Vector3<f64>>())
}

/// Compares a merged model with its robots at a random configuration.
fn same_as_alone(robots: &[Placed], seed: u64) {
    let mut rng = rng(seed);
    let (model, merged) = Model::merged("both", robots).unwrap();
    let q: Vec<f64> = robots.iter().flat_map(|r| r.model.random_configuration(&mut rng)).collect();
    let nv = robots.iter().map(|r| r.model.nv()).sum::<usize>();
    assert_eq!((model.nq(), model.nv()), (q.len(), nv));
    let mut data = Data::new(&model);
    model.forward(&q, &mut data);
    let (mut sum, mut moment) = (0.0, Vector3::zeros());
    for (placed, merged) in robots.iter().zip(&merged) {
        let alone = placed.model;
        let of_robot = &q[merged.first_coordinate..merged.first_coordinate + alone.nq()];
        let mut own = Data::new(alone);
        alone.forward(of_robot, &mut own);
        for l in 0..alone.links.len() {
            let (link, there) = (LinkId(l as u32), merged.link(LinkId(l as u32)));
            assert_eq!(model.link_ref(there).name, format!("{}{}", placed.prefix, alone.link_ref(link).name));
            let expected = placed.at * own.pose(link);
            let apart = expected.inv_mul(data.pose(there));
            assert!(apart.translation.vector.norm() < 1e-12 && apart.rotation.angle() < 1e-7, "{apart}");
            let p = vector(&mut rng, 1.0);
            let p_W = (expected * nalgebra::Point3::from(p)).coords;
            let p_own = (own.pose(link) * nalgebra::Point3::from(p)).coords;
            let (mut J, mut J_own) = (DMatrix::zeros(6, model.nv()), DMatrix::zeros(6, alone.nv()));
            data.jacobian(&model, there, &p_W, &mut J);
            own.jacobian(alone, link, &p_own, &mut J_own);
            let R = placed.at.rotation.to_rotation_matrix();
            for dof in 0..model.nv() {
                let column = J.column(dof);
                let Some(k) = dof.checked_sub(merged.first_dof).filter(|k| *k < alone.nv()) else {
                    assert_eq!(column.norm(), 0.0);
                    continue;
                };
                let own = J_own.column(k);
                let turn = |i: usize| R * Vector3::new(own[i], own[i + 1], own[i + 2]);
                let expected: Vec<f64> = turn(0).iter().chain(turn(3).iter()).copied().collect();
                assert!(column.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12), "{column} {expected:?}");
            }
        }
        for j in 0..alone.joints.len() {
            let (joint, there) = (JointId(j as u32), merged.joint(JointId(j as u32)));
            assert_eq!(model.joint_ref(there).name, format!("{}{}", placed.prefix, alone.joint_ref(joint).name));
            let (here, at) = (alone.joint_position(joint, of_robot), model.joint_position(there, &q));
            assert_eq!(here, at);
        }
        for (k, dof) in alone.dofs.iter().enumerate() {
            let there = &model.dofs[merged.dof(k)];
            assert_eq!(there.name, format!("{}{}", placed.prefix, dof.name));
            assert_eq!((there.lower, there.upper, there.velocity), (dof.lower, dof.upper, dof.velocity));
            assert_eq!((there.acceleration, there.unit), (dof.acceleration, dof.unit));
        }
        let (mass, of_own) = balance(alone, &own);
        sum += mass;
        moment += placed.at.rotation * of_own + placed.at.translation.vector * mass;
    }
    let (mass, of_all) = balance(&model, &data);
    assert!((mass - sum).abs() < 1e-12 && (of_all - moment).norm() < 1e-10);
}

proptest! {
    #[test]
    fn random_robots_move_as_alone(
        a in tree(),
        b in tree(),
        bases in prop::array::uniform2(base()),
        seed: u64,
    ) {
        let mut rng = rng(seed);
        let (a, b) = (load(&a, bases[0]), load(&b, bases[1]));
        let at = [pose(&mut rng, 2.0), pose(&mut rng, 2.0)];
        same_as_alone(&two(&a, &b, at), seed);
    }
}

#[test]
fn an_arm_and_a_cart_move_as_alone() {
    let mut rng = rng(3);
    for bases in [[Base::Fixed, Base::Planar], [Base::Unicycle, Base::Unicycle], [Base::Floating, Base::Unicycle]] {
        let (arm, cart) = (load(ARM, bases[0]), load(WORKCELL, bases[1]));
        for seed in 0..30 {
            let at = [pose(&mut rng, 2.0), pose(&mut rng, 2.0)];
            same_as_alone(&two(&arm, &cart, at), seed);
        }
    }
}

#[test]
fn columns_of_merged_robots_are_central_differences_of_their_motion() {
    let mut rng = rng(5);
    for bases in [[Base::Unicycle, Base::Fixed], [Base::Planar, Base::Unicycle], [Base::Floating, Base::Floating]] {
        let (a, b) = (load(ARM, bases[0]), load(WORKCELL, bases[1]));
        let at = [pose(&mut rng, 2.0), pose(&mut rng, 2.0)];
        let (model, _) = Model::merged("both", &two(&a, &b, at)).unwrap();
        let q = model.random_configuration(&mut rng);
        let mut data = Data::new(&model);
        model.forward(&q, &mut data);
        let mut moved = [Data::new(&model), Data::new(&model)];
        let step = 1e-6;
        for dof in 0..model.nv() {
            let mut v = vec![0.0; model.nv()];
            v[dof] = 1.0;
            for (data, dt) in moved.iter_mut().zip([step, -step]) {
                let mut q = q.clone();
                model.integrate(&mut q, &v, dt);
                model.forward(&q, data);
            }
            for link in (0..model.links.len() as u32).map(LinkId) {
                let p = Vector3::new(0.3, -0.2, 0.1);
                let at = |data: &Data| (data.pose(link) * nalgebra::Point3::from(p)).coords;
                let measured = (at(&moved[0]) - at(&moved[1])) / (2.0 * step);
                let predicted = data.point_velocity(&model, link, &at(&data), &v);
                assert!((measured - predicted).norm() < 1e-7, "{bases:?} {dof} {measured} {predicted}");
            }
        }
    }
}

#[test]
fn merged_robots_step_and_differ_as_alone() {
    let mut rng = rng(8);
    for bases in [[Base::Unicycle, Base::Planar], [Base::Floating, Base::Unicycle], [Base::Fixed, Base::Floating]] {
        let (a, b) = (load(ARM, bases[0]), load(WORKCELL, bases[1]));
        let (model, merged) = Model::merged("both", &two(&a, &b, [Isometry3::identity(); 2])).unwrap();
        let (mut q, v) = (model.random_configuration(&mut rng), vec![0.7; model.nv()]);
        let before = q.clone();
        model.integrate(&mut q, &v, 0.3);
        let mut way = vec![0.0; model.nv()];
        model.difference(&before, &q, &mut way);
        for (alone, place) in [&a, &b].into_iter().zip(&merged) {
            let own = place.first_coordinate..place.first_coordinate + alone.nq();
            let of_own = place.first_dof..place.first_dof + alone.nv();
            let mut q_own = before[own.clone()].to_vec();
            alone.integrate(&mut q_own, &v[of_own.clone()], 0.3);
            assert_eq!(q_own, q[own.clone()]);
            let mut way_own = vec![0.0; alone.nv()];
            alone.difference(&before[own], &q_own, &mut way_own);
            assert_eq!(way_own, way[of_own]);
        }
        let prefixes: Vec<&str> = model.bases.iter().map(|base| base.prefix(&model)).collect();
        let mobile = ["a_", "b_"].into_iter().zip(bases).filter(|(_, base)| *base != Base::Fixed);
        assert_eq!(prefixes, mobile.map(|(prefix, _)| prefix).collect::<Vec<_>>());
    }
}

#[test]
fn a_merged_model_is_read_again_as_it_was_written() {
    let (arm, cart) = (load(ARM, Base::Fixed), load(WORKCELL, Base::Unicycle));
    let (model, _) = Model::merged("both", &two(&arm, &cart, [Isometry3::identity(); 2])).unwrap();
    let text = serde_json::to_string(&model).unwrap();
    assert_eq!(serde_json::from_str::<Model>(&text).unwrap(), model);
    let alone = serde_json::to_string(&arm).unwrap();
    assert!(!alone.contains("roots") && !alone.contains("bases"));
    let json = serde_json::to_value(&model).unwrap();
    let stand = model.joint("b_stand").unwrap().index();
    for (at, value) in [
        ("/bases/0/kind", serde_json::json!("fixed")),
        ("/bases/0/kind", serde_json::json!("floating")),
        ("/bases/0/link", 900.into()),
        ("/bases/0/link", 0.into()),
        ("/bases/0/first_coordinate", 0.into()),
        ("/bases/0/first_dof", 0.into()),
        ("/bases/0/first_dof", serde_json::json!(usize::MAX)),
        ("/bases", serde_json::json!([])),
        (&format!("/joints/{stand}/parent"), (model.link("a_upper").unwrap().0).into()),
    ] {
        let mut broken = json.clone();
        *broken.pointer_mut(at).unwrap() = value.clone();
        assert!(serde_json::from_value::<Model>(broken).is_err(), "{at} {value}");
    }
}

#[test]
fn links_of_two_robots_are_never_neighbours() {
    let arm = load(ARM, Base::Fixed);
    let at = [Isometry3::identity(), Isometry3::translation(0.0, 0.6, 0.0)];
    let (model, merged) = Model::merged("both", &two(&arm, &arm, at)).unwrap();
    let own = contacts::pairs(&arm).len();
    let pairs = contacts::pairs(&model);
    let robots = |pair: &[LinkId; 2]| pair.map(|l| model.robot_of(l));
    for robot in 0..2 {
        assert_eq!(pairs.iter().filter(|pair| robots(pair) == [robot; 2]).count(), own);
    }
    // Every pair between them but those of two links that do not move.
    let shaped = |robot: usize, still: bool| {
        let links = (0..arm.links.len() as u32).map(|l| merged[robot].link(LinkId(l)));
        let links = links.filter(|l| !model.link_ref(*l).collision.is_empty());
        links.filter(|l| !still || model.support(*l).is_empty()).count()
    };
    let between = pairs.iter().filter(|pair| robots(pair) == [0, 1]).count();
    assert_eq!(between, shaped(0, false) * shaped(1, false) - shaped(0, true) * shaped(1, true));
    assert!(between > 0);
}

#[test]
fn robots_that_cannot_be_merged_are_told() {
    let arm = load(ARM, Base::Fixed);
    let at = [Isometry3::identity(); 2];
    let refused = |robots: &[Placed]| Model::merged("both", robots).unwrap_err();
    let mut same = two(&arm, &arm, at);
    same[1].prefix = "a_";
    let name = format!("a_{}", arm.links[0].name);
    assert_eq!(refused(&same), MergeError::Name { robot: 1, name });
}
