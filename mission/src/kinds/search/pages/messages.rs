//! The messages of srs section 7.1 on a person's page: *My pose*, *My goal*, *Robot goal*, *Robot pose*, *Replan*; the roles
//! that follow from them (section 6), and how often each was sent.

use serde::Deserialize;
use serde_json::{Value, json};

use super::super::event::typed;
use super::super::execution::{MessageCounts, Role};
use super::super::habits::ReminderKind;
use super::SearchPages;
use crate::kind::pages::words::clock_time;
use crate::kind::pages::{Button, ButtonGroup, JournalSink, PageReminder, Pages, PlanUpdate, PointInput, Refusal};
use crate::kind::{Detail, Event};

/// Time by which the clock of a phone may be ahead (s).
const AHEAD: f64 = 2.0;

/// A message, with the number and the time by which one that comes twice or late is recognised.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Message {
    /// Number of messages that the person had sent before.
    number: usize,
    /// Mission time at which it was true (s); none: now.
    #[serde(default)]
    time: Option<f64>,
    /// The place that it is about (m).
    #[serde(default)]
    to: Option<[f64; 2]>,
    /// Index of the agent that it is about, if that is not the person.
    #[serde(default)]
    agent: Option<usize>,
}

impl Message {
    /// The agent that it is about.
    pub fn agent(self) -> Result<usize, Refusal> {
        self.agent.ok_or_else(|| Refusal::Invalid("`agent` is missing".into()))
    }
}

/// Messages of a person.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sent {
    counts: MessageCounts,
    /// Number of all messages, those that withdraw a goal included.
    number: usize,
    /// Time of the last message (s).
    last: f64,
}

/// The words for the effect on the plan.
pub(super) fn planned(update: PlanUpdate) -> &'static str {
    match update {
        PlanUpdate::Replanned => "There is a new plan.",
        PlanUpdate::Rescheduled | PlanUpdate::Unchanged => "The plan stays.",
    }
}

impl SearchPages {
    /// Takes a message of a person. One that is impossible changes nothing, and is not recorded.
    pub(super) fn send(
        &mut self,
        member: usize,
        message: Message,
        name: &str,
        about: usize,
        journal: &mut JournalSink<'_>,
    ) -> Result<String, Refusal> {
        let event = Event::of(name, about);
        let event = message.to.map_or(event.clone(), |to| event.and("to", Detail::Point(to)));
        let now = self.run.execution.time();
        let sent = self.sent.get(&member).copied().unwrap_or_default();
        if message.number < sent.number {
            return Ok("This message is noted already.".into());
        }
        if message.number > sent.number {
            return Err(Refusal::NotNow("This page is not up to date: look at it, and send the message again.".into()));
        }
        if message.time.is_some_and(|time| !time.is_finite()) {
            return Err(Refusal::Invalid("`time` is no number".into()));
        }
        let time = message.time.unwrap_or(now);
        if time > now + AHEAD {
            let (then, now) = (clock_time(time), clock_time(now));
            return Err(Refusal::NotNow(format!(
                "This message is from the future: it says {then}, and the mission is at {now}. Nothing was recorded."
            )));
        }
        if time < sent.last {
            return Err(Refusal::NotNow("A later message of yours is noted already. Nothing was recorded.".into()));
        }
        // A place in a wall or outside the map is refused before anything is recorded.
        let possible = typed(self.problem(), &event).map_err(Refusal::Invalid)?;
        let refused = self.run.execution.check_event(possible);
        refused.map_err(|why| Refusal::NotNow(format!("Not possible now: {why}. Nothing was recorded.")))?;
        let update = self.happen(&event, journal)?;
        let own = self.sent.entry(member).or_default();
        (own.number, own.last) = (own.number + 1, time.min(now));
        let counts = &mut own.counts;
        match name {
            "my_pose" => counts.poses += 1,
            "my_goal" => counts.goals += 1,
            "robot_goal" => counts.robot_goals += 1,
            "robot_pose" => counts.robot_poses += 1,
            "replan" => counts.replans += 1,
            _ => {}
        }
        let whom = self.problem().agent_label(about).to_string();
        let place = message.to.map_or_else(String::new, |[x, y]| format!("({x:.1}, {y:.1}) m"));
        let noted = match name {
            "my_pose" => format!("Noted: you are at {place}."),
            "my_goal" => format!("Noted: you go to {place}."),
            "robot_goal" => format!("Noted: {whom} goes to {place}."),
            "robot_pose" => format!("Noted: {whom} is at {place}."),
            _ => "Noted.".into(),
        };
        Ok(format!("{noted} {}", planned(update)))
    }

    /// The buttons of the messages.
    pub(super) fn message_buttons(&self, member: usize, here: bool) -> Vec<ButtonGroup> {
        let (problem, of) = (self.problem(), &self.run.execution);
        let Sent { counts, number, .. } = self.sent.get(&member).copied().unwrap_or_default();
        let request = |what: &str, more: &[(&str, Value)]| {
            let mut request = json!({ "what": what, "number": number });
            more.iter().for_each(|(key, value)| request[*key] = value.clone());
            request
        };
        let at = |button: Button, prompt: String| Button { point: Some(PointInput { key: "to", prompt }), ..button };
        let counters = problem.reminder.is_some_and(|of| of.kind == ReminderKind::Counters);
        let used = |button: Button, uses: usize| Button { uses: counters.then_some(uses), ..button };
        let own = vec![
            used(at(Button::main("my_pose", "My pose", here, request("my_pose", &[])), "I am at".into()), counts.poses),
            used(at(Button::new("my_goal", "My goal", here, request("my_goal", &[])), "I go to".into()), counts.goals),
            Button::new("replan", "Replan", here, request("replan", &[])),
        ];
        let sent = [
            (counts.poses, "pose"),
            (counts.goals, "goal"),
            (counts.robot_goals, "robot goal"),
            (counts.robot_poses, "robot pose"),
            (counts.replans, "replan"),
        ];
        let sent: Vec<String> = sent
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}{}", if count == 1 { "" } else { "s" }))
            .collect();
        let heading = if sent.is_empty() { "Messages".into() } else { format!("Messages, sent: {}", sent.join(", ")) };
        let mut groups = vec![ButtonGroup { heading, buttons: own }];
        let robots = problem.agents.iter().enumerate().filter(|(_, who)| !who.human);
        for (robot, who) in robots {
            let name = problem.agent_label(robot);
            let (may, with) = (here && !who.lost, [("agent", json!(robot))]);
            let goal = Button::new(format!("robot_goal_{robot}"), "Robot goal", may, request("robot_goal", &with));
            let pose = Button::new(format!("robot_pose_{robot}"), "Robot pose", may, request("robot_pose", &with));
            let buttons =
                vec![used(at(goal, format!("{name} goes to")), counts.robot_goals), at(pose, format!("{name} is at"))];
            groups.push(ButtonGroup { heading: name.into(), buttons });
        }
        let told = (0..problem.agents.len()).filter(|agent| of.told_goal(*agent).is_some());
        let free = |agent: usize| {
            let mine = agent == member;
            let text = if mine { "Withdraw my goal" } else { "Withdraw goal" };
            let button = Button::new(format!("free_{agent}"), text, here, request("free", &[("agent", json!(agent))]));
            let heading = format!("Goal told for {}", if mine { "you" } else { problem.agent_label(agent) });
            ButtonGroup { heading, buttons: vec![button] }
        };
        groups.extend(told.filter(|agent| *agent == member || !problem.agents[*agent].human).map(free));
        groups
    }

    /// The reminder that a person has not followed yet.
    pub(super) fn reminder(&self, member: usize) -> Option<PageReminder> {
        let of = &self.run.execution;
        let reminder = self.problem().reminder.filter(|_| of.is_reminded(member) > 0 && !of.done())?;
        let lost = self.problem().agents.get(member).is_none_or(|who| who.lost);
        let text = "Where are you? Send your pose.".into();
        let (number, kind) = (of.reminders(member), reminder.kind.name());
        (!lost).then_some(PageReminder { number, kind, button: "my_pose", text })
    }

    /// The present roles, as a sentence.
    pub(super) fn roles(&self) -> String {
        let role = self.run.execution.role();
        let who = match role {
            Role::LeaderFollower => "the plan decides all goals",
            Role::PeerToPeer => "people decide their goals, and the plan those of robots",
            Role::MasterSlave => "people decide the goals of all",
            Role::LeaderLeader => "people decide the goals of robots, and the plan those of people",
        };
        format!("Roles: {}; {who}.", role.name())
    }
}
