//! Keys of obstacles, and of their true places in a scenario.

use blocks::{Located, Unbound, Word, block};
use stdlib_tasks::dimension::{LENGTH, NONE};
use stdlib_tasks::params::Quantity;

use super::ValueType;

const SIZE: Quantity = Quantity::at_least(LENGTH, 0.0).usually(1e-4, 200.0);
const RADIUS: Quantity = Quantity::above(LENGTH, 0.0).usually(1e-4, 50.0);
/// Distance by which pieces may exceed their mesh.
pub(super) const PIECES_WITHIN: Quantity = Quantity::above(LENGTH, 0.0).usually(1e-4, 1.0);
const PLACE: ValueType = ValueType::Vector(Quantity::any(LENGTH));

block! {
    /// An obstacle. It has exactly one of `box`, `sphere`, `cylinder`, `capsule`, `plane`, `mesh`, `cloud` and
    /// `heightfield`.
    pub struct ObstacleBlock = OBSTACLE, "an obstacle" {
        /// A box with these edge lengths along its axes, centred at `position`. One of them may be zero: a wall of no
        /// thickness.
        r#box: Option<Located<[f64; 3]>> = optional(ValueType::Vector(SIZE), "[1.2, 0.8, 0.04] m");
        /// A ball of this radius around `position`.
        sphere: Option<Located<f64>> = optional(ValueType::Number(RADIUS));
        /// A cylinder about its z axis, centred at `position`.
        cylinder: Option<RoundBlock> = optional(ValueType::Block(&ROUND));
        /// A capsule about its z axis, centred at `position`: a cylinder with a half ball at each end.
        capsule: Option<RoundBlock> = optional(ValueType::Block(&ROUND));
        /// The space behind a plane through `position`; the vector points to the free side and needs no unit length.
        plane: Option<Located<[f64; 3]>> = optional(ValueType::Vector(Quantity::any(NONE)), "[0, 0, 1]");
        /// A mesh, by default its convex hull: a `.stl`, `.obj` or `.dae` file, relative to the folder of the spec.
        mesh: Option<Located<String>> = optional(ValueType::Text);
        /// Of a mesh: its convex hull; convex pieces that contain it, or its triangles, with its hollows (`.stl` and `.obj`).
        shape: Word = or(ValueType::Choice(&["hull", "pieces", "triangles"]), "hull");
        /// Distance by which `shape pieces` may exceed the mesh.
        pieces_within: Located<f64> = or(ValueType::Number(PIECES_WITHIN), "0.005 m");
        /// The points of a cloud: a `.ply`, `.pcd` or `.xyz` file, relative to the folder of the spec.
        cloud: Option<Located<String>> = optional(ValueType::Text);
        /// Radius of the balls around the points of a cloud.
        radius: Located<f64> = or(ValueType::Number(Quantity::at_least(LENGTH, 0.0).usually(1e-4, 1.0)), "0 m");
        /// The surface over a grid of heights: a `.csv` file with a line for each row, the first one farthest along y.
        heightfield: Option<Located<String>> = optional(ValueType::Text);
        /// Of a heightfield: distance between two heights of a row, and between two rows.
        cell: Option<Located<f64>> = optional(ValueType::Number(Quantity::above(LENGTH, 0.0).usually(1e-3, 10.0)), "5 cm");
        /// Of a mesh, cloud or heightfield: metres of one unit of the file, `0.001` for a file in millimetres.
        scale: Located<f64> = or(ValueType::Number(Quantity::above(NONE, 0.0).usually(1e-4, 1e3)), "1");
        /// Position of its centre, or of the origin of a file (of a
        /// heightfield: the middle of the grid), in the world, or with `on` in the frame of that link; an
        /// expression that may depend on `time` and signals.
        position: Option<Unbound> = elsewhere(PLACE);
        /// Its orientation, likewise: `rpy(0, 0, 30 deg)`. Default: the axes of the world, or of the link.
        orientation: Option<Unbound> = elsewhere(ValueType::Value);
        /// The link that carries it.
        on: Option<Unbound> = elsewhere(ValueType::Link);
        /// Condition under which it is there, such as a signal of type `flag` or `present(SIGNAL)`. Default: always.
        present: Option<Unbound> = elsewhere(ValueType::Value);
    }
}

block! {
    /// Size of a cylinder or of a capsule.
    pub struct RoundBlock = ROUND, "the size of a cylinder or capsule" {
        /// The radius.
        radius: Option<Located<f64>> = required(ValueType::Number(RADIUS), "0.1 m");
        /// The length along the z axis; that of a capsule does not count its ends.
        length: Option<Located<f64>> = required(ValueType::Number(SIZE), "1 m");
    }
}

block! {
    /// The true place of an obstacle in a scenario.
    pub struct TrueObstacleBlock = TRUE_OBSTACLE, "the true place of an obstacle" {
        /// Its true position, constant; default: as declared.
        position: Option<Unbound> = elsewhere(PLACE);
        /// Its true orientation, constant; default: as declared.
        orientation: Option<Unbound> = elsewhere(ValueType::Value);
        /// True if the obstacle is truly there; default: as declared.
        present: Option<bool> = optional(ValueType::Flag);
    }
}
