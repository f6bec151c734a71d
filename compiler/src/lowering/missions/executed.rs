//! Who takes part in a mission that a scenario executes, by name, and what is measured of whom.

use mission::kinds::layers::problem::Problem as Layers;
use mission::kinds::schedule::problem::Problem as Schedule;
use runtime::program::{MissionKind, MissionMeasure, OfLayers, OfMission};

use crate::quantities::Whose;

/// What is executed.
#[derive(Clone, Copy)]
pub(super) enum Executed<'p> {
    /// Robots that serve agents.
    Schedule(&'p Schedule),
    /// A team that does layers of tasks.
    Layers(&'p Layers),
}

impl<'p> Executed<'p> {
    /// What a mission plans.
    pub fn of(kind: &'p MissionKind) -> Executed<'p> {
        match kind {
            MissionKind::Schedule(schedule) => Executed::Schedule(&schedule.problem),
            MissionKind::Layers(layers) => Executed::Layers(&layers.problem),
        }
    }

    /// The mission itself.
    pub fn whole(self) -> Whose {
        match self {
            Executed::Schedule(_) => Whose::Mission,
            Executed::Layers(_) => Whose::Layers,
        }
    }

    /// That everything is done.
    pub fn done(self) -> MissionMeasure {
        match self {
            Executed::Schedule(_) => MissionMeasure::Mission(OfMission::Done),
            Executed::Layers(_) => MissionMeasure::Layers(OfLayers::Done),
        }
    }

    /// Everybody, by name, each with an index of its own kind.
    pub fn members(self) -> Vec<(&'p str, Whose, usize)> {
        match self {
            Executed::Schedule(problem) => {
                let robots = problem.robots.iter().enumerate().map(|(i, m)| (m.name.as_str(), Whose::Robot, i));
                let agents = problem.agents.iter().enumerate().map(|(i, a)| (a.name.as_str(), Whose::Agent, i));
                robots.chain(agents).collect()
            }
            Executed::Layers(problem) => {
                let whose = |human: bool| if human { Whose::LayersHuman } else { Whose::LayersRobot };
                let agents = problem.agents.iter().enumerate();
                agents.map(|(i, who)| (who.name.as_str(), whose(who.is_human()), i)).collect()
            }
        }
    }

    /// Two names, for an example.
    pub fn example(self) -> (&'p str, &'p str) {
        let members = self.members();
        let name = |i: usize| members.get(i).map(|member| member.0);
        (name(0).unwrap_or("m1"), name(1).or(name(0)).unwrap_or("m2"))
    }
}
