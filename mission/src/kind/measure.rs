//! Quantities of a kind of mission that can be measured.

use quantities::dimension::Dimension;

/// A quantity that can be measured, defined once: expectations, their diagnostics, the editor and the page of keys derive
/// from it.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Name behind the dot.
    pub name: &'static str,
    /// Roles of the members that have it; none: the mission has it.
    pub of: &'static [&'static str],
    /// Type and unit.
    pub form: Form,
    /// Meaning, in Markdown, without the unit.
    pub doc: &'static str,
}

impl Measure {
    /// A measure of the whole mission.
    pub const fn whole(name: &'static str, form: Form, doc: &'static str) -> Measure {
        Measure { name, of: &[], form, doc }
    }

    /// A measure of members with these roles.
    pub const fn of(of: &'static [&'static str], name: &'static str, form: Form, doc: &'static str) -> Measure {
        Measure { name, of, form, doc }
    }

    /// True if it is of a member of this role; none: of the mission.
    pub fn is_of(&self, role: Option<&str>) -> bool {
        role.map_or(self.of.is_empty(), |role| self.of.contains(&role))
    }
}

/// Type of a measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A number of this dimension.
    Number(Dimension),
    /// True or false.
    Truth,
    /// A point (m). On the ground its third number is zero.
    Point,
    /// True or false, of the controller that a member runs: the runner knows it, and the execution does not.
    OfController,
}

/// A truth value as a measure.
pub(crate) fn truth(holds: bool) -> [f64; 3] {
    number(if holds { 1.0 } else { -1.0 })
}

/// A number as a measure.
pub(crate) fn number(x: f64) -> [f64; 3] {
    [x, f64::NAN, f64::NAN]
}
