//! Mobility of the root link: fixed, on wheels, or floating.

use serde::{Deserialize, Serialize};

/// Motion of the root link in the world. Its coordinates come first in `q` and `v`.
///
/// | base | `q` | `v` (base frame) |
/// |---|---|---|
/// | `fixed` | | |
/// | `planar` | x, y \[m\], yaw \[rad\] | base_x, base_y \[m/s\], base_yaw \[rad/s\] |
/// | `unicycle` | x, y \[m\], yaw \[rad\] | base_forward \[m/s\], base_yaw \[rad/s\] |
/// | `floating` | x, y, z \[m\], qw, qx, qy, qz | base_x, base_y, base_z \[m/s\], base_wx, base_wy, base_wz \[rad/s\] |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Base {
    /// The root link is fixed in the world.
    #[default]
    Fixed,
    /// Moves freely in the plane z = 0 (omnidirectional wheels).
    Planar,
    /// Drives forward and turns in the plane z = 0 (differential drive); cannot slip sideways.
    Unicycle,
    /// Six degrees of freedom.
    Floating,
}

impl Base {
    /// Number of coordinates in the configuration: 0, 3, 3 or 7.
    #[inline]
    pub const fn nq(self) -> usize {
        match self {
            Base::Fixed => 0,
            Base::Planar | Base::Unicycle => 3,
            Base::Floating => 7,
        }
    }

    /// Number of coordinates in the velocity: 0, 3, 2 or 6.
    #[inline]
    pub const fn nv(self) -> usize {
        self.dof_names().len()
    }

    /// Returns the names of the base's degrees of freedom, in the order of `v`.
    pub const fn dof_names(self) -> &'static [&'static str] {
        match self {
            Base::Fixed => &[],
            Base::Planar => &["base_x", "base_y", "base_yaw"],
            Base::Unicycle => &["base_forward", "base_yaw"],
            Base::Floating => &["base_x", "base_y", "base_z", "base_wx", "base_wy", "base_wz"],
        }
    }

    /// Returns true if the `i`-th degree of freedom is a rotation (rad), false for a translation (m).
    pub(crate) const fn turns(self, i: usize) -> bool {
        match self {
            Base::Fixed => false,
            Base::Planar => i == 2,
            Base::Unicycle => i == 1,
            Base::Floating => i >= 3,
        }
    }
}
