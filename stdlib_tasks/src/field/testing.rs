//! Shared by the tests of safety fields, here and in the planner: robots and random numbers.

use nalgebra::Vector3;
use proptest::prelude::*;
use robot::{Base, Model, Options};

/// A vector with entries within ±reach.
pub fn vector(reach: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-reach..reach).prop_map(Vector3::from)
}

/// A repeatable generator of numbers in 0..1 (splitmix64).
pub fn rng(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

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
