//! Reminders of people to send their pose (srs 7.2), and the times between the messages *My pose* (TBM, srs table 1).
//!
//! A person is reminded when a time has passed since the last pose, or since the start; without a pose after a shorter one again, and so on.
//! A pose resets the time. Reminders are entries of the log; pages show them.

use super::SearchExecution;
use super::record::LogEntry;
use super::steps::Step;
use crate::kinds::search::problem::Problem;

/// Time from a reminder to the pose of a simulated person who heeds it (s). Ours.
const REACTION: f64 = 1.5;
/// Threshold of the times between messages where nothing else is written (s), srs 8.4.1.
const THRESHOLD: f64 = 10.0;

/// Poses and reminders of an agent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Poses {
    /// Time of the last pose (s).
    last: Option<f64>,
    /// Number of poses.
    count: usize,
    /// Number of times between two poses.
    times: usize,
    /// Number of those below the threshold.
    prompt: usize,
    /// Time of the last pose or reminder, from which the next reminder counts (s).
    since: f64,
    /// Number of reminders since the last pose.
    reminders: usize,
    /// Number of all reminders.
    all: usize,
}

impl Poses {
    /// Nobody has sent anything.
    pub fn none(problem: &Problem) -> Poses {
        Poses { since: problem.start, ..Poses::default() }
    }
}

impl SearchExecution {
    /// Threshold below which the time between two poses of an agent is short enough (s): that of the habits, else that of the reminder.
    fn threshold(&self, agent: usize) -> f64 {
        let habits = self.problem.agents.get(agent).and_then(|who| who.habits?.my_pose);
        let reminder = self.problem.reminder.map(|reminder| reminder.after);
        habits.map(|times| times.below).or(reminder).unwrap_or(THRESHOLD)
    }

    /// Number of reminders that an agent got.
    pub fn reminders(&self, agent: usize) -> usize {
        self.world.poses.get(agent).map_or(0, |poses| poses.all)
    }

    /// Number of reminders since the last pose of an agent: more than 0 until the pose is sent.
    pub fn is_reminded(&self, agent: usize) -> usize {
        self.world.poses.get(agent).map_or(0, |poses| poses.reminders)
    }

    /// Number of messages *My pose* of an agent.
    pub fn poses(&self, agent: usize) -> usize {
        self.world.poses.get(agent).map_or(0, |poses| poses.count)
    }

    /// Number of times between the poses of an agent, and of those below the threshold.
    pub fn times_between_poses(&self, agent: usize) -> [usize; 2] {
        self.world.poses.get(agent).map_or([0; 2], |poses| [poses.times, poses.prompt])
    }

    /// An agent has said where it is.
    pub(super) fn count_pose(&mut self, agent: usize) {
        let (now, threshold) = (self.time, self.threshold(agent));
        let Some(poses) = self.world.poses.get_mut(agent) else { return };
        if let Some(last) = poses.last {
            poses.times += 1;
            poses.prompt += usize::from(now - last < threshold);
        }
        poses.count += 1;
        (poses.last, poses.since, poses.reminders) = (Some(now), now, 0);
        self.pose_was_sent(agent);
    }

    /// The steps of reminders.
    pub(super) fn steps_of_reminders(&self) -> Vec<(f64, Step)> {
        let Some(reminder) = self.problem.reminder.filter(|_| !self.done()) else { return Vec::new() };
        let people = self.problem.agents.iter().enumerate().filter(|(_, who)| who.human && !who.lost);
        let step = |(agent, _): (usize, _)| {
            let poses = self.world.poses.get(agent)?;
            let due = poses.since + reminder.wait(poses.reminders)?;
            (due <= self.problem.horizon).then_some((due, Step::Reminds(agent)))
        };
        people.filter_map(step).collect()
    }

    /// A person is reminded.
    pub(super) fn remind(&mut self, agent: usize) {
        let now = self.time;
        let Some(poses) = self.world.poses.get_mut(agent) else { return };
        (poses.since, poses.reminders, poses.all) = (now, poses.reminders + 1, poses.all + 1);
        let number = poses.all;
        self.record(LogEntry::Reminded { agent });
        self.heed(agent, number, REACTION);
    }
}
