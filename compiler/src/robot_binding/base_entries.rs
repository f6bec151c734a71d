//! Entries of `home` and of the `start` of a scenario for the base: its coordinates, and the orientation of a floating
//! one.

use dsl::tree::Entry;
use dsl::{Diagnostic, Help, Snippet, Span};
use robot::Base;
use stdlib_tasks::dimension::{ANGLE, LENGTH};

use crate::expr::Kind;
use crate::expr::constants::Constants;

/// The key of the orientation of a floating base.
const ORIENTATION: &str = "base_orientation";

/// Names that `home` and `start` know for a base.
pub(super) fn names(base: Base) -> &'static [&'static str] {
    match base {
        Base::Fixed => &[],
        Base::Planar | Base::Unicycle => &["base_x", "base_y", "base_yaw"],
        Base::Floating => &["base_x", "base_y", "base_z", ORIENTATION],
    }
}

/// An entry of `home` or `start`, read as one of the base.
pub(crate) enum BaseEntry {
    /// Its key is none of the base.
    Other,
    /// It cannot be read, with a diagnostic.
    Wrong,
    /// Coordinates in `q` from the index `first`.
    Coordinates {
        /// Index of the first one.
        first: usize,
        /// The coordinates.
        values: Vec<f64>,
    },
}

impl BaseEntry {
    /// Reads an entry, with its mistakes.
    pub(crate) fn read(
        base: Base,
        e: &Entry,
        constants: &mut Constants,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> BaseEntry {
        let key = e.key.value.as_str();
        if base == Base::Floating && ["base_roll", "base_pitch", "base_yaw", "base_rpy"].contains(&key) {
            diagnostics.push(no_angle(key, e.key.span));
            return BaseEntry::Wrong;
        }
        let Some(first) = names(base).iter().position(|name| *name == key) else { return BaseEntry::Other };
        let values = match key {
            ORIENTATION => orientation(e, constants, diagnostics),
            "base_yaw" => constants.scalar(&e.value, ANGLE, diagnostics).map(|x| vec![x]),
            _ => constants.scalar(&e.value, LENGTH, diagnostics).map(|x| vec![x]),
        };
        values.map_or(BaseEntry::Wrong, |values| BaseEntry::Coordinates { first, values })
    }
}

/// The error for an angle of a floating base.
fn no_angle(key: &str, at: Span) -> Diagnostic {
    Diagnostic::unknown_name(at, format!("a floating base has no coordinate `{key}`"))
        .note("it turns about all axes, so that its orientation is one value")
        .help(Help::with("write for instance {}", [Snippet::entry(ORIENTATION, "rpy(0, 0, 90 deg)")]))
}

/// The quaternion `w x y z` of an entry.
fn orientation(e: &Entry, constants: &mut Constants, diagnostics: &mut Vec<Diagnostic>) -> Option<Vec<f64>> {
    let typed = constants.constant(&e.value, diagnostics)?;
    if typed.kind != Kind::Rotation {
        let is = typed.kind.describe();
        let text = format!("`{ORIENTATION}` is {}, and this is {is}", Kind::Rotation.describe());
        let d = Diagnostic::error("HQ0304", e.value.span, text).here(is);
        diagnostics.push(match typed.kind {
            Kind::Pose => d.help("write `.orientation` after it"),
            _ => d.help("write `rpy(roll, pitch, yaw)`, `axis_angle(vector, angle)` or `quaternion(w, x, y, z)`"),
        });
        return None;
    }
    typed.nodes.iter().map(|&node| constants.graph.constant(node)).collect()
}
