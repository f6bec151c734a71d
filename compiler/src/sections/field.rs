//! Keys of safety fields.

use super::{Holds, Key, Section};

/// A safety field.
pub static SAFETY_FIELD: Section = Section {
    name: "a safety field",
    keys: &[
        Key::required(
            "of",
            Holds::People,
            "Whose distance counts: a human, a point of one, any position in the world, or a list of these.",
        ),
        Key::optional(
            "links",
            Holds::Links,
            "The part of the robot that counts: links, arms, points, segments and groups; the whole robot where left out.",
        ),
        Key::or(
            "distance",
            Holds::WordOr(&["identity", "saturating"]),
            "identity",
            "The function of the distance that is averaged: `identity`, `saturating(1.5 m)`, or an expression in `d` that does not fall, such as `min(d, 2 m)`.",
        ),
        Key::or(
            "points",
            Holds::WordOr(&["mean", "minimum", "soft_minimum"]),
            "mean",
            "How several points make one number: `mean`, `minimum`, or `soft_minimum(8 /m)`, which lies below the minimum and is smooth.",
        ),
    ],
};
