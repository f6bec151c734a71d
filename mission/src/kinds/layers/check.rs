//! Checks of a layered problem before planning: each mistake names the declaration, the reason and, for a
//! contradiction, the other declaration.
//!
//! A problem without mistakes has a plan: each open task gets an object of its own, and an agent for it.

use serde::{Deserialize, Serialize};

use crate::check::{self, entry, of};
use crate::numbers::{MAX_NUMBER, MIN_SPEED};

use super::feasible;
use super::problem::{Begun, Body, Problem, Task, Weights};
use super::reason::Reason;
use super::scales::Scales;

/// Maximum number of agents of a problem.
pub const MAX_AGENTS: usize = 32;
/// Maximum number of tasks.
pub const MAX_TASKS: usize = 256;
/// Maximum number of objects.
pub const MAX_OBJECTS: usize = 512;
/// Maximum number of positions on the path of a task, of features of an object or a task, and of skills of an agent.
pub const MAX_ENTRIES: usize = 64;

/// A declaration of the problem.
pub type Declaration = check::Declaration<Item, Key>;

/// A mistake in a problem.
pub type Mistake = check::Mistake<Item, Key, Reason>;

type Checker<'a> = check::Checker<'a, Problem, Item, Key, Reason>;

/// An entry of the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Item {
    /// The mission itself.
    Mission,
    /// The agent of this index.
    Agent(usize),
    /// The object of this index.
    Object(usize),
    /// The layer of this index.
    Layer(usize),
    /// The task of this index.
    Task(usize),
    /// The entry of this index in [`Problem::begun`].
    Begun(usize),
}

/// A key of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "each is named after the field of the problem that it is")]
pub enum Key {
    Place,
    Speed,
    Energy,
    Slowing,
    Skills,
    Reach,
    Payload,
    Cannot,
    Spread,
    Mass,
    Features,
    Layer,
    Action,
    Path,
    Object,
    Agent,
    Weights,
    Start,
}

impl Key {
    /// Returns the keys of the language that it was read from, the most specific first.
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Key::Place => &["place"],
            Key::Speed => &["speed"],
            Key::Energy => &["energy", "factor"],
            Key::Slowing => &["slowing"],
            Key::Skills => &["paces", "skills"],
            Key::Reach => &["reach"],
            Key::Payload => &["payload"],
            Key::Cannot => &["cannot"],
            Key::Spread => &["spread"],
            Key::Mass => &["mass"],
            Key::Features => &["features"],
            Key::Layer => &[],
            Key::Action => &[ACTION],
            Key::Path => &["via", "to"],
            Key::Object => &["object"],
            Key::Agent => &["agent"],
            Key::Weights => &["weights"],
            Key::Start => &[],
        }
    }
}

/// The action of a task, which is no key of its block.
pub(super) const ACTION: &str = "=";

impl Problem {
    /// Returns all mistakes of this problem, in the order of its fields; empty if the problem can be planned.
    pub fn check(&self) -> Vec<Mistake> {
        let mut checker = Checker::new(self);
        checker.mission();
        checker.agents();
        checker.objects();
        checker.tasks();
        if checker.mistakes.is_empty() {
            checker.begun();
        }
        if checker.mistakes.is_empty() {
            checker.mistakes = feasible::mistakes(self);
        }
        if checker.mistakes.is_empty() && Scales::of(self).makespan <= 0.0 {
            checker.refuse(entry(Item::Mission), Reason::NoTime);
        }
        checker.mistakes
    }
}

impl Checker<'_> {
    fn speed(&mut self, at: Declaration, value: f64) {
        self.at_least(at, value, MIN_SPEED);
    }

    fn few(&mut self, at: Declaration, count: usize, most: usize) {
        if count > most {
            self.refuse(at, Reason::TooMany { count, most });
        }
    }

    fn place(&mut self, at: Declaration, place: &[f64; 3]) {
        for coordinate in place {
            self.usual(at, *coordinate);
        }
    }

    fn mission(&mut self) {
        let problem = self.problem;
        let mission = entry(Item::Mission);
        let Weights { workload, energy, makespan } = problem.weights;
        for weight in [workload, energy, makespan] {
            self.not_negative(of(Item::Mission, Key::Weights), weight);
        }
        self.usual(of(Item::Mission, Key::Start), problem.start);
        if problem.agents.is_empty() {
            self.refuse(mission, Reason::NoAgent);
        }
        if problem.tasks.is_empty() {
            self.refuse(mission, Reason::NoTask);
        }
        self.few(mission, problem.agents.len(), MAX_AGENTS);
        self.few(mission, problem.objects.len(), MAX_OBJECTS);
        self.few(mission, problem.tasks.len(), MAX_TASKS);
        self.few(mission, problem.layers.len(), MAX_TASKS);
        for layer in 0..problem.layers.len().min(MAX_TASKS) {
            if !problem.tasks.is_empty() && problem.tasks.iter().all(|task| task.layer != layer) {
                self.refuse(entry(Item::Layer(layer)), Reason::EmptyLayer);
            }
        }
    }

    fn agents(&mut self) {
        for (index, agent) in self.problem.agents.iter().enumerate() {
            let item = Item::Agent(index);
            self.place(of(item, Key::Place), &agent.place);
            match agent.body {
                Body::Robot { speed, energy } => {
                    let before = self.mistakes.len();
                    self.speed(of(item, Key::Speed), speed.low);
                    self.speed(of(item, Key::Speed), speed.high);
                    if self.mistakes.len() == before && speed.high < speed.low {
                        self.refuse(of(item, Key::Speed), Reason::Reversed { low: speed.low, high: speed.high });
                    }
                    for coefficient in [energy.standby, energy.friction, energy.drag] {
                        self.not_negative(of(item, Key::Energy), coefficient);
                    }
                }
                Body::Human { speed, slowing } => {
                    self.speed(of(item, Key::Speed), speed);
                    self.not_negative(of(item, Key::Slowing), slowing);
                }
            }
            let at = of(item, Key::Skills);
            self.few(at, agent.skills.len(), MAX_ENTRIES);
            for (number, skill) in agent.skills.iter().enumerate() {
                if agent.skills[..number].iter().any(|other| other.action == skill.action) {
                    self.refuse(at, Reason::TwiceSkill { action: skill.action.clone() });
                }
                self.not_negative(at, skill.duration);
                if !(skill.pace > 0.0 && skill.pace <= 1.0) {
                    self.refuse(at, Reason::Pace { action: skill.action.clone(), value: skill.pace });
                }
            }
            for (key, value) in [(Key::Reach, agent.reach), (Key::Payload, agent.payload)] {
                if let Some(value) = value {
                    self.not_negative(of(item, key), value);
                }
            }
            self.few(of(item, Key::Cannot), agent.cannot.len(), MAX_ENTRIES);
            self.not_negative(of(item, Key::Spread), agent.spread);
        }
    }

    fn objects(&mut self) {
        for (index, object) in self.problem.objects.iter().enumerate() {
            let item = Item::Object(index);
            self.place(of(item, Key::Place), &object.place);
            self.not_negative(of(item, Key::Mass), object.mass);
            self.few(of(item, Key::Features), object.features.len(), MAX_ENTRIES);
        }
    }

    fn tasks(&mut self) {
        for (index, task) in self.problem.tasks.iter().enumerate() {
            let item = Item::Task(index);
            if task.layer >= self.problem.layers.len() {
                self.refuse(of(item, Key::Layer), Reason::Unknown { index: task.layer });
            }
            self.few(of(item, Key::Features), task.features.len(), MAX_ENTRIES);
            self.few(of(item, Key::Path), task.path.len(), MAX_ENTRIES);
            for place in &task.path {
                self.place(of(item, Key::Path), place);
            }
            for (key, index, count) in [
                (Key::Object, task.object, self.problem.objects.len()),
                (Key::Agent, task.agent, self.problem.agents.len()),
            ] {
                if let Some(index) = index.filter(|index| *index >= count) {
                    self.refuse(of(item, key), Reason::Unknown { index });
                }
            }
        }
    }

    fn begun(&mut self) {
        let problem = self.problem;
        for (index, begun) in problem.begun.iter().enumerate() {
            let at = entry(Item::Begun(index));
            if let Some(reason) = self.wrong_begun(begun) {
                self.refuse(at, reason);
                continue;
            }
            for (other, earlier) in problem.begun[..index].iter().enumerate() {
                let same = begun.object.is_some() && begun.object == earlier.object;
                let both = begun.start < earlier.end - 1e-6 && earlier.start < begun.end - 1e-6;
                let reason = match () {
                    () if begun.task == earlier.task => Reason::Twice,
                    () if same => Reason::SameObject,
                    () if begun.agent == earlier.agent && both => Reason::Overlap,
                    () => continue,
                };
                self.mistakes.push(Mistake { at, against: Some(entry(Item::Begun(other))), reason });
            }
        }
    }

    fn wrong_begun(&self, begun: &Begun) -> Option<Reason> {
        let problem = self.problem;
        let Some(task) = problem.tasks.get(begun.task) else { return Some(Reason::Unknown { index: begun.task }) };
        let Some(agent) = problem.agents.get(begun.agent) else { return Some(Reason::Unknown { index: begun.agent }) };
        if begun.object.is_some() != task.needs_object() {
            return Some(Reason::ObjectOfBegun);
        }
        if let Some(object) = begun.object.filter(|object| *object >= problem.objects.len()) {
            return Some(Reason::Unknown { index: object });
        }
        if agent.skill(&task.action).is_none() {
            return Some(Reason::NoSkill { agent: begun.agent, action: task.action.clone() });
        }
        let usual = |t: &f64| t.is_finite() && t.abs() <= MAX_NUMBER;
        if let Some(value) = [begun.start, begun.end, begun.speed].into_iter().find(|t| !usual(t)) {
            return Some(Reason::TooLarge { value });
        }
        if begun.speed < MIN_SPEED {
            return Some(Reason::TooSmall { value: begun.speed, least: MIN_SPEED });
        }
        if begun.end < begun.start {
            return Some(Reason::NotAscending);
        }
        if begun.start > problem.start {
            return Some(Reason::Later { begins: begun.start });
        }
        let before = |other: &&Task| other.layer < task.layer;
        let done = |other: usize| problem.begun_of(other).is_some_and(|b| b.end <= begun.start + 1e-6);
        let open = problem.tasks.iter().enumerate().find(|(index, other)| before(other) && !done(*index));
        open.map(|(index, _)| Reason::LayerBefore { task: index })
    }
}
