//! Runs of specs: a spec read and compiled ([`project`]), one scenario ([`trial`]), many of them ([`sweep`]), plans of
//! missions ([`planned`]) as data ([`plan_data`]), and files of the problems that a run solves ([`ticks`]).

pub mod plan_data;
pub mod planned;
pub mod project;
pub mod sweep;
pub mod ticks;
pub mod trial;
