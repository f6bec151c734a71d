//! A compiled program as a node of ROS 2: [`run`] reads joints, sensors and people from topics, steps the controller, and sends its
//! commands.
//!
//! The connection is [`runtime::program::RosProgram`]. The loop runs in the thread that calls [`run`]; what is shown to others is made
//! and sent by threads of its own.

pub mod commands;
mod connections;
mod error;
pub mod frames;
mod inputs;
pub mod joints;
pub mod messages;
pub mod names;
mod neighbours;
mod node;
mod outputs;
mod quality;
pub mod readings;
mod remark;
mod services;
mod signals;
mod telemetry;

pub use connections::{Connection, connections};
pub use error::RosError;
pub use node::{Ended, Settings, run};
pub use remark::{Remark, Tell};
pub use ros2_client::ServiceMapping;
