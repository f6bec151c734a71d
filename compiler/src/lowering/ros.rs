//! Lowers `ros` blocks: the topics of ROS 2 that a controller reads and writes.

use std::collections::BTreeMap;

use blocks::{Block as _, ByName, Located, Unbound};
use dsl::tree::{Block, Entry};
use dsl::{Diagnostic, Span, Spanned};
use names::list;
use robot::{MobileBase, Model};
use runtime::program::{
    BaseOdometry, CommandForm, CommandTopic, JointStates, RosProgram, SignalTopic, TickSource, wrong_topic,
};

use super::Lowerer;
use crate::block_binding::Scope;
use crate::forms::block_of;
use crate::robot_binding::{BoundRobot, joints};
use crate::sections::{CommandTopicBlock, RosBlock, SIGNAL_TOPIC, SignalTopicBlock};

/// A topic of commands, with the span of its name.
struct Written {
    command: CommandTopic,
    at: Span,
}

impl Lowerer<'_> {
    /// The connection of a `ros` block. Parts with a mistake are left out.
    pub(super) fn ros(&mut self, block: &RosBlock, robot: &BoundRobot) -> RosProgram {
        if block.stale_after.value < robot.period {
            let span = self.origins.span(block.stale_after.at);
            let d = Diagnostic::error("HQ0823", span, "positions of joints would be stale before the next tick");
            let d = d.label(robot.rate_span, format!("one tick is {} s", robot.period));
            self.push(d.help("write the time of a few ticks, 50 ms for instance"));
        }
        block.namespace.as_ref().map(|topic| self.topic(topic));
        let odometry = block.odometry.as_ref().and_then(|topic| self.odometry(topic, &robot.model));
        if let Some(node) = &block.node
            && (node.value.contains(['/', '~']) || wrong_topic(&node.value).is_some())
        {
            let span = self.origins.span(node.at);
            let d = Diagnostic::error("HQ0823", span, format!("`{}` is no name of a node", node.value));
            self.push(d.help("write letters, digits and `_`, and no digit in the first place"));
        }
        let mut joint_states = Vec::new();
        for ByName { value, .. } in &block.joint_states {
            let (topic, prefix) = (&value.value.topic, value.value.prefix.clone().unwrap_or_default());
            joint_states.extend(topic.as_ref().and_then(|t| self.topic(t)).map(|topic| JointStates { topic, prefix }));
        }
        let commands: Vec<Written> = block.commands.iter().filter_map(|c| self.command_topic(c, robot)).collect();
        self.same_topic(&commands);
        let commands: Vec<CommandTopic> = commands.into_iter().map(|c| c.command).collect();
        if let Some(first) = block.commands.first().filter(|_| commands.len() == block.commands.len()) {
            self.not_commanded(&commands, &robot.model, first.name.at);
        }
        let mut signals = Vec::new();
        for e in self.entries_of(block.signals.as_ref()) {
            let own = block_of(&e.value, "the topic of a signal", self.diagnostics);
            signals.extend(own.and_then(|own| self.signal_topic(&e.key, own)));
        }
        for human in self.entries_of(block.humans.as_ref()) {
            let points = block_of(&human.value, "the topics of a human", self.diagnostics);
            for e in points.iter().flat_map(|points| &points.entries) {
                let own = block_of(&e.value, "the topic of a point", self.diagnostics);
                let name = Spanned::new(format!("{}.{}", human.key.value, e.key.value), e.key.span);
                signals.extend(own.and_then(|own| self.signal_topic(&name, own)));
            }
        }
        let text = |of: &Option<Located<String>>| of.as_ref().map(|t| t.value.clone());
        RosProgram {
            node: text(&block.node).unwrap_or_else(|| RosProgram::default().node),
            namespace: text(&block.namespace).unwrap_or_else(|| RosProgram::default().namespace),
            tick: if block.tick == "joint_states" { TickSource::JointStates } else { TickSource::Timer },
            stale_after: block.stale_after.value,
            world: block.world_frame.clone().unwrap_or_else(|| RosProgram::default().world),
            transforms: block.transforms,
            joint_states,
            odometry: odometry.into_iter().collect(),
            commands,
            signals,
        }
    }

    /// Entries of a block that is bound here.
    fn entries_of(&mut self, at: Option<&Located<Unbound>>) -> Vec<Entry> {
        let value = at.and_then(|at| self.origins.unbound(at)).cloned();
        let block = value.as_ref().and_then(|value| block_of(value, "this", self.diagnostics));
        block.map(|block| block.entries.clone()).unwrap_or_default()
    }

    /// The name of a topic, if it is one.
    fn topic(&mut self, topic: &Located<String>) -> Option<String> {
        let Some(why) = wrong_topic(&topic.value) else { return Some(topic.value.clone()) };
        let span = self.origins.span(topic.at);
        let text = format!("`{}` is no name of a topic: {why}", topic.value);
        let d = Diagnostic::error("HQ0823", span, text);
        self.push(
            d.help("write letters, digits and `_` between slashes: `/arm_controller/commands`, `wrench`, `~/goal`"),
        );
        None
    }

    /// The topic with the pose of the base. Those of several bases have names of their own.
    fn odometry(&mut self, topic: &Located<String>, model: &Model) -> Option<BaseOdometry> {
        let name = self.topic(topic)?;
        match model.bases.len() {
            0 => None,
            1 => Some(BaseOdometry { topic: name, base: 0 }),
            _ => {
                let text = "one topic cannot have the poses of several bases";
                let d = Diagnostic::error("HQ0823", self.origins.span(topic.at), text);
                let usual =
                    model.bases.iter().map(|base| format!("/{}/odom", base.prefix(model).trim_end_matches('_')));
                let usual: Vec<String> = usual.collect();
                let usual = list(usual.iter().map(String::as_str), 4);
                self.push(d.help(format!("leave it out: the poses are read from {usual}, which ROS 2 can remap")));
                None
            }
        }
    }

    fn command_topic(&mut self, of: &ByName<CommandTopicBlock>, robot: &BoundRobot) -> Option<Written> {
        let block = &of.value.value;
        let at = self.origins.span(of.name.at);
        let model = &robot.model;
        let form = match block.form {
            "position" => CommandForm::Position,
            "trajectory" => CommandForm::Trajectory,
            "twist" => CommandForm::Twist,
            _ => CommandForm::Velocity,
        };
        let dofs = match &block.joints {
            Some(joints_at) => {
                let value = self.origins.unbound(joints_at)?.clone();
                if form == CommandForm::Twist && model.bases.len() < 2 {
                    let d = Diagnostic::error("HQ0823", value.span, "a `twist` moves the base, and no joints");
                    self.push(d.help("leave `joints` out, or write another `form`"));
                    return None;
                }
                let dofs = joints(value.items(), model, &robot.joint_groups, self.diagnostics)?;
                if form == CommandForm::Twist {
                    if !model.bases.iter().any(|base| base.dofs().eq(dofs.iter().copied())) {
                        let d = Diagnostic::error("HQ0823", value.span, "a `twist` moves one base, and nothing else");
                        self.push(d.help(format!("write one of {}", groups_of_bases(model))));
                        return None;
                    }
                } else if dofs.iter().any(|dof| model.base_of_dof(*dof).is_some()) {
                    let text = "the base is no joint, and has a topic of its own";
                    let d = Diagnostic::error("HQ0823", value.span, text);
                    self.push(d.help("take it out of this list, and add a topic of the form `twist`"));
                    return None;
                }
                dofs
            }
            None if form == CommandForm::Twist => match model.bases.as_slice() {
                [base] => base.dofs().collect(),
                [] => {
                    let text = "a `twist` moves the base, and the base of this robot is fixed";
                    let d = Diagnostic::error("HQ0823", at, text);
                    let help =
                        "leave this topic out, or write `base planar`, `base unicycle` or `base floating` in the robot";
                    self.push(d.help(help));
                    return None;
                }
                _ => {
                    let d = Diagnostic::error("HQ0823", at, "a `twist` moves one base, and here are several");
                    self.push(d.help(format!("name it as `joints`: one of {}", groups_of_bases(model))));
                    return None;
                }
            },
            None => (0..model.nv()).filter(|dof| model.base_of_dof(*dof).is_none()).collect(),
        };
        let prefix = block.prefix.clone().unwrap_or_default();
        let topic = self.topic(block.topic.as_ref()?)?;
        let to = block.topic.as_ref().map_or(at, |t| self.origins.span(t.at));
        Some(Written { command: CommandTopic { name: of.name.value.clone(), topic, form, dofs, prefix }, at: to })
    }

    /// Reports topics that two commands are sent to.
    fn same_topic(&mut self, all: &[Written]) {
        let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
        for Written { command: CommandTopic { topic, .. }, at } in all {
            let at = *at;
            if let Some(first) = seen.insert(topic, at) {
                let text = format!("two commands are sent to `{topic}`");
                let d = Diagnostic::error("HQ0823", at, text).label(first, "the other one");
                self.push(d.help("give each command a topic of its own: a reader cannot tell them apart"));
            }
        }
    }

    /// Warns of joints whose commands are sent nowhere.
    fn not_commanded(&mut self, commands: &[CommandTopic], model: &Model, at: blocks::Origin) {
        let sent = |dof: usize| commands.iter().any(|c| c.dofs.contains(&dof));
        let left: Vec<&str> =
            model.dofs.iter().enumerate().filter(|(i, _)| !sent(*i)).map(|(_, d)| d.name.as_str()).collect();
        if left.is_empty() {
            return;
        }
        let (is, word) = if left.len() == 1 { ("is", "command") } else { ("are", "commands") };
        let text = format!("the {word} of {} {is} sent nowhere", list(left.iter().copied(), 4));
        let d = Diagnostic::warning("HQ0824", self.origins.span(at), text);
        let d = d.note("the controller counts on these motions, and the robot does not make them");
        self.push(d.help("add a topic for them, or `lock` them in the robot"));
    }

    fn signal_topic(&mut self, key: &Spanned<String>, block: &Block) -> Option<SignalTopic> {
        let bound = self.block_binder(&Scope::default()).block(block, &SIGNAL_TOPIC, key.span);
        if bound.has_wrong() {
            return None;
        }
        let block = SignalTopicBlock::read(&bound);
        let signals = || self.interface.signals.iter().enumerate();
        let Some((signal, of)) = signals().find(|(_, s)| s.name == key.value) else {
            let is_event = self.interface.events.contains(&key.value);
            let names: Vec<String> = signals().filter(|(_, s)| !s.is_variable()).map(|(_, s)| s.name.clone()).collect();
            let d = Diagnostic::undeclared("signal", &key.value, key.span);
            self.push(match is_event {
                true => d.help(format!("it is an event, which the service `~/{}` raises", key.value)),
                false => d.one_of("declared are", &key.value, names.iter().map(String::as_str)),
            });
            return None;
        };
        if of.is_variable() {
            let text = format!("`{}` is a variable, which the machine sets itself", key.value);
            self.push(Diagnostic::error("HQ0823", key.span, text).help("read the topic into a signal"));
            return None;
        }
        let possible = of.ros_messages();
        let message = match &block.message {
            None => possible[0].to_string(),
            Some(written) => {
                // Both spellings of ROS are common.
                let plain = written.value.replace("/msg/", "/");
                if !possible.contains(&plain.as_str()) {
                    let text = format!("a signal of the type `{}` is not read from `{}`", of.kind, written.value);
                    let d = Diagnostic::error("HQ0823", self.origins.span(written.at), text);
                    let help = format!("possible {}", list_of(possible));
                    self.push(d.help(help).nearest(&plain, possible.iter().copied()));
                    return None;
                }
                plain
            }
        };
        let topic = self.topic(block.topic.as_ref()?)?;
        Some(SignalTopic { signal, topic, message, frame: block.frame_id, latched: block.latched })
    }
}

/// Names of the groups of joints that are bases.
fn groups_of_bases(model: &Model) -> String {
    let group = |base: &MobileBase| format!("{}base", base.prefix(model));
    let groups: Vec<String> = model.bases.iter().map(group).collect();
    list(groups.iter().map(String::as_str), 4)
}

fn list_of(messages: &[&str]) -> String {
    let verb = if messages.len() == 1 { "is" } else { "are" };
    format!("{verb} {}", list(messages.iter().copied(), 8))
}
