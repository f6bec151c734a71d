//! Tests of the node: messages against the controller's numbers, and a node against an independent participant.

extern crate hierarq_ros as ros;

#[path = "it/commands.rs"]
mod commands;
#[path = "it/configuration.rs"]
mod configuration;
#[path = "it/enabled.rs"]
mod enabled;
#[path = "it/faults.rs"]
mod faults;
#[path = "it/frames.rs"]
mod frames;
#[path = "it/names.rs"]
mod names;
#[path = "it/network.rs"]
mod network;
#[path = "it/others.rs"]
mod others;
#[path = "it/peers.rs"]
mod peers;
#[path = "it/rates.rs"]
mod rates;
#[path = "it/readings.rs"]
mod readings;
#[path = "it/specs.rs"]
mod specs;
