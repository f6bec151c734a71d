//! Table of coverage: the limits that each stack keeps, on the joints that it moves and on links.

use std::collections::BTreeSet;

use robot::{JointKind, LinkId, Model};
use runtime::program::{LevelProgram, Program};
use stdlib_tasks::Task;
use stdlib_tasks::bound::{Bound, Slot};
use stdlib_tasks::protection::{Hazard, Protection};
use stdlib_tasks::task::RowKind;

use crate::analysis::stacks::Stacks;
use crate::checks::accelerations::{moved_dofs, movers};
use crate::checks::readings;
use crate::demands::JointQuantity;

/// Magnitude of a coefficient of a row up to which it is rounding: the joint is on an axis through the point.
const ROUNDING: f64 = 1e-9;

/// Firmness of a limit in a stack, from the weakest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Firmness {
    /// On a soft level that is not above all targets: it bounds only the freedom that they leave.
    Remaining,
    /// On a soft level above all targets, which may be violated.
    Soft,
    /// On a hard level.
    Hard,
}

impl Firmness {
    /// The firmness in a word or two.
    pub fn word(self) -> &'static str {
        match self {
            Firmness::Remaining => "below targets",
            Firmness::Soft => "soft",
            Firmness::Hard => "hard",
        }
    }
}

/// A limit in a stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Hold {
    /// Firmness.
    pub firmness: Firmness,
    /// Index of its level in the stack.
    pub level: usize,
    /// Index of its task in the program.
    pub task: usize,
}

/// Limits of a degree of freedom that a stack moves.
#[derive(Clone, Debug)]
pub struct JointCoverage {
    /// Index of the degree of freedom.
    pub dof: usize,
    /// The firmest limit of its velocity.
    pub velocity: Option<Hold>,
    /// The limit of its position: the weaker one of both sides.
    pub position: Option<Hold>,
    /// The firmest limit of its acceleration.
    pub acceleration: Option<Hold>,
    /// False for a joint that turns without end, and for the base: their positions need no limit.
    pub needs_position: bool,
}

impl JointCoverage {
    /// Returns the limit of a quantity.
    pub fn limit(&self, quantity: JointQuantity) -> Option<Hold> {
        match quantity {
            JointQuantity::Velocity => self.velocity,
            JointQuantity::Position => self.position,
            JointQuantity::Acceleration => self.acceleration,
        }
    }

    /// Returns false for a quantity that needs no limit.
    pub fn needs(&self, quantity: JointQuantity) -> bool {
        quantity != JointQuantity::Position || self.needs_position
    }
}

/// A point of a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PersonPoint {
    /// Index of the person.
    pub human: usize,
    /// Index of the signal of the point.
    pub signal: usize,
}

/// Hazard that links are kept from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum KeptFrom {
    /// A plane.
    Plane,
    /// Another link.
    Link(LinkId),
    /// Points of people.
    People(BTreeSet<PersonPoint>),
    /// An obstacle, by its index.
    Obstacle(usize),
    /// A place that no person moves.
    Place,
    /// Another bound of a value.
    Value,
}

/// Links that a limit guards.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Guard {
    /// The limit.
    pub hold: Hold,
    /// The links; empty for a bound of the whole robot.
    pub links: BTreeSet<LinkId>,
    /// Hazard that they are kept from.
    pub from: KeptFrom,
}

/// Coverage of a stack.
#[derive(Clone, Debug)]
pub struct StackCoverage {
    /// Index of the stack.
    pub stack: usize,
    /// Indices of the states in which it runs, innermost ones alone.
    pub states: Vec<usize>,
    /// True if a task of the stack moves the robot by itself.
    pub moves: bool,
    /// Degrees of freedom that targets of the stack move, or limits of distances and other values can move.
    pub joints: Vec<JointCoverage>,
    /// Links that its limits guard.
    pub guards: Vec<Guard>,
    /// All limits of the stack.
    pub limits: Vec<Hold>,
}

impl StackCoverage {
    /// Computes the coverage of a stack of a program without errors.
    pub fn of(program: &Program, index: usize) -> StackCoverage {
        StackCoverage::among(program, &Stacks::new(program), index)
    }

    /// The same, with stacks that may be built already.
    pub(super) fn among(program: &Program, stacks: &Stacks, index: usize) -> StackCoverage {
        let stack = &program.stacks[index];
        let members =
            || stack.levels.iter().enumerate().flat_map(|(k, l)| l.members.iter().map(move |m| (k, l, m.task)));
        let targets = members().filter(|(_, _, task)| row_kind(program, *task) == Some(RowKind::Equality));
        let first_target = targets.map(|(level, ..)| level).min().unwrap_or(usize::MAX);
        let (mut pushing, mut limits, mut guards) = (Vec::new(), Vec::new(), Vec::new());
        let mut holds = JointHolds::new(&program.robot.model);
        for ((level, l, task), built) in members().zip(stacks.tasks(index)) {
            let Ok(built) = &built.task else { continue };
            let hold = Hold { firmness: firmness(l, level, first_target, built.as_ref()), level, task };
            let is_target = row_kind(program, task) == Some(RowKind::Equality);
            if is_target || built.degrees_of_freedom().is_none() {
                pushing.push(task);
            }
            let protections = built.protections();
            if !is_target || !protections.is_empty() {
                limits.push(hold);
            }
            holds.add(program, built.as_ref(), hold);
            guards.extend(protections.into_iter().map(|p| guard(program, p, hold)));
        }
        guards.sort_unstable();
        guards.dedup();
        let moved = moved_dofs(program, stacks, index, &pushing, ROUNDING);
        let free = moved.into_iter().filter(|dof| !stack.locked.contains(dof));
        let joints: Vec<JointCoverage> = free.filter_map(|dof| holds.of(&program.robot.model, dof)).collect();
        let moves = !joints.is_empty() && !movers(program, stack).is_empty();
        StackCoverage { stack: index, states: states(program, index), moves, joints, guards, limits }
    }

    /// Computes the coverage of all stacks that a run or a scenario can enter.
    pub fn of_runs(program: &Program) -> Vec<StackCoverage> {
        let stacks = Stacks::new(program);
        program.entered_stacks().into_iter().map(|stack| StackCoverage::among(program, &stacks, stack)).collect()
    }

    /// Returns true if the stack moves a link in the world.
    pub fn moves_link(&self, model: &Model, link: LinkId) -> bool {
        model.support(link).iter().any(|s| self.moves_dof(s.dof))
    }

    /// Returns true if the stack moves two links against each other.
    pub fn moves_between(&self, model: &Model, [a, b]: [LinkId; 2]) -> bool {
        let (a, b) = (model.support(a), model.support(b));
        let own = |x: &[robot::Support], y: &[robot::Support]| {
            x.iter().any(|s| self.moves_dof(s.dof) && !y.iter().any(|other| other.column == s.column))
        };
        own(a, b) || own(b, a)
    }

    fn moves_dof(&self, dof: u32) -> bool {
        self.joints.iter().any(|j| j.dof == dof as usize)
    }
}

/// Innermost states in which a stack runs.
fn states(program: &Program, stack: usize) -> Vec<usize> {
    let Some(machine) = &program.machine else { return Vec::new() };
    let leaves = (0..machine.states.len()).filter(|&s| machine.states[s].initial.is_none());
    leaves.filter(|&s| machine.stacks_in(s).contains(&stack)).collect()
}

fn row_kind(program: &Program, task: usize) -> Option<RowKind> {
    stdlib_tasks::find(&program.tasks[task].kind).map(|kind| kind.row_kind)
}

fn firmness(l: &LevelProgram, level: usize, first_target: usize, task: &dyn Task) -> Firmness {
    match (task.gives_way(), l.hard) {
        (true, _) => Firmness::Soft,
        (false, true) => Firmness::Hard,
        (false, false) if level < first_target => Firmness::Soft,
        (false, false) => Firmness::Remaining,
    }
}

/// Links that a task protects, with the people whose positions it reads.
fn guard(program: &Program, protection: Protection, hold: Hold) -> Guard {
    let Protection { mut links, hazard } = protection;
    let points = |bounds: &[Bound]| -> BTreeSet<PersonPoint> {
        let numbers: BTreeSet<usize> = bounds.iter().flat_map(|b| readings::numbers(program, b)).collect();
        let humans = program.interface.humans.iter().enumerate();
        let all = humans.flat_map(|(human, h)| h.points.iter().map(move |&signal| PersonPoint { human, signal }));
        all.filter(|p| readings::position(&program.interface.signals[p.signal]).any(|n| numbers.contains(&n))).collect()
    };
    let of_slots = |slots: Vec<Slot>| points(&slots.into_iter().map(Bound::Value).collect::<Vec<_>>());
    let (people, otherwise) = match hazard {
        Hazard::Plane => (BTreeSet::new(), KeptFrom::Plane),
        Hazard::Link(other) => (BTreeSet::new(), KeptFrom::Link(other)),
        Hazard::Obstacle(name, position) => {
            let index = program.obstacles.iter().position(|o| o.name == name);
            (of_slots(vec![position]), index.map_or(KeptFrom::Place, KeptFrom::Obstacle))
        }
        Hazard::Points(slots) => (of_slots(slots), KeptFrom::Place),
        Hazard::Value(slots) => (of_slots(slots), KeptFrom::Value),
        Hazard::Field(field) => {
            links.extend(program.fields.get(field).into_iter().flat_map(|f| &f.links));
            (points(&[Bound::Field(field)]), KeptFrom::Place)
        }
    };
    let from = if people.is_empty() { otherwise } else { KeptFrom::People(people) };
    Guard { hold, links: links.into_iter().collect(), from }
}

/// The firmest limits of each degree of freedom.
struct JointHolds {
    velocity: Vec<Option<Hold>>,
    acceleration: Vec<Option<Hold>>,
    lower: Vec<Option<Hold>>,
    upper: Vec<Option<Hold>>,
}

impl JointHolds {
    fn new(model: &Model) -> JointHolds {
        let none = || vec![None; model.nv()];
        JointHolds { velocity: none(), acceleration: none(), lower: none(), upper: none() }
    }

    fn add(&mut self, program: &Program, task: &dyn Task, hold: Hold) {
        let firmer = |all: &mut [Option<Hold>], dof: usize| {
            if let Some(known) = all.get_mut(dof)
                && known.is_none_or(|k| k.firmness < hold.firmness)
            {
                *known = Some(hold);
            }
        };
        for (dof, _) in task.speed_limits(&program.values.initial) {
            firmer(&mut self.velocity, dof);
        }
        for (dof, _) in task.acceleration_limits() {
            firmer(&mut self.acceleration, dof);
        }
        for bounded in task.bounded_positions() {
            if bounded.lower {
                firmer(&mut self.lower, bounded.dof);
            }
            if bounded.upper {
                firmer(&mut self.upper, bounded.dof);
            }
        }
    }

    fn of(&self, model: &Model, dof: usize) -> Option<JointCoverage> {
        let joint = model.dofs.get(dof)?.joint;
        let needs_position = joint.is_some_and(|j| model.joint_ref(j).kind != JointKind::Continuous);
        let position = self.lower[dof].zip(self.upper[dof]);
        Some(JointCoverage {
            dof,
            velocity: self.velocity[dof],
            position: position.map(|(a, b)| if b.firmness < a.firmness { b } else { a }),
            acceleration: self.acceleration[dof],
            needs_position,
        })
    }
}
