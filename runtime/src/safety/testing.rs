//! What the tests of this folder share: an adaptive quadrature, robots, random numbers.

use nalgebra::Vector3;
use proptest::prelude::*;
use robot::{Base, Model, Options};

/// Adaptive Simpson quadrature to about 1e-12.
pub fn adaptive(f: &dyn Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    fn simpson(f: &dyn Fn(f64) -> f64, a: [f64; 2], fa: [f64; 3], whole: f64, depth: u32) -> f64 {
        let m = 0.5 * (a[0] + a[1]);
        let (l, r) = (f(0.5 * (a[0] + m)), f(0.5 * (m + a[1])));
        let h = a[1] - a[0];
        let left = h / 12.0 * (fa[0] + 4.0 * l + fa[1]);
        let right = h / 12.0 * (fa[1] + 4.0 * r + fa[2]);
        let error = left + right - whole;
        if depth == 0 || error.abs() < 1e-13 {
            return left + right + error / 15.0;
        }
        simpson(f, [a[0], m], [fa[0], l, fa[1]], left, depth - 1)
            + simpson(f, [m, a[1]], [fa[1], r, fa[2]], right, depth - 1)
    }
    if to <= from {
        return 0.0;
    }
    let fa = [f(from), f(0.5 * (from + to)), f(to)];
    simpson(f, [from, to], fa, (to - from) / 6.0 * (fa[0] + 4.0 * fa[1] + fa[2]), 24)
}

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
