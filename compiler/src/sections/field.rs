//! Keys of safety fields.

use super::{Holds, Key, Section};

/// A safety field.
pub static SAFETY_FIELD: Section = Section {
    name: "a safety field",
    keys: &[
        Key::required(
            "of",
            Holds::People,
            "People and positions whose distance to the robot is measured: a human, a point of one, any position in \
             the world, or a list of these.",
        ),
        Key::optional(
            "links",
            Holds::Links,
            "Parts of the robot whose distance is measured: links, arms, points, segments and groups. Default: the \
             whole robot.",
        ),
        Key::or(
            "distance",
            Holds::WordOr(&["identity", "saturating"]),
            "identity",
            "The function of the distance that is averaged: `identity`, `saturating(1.5 m)`, or an expression in `d` \
             that does not decrease, such as `min(d, 2 m)`.",
        ),
        Key::or(
            "points",
            Holds::WordOr(&["mean", "minimum", "soft_minimum"]),
            "mean",
            "Combination of the values of several points into one: `mean`, `minimum`, or `soft_minimum(8 /m)`, which \
             is smooth and below the minimum.",
        ),
    ],
};
