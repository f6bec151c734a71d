//! The topics and services of a program, for people to read.

use runtime::program::{CommandForm, Program, RosProgram};

use crate::names::{part, resolved};

/// A topic or a service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// Role: `reads`, `writes`, `service`.
    pub role: &'static str,
    /// Resolved name.
    pub name: String,
    /// Type of its messages.
    pub kind: String,
    /// Content.
    pub content: String,
}

/// Topics that are read, those of commands and requests, and services.
pub fn connections(program: &Program, ros: &RosProgram) -> Vec<Connection> {
    let row = |role, name: &str, kind: &str, content: String| Connection {
        role,
        name: resolved(ros, name),
        kind: kind.to_string(),
        content,
    };
    let mut all = Vec::new();
    for states in &ros.joint_states {
        all.push(row("reads", &states.topic, "sensor_msgs/JointState", "positions of joints".to_string()));
    }
    let model = &program.robot.model;
    for odometry in &ros.odometry {
        let of = model.bases.get(odometry.base).map_or("base", |base| base.link_name(model));
        let content =
            if model.bases.len() > 1 { format!("pose of the base `{of}`") } else { "pose of the base".to_string() };
        all.push(row("reads", &odometry.topic, "nav_msgs/Odometry", content));
    }
    for topic in &ros.signals {
        let name = program.interface.signals.get(topic.signal).map_or("", |s| s.name.as_str());
        let latched = if topic.latched { ", latched" } else { "" };
        all.push(row("reads", &topic.topic, &topic.message, format!("signal {name}{latched}")));
    }
    all.push(row("reads", "/tf_static", "tf2_msgs/TFMessage", "fixed transforms".to_string()));
    for command in &ros.commands {
        let names = command.dofs.iter().filter_map(|d| program.robot.model.dofs.get(*d)).map(|d| d.name.as_str());
        let what = match command.form {
            CommandForm::Velocity => "velocities of",
            CommandForm::Position => "positions of",
            CommandForm::Trajectory => "trajectory of",
            CommandForm::Twist => "velocity of the base:",
        };
        let names: Vec<&str> = names.collect();
        all.push(row("writes", &command.topic, command.form.message(), format!("{what} {}", names.join(", "))));
    }
    if program.machine.is_some() {
        all.push(row("writes", "~/actions", "std_msgs/String", "requests of the machine".to_string()));
    }
    for event in crate::services::raised_by_others(program) {
        let content = format!("event {}", event.name);
        all.push(row("service", &format!("~/{}", part(event.name)), "std_srvs/Trigger", content));
    }
    for service in crate::services::own(program) {
        all.push(row("service", &format!("~/{}", service.name), "std_srvs/Trigger", service.content.to_string()));
    }
    all
}
