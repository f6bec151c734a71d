//! Tests of the node: messages against the controller's numbers, and a node against an independent participant.

extern crate hierarq_ros as ros;

#[path = "it/commands.rs"]
mod commands;
#[path = "it/configuration.rs"]
mod configuration;
#[path = "it/names.rs"]
mod names;
#[path = "it/network.rs"]
mod network;
#[path = "it/readings.rs"]
mod readings;
#[path = "it/specs.rs"]
mod specs;
