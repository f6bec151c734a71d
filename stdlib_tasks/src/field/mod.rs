//! Safety field between people and the robot: the distance of the whole robot from all observed points of a person, as
//! one number with exact derivatives. Thesis 4.2.2, corrected.
//!
//! [`Field`] is the number with all its storage, [`FieldProgram`] the same as data. [`SpeedAndSeparation`] is the rule
//! of ISO/TS 15066. Constructors allocate all memory; functions that run in a tick neither allocate nor panic.

#[cfg(test)]
mod adaptive;
mod body;
mod chi;
mod curvature_bound;
mod error;
mod line;
mod program;
mod quadrature;
mod segment;
mod separation;
#[cfg(test)]
mod testing;
mod value;

pub use body::{Attached, Body, LinkSegment};
pub use chi::{Chi, DistanceFunction};
pub use error::{SafetyError, finite, gain, setting};
pub use line::line_mean;
pub use program::{DistanceProgram, ExpressionDistance, FieldProgram};
pub use quadrature::GaussLegendre;
pub use segment::{Mean, mean_distance};
pub use separation::{SpeedAndSeparation, Stopping, Verdict};
pub use value::{Field, HumanPoint, Over};
