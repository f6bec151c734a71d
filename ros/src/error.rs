//! Reasons for which a node cannot begin or go on.

use ros2_client::{CreateError, NodeCreateError};
use runtime::ProgramError;

/// Reason for which a node cannot begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum RosError {
    /// The client library refuses something, for instance because there is no network.
    #[error("the connection to ROS 2 failed: {0}")]
    Create(String),
    /// A name is none for ROS 2.
    #[error("`{name}` is no name in ROS 2: {why}")]
    Name {
        /// The name.
        name: String,
        /// The reason.
        why: String,
    },
    /// A type of messages that signals are not read from.
    #[error("messages of the type `{0}` are not read")]
    Message(String),
    /// The program cannot be executed.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// The system gives no thread, or the record of the run could not be stored.
    #[error(transparent)]
    System(#[from] std::io::Error),
}

impl From<CreateError> for RosError {
    fn from(e: CreateError) -> RosError {
        RosError::Create(e.to_string())
    }
}

impl From<NodeCreateError> for RosError {
    fn from(e: NodeCreateError) -> RosError {
        RosError::Create(e.to_string())
    }
}
