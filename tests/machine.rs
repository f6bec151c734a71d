//! Machines at run time: selection of transitions, order of exits and entries, requests to the world, blending between
//! stacks, and handling of faults.

use crate::common;

mod absent;
mod again;
mod blend;
mod completion;
mod entry;
mod faults;
mod host;
mod interpreter;
mod interrupted_blend;
mod late_ticks;
mod letting_go;
mod motion;
mod region_stacks;
mod regions;
mod semantics;
mod sensors;
mod slow_ticks;
mod task_outputs;
mod variables;
