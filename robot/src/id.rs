//! Typed indices of links and joints.

use serde::{Deserialize, Serialize};

/// Index into [`crate::Model::links`]. Every link is a frame; `LinkId(0)` is the root.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct LinkId(pub u32);

/// Index into [`crate::Model::joints`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct JointId(pub u32);

impl LinkId {
    /// Returns the index as `usize`.
    #[inline]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl JointId {
    /// Returns the index as `usize`.
    #[inline]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}
