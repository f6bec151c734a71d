//! Tests of the compiler, from specs to programs and diagnostics: one file per subject.

mod accelerations;
mod axes;
mod center_of_mass;
mod common;
mod coverage;
mod diagnostics;
mod entries;
mod exploration;
mod expressions;
mod frames;
mod hostile;
mod initial;
mod inline_tasks;
mod meaning;
mod missions;
mod pages;
mod params;
mod quiet;
mod ranges;
mod rendering;
mod resolve;
mod reuse;
mod sections;
mod start_of_run;
mod state;
mod together;
