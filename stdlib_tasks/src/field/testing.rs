//! Shared by the tests of safety fields, here and in the planner: robots and random numbers.

use nalgebra::Vector3;
use proptest::prelude::*;
use robot::{Base, Model, Options};

/// A vector with entries within ±reach.
pub fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
}

pub use robot::random::units as rng;

/// Robots of different build: one arm, a two-armed one on each kind of base, a tree with sliding and mimicking joints.
pub fn robots() -> Vec<Model> {
    let read = |text: &str, base: Base| {
        let options = Options { base, ..Options::default() };
        match Model::from_urdf(text, &options) {
            Ok((model, _)) => model,
            Err(e) => panic!("{e:?}"),
        }
    };
    let canopies = include_str!("../../../examples/robots/canopies.urdf");
    vec![
        read(include_str!("../../../examples/robots/arm7.urdf"), Base::Fixed),
        read(canopies, Base::Unicycle),
        read(canopies, Base::Floating),
        read(include_str!("../../../robot/tests/it/workcell.urdf"), Base::Planar),
    ]
}
