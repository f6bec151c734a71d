//! Habits and reminders from their declarations, and their mistakes: times between messages that contradict each other, habits of
//! robots, reminders of nobody, and habits without an effect.

use blocks::{Bound, BoundBlock, Help, Snippet};

use super::check::{Item, Mistake};
use super::habits::{Habits, Intervals, OwnGoal, Reminder, ReminderKind};
use super::habits_blocks::{HabitsBlock, ReminderBlock};
use super::problem::Problem;
use crate::declare::{Origins, Remark, Remarks};

/// Code of times that no distribution has.
const TIMES: &str = "HQ0954";
/// Code of habits and reminders of nobody.
const NOBODY: &str = "HQ0955";
/// Code of a habit without an effect.
const NO_EFFECT: &str = "HQ0956";

/// Keys of the blocks inside an agent or the mission, as parts of it.
const PARTS: [(&str, &str, &str); 12] = [
    ("habits", "my_pose", "habits.my_pose"),
    ("habits", "own_goal", "habits.own_goal"),
    ("habits", "my_goal", "habits.my_goal"),
    ("habits", "robot_goal", "habits.robot_goal"),
    ("habits", "robot_goal_alone", "habits.robot_goal_alone"),
    ("habits", "heeds", "habits.heeds"),
    ("my_pose", "mean", "my_pose.mean"),
    ("my_pose", "share", "my_pose.share"),
    ("my_pose", "below", "my_pose.below"),
    ("reminder", "kind", "reminder.kind"),
    ("reminder", "after", "reminder.after"),
    ("reminder", "least", "reminder.least"),
];

/// Notes the places of keys inside the blocks of habits and reminders.
pub(super) fn add_places<'m>(item: Item, settings: &'m BoundBlock, places: &mut Origins<'m, Item>) {
    let inner = |of: &'m BoundBlock, key: &str| match of.get(key).map(|value| &value.value) {
        Some(Bound::Block(block)) => Some(block),
        _ => None,
    };
    let habits = inner(settings, "habits");
    let intervals = habits.and_then(|habits| inner(habits, "my_pose"));
    for (block, key, part) in PARTS {
        let of = match block {
            "habits" => habits,
            "my_pose" => intervals,
            _ => inner(settings, "reminder"),
        };
        if let Some(at) = of.and_then(|of| of.origin(key)) {
            places.add_part(item, part, at);
        }
    }
}

pub(super) fn habits(block: HabitsBlock) -> Habits {
    let own_goal = OwnGoal::NAMES.iter().position(|name| *name == block.own_goal);
    Habits {
        my_pose: block.my_pose.map(|of| Intervals { mean: of.mean, share: of.share, below: of.below }),
        follows: block.follows,
        own_goal: own_goal.map_or(OwnGoal::Greedy, |index| OwnGoal::ALL[index]),
        goals_beyond: block.goals_beyond,
        my_goal: block.my_goal,
        robot_goal: block.robot_goal,
        robot_goal_alone: block.robot_goal_alone,
        replan: block.replan,
        heeds: block.heeds,
    }
}

pub(super) fn reminder(block: ReminderBlock) -> Reminder {
    let kind = ReminderKind::NAMES.iter().position(|name| *name == block.kind);
    Reminder {
        kind: kind.map_or(ReminderKind::Multimodal, |index| ReminderKind::ALL[index]),
        after: block.after,
        shorten: block.shorten,
        least: block.least,
    }
}

/// Returns true if every number of the habits and of the reminder is in its range.
pub(super) fn in_range(p: &Problem) -> bool {
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let share = |x: f64| (0.0..=1.0).contains(&x);
    let habits = p.agents.iter().filter_map(|who| who.habits).all(|of| {
        let shares = [of.follows, of.my_goal, of.robot_goal, of.robot_goal_alone, of.replan, of.heeds];
        let times = of.my_pose.is_none_or(|t| positive(t.mean) && positive(t.below) && t.share.is_none_or(share));
        times && of.goals_beyond.is_finite() && of.goals_beyond >= 0.0 && shares.into_iter().all(share)
    });
    let reminder =
        p.reminder.is_none_or(|of| positive(of.after) && positive(of.least) && (0.1..=1.0).contains(&of.shorten));
    habits && reminder
}

/// Habits and reminders that cannot be.
pub(super) fn people(p: &Problem, found: &mut Vec<Mistake>) {
    for (i, who) in p.agents.iter().enumerate() {
        let Some(habits) = who.habits else { continue };
        if !who.human {
            let text = format!("`{}` is a robot, and has habits", who.name);
            let help = "remove `habits`, or declare the agent as a `human`";
            let mistake = Mistake::new(NOBODY, Item::Agent(i), &["habits"], text, help);
            found.push(Mistake { note: Some("a robot follows the plan and sends no messages"), ..mistake });
            continue;
        }
        let Some(times) = habits.my_pose else { continue };
        if let (Err([least, most]), Some(share)) = (times.distribution(), times.share) {
            let text = format!(
                "no times between messages have a mean of {} s and {} % of them below {} s",
                times.mean,
                (1e4 * share).round() / 1e2,
                times.below
            );
            // Rounded into the range, so that the proposed share is possible.
            let least = (1e4 * least).ceil() / 1e4;
            let most = (1e4 * most).floor() / 1e4;
            let near = if share < least { least } else { most };
            let help = Help::with(
                "write a share from {} to {}, for instance {}, or another mean",
                [
                    Snippet::same(format!("{least}")),
                    Snippet::same(format!("{most}")),
                    Snippet::entry("share", format!("{near}")),
                ],
            );
            let keys = &["my_pose.share", "habits.my_pose", "habits"];
            let mistake = Mistake::new(TIMES, Item::Agent(i), keys, text, help);
            let against = Some((Item::Agent(i), &["my_pose.mean", "habits"][..], "the mean"));
            found.push(Mistake { against, note: Some("the times have a Weibull distribution"), ..mistake });
        }
    }
    let Some(reminder) = p.reminder else { return };
    if p.agents.iter().all(|who| !who.human) {
        let text = "nobody is reminded: this search has no person".to_string();
        let person =
            Snippet::declared("human", "NAME", [Snippet::entry("start", "[0, 0] m"), Snippet::entry("speed", "1 m/s")]);
        let help = Help::with("declare one, {}, or remove `reminder`", [person]);
        found.push(Mistake::new(NOBODY, Item::Mission, &["reminder"], text, help));
    }
    if reminder.least > reminder.after {
        let text = format!(
            "the first reminder comes after {} s, and reminders are at least {} s apart",
            reminder.after, reminder.least
        );
        let help = Help::with("write for instance {}", [Snippet::entry("least", format!("{} s", reminder.after))]);
        // A time that is not written is the usual one.
        let keys = &["reminder.least", "reminder.after", "reminder"];
        let mistake = Mistake::new(TIMES, Item::Mission, keys, text, help);
        let note = (reminder.least == 4.0).then_some("`least` is 4 s if it is not written");
        found.push(Mistake { note, ..mistake });
    }
}

/// Warns of habits without an effect.
pub(super) fn without_effect(p: &Problem, places: &Origins<'_, Item>, remarks: &mut Remarks) {
    let robots = p.agents.iter().any(|who| !who.human);
    for (i, who) in p.agents.iter().enumerate().filter(|(_, who)| who.human) {
        let Some(habits) = who.habits else { continue };
        let name = &who.name;
        let mut warn = |part: &'static str, text: String, help: Help| {
            // Only what is written can be without an effect.
            if let Some(at) = places.written(Item::Agent(i), &[part]) {
                remarks.push(Remark::warning(NO_EFFECT, at, text).help(help));
            }
        };
        if p.reminder.and_then(|of| of.wait(0)).is_none() {
            let text = format!("`{name}` heeds reminders, and nobody is reminded in this search");
            let remind =
                Snippet::block("reminder", [Snippet::entry("kind", "multimodal"), Snippet::entry("after", "10 s")]);
            warn("habits.heeds", text, Help::with("write {} for the mission, or remove `heeds`", [remind]));
        }
        let leaves = habits.follows < 1.0;
        let leave = || Help::with("write for instance {}, or remove it", [Snippet::entry("follows", "0.7")]);
        if !leaves {
            for (part, of) in [("habits.own_goal", "the choice of goals"), ("habits.my_goal", "*My goal*")] {
                let text =
                    format!("{of} has no effect: `{name}` always follows the plan, and has no goals of their own");
                warn(part, text, leave());
            }
        }
        if !robots {
            for part in ["habits.robot_goal", "habits.robot_goal_alone"] {
                let text = format!("`{name}` tells goals of robots, and this search has no robot");
                warn(part, text, "remove it, or declare a robot".into());
            }
        } else if leaves && habits.my_goal == 0.0 {
            let text = format!("*Robot goal* has no effect: it comes after *My goal*, which `{name}` never sends");
            let help = Help::with(
                "write for instance {}, or {}",
                [Snippet::entry("my_goal", "0.8"), Snippet::entry("robot_goal_alone", "0.3")],
            );
            warn("habits.robot_goal", text, help);
        } else if !leaves {
            let text =
                format!("*Robot goal* has no effect: it comes after *My goal*, and `{name}` always follows the plan");
            warn("habits.robot_goal", text, leave());
        }
    }
}
