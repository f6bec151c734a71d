//! Names of topics, services and types.

use ros::names::{from_dds, part, resolved};
use runtime::program::{RosProgram, wrong_topic};

#[test]
fn names_are_resolved_as_in_ros() {
    // The table of https://design.ros2.org/articles/topic_and_service_names.html, "Examples".
    let ros = |namespace: &str, node: &str| RosProgram {
        namespace: namespace.to_string(),
        node: node.to_string(),
        ..RosProgram::default()
    };
    let cases = [
        ("/", "my_node", "ping", "/ping"),
        ("/my_ns", "my_node", "ping", "/my_ns/ping"),
        ("/my_ns", "my_node", "/ping", "/ping"),
        ("/", "my_node", "~/ping", "/my_node/ping"),
        ("/my_ns", "my_node", "~/ping", "/my_ns/my_node/ping"),
        ("my_ns/sub", "n", "a/b", "/my_ns/sub/a/b"),
    ];
    for (namespace, node, name, expected) in cases {
        assert_eq!(resolved(&ros(namespace, node), name), expected);
    }
}

#[test]
fn texts_that_are_no_topics_are_known() {
    for good in ["/a", "a", "~/a", "/a_1/b2", "wrench", "/", "/_hidden"] {
        assert_eq!(wrong_topic(good), None, "{good}");
    }
    for bad in ["", "~/", "/a/", "a//b", "1a", "/a/2b", "a b", "/ä", "a__b", "~a", "{ns}/a", "a.b"] {
        assert!(wrong_topic(bad).is_some(), "{bad}");
    }
}

#[test]
fn types_of_dds_are_those_of_ros() {
    assert_eq!(from_dds("std_msgs::msg::dds_::Float64_"), "std_msgs/Float64");
    assert_eq!(from_dds("std_srvs::srv::dds_::Trigger_Request_"), "std_srvs/Trigger_Request");
    assert_eq!(from_dds("something_else"), "something_else");
}

#[test]
fn events_become_parts_of_names() {
    assert_eq!(part("go"), "go");
    assert_eq!(part("gripper.done"), "gripper/done");
    assert_eq!(part("call 2"), "call_2");
    assert!(wrong_topic(&part("gripper.done")).is_none());
}
