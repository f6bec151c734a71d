//! Names of topics and services.

use ros2_client::{MessageTypeName, Name, NodeName, ServiceTypeName};
use runtime::program::RosProgram;

use crate::RosError;

/// Name of the node.
///
/// # Errors
/// It is none for ROS 2.
pub fn node_name(ros: &RosProgram) -> Result<NodeName, RosError> {
    let wrong = |e: &dyn std::fmt::Display| RosError::Name { name: ros.node.clone(), why: e.to_string() };
    let namespace = format!("/{}", ros.namespace.trim_matches('/'));
    NodeName::new(&namespace, &ros.node).map_err(|e| wrong(&e))
}

/// Resolved name of a topic or service: absolute names stay, `~/` stands for the node, and others are in its namespace.
pub fn resolved(ros: &RosProgram, name: &str) -> String {
    let namespace = ros.namespace.trim_matches('/');
    let parts = |own: &str| -> String {
        let all = [namespace, own].into_iter().filter(|part| !part.is_empty());
        all.fold(String::new(), |name, part| name + "/" + part)
    };
    match (name.strip_prefix("~/"), name.starts_with('/')) {
        (Some(rest), _) => format!("{}/{rest}", parts(&ros.node)),
        (None, true) => name.to_string(),
        (None, false) => parts(name),
    }
}

/// A resolved name for the client library.
///
/// # Errors
/// It is none for ROS 2.
pub fn absolute(name: &str) -> Result<Name, RosError> {
    Name::parse(name).map_err(|e| RosError::Name { name: name.to_string(), why: e.to_string() })
}

/// Type of a message: `std_msgs/Bool`.
pub fn message_type(name: &str) -> MessageTypeName {
    let (package, name) = name.split_once('/').unwrap_or(("", name));
    MessageTypeName::new(package, name)
}

/// Type of a message in the words of ROS, from its name in DDS: `std_msgs::msg::dds_::Bool_`.
pub fn from_dds(name: &str) -> String {
    let name = name.replace("::msg::dds_::", "/").replace("::srv::dds_::", "/");
    name.strip_suffix('_').unwrap_or(&name).to_string()
}

/// Type of the services.
pub fn trigger() -> ServiceTypeName {
    ServiceTypeName::new("std_srvs", "Trigger")
}

/// A text as a part of a name: letters, digits and `_`; other characters become `_`, and dots slashes.
pub fn part(text: &str) -> String {
    let one = |c: char| match c {
        '.' => '/',
        c if c.is_ascii_alphanumeric() => c,
        _ => '_',
    };
    text.chars().map(one).collect()
}
