//! Several robots in one model: poses, Jacobians and masses are those of each robot alone.

use hierarq_robot::{Base, Data, JointId, LinkId, MergeError, Model, Placed, contacts};
use nalgebra::{DMatrix, Isometry3, Vector3};
use proptest::prelude::*;

use crate::common::{load, pose, rng, tree, vector};

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
    assert_eq!((model.nq(), model.nv()), (q.len(), q.len()));
    let mut data = Data::new(&model);
    model.forward(&q, &mut data);
    let (mut sum, mut moment) = (0.0, Vector3::zeros());
    for (placed, merged) in robots.iter().zip(&merged) {
        let alone = placed.model;
        let of_robot = &q[merged.first_dof..merged.first_dof + alone.nq()];
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
                // The base moves in its own axes alone, and in those of its place here.
                let of_base = alone.base == Base::Planar && k < 2;
                let expected: Vec<f64> = if of_base {
                    let axis = R * if k == 0 { Vector3::x() } else { Vector3::y() };
                    vec![axis.x, axis.y, axis.z, 0.0, 0.0, 0.0]
                } else {
                    let own = J_own.column(k);
                    let turn = |i: usize| R * Vector3::new(own[i], own[i + 1], own[i + 2]);
                    turn(0).iter().chain(turn(3).iter()).copied().collect()
                };
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
        bases in prop::array::uniform2(prop::sample::select(vec![Base::Fixed, Base::Planar])),
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
    let (arm, cart) = (load(ARM, Base::Fixed), load(WORKCELL, Base::Planar));
    let mut rng = rng(3);
    for seed in 0..30 {
        let at = [pose(&mut rng, 2.0), pose(&mut rng, 2.0)];
        same_as_alone(&two(&arm, &cart, at), seed);
    }
}

#[test]
fn a_merged_model_is_read_again_as_it_was_written() {
    let (arm, cart) = (load(ARM, Base::Fixed), load(WORKCELL, Base::Planar));
    let (model, _) = Model::merged("both", &two(&arm, &cart, [Isometry3::identity(); 2])).unwrap();
    let text = serde_json::to_string(&model).unwrap();
    assert_eq!(serde_json::from_str::<Model>(&text).unwrap(), model);
    assert!(!serde_json::to_string(&arm).unwrap().contains("roots"));
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
    let (arm, cart) = (load(ARM, Base::Fixed), load(WORKCELL, Base::Unicycle));
    let at = [Isometry3::identity(); 2];
    let refused = |robots: &[Placed]| Model::merged("both", robots).unwrap_err();
    assert_eq!(refused(&two(&arm, &cart, at)), MergeError::Base { robot: 1 });
    let mut same = two(&arm, &arm, at);
    same[1].prefix = "a_";
    let name = format!("a_{}", arm.links[0].name);
    assert_eq!(refused(&same), MergeError::Name { robot: 1, name });
}
