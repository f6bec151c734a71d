//! Pairs of links that touch: against distances at random postures that this test draws.

use hierarq_robot::random::units;
use hierarq_robot::{Data, Model, Options, contacts};

const ARM: &str = include_str!("../../../examples/robots/arm7.urdf");

fn arm() -> Model {
    Model::from_urdf(ARM, &Options::default()).unwrap().0
}

#[test]
fn neighbours_are_joined_by_one_joint() {
    let model = arm();
    let id = |name: &str| model.link(name).unwrap();
    assert!(contacts::are_neighbours(&model, id("link_2"), id("link_3")));
    assert!(contacts::are_neighbours(&model, id("gripper"), id("link_7")), "a fixed joint");
    assert!(contacts::are_neighbours(&model, id("gripper"), id("link_6")), "through a fixed joint");
    assert!(!contacts::are_neighbours(&model, id("link_2"), id("link_4")));
    assert!(contacts::pairs(&model).iter().all(|[a, b]| a < b && !contacts::are_neighbours(&model, *a, *b)));
}

#[test]
fn what_touches_always_touches_at_other_postures_too() {
    let model = arm();
    let home = model.neutral();
    let pairs = contacts::pairs(&model);
    let always = contacts::always_touching(&model, &home, &pairs);
    let names: Vec<[&str; 2]> = always.iter().map(|pair| pair.map(|link| model.link_ref(link).name.as_str())).collect();
    assert_eq!(names, [["base_link", "link_2"], ["link_5", "link_7"]]);
    let mut unit = units(77);
    let mut data = Data::new(&model);
    let mut apart = vec![false; pairs.len()];
    for _ in 0..2000 {
        model.forward(&model.random_configuration(&mut unit), &mut data);
        for (apart, pair) in apart.iter_mut().zip(&pairs) {
            *apart |= !contacts::touch(&model, &data, *pair);
        }
    }
    for (apart, pair) in apart.iter().zip(&pairs) {
        assert_eq!(!apart, always.contains(pair), "{pair:?}");
    }
}
