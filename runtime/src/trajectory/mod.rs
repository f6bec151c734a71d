//! Trajectories: motion to a goal within declared limits of speed, acceleration and jerk, from rest or in motion.
//!
//! Everything is planned in closed form, or by searches with a bounded number of steps, and evaluated by time.
//! Functions are total: if there is no plan, the result says so. Only [`Route::new`] and [`Follower::new`] allocate.
//!
//! | file | content |
//! |---|---|
//! | `profile` | motion of one number, as pieces of constant jerk |
//! | `trapezoid`, `s_curve` | the profiles to rest, from any state |
//! | `path` | a vector: straight from rest, bounded in its norms after a new goal in motion |
//! | `rotation` | an orientation: the geodesic from rest |
//! | `route` | a vector over several points, corners rounded |
//! | `follower` | one of these at run time, with a goal that may change |

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
pub use route::{Route, RouteOptions};
pub use s_curve::s_curve;
pub use trapezoid::trapezoid;
