//! Shared by the tests of safety fields, here and in the planner: robots and random numbers.

use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use robot::{Base, Model, Options, Placed};

/// A vector with entries within ±reach.
pub fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
}

pub use robot::random::units as rng;

/// Robots of different build: one arm, a two-armed one on each kind of base, a tree with sliding and mimicking joints, an arm
/// and a two-armed one together.
pub fn robots() -> Vec<Model> {
    let read = |text: &str, base: Base| {
        let options = Options { base, ..Options::default() };
        match Model::from_urdf(text, &options) {
            Ok((model, _)) => model,
            Err(e) => panic!("{e:?}"),
        }
    };
    let canopies = include_str!("../../../examples/robots/canopies.urdf");
    let arm = read(include_str!("../../../examples/robots/arm7.urdf"), Base::Fixed);
    let cart = read(canopies, Base::Unicycle);
    let together = [
        Placed { model: &arm, prefix: "arm_", at: Isometry3::translation(1.0, 0.5, 0.0) },
        Placed { model: &cart, prefix: "cart_", at: Isometry3::rotation(Vector3::new(0.1, 0.0, 0.4)) },
    ];
    let Ok((two, _)) = Model::merged("two", &together) else { panic!("robots with different names") };
    vec![
        arm,
        cart,
        two,
        read(canopies, Base::Floating),
        read(include_str!("../../../robot/tests/it/workcell.urdf"), Base::Planar),
    ]
}
