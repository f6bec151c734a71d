//! Events of an exploration in the words of the language and of people.

use super::polygon::Point;
use super::problem::Problem;
use crate::kind::Event as Named;
use crate::numbers::MAX_NUMBER;

/// An event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A robot breaks down where it is.
    RobotLost {
        /// The robot.
        robot: usize,
    },
    /// A robot takes part again.
    RobotBack {
        /// The robot.
        robot: usize,
    },
    /// Nobody knows where the person is.
    PersonLost,
    /// The person is seen again.
    PersonBack,
    /// The person stands for a time (s).
    Late {
        /// The time.
        by: f64,
    },
    /// The person walks to a place, and then as the model says.
    Strays {
        /// The place (m).
        to: Point,
    },
    /// The person says where they are.
    MyPose {
        /// The place (m).
        at: Point,
    },
    /// The person says that they have left.
    Done,
}

/// The event of the execution.
///
/// # Errors
/// The reason why there is no such event.
pub(super) fn typed(problem: &Problem, of: &Named) -> Result<Event, String> {
    let name = of.event.as_str();
    let robots = problem.robots.len();
    let member = of.member.filter(|member| *member <= robots);
    let member = member.ok_or_else(|| format!("`{name}` names a member that does not exist, or a target"))?;
    let person = member == robots;
    let place = || {
        let to = of.point("to").filter(|to| to.iter().all(|x| x.abs() <= MAX_NUMBER));
        to.ok_or_else(|| format!("`{name}` needs `to`"))
    };
    match (name, person) {
        ("lost", false) => Ok(Event::RobotLost { robot: member }),
        ("back", false) => Ok(Event::RobotBack { robot: member }),
        ("lost", true) => Ok(Event::PersonLost),
        ("back", true) => Ok(Event::PersonBack),
        ("late", true) => {
            let by = of.number("by").filter(|by| (0.0..=MAX_NUMBER).contains(by));
            Ok(Event::Late { by: by.ok_or("`late` needs `by`, a time of zero or more")? })
        }
        ("strays", true) => Ok(Event::Strays { to: place()? }),
        ("my_pose", true) => Ok(Event::MyPose { at: place()? }),
        ("done", true) => Ok(Event::Done),
        (other, _) => Err(format!("an exploration has no event `{other}` of this member")),
    }
}

/// The words for an event.
pub(super) fn words(problem: &Problem, event: &Event) -> String {
    let person = problem.person_label();
    match event {
        Event::RobotLost { robot } => format!("{} is lost", problem.robot_label(*robot)),
        Event::RobotBack { robot } => format!("{} is back", problem.robot_label(*robot)),
        Event::PersonLost => format!("{person} is out of sight"),
        Event::PersonBack => format!("{person} is in sight again"),
        Event::Late { by } => format!("{person} stands for {by:.1} s"),
        Event::Strays { to } => format!("{person} walks to ({:.1}, {:.1}) m", to[0], to[1]),
        Event::MyPose { at } => format!("{person} says to be at ({:.1}, {:.1}) m", at[0], at[1]),
        Event::Done => format!("{person} says to have left"),
    }
}

/// The words for an event by its name.
pub(super) fn describe(problem: &Problem, of: &Named) -> String {
    typed(problem, of).map_or_else(|_| of.event.clone(), |event| words(problem, &event))
}
