//! What can be expected of a mission, written once: what each quantity is called, whose it is, its unit and what it says.
//! Expectations, their diagnostics, the language server and the page of keys derive from it.

use names::{list, suggest};
use runtime::program::{MissionMeasure, OfAgent, OfLayers, OfMission, OfRobot, OfTeammate};
use stdlib_tasks::dimension::{Dimension, LENGTH, NONE, TIME, VELOCITY};

const ENERGY: Dimension = Dimension { m: 2, kg: 1, s: -2, rad: 0 };
const WORKLOAD: Dimension = Dimension { m: 0, kg: 1, s: 1, rad: 0 };

/// Whose a quantity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whose {
    /// Of a schedule, `vineyard.makespan`.
    Mission,
    /// Of a person or a working robot of a schedule, `h1.waited`.
    Agent,
    /// Of a robot that serves, `m1.travelled`.
    Robot,
    /// Of a mission of layers, `letter.layer`.
    Layers,
    /// Of a robot of layers, `left_arm.energy`.
    LayersRobot,
    /// Of a person of layers, `anna.workload`.
    LayersHuman,
}

impl Whose {
    /// What a person calls it, with its article.
    pub fn describe(self) -> &'static str {
        match self {
            Whose::Mission => "a schedule",
            Whose::Agent => "an agent of a schedule",
            Whose::Robot => "a robot of a schedule",
            Whose::Layers => "a mission of layers",
            Whose::LayersRobot => "a robot of layers",
            Whose::LayersHuman => "a human of layers",
        }
    }

    /// It is a mission, and nobody who has a place.
    pub fn is_mission(self) -> bool {
        matches!(self, Whose::Mission | Whose::Layers)
    }
}

/// What a quantity is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A number.
    Number(Dimension),
    /// True or false.
    Truth,
    /// A point in m. On the ground of a schedule its third number is zero.
    Point,
}

/// What is measured: one number, or two or three of a point.
pub type Measures = [Option<MissionMeasure>; 3];

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
    /// What is measured. The index is that of the robot or the agent.
    measures: fn(usize) -> Measures,
}

impl MissionQuantity {
    /// What is measured for the robot or agent of this index: one number, or two or three of a point.
    pub fn measures(&self, index: usize) -> Measures {
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

type Measure = fn(usize) -> Measures;

const fn of(whose: Whose, name: &'static str, form: Form, doc: &'static str, measures: Measure) -> MissionQuantity {
    MissionQuantity { name, whose, form, doc, measures }
}

const fn mission(name: &'static str, form: Form, doc: &'static str, measures: Measure) -> MissionQuantity {
    of(Whose::Mission, name, form, doc, measures)
}

const fn agent(name: &'static str, form: Form, doc: &'static str, measures: Measure) -> MissionQuantity {
    of(Whose::Agent, name, form, doc, measures)
}

const fn robot(name: &'static str, form: Form, doc: &'static str, measures: Measure) -> MissionQuantity {
    of(Whose::Robot, name, form, doc, measures)
}

const fn layers(name: &'static str, form: Form, doc: &'static str, measures: Measure) -> MissionQuantity {
    of(Whose::Layers, name, form, doc, measures)
}

const fn arm(name: &'static str, form: Form, doc: &'static str, measures: Measure) -> MissionQuantity {
    of(Whose::LayersRobot, name, form, doc, measures)
}

const fn person(name: &'static str, form: Form, doc: &'static str, measures: Measure) -> MissionQuantity {
    of(Whose::LayersHuman, name, form, doc, measures)
}

fn of_mission(of: OfMission) -> Measures {
    [Some(MissionMeasure::Mission(of)), None, None]
}

fn of_agent(index: usize, of: OfAgent) -> Measures {
    [Some(MissionMeasure::Agent(index, of)), None, None]
}

fn of_robot(index: usize, of: OfRobot) -> Measures {
    [Some(MissionMeasure::Robot(index, of)), None, None]
}

fn of_layers(of: OfLayers) -> Measures {
    [Some(MissionMeasure::Layers(of)), None, None]
}

fn of_teammate(index: usize, of: OfTeammate) -> Measures {
    [Some(MissionMeasure::Teammate(index, of)), None, None]
}

fn hand(index: usize) -> Measures {
    [OfTeammate::X, OfTeammate::Y, OfTeammate::Z].map(|axis| Some(MissionMeasure::Teammate(index, axis)))
}

const WORKING: &str = "It is at work.";
const LOST: &str = "It takes no part any more.";
const TASKS: &str = "How many tasks it has done.";
const WORKED: &str = "How long it was at work, the task under way with it.";
const HAND: &str = "Where it is: on its way from its base to the object, along the path and back, or at its base.";
const WAY: &str = "The way that it has gone, in tasks that have ended or were dropped.";

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
    agent("faulted", Form::Truth, "The controller that it runs has broken down, so that it is lost.", |i| {
        of_agent(i, OfAgent::Faulted)
    }),
    agent("position", Form::Point, "Where it works and is served.", |i| {
        [Some(MissionMeasure::Agent(i, OfAgent::X)), Some(MissionMeasure::Agent(i, OfAgent::Y)), None]
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
        [Some(MissionMeasure::Robot(i, OfRobot::X)), Some(MissionMeasure::Robot(i, OfRobot::Y)), None]
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
    layers("done", Form::Truth, "Every task is done. `done` alone says the same.", |_| of_layers(OfLayers::Done)),
    layers("stranded", Form::Truth, "There is no plan for everything any more: nobody is left for a task.", |_| {
        of_layers(OfLayers::Stranded)
    }),
    layers("makespan", Form::Number(TIME), "From the start to the end of the last task so far.", |_| {
        of_layers(OfLayers::Makespan)
    }),
    layers("cost", Form::Number(NONE), "What the plan costs, as it stands.", |_| of_layers(OfLayers::Cost)),
    layers(
        "energy",
        Form::Number(ENERGY),
        "The energy of all robots, in tasks that have ended or were dropped.",
        |_| of_layers(OfLayers::Energy),
    ),
    layers("workload", Form::Number(WORKLOAD), "The workload of all people.", |_| of_layers(OfLayers::Workload)),
    layers("layer", Form::Number(NONE), "How many layers are done.", |_| of_layers(OfLayers::Layer)),
    layers("tasks", Form::Number(NONE), "How many tasks are done.", |_| of_layers(OfLayers::Tasks)),
    layers("dropped", Form::Number(NONE), "How often a task failed, or was dropped by who was lost.", |_| {
        of_layers(OfLayers::Dropped)
    }),
    layers("reschedules", Form::Number(NONE), "How often times of the plan moved, and who does what stayed.", |_| {
        of_layers(OfLayers::Reschedules)
    }),
    layers("reallocations", Form::Number(NONE), "How often what had not begun was planned anew.", |_| {
        of_layers(OfLayers::Reallocations)
    }),
    arm("working", Form::Truth, WORKING, |i| of_teammate(i, OfTeammate::Working)),
    arm("lost", Form::Truth, LOST, |i| of_teammate(i, OfTeammate::Lost)),
    arm("tasks", Form::Number(NONE), TASKS, |i| of_teammate(i, OfTeammate::Tasks)),
    arm("worked", Form::Number(TIME), WORKED, |i| of_teammate(i, OfTeammate::Worked)),
    arm("position", Form::Point, HAND, hand),
    arm("travelled", Form::Number(LENGTH), WAY, |i| of_teammate(i, OfTeammate::Travelled)),
    arm("energy", Form::Number(ENERGY), "The energy that these ways took.", |i| of_teammate(i, OfTeammate::Energy)),
    person("working", Form::Truth, WORKING, |i| of_teammate(i, OfTeammate::Working)),
    person("lost", Form::Truth, LOST, |i| of_teammate(i, OfTeammate::Lost)),
    person("tasks", Form::Number(NONE), TASKS, |i| of_teammate(i, OfTeammate::Tasks)),
    person("worked", Form::Number(TIME), WORKED, |i| of_teammate(i, OfTeammate::Worked)),
    person("position", Form::Point, HAND, hand),
    person("travelled", Form::Number(LENGTH), WAY, |i| of_teammate(i, OfTeammate::Travelled)),
    person(
        "workload",
        Form::Number(WORKLOAD),
        "Its workload: of each task that has ended or was dropped the time, times the mass of the object.",
        |i| of_teammate(i, OfTeammate::Workload),
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_stands_once_and_says_what_it_is() {
        for (i, q) in QUANTITIES.iter().enumerate() {
            assert!(QUANTITIES[..i].iter().all(|o| (o.whose, o.name) != (q.whose, q.name)), "{}", q.name);
            assert!(q.doc.len() > 10 && q.doc.ends_with('.'), "{}", q.name);
            let measures = q.measures(3);
            assert_eq!(measures[1].is_some(), q.form == Form::Point, "{}", q.name);
            let fits = |measure: MissionMeasure| match (q.whose, measure) {
                (Whose::Mission, MissionMeasure::Mission(_)) | (Whose::Layers, MissionMeasure::Layers(_)) => true,
                (Whose::Agent, MissionMeasure::Agent(index, _)) => index == 3,
                (Whose::Robot, MissionMeasure::Robot(index, _)) => index == 3,
                (Whose::LayersRobot | Whose::LayersHuman, MissionMeasure::Teammate(index, _)) => index == 3,
                _ => false,
            };
            assert!(measures[0].is_some() && measures.into_iter().flatten().all(fits), "{}", q.name);
        }
    }
}
