//! Runs of specs: a spec read and compiled ([`project`]), its certain fixes applied ([`mend`]), one scenario
//! ([`scenario_runner`]), many of them ([`sweep`]), differences in behaviour ([`diff`]), and files of the problems that a run solves
//! ([`qp_log`]).

pub mod diff;
pub mod mend;
pub mod project;
pub mod qp_log;
pub mod scenario_runner;
#[cfg(feature = "sweep")]
pub mod sweep;
