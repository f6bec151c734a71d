//! What can be expected of a mission, written once: what each quantity is called, whose it is, its unit and what it says.
//! Expectations, their diagnostics, the language server and the page of keys derive from it.

use runtime::program::{MissionMeasure, OfAgent, OfMission, OfRobot};
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE, TIME, VELOCITY};

use crate::names::{list, suggest};

const ENERGY: Dimension = Dimension { m: 2, kg: 1, s: -2, rad: 0 };

/// Whose a quantity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whose {
    /// Of the mission, `vineyard.makespan`.
    Mission,
    /// Of a person or a working robot, `h1.waited`.
    Agent,
    /// Of a robot that serves, `m1.travelled`.
    Robot,
}

impl Whose {
    /// What a person calls it, with its article.
    pub fn describe(self) -> &'static str {
        match self {
            Whose::Mission => "a mission",
            Whose::Agent => "an agent",
            Whose::Robot => "a robot",
        }
    }
}

/// What a quantity is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A number.
    Number(Dimension),
    /// True or false.
    Truth,
    /// A point of the ground, in m; its third number is zero.
    Point,
}

/// A quantity.
#[derive(Debug)]
pub struct MissionQuantity {
    /// What stands behind the dot.
    pub name: &'static str,
    /// Whose it is.
    pub whose: Whose,
    /// What it is.
    pub form: Form,
    /// What it says, in Markdown. The unit stands in `form`.
    pub doc: &'static str,
    /// What is measured: one number, or two of a point. The index is that of the robot or the agent.
    measures: fn(usize) -> (MissionMeasure, Option<MissionMeasure>),
}

impl MissionQuantity {
    /// What is measured for the robot or agent of this index: one number, or two of a point.
    pub fn measures(&self, index: usize) -> (MissionMeasure, Option<MissionMeasure>) {
        (self.measures)(index)
    }
}

/// The quantity of this name.
pub fn find(whose: Whose, name: &str) -> Option<&'static MissionQuantity> {
    QUANTITIES.iter().find(|q| q.whose == whose && q.name == name)
}

/// What to write instead of a name that is no quantity of this.
pub fn instead(whose: Whose, name: &str) -> String {
    let names = || QUANTITIES.iter().filter(|q| q.whose == whose).map(|q| q.name);
    match suggest(name, names()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("there is {}", list(names(), 12)),
    }
}

const fn mission(name: &'static str, form: Form, doc: &'static str, of: Measure) -> MissionQuantity {
    MissionQuantity { name, whose: Whose::Mission, form, doc, measures: of }
}

const fn agent(name: &'static str, form: Form, doc: &'static str, of: Measure) -> MissionQuantity {
    MissionQuantity { name, whose: Whose::Agent, form, doc, measures: of }
}

const fn robot(name: &'static str, form: Form, doc: &'static str, of: Measure) -> MissionQuantity {
    MissionQuantity { name, whose: Whose::Robot, form, doc, measures: of }
}

type Measure = fn(usize) -> (MissionMeasure, Option<MissionMeasure>);

fn of_mission(of: OfMission) -> (MissionMeasure, Option<MissionMeasure>) {
    (MissionMeasure::Mission(of), None)
}

fn of_agent(index: usize, of: OfAgent) -> (MissionMeasure, Option<MissionMeasure>) {
    (MissionMeasure::Agent(index, of), None)
}

fn of_robot(index: usize, of: OfRobot) -> (MissionMeasure, Option<MissionMeasure>) {
    (MissionMeasure::Robot(index, of), None)
}

/// All of them.
pub static QUANTITIES: &[MissionQuantity] = &[
    mission(
        "done",
        Form::Truth,
        "Everything is served that can be, and every robot is back at its depot. `done` alone says the same.",
        |_| of_mission(OfMission::Done),
    ),
    mission("stranded", Form::Truth, "There is no plan any more: no robot is left, or none was found.", |_| {
        of_mission(OfMission::Stranded)
    }),
    mission("makespan", Form::Number(TIME), "From the start to the end of the last service so far.", |_| {
        of_mission(OfMission::Makespan)
    }),
    mission("cost", Form::Number(NONE), "What the plan costs, as it stands.", |_| of_mission(OfMission::Cost)),
    mission("energy", Form::Number(ENERGY), "The energy of all robots, for ways that have ended.", |_| {
        of_mission(OfMission::Energy)
    }),
    mission(
        "reschedules",
        Form::Number(NONE),
        "How often times of the plan moved, and who serves whom stayed.",
        |_| of_mission(OfMission::Reschedules),
    ),
    mission("reallocations", Form::Number(NONE), "How often what had not begun was planned anew.", |_| {
        of_mission(OfMission::Reallocations)
    }),
    agent("waited", Form::Number(TIME), "All its waits so far, the one under way with them.", |i| {
        of_agent(i, OfAgent::Waited)
    }),
    agent("served", Form::Number(NONE), "How many of its operations have been served.", |i| {
        of_agent(i, OfAgent::Served)
    }),
    agent("working", Form::Truth, "It is at work.", |i| of_agent(i, OfAgent::Working)),
    agent("lost", Form::Truth, "It has left.", |i| of_agent(i, OfAgent::Lost)),
    agent("position", Form::Point, "Where it works and is served.", |i| {
        (MissionMeasure::Agent(i, OfAgent::X), Some(MissionMeasure::Agent(i, OfAgent::Y)))
    }),
    agent(
        "adaptation",
        Form::Number(NONE),
        "How well its waits followed what it said of them: the adaptation index, 1 at the start, more where they did.",
        |i| of_agent(i, OfAgent::Adaptation),
    ),
    agent("speed_adaptation", Form::Number(NONE), "The same of the speeds of robots that came.", |i| {
        of_agent(i, OfAgent::SpeedAdaptation)
    }),
    agent(
        "wait_satisfaction",
        Form::Number(NONE),
        "What it says of its waits, smoothed: from -1, too short, to 1, too long; 0 before it said anything.",
        |i| of_agent(i, OfAgent::WaitSatisfaction),
    ),
    agent(
        "approach_satisfaction",
        Form::Number(NONE),
        "What it says of approaches, smoothed: from -1, very fast, to 1, very slow; 0 before it said anything.",
        |i| of_agent(i, OfAgent::ApproachSatisfaction),
    ),
    robot("position", Form::Point, "Where it is.", |i| {
        (MissionMeasure::Robot(i, OfRobot::X), Some(MissionMeasure::Robot(i, OfRobot::Y)))
    }),
    robot("speed", Form::Number(VELOCITY), "How fast it is; never negative.", |i| of_robot(i, OfRobot::Speed)),
    robot("travelled", Form::Number(LENGTH), "The way that it has gone, in ways that have ended.", |i| {
        of_robot(i, OfRobot::Travelled)
    }),
    robot("energy", Form::Number(ENERGY), "The energy that these ways took.", |i| of_robot(i, OfRobot::Energy)),
    robot("busy", Form::Truth, "It is under way, waits for an agent, serves, or unloads.", |i| {
        of_robot(i, OfRobot::Busy)
    }),
    robot("served", Form::Number(NONE), "How many operations it has served.", |i| of_robot(i, OfRobot::Served)),
    robot("lost", Form::Truth, "It has broken down.", |i| of_robot(i, OfRobot::Lost)),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_stands_once_and_says_what_it_is() {
        for (i, q) in QUANTITIES.iter().enumerate() {
            assert!(QUANTITIES[..i].iter().all(|o| (o.whose, o.name) != (q.whose, q.name)), "{}", q.name);
            assert!(q.doc.len() > 10 && q.doc.ends_with('.'), "{}", q.name);
            let (first, second) = q.measures(3);
            assert_eq!(second.is_some(), q.form == Form::Point, "{}", q.name);
            let fits = match (q.whose, first) {
                (Whose::Mission, MissionMeasure::Mission(_)) => true,
                (Whose::Agent, MissionMeasure::Agent(index, _)) => index == 3,
                (Whose::Robot, MissionMeasure::Robot(index, _)) => index == 3,
                _ => false,
            };
            assert!(fits, "{}", q.name);
        }
    }
}
