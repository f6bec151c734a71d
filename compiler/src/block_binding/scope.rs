//! Names that the values of a mission's blocks may refer to: its members, and its places.

use std::collections::BTreeMap;

use blocks::Members;

/// Members of the mission around a block.
#[derive(Debug, Default)]
pub(crate) struct Scope {
    /// Names of the members, by role, in the order written.
    pub members: BTreeMap<&'static str, Vec<String>>,
    /// Positions (m) of places.
    pub places: BTreeMap<String, [f64; 3]>,
    /// Name of the mission; empty outside of missions.
    pub mission: String,
}

/// Role of members that are places; their key `at` is the position.
pub(crate) const PLACE: &str = "place";

impl Scope {
    /// Returns the names of members, in the order of their indices.
    pub fn names(&self, of: &Members) -> Vec<&str> {
        of.roles.iter().filter_map(|role| self.members.get(role)).flatten().map(String::as_str).collect()
    }

    /// Returns true for a declared place.
    pub fn has_place(&self, name: &str) -> bool {
        self.members.get(PLACE).is_some_and(|places| places.iter().any(|place| place == name))
    }
}
