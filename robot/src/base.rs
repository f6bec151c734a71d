//! Bases: the motion of the first link of a robot in the world. It is fixed, on wheels, or floats.

use serde::{Deserialize, Serialize};

/// Motion of the first link of a robot, relative to the place where it stands if all coordinates are zero: the world, or the
/// place of [`crate::Placed`]. Its coordinates come before those of the robot's joints, in `q` and in `v`.
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
    /// The link is fixed.
    #[default]
    Fixed,
    /// Moves freely in the plane z = 0 of its place (omnidirectional wheels).
    Planar,
    /// Drives forward and turns in the plane z = 0 of its place (differential drive); cannot slip sideways.
    Unicycle,
    /// Six degrees of freedom.
    Floating,
}

impl Base {
    /// Number of coordinates in the configuration: 0, 3, 3 or 7.
    #[inline]
    pub const fn nq(self) -> usize {
        self.coordinate_names().len()
    }

    /// Number of coordinates in the velocity: 0, 3, 2 or 6.
    #[inline]
    pub const fn nv(self) -> usize {
        self.dof_names().len()
    }

    /// Returns the word for the base in specs.
    pub const fn word(self) -> &'static str {
        match self {
            Base::Fixed => "fixed",
            Base::Planar => "planar",
            Base::Unicycle => "unicycle",
            Base::Floating => "floating",
        }
    }

    /// Returns the names of the base's coordinates, in the order of `q`.
    pub const fn coordinate_names(self) -> &'static [&'static str] {
        match self {
            Base::Fixed => &[],
            Base::Planar | Base::Unicycle => &["base_x", "base_y", "base_yaw"],
            Base::Floating => &["base_x", "base_y", "base_z", "base_qw", "base_qx", "base_qy", "base_qz"],
        }
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

    /// Returns true for a base that drives on the ground, and so has a position there and a direction.
    pub const fn drives(self) -> bool {
        matches!(self, Base::Planar | Base::Unicycle)
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
