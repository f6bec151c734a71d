//! Remarks of a node while it runs.

use std::fmt;
use std::sync::Arc;

/// A remark for the user, told once.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Remark {
    /// Joints whose positions have not been heard of yet.
    WaitingFor {
        /// Their names.
        joints: Vec<String>,
        /// Topics that they may come from.
        topics: Vec<String>,
        /// Names of joints that messages had, and that the robot has not.
        strangers: Vec<String>,
    },
    /// Topics of commands that nobody reads yet.
    NobodyReads {
        /// The topics.
        topics: Vec<String>,
    },
    /// Topics of commands that nobody reads any more.
    ReaderGone {
        /// The topics.
        topics: Vec<String>,
    },
    /// The controller runs.
    Running,
    /// Messages in a frame from which no transform leads to the one of the signal.
    OtherFrame {
        /// Topic.
        topic: String,
        /// Frame of the messages.
        frame: String,
        /// Frame that is needed.
        needed: String,
    },
    /// Messages that cannot be read.
    Unreadable {
        /// Topic.
        topic: String,
        /// The reason.
        why: String,
    },
    /// Two publishers of the position of a joint: those of the second one are not read.
    TwoSources {
        /// Topic of the second one.
        topic: String,
        /// The joint.
        joint: String,
    },
    /// A topic on which others send messages of another type.
    OtherType {
        /// Topic.
        topic: String,
        /// Type that others send.
        found: String,
        /// Type that the node reads or writes.
        needed: String,
    },
    /// A topic whose latched messages are read, and on which somebody keeps none for those who come later: its messages are not read.
    NotLatched {
        /// Topic.
        topic: String,
    },
    /// A topic of a signal on which somebody keeps the last message for those who come later, which is not read.
    Latched {
        /// Topic.
        topic: String,
    },
    /// The fault of the controller has changed.
    Fault(String),
    /// The state of the machine has changed.
    State(String),
    /// A command that could not be sent.
    NotSent {
        /// Topic.
        topic: String,
        /// The reason.
        why: String,
    },
}

/// Receiver of remarks, called from any thread.
pub type Tell = Arc<dyn Fn(&Remark) + Send + Sync>;

fn some(names: &[String]) -> String {
    let shown: Vec<&str> = names.iter().take(6).map(String::as_str).collect();
    let more = names.len().saturating_sub(shown.len());
    let tail = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{tail}", shown.join(", "))
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Remark::WaitingFor { joints, topics, strangers } => {
                write!(f, "waiting for positions of {} on {}", some(joints), some(topics))?;
                if strangers.is_empty() {
                    return Ok(());
                }
                write!(f, "; messages name {}, which the robot does not have", some(strangers))
            }
            Remark::NobodyReads { topics } => {
                write!(f, "waiting for somebody who reads the commands on {}", some(topics))
            }
            Remark::ReaderGone { topics } => write!(
                f,
                "nobody reads the commands on {} any more: the robot stands until a call of ~/motion/resume",
                some(topics)
            ),
            Remark::Running => write!(f, "all joints are known and the commands are read: the controller runs"),
            Remark::OtherFrame { topic, frame, needed } => {
                write!(
                    f,
                    "messages on {topic} are in the frame `{frame}`, from which no fixed transform of /tf_static leads to `{needed}`: \
                     they are rejected"
                )
            }
            Remark::Unreadable { topic, why } => write!(f, "a message on {topic} cannot be read: {why}"),
            Remark::TwoSources { topic, joint } => write!(
                f,
                "a second publisher on {topic} sends the position of `{joint}`: it is not read while the first one sends. \
                 Another robot may be in the same domain (ROS_DOMAIN_ID)"
            ),
            Remark::OtherType { topic, found, needed } => {
                write!(f, "others use {topic} with messages of the type {found}, and this node with {needed}")
            }
            Remark::NotLatched { topic } => {
                write!(
                    f,
                    "a publisher on {topic} keeps no message for those who come later, and is not read: leave out `latched`"
                )
            }
            Remark::Latched { topic } => {
                write!(
                    f,
                    "a publisher on {topic} keeps its last message for those who come later: `latched true` reads it"
                )
            }
            Remark::Fault(fault) if fault.is_empty() => write!(f, "no fault any more"),
            Remark::Fault(fault) => write!(f, "fault {fault}"),
            Remark::State(state) => write!(f, "state {state}"),
            Remark::NotSent { topic, why } => write!(f, "a command on {topic} was not sent: {why}"),
        }
    }
}
