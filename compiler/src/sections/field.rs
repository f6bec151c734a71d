//! Keys of safety fields.

use blocks::{Argument, Unbound, ValueType, block};
use stdlib_tasks::dimension::LENGTH;

/// Argument of the function of the distance.
pub static FIELD_DISTANCE: &[Argument] =
    &[Argument { name: "d", is_vector: false, dimension: LENGTH, doc: "The distance from the robot to the person." }];

block! {
    /// A safety field.
    pub struct SafetyFieldBlock = SAFETY_FIELD, "a safety field" {
        /// People and positions whose distance to the robot is measured: a human, a point of one, any position in
        /// the world, or a list of these.
        of: Option<Unbound> = required_elsewhere(ValueType::People, "operator");
        /// Parts of the robot whose distance is measured: links, arms, points, segments and groups. Default: the
        /// whole robot.
        links: Option<Unbound> = elsewhere(ValueType::Links);
        /// The function of the distance that is averaged: `identity`, `saturating(1.5 m)`, or an expression in `d`
        /// that does not decrease, such as `min(d, 2 m)`.
        distance: Unbound = or(ValueType::WordOr(&["identity", "saturating"]), "identity");
        /// Combination of the values of several points into one: `mean`, `minimum`, or `soft_minimum(8 /m)`, which
        /// is smooth and below the minimum.
        points: Unbound = or(ValueType::WordOr(&["mean", "minimum", "soft_minimum"]), "mean");
    }
}
