//! Runs of specs: a spec read and compiled ([`project`]), its certain mistakes mended ([`mend`]), one scenario ([`trial`]), many of them ([`sweep`]), and files of the
//! problems that a run solves ([`ticks`]).

pub mod mend;
pub mod project;
#[cfg(feature = "sweep")]
pub mod sweep;
pub mod ticks;
pub mod trial;
