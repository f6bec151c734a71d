//! Machines at run time: which transition is taken, in which order states are left and entered, what is asked of the
//! world, how the command goes over from one stack to another, and what becomes of faults.

#[path = "common/cli.rs"]
mod cli;
mod common;

#[path = "machine/again.rs"]
mod again;
#[path = "machine/blend.rs"]
mod blend;
#[path = "machine/entry.rs"]
mod entry;
#[path = "machine/faults.rs"]
mod faults;
#[path = "machine/host.rs"]
mod host;
#[path = "machine/interpreter.rs"]
mod interpreter;
#[path = "machine/late_ticks.rs"]
mod late_ticks;
#[path = "machine/letting_go.rs"]
mod letting_go;
#[path = "machine/motion.rs"]
mod motion;
#[path = "machine/semantics.rs"]
mod semantics;
#[path = "machine/sensors.rs"]
mod sensors;
#[path = "machine/slow_ticks.rs"]
mod slow_ticks;
#[path = "machine/told.rs"]
mod told;
#[path = "machine/variables.rs"]
mod variables;
