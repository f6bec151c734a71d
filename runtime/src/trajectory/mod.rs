//! Trajectories: motion to a goal within declared limits of speed, acceleration and jerk, from rest or in motion.
//!
//! Everything is planned in closed form, or by searches of a bounded number of steps; looked up by time; and total: where
//! there is no plan, there is an answer that says so. Nothing allocates but [`Route::new`] and [`Follower::new`].
//!
//! | file | is |
//! |---|---|
//! | `profile` | motion of one number, as pieces of constant jerk |
//! | `trapezoid`, `s_curve` | the profiles to rest, from any state |
//! | `path` | a vector: straight from rest, bounded in its norms after a new goal in motion |
//! | `rotation` | an orientation: the geodesic from rest |
//! | `route` | a vector over several points, corners rounded |
//! | `follower` | one of them at run time: follows a goal that may change |

mod follower;
mod limits;
mod path;
mod profile;
mod rotation;
mod route;
mod s_curve;
mod trapezoid;

pub use follower::Follower;
pub use limits::Limits;
pub use path::{Path, State};
pub use profile::{Motion, Profile};
pub use rotation::{Turn, Turning, quaternion_rate};
pub use route::Route;
pub use s_curve::s_curve;
pub use trapezoid::trapezoid;
