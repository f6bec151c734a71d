//! Contacts between links: the distance of two links, the pairs that can be kept apart, and those that touch at all of
//! many random postures.

use std::collections::BTreeSet;

use crate::geometry::{Degenerate, closest};
use crate::random::SplitMix64;
use crate::{Data, LinkId, Model, PlacedShape};

/// Two links, the one with the smaller index first.
pub type LinkPair = [LinkId; 2];

/// Number of random postures at which two links must touch to count as always touching.
pub const POSTURES: usize = 1_000;

/// Seed of these postures.
pub const SEED: u64 = 1;

/// Returns the pair of two links.
pub fn pair(a: LinkId, b: LinkId) -> LinkPair {
    [a.min(b), a.max(b)]
}

/// Returns the distance of two links \[m\], not above zero if they overlap; infinite if one has no shape.
pub fn distance(model: &Model, data: &Data, [a, b]: LinkPair) -> f64 {
    let (on_a, on_b) = (&model.link_ref(a).collision, &model.link_ref(b).collision);
    let (at_a, at_b) = (data.pose(a), data.pose(b));
    let apart =
        |s: &PlacedShape, t: &PlacedShape| match closest(&s.shape, &(at_a * s.origin), &t.shape, &(at_b * t.origin)) {
            Ok(found) => found.distance,
            Err(Degenerate::Touching) => 0.0,
        };
    on_a.iter().flat_map(|s| on_b.iter().map(move |t| apart(s, t))).fold(f64::INFINITY, f64::min)
}

/// Returns true if two links overlap.
pub fn touch(model: &Model, data: &Data, pair: LinkPair) -> bool {
    distance(model, data, pair) <= 0.0
}

/// Returns true if at most one degree of freedom moves two links against each other. Such links meet at their joint, and
/// overlap there by how they are built. Links of two robots are neighbours only if nothing moves them against each other.
pub fn are_neighbours(model: &Model, a: LinkId, b: LinkId) -> bool {
    let (of_a, of_b) = (model.support(a), model.support(b));
    let between = of_a.iter().filter(|s| !of_b.contains(s)).count() + of_b.iter().filter(|s| !of_a.contains(s)).count();
    between <= usize::from(model.robot_of(a) == model.robot_of(b))
}

/// Returns the pairs of links with collision shapes that are no neighbours, in the order of the model.
pub fn pairs(model: &Model) -> Vec<LinkPair> {
    let with_shapes: Vec<LinkId> =
        (0..model.links.len() as u32).map(LinkId).filter(|l| !model.link_ref(*l).collision.is_empty()).collect();
    let mut pairs = Vec::new();
    for (k, &a) in with_shapes.iter().enumerate() {
        pairs.extend(with_shapes[k + 1..].iter().filter(|&&b| !are_neighbours(model, a, b)).map(|&b| [a, b]));
    }
    pairs
}

/// Returns those of the pairs that touch at `home` and at each of [`POSTURES`] random postures within the limits of the
/// joints: their shapes overlap by how they are drawn. Bases stay at `home`, whose length is nq.
pub fn always_touching(model: &Model, home: &[f64], pairs: &[LinkPair]) -> BTreeSet<LinkPair> {
    let mut data = Data::new(model);
    model.forward(home, &mut data);
    let mut left: Vec<LinkPair> = pairs.iter().copied().filter(|pair| touch(model, &data, *pair)).collect();
    let mut generator = SplitMix64(SEED);
    for _ in 0..POSTURES {
        if left.is_empty() {
            break;
        }
        let mut q = model.random_configuration(&mut || generator.unit());
        model.copy_bases(home, &mut q);
        model.forward(&q, &mut data);
        left.retain(|pair| touch(model, &data, *pair));
    }
    left.into_iter().collect()
}
