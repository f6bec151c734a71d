//! Machines at run time: which transition is taken, in which order states are left and entered, what is asked of the
//! world, how the command goes over from one stack to another, and what becomes of faults.

use crate::common;

mod again;
mod blend;
mod entry;
mod faults;
mod host;
mod interpreter;
mod late_ticks;
mod letting_go;
mod motion;
mod semantics;
mod sensors;
mod slow_ticks;
mod told;
mod variables;
