//! Entries of `home` and of the `start` of a scenario for bases: their coordinates, and the orientation of a floating one. Of
//! several robots, the name of each stands before those of its base.

use dsl::tree::Entry;
use dsl::{Diagnostic, Help, Snippet};
use robot::{Base, Model};
use stdlib_tasks::dimension::{ANGLE, LENGTH};

use crate::expr::Kind;
use crate::expr::constants::Constants;

/// The key of the orientation of a floating base.
pub(crate) const ORIENTATION: &str = "base_orientation";

/// Names that `home` and `start` know for the bases of a model.
pub(super) fn names(model: &Model) -> Vec<String> {
    let of = |base: &robot::MobileBase| {
        let prefix = base.prefix(model);
        entries(base.kind).iter().map(move |name| format!("{prefix}{name}"))
    };
    model.bases.iter().flat_map(of).collect()
}

/// Names for a base alone.
fn entries(base: Base) -> &'static [&'static str] {
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
        model: &Model,
        e: &Entry,
        constants: &mut Constants,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> BaseEntry {
        for base in &model.bases {
            let prefix = base.prefix(model);
            let Some(key) = e.key.value.strip_prefix(prefix) else { continue };
            let angles = ["base_roll", "base_pitch", "base_yaw", "base_rpy"];
            if base.kind == Base::Floating && angles.contains(&key) {
                diagnostics.push(no_angle(prefix, e));
                return BaseEntry::Wrong;
            }
            let Some(place) = entries(base.kind).iter().position(|name| *name == key) else { continue };
            let values = match key {
                ORIENTATION => orientation(e, constants, diagnostics),
                "base_yaw" => constants.scalar(&e.value, ANGLE, diagnostics).map(|x| vec![x]),
                _ => constants.scalar(&e.value, LENGTH, diagnostics).map(|x| vec![x]),
            };
            let first = base.first_coordinate + place;
            return values.map_or(BaseEntry::Wrong, |values| BaseEntry::Coordinates { first, values });
        }
        BaseEntry::Other
    }
}

/// The error for an angle of a floating base.
fn no_angle(prefix: &str, e: &Entry) -> Diagnostic {
    Diagnostic::unknown_name(e.key.span, format!("a floating base has no coordinate `{}`", e.key.value))
        .note("it turns about all axes, so that its orientation is one value")
        .help(Help::with(
            "write for instance {}",
            [Snippet::entry(format!("{prefix}{ORIENTATION}"), "rpy(0, 0, 90 deg)")],
        ))
}

/// The quaternion `w x y z` of an entry.
fn orientation(e: &Entry, constants: &mut Constants, diagnostics: &mut Vec<Diagnostic>) -> Option<Vec<f64>> {
    let typed = constants.constant(&e.value, diagnostics)?;
    if typed.kind != Kind::Rotation {
        let is = typed.kind.describe();
        let text = format!("`{}` is {}, and this is {is}", e.key.value, Kind::Rotation.describe());
        let d = Diagnostic::error("HQ0304", e.value.span, text).here(is);
        diagnostics.push(match typed.kind {
            Kind::Pose => d.help("write `.orientation` after it"),
            _ => d.help("write `rpy(roll, pitch, yaw)`, `axis_angle(vector, angle)` or `quaternion(w, x, y, z)`"),
        });
        return None;
    }
    typed.nodes.iter().map(|&node| constants.graph.constant(node)).collect()
}
