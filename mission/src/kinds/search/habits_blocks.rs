//! The blocks of simulated people and of reminders.

use blocks::{ValueType, Word, block};
use quantities::Quantity;
use quantities::dimension::{NONE, TIME};

use super::habits::{OwnGoal, ReminderKind};
use crate::declare::common::{A_LENGTH, A_SHARE};

const A_TIME: ValueType = ValueType::Number(Quantity::above(TIME, 0.0));

block! {
    /// Habits of a simulated person.
    pub struct HabitsBlock = HABITS, "a block of habits" {
        /// Times between the messages *My pose*; default: none is sent by itself.
        my_pose: Option<IntervalsBlock> = optional(ValueType::Block(&INTERVALS), "{ mean 9.4 s  share 0.73 }");
        /// Probability of following the plan, at each decision: at the start, and whenever the next way begins after an arrival.
        /// Else the person goes to a goal of their own.
        follows: f64 = or(A_SHARE, "1");
        /// A goal of their own is the one with the most reward a second in the person's own belief, or the nearest of the
        /// worthwhile ones.
        own_goal: Word = or(ValueType::Choice(&OwnGoal::NAMES), "greedy");
        /// Least distance of a goal that the person chooses, for themselves or for a robot.
        goals_beyond: f64 = or(A_LENGTH, "0.5 m");
        /// Probability of sending *My goal* before going to a goal of their own; else the person strays and says nothing.
        my_goal: f64 = or(A_SHARE, "0");
        /// Probability of sending *Robot goal* after *My goal* (master-slave).
        robot_goal: f64 = or(A_SHARE, "0");
        /// Probability of sending *Robot goal* at a decision without *My goal* (leader-leader).
        robot_goal_alone: f64 = or(A_SHARE, "0");
        /// Probability of rejecting a proposed way with *Replan*, before each decision about one.
        replan: f64 = or(A_SHARE, "0");
        /// Probability of sending *My pose* after a reminder.
        heeds: f64 = or(A_SHARE, "1");
    }
}

block! {
    /// Times between the messages *My pose* of a person: a Weibull distribution.
    pub struct IntervalsBlock = INTERVALS, "a distribution of times" {
        /// Mean of the times.
        mean: f64 = required(A_TIME, "9.4 s");
        /// Share of the times that are below the threshold; default: that of the exponential distribution.
        share: Option<f64> = optional(A_SHARE, "0.73");
        /// The threshold.
        below: f64 = or(A_TIME, "10 s");
    }
}

block! {
    /// Reminders to send one's pose.
    pub struct ReminderBlock = REMINDER, "a reminder" {
        /// Form on pages: a `toast` passes, a `popup` blocks the page until the pose is sent, `multimodal` vibrates and makes the button blink,
        /// `counters` show the number of its uses on each button and remind nobody.
        kind: Word = or(ValueType::Choice(&ReminderKind::NAMES), "multimodal");
        /// Time since the last *My pose* of a person, or since the start, after which the person is reminded.
        after: f64 = or(A_TIME, "10 s");
        /// Factor of that time after each reminder in a row. A pose resets it.
        shorten: f64 = or(ValueType::Number(Quantity::between(NONE, 0.1, 1.0)), "0.8");
        /// The least time between two reminders.
        least: f64 = or(A_TIME, "4 s");
    }
}
